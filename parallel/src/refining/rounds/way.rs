//! Straight ways to proposed points, from worker to worker.

use crate::refining::domain::{DomainMesh, FarFace};
use crate::refining::news::{Bits, PartEnd, WireItem};
use ltbw_core::topology::TetId;
use ltbw_refine::{Heading, Stop, Walked, Way, walk};

/// The end of a way.
pub(super) enum WayEnd {
    /// It ends in the tetrahedron that holds its point.
    At(TetId),
    /// It goes on elsewhere.
    Far(FarFace),
    /// It is not to be searched.
    Not(PartEnd),
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
    let Walked { end, steps } = walk(mesh, Stop { t, entry }, &way);
    mesh.count_steps(steps as u64);
    match end {
        Way::Arrived(t) => match mesh.inner.tets().vertices(t).map(|v| mesh.point(v)) {
            corners if corners.contains(&way.to) => WayEnd::Not(PartEnd::Vertex),
            _ => WayEnd::At(t),
        },
        Way::Blocked(side) => WayEnd::Not(PartEnd::Blocked(WireItem::new(&side.item))),
        Way::Outside => WayEnd::Not(PartEnd::Outside),
        Way::Far(face) => WayEnd::Far(face),
    }
}
