//! A domain made ready for refinement: corners on the grid, segments, and facets as maximal groups
//! of coplanar polygons.
//!
//! An edge of polygons is a *segment*, except where two polygons of one facet with one marker meet
//! and nothing else does: there the facet simply continues.

use super::carrier::{Carrier, Cut, Grid, Line, Plane, corner_point};
use super::flat::{self, Polygon};
use super::patch::{Patch, Piece};
use crate::RefineError;
use crate::heed::Heed;
use crate::table::{Map, Set, edge};
use ltbw_core::build::Builder;
use ltbw_core::mesh::{Duplicate, Mesh};
use ltbw_domain::{Domain, Element, Lattice};
use ltbw_exact::{Point, PointSet};

/// A segment of the complex.
#[derive(Clone, Debug)]
pub(crate) struct Segment {
    /// Its corners.
    pub(crate) ends: [u32; 2],
    pub(crate) line: Line,
    /// The facets that it lies on, ascending.
    pub(crate) facets: Vec<u32>,
    /// The facets of these whose polygons are on both sides of it.
    pub(crate) twice: Vec<u32>,
}

/// A facet of the domain as part of one of the complex.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Its polygons.
    pub(crate) polygons: Vec<Vec<u32>>,
    /// Points in its holes, in fine steps.
    pub(crate) holes: Vec<Point>,
    pub(crate) marker: i32,
    /// The facet of the domain that it is, or is a piece of; of a patch the largest.
    pub(crate) facet: u32,
}

/// A maximal set of coplanar facets of the domain, or a patch: facets that are connected and
/// coplanar within the tolerance.
#[derive(Clone, Debug)]
pub(crate) struct Facet {
    /// The plane; of a patch that of its largest polygon.
    pub(crate) plane: Plane,
    pub(crate) parts: Vec<Part>,
    /// The geometry of a patch.
    pub(crate) patch: Option<Patch>,
    /// The corners on it, ascending.
    pub(crate) corners: Vec<u32>,
}

impl Facet {
    fn new(plane: Plane, patch: Option<Patch>) -> Self {
        Self { plane, parts: Vec::new(), patch, corners: Vec::new() }
    }
}

/// The complex.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plc {
    pub(crate) corners: Vec<Grid>,
    /// Points that are to be vertices, too, in fine steps, and where they live.
    pub(crate) points: Vec<(Point, Carrier)>,
    pub(crate) segments: Vec<Segment>,
    pub(crate) facets: Vec<Facet>,
    /// Per corner: the facets on which it lies, ascending.
    pub(crate) facets_at: Vec<Vec<u32>>,
    /// Per corner: the segments that end there.
    pub(crate) segments_at: Vec<Vec<u32>>,
    /// The number of times that a patch ends where it would fold over itself.
    pub(crate) folds: usize,
}

/// A plane as its primitive normal n and n·x.
type PlaneKey = ([i64; 3], i128);

/// The uses of an edge.
#[derive(Default)]
struct Uses {
    /// Facet and marker of each polygon along it.
    polygons: Vec<(u32, i32)>,
    /// It is a segment drawn on its own.
    drawn: bool,
    facets: Vec<u32>,
}

impl Plc {
    /// Are there facets within a tolerance?
    pub(crate) fn has_patches(&self) -> bool {
        self.facets.iter().any(|facet| facet.patch.is_some())
    }

    /// The number of vertices that the domain says.
    pub(crate) fn count(&self) -> usize {
        self.corners.len() + self.points.len()
    }

    /// The Delaunay mesh of the corners, points and cuts, numbered in this order. Where another one
    /// is at a cut nothing is cut.
    pub(crate) fn first_mesh(
        &self,
        cuts: &mut Vec<Cut>,
        lattice: &Lattice,
        heed: Heed<'_>,
    ) -> Result<Mesh, RefineError> {
        let cut = |cut: &Cut| self.segments[cut.segment as usize].line.point(cut.parameter);
        let own = self.corners.iter().map(corner_point).chain(self.points.iter().map(|p| p.0));
        let points: Vec<Point> = own.chain(cuts.iter().map(cut)).collect();
        let builder = heed.0.map_or(Builder::new(), |token| Builder::new().cancel(token));
        let mut mesh = builder.build(&PointSet::new(points)?)?.mesh;
        heed.ask()?;
        if let Some(&Duplicate { number: second, kept: first }) = mesh.duplicates().first() {
            if second.max(first) as usize >= self.count() {
                cuts.clear();
                return self.first_mesh(cuts, lattice, heed);
            }
            return Err(RefineError::DuplicateVertex { first, second });
        }
        mesh.scaled_by(ltbw_domain::lattice::PARAMETER_BITS - lattice.exponent());
        Ok(mesh)
    }

    /// Where the vertex of the first mesh lives that has this number.
    pub(crate) fn carrier_of(&self, number: u32, cuts: &[Cut]) -> Carrier {
        let point = (number as usize).checked_sub(self.corners.len());
        let cut = (number as usize).checked_sub(self.count());
        let cut = cut.and_then(|k| cuts.get(k)).map(|cut| cut.carrier());
        let point = point.and_then(|k| self.points.get(k)).map(|own| own.1);
        cut.or(point).unwrap_or(Carrier::Corner(number))
    }

    /// Does a vertex with this carrier lie on facet `f`?
    pub(crate) fn lies_on(&self, carrier: Carrier, f: u32) -> bool {
        match carrier {
            Carrier::Corner(c) => self.facets_at[c as usize].binary_search(&f).is_ok(),
            Carrier::Segment(s, _) => self.segments[s as usize].facets.contains(&f),
            Carrier::Facet(g) => f == g,
            Carrier::Free => false,
        }
    }

    /// Takes the complex from a domain whose vertices are on their lattice.
    ///
    /// # Errors
    /// Polygons that are degenerate or that are not planar and cannot be divided.
    #[cfg(test)]
    pub(crate) fn new(domain: &Domain, lattice: &Lattice) -> Result<Self, RefineError> {
        Self::within(domain, lattice, 0.0, &Set::default(), Heed::default())
    }

    /// Takes the complex; polygons that are coplanar within `tolerance` make one facet.
    ///
    /// # Errors
    /// Those of [`Plc::new`].
    pub(crate) fn within(
        domain: &Domain,
        lattice: &Lattice,
        tolerance: f64,
        without: &Set<u32>,
        heed: Heed<'_>,
    ) -> Result<Self, RefineError> {
        let mut plc = Self::default();
        for (v, p) in (0..).zip(&domain.vertices) {
            let steps = lattice.steps(p);
            plc.corners.push(steps.ok_or(RefineError::OffLattice { vertex: v, at: *p })?);
        }
        let mut groups: Map<PlaneKey, u32> = Map::default();
        let scale = |p: &Point| p.map(|c| c / lattice.fine_step());
        let in_patch = plc.join_patches(domain, tolerance / lattice.step(), without, heed)?;
        for (f, facet) in (0..).zip(&domain.facets).filter(|(f, _)| !in_patch.contains(f)) {
            heed.ask_at(f as usize)?;
            let holes: Vec<Point> = facet.holes.iter().map(scale).collect();
            for polygons in plc.planar_pieces(f, &facet.polygons)? {
                let (key, plane) = plc.plane_of(f, &polygons)?;
                let next = plc.facets.len() as u32;
                let group = *groups.entry(key).or_insert(next);
                if group == next {
                    plc.facets.push(Facet::new(plane, None));
                }
                let (holes, marker) = (holes.clone(), facet.marker);
                let part = Part { polygons, holes, marker, facet: f };
                plc.facets[group as usize].parts.push(part);
            }
        }
        plc.join_edges(domain.segments.iter().map(|drawn| drawn.0));
        plc.join_corners(&groups);
        plc.join_points(domain, lattice)?;
        Ok(plc)
    }

    /// Makes facets of the polygons that are coplanar within `tolerance` steps, and returns which
    /// facets of the domain are in these.
    fn join_patches(
        &mut self,
        domain: &Domain,
        tolerance: f64,
        without: &Set<u32>,
        heed: Heed<'_>,
    ) -> Result<Set<u32>, RefineError> {
        let mut taken = Set::default();
        if tolerance <= 0.0 {
            return Ok(taken);
        }
        let (groups, folds) = flat::patches(&self.corners, domain, tolerance, heed)?;
        self.folds = folds;
        for group in groups.into_iter().filter(|group| !without.contains(&group.polygons[0].facet))
        {
            let first = group.polygons[0].facet;
            let mut pieces = Vec::new();
            for Polygon { facet, corners, .. } in &group.polygons {
                let polygons = [corners.clone()];
                let plane = self.plane_of(*facet, &polygons)?.1;
                pieces.push(Piece { corners: corners.clone(), plane });
                taken.insert(*facet);
            }
            let Some(&Piece { plane, .. }) = pieces.first() else { continue };
            let marker = domain.facets[first as usize].marker;
            let polygons = group.polygons.into_iter().map(|p| p.corners).collect();
            let patch = Patch::new(&self.corners, first, group.axis, &pieces);
            let mut facet = Facet::new(plane, Some(patch));
            facet.parts.push(Part { polygons, holes: Vec::new(), marker, facet: first });
            self.facets.push(facet);
        }
        Ok(taken)
    }

    /// The polygons of a facet, if it is planar; else its triangles, one list each.
    fn planar_pieces(
        &self,
        facet: u32,
        polygons: &[Vec<u32>],
    ) -> Result<Vec<Vec<Vec<u32>>>, RefineError> {
        if polygons.is_empty() {
            return Ok(Vec::new());
        }
        let (n, d) = self.plane_of(facet, polygons)?.0;
        if polygons.iter().flatten().all(|&v| level(&n, &self.corners[v as usize]) == d) {
            return Ok(vec![polygons.to_vec()]);
        }
        let [polygon] = polygons else {
            return Err(RefineError::NotPlanar { element: Element::Facet(facet) });
        };
        let triangles = clip_ears(&self.corners, polygon, &n);
        let triangles =
            triangles.ok_or(RefineError::NotPlanar { element: Element::Facet(facet) })?;
        Ok(triangles.into_iter().map(|t| vec![t.to_vec()]).collect())
    }

    /// The plane through the first corners that span one, with a wide basis.
    fn plane_of(
        &self,
        facet: u32,
        polygons: &[Vec<u32>],
    ) -> Result<(PlaneKey, Plane), RefineError> {
        let degenerate = RefineError::Degenerate { element: Element::Facet(facet) };
        let at = |v: u32| self.corners[v as usize];
        let mut corners = polygons.iter().flatten().copied();
        let origin = at(corners.next().ok_or(degenerate.clone())?);
        let length = |v: &Grid| (0..3).map(|k| i128::from(v[k] - origin[k]).pow(2)).sum::<i128>();
        // The farthest corner, then the one that spans the widest triangle with it.
        let far = polygons.iter().flatten().map(|&v| at(v)).max_by_key(length);
        let far = far.ok_or(degenerate.clone())?;
        let area = |v: &Grid| -> i128 { normal(&origin, &far, v).iter().map(|c| c.abs()).sum() };
        let wide = polygons.iter().flatten().map(|&v| at(v)).max_by_key(area);
        let wide = wide.filter(|v| area(v) > 0).ok_or(degenerate)?;
        let n = primitive(normal(&origin, &far, &wide));
        Ok(((n, level(&n, &origin)), Plane::through(origin, far, wide)))
    }

    /// Finds the segments among the edges of all polygons, and those that are drawn.
    fn join_edges(&mut self, drawn: impl Iterator<Item = [u32; 2]>) {
        let mut uses: Map<[u32; 2], Uses> = Map::default();
        let mut order = Vec::new();
        let mut touch = |a: u32, b: u32, use_it: &mut dyn FnMut(&mut Uses)| {
            if a != b {
                let key = edge(a, b);
                use_it(uses.entry(key).or_insert_with(|| {
                    order.push(key);
                    Uses::default()
                }));
            }
        };
        for (f, facet) in (0..).zip(&self.facets) {
            for part in &facet.parts {
                for polygon in &part.polygons {
                    for (k, &a) in polygon.iter().enumerate() {
                        let b = polygon[(k + 1) % polygon.len()];
                        touch(a, b, &mut |uses| {
                            uses.facets.push(f);
                            match polygon.len() {
                                2 => uses.drawn = true,
                                _ => uses.polygons.push((f, part.marker)),
                            }
                        });
                    }
                }
            }
        }
        for [a, b] in drawn {
            touch(a, b, &mut |uses| uses.drawn = true);
        }
        for key in order {
            let Some(Uses { polygons, drawn, mut facets }) = uses.remove(&key) else { continue };
            let continues = matches!(polygons[..], [p, q] if p == q) && !drawn;
            facets.sort_unstable();
            facets.dedup();
            if !continues {
                let sides = |f: &&u32| polygons.iter().filter(|(g, _)| g == *f).count() > 1;
                let twice = facets.iter().filter(sides).copied().collect();
                let [from, to] = key.map(|v| self.corners[v as usize]);
                let line = Line { from, to };
                self.segments.push(Segment { ends: key, line, facets, twice });
            }
        }
    }

    /// Finds which facets and segments meet at each corner. A vertex that nothing names may lie on
    /// a facet nevertheless.
    fn join_corners(&mut self, groups: &Map<PlaneKey, u32>) {
        let mut facets_at = vec![Vec::new(); self.corners.len()];
        let mut used = vec![false; self.corners.len()];
        for (f, facet) in (0..).zip(&self.facets) {
            for &v in facet.parts.iter().flat_map(|p| p.polygons.iter().flatten()) {
                facets_at[v as usize].push(f);
                used[v as usize] = true;
            }
        }
        let mut planes: Vec<(&PlaneKey, u32)> = groups.iter().map(|(k, &f)| (k, f)).collect();
        planes.sort_unstable_by_key(|&(_, f)| f);
        for (v, at) in self.corners.iter().enumerate().filter(|&(v, _)| !used[v]) {
            let on = planes.iter().filter(|((n, d), _)| level(n, at) == *d);
            facets_at[v].extend(on.map(|&(_, f)| f));
        }
        self.segments_at = vec![Vec::new(); self.corners.len()];
        for (s, segment) in (0..).zip(&self.segments) {
            for v in segment.ends {
                self.segments_at[v as usize].push(s);
            }
        }
        for (v, facets) in (0..).zip(&mut facets_at) {
            facets.sort_unstable();
            facets.dedup();
            for &f in facets.iter() {
                self.facets[f as usize].corners.push(v);
            }
        }
        self.facets_at = facets_at;
    }
}

/// (a - o) × (b - o), exactly: differences of at most 2^27, so below 2^56.
fn normal(o: &Grid, a: &Grid, b: &Grid) -> [i128; 3] {
    let [u, v] = [a, b].map(|p| [0, 1, 2].map(|k| i128::from(p[k] - o[k])));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// n·x, below 2^84.
fn level(n: &[i64; 3], x: &Grid) -> i128 {
    (0..3).map(|k| i128::from(n[k]) * i128::from(x[k])).sum()
}

/// The normal without common divisors, its first entry that is not zero positive.
fn primitive(n: [i128; 3]) -> [i64; 3] {
    let gcd = |mut a: i128, mut b: i128| {
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a.abs()
    };
    let divisor = gcd(gcd(n[0], n[1]), n[2]).max(1);
    let sign = n.iter().find(|&&c| c != 0).map_or(1, |c| c.signum());
    // Entries of a normal are below 2^56.
    n.map(|c| (c / divisor * sign) as i64)
}

/// Divides a polygon that is not planar into triangles by clipping ears of its projection along
/// the normal's largest entry; `None` if no ear is left. Cubic in the number of corners at worst.
fn clip_ears(corners: &[Grid], polygon: &[u32], n: &[i64; 3]) -> Option<Vec<[u32; 3]>> {
    let drop = (0..3).max_by_key(|&k| n[k].abs())?;
    let (x, y) = ((drop + 1) % 3, (drop + 2) % 3);
    let turn = |a: u32, b: u32, c: u32| -> i128 {
        let [a, b, c] = [a, b, c].map(|v| &corners[v as usize]);
        let d = |p: &Grid, q: &Grid, k: usize| i128::from(p[k] - q[k]);
        d(b, a, x) * d(c, a, y) - d(b, a, y) * d(c, a, x)
    };
    let mut ring = polygon.to_vec();
    let area: i128 = (1..ring.len()).map(|k| turn(ring[0], ring[k - 1], ring[k])).sum();
    if area < 0 {
        ring.reverse();
    }
    let mut triangles = Vec::new();
    while ring.len() > 3 {
        let len = ring.len();
        let ear = (0..len).find(|&k| {
            let [a, b, c] = [ring[k], ring[(k + 1) % len], ring[(k + 2) % len]];
            let holds = |&v: &u32| {
                ![a, b, c].contains(&v)
                    && turn(a, b, v) >= 0
                    && turn(b, c, v) >= 0
                    && turn(c, a, v) >= 0
            };
            turn(a, b, c) > 0 && !ring.iter().any(holds)
        })?;
        triangles.push([ring[ear], ring[(ear + 1) % len], ring[(ear + 2) % len]]);
        ring.remove((ear + 1) % len);
    }
    triangles.push([*ring.first()?, *ring.get(1)?, *ring.get(2)?]);
    Some(triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bent_polygon_becomes_triangles_that_cover_it() {
        let corners = vec![[0, 0, 0], [4, 0, 1], [4, 4, 0], [2, 1, 0], [0, 4, 3]];
        let triangles = clip_ears(&corners, &[0, 1, 2, 3, 4], &[0, 0, 1]).expect("ears");
        assert_eq!(triangles.len(), 3);
        let area = |t: &[u32; 3]| normal_z(&corners, t);
        assert!(triangles.iter().all(|t| area(t) > 0));
        assert_eq!(triangles.iter().map(area).sum::<i128>(), 20);
    }

    fn normal_z(corners: &[Grid], t: &[u32; 3]) -> i128 {
        let [a, b, c] = t.map(|v| corners[v as usize]);
        normal(&a, &b, &c)[2]
    }

    #[test]
    fn normals_are_primitive() {
        assert_eq!(primitive([0, -6, 9]), [0, 2, -3]);
        assert_eq!(primitive([-4, 0, 0]), [1, 0, 0]);
    }
}
