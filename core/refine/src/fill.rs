//! The filling: the point is inserted, and marks, tables and work are brought up to date.

use crate::complex::carrier::Carrier;
use crate::mesh::bounds::Bounds;
use crate::mesh::item::{Item, Queues};
use crate::mesh::marks::{Word, edge_bit, face_bit};
use crate::mesh::state::{Place, State};
use crate::rules::verdict::Filling;
use crate::table::{edge, triangle};
use crate::thin::ThinTets;
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
    pub(crate) fn fill(
        &mut self,
        open: OpenCavity<'_, State>,
        place: &Place,
        filling: &Filling,
        bounds: Option<&Bounds<'_>>,
        work: &mut Queues,
    ) {
        open.end(|state| {
            let p = state.fill(place, self.next_number);
            self.next_number += 1;
            self.points.count(place.carrier);
            self.follow(state, p, filling, bounds, work);
        });
    }

    /// Fills the open cavity of a vertex that was put off.
    pub(crate) fn fill_vertex(
        &mut self,
        open: OpenCavity<'_, State>,
        v: VertexId,
        filling: &Filling,
        work: &mut Queues,
    ) {
        open.end(|state| {
            state.fill_vertex(v);
            self.follow(state, v, filling, None, work);
        });
    }

    /// Brings up to date what depends on the star of a new vertex.
    fn follow(
        &mut self,
        state: &mut State,
        p: VertexId,
        filling: &Filling,
        bounds: Option<&Bounds<'_>>,
        work: &mut Queues,
    ) {
        state.relabel_walls(&filling.changes);
        self.created.clear();
        self.created.extend_from_slice(state.mesh.cavity().star().tets);
        if state.carriers[p.index()] != Carrier::Free || !filling.changes.is_empty() {
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
    }

    /// Puts the new tetrahedra that are over their bounds; those of a joint step are noted, and
    /// looked at when it is done.
    fn put_created(&mut self, state: &mut State, bounds: &Bounds<'_>, work: &mut Queues) {
        if let Some(journal) = &mut state.journal {
            let topology = state.mesh.topology();
            let created = self.created.iter().map(|&t| (t, topology.at(t).vertices()));
            return journal.created.extend(created.filter(|(_, v)| v[3] != INFINITE));
        }
        let created = self.created.iter().copied();
        for (t, v) in bounds.over_of(state, created, &mut self.thin.tets) {
            work.put(Item::Tet(t, v), bounds.excess_of(state, t));
        }
        self.thin.forget_old(|(t, v)| state.is_live(t, v));
    }

    /// After the filling: old boundary items that are gone or lost, and the new ones.
    fn update_boundary(
        &self,
        state: &mut State,
        p: VertexId,
        filling: &Filling,
        work: &mut Queues,
    ) {
        state.enter_filling(p, filling);
        let star = self.created.iter().map(|&t| StarTet { t, v: state.vertices(t) });
        let star: Vec<_> = star.collect();
        let mut missed = Vec::new();
        filling.mark(&star, |t, bits| state.marks.set(t, bits), &mut missed);
        for &item in filling.lost.iter().chain(&missed) {
            state.miss(item, work);
        }
    }
}

/// A tetrahedron of a star, with its vertices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StarTet {
    pub(crate) t: TetId,
    pub(crate) v: [VertexId; 4],
}

impl Filling {
    /// Marks the new subsegments and subfaces at a star of its vertex, which is the first one of
    /// each tetrahedron; tells of those that it has not.
    pub(crate) fn mark(
        &self,
        star: &[StarTet],
        mark: impl Fn(TetId, Word),
        missed: &mut Vec<Item>,
    ) {
        let Some(&StarTet { v: [p, ..], .. }) = star.first() else { return };
        let slot_of = |v: &[VertexId; 4], a| (1..4).find(|&k| v[k] == a);
        for a in self.split.iter().flat_map(|(ends, _)| *ends) {
            let mut is_there = false;
            for StarTet { t, v } in star {
                let Some(slot) = slot_of(v, a) else { continue };
                is_there = true;
                mark(*t, edge_bit(0, slot));
            }
            if !is_there {
                missed.push(Item::Segment(edge(a, p)));
            }
        }
        let rim: Vec<[VertexId; 2]> =
            self.changes.iter().flat_map(|change| &change.rim).map(|&[a, b]| edge(a, b)).collect();
        let mut sorted: Vec<([VertexId; 2], usize)> = rim.iter().copied().zip(0..).collect();
        sorted.sort_unstable();
        let mut is_there = vec![false; rim.len()];
        for StarTet { t, v } in star.iter().filter(|_| !rim.is_empty()) {
            for [i, j] in [[1, 2], [1, 3], [2, 3]] {
                let key = edge(v[i], v[j]);
                let first = sorted.partition_point(|(other, _)| *other < key);
                for (_, k) in sorted[first..].iter().take_while(|(other, _)| *other == key) {
                    is_there[*k] = true;
                    mark(*t, face_bit(6 - i - j));
                }
            }
        }
        let missing = rim.iter().zip(is_there).filter(|(_, is_there)| !is_there);
        missed.extend(missing.map(|(&[a, b], _)| Item::Subface(triangle(p, a, b))));
    }
}

impl State {
    /// Takes the items that are gone with a filling by vertex `p` out of the tables, and enters the
    /// new ones.
    pub(crate) fn enter_filling(&mut self, p: VertexId, filling: &Filling) {
        let Filling { split, changes, .. } = filling;
        if let Some((ends, _)) = *split {
            self.remove_segment(ends);
        }
        for s in changes.iter().flat_map(|change| &change.removed) {
            self.remove_subface(*s);
        }
        if let Some((ends, s)) = *split {
            ends.into_iter().for_each(|end| self.add_segment(edge(end, p), s));
        }
        for change in changes {
            for &[a, b] in &change.rim {
                self.add_subface(triangle(p, a, b), change.facet);
            }
        }
    }

    /// Fills the open cavity of a vertex that was put off.
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
