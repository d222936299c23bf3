//! Dust on the inner side of its patch goes to the outer one.
//!
//! Dust is a tetrahedron with all four corners on one patch. Joint steps, and points where the rule
//! for dust did not serve, leave some on the inner side. Where two faces of it are subfaces of the
//! patch, and the two others would cover the same place with the inner side where it belongs, these
//! are the subfaces instead.

use crate::complex::carrier::{Carrier, Corner};
use crate::complex::plc::Plc;
use crate::mesh::item::Item;
use crate::mesh::marks::{FACES, face_bit};
use crate::mesh::state::{FACE, State};
use crate::mesh::tiles::is_above;
use crate::table::{edge, triangle};
use ltbw_core::topology::{TetId, slot_of, tet_of};
use std::cmp::Reverse;

impl State {
    /// Moves all dust to the outer sides.
    pub(crate) fn settle_all_dust(&mut self) {
        if self.plc.has_patches() {
            let has_two = |t: &TetId| (self.marks.of(*t) & FACES).count_ones() == 2;
            let all: Vec<TetId> = self.mesh.tet_ids().filter(has_two).collect();
            self.settle_dust(all);
        }
    }

    /// Moves dust among these tetrahedra, and what it uncovers, to the outer sides.
    pub(crate) fn settle_dust(&mut self, tets: impl IntoIterator<Item = TetId>) {
        let mut list: Vec<TetId> = tets.into_iter().collect();
        self.sort_last_first(&mut list);
        // No tetrahedron comes back from an outer side, so each moves once at most.
        while let Some(t) = list.pop() {
            if self.settle(t) {
                let mut next = self.mesh.topology().at(t).neighbours().map(tet_of).to_vec();
                self.sort_last_first(&mut next);
                list.append(&mut next);
            }
        }
    }

    /// Tetrahedra the last of which comes first by coordinates, where that decides.
    fn sort_last_first(&self, tets: &mut Vec<TetId>) {
        if self.by_place {
            tets.retain(|&t| self.mesh.tet(t).is_some());
            let place = |t: &TetId| Reverse(self.place_of(Item::Tet(*t, self.vertices(*t))));
            tets.sort_by_cached_key(place);
        }
    }

    /// Moves a tetrahedron to the outer side of a patch, if it is dust of it on the inner side.
    fn settle(&mut self, t: TetId) -> bool {
        let word = self.marks.of(t);
        if (word & FACES).count_ones() != 2 {
            return false;
        }
        let (v, neighbours) = (self.vertices(t), self.mesh.topology().at(t).neighbours());
        let face = |slot: usize| FACE[slot].map(|k| v[k]);
        let patch = |slot: usize| {
            let [a, b, c] = face(slot);
            let marked = word & face_bit(slot) != 0;
            if marked { self.subfaces.get(&triangle(a, b, c)).copied() } else { None }
        };
        let region = |t: TetId| self.marks.region(t);
        let flat = Flat {
            corners: self.cornered(v),
            region: region(t),
            facets: [0, 1, 2, 3].map(patch),
            beyond: neighbours.map(|face| region(tet_of(face))),
        };
        let is_segment = |[i, j]: [usize; 2]| self.segments.contains_key(&edge(v[i], v[j]));
        let Some((f, outer)) = self.plc.settled(&flat, is_segment) else { return false };
        for (slot, of) in flat.facets.into_iter().enumerate() {
            let [a, b, c] = face(slot);
            let across = neighbours[slot];
            let key = triangle(a, b, c);
            for (t, slot) in [(t, slot), (tet_of(across), slot_of(across))] {
                match of {
                    None => self.marks.set(t, face_bit(slot)),
                    Some(_) => self.marks.clear(t, face_bit(slot)),
                }
            }
            match of {
                None => self.add_subface(key, f),
                Some(_) => self.remove_subface(key),
            }
        }
        self.marks.set_region(t, outer);
        true
    }
}

/// A tetrahedron beside subfaces, by values.
pub(crate) struct Flat {
    pub(crate) corners: [Corner; 4],
    pub(crate) region: u32,
    /// Of which facet the face opposite each slot is a subface.
    pub(crate) facets: [Option<u32>; 4],
    /// The regions beyond the faces.
    pub(crate) beyond: [u32; 4],
}

impl Plc {
    /// The patch of which a tetrahedron is dust on the inner side, with the region on the outer one
    /// if it belongs there: two of its faces are subfaces of the patch, and the others can be.
    pub(crate) fn settled(
        &self,
        flat: &Flat,
        is_segment: impl Fn([usize; 2]) -> bool,
    ) -> Option<(u32, u32)> {
        let (old, new): (Vec<usize>, Vec<usize>) =
            (0..4).partition(|&slot| flat.facets[slot].is_some());
        let [i, j] = old[..] else { return None };
        let f = flat.facets[i].filter(|f| flat.facets[j] == Some(*f))?;
        let patch = self.facets[f as usize].patch.as_ref()?;
        let sides = patch.sides.filter(|sides| sides.inner == flat.region)?;
        let lies_on = |own: &Corner| self.lies_on(own.carrier, f);
        // The other two slots are the ends of the edge that both subfaces have.
        if !flat.corners.iter().all(lies_on) || is_segment([new[0], new[1]]) {
            return None;
        }
        let fits = |&slot: &usize| {
            let [a, b, c] = FACE[slot].map(|k| flat.corners[k].point);
            let turn = patch.turn([&a, &b, &c]);
            turn != 0 && is_above(slot, turn) != sides.upwards && flat.beyond[slot] == sides.inner
        };
        new.iter().all(fits).then_some((f, sides.outer))
    }

    /// Are all four corners of a tetrahedron, which live there, on one patch, and is a region that
    /// on the inner side of it?
    pub(crate) fn is_inner(&self, carriers: [Carrier; 4], region: u32) -> bool {
        let is_inner = |f: &&u32| {
            let sides = self.facets[**f as usize].patch.as_ref().and_then(|patch| patch.sides);
            sides.is_some_and(|sides| sides.inner == region)
        };
        let on = |f: &u32| carriers.iter().all(|&carrier| self.lies_on(carrier, *f));
        self.facets_of(&carriers[0]).iter().filter(is_inner).any(on)
    }
}
