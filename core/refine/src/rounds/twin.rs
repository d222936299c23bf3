//! The rules that keep points of one round apart, read off the mesh when it is decided: a twin of
//! the watch, for tests.

use super::{Candidate, Rounds};
use crate::complex::carrier::Carrier;
use crate::complex::measure::in_equatorial_ball;
use crate::mesh::item::Item;
use crate::mesh::marks::{EDGES, ENDS, FACES, edge_bit, face_bit};
use crate::mesh::state::FACE;
use crate::table::{edge, triangle};
use ltbw_core::topology::{INFINITE, TetId};

impl Rounds<'_, '_> {
    /// Does a candidate that fits wait for one before it, other than one in its own tetrahedron?
    pub(super) fn waits_by_the_mesh(&self, own: &Candidate) -> bool {
        let word = |t: TetId| self.own.state.marks.of(t);
        let cavity = self.choice.cavity_of(own);
        let boundary = self.reserved.of_boundary().end;
        let is_beside = |t: TetId| self.reserved.has_rival(t, boundary);
        let is_apart = |t: TetId| {
            let other = self.reserved.holder(t).filter(|&other| other < own.rank as usize);
            let other = other.map(|k| &self.choice.candidates[k]);
            other.is_some_and(|other| !other.place.carrier.is_with(own.place.carrier))
        };
        match own.item {
            Item::Tet(..) => {
                let is_marked = cavity.iter().any(|&t| word(t) & (FACES | EDGES) != 0);
                let beside = boundary > 0 && self.has_in_closure(own, is_beside);
                is_marked && (self.loses_jointly(own) || beside)
            }
            Item::Subface(s) => {
                let has = |t: &&TetId| s.iter().all(|c| self.own.state.vertices(**t).contains(c));
                let mut at = cavity.iter().filter(has);
                at.all(|&t| self.reserved.has_rival(t, own.rank))
                    || self.loses_jointly(own)
                    || self.has_in_closure(own, is_apart)
            }
            Item::Segment(_) => self.loses_jointly(own) || self.has_in_closure(own, is_apart),
        }
    }

    /// Has a candidate's closure a slot of this kind?
    fn has_in_closure(&self, own: &Candidate, is: impl Fn(TetId) -> bool) -> bool {
        let mut cavity = self.choice.cavity_of(own).iter();
        cavity.any(|&t| is(t) || self.neighbours(t).into_iter().any(&is))
    }

    /// Rules (b) and (c): does a candidate touch a face or edge that it could take out of the mesh
    /// together with one before it?
    fn loses_jointly(&self, own: &Candidate) -> bool {
        let cavity = self.choice.cavity_of(own);
        cavity.iter().any(|&t| self.loses_face(own, t) || self.loses_edge(own, t))
    }

    /// Rule (b): a face that is not safe, of which it has one tetrahedron and a rival the other.
    fn loses_face(&self, own: &Candidate, t: TetId) -> bool {
        let (state, word) = (&self.own.state, self.own.state.marks.of(t));
        let (v, beyond) = (state.vertices(t), self.neighbours(t));
        (0..4).filter(|&slot| word & face_bit(slot) != 0).any(|slot| {
            let [a, b, c] = FACE[slot].map(|k| v[k]);
            let is_lost = || match own.place.carrier {
                Carrier::Free => {
                    let is_other = |w: &u32| ![a, b, c].map(|v| v.number()).contains(w);
                    let all = [v, state.vertices(beyond[slot])].concat();
                    let [p, q, r] = [a, b, c].map(|v| state.at(v));
                    all.iter()
                        .filter(|w| is_other(&w.number()) && **w != INFINITE)
                        .any(|&apex| in_equatorial_ball(&p, &q, &r, &state.at(apex)))
                }
                carrier => {
                    let facet = state.subfaces.get(&triangle(a, b, c));
                    !facet.is_some_and(|&f| state.lies_on(carrier, f))
                }
            };
            self.reserved.has_rival(beyond[slot], own.rank) && is_lost()
        })
    }

    /// Rule (c): an edge of which a rival has a tetrahedron of its own closure.
    fn loses_edge(&self, own: &Candidate, t: TetId) -> bool {
        let (state, word) = (&self.own.state, self.own.state.marks.of(t));
        let (v, beyond) = (state.vertices(t), self.neighbours(t));
        ENDS.into_iter().filter(|&[i, j]| word & edge_bit(i, j) != 0).any(|[i, j]| {
            let mut beside = (0..4).filter(|&slot| slot != i && slot != j);
            let is_own = || match own.place.carrier {
                Carrier::Segment(s, _) => state.segments.get(&edge(v[i], v[j])) == Some(&s),
                _ => false,
            };
            let is_met = self.reserved.has_rival(t, own.rank)
                || beside.any(|slot| self.reserved.has_rival(beyond[slot], own.rank));
            is_met && !is_own()
        })
    }
}
