//! The boundary in the open cavity of a point: what the point encroaches, and what it would take
//! out of the mesh.
//!
//! All is found in one pass over the marked tetrahedra of the cavity, without a list of its walls.
//! The tetrahedra of the cavity at an edge of its boundary are one arc, since the point sees all of
//! the boundary: the first one reports the edge. An edge inside the cavity is reported by the
//! smallest tetrahedron around it.

use super::carrier::Carrier;
use super::facet::Change;
use super::item::Item;
use super::marks::{EDGES, ENDS, FACES, face_bit};
use super::state::{FACE, State, Touched};
use super::table::{Set, edge, triangle};
use ltbw_core::topology::{TetId, VertexId, tet_of};
use ltbw_exact::Point;

/// The other two slots at each edge of [`ENDS`], in such an order that with the edge before them
/// they are positively oriented.
const ACROSS: [[usize; 2]; 6] = [[2, 3], [3, 1], [1, 2], [0, 3], [2, 0], [0, 1]];

impl State {
    /// The items that a point encroaches, of the boundary in its cavity.
    pub(crate) fn hits_in(&self, touched: &Touched) -> Vec<Item> {
        let mut hits = touched.hits();
        if self.by_place {
            self.sort_largest_first(&mut hits);
        }
        hits
    }

    /// Looks at the boundary in the open cavity of `p`, which lives on `carrier`: what is in it,
    /// and what `p` encroaches, by the closure and the encroachment index.
    pub(crate) fn touch(&mut self, p: &Point, carrier: Carrier) {
        let mut touched = std::mem::take(&mut self.touched);
        let topology = self.mesh.topology();
        let is_open = |t: TetId| topology.at(t).is_marked();
        self.look_into((self.mesh.cavity().tets(), &is_open), p, carrier, &mut touched);
        self.touched = touched;
    }

    /// Looks into a cavity that need not be open: its tetrahedra, and whether it has one.
    pub(crate) fn look_into(
        &self,
        (tets, has): (impl Iterator<Item = TetId>, &impl Fn(TetId) -> bool),
        p: &Point,
        carrier: Carrier,
        touched: &mut Touched,
    ) {
        touched.clear();
        for t in tets {
            let word = self.marks.of(t);
            touched.is_marked |= word & (EDGES | FACES) != 0;
            if word & EDGES != 0 {
                self.touch_edges(t, word, has, touched);
            }
            if word & FACES != 0 {
                self.touch_faces((t, word), has, p, carrier, touched);
            }
        }
        let Touched { rim, inner_edges, hit_segments, .. } = touched;
        inner_edges.sort_unstable();
        let is_hit = |s: &&[VertexId; 2]| {
            let has = |corner: u32| self.has_corner(Item::Segment(**s), corner);
            let related = |&of: &u32| self.angles.related_segment(carrier, of, &has).is_some();
            let related = carrier != Carrier::Free && self.segments.get(*s).is_some_and(related);
            !related && self.encroaches_segment(**s, p)
        };
        hit_segments.extend(rim.iter().chain(&*inner_edges).filter(is_hit));
        hit_segments.sort_unstable();
        hit_segments.dedup();
        self.touch_pending(p, carrier, touched);
    }

    /// Takes the marked edges of a tetrahedron of the cavity that it has to report.
    fn touch_edges(
        &self,
        t: TetId,
        word: u32,
        has: &impl Fn(TetId) -> bool,
        touched: &mut Touched,
    ) {
        let tet = self.mesh.topology().at(t);
        let (v, n) = (tet.vertices(), tet.neighbours());
        let inside = n.map(|face| has(tet_of(face)));
        for (k, [i, j]) in ENDS.into_iter().enumerate() {
            if word >> (4 + k) & 1 == 0 {
                continue;
            }
            let key = edge(v[i], v[j]);
            let [mut before, mut after] = ACROSS[k];
            if key[0] != v[i] {
                (before, after) = (after, before);
            }
            if !inside[before] {
                touched.rim.push(key);
            } else if inside[after] && self.is_smallest_around(t, key, [before, after], has) {
                touched.inner_edges.push(key);
            }
        }
    }

    /// Are all tetrahedra around an edge of `t` in the cavity, and `t` the smallest? The faces of
    /// `t` at the edge are those opposite `slots`.
    fn is_smallest_around(
        &self,
        t: TetId,
        key: [VertexId; 2],
        slots: [usize; 2],
        has: &impl Fn(TetId) -> bool,
    ) -> bool {
        let topology = self.mesh.topology();
        let [before, after] = slots.map(|slot| tet_of(topology.at(t).neighbours()[slot]));
        if before < t || after < t {
            return false;
        }
        // Around an edge a walk comes back to where it started, at the latest after all.
        let (mut from, mut at) = (t, after);
        for _ in 0..topology.slots() {
            let tet = topology.at(at);
            if at == t {
                return true;
            }
            if at < t || !has(at) {
                return false;
            }
            let (v, n) = (tet.vertices(), tet.neighbours());
            let next = (0..4).find(|&k| !key.contains(&v[k]) && tet_of(n[k]) != from);
            let Some(slot) = next else { return false };
            (from, at) = (at, tet_of(n[slot]));
        }
        false
    }

    /// Takes the marked faces of a tetrahedron of the cavity.
    fn touch_faces(
        &self,
        (t, word): (TetId, u32),
        has: &impl Fn(TetId) -> bool,
        p: &Point,
        carrier: Carrier,
        touched: &mut Touched,
    ) {
        let tet = self.mesh.topology().at(t);
        let v = tet.vertices();
        for slot in (0..4).filter(|&slot| word & face_bit(slot) != 0) {
            let other = tet_of(tet.neighbours()[slot]);
            let inside = has(other);
            // An inner face is met from both sides.
            if inside && other < t {
                continue;
            }
            let [a, b, c] = FACE[slot].map(|k| v[k]);
            let key = triangle(a, b, c);
            let Some(&facet) = self.subfaces.get(&key) else { continue };
            if inside {
                touched.inner.push((key, facet));
            }
            let has = |corner: u32| self.has_corner(Item::Subface(key), corner);
            if self.angles.related(&self.plc, carrier, facet, &has).is_none()
                && self.encroaches_subface(key, facet, p, carrier)
            {
                touched.hit_subfaces.push(key);
            }
        }
    }

    /// Adds the pending items that `p` encroaches.
    fn touch_pending(&self, p: &Point, carrier: Carrier, touched: &mut Touched) {
        let Touched { hit_segments, hit_subfaces, .. } = touched;
        let segments: Set<[VertexId; 2]> = hit_segments.iter().copied().collect();
        let subfaces: Set<[VertexId; 3]> = hit_subfaces.iter().copied().collect();
        // The index tells of each item once.
        for item in self.encroachment.near(p) {
            match item {
                Item::Segment(s) => {
                    if !segments.contains(&s) && self.encroaches_segment(s, p) {
                        hit_segments.push(s);
                    }
                }
                Item::Subface(s) => {
                    let Some(&facet) = self.subfaces.get(&s) else { continue };
                    let known = subfaces.contains(&s);
                    if !known && self.encroaches_subface(s, facet, p, carrier) {
                        hit_subfaces.push(s);
                    }
                }
                Item::Tet(..) => {}
            }
        }
    }

    /// The boundary items that a point would take out of the mesh, of those in its cavity, but for
    /// those that it splits: the subsegment `split`, and what `changes` remove.
    pub(crate) fn losses_in(
        &self,
        touched: &Touched,
        split: Option<[VertexId; 2]>,
        changes: &[Change],
    ) -> Vec<Item> {
        let removed: Set<&[VertexId; 3]> = changes.iter().flat_map(|c| &c.removed).collect();
        let stays = |s: &[VertexId; 3]| !removed.contains(s);
        let inner = touched.inner.iter().map(|(s, _)| *s);
        let faces = inner.filter(stays).map(Item::Subface);
        let edges = touched.inner_edges.iter().filter(|e| Some(**e) != split);
        let mut lost: Vec<Item> = faces.chain(edges.map(|&e| Item::Segment(e))).collect();
        if self.by_place {
            self.sort_largest_first(&mut lost);
        }
        lost
    }
}
