//! Joint kills: two points of a round, each of which takes no item out of the mesh, may do so
//! together. The rules that exclude it, as `docs/refinement.md` numbers them.

use super::{Candidate, Rounds};
use crate::refine::carrier::Carrier;
use crate::refine::item::Item;
use crate::refine::marks::{EDGES, ENDS, FACES, face_bit};
use crate::refine::measure::{in_diametral_ball, in_equatorial_ball};
use crate::refine::state::FACE;
use crate::refine::table::{edge, triangle};
use ltbw_core::topology::{INFINITE, TetId, VertexId, slot_of, tet_of};

impl Rounds<'_, '_> {
    /// The two tetrahedra at a subface that a candidate is to split.
    pub(super) fn tets_at(&self, own: &Candidate, s: [VertexId; 3]) -> Vec<TetId> {
        let cavity = &self.cavities[own.cavity.clone()];
        let has = |t: &&TetId| {
            let v = self.own.state.vertices(**t);
            s.iter().all(|c| v.contains(c))
        };
        cavity.iter().filter(has).copied().collect()
    }

    /// Rules (b) and (c): does a candidate touch a face or edge that it could take out of the
    /// mesh together with one before it?
    pub(super) fn loses_jointly(&self, own: &Candidate) -> bool {
        let cavity = &self.cavities[own.cavity.clone()];
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
            if !self.has_rival(tet_of(outer), own.rank) {
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

    /// Rule (c): an edge that is not safe, with a tetrahedron in the cavity of a rival.
    fn loses_edge(&self, own: &Candidate, t: TetId, word: u32) -> bool {
        let state = &self.own.state;
        let (carrier, v) = (own.place.carrier, state.vertices(t));
        ENDS.into_iter().enumerate().filter(|(bit, _)| word >> (4 + bit) & 1 == 1).any(
            |(_, [i, j])| {
                let ends = edge(v[i], v[j]);
                let of = state.segments.get(&ends).copied();
                if let Carrier::Segment(s, _) = carrier
                    && of == Some(s)
                {
                    return false;
                }
                let others = (0..4).filter(|&slot| slot != i && slot != j).map(|slot| v[slot]);
                let mut is_met = false;
                let has = |corner: u32| state.has_corner(Item::Segment(ends), corner);
                let related = |s: u32| state.angles.related_segment(carrier, s, &has).is_some();
                let mut is_safe =
                    !matches!(carrier, Carrier::Segment(..)) && of.is_some_and(|s| !related(s));
                let [a, b] = ends.map(|v| state.at(v));
                let mut look = |at: TetId, apex: VertexId| {
                    is_met |= self.has_rival(at, own.rank);
                    let inside = || apex != INFINITE && in_diametral_ball(&a, &b, &state.at(apex));
                    is_safe = is_safe && !inside();
                };
                let first: Vec<VertexId> = others.collect();
                look(t, first[1]);
                self.around(t, ends, first[0], &mut look);
                is_met && !is_safe
            },
        )
    }

    /// Calls `look` for each tetrahedron around an edge of `t` after `t` itself, with the vertex
    /// that it does not share with the one before; the first step leaves vertex `leave` behind.
    fn around(
        &self,
        t: TetId,
        ends: [VertexId; 2],
        leave: VertexId,
        look: &mut dyn FnMut(TetId, VertexId),
    ) {
        let topology = self.own.state.mesh.topology();
        let (mut at, mut leave) = (t, leave);
        // Around an edge the way comes back to its start; the bound only guards it.
        for _ in 0..topology.slots() {
            let tet = topology.at(at);
            let v = tet.vertices();
            let Some(slot) = v.iter().position(|&w| w == leave) else { return };
            let Some(&kept) = v.iter().find(|w| **w != leave && !ends.contains(w)) else { return };
            let face = tet.neighbours()[slot];
            at = tet_of(face);
            if at == t {
                return;
            }
            look(at, topology.at(at).vertices()[slot_of(face)]);
            leave = kept;
        }
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
