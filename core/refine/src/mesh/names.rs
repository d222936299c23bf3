//! Which edges and faces of the mesh are boundary: a function of their vertices.
//!
//! While every subsegment and subface is in the mesh, the carriers of its vertices tell what they
//! are. An edge between two vertices of one segment is a subsegment, for a third one between them
//! would be on the edge. A triangle of vertices of one facet does not cross a subsegment; so it is
//! a subface if one of them is inside the facet, or if it is on a side of a segment where the facet
//! is. Triangles of three corners are as they were at the start: all new ones have a new vertex.
//!
//! Facets that are patches within a tolerance have no plane: their subfaces are where the label
//! changes (`patches/surface.rs`).

use super::marks::{ENDS, edge_bit, face_bit};
use super::state::{FACE, State};
use crate::complex::carrier::{Carrier, Corner, corner_point};
use crate::complex::plc::Plc;
use crate::table::{self, Map, Set, edge, triangle};
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_exact::Point;
use std::cmp::Ordering;

/// All that the carriers do not tell, at a state in which nothing is missing.
#[derive(Debug, Default)]
pub(crate) struct Names {
    /// Segments by their ends.
    segments: Map<[u32; 2], u32>,
    /// By segment and facet: is the facet on the left, and on the right of the segment?
    sides: Map<(u32, u32), [bool; 2]>,
    /// Subfaces whose vertices are corners.
    faces: Set<[u32; 3]>,
}

impl Names {
    /// The names in a state, as long as nothing is missing, from now on.
    pub(crate) fn of(state: &State) -> Self {
        let plc = &state.plc;
        let segments = (0..).zip(&plc.segments).map(|(s, own)| (own.ends, s)).collect();
        let mut own = Self { segments, ..Self::default() };
        let exact = state.subfaces.iter().filter(|(_, f)| !plc.is_patch(**f));
        for (&corners, &f) in exact {
            let at = |v: VertexId| (state.carriers[v.index()], state.at(v));
            if let [Carrier::Corner(a), Carrier::Corner(b), Carrier::Corner(c)] =
                corners.map(|v| at(v).0)
            {
                own.faces.insert(triangle(a, b, c));
            }
            for ([a, b], apex) in table::sides(corners) {
                if let Some(s) = own.segment(plc, [at(a).0, at(b).0]) {
                    let side = plc.side(f, s, &at(apex).1);
                    own.sides.entry((s, f)).or_default()[usize::from(side == Ordering::Less)] =
                        true;
                }
            }
        }
        own
    }

    /// The segment that an edge of the mesh between two vertices is on, if it is a subsegment.
    pub(crate) fn segment(&self, plc: &Plc, ends: [Carrier; 2]) -> Option<u32> {
        let is_end = |s: u32, c: u32| plc.segments[s as usize].ends.contains(&c);
        match ends {
            [Carrier::Segment(s, _), Carrier::Segment(r, _)] => (s == r).then_some(s),
            [Carrier::Segment(s, _), Carrier::Corner(c)]
            | [Carrier::Corner(c), Carrier::Segment(s, _)] => is_end(s, c).then_some(s),
            [Carrier::Corner(a), Carrier::Corner(b)] => self.segments.get(&edge(a, b)).copied(),
            _ => None,
        }
    }

    /// The facet that a triangle of the mesh is on, if it is a subface, but not of a patch.
    pub(crate) fn facet(&self, plc: &Plc, corners: [Corner; 3]) -> Option<u32> {
        let carriers = corners.map(|own| own.carrier);
        if carriers.contains(&Carrier::Free) {
            return None;
        }
        let on_all =
            |&f: &u32| !plc.is_patch(f) && carriers.iter().all(|&carrier| plc.lies_on(carrier, f));
        let inside = carriers.iter().find_map(|&carrier| match carrier {
            Carrier::Facet(f) => Some(f),
            _ => None,
        });
        if let Some(f) = inside {
            return Some(f).filter(on_all);
        }
        let on_segment = carriers.iter().find_map(|&carrier| match carrier {
            Carrier::Segment(s, _) => Some(s),
            _ => None,
        });
        if let Some(s) = on_segment {
            let f = plc.segments[s as usize].facets.iter().copied().find(on_all)?;
            let mut sides = corners.iter().map(|own| plc.side(f, s, &own.point));
            let off = sides.find(|side| side.is_ne())?;
            let known = self.sides.get(&(s, f)).copied().unwrap_or_default();
            return known[usize::from(off.is_lt())].then_some(f);
        }
        let [Carrier::Corner(a), Carrier::Corner(b), Carrier::Corner(c)] = carriers else {
            return None;
        };
        let is_face = self.faces.contains(&triangle(a, b, c));
        is_face.then(|| plc.facets_at[a as usize].iter().copied().find(on_all)).flatten()
    }

    /// Does a mark, or an entry of a table, of an edge or face of tetrahedron `t` differ from what
    /// the carriers, and at patches the labels, tell?
    pub(crate) fn differ(&self, state: &State, t: TetId) -> bool {
        let (plc, v, word) = (&state.plc, state.vertices(t), state.marks.of(t));
        let carrier = |k: usize| match v[k] {
            INFINITE => Carrier::Free,
            v => state.carriers[v.index()],
        };
        let is_other_edge = |[i, j]: [usize; 2]| {
            let name = self.segment(plc, [carrier(i), carrier(j)]);
            let known = state.segments.get(&edge(v[i], v[j])).copied();
            name != known || name.is_some() != (word & edge_bit(i, j) != 0)
        };
        let is_other_face = |(slot, face): (usize, [usize; 3])| {
            let [a, b, c] = face.map(|k| v[k]);
            let known = state.subfaces.get(&triangle(a, b, c)).copied();
            if face.iter().any(|&k| v[k] == INFINITE) {
                return false;
            }
            let corners = face.map(|k| state.corner(v[k]));
            let labels = [t, state.neighbours(t)[slot]].map(|t| state.marks.region(t));
            let name = self.facet(plc, corners).or_else(|| plc.patch_at(corners, slot, labels));
            name != known || name.is_some() != (word & face_bit(slot) != 0)
        };
        ENDS.into_iter().any(is_other_edge) || FACE.into_iter().enumerate().any(is_other_face)
    }
}

impl Plc {
    /// The side of segment `s` in the plane of facet `f`, on which it lies, that `p` of that plane
    /// is on.
    pub(crate) fn side(&self, f: u32, s: u32, p: &Point) -> Ordering {
        let ends = self.segments[s as usize].ends;
        let [a, b] = ends.map(|c| corner_point(&self.corners[c as usize]));
        self.turn(f, [&a, &b, p])
    }

    /// The turn of three points of the plane of facet `f`, as seen along an axis that is not in it.
    pub(crate) fn turn(&self, f: u32, [a, b, p]: [&Point; 3]) -> Ordering {
        let normal = self.facets[f as usize].plane.normal();
        let drop = (0..3).max_by(|&i, &j| normal[i].abs().total_cmp(&normal[j].abs()));
        let drop = drop.unwrap_or_default();
        let [x, y] = [(drop + 1) % 3, (drop + 2) % 3];
        // Coordinates are whole and at most 2^53: products are below 2^109.
        let from_a = |p: &Point, k: usize| p[k] as i128 - a[k] as i128;
        (from_a(b, x) * from_a(p, y)).cmp(&(from_a(b, y) * from_a(p, x)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Refiner;
    use crate::tests::{ready, refine};
    use ltbw_generate::{DomainKind, Shape};

    #[test]
    fn carriers_tell_what_marks_and_tables_tell() {
        for kind in [DomainKind::CubeInCube, DomainKind::Tee, DomainKind::Wedge] {
            let whole = ready(kind, &Shape::default());
            let mut refined = refine(&Refiner::new().max_volume(0.02), &whole);
            let names = Names::of(&refined.state);
            let all: Vec<TetId> = refined.state.mesh.topology().iter().map(|(t, _)| t).collect();
            assert!(all.iter().all(|&t| !names.differ(&refined.state, t)), "{kind:?}");
            let state = &mut refined.state;
            let marked = |t: &&TetId| state.marks.of(**t) & face_bit(0) != 0;
            let t = *all.iter().find(marked).expect("a subface");
            let [a, b, c] = FACE[0].map(|k| state.vertices(t)[k]);
            // An entry that is gone, another facet, a mark too many: each one is seen.
            let of = state.subfaces.remove(&triangle(a, b, c)).expect("its facet");
            assert!(names.differ(state, t), "{kind:?}: without an entry");
            let others = state.plc.facets.len() as u32;
            state.subfaces.insert(triangle(a, b, c), (of + 1) % others);
            assert!(names.differ(state, t), "{kind:?}: of another facet");
            state.subfaces.insert(triangle(a, b, c), of);
            assert!(!names.differ(state, t), "{kind:?}: as before");
            let bare = |t: &&TetId| {
                state.vertices(**t)[3] != INFINITE && state.marks.of(**t) & face_bit(1) == 0
            };
            let t = *all.iter().find(bare).expect("a face inside");
            state.marks.set(t, face_bit(1));
            assert!(names.differ(state, t), "{kind:?}: a mark too many");
        }
    }
}
