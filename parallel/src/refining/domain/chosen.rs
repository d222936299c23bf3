//! The insertion at once of points on which all is decided, mostly into cavities that the choice
//! has found.

use super::carriers::Carriers;
use super::values::DomainPoint;
use crate::mesh::{Again, LocalMesh, VertexName};
use crate::protocol::{Directory, Insert, Submesh};
use crate::refining::flags::Flags;
use ltbw_core::topology::{INFINITE, TetId, slot_of, tet_of};
use std::cell::RefCell;

/// The way in which a point was inserted at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AtOnce {
    No,
    /// By the kernel.
    Filled,
    /// By a patch.
    Patched,
}

/// The slots of a submesh.
#[derive(Debug, Default)]
pub(super) struct Slots {
    /// The regions of their tetrahedra, 0 of ghosts.
    pub(super) regions: Vec<u32>,
    /// The slots that were written in this round.
    written: Flags,
    /// The cavity that the choice has found for a point, by its name.
    found: RefCell<(VertexName, Vec<TetId>)>,
}

impl Slots {
    /// The region of a tetrahedron.
    pub(super) fn region(&self, t: TetId) -> u32 {
        self.regions.get(t.index()).copied().unwrap_or_default()
    }

    /// Notes the region of a tetrahedron that is new.
    pub(super) fn put(&mut self, t: TetId, region: u32) {
        if self.regions.len() <= t.index() {
            self.regions.resize(t.index() + 1, 0);
        }
        self.regions[t.index()] = region;
        self.written.set(t.index(), true);
    }

    /// A round begins: cavities are found from now on.
    pub(super) fn begin_round(&mut self) {
        self.written.clear();
        self.found.get_mut().1.clear();
    }

    /// Remembers the cavity found in this round for a point, which is inserted next.
    pub(super) fn remember(&self, name: VertexName, cavity: &[TetId]) {
        let (of, found) = &mut *self.found.borrow_mut();
        *of = name;
        found.clear();
        found.extend_from_slice(cavity);
    }
}

/// All that a submesh of a domain notes of its vertices and slots.
pub(super) struct Notes<'n> {
    pub(super) carriers: &'n mut Carriers,
    pub(super) slots: &'n mut Slots,
    /// Scratch: the regions of a star.
    pub(super) star: &'n mut Vec<u32>,
}

/// Inserts a point, if nothing is in its way: enters the carrier of its vertex, and the regions of
/// the new tetrahedra.
pub(super) fn insert_chosen(
    inner: &mut LocalMesh,
    notes: Notes<'_>,
    point: &DomainPoint,
    seed: TetId,
    directory: &Directory,
) -> Insert<TetId> {
    let Notes { carriers, slots, star } = notes;
    star.clear();
    let own = |t: TetId| slots.region(t);
    let changed = |t: TetId| slots.written.has(t.index());
    let known = slots.found.borrow();
    let is_known = known.0 == point.name() && !known.1.is_empty();
    let again = is_known.then_some(Again { found: &known.1[..], changed: &changed });
    let mut whole = None;
    let insert = inner.insert_seeing(&point.vertex, seed, again, directory, |topology, cavity| {
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
    drop(known);
    if insert == Insert::Done {
        for (k, &t) in inner.made_at_once().iter().enumerate() {
            // A ghost is in the exterior, as all ghosts of its cavity were.
            let region = whole.or_else(|| star.get(k).copied()).unwrap_or_default();
            let v = inner.tets().vertices(t);
            let is_ghost = region != 0 && v[3] == INFINITE;
            slots.put(t, if is_ghost { 0 } else { region });
        }
        if let Some(v) = inner.number(point.vertex.name) {
            carriers.set(v, point.carrier);
            for &t in inner.made_at_once().iter().filter(|_| !point.labels.is_empty()) {
                let corners = inner.tets().vertices(t);
                let mut wall = corners.into_iter().filter(|&own| own != v && own != INFINITE);
                if let (Some(a), Some(b), Some(c)) = (wall.next(), wall.next(), wall.next())
                    && let Some(label) = point.label(&[a, b, c].map(|v| inner.tets().point(v)))
                {
                    slots.put(t, label);
                }
            }
        }
    }
    insert
}
