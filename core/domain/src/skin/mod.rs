//! The domain that a mesh is of, so that it can be gone on with: its boundary as facets as wide as
//! they are flat, and all its other vertices as points.
//!
//! Where the mesh is one of ours the corners of these facets are on their lattice, and all other
//! vertices exactly on facets and segments, or inside: then nothing moves. Of other meshes each
//! boundary triangle is a facet, as in a file of a surface, and its corners move to the lattice.
//!
//! Cost: n log n; a look at all boundary triangles for each void.

mod delaunay;
mod facets;

use crate::check::contact::sides_of;
use crate::given::rounding_of;
use crate::prepare::Prepared;
use crate::triangulate;
use crate::vector::{cross, dot, minus};
use crate::{Domain, Facet, Lattice, PrepareError, PrepareOptions, Region};
use ltbw_core::TetMesh;
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, orient3d};
use std::collections::{HashMap, HashSet};

/// Why a mesh cannot be gone on with.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SkinError {
    /// There are no tetrahedra.
    #[error("the mesh has no tetrahedra")]
    Empty,
    /// A tetrahedron names a vertex that is not there, or one twice.
    #[error("tetrahedron {tet} names a vertex that is not there, or one twice")]
    Index {
        /// Its place in the list.
        tet: usize,
    },
    /// A tetrahedron has no volume.
    #[error("tetrahedron {tet} is flat; it has the corner {at:?}")]
    Flat {
        /// Its place in the list.
        tet: usize,
        /// One of its corners.
        at: Point,
    },
    /// A triangle has three tetrahedra, or two on one side.
    #[error("tetrahedra {} and {} overlap at a triangle at {at:?}", .tets[0], .tets[1])]
    Overlap {
        /// Two of them.
        tets: [usize; 2],
        /// A corner of the triangle.
        at: Point,
    },
    /// A vertex lies strictly inside the circumsphere of a tetrahedron.
    #[error(
        "the mesh is not Delaunay: vertex {vertex} at {at:?} is inside the circumsphere of \
         tetrahedron {tet} with the corner {corner:?}"
    )]
    NotDelaunay {
        /// The tetrahedron.
        tet: usize,
        /// One of its corners.
        corner: Point,
        /// The vertex.
        vertex: u32,
        /// Its place.
        at: Point,
    },
    /// The vertices have no mesh.
    #[error("the vertices of the mesh have no Delaunay mesh: {0}")]
    Vertices(String),
    /// The boundary makes no domain.
    #[error("the boundary of the mesh is no domain: {0}")]
    Boundary(#[from] PrepareError),
    /// The boundary bounds another volume than the tetrahedra fill.
    #[error(
        "the tetrahedra have a volume of {tets:?}, their boundary bounds one of {domain:?}: they \
         overlap, or the boundary touches itself"
    )]
    Volume {
        /// Of the tetrahedra.
        tets: f64,
        /// Of the domain.
        domain: f64,
    },
}

impl SkinError {
    /// A short code that stays the same between versions, for programs to match on.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            SkinError::Empty => "mesh.empty",
            SkinError::Index { .. } => "mesh.index",
            SkinError::Flat { .. } => "mesh.flat",
            SkinError::Overlap { .. } => "mesh.overlap",
            SkinError::NotDelaunay { .. } => "mesh.not-delaunay",
            SkinError::Vertices(_) => "mesh.vertices",
            SkinError::Boundary(error) => error.code(),
            SkinError::Volume { .. } => "mesh.volume",
        }
    }
}

/// A triangle of the boundary, or of a wall inside.
#[derive(Debug, Clone, Copy)]
struct Face {
    /// Counter-clockwise when seen from outside the first tetrahedron.
    corners: [u32; 3],
    marker: i32,
    /// Is there a tetrahedron on one side alone?
    is_outer: bool,
}

/// The domain of a mesh.
#[derive(Clone, Debug)]
pub struct PreparedSkin {
    /// The domain.
    pub ready: Prepared,
    /// The distance within which its facets are to be taken for coplanar.
    pub flat_tolerance: f64,
}

/// The number of no tetrahedron.
const NONE: u32 = u32::MAX;

/// The corners opposite each corner of a positive tetrahedron, seen from outside.
const OPPOSITE: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// A mesh and its boundary.
#[derive(Debug)]
pub struct Skin<'m> {
    points: &'m [Point],
    /// Positively oriented; those of the exterior are left out.
    tets: Vec<[u32; 4]>,
    /// Their places in the mesh's list.
    numbers: Vec<usize>,
    /// Of each tetrahedron, opposite each corner.
    neighbours: Vec<[u32; 4]>,
    faces: Vec<Face>,
    regions: Vec<Region>,
    volume: f64,
}

fn sorted([a, b, c]: [u32; 3]) -> [u32; 3] {
    let mut corners = [a, b, c];
    corners.sort_unstable();
    corners
}

/// Are the tetrahedra of a mesh with a tag, or else attribute, of 0 its exterior?
fn exterior(mesh: &TetMesh) -> Vec<bool> {
    let count = mesh.tets.len();
    let zero: Vec<bool> = match (&mesh.tet_tags, &mesh.tet_attributes) {
        (Some(tags), _) => tags.iter().map(|tag| *tag == 0).collect(),
        (None, Some(values)) => values.iter().map(|value| *value == 0.0).collect(),
        _ => Vec::new(),
    };
    let is_some = zero.len() == count && zero.contains(&false);
    if is_some { zero } else { vec![false; count] }
}

impl<'m> Skin<'m> {
    /// Finds the boundary: the triangles of one tetrahedron, those between different tags, and
    /// those that the mesh lists; of a list of all triangles, those with a marker other than 0.
    ///
    /// # Errors
    /// [`SkinError`]: no tetrahedra, or such as are no mesh.
    pub fn of(mesh: &'m TetMesh) -> Result<Self, SkinError> {
        let points = mesh.points.as_slice();
        let is_out = exterior(mesh);
        let (mut tets, mut numbers) = (Vec::new(), Vec::new());
        for (tet, (v, _)) in mesh.tets.iter().zip(&is_out).enumerate().filter(|(_, own)| !own.1) {
            let is_there = v.iter().all(|&v| (v as usize) < points.len());
            if !is_there || (0..4).any(|k| v[..k].contains(&v[k])) {
                return Err(SkinError::Index { tet });
            }
            let [a, b, c, d] = v.map(|v| &points[v as usize]);
            tets.push(match orient3d(a, b, c, d) {
                Sign::Positive => *v,
                Sign::Negative => [v[0], v[1], v[3], v[2]],
                Sign::Zero => return Err(SkinError::Flat { tet, at: *a }),
            });
            numbers.push(tet);
        }
        if tets.is_empty() {
            return Err(SkinError::Empty);
        }
        let mut skin = Self {
            points,
            neighbours: vec![[NONE; 4]; tets.len()],
            tets,
            numbers,
            faces: Vec::new(),
            regions: Vec::new(),
            volume: 0.0,
        };
        skin.volume = skin.tets.iter().map(|t| skin.volume_of(t)).sum();
        skin.find_faces(mesh)?;
        skin.find_regions(mesh);
        Ok(skin)
    }

    fn at(&self, v: u32) -> &'m Point {
        &self.points[v as usize]
    }

    fn volume_of(&self, t: &[u32; 4]) -> f64 {
        let [a, b, c, d] = t.map(|v| self.at(v));
        dot(&cross(&minus(b, a), &minus(c, a)), &minus(d, a)) / 6.0
    }

    fn find_faces(&mut self, mesh: &TetMesh) -> Result<(), SkinError> {
        let listed: HashMap<[u32; 3], i64> =
            mesh.faces.iter().map(|face| (sorted(face.corners), face.marker)).collect();
        let mut sides: Vec<([u32; 3], u32, u8)> = Vec::with_capacity(4 * self.tets.len());
        for (t, v) in (0..).zip(&self.tets) {
            let side = |k: usize| (sorted(OPPOSITE[k].map(|i| v[i])), t, k as u8);
            sides.extend((0..4).map(side));
        }
        sides.sort_unstable();
        // Some programs list every triangle there is (TetGen's option `-f`, its `.mesh` files).
        let is_listed = |own: &[([u32; 3], u32, u8)]| listed.contains_key(&own[0].0);
        let lists_all = sides.chunk_by(|one, other| one.0 == other.0).all(is_listed);
        let tag = |t: u32| mesh.tet_tags.as_ref()?.get(self.numbers[t as usize]).copied();
        for own in sides.chunk_by(|one, other| one.0 == other.0) {
            let (key, t, k) = own[0];
            let corners = OPPOSITE[usize::from(k)].map(|i| self.tets[t as usize][i]);
            let mut is_wall = true;
            if let Some(&(_, u, l)) = own.get(1) {
                let other = OPPOSITE[usize::from(l)].map(|i| self.tets[u as usize][i]);
                // On the two sides it turns both ways.
                if own.len() > 2 || (0..3).any(|r| [0, 1, 2].map(|i| other[(i + r) % 3]) == corners)
                {
                    let tets = [t, u].map(|t| self.numbers[t as usize]);
                    return Err(SkinError::Overlap { tets, at: *self.at(corners[0]) });
                }
                self.neighbours[t as usize][usize::from(k)] = u;
                self.neighbours[u as usize][usize::from(l)] = t;
                let is_told = |marker: &i64| *marker != 0 || !lists_all;
                is_wall = tag(t) != tag(u) || listed.get(&key).is_some_and(is_told);
            }
            if is_wall {
                let marker = listed.get(&key).copied().unwrap_or(0);
                let marker = i32::try_from(marker).unwrap_or(0);
                self.faces.push(Face { corners, marker, is_outer: own.len() == 1 });
            }
        }
        Ok(())
    }

    /// A seed for each set of tetrahedra between walls, by their tags; none where there is one set
    /// and no tag says anything.
    fn find_regions(&mut self, mesh: &TetMesh) {
        let walls: HashSet<[u32; 3]> = self.faces.iter().map(|face| sorted(face.corners)).collect();
        let mut seen = vec![false; self.tets.len()];
        let mut regions: Vec<(i64, Region)> = Vec::new();
        for first in 0..self.tets.len() {
            if std::mem::replace(&mut seen[first], true) {
                continue;
            }
            let (mut stack, mut best) = (vec![first as u32], (0.0, first));
            while let Some(t) = stack.pop() {
                let v = self.tets[t as usize];
                let volume = self.volume_of(&v);
                if volume > best.0 {
                    best = (volume, t as usize);
                }
                for (own, &other) in OPPOSITE.iter().zip(&self.neighbours[t as usize]) {
                    let is_open = other != NONE && !walls.contains(&sorted(own.map(|i| v[i])));
                    if is_open && !std::mem::replace(&mut seen[other as usize], true) {
                        stack.push(other);
                    }
                }
            }
            let corners = self.tets[best.1].map(|v| self.at(v));
            let seed = [0, 1, 2].map(|k| corners.iter().map(|p| p[k] / 4.0).sum());
            let number = self.numbers[first];
            let tag = mesh.tet_tags.as_ref().and_then(|tags| tags.get(number).copied());
            let own = mesh.tet_attributes.as_ref().and_then(|all| all.get(number).copied());
            let attribute = own.or(tag.map(|tag| tag as f64)).unwrap_or(0.0);
            regions.push((tag.unwrap_or(0), Region { seed, attribute, max_volume: None }));
        }
        regions.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.seed[0].total_cmp(&b.1.seed[0])));
        let says =
            regions.len() > 1 || regions.iter().any(|own| ![0.0, 1.0].contains(&own.1.attribute));
        self.regions = regions.into_iter().filter(|_| says).map(|own| own.1).collect();
    }

    /// The vertices of tetrahedra: those of the boundary, and those inside, ascending.
    fn vertices(&self) -> [Vec<u32>; 2] {
        let mut kind = vec![0_u8; self.points.len()];
        self.tets.iter().flatten().for_each(|&v| kind[v as usize] = 1);
        self.faces.iter().flat_map(|face| face.corners).for_each(|v| kind[v as usize] = 2);
        [2, 1].map(|own| (0..).zip(&kind).filter(|(_, k)| **k == own).map(|(v, _)| v).collect())
    }

    fn places(&self, vertices: &[u32]) -> Vec<Point> {
        vertices.iter().map(|&v| *self.at(v)).collect()
    }

    /// The domain of the mesh, ready to be meshed, its vertices being points of it.
    ///
    /// # Errors
    /// [`SkinError`]: a boundary that is no domain.
    pub fn prepare(&self, options: &PrepareOptions) -> Result<PreparedSkin, SkinError> {
        let options = PrepareOptions { oriented: false, ..*options };
        let wide = self.wide_facets();
        let is_on_lattice = |domain: &Domain| {
            let lattice = Lattice::of(domain).ok();
            let lattice = lattice.filter(|lattice| lattice.lost_bits() < 2);
            lattice.is_some_and(|own| domain.vertices.iter().all(|p| own.steps(p).is_some()))
        };
        let exact = wide.filter(is_on_lattice).and_then(|domain| domain.prepare(&options).ok());
        let (mut ready, flat_tolerance) = match exact {
            Some(ready) => (ready, 0.0),
            None => {
                let ready = self.triangles().prepare(&options)?;
                let rounding = rounding_of(&ready.domain);
                (ready, rounding)
            }
        };
        let domain = ready.report.volume().map_or(0.0, |volume| volume.to_f64());
        if (domain - self.volume).abs() > 1e-6 * self.volume {
            return Err(SkinError::Volume { tets: self.volume, domain });
        }
        self.give_inner(&mut ready);
        Ok(PreparedSkin { ready, flat_tolerance })
    }

    /// Gives a domain the boundary's vertices as points.
    pub fn give_outer(&self, domain: &mut Domain) {
        let [outer, _] = self.vertices();
        domain.points.extend(self.places(&outer));
    }

    /// Gives a domain that is ready to be meshed the vertices inside as points.
    pub fn give_inner(&self, ready: &mut Prepared) {
        let [_, inner] = self.vertices();
        let near = |v: &u32| ready.lattice.nearest_fine(self.at(*v));
        ready.domain.points.extend(inner.iter().map(near));
    }

    /// Each triangle of the boundary as a facet.
    fn triangles(&self) -> Domain {
        let [outer, _] = self.vertices();
        let mut number = vec![NONE; self.points.len()];
        (0..).zip(&outer).for_each(|(k, &v)| number[v as usize] = k);
        let facet =
            |face: &Face| Facet::polygon(&face.corners.map(|v| number[v as usize]), face.marker);
        Domain {
            vertices: self.places(&outer),
            facets: self.faces.iter().map(facet).collect(),
            ..self.seeds()
        }
    }

    /// A domain of seeds alone.
    fn seeds(&self) -> Domain {
        Domain { regions: self.regions.clone(), holes: self.voids(), ..Domain::default() }
    }

    /// A point in each void. A surface that bounds one has a negative volume.
    fn voids(&self) -> Vec<Point> {
        let outer: Vec<&Face> = self.faces.iter().filter(|face| face.is_outer).collect();
        let mut at_edge: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
        for (f, face) in outer.iter().enumerate() {
            for side in sides_of(face.corners) {
                at_edge.entry(triangulate::sorted(side)).or_default().push(f);
            }
        }
        let mut seen = vec![false; outer.len()];
        let mut holes = Vec::new();
        for first in 0..outer.len() {
            if std::mem::replace(&mut seen[first], true) {
                continue;
            }
            let origin = *self.at(outer[first].corners[0]);
            let (mut stack, mut volume, mut widest) = (vec![first], 0.0, (0.0, first));
            while let Some(f) = stack.pop() {
                let [a, b, c] = outer[f].corners.map(|v| minus(self.at(v), &origin));
                volume += dot(&a, &cross(&b, &c));
                let normal = cross(&minus(&b, &a), &minus(&c, &a));
                if dot(&normal, &normal) > widest.0 {
                    widest = (dot(&normal, &normal), f);
                }
                for side in sides_of(outer[f].corners) {
                    let own = &at_edge[&triangulate::sorted(side)];
                    if let [g, h] = own[..] {
                        let next = if g == f { h } else { g };
                        if !std::mem::replace(&mut seen[next], true) {
                            stack.push(next);
                        }
                    }
                }
            }
            if volume < 0.0 {
                holes.extend(self.beyond(&outer, widest.1));
            }
        }
        holes
    }

    /// A point half way from a triangle to what is opposite, outside.
    fn beyond(&self, outer: &[&Face], f: usize) -> Option<Point> {
        let [a, b, c] = outer[f].corners.map(|v| self.at(v));
        let from = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
        let way = cross(&minus(b, a), &minus(c, a));
        let hit = |(g, face): (usize, &&Face)| {
            let [a, b, c] = face.corners.map(|v| self.at(v));
            let (u, v, w) = (minus(b, a), minus(c, a), minus(&from, a));
            let n = cross(&u, &v);
            let part = -dot(&n, &w) / dot(&n, &way);
            let p = [0, 1, 2].map(|k| w[k] + part * way[k]);
            let s = dot(&cross(&p, &v), &n) / dot(&n, &n);
            let t = dot(&cross(&u, &p), &n) / dot(&n, &n);
            (g != f && part > 0.0 && s >= 0.0 && t >= 0.0 && s + t <= 1.0).then_some(part)
        };
        let nearest = outer.iter().enumerate().filter_map(hit).min_by(f64::total_cmp)?;
        Some([0, 1, 2].map(|k| from[k] + nearest / 2.0 * way[k]))
    }
}
