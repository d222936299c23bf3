//! Triangles of a facet, exactly.
//!
//! The facet is projected along the axis nearest to its normal; the edges of its polygons are
//! forced into the Delaunay triangulation of its vertices (`plane.rs`); what is outside them or
//! around a hole point falls away. In a plane the projection changes nothing; a facet that is not
//! planar becomes the piecewise linear surface over it, if its projection does not cross itself.
//!
//! Cost: triangles and convex quadrilaterals need a few orientation tests; n corners about
//! n log n time, at worst n². Hole points are looked up by the boxes of the triangles.

mod plane;

use crate::{Domain, Facet};
use ltbw_exact::Point;
use ltbw_exact::predicates::{PLANES, Sign, collinear, orient2d, orient3d};
use plane::Plane;

/// A defect of a facet by itself. Vertices are those of the domain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Problem {
    /// All corners are on a line.
    NoArea,
    /// A polygon names a vertex twice.
    RepeatedVertex {
        /// The polygon.
        polygon: u32,
        /// The vertex.
        vertex: u32,
    },
    /// Two vertices lie at the same place of the projection.
    SamePlace([u32; 2]),
    /// A vertex of the facet lies inside an edge that does not name it.
    VertexOnEdge {
        /// The vertex.
        vertex: u32,
        /// The edge.
        edge: [u32; 2],
    },
    /// Two edges cross.
    Crossing([u32; 2], [u32; 2]),
    /// A hole point is in no piece that the polygons enclose.
    HoleOutside(u32),
    /// A hole point is on an edge.
    HoleOnEdge(u32),
}

impl Problem {
    /// Whether the triangles are those of the facet in spite of it.
    fn is_harmless(self) -> bool {
        matches!(self, Problem::HoleOutside(_) | Problem::HoleOnEdge(_))
    }
}

/// The triangles of a facet.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Triangulated {
    /// Corners of the triangles, oriented as the first polygon of three corners or more.
    pub triangles: Vec<[u32; 3]>,
    /// Edges that border no triangle: parts of the facet that are segments only.
    pub loose: Vec<[u32; 2]>,
    /// Do all corners lie in one plane?
    pub planar: bool,
    /// The defects.
    pub problems: Vec<Problem>,
}

impl Triangulated {
    /// Are the triangles those of the facet?
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.problems.iter().all(|p| p.is_harmless())
    }
}

impl Domain {
    /// The triangles of a facet; `None` past the last facet.
    ///
    /// The domain has to have passed [`Domain::check_structure`].
    #[must_use]
    pub fn triangulate(&self, facet: u32) -> Option<Triangulated> {
        Some(self::facet(&self.vertices, self.facets.get(facet as usize)?))
    }

    /// Cuts facets that are not planar into triangles, each a facet of the same marker; returns for
    /// each facet the one that it was part of. Facets that are wrong by themselves stay.
    pub fn flatten(&mut self) -> Vec<u32> {
        let mut origin = Vec::with_capacity(self.facets.len());
        let mut flat = Vec::with_capacity(self.facets.len());
        for (number, facet) in (0..).zip(std::mem::take(&mut self.facets)) {
            let simple = facet.polygons.iter().map(Vec::len).sum::<usize>() <= 3;
            let cut = if simple { None } else { Some(self::facet(&self.vertices, &facet)) };
            match cut {
                Some(cut) if !cut.planar && cut.is_sound() => {
                    origin.extend(cut.triangles.iter().map(|_| number));
                    flat.extend(cut.triangles.iter().map(|t| Facet::polygon(t, facet.marker)));
                    let loose = cut.loose.iter().map(|&edge| (edge, facet.marker));
                    self.segments.extend(loose);
                }
                _ => {
                    origin.push(number);
                    flat.push(facet);
                }
            }
        }
        self.facets = flat;
        origin
    }
}

/// Triangulates a facet whose corners are indices of `points`.
pub fn facet(points: &[Point], facet: &Facet) -> Triangulated {
    if let ([polygon], []) = (facet.polygons.as_slice(), facet.holes.as_slice())
        && let Some(found) = quick(points, polygon)
    {
        return found;
    }
    let problems = repeated(facet);
    if !problems.is_empty() {
        return Triangulated { planar: true, problems, ..Triangulated::default() };
    }
    let mut vertices: Vec<u32> = facet.polygons.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let Some((corners, axes)) = frame(points, &vertices) else {
        let problems = vec![Problem::NoArea];
        let loose = facet.polygons.iter().flat_map(|p| edges(p)).collect();
        return Triangulated { loose, planar: true, problems, ..Triangulated::default() };
    };
    let [a, b, c] = corners.map(|v| &points[v as usize]);
    let planar = vertices.iter().all(|&v| orient3d(a, b, c, &points[v as usize]).is_zero());
    let mut places: Vec<Point> = vertices.iter().map(|&v| points[v as usize]).collect();
    if !planar {
        // Delaunay means the projection's circles then, and not those of distances in space.
        places.iter_mut().for_each(|p| p[3 - axes[0] - axes[1]] = 0.0);
    }
    Triangulated { planar, ..by_plane(points, facet, &vertices, places, axes) }
}

/// A triangle or a strictly convex quadrilateral, the commonest facets by far.
fn quick(points: &[Point], polygon: &[u32]) -> Option<Triangulated> {
    let at = |v: u32| &points[v as usize];
    let planar = match *polygon {
        [a, b, c] => {
            if collinear(at(a), at(b), at(c)) {
                return None;
            }
            return Some(Triangulated {
                triangles: vec![[a, b, c]],
                planar: true,
                ..Triangulated::default()
            });
        }
        [a, b, c, d] => orient3d(at(a), at(b), at(c), at(d)).is_zero(),
        _ => return None,
    };
    let &[a, b, c, d] = polygon else { return None };
    let turns = |axes| {
        let turn = |p, q, r| orient2d(at(p), at(q), at(r), axes);
        let first = turn(a, b, c);
        let same = [turn(b, c, d), turn(c, d, a), turn(d, a, b)].iter().all(|&t| t == first);
        !first.is_zero() && same
    };
    let convex = planar && PLANES.into_iter().any(turns);
    convex.then(|| Triangulated {
        triangles: vec![[a, b, c], [a, c, d]],
        planar,
        ..Triangulated::default()
    })
}

/// Polygons that name a vertex twice.
fn repeated(facet: &Facet) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (polygon, corners) in (0..).zip(&facet.polygons) {
        let mut sorted = corners.clone();
        sorted.sort_unstable();
        let twice = sorted.windows(2).filter(|w| w[0] == w[1]);
        problems.extend(twice.map(|w| Problem::RepeatedVertex { polygon, vertex: w[0] }));
    }
    problems.dedup();
    problems
}

/// The edges of a polygon; two corners have one.
pub(crate) fn edges(polygon: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    let count = if polygon.len() == 2 { 1 } else { polygon.len() };
    (0..count).map(|i| [polygon[i], polygon[(i + 1) % polygon.len()]])
}

/// An edge with its ends ascending: the same from either side.
pub(crate) fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Three vertices that are not collinear, and two axes to which they project likewise: those across
/// the largest component of the normal, as far as rounding tells. `None` if all are collinear.
fn frame(points: &[Point], vertices: &[u32]) -> Option<([u32; 3], [usize; 2])> {
    let at = |v: u32| &points[v as usize];
    let (&first, rest) = vertices.split_first()?;
    let minus = |p: &Point, q: &Point| [0, 1, 2].map(|k| p[k] - q[k]);
    let square = |p: &Point| p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    let normal = |b: u32, c: u32| {
        let (u, v) = (minus(at(b), at(first)), minus(at(c), at(first)));
        [0, 1, 2].map(|k: usize| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3])
    };
    let largest = |size: &dyn Fn(u32) -> f64| {
        rest.iter().copied().max_by(|&v, &w| size(v).total_cmp(&size(w)))
    };
    // The largest triangle at the first vertex, as far as rounding tells; else any triangle.
    let far = largest(&|v| square(&minus(at(v), at(first))))?;
    let wide = largest(&|v| square(&normal(far, v)))?;
    let triple = if collinear(at(first), at(far), at(wide)) {
        let other = rest.iter().copied().find(|&v| at(v) != at(first))?;
        let third = rest.iter().copied().find(|&v| !collinear(at(first), at(other), at(v)))?;
        [first, other, third]
    } else {
        [first, far, wide]
    };
    let size = normal(triple[1], triple[2]).map(f64::abs);
    let mut axes = PLANES;
    // The axis that is left out is 3 minus the sum of the others.
    axes.sort_by(|p, q| size[3 - q[0] - q[1]].total_cmp(&size[3 - p[0] - p[1]]));
    let [a, b, c] = triple.map(at);
    let axes = axes.into_iter().find(|&axes| !orient2d(a, b, c, axes).is_zero())?;
    Some((triple, axes))
}

/// The general case: `places` are those of the `vertices`, in one plane.
fn by_plane(
    points: &[Point],
    facet: &Facet,
    vertices: &[u32],
    places: Vec<Point>,
    axes: [usize; 2],
) -> Triangulated {
    let local = |v: u32| vertices.partition_point(|&w| w < v) as u32;
    let global = |v: u32| vertices[v as usize];
    let wrong = |problem: Problem| Triangulated {
        problems: vec![match problem {
            Problem::SamePlace([v, w]) => Problem::SamePlace([global(v), global(w)]),
            Problem::VertexOnEdge { vertex, edge } => {
                Problem::VertexOnEdge { vertex: global(vertex), edge: edge.map(global) }
            }
            Problem::Crossing(e, f) => Problem::Crossing(e.map(global), f.map(global)),
            other => other,
        }],
        ..Triangulated::default()
    };
    let mut plane = match Plane::new(places, axes) {
        Ok(plane) => plane,
        Err(problem) => return wrong(problem),
    };
    for edge in facet.polygons.iter().flat_map(|p| edges(p)) {
        if let Err(problem) = plane.force(edge.map(local)) {
            return wrong(problem);
        }
    }
    let mut found = Triangulated::default();
    plane.remove_outside();
    // All hole points are located before any of them removes anything.
    let mut seeds = Vec::new();
    let index = if facet.holes.is_empty() { plane::Index::new() } else { plane.index() };
    for (h, hole) in (0..).zip(&facet.holes) {
        match plane.locate(&index, hole) {
            plane::Place::Inside(t) => seeds.push(t),
            plane::Place::Outside => found.problems.push(Problem::HoleOutside(h)),
            plane::Place::OnEdge => found.problems.push(Problem::HoleOnEdge(h)),
        }
    }
    seeds.into_iter().for_each(|t| plane.remove_from(t));
    let flip = match facet.polygons.iter().find(|p| p.len() > 2) {
        Some(polygon) => turn(points, polygon, axes).is_negative(),
        None => false,
    };
    found.triangles = plane
        .kept()
        .map(|t| t.map(global))
        .map(|[a, b, c]| if flip { [a, c, b] } else { [a, b, c] })
        .collect();
    found.loose = plane.loose().map(|e| e.map(global)).collect();
    if found.triangles.is_empty() {
        found.problems.push(Problem::NoArea);
    }
    found
}

/// The orientation of a polygon that does not cross or touch itself: that of its extreme corner,
/// which is not on a line with the corners before and behind it.
fn turn(points: &[Point], polygon: &[u32], axes: [usize; 2]) -> Sign {
    let at = |i: usize| &points[polygon[i % polygon.len()] as usize];
    let key = |i: usize| (at(i)[axes[0]], at(i)[axes[1]]);
    let n = polygon.len();
    let least = (1..n).fold(0, |least, i| if key(i) < key(least) { i } else { least });
    orient2d(at(least + n - 1), at(least), at(least + 1), axes)
}
