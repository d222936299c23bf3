//! Joint kills: two points of a round, each of which takes no item out of the mesh, may do so
//! together. The rules that exclude it, as `docs/rounds.md` numbers them.

use super::{Candidate, Rounds};
use crate::complex::carrier::Carrier;
use crate::complex::measure::in_equatorial_ball;
use crate::mesh::marks::{EDGES, ENDS, FACES, face_bit};
use crate::mesh::state::FACE;
use crate::table::{edge, triangle};
use ltbw_core::topology::{INFINITE, TetId, VertexId, slot_of, tet_of};

impl Rounds<'_, '_> {
    /// The two tetrahedra at a subface that a candidate is to split.
    pub(super) fn tets_at(&self, own: &Candidate, s: [VertexId; 3]) -> Vec<TetId> {
        let cavity = self.choice.cavity_of(own);
        let has = |t: &&TetId| {
            let v = self.own.state.vertices(**t);
            s.iter().all(|c| v.contains(c))
        };
        cavity.iter().filter(has).copied().collect()
    }

    /// Rules (b) and (c): does a candidate touch a face or edge that it could take out of the
    /// mesh together with one before it?
    pub(super) fn loses_jointly(&self, own: &Candidate) -> bool {
        let cavity = self.choice.cavity_of(own);
        cavity.iter().any(|&t| {
            let word = self.own.state.marks.of(t);
            word & FACES != 0 && self.loses_face(own, t, word)
                || word & EDGES != 0 && self.loses_edge(own, t, word)
        })
    }

    /// Rule (b): a face that is not safe, of which it has one tetrahedron and a rival the other.
    fn loses_face(&self, own: &Candidate, t: TetId, word: u32) -> bool {
        let (state, carrier) = (&self.own.state, own.place.carrier);
        let topology = state.mesh.topology();
        let tet = topology.at(t);
        (0..4).filter(|&slot| word & face_bit(slot) != 0).any(|slot| {
            let outer = tet.neighbours()[slot];
            if !self.reserved.has_rival(tet_of(outer), own.rank) {
                return false;
            }
            let [a, b, c] = FACE[slot].map(|i| tet.vertices()[i]);
            if carrier != Carrier::Free {
                let facet = state.subfaces.get(&triangle(a, b, c));
                return !facet.is_some_and(|&f| state.lies_on(carrier, f));
            }
            let beyond = topology.at(tet_of(outer)).vertices()[slot_of(outer)];
            let [a, b, c] = [a, b, c].map(|v| state.at(v));
            [tet.vertices()[slot], beyond]
                .into_iter()
                .any(|apex| apex != INFINITE && in_equatorial_ball(&a, &b, &c, &state.at(apex)))
        })
    }

    /// Rule (c): an edge of which a rival has a tetrahedron of its own closure.
    fn loses_edge(&self, own: &Candidate, t: TetId, word: u32) -> bool {
        let (state, carrier) = (&self.own.state, own.place.carrier);
        let topology = state.mesh.topology();
        let (v, n) = (topology.at(t).vertices(), topology.at(t).neighbours());
        ENDS.into_iter().enumerate().filter(|(bit, _)| word >> (4 + bit) & 1 == 1).any(
            |(_, [i, j])| {
                let mut beside = (0..4).filter(|&slot| slot != i && slot != j);
                let is_met = self.reserved.has_rival(t, own.rank)
                    || beside.any(|slot| self.reserved.has_rival(tet_of(n[slot]), own.rank));
                let is_own = || match carrier {
                    Carrier::Segment(s, _) => state.segments.get(&edge(v[i], v[j])) == Some(&s),
                    _ => false,
                };
                is_met && !is_own()
            },
        )
    }
}

/// Are two boundary points on one segment, or in one facet?
pub(super) fn is_same(a: Carrier, b: Carrier) -> bool {
    match (a, b) {
        (Carrier::Segment(s, _), Carrier::Segment(r, _)) => s == r,
        (Carrier::Facet(f), Carrier::Facet(g)) => f == g,
        _ => false,
    }
}
