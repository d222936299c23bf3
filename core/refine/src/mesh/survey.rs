//! Surveys: the boundary in the cavity of a point, and the items that the point encroaches.

use super::item::Item;
use ltbw_core::topology::VertexId;

/// A subface of a cavity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face<T> {
    pub(crate) key: [VertexId; 3],
    pub(crate) facet: u32,
    /// A tetrahedron of the cavity that has it, and the one beyond, if that is in the closure.
    pub(crate) sides: [Option<T>; 2],
    /// Both are in the cavity.
    pub(crate) is_inner: bool,
}

impl<T: Copy> Face<T> {
    /// The tetrahedra of the cavity that have it.
    pub(crate) fn inside(&self) -> impl Iterator<Item = T> {
        let [one, other] = self.sides;
        one.into_iter().chain(other.filter(|_| self.is_inner))
    }
}

/// A subsegment of a cavity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    pub(crate) key: [VertexId; 2],
    pub(crate) segment: u32,
    /// All tetrahedra around it are in the cavity.
    pub(crate) is_inner: bool,
}

/// The boundary in a cavity.
#[derive(Debug)]
pub(crate) struct Survey<T> {
    /// Its subfaces, in the order of the cavity.
    pub(crate) faces: Vec<Face<T>>,
    /// Its subsegments, by their keys.
    pub(crate) edges: Vec<Edge>,
    /// Subsegments, then subfaces, whose closed balls hold the point: those of the cavity, and
    /// pending ones.
    pub(crate) hit_segments: Vec<[VertexId; 2]>,
    pub(crate) hit_subfaces: Vec<[VertexId; 3]>,
}

impl<T> Default for Survey<T> {
    fn default() -> Self {
        let (faces, edges, hit_segments, hit_subfaces) = Default::default();
        Self { faces, edges, hit_segments, hit_subfaces }
    }
}

impl<T: Copy + Ord> Survey<T> {
    /// Is nothing of the boundary in the cavity?
    pub(crate) fn is_bare(&self) -> bool {
        self.faces.is_empty() && self.edges.is_empty()
    }

    /// The subfaces inside the cavity.
    pub(crate) fn inner(&self) -> impl Iterator<Item = &Face<T>> {
        self.faces.iter().filter(|face| face.is_inner)
    }

    /// The items that the point encroaches: the subsegments, or, if there are none, the subfaces.
    pub(crate) fn hits(&self) -> Vec<Item> {
        match self.hit_segments.is_empty() {
            true => self.hit_subfaces.iter().map(|&s| Item::Subface(s)).collect(),
            false => self.hit_segments.iter().map(|&s| Item::Segment(s)).collect(),
        }
    }
}
