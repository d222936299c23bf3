//! One worker's tetrahedra over their bounds, and which of them come before all around them.
//!
//! The tetrahedra around one are its face neighbours and the face neighbours of these. Where they
//! are another worker's, two exchanges tell: first the ranks of the tetrahedra at interface faces,
//! then whether one around them comes before the one beyond, whose rank is known by now.
//!
//! Only what has changed is looked at and told: interface faces that are new, or have another
//! tetrahedron beyond them, and tetrahedra at interface faces that have a new one beside them. Both
//! workers see a face change in the same round, and forget what they knew of it: no rank, and that
//! nothing behind it comes before, need not be told.
//!
//! Knowledge of tetrahedra here alone is in [`Keys`], as that of the engine with one mesh.

mod told;

use super::ranked::{Own, RankedHere, places_of, rank_of};
use crate::protocol::{BlockId, Handle, Name, Rules};
use crate::refining::domain::{DomainMesh, is_beyond_help};
use crate::refining::flags::Flags;
use ltbw_core::Point;
use ltbw_core::topology::{INFINITE, TetId, VertexId, slot_of, tet_of};
use ltbw_refine::{Keys, Rank, RankLead, Refusal, Solid, ThinTets};
use rustc_hash::FxHashMap;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// An interface face, as seen from here.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Interface {
    t: TetId,
    slot: usize,
    beyond: Handle,
}

/// All that is known of the far face at a place.
#[derive(Clone, Copy, Debug, Default)]
struct Far {
    /// Told by the worker beyond: the rank of its tetrahedron, if that is over its bounds.
    rank: Option<Rank>,
    /// One around its tetrahedron comes before the one here.
    is_beaten: bool,
    /// One here comes before that worker's around its tetrahedron, as it was told last.
    told: bool,
}

/// A tetrahedron that comes before all around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foremost {
    pub(super) t: TetId,
    pub(super) v: [VertexId; 4],
    pub(super) lead: RankLead,
    /// The first of its vertices.
    pub(super) at: Point,
}

/// A tetrahedron that has come and is over its bounds.
#[derive(Clone, Copy, Debug)]
pub(super) struct OverHere {
    pub(super) t: TetId,
    pub(super) key: u64,
}

/// The tetrahedra over their bounds, and what others tell of theirs.
#[derive(Debug, Default)]
pub(super) struct SharedKeys {
    /// The tetrahedra here.
    pub(super) own: Keys,
    /// Tetrahedra that may have tiny dihedral angles.
    thin: ThinTets,
    /// Does the mesh note which interface faces change?
    is_watching: bool,
    /// By place: the interface face there, and what is known of its far face.
    interface: Vec<Option<Interface>>,
    far: Vec<Far>,
    /// By the block beyond: the number of interface faces.
    blocks: BTreeMap<BlockId, usize>,
    /// Places at which something has changed in this round.
    changed: Vec<u32>,
    /// Tetrahedra at interface faces around which something has changed in this round.
    touched: Vec<TetId>,
    /// By slot: the number of interface faces of its tetrahedron.
    counts: Vec<u8>,
    /// Slots whose tetrahedra have such faces.
    beside: Flags,
    /// The slots in `touched`.
    is_touched: Flags,
    /// The memory of news that others have told: about as much is told them.
    spare: Vec<Vec<(Name, u8, Option<Rank>)>>,
    /// Tetrahedra that were refused.
    refused: FxHashMap<Own, Refusal>,
    /// The ones among them whose ranks others may know still.
    withdrawn: Vec<Own>,
    /// Was a tetrahedron over its bounds that splitting does not help?
    has_helpless: bool,
    /// The memory of lists of the foremost ones, of rounds before.
    foremost: [Vec<Foremost>; 2],
}

/// Keeps the memory of news that were heard, of a few, for the next that are told.
pub(super) fn keep<T>(spare: &mut Vec<Vec<T>>, news: Vec<T>) {
    if news.capacity() > 0 && spare.len() < SPARE {
        spare.push(news);
    }
}

/// News at most whose memory is kept.
const SPARE: usize = 32;

impl SharedKeys {
    /// Makes room for all slots.
    fn make_room(&mut self, mesh: &DomainMesh<'_>) {
        let slots = mesh.inner.tets().topology().slots();
        self.own.grow(slots);
        self.counts.resize(slots, 0);
    }

    /// Looks at new tetrahedra.
    pub(super) fn look_at<C: Rules>(&mut self, mesh: &DomainMesh<'_>, tets: &[TetId]) {
        let all = mesh.inner.tets();
        self.make_room(mesh);
        self.own.begin_look();
        tets.iter().for_each(|&t| self.own.forget(t));
        let first = self.own.count();
        let inside = tets.iter().copied().filter_map(|t| {
            let region = mesh.region(t);
            let is_inside = all.is_live(t) && all.vertices(t)[3] != INFINITE && region != 0;
            let corners = || all.vertices(t).map(|v| mesh.point(v));
            is_inside.then(|| Solid { tet: t, corners: corners(), region })
        });
        let mut thin = std::mem::take(&mut self.thin);
        let tell = |t: TetId| thin.tets.push((t, all.vertices(t)));
        for t in mesh.complex.over_among(inside, tell) {
            // One that is told of twice has a key already.
            let carrier = |k: usize| mesh.carrier(all.vertices(t)[k]);
            let is_refused = || self.refused.contains_key(&(t, all.vertices(t)));
            let is_flat = mesh.complex.is_flat(carrier);
            let is_helpless = !is_flat && is_beyond_help(mesh, t);
            self.has_helpless |= is_helpless;
            let is_split = !is_flat && !is_helpless && (self.refused.is_empty() || !is_refused());
            if self.own.at(t) == 0 && is_split {
                let places = places_of::<C>(mesh, all.vertices(t));
                self.own.enter(t, Rank::key_of_tet(places));
            }
        }
        self.thin = thin;
        if !self.blocks.is_empty() {
            for &t in tets.iter().filter(|&&t| all.is_live(t)) {
                for n in all.neighbours(t).map(tet_of) {
                    // Most are at no interface face.
                    if self.is_beside(n) {
                        self.touch(n);
                    }
                }
            }
        }
        self.own.find_witnesses(&RankedHere::<C>::of(mesh), first);
    }

    /// A tetrahedron is refused: it has no rank any more.
    pub(super) fn refuse(&mut self, mesh: &DomainMesh<'_>, own: Own, why: Refusal) {
        // Others insert already.
        if mesh.has(own.0, own.1) {
            // No look so far has found it so.
            self.own.write(own.0, 0, self.own.look() + 1);
            self.withdrawn.push(own);
        }
        self.refused.insert(own, why);
    }

    /// A tetrahedron was refused in rounds before.
    pub(super) fn refuse_again(&mut self, own: Own, why: Refusal) {
        self.refused.insert(own, why);
    }

    /// Why a tetrahedron was refused, if it was.
    pub(super) fn refusal(&self, mesh: &DomainMesh<'_>, t: TetId) -> Option<Refusal> {
        self.refused.get(&(t, mesh.inner.tets().vertices(t))).copied()
    }

    /// Tetrahedra are to leave in a redeal.
    pub(super) fn leave(&mut self, tets: impl Iterator<Item = TetId>) {
        self.own.begin_look();
        tets.for_each(|t| self.own.forget(t));
    }

    /// Tetrahedra have come in a redeal: nothing that was told of interface faces holds any more.
    pub(super) fn come(&mut self, mesh: &DomainMesh<'_>, tets: impl Iterator<Item = TetId>) {
        let Self { own, thin, refused, has_helpless, .. } = std::mem::take(self);
        *self = Self { own, thin, refused, has_helpless, ..Self::default() };
        self.make_room(mesh);
        self.leave(tets);
    }

    /// Enters tetrahedra that have come and are over their bounds.
    pub(super) fn enter_over<C: Rules>(&mut self, mesh: &DomainMesh<'_>, over: &[OverHere]) {
        let first = self.own.count();
        over.iter().for_each(|own| self.own.enter(own.t, own.key));
        self.own.find_witnesses(&RankedHere::<C>::of(mesh), first);
    }

    /// Notes one that has come and may have tiny dihedral angles.
    pub(super) fn enter_thin(&mut self, mesh: &DomainMesh<'_>, t: TetId) {
        self.thin.tets.push((t, mesh.inner.tets().vertices(t)));
    }

    /// Forgets those that are gone; finds the interface faces that are new.
    pub(super) fn start(&mut self, mesh: &mut DomainMesh<'_>) {
        if !self.is_watching {
            self.is_watching = true;
            mesh.inner.watch_far_faces();
        }
        self.changed.clear();
        mesh.inner.take_changed_far_faces(&mut self.changed);
        self.changed.sort_unstable();
        self.changed.dedup();
        let tets = mesh.inner.tets();
        // A tetrahedron that is gone has changed since the last ones were looked at.
        self.own.begin_look();
        self.make_room(mesh);
        let changed = std::mem::take(&mut self.changed);
        let places = changed.last().map_or(0, |&last| last as usize + 1).max(self.far.len());
        self.far.resize_with(places, Far::default);
        self.interface.resize(places, None);
        for &place in &changed {
            self.far[place as usize] = Far::default();
            if let Some(old) = self.interface[place as usize].take() {
                self.count_faces(old.t, |count| count - 1);
                self.touch(old.t);
                self.count(old.beyond.block, |count| count - 1);
            }
            if let Some((far, face, beyond)) = tets.far_at(place) {
                let (t, slot) = (tet_of(face), slot_of(face));
                self.interface[place as usize] = Some(Interface { t, slot, beyond });
                self.count_faces(t, |count| count + 1);
                self.count(beyond.block, |count| count + 1);
                self.touch(t);
                self.own.forget(far);
            }
        }
        self.changed = changed;
        for &t in tets.topology().free_slots() {
            self.own.forget(t);
        }
        if !self.refused.is_empty() {
            self.refused.retain(|&(t, v), _| mesh.has(t, v));
        }
        for (t, _) in self.withdrawn.clone().into_iter().filter(|&(t, v)| mesh.has(t, v)) {
            for near in tets.neighbours(t).map(tet_of).into_iter().chain([t]) {
                if self.is_beside(near) {
                    self.touch(near);
                }
            }
        }
        self.thin.forget_old(|(t, v)| mesh.has(t, v));
        debug_assert!(self.has_all_interface_faces(mesh));
    }

    /// Is a tetrahedron left over its bounds? It may be that none is.
    pub(super) fn may_have_over(&self) -> bool {
        self.has_helpless || !self.refused.is_empty()
    }

    /// The tetrahedra that were refused.
    pub(super) fn refused(&self, mesh: &DomainMesh<'_>) -> Vec<(TetId, Refusal)> {
        let left = self.refused.iter().filter(|((t, v), _)| mesh.has(*t, *v));
        let mut all: Vec<(TetId, Refusal)> = left.map(|(own, why)| (own.0, *why)).collect();
        all.sort_unstable_by_key(|own| own.0);
        all
    }

    /// The tetrahedra that may have tiny dihedral angles.
    pub(super) fn thin(&self, mesh: &DomainMesh<'_>) -> Vec<TetId> {
        let left = self.thin.tets.iter().copied().filter(|&(t, v)| mesh.has(t, v));
        let mut all: Vec<TetId> = left.map(|(t, _)| t).collect();
        // Some are told of twice.
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Notes that something has changed around a tetrahedron at an interface face.
    fn touch(&mut self, t: TetId) {
        if !self.is_touched.has(t.index()) {
            self.is_touched.set(t.index(), true);
            self.touched.push(t);
        }
    }

    /// Has the tetrahedron in a slot an interface face?
    fn is_beside(&self, t: TetId) -> bool {
        self.beside.has(t.index())
    }

    /// Changes the number of interface faces of a tetrahedron.
    fn count_faces(&mut self, t: TetId, change: impl Fn(u8) -> u8) {
        let count = &mut self.counts[t.index()];
        *count = change(*count);
        self.beside.set(t.index(), *count > 0);
    }

    /// Changes the number of interface faces to a block.
    fn count(&mut self, block: BlockId, change: impl Fn(usize) -> usize) {
        let count = self.blocks.entry(block).or_default();
        *count = change(*count);
        if *count == 0 {
            self.blocks.remove(&block);
        }
    }

    /// Are the interface faces known those that there are?
    fn has_all_interface_faces(&self, mesh: &DomainMesh<'_>) -> bool {
        let tets = mesh.inner.tets();
        let known = |place: usize| {
            let there = tets.far_at(place as u32).map(|(_, face, beyond)| Interface {
                t: tet_of(face),
                slot: slot_of(face),
                beyond,
            });
            there == self.interface[place]
        };
        let count = self.interface.iter().flatten().count();
        count == mesh.inner.num_interface_faces() && (0..self.interface.len()).all(known)
    }

    /// Interface faces of which something is to be told.
    pub(super) fn news(&self) -> usize {
        self.changed.len() + self.touched.len()
    }

    /// The rank of a tetrahedron over its bounds.
    pub(super) fn rank<C: Rules>(&self, mesh: &DomainMesh<'_>, t: TetId) -> Option<Rank> {
        (self.own.at(t) != 0).then(|| rank_of::<C>(mesh, mesh.inner.tets().vertices(t)))
    }

    /// The rank that another worker has told of what is beyond the far face in slot `t`.
    fn heard(&self, mesh: &DomainMesh<'_>, t: TetId) -> Option<&Rank> {
        self.far.get(mesh.inner.tets().far_place(t)? as usize)?.rank.as_ref()
    }

    /// Comes the tetrahedron in slot `t`, or the one beyond the far face there, before this rank?
    fn is_before<C: Rules>(&self, mesh: &DomainMesh<'_>, t: TetId, rank: &Rank) -> bool {
        match self.own.at(t) {
            0 => self.heard(mesh, t).is_some_and(|other| other < rank),
            key => compare::<C>(mesh, t, key, rank).is_lt(),
        }
    }

    /// Comes one around the tetrahedron here before the one beyond its interface face?
    fn beats<C: Rules>(&self, mesh: &DomainMesh<'_>, own: &Interface, beyond: &Rank) -> bool {
        let around = mesh.inner.tets().neighbours(own.t).into_iter().enumerate();
        let mut others = around.filter(|&(slot, _)| slot != own.slot);
        others.any(|(_, face)| self.is_before::<C>(mesh, tet_of(face), beyond))
    }

    /// The tetrahedra that come before all around them: those at interface faces, and the others.
    /// `take_back` is given the lists when they are done with.
    pub(super) fn foremost<C: Rules>(&mut self, mesh: &DomainMesh<'_>) -> [Vec<Foremost>; 2] {
        let mut all = std::mem::take(&mut self.foremost);
        all.iter_mut().for_each(Vec::clear);
        let mut own = std::mem::take(&mut self.own);
        own.sift(&RankedHere::<C>::of(mesh), |t, key| {
            let is_inner = !self.is_beside(t);
            if !self.is_beaten_from_afar::<C>(mesh, t, key) {
                // All that is read of it is in the cache now.
                let v = mesh.inner.tets().vertices(t);
                let (lead, at) = (RankLead::of_tet(key), mesh.point(v[0]));
                all[usize::from(is_inner)].push(Foremost { t, v, lead, at });
            }
        });
        self.own = own;
        all
    }

    /// Takes the memory of these lists back.
    pub(super) fn take_back(&mut self, foremost: [Vec<Foremost>; 2]) {
        self.foremost = foremost;
    }

    /// Sifts some more entries, so that they have their witnesses when the foremost are found.
    /// Tells of tetrahedra away from interface faces that may be foremost then.
    pub(super) fn sift_ahead<C: Rules>(&mut self, mesh: &mut DomainMesh<'_>, told: &mut Vec<Own>) {
        self.make_room(mesh);
        let mut own = std::mem::take(&mut self.own);
        let count = own.sift_ahead(&RankedHere::<C>::of(mesh), |t| {
            if mesh.inner.tets().is_live(t) && !self.is_by_interface(mesh, t) {
                told.push((t, mesh.inner.tets().vertices(t)));
            }
        });
        self.own = own;
        mesh.count_steps(count as u64 / 2);
    }

    /// Has it or a neighbour an interface face? Of most neither has.
    fn is_by_interface(&self, mesh: &DomainMesh<'_>, t: TetId) -> bool {
        let around = mesh.inner.tets().neighbours(t).map(tet_of);
        around.into_iter().chain([t]).any(|t| self.is_beside(t))
    }

    /// Does one that is another worker's come before one that nothing here comes before?
    fn is_beaten_from_afar<C: Rules>(&self, mesh: &DomainMesh<'_>, t: TetId, key: u64) -> bool {
        let tets = mesh.inner.tets();
        let around = tets.neighbours(t).map(tet_of);
        if !self.is_by_interface(mesh, t) {
            return false;
        }
        let is_before = |rank: &Rank| compare::<C>(mesh, t, key, rank).is_gt();
        around.into_iter().any(|n| match tets.far_place(n) {
            Some(place) => self
                .far
                .get(place as usize)
                .is_some_and(|far| far.is_beaten || far.rank.as_ref().is_some_and(is_before)),
            None => {
                let mut faces = tets.neighbours(n).into_iter().map(tet_of);
                faces.any(|u| self.heard(mesh, u).is_some_and(is_before))
            }
        })
    }
}

/// The order of the rank of a tetrahedron over its bounds, which has this key, and another one:
/// mostly by the keys.
fn compare<C: Rules>(mesh: &DomainMesh<'_>, t: TetId, key: u64, rank: &Rank) -> Ordering {
    let whole = || rank_of::<C>(mesh, mesh.inner.tets().vertices(t)).cmp(rank);
    rank.key().cmp(&key).then_with(whole)
}

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests;
