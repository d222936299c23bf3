//! Straight ways to proposed points, through one worker's tetrahedra.

use super::mesh::DomainMesh;
use super::values::{ItemKey, subface_key};
use crate::protocol::Handle;
use ltbw_core::cavity::OTHERS;
use ltbw_core::topology::{TetId, VertexId, slot_of, tet_of};
use ltbw_exact::Point;
use ltbw_refine::{Across, BoundaryItem, Carrier, Heading, Stop, View, Walked, Way, middle, walk};

/// A face beyond which a way goes on elsewhere.
#[derive(Clone, Copy, Debug)]
pub struct FarFace {
    /// The tetrahedron beyond.
    pub(in super::super) at: Handle,
    /// The region on this side.
    pub(in super::super) region: u32,
}

/// A subface that bars a way.
#[derive(Clone, Copy, Debug)]
pub struct Side {
    pub(in super::super) item: BoundaryItem,
    /// The tetrahedron before it, and the slot opposite.
    t: TetId,
    slot: usize,
}

/// A subface that bars the way to the point of a tetrahedron.
#[derive(Clone, Copy, Debug)]
pub(super) struct Barrier {
    pub(super) key: ItemKey,
    /// Its facet.
    pub(super) of: u32,
    /// The tetrahedron before it.
    pub(super) tet: TetId,
}

impl View for DomainMesh<'_> {
    type Item = Side;
    type Far = FarFace;

    fn most_steps(&self) -> usize {
        self.inner.tets().topology().slots()
    }

    fn vertices(&self, t: TetId) -> [VertexId; 4] {
        self.inner.tets().vertices(t)
    }

    fn point(&self, v: VertexId) -> Point {
        DomainMesh::point(self, v)
    }

    /// At a far face the one beyond looks whether it is of a patch.
    fn barrier(&self, t: TetId, v: [VertexId; 4], slot: usize) -> Option<Side> {
        let is_bound = OTHERS[slot].into_iter().all(|k| self.is_bound(v[k]));
        if !is_bound {
            return None;
        }
        let corners = v.map(|v| self.corner(v));
        let item = self.complex.side_of(&corners, slot, || labels_at(self, t, slot))?;
        Some(Side { item, t, slot })
    }

    fn across(&self, t: TetId, slot: usize) -> Across<FarFace> {
        let next = self.inner.tets().neighbours(t)[slot];
        match self.inner.tets().far(tet_of(next)) {
            Some(at) => Across::Far(FarFace { at, region: self.region(t) }),
            None => Across::Here(Stop { t: tet_of(next), entry: Some(slot_of(next)) }),
        }
    }
}

/// The regions of a tetrahedron, and of the one beyond the face opposite a slot, if that is here.
pub(in super::super) fn labels_at(
    mesh: &DomainMesh<'_>,
    t: TetId,
    slot: usize,
) -> Option<[u32; 2]> {
    let beyond = tet_of(mesh.inner.tets().neighbours(t)[slot]);
    let is_here = mesh.inner.tets().far(beyond).is_none();
    is_here.then(|| [t, beyond].map(|t| mesh.region(t)))
}

impl DomainMesh<'_> {
    /// The subface that bars the way to the point of a tetrahedron, as far as that leads through
    /// this submesh: it goes first, and no cavity is opened, which may be half of the hull. None
    /// where limits may tell that it is not to be split.
    pub(super) fn barrier_before(&self, tet: TetId, to: Point, may: bool) -> Option<Barrier> {
        let corners = self.inner.tets().vertices(tet);
        let from = middle(corners.map(|v| self.point(v)));
        let heading = Heading { from, to, may };
        let Walked { end, steps } = walk(self, Stop { t: tet, entry: None }, &heading);
        self.count_way(steps as u64);
        let Way::Blocked(Side { item, t, slot }) = end else { return None };
        if self.complex.has_angles() {
            let own = corners.map(|v| self.carrier(v));
            let face = item.corners().iter().map(|corner| corner.carrier);
            let all: Vec<Carrier> = own.into_iter().chain(face).collect();
            if self.complex.are_related(&all) {
                return None;
            }
        }
        let v = self.inner.tets().vertices(t);
        let key = subface_key(OTHERS[slot].map(|k| self.inner.name(v[k])));
        Some(Barrier { key, of: item.of(), tet: t })
    }
}
