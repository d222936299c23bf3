//! Closures as a survey reads them.

use super::choice::{Closure, Corner};
use crate::mesh::state::FACE;
use crate::table::{Map, triangle};

/// A closure as a survey reads it.
#[doc(hidden)]
pub trait Surveyed {
    /// A tetrahedron of it.
    type Tet: Copy + Ord;

    /// The tetrahedra in conflict with the point.
    fn cavity(&self) -> impl Iterator<Item = Self::Tet>;

    /// Is a tetrahedron in conflict with the point?
    fn is_in(&self, t: Self::Tet) -> bool;

    /// The vertices of a tetrahedron, positively oriented. The one at infinity, and one that is not
    /// told, is [`NOWHERE`](crate::NOWHERE).
    fn vertices(&self, t: Self::Tet) -> [u32; 4];

    /// Which vertices of a tetrahedron are on the boundary? [`NOWHERE`](crate::NOWHERE) is not.
    fn bound(&self, t: Self::Tet) -> [bool; 4];

    /// A vertex, which is not [`NOWHERE`](crate::NOWHERE).
    fn corner(&self, v: u32) -> Corner;

    /// The region of a tetrahedron; it need not be told where there are no patches.
    fn region(&self, t: Self::Tet) -> u32;

    /// The tetrahedron beyond face `slot` of one in conflict, if that is in the closure, too. It
    /// need not be told where fewer than two corners of the face are on the boundary, unless there
    /// are patches.
    fn beyond(&self, t: Self::Tet, slot: usize) -> Option<Self::Tet>;
}

/// A closure of which only values are known, with the tetrahedra at each face that matters. A
/// tetrahedron is its place there.
#[doc(hidden)]
#[derive(Debug)]
pub struct Collected<'c> {
    closure: &'c Closure,
    at_face: Map<[u32; 3], [Option<usize>; 2]>,
}

impl<'c> Collected<'c> {
    /// Looks at all faces of a closure.
    pub fn of(closure: &'c Closure) -> Self {
        let mut own = Self { closure, at_face: Map::default() };
        for (k, (tet, _)) in closure.tets.iter().enumerate() {
            let bound = own.bound(k);
            // A face that is marked, or has a marked edge, has two corners on the boundary. Where
            // there are patches all walls count.
            let has_labels = !closure.regions.is_empty();
            let is_on = |face: &[usize; 3]| {
                has_labels || face.iter().filter(|&&slot| bound[slot]).count() > 1
            };
            if own.at_face.is_empty() && FACE.iter().any(is_on) {
                own.at_face.reserve(closure.tets.len());
            }
            for face in FACE.into_iter().filter(is_on) {
                let entry = own.at_face.entry(sorted_face(face.map(|slot| tet[slot]))).or_default();
                entry[usize::from(entry[0].is_some())] = Some(k);
            }
        }
        own
    }
}

impl Surveyed for Collected<'_> {
    type Tet = usize;

    fn cavity(&self) -> impl Iterator<Item = usize> {
        (0..self.closure.tets.len()).filter(|&k| self.is_in(k))
    }

    fn is_in(&self, t: usize) -> bool {
        self.closure.tets[t].1
    }

    fn vertices(&self, t: usize) -> [u32; 4] {
        self.closure.tets[t].0
    }

    fn bound(&self, t: usize) -> [bool; 4] {
        self.closure.bound(t)
    }

    fn corner(&self, v: u32) -> Corner {
        self.closure.corners[v as usize]
    }

    fn region(&self, t: usize) -> u32 {
        self.closure.regions.get(t).copied().unwrap_or_default()
    }

    fn beyond(&self, t: usize, slot: usize) -> Option<usize> {
        let tet = self.vertices(t);
        let at = self.at_face.get(&sorted_face(FACE[slot].map(|slot| tet[slot])))?;
        at.iter().flatten().copied().find(|other| *other != t)
    }
}

/// The key of a face with these corners.
fn sorted_face([a, b, c]: [u32; 3]) -> [u32; 3] {
    triangle(a, b, c)
}
