//! Straight ways to proposed points, through one worker's tetrahedra.

use crate::protocol::Handle;
use crate::refining::domain::DomainMesh;
use crate::refining::news::{Bits, PartEnd, WireItem};
use ltbw_core::cavity::OTHERS;
use ltbw_core::topology::{TetId, VertexId, slot_of, tet_of};
use ltbw_exact::Point;
use ltbw_refine::{Across, BoundaryItem, Heading, Stop, View, Way, walk};

/// The end of a way.
pub(super) enum WayEnd {
    /// It ends in the tetrahedron that holds its point.
    At(TetId),
    /// It goes on elsewhere.
    Far(FarFace),
    /// It is not to be searched.
    Not(PartEnd),
}

/// A face beyond which a way goes on elsewhere.
#[derive(Clone, Copy, Debug)]
pub struct FarFace {
    /// The tetrahedron beyond.
    pub(super) at: Handle,
    /// The region on this side.
    pub(super) region: u32,
}

/// The place where a way begins, or goes on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) t: TetId,
    /// The slot of the face that it comes in by, and the region beyond.
    pub(super) by: Option<(usize, u32)>,
}

/// The place where a whole way begins, and whether its point may be inserted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Begin {
    pub(super) start: Bits,
    pub(super) may: bool,
}

impl View for DomainMesh<'_> {
    type Item = BoundaryItem;
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
    fn barrier(&self, t: TetId, v: [VertexId; 4], slot: usize) -> Option<BoundaryItem> {
        let is_bound = OTHERS[slot].into_iter().all(|k| self.is_bound(v[k]));
        if !is_bound {
            return None;
        }
        let corners = v.map(|v| self.corner(v));
        self.complex.side_of(&corners, slot, || labels_at(self, t, slot))
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
pub(super) fn labels_at(mesh: &DomainMesh<'_>, t: TetId, slot: usize) -> Option<[u32; 2]> {
    let beyond = tet_of(mesh.inner.tets().neighbours(t)[slot]);
    let is_here = mesh.inner.tets().far(beyond).is_none();
    is_here.then(|| [t, beyond].map(|t| mesh.region(t)))
}

/// Walks straight from `start` to `to`, from an entry on.
pub(super) fn walk_way(
    mesh: &mut DomainMesh<'_>,
    Entry { t, by }: Entry,
    start: &Bits,
    to: &Bits,
    may: bool,
) -> WayEnd {
    let way = Heading { from: start.map(f64::from_bits), to: to.map(f64::from_bits), may };
    // The worker before could not tell whether the face is of a patch.
    if let Some((slot, beyond)) = by
        && mesh.complex.has_patches()
    {
        let corners = mesh.inner.tets().vertices(t).map(|v| mesh.corner(v));
        let labels = [mesh.region(t), beyond];
        if let Some(item) = mesh.complex.side_of(&corners, slot, || Some(labels)) {
            return WayEnd::Not(PartEnd::Blocked(WireItem::new(&item)));
        }
    }
    let entry = by.map(|(slot, _)| slot);
    let (end, steps) = walk(mesh, Stop { t, entry }, &way);
    mesh.count_steps(steps as u64);
    match end {
        Way::Arrived(t) => match mesh.inner.tets().vertices(t).map(|v| mesh.point(v)) {
            corners if corners.contains(&way.to) => WayEnd::Not(PartEnd::Vertex),
            _ => WayEnd::At(t),
        },
        Way::Blocked(item) => WayEnd::Not(PartEnd::Blocked(WireItem::new(&item))),
        Way::Outside => WayEnd::Not(PartEnd::Outside),
        Way::Far(face) => WayEnd::Far(face),
    }
}
