//! Straight ways to proposed points, through one worker's tetrahedra.

use super::serve::corner;
use crate::protocol::Handle;
use crate::refining::domain::DomainMesh;
use crate::refining::news::{Bits, PartEnd, WireItem};
use ltbw_core::cavity::OTHERS;
use ltbw_core::topology::{TetId, VertexId, slot_of, tet_of};
use ltbw_exact::Point;
use ltbw_refine::{Across, BoundaryItem, Carrier, Heading, Stop, View, Way, walk};

/// The end of a way.
pub(super) enum WayEnd {
    /// It ends in the tetrahedron that holds its point.
    At(TetId),
    /// It goes on elsewhere.
    Far(Handle),
    /// It is not to be searched.
    Not(PartEnd),
}

impl View for DomainMesh<'_> {
    type Item = BoundaryItem;
    type Far = Handle;

    fn most_steps(&self) -> usize {
        self.inner.tets().topology().slots()
    }

    fn vertices(&self, t: TetId) -> [VertexId; 4] {
        self.inner.tets().vertices(t)
    }

    fn point(&self, v: VertexId) -> Point {
        DomainMesh::point(self, v)
    }

    fn barrier(&self, _: TetId, v: [VertexId; 4], slot: usize) -> Option<BoundaryItem> {
        let face = OTHERS[slot].map(|k| corner(self, v[k]));
        let is_bound = face.iter().all(|corner| corner.carrier != Carrier::Free);
        if is_bound { self.complex.item_at(face) } else { None }
    }

    fn across(&self, t: TetId, slot: usize) -> Across<Handle> {
        let next = self.inner.tets().neighbours(t)[slot];
        match self.inner.tets().far(tet_of(next)) {
            Some(handle) => Across::Far(handle),
            None => Across::Here(Stop { t: tet_of(next), entry: Some(slot_of(next)) }),
        }
    }
}

/// Walks straight from `start` to `to`, from face `entry` of tetrahedron `t` on.
pub(super) fn walk_way(
    mesh: &mut DomainMesh<'_>,
    (t, entry): (TetId, Option<usize>),
    start: &Bits,
    to: &Bits,
    may: bool,
) -> WayEnd {
    let way = Heading { from: start.map(f64::from_bits), to: to.map(f64::from_bits), may };
    let (end, steps) = walk(mesh, Stop { t, entry }, &way);
    mesh.count_steps(steps as u64);
    match end {
        Way::Arrived(t) => match mesh.inner.tets().vertices(t).map(|v| mesh.point(v)) {
            corners if corners.contains(&way.to) => WayEnd::Not(PartEnd::Vertex),
            _ => WayEnd::At(t),
        },
        Way::Blocked(item) => WayEnd::Not(PartEnd::Blocked(WireItem::new(&item))),
        Way::Outside => WayEnd::Not(PartEnd::Outside),
        Way::Far(handle) => WayEnd::Far(handle),
    }
}
