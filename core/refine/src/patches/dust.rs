//! Dust on the inner side of its patch goes to the outer one.
//!
//! Dust is a tetrahedron with all four corners on one patch. Joint steps, and points where the rule
//! for dust did not serve, leave some on the inner side. Where two faces of it are subfaces of the
//! patch, and the two others would cover the same place with the inner side where it belongs, these
//! are the subfaces instead.

use crate::mesh::item::Item;
use crate::mesh::marks::{FACES, face_bit};
use crate::mesh::state::{FACE, State};
use crate::mesh::tiles::is_above;
use crate::table::{edge, triangle};
use ltbw_core::topology::{TetId, VertexId, slot_of, tet_of};
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
        if (0..4).filter(|&slot| word & face_bit(slot) != 0).count() != 2 {
            return false;
        }
        let v = self.vertices(t);
        let mut old = Vec::new();
        let mut new = Vec::new();
        for (slot, face) in FACE.into_iter().enumerate() {
            let [a, b, c] = face.map(|k| v[k]);
            match word & face_bit(slot) {
                0 => new.push((slot, [a, b, c])),
                _ => old.push((slot, [a, b, c])),
            }
        }
        let [(i, first), (j, second)] = old[..] else { return false };
        let patch_of = |[a, b, c]: [VertexId; 3]| self.subfaces.get(&triangle(a, b, c)).copied();
        let Some(f) = patch_of(first).filter(|f| patch_of(second) == Some(*f)) else {
            return false;
        };
        let Some(patch) = &self.plc.facets[f as usize].patch else { return false };
        let Some(sides) = patch.sides.filter(|sides| sides.inner == self.marks.region(t)) else {
            return false;
        };
        let rest: Vec<VertexId> = (0..4).filter(|&k| k != i && k != j).map(|k| v[k]).collect();
        if !v.iter().all(|&v| self.lies_on(self.carriers[v.index()], f))
            || self.segments.contains_key(&edge(rest[0], rest[1]))
        {
            return false;
        }
        let neighbours = self.mesh.topology().at(t).neighbours();
        let fits = |&(slot, corners): &(usize, [VertexId; 3])| {
            let [a, b, c] = corners.map(|v| self.at(v));
            let turn = patch.turn([&a, &b, &c]);
            let other = self.marks.region(tet_of(neighbours[slot]));
            turn != 0 && is_above(slot, turn) != sides.upwards && other == sides.inner
        };
        if !new.iter().all(fits) {
            return false;
        }
        for ((slot, [a, b, c]), is_new) in
            old.into_iter().map(|o| (o, false)).chain(new.into_iter().map(|n| (n, true)))
        {
            let across = neighbours[slot];
            let key = triangle(a, b, c);
            for (t, slot) in [(t, slot), (tet_of(across), slot_of(across))] {
                match is_new {
                    true => self.marks.set(t, face_bit(slot)),
                    false => self.marks.clear(t, face_bit(slot)),
                }
            }
            match is_new {
                true => self.add_subface(key, f),
                false => self.remove_subface(key),
            }
        }
        self.marks.set_region(t, sides.outer);
        true
    }
}
