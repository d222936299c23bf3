//! The insertion at once of points on which all is decided.

use super::values::DomainPoint;
use crate::mesh::LocalMesh;
use crate::protocol::{Directory, Insert, Submesh};
use ltbw_core::topology::{INFINITE, TetId, slot_of, tet_of};
use ltbw_domain::refine::Carrier;

/// The way in which a point was inserted at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AtOnce {
    No,
    /// By the kernel.
    Filled,
    /// By a patch.
    Patched,
}

/// Puts a value at a place of a list that may be too short.
pub(super) fn put<T: Clone>(list: &mut Vec<T>, place: usize, value: T, rest: T) {
    if list.len() <= place {
        list.resize(place + 1, rest);
    }
    list[place] = value;
}

/// Inserts a point, if nothing is in its way: enters the carrier of its vertex, and the regions of
/// the new tetrahedra. `star` is scratch.
pub(super) fn insert_chosen(
    inner: &mut LocalMesh,
    (carriers, regions, star): (&mut Vec<Carrier>, &mut Vec<u32>, &mut Vec<u32>),
    (point, seed): (&DomainPoint, TetId),
    directory: &Directory,
) -> Insert<TetId> {
    star.clear();
    let own = |t: TetId| regions.get(t.index()).copied().unwrap_or_default();
    let mut whole = None;
    let insert = inner.insert_seeing(&point.vertex, seed, directory, |topology, cavity| {
        let first = own(seed);
        if cavity.tets().all(|t| own(t) == first) {
            whole = Some(first);
            return;
        }
        // Each new tetrahedron is in the region of the one that was behind its outer face.
        let inside = cavity
            .boundary()
            .map(|(_, outer)| tet_of(topology.at(tet_of(outer)).neighbours()[slot_of(outer)]));
        star.extend(inside.map(own));
    });
    if insert == Insert::Done {
        for (k, &t) in inner.made_at_once().iter().enumerate() {
            // A ghost is in the exterior, as all ghosts of its cavity were.
            let region = whole.or_else(|| star.get(k).copied()).unwrap_or_default();
            let is_ghost = region != 0 && inner.tets().vertices(t)[3] == INFINITE;
            put(regions, t.index(), if is_ghost { 0 } else { region }, 0);
        }
        if let Some(v) = inner.number(point.vertex.name) {
            put(carriers, v.index(), point.carrier, Carrier::Free);
        }
    }
    insert
}
