//! Straight ways to proposed points, through one worker's tetrahedra.

use super::serve::corner;
use crate::protocol::Handle;
use crate::refining::domain::DomainMesh;
use crate::refining::news::{Bits, PartEnd, WireItem};
use ltbw_core::cavity::OTHERS;
use ltbw_core::topology::{INFINITE, TetId, slot_of, tet_of};
use ltbw_refine::{Carrier, way_out};

/// The end of a way.
pub(super) enum WayEnd {
    /// It ends in the tetrahedron that holds its point.
    At(TetId),
    /// It goes on elsewhere.
    Far(Handle),
    /// It is not to be searched.
    Not(PartEnd),
}

/// Walks straight from `start` to `to`, from face `entry` of tetrahedron `t` on.
pub(super) fn walk_way(
    mesh: &mut DomainMesh<'_>,
    (mut t, mut entry): (TetId, Option<usize>),
    start: &Bits,
    to: &Bits,
    may: bool,
) -> WayEnd {
    let (from, p) = (start.map(f64::from_bits), to.map(f64::from_bits));
    let slots = mesh.inner.tets().topology().slots();
    // In a Delaunay mesh such a walk visits no tetrahedron twice; the bound only guards it.
    for step in 0..=slots {
        let tets = mesh.inner.tets();
        let v = tets.vertices(t);
        if v[3] == INFINITE {
            mesh.count_steps(step as u64);
            return WayEnd::Not(PartEnd::Outside);
        }
        let corners = v.map(|v| mesh.point(v));
        let Some(slot) = way_out(corners, entry, &from, &p) else {
            mesh.count_steps(step as u64);
            return match corners.contains(&p) {
                _ if !may => WayEnd::Not(PartEnd::Outside),
                true => WayEnd::Not(PartEnd::Vertex),
                false => WayEnd::At(t),
            };
        };
        let face = OTHERS[slot].map(|k| corner(mesh, v[k]));
        if face.iter().all(|corner| corner.carrier != Carrier::Free)
            && let Some(item) = mesh.complex.item_at(face)
        {
            mesh.count_steps(step as u64);
            return WayEnd::Not(PartEnd::Blocked(WireItem::new(&item)));
        }
        let next = mesh.inner.tets().neighbours(t)[slot];
        if let Some(handle) = mesh.inner.tets().far(tet_of(next)) {
            mesh.count_steps(step as u64);
            return WayEnd::Far(handle);
        }
        (t, entry) = (tet_of(next), Some(slot_of(next)));
    }
    WayEnd::Not(PartEnd::Outside)
}
