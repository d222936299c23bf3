//! The look at a cavity, which makes its survey.
//!
//! One pass over the tetrahedra of the cavity finds all, without a list of its walls. Those at an
//! edge of the cavity's boundary are one arc, since the point sees all of the boundary: the first
//! one reports the edge. An edge inside is reported by the smallest tetrahedron around it.

use super::bounded::{Bounded, InMesh};
use crate::complex::carrier::Carrier;
use crate::complex::measure::{in_diametral_ball, in_equatorial_ball};
use crate::mesh::item::Item;
use crate::mesh::marks::{EDGES, ENDS, FACES, Word, face_bit};
use crate::mesh::state::{FACE, Place, State};
use crate::mesh::survey::{Edge, Face, Survey};
use crate::table::{Set, edge, triangle};
use ltbw_core::topology::VertexId;
use ltbw_exact::Point;

/// The other two slots at each edge of [`ENDS`], in such an order that with the edge before them
/// they are positively oriented.
const ACROSS: [[usize; 2]; 6] = [[2, 3], [3, 1], [1, 2], [0, 3], [2, 0], [0, 1]];

impl State {
    /// Looks at the boundary in the open cavity of a place.
    pub(crate) fn look(&mut self, place: &Place) {
        let mut survey = std::mem::take(&mut self.survey);
        survey.look(&InMesh::open(self), &place.p, place.carrier);
        self.survey = survey;
    }
}

impl<T: Copy + Ord> Survey<T> {
    /// Finds the boundary in the cavity of `p`, which lives on `carrier`, and what `p` encroaches.
    pub(crate) fn look<B: Bounded<Tet = T>>(&mut self, closure: &B, p: &Point, carrier: Carrier) {
        self.faces.clear();
        self.edges.clear();
        self.hit_segments.clear();
        self.hit_subfaces.clear();
        for t in closure.cavity() {
            let word = closure.marks(t);
            if word & EDGES != 0 {
                self.note_edges(closure, t, word);
            }
            if word & FACES != 0 {
                self.note_faces(closure, t, word);
            }
        }
        self.edges.sort_unstable_by_key(|edge| edge.key);
        debug_assert!(
            closure.state().is_none() || self.edges.is_sorted_by(|a, b| a.key < b.key),
            "of each edge one tetrahedron reports"
        );
        self.hit(closure, p, carrier);
    }

    /// Takes the marked edges of a tetrahedron of the cavity that it has to report.
    fn note_edges<B: Bounded<Tet = T>>(&mut self, closure: &B, t: T, word: Word) {
        let v = closure.vertices(t);
        for (k, [i, j]) in ENDS.into_iter().enumerate() {
            if word >> (4 + k) & 1 == 0 {
                continue;
            }
            let key = edge(v[i], v[j]);
            let [mut before, mut after] = ACROSS[k];
            if key[0] != v[i] {
                (before, after) = (after, before);
            }
            let inside = |slot: usize| closure.beyond(t, slot).filter(|&t| closure.is_in(t));
            let is_inner = match inside(before) {
                None => false,
                Some(before) => match inside(after) {
                    Some(after) if is_smallest_around(closure, t, key, [before, after]) => true,
                    _ => continue,
                },
            };
            if let Some(segment) = closure.segment(key) {
                self.edges.push(Edge { key, segment, is_inner });
            }
        }
    }

    /// Takes the marked faces of a tetrahedron of the cavity.
    fn note_faces<B: Bounded<Tet = T>>(&mut self, closure: &B, t: T, word: Word) {
        let v = closure.vertices(t);
        for slot in (0..4).filter(|&slot| word & face_bit(slot) != 0) {
            let beyond = closure.beyond(t, slot);
            let is_inner = beyond.is_some_and(|other| closure.is_in(other));
            // An inner face is met from both sides.
            if is_inner && beyond < Some(t) {
                continue;
            }
            let [a, b, c] = FACE[slot].map(|k| v[k]);
            let key = triangle(a, b, c);
            let Some(facet) = closure.facet_at(t, slot) else { continue };
            self.faces.push(Face { key, facet, sides: [Some(t), beyond], is_inner });
        }
    }

    /// Finds what a point encroaches: of the boundary in its cavity, and of what is pending.
    fn hit<B: Bounded<Tet = T>>(&mut self, closure: &B, p: &Point, carrier: Carrier) {
        let Self { faces, edges, hit_segments, hit_subfaces } = self;
        let in_ball = |s: [VertexId; 2]| {
            let [a, b] = s.map(|v| closure.at(v));
            in_diametral_ball(&a, &b, p)
        };
        // A point on its facet encroaches no subface.
        let off_in_ball = |s: [VertexId; 3], facet: u32| {
            let [a, b, c] = s.map(|v| closure.at(v));
            !closure.plc().lies_on(carrier, facet) && in_equatorial_ball(&a, &b, &c, p)
        };
        let is_hit = |own: &&Edge| {
            !closure.is_related(carrier, Item::Segment(own.key), own.segment) && in_ball(own.key)
        };
        hit_segments.extend(edges.iter().filter(is_hit).map(|own| own.key));
        let is_hit = |own: &&Face<T>| {
            !closure.is_related(carrier, Item::Subface(own.key), own.facet)
                && off_in_ball(own.key, own.facet)
        };
        hit_subfaces.extend(faces.iter().filter(is_hit).map(|own| own.key));
        let segments: Set<[VertexId; 2]> = hit_segments.iter().copied().collect();
        let subfaces: Set<[VertexId; 3]> = hit_subfaces.iter().copied().collect();
        for item in closure.pending(p) {
            match item {
                Item::Segment(s) if !segments.contains(&s) && in_ball(s) => hit_segments.push(s),
                Item::Subface(s)
                    if !subfaces.contains(&s)
                        && closure.pending_facet(s).is_some_and(|facet| off_in_ball(s, facet)) =>
                {
                    hit_subfaces.push(s);
                }
                _ => {}
            }
        }
    }
}

/// Are all tetrahedra around an edge of `t` in the cavity, and `t` the smallest? `beside` are those
/// beyond the faces of `t` at the edge.
fn is_smallest_around<B: Bounded>(
    closure: &B,
    t: B::Tet,
    key: [VertexId; 2],
    [before, after]: [B::Tet; 2],
) -> bool {
    if before < t || after < t {
        return false;
    }
    // Around an edge a walk comes back to where it started, at the latest after all.
    let (mut from, mut at) = (t, after);
    for _ in 0..closure.most_steps() {
        if at == t {
            return true;
        }
        if at < t || !closure.is_in(at) {
            return false;
        }
        let v = closure.vertices(at);
        let mut next = (0..4).filter(|&k| !key.contains(&v[k])).map(|k| closure.beyond(at, k));
        let Some(Some(beyond)) = next.find(|other| *other != Some(from)) else { return false };
        (from, at) = (at, beyond);
    }
    false
}
