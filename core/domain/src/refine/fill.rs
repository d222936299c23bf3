//! The filling: the point is inserted, and marks, tables and work are brought up to date.

use super::bounds::Bounds;
use super::carrier::Carrier;
use super::item::{Item, Work};
use super::marks::{edge_bit, face_bit};
use super::state::{Place, State};
use super::table::{edge, triangle};
use super::thin::ThinTets;
use super::verdict::Filling;
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_core::transaction::OpenCavity;

/// Points inserted, by what they are on.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Points {
    pub(crate) segments: u64,
    pub(crate) facets: u64,
    pub(crate) free: u64,
}

impl Points {
    pub(crate) fn count(&mut self, carrier: Carrier) {
        match carrier {
            Carrier::Segment(..) => self.segments += 1,
            Carrier::Facet(_) => self.facets += 1,
            Carrier::Free | Carrier::Corner(_) => self.free += 1,
        }
    }

    pub(crate) fn total(self) -> u64 {
        self.segments + self.facets + self.free
    }
}

/// The vertices inserted so far.
#[derive(Debug)]
pub(crate) struct Inserted {
    pub(crate) points: Points,
    /// The number of the next vertex.
    pub(crate) next_number: u32,
    /// The new tetrahedra of the last insertion, or the slots that a joint step has written.
    pub(crate) created: Vec<TetId>,
    /// Tetrahedra that may have tiny dihedral angles: all that are left, and others.
    pub(crate) thin: ThinTets,
}

impl Inserted {
    /// No vertices yet.
    pub(crate) fn from(next_number: u32) -> Self {
        Self {
            points: Points::default(),
            next_number,
            created: Vec::new(),
            thin: ThinTets::default(),
        }
    }

    /// Fills the open cavity of a place. Items that the mesh has lost, and new tetrahedra over
    /// their bounds, are put to the work.
    pub(crate) fn fill<W: Work>(
        &mut self,
        open: OpenCavity<'_, State>,
        place: &Place,
        filling: &Filling,
        bounds: Option<&Bounds<'_>>,
        work: &mut W,
    ) {
        open.end(|state| {
            let p = state.fill(place, self.next_number);
            state.relabel_walls(&filling.changes);
            self.next_number += 1;
            self.points.count(place.carrier);
            self.created.clear();
            self.created.extend_from_slice(state.mesh.cavity().star().tets);
            if place.carrier != Carrier::Free || !filling.changes.is_empty() {
                self.update_boundary(state, p, filling, work);
            }
            // Labels are inherited; what they have to be is a function of the subfaces alone.
            debug_assert!(
                bounds.is_none()
                    || state.journal.is_some()
                    || state.is_labelled(self.created.iter().copied()),
                "the label changes where there is no subface, or not at one"
            );
            if let Some(bounds) = bounds {
                self.put_created(state, bounds, work);
            }
        });
    }

    /// Puts the new tetrahedra that are over their bounds; those of a joint step are noted, and
    /// looked at when it is done.
    fn put_created<W: Work>(&mut self, state: &mut State, bounds: &Bounds<'_>, work: &mut W) {
        if let Some(journal) = &mut state.journal {
            let topology = state.mesh.topology();
            let created = self.created.iter().map(|&t| (t, topology.at(t).vertices()));
            return journal.created.extend(created.filter(|(_, v)| v[3] != INFINITE));
        }
        let created = self.created.iter().copied();
        for (t, v) in bounds.over_of(state, created, &mut self.thin.tets) {
            work.put(Item::Tet(t, v), bounds.excess_of(state, t));
        }
        self.thin.forget_old(state);
    }

    /// After the filling: old boundary items that are gone or lost, and the new ones.
    fn update_boundary<W: Work>(
        &self,
        state: &mut State,
        p: VertexId,
        filling: &Filling,
        work: &mut W,
    ) {
        let Filling { split, changes, lost } = filling;
        if let Some((ends, _)) = *split {
            state.remove_segment(ends);
        }
        for s in changes.iter().flat_map(|change| &change.removed) {
            state.remove_subface(*s);
        }
        for item in lost {
            state.miss(*item, work);
        }
        if let Some((ends, s)) = *split {
            for end in ends {
                self.add_segment(state, [end, p], s, work);
            }
        }
        for change in changes {
            for &[a, b] in &change.rim {
                self.add_subface(state, [p, a, b], change.facet, work);
            }
        }
    }

    /// Enters the subsegment from the new vertex `p` to `a`; marks it if the star has it.
    fn add_segment<W: Work>(&self, state: &mut State, [a, p]: [VertexId; 2], s: u32, work: &mut W) {
        let key = edge(a, p);
        state.add_segment(key, s);
        let mut present = false;
        for &t in &self.created {
            let v = state.vertices(t);
            let Some(slot) = (1..4).find(|&k| v[k] == a) else { continue };
            present = true;
            state.marks.set(t, edge_bit(0, slot));
        }
        if !present {
            state.miss(Item::Segment(key), work);
        }
    }

    /// Enters the subface from the new vertex `p` to the edge `ab`; marks it if the star has it.
    fn add_subface<W: Work>(
        &self,
        state: &mut State,
        [p, a, b]: [VertexId; 3],
        f: u32,
        work: &mut W,
    ) {
        let key = triangle(p, a, b);
        state.add_subface(key, f);
        let mut present = false;
        for &t in &self.created {
            let v = state.vertices(t);
            let (Some(i), Some(j)) = ((1..4).find(|&k| v[k] == a), (1..4).find(|&k| v[k] == b))
            else {
                continue;
            };
            present = true;
            state.marks.set(t, face_bit(6 - i - j));
        }
        if !present {
            state.miss(Item::Subface(key), work);
        }
    }
}

impl State {
    /// Fills the open cavity of a free vertex that was put off.
    pub(crate) fn fill_vertex(&mut self, v: VertexId) {
        self.marks.gather(&self.mesh);
        OpenCavity::new(&mut self.mesh).fill_vertex(v);
        self.marks.pass_on(&self.mesh);
    }

    /// Fills the open cavity; the star gets the marks of its walls. Returns the new vertex.
    fn fill(&mut self, place: &Place, number: u32) -> VertexId {
        self.marks.gather(&self.mesh);
        let open = OpenCavity::new(&mut self.mesh);
        let p = match &mut self.journal {
            None => open.fill(place.p, number),
            Some(journal) => {
                let (p, undo) = open.fill_for_now(place.p, number);
                let words = undo.cavity().map(|t| self.marks.of(t)).collect();
                journal.insertions.push((undo, words));
                journal.points.push((place.p, place.carrier));
                p
            }
        };
        self.carriers.push(place.carrier);
        self.marks.pass_on(&self.mesh);
        p
    }
}
