//! The insertion of the points of a round by several threads: each has a share of them along the
//! curve, inserts those whose closures nobody else needs, and leaves the others.

use super::keys::Keys;
use super::ranked::{Bad, witness};
use super::reserved::Reserved;
use super::{Candidate, Choice, Look, Rounds};
use crate::RefineError;
use crate::complex::carrier::Carrier;
use crate::fill::StarTet;
use crate::mesh::bounds::{Bounds, Four, bits};
use crate::mesh::item::Item;
use crate::mesh::key::key_of_tet;
use crate::mesh::marks::{Marks, Word};
use crate::thin::Thin;
use ltbw_core::BuildError;
use ltbw_core::mesh::lanes::{Batch, Chosen, Follow, Lanes, View};
use ltbw_core::topology::{FaceId, INFINITE, TetId, VertexId, tet_of};

/// The fewest points for a lane.
const FEW: usize = if cfg!(test) { 2 } else { 128 };
/// The insertions of a lane between two looks at the new tetrahedra.
const BATCH: usize = if cfg!(test) { 3 } else { 32 };
/// The points inserted between two looks at whether the work is cancelled.
const STAGE: usize = if cfg!(test) { 50 } else { 1 << 16 };

/// The memory of the threads that insert together.
#[derive(Debug, Default)]
pub(super) struct Memory {
    lanes: Lanes,
    kept: Vec<Kept>,
}

/// The memory of one lane, in cache lines of its own.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Kept {
    /// The words of the walls of the open cavity.
    inherited: Vec<Word>,
    /// The slots that it has written since its last look, each once.
    created: Vec<TetId>,
    /// Insertions since the last look.
    insertions: usize,
    /// The looks of this stage.
    looks: u32,
    /// The tetrahedra over their bounds that it has found, and those that may have tiny dihedral
    /// angles.
    bad: Vec<Bad>,
    thin: Vec<Thin>,
    /// Scratch: a star with boundary.
    star: Vec<StarTet>,
    /// Items that should be in a star, but are not.
    missed: Vec<Item>,
}

/// Marks, slots written, and keys, which each lane brings up to date.
struct Update<'u> {
    candidates: &'u [Candidate],
    /// The candidates that are inserted.
    stage: &'u [usize],
    marks: &'u Marks,
    reserved: &'u Reserved,
    keys: &'u Keys,
    /// The bounds, if tetrahedra are looked at here.
    bounds: Option<&'u Bounds<'u>>,
}

impl Update<'_> {
    /// Looks at the tetrahedra made since the last look, as long as they are in the cache. None was
    /// refused before: each has a new vertex.
    #[inline(never)]
    fn look(&self, own: &mut Kept, view: View<'_>) {
        let Some(bounds) = self.bounds else { return };
        own.insertions = 0;
        own.looks += 1;
        let (look, first) = (self.keys.look() + own.looks, own.bad.len());
        own.created.iter().for_each(|&t| self.keys.write(t, 0, look));
        self.find_bad(own, look, bounds, view);
        own.created.clear();
        for bad in &mut own.bad[first..] {
            if let Some(witness) = self.one_before(bad.t, view) {
                bad.witness = witness;
            }
        }
    }

    /// Finds the new tetrahedra that are over their bounds, and gives their slots keys. None lies
    /// between the triangles of a patch: points that change one go in no lane.
    fn find_bad(&self, kept: &mut Kept, look: u32, bounds: &Bounds<'_>, view: View<'_>) {
        let Kept { created, bad, thin, .. } = kept;
        let mut solid = created.iter().filter_map(|&t| {
            let region = self.marks.region(t);
            let tet = view.tet(t).filter(|tet| region != 0 && !tet.is_ghost())?;
            Some((t, tet.vertices(), region))
        });
        let (mut four, mut own) = (Four::default(), [(TetId::default(), [INFINITE; 4]); 4]);
        loop {
            four.clear();
            for (to, (t, v, region)) in own.iter_mut().zip(solid.by_ref()) {
                *to = (t, v);
                four.push(v.map(|v| view.point(v)), region);
            }
            let looked = bounds.look_at_four(&four);
            for k in bits(looked.0) {
                let t = own[k].0;
                self.keys.set(t, key_of_tet(four.corners(k)));
                bad.push(Bad::new(t, look));
            }
            thin.extend(bits(looked.1).map(|k| own[k]));
            if four.count() < own.len() {
                return;
            }
        }
    }

    /// A tetrahedron around `t` that comes before it, and the neighbour on the way there, or `t`.
    /// Only slots of this lane count, since others may be written meanwhile, within this look.
    fn one_before(&self, t: TetId, view: View<'_>) -> Option<[TetId; 2]> {
        let key = self.keys.at(t);
        let neighbours = view.tet(t)?.neighbours().map(tet_of);
        let is_before = |&other: &TetId| self.keys.at(other) > key && view.tet(other).is_some();
        let around = |way: TetId| view.tet(way).map(|tet| tet.neighbours().map(tet_of));
        witness(t, neighbours, around, is_before)
    }
}

impl Follow for Update<'_> {
    type Own = Kept;

    #[inline(always)]
    fn changed(&self, t: TetId) -> bool {
        self.reserved.is_written(t)
    }

    #[inline(always)]
    fn fetch(&self, t: TetId) {
        self.reserved.prefetch(t);
        self.marks.prefetch(t);
    }

    #[inline(always)]
    fn opened(&self, own: &mut Kept, walls: impl Iterator<Item = FaceId>) {
        self.marks.inherit(&mut own.inherited, walls);
    }

    #[inline(always)]
    fn filled(&self, own: &mut Kept, k: usize, star: &[TetId], view: View<'_>) {
        self.marks.pass(&own.inherited, star);
        let Candidate { place, filling, .. } = &self.candidates[self.stage[k]];
        if place.carrier != Carrier::Free {
            own.star.clear();
            let star_tet = |&t: &TetId| Some(StarTet { t, v: view.tet(t)?.vertices() });
            own.star.extend(star.iter().filter_map(star_tet));
            filling.mark(&own.star, |t, bits| self.marks.set(t, bits), &mut own.missed);
        }
        for &t in star {
            if self.reserved.note_written(t, own.looks) {
                own.created.push(t);
                // These are written when the tetrahedron is looked at.
                self.keys.prefetch_all(t);
            }
        }
        own.insertions += 1;
        if own.insertions == BATCH {
            self.look(own, view);
        }
    }

    fn ended(&self, own: &mut Kept, view: View<'_>) {
        self.look(own, view);
    }
}

impl Rounds<'_, '_> {
    /// May several threads insert some of the chosen points? Not if labels at a patch change: they
    /// are a function of the mesh as long as one point at a time changes it.
    pub(super) fn may_use_lanes(&self, list: &[usize]) -> bool {
        let changes = |&k: &usize| !self.choice.candidates[k].filling.changes.is_empty();
        let changes_patch = self.in_waves && list.iter().any(changes);
        self.threads > 1 && !self.reserved.has_alone() && !changes_patch
    }

    /// Inserts candidates in lanes; returns their number, which is less than all if the work is
    /// cancelled. A point of the boundary is put off if the changes that come with it may be
    /// others by now.
    ///
    /// # Errors
    /// There is no room for one.
    pub(super) fn insert_in_lanes(
        &mut self,
        order: &[usize],
        look: Look<'_>,
    ) -> Result<usize, RefineError> {
        let mut count = 0;
        for stage in order.chunks(STAGE) {
            if count > 0 && look(self.own.state.mesh.num_vertices()) {
                break;
            }
            self.insert_stage(stage)?;
            count += stage.len();
        }
        Ok(count)
    }

    fn insert_stage(&mut self, stage: &[usize]) -> Result<(), RefineError> {
        let count = stage.len();
        let many = self.threads.min(count / FEW).clamp(1, Lanes::MOST);
        let Self { own, choice, reserved, keys, lanes, .. } = self;
        let Choice { candidates, cavities, .. } = choice;
        let (state, inserted) = (&mut own.state, &mut own.inserted);
        let slots = state.mesh.make_room_for(count, many).map_err(BuildError::from)?;
        let marks = || rayon::join(|| state.marks.grow(slots), || reserved.grow(slots));
        rayon::join(|| keys.grow(slots), marks);
        let (candidates, cavities) = (&*candidates, &*cavities);
        let chosen = |k: usize| {
            let Candidate { place, cavity, .. } = &candidates[stage[k]];
            let is_fixed = place.carrier != Carrier::Free;
            Chosen { p: place.p, cavity: &cavities[cavity.clone()], is_fixed }
        };
        // Tetrahedra near small angles that points cannot help are found with the whole mesh.
        let bounds = own.bounds.as_ref().filter(|_| state.angles.is_empty());
        let marks = &state.marks;
        let follow = Update { candidates, stage, marks, reserved, keys, bounds };
        let Memory { lanes, kept } = lanes;
        kept.resize_with(kept.len().max(many), Kept::default);
        let batch = Batch { number: inserted.next_number, count, chosen: &chosen };
        let (first, put_off) = state.mesh.fill_in_lanes(lanes, batch, &follow, &mut kept[..many]);
        for &k in stage {
            let carrier = candidates[k].place.carrier;
            state.carriers.push(carrier);
            inserted.points.count(carrier);
        }
        inserted.next_number += count as u32;
        let looks = kept.iter().map(|own| own.looks).max().unwrap_or(0);
        self.keys.pass_looks(looks);
        self.reserved.pass_looks(looks);
        let (thin, mut missed) = (&mut inserted.thin.tets, Vec::new());
        let mut bad = self.keys.take();
        for own in kept {
            own.looks = 0;
            bad.append(&mut own.bad);
            thin.append(&mut own.thin);
            self.created.append(&mut own.created);
            missed.append(&mut own.missed);
        }
        self.keys.put(bad);
        let vertex = |k: usize| VertexId::at(first.index() + k);
        let mut others = put_off.iter().peekable();
        for (k, &own) in stage.iter().enumerate() {
            if others.next_if_eq(&&k).is_none() && !self.is_inner(own) {
                self.take_boundary(own, vertex(k));
            }
        }
        missed.into_iter().for_each(|item| self.own.state.miss(item, &mut self.nothing));
        for k in put_off {
            self.insert_one(stage[k], Some(vertex(k)))?;
        }
        self.look_at_created();
        Ok(())
    }

    /// Brings tables up to date after the insertion of a boundary candidate's point.
    fn take_boundary(&mut self, k: usize, v: VertexId) {
        let Candidate { item, ref filling, .. } = self.choice.candidates[k];
        debug_assert!(filling.lost.is_empty());
        self.own.state.enter_filling(v, filling);
        self.demands.remove(&item);
        self.own.record.limits.remove(&item);
    }
}
