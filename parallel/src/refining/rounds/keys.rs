//! One worker's tetrahedra over their bounds, and which of them come before all around them.
//!
//! The tetrahedra around one are its face neighbours and the face neighbours of these. Where they
//! are another worker's, two exchanges tell: first the ranks of the tetrahedra at interface faces,
//! then the best rank around each of these.
//!
//! Only what has changed is told. A tetrahedron at an interface face has a name that no other ever
//! has, so that what was told of the face stays true of it, or is told anew.
//!
//! Witnesses are remembered from round to round, as by the engine with one mesh (`sift`).

use crate::protocol::{Directory, Handle, Name, Rules, Submesh, WorkerId};
use crate::refining::domain::DomainMesh;
use ltbw_core::topology::{INFINITE, TetId, VertexId, slot_of, tet_of};
use ltbw_core::{Point, expect, prefetch};
use ltbw_domain::refine::{Bad, Rank, Ranked, sift, witness};
use rustc_hash::FxHashMap;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::marker::PhantomData;

/// The news for each worker at an interface face: its tetrahedron and face, and a rank.
pub(super) type Told = BTreeMap<WorkerId, Vec<(Name, u8, Option<Rank>)>>;

/// An interface face, as seen from here.
#[derive(Clone, Copy, Debug)]
struct Interface {
    t: TetId,
    slot: usize,
    beyond: Handle,
}

/// A tetrahedron that comes before all around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foremost {
    pub(super) t: TetId,
    pub(super) v: [VertexId; 4],
    pub(super) rank: Rank,
    /// The first of its vertices.
    pub(super) at: Point,
}

/// A tetrahedron over its bounds at or near an interface face: one here, as of a look, or another
/// worker's.
#[derive(Clone, Copy, Debug, PartialEq)]
enum One {
    Here(TetId, u32),
    There(Rank),
}

/// The round in which something was told of a face, and what.
type ToldOnce = (u32, Option<One>);

/// The tetrahedra over their bounds.
#[derive(Debug, Default)]
pub(super) struct Keys {
    /// By slot: the leading part of its tetrahedron's rank, 0 if that is within its bounds.
    keys: Vec<u64>,
    /// By slot: the look at which its tetrahedron was new, or had gone.
    stamps: Vec<u32>,
    /// Looks so far, of which a round may have several.
    look: u32,
    round: u32,
    bad: Vec<Bad>,
    /// By own tetrahedron and face: the rank beyond, and the best one around that.
    beyond: [FxHashMap<(Name, u8), Rank>; 2],
    /// By other worker's tetrahedron and face: in which round it was told last, and what. Only what
    /// was told in the last round is sure to be known there: another worker may have told since.
    told: [FxHashMap<(Name, u8), ToldOnce>; 2],
    interface: Vec<Interface>,
    /// By slot: has its tetrahedron an interface face?
    is_beside: Vec<bool>,
}

/// The places by which a tetrahedron with these corners is ranked.
#[inline(always)]
fn places_of<C: Rules>(mesh: &DomainMesh<'_>, corners: [VertexId; 4]) -> [Point; 4] {
    // R22.
    match C::RANKS_BY_PLACE {
        true => corners.map(|v| mesh.point(v)),
        false => corners.map(|v| [f64::from(v.number()), 0.0, 0.0]),
    }
}

/// The rank of a tetrahedron with these corners.
fn rank_of<C: Rules>(mesh: &DomainMesh<'_>, corners: [VertexId; 4]) -> Rank {
    Rank::of_tet(places_of::<C>(mesh, corners))
}

impl Keys {
    /// Takes memory for about this many tetrahedra. A hint.
    pub(super) fn expect_tets(&mut self, tets: usize) {
        expect(&mut self.keys, tets);
        expect(&mut self.stamps, tets);
    }

    /// Looks at new tetrahedra.
    pub(super) fn look_at<C: Rules>(&mut self, mesh: &DomainMesh<'_>, tets: &[TetId]) {
        let all = mesh.inner.tets();
        let slots = all.topology().slots();
        self.keys.resize(slots, 0);
        self.stamps.resize(slots, 0);
        self.look += 1;
        for &t in tets {
            self.keys[t.index()] = 0;
            self.stamps[t.index()] = self.look;
        }
        let first = self.bad.len();
        let inside = tets.iter().copied().filter_map(|t| {
            let region = mesh.region(t);
            let is_inside = all.is_live(t) && all.vertices(t)[3] != INFINITE && region != 0;
            is_inside.then(|| (t, all.vertices(t).map(|v| mesh.point(v)), region))
        });
        for t in mesh.complex.over_among(inside) {
            // One that is told of twice has a key already.
            if self.keys[t.index()] == 0 {
                let places = places_of::<C>(mesh, all.vertices(t));
                self.keys[t.index()] = Rank::key_of_tet(places);
                self.bad.push(Bad::new(t, self.look));
            }
        }
        // They are in the cache; a witness of now may be one when the round is over.
        for k in first..self.bad.len() {
            if let Some(next) = self.bad.get(k + 2) {
                let around = all.neighbours(next.t).map(tet_of);
                around
                    .into_iter()
                    .for_each(|t| prefetch(self.keys.as_ptr().wrapping_add(t.index())));
            }
            if let Some(witness) = self.ranked::<C>(mesh).one_before(self.bad[k].t) {
                self.bad[k].witness = witness;
            }
        }
    }

    /// Forgets those that are gone; finds the interface faces.
    pub(super) fn start(&mut self, mesh: &DomainMesh<'_>) {
        let tets = mesh.inner.tets();
        let topology = tets.topology();
        // A tetrahedron that is gone has changed since the last ones were looked at.
        self.look += 1;
        for own in self.interface.drain(..) {
            self.is_beside[own.t.index()] = false;
        }
        self.is_beside.resize(topology.slots(), false);
        for (face, beyond) in tets.far_faces() {
            let (t, slot) = (tet_of(face), slot_of(face));
            self.interface.push(Interface { t, slot, beyond });
            self.is_beside[t.index()] = true;
            self.forget(tet_of(topology.at(t).neighbours()[slot]));
        }
        for &t in topology.free_slots() {
            self.forget(t);
        }
        // Names of tetrahedra that are gone are never asked for again.
        let most = 4 * self.interface.len() + 1024;
        if self.beyond.iter().any(|beyond| beyond.len() > most) {
            let is_here = |&(name, _): &(Name, u8)| mesh.resolve(name).is_some();
            self.beyond.iter_mut().for_each(|beyond| beyond.retain(|at, _| is_here(at)));
        }
        if self.told.iter().any(|told| told.len() > most) {
            let last = self.round;
            self.told.iter_mut().for_each(|told| told.retain(|_, own| own.0 == last));
        }
        self.round += 1;
    }

    /// There is no tetrahedron in a slot.
    fn forget(&mut self, t: TetId) {
        self.keys[t.index()] = 0;
        self.stamps[t.index()] = self.look;
    }

    /// Interface faces.
    pub(super) fn interface_faces(&self) -> usize {
        self.interface.len()
    }

    /// The rank of a tetrahedron over its bounds.
    pub(super) fn rank<C: Rules>(&self, mesh: &DomainMesh<'_>, t: TetId) -> Option<Rank> {
        let is_over = self.keys[t.index()] != 0;
        is_over.then(|| rank_of::<C>(mesh, mesh.inner.tets().vertices(t)))
    }

    /// The tetrahedron over its bounds in slot `t`.
    fn one_at(&self, t: TetId) -> Option<One> {
        (self.keys[t.index()] != 0).then(|| One::Here(t, self.stamps[t.index()]))
    }

    /// The same, or the one beyond face `slot` of `from`, if `t` stands for that.
    fn one_beside(&self, mesh: &DomainMesh<'_>, from: TetId, slot: usize, t: TetId) -> Option<One> {
        self.one_at(t).or_else(|| {
            mesh.inner.tets().far(t)?;
            self.told_beyond(mesh, 0, from, slot).map(One::There)
        })
    }

    /// The rank told of a face of tetrahedron `t` in an exchange.
    fn told_beyond(
        &self,
        mesh: &DomainMesh<'_>,
        exchange: usize,
        t: TetId,
        slot: usize,
    ) -> Option<Rank> {
        let name = mesh.inner.tets().tag_of(t)?;
        self.beyond[exchange].get(&(name, slot as u8)).copied()
    }

    fn rank_of_one<C: Rules>(&self, mesh: &DomainMesh<'_>, one: One) -> Option<Rank> {
        match one {
            One::Here(t, _) => self.rank::<C>(mesh, t),
            One::There(rank) => Some(rank),
        }
    }

    /// The one that comes before others.
    fn best<C: Rules>(&self, mesh: &DomainMesh<'_>, all: impl Iterator<Item = One>) -> Option<One> {
        let key = |one: &One| match one {
            One::Here(t, _) => self.keys[t.index()],
            One::There(rank) => rank.key(),
        };
        all.reduce(|one, other| {
            let is_after = match key(&other).cmp(&key(&one)) {
                Ordering::Equal => {
                    self.rank_of_one::<C>(mesh, other) >= self.rank_of_one::<C>(mesh, one)
                }
                order => order == Ordering::Less,
            };
            if is_after { one } else { other }
        })
    }

    /// The news for others in an exchange, an entry for each worker that has a tetrahedron beside
    /// one of this worker.
    pub(super) fn told<C: Rules>(
        &mut self,
        mesh: &DomainMesh<'_>,
        directory: &Directory,
        exchange: usize,
    ) -> Told {
        let mut news = Told::new();
        let mut told = std::mem::take(&mut self.told[exchange]);
        for &Interface { t, slot, beyond } in &self.interface {
            let entry = news.entry(directory.owner(beyond.block)).or_default();
            let one = match exchange {
                0 => self.one_at(t),
                _ => {
                    let around = mesh.inner.tets().neighbours(t).into_iter().enumerate();
                    let others = around.filter(|&(k, _)| k != slot);
                    let all =
                        others.filter_map(|(k, face)| self.one_beside(mesh, t, k, tet_of(face)));
                    self.best::<C>(mesh, all)
                }
            };
            let at = (beyond.name, beyond.face);
            if told.insert(at, (self.round, one)) != Some((self.round - 1, one)) {
                let rank = one.and_then(|one| self.rank_of_one::<C>(mesh, one));
                entry.push((beyond.name, beyond.face, rank));
            }
        }
        self.told[exchange] = told;
        news
    }

    /// Takes what another worker tells.
    pub(super) fn hear(&mut self, exchange: usize, keys: Vec<(Name, u8, Option<Rank>)>) {
        for (name, face, rank) in keys {
            match rank {
                Some(rank) => _ = self.beyond[exchange].insert((name, face), rank),
                None => _ = self.beyond[exchange].remove(&(name, face)),
            }
        }
    }

    /// The tetrahedra that come before all around them: those at interface faces, and the others.
    pub(super) fn foremost<C: Rules>(&mut self, mesh: &DomainMesh<'_>) -> [Vec<Foremost>; 2] {
        let mut all: [Vec<Foremost>; 2] = Default::default();
        let mut bad = std::mem::take(&mut self.bad);
        let kept = sift(&mut bad, self.look, &self.ranked::<C>(mesh), |t| {
            let is_inner = !self.is_beside[t.index()];
            if !self.is_beaten_from_afar::<C>(mesh, t) {
                // All that is read of it is in the cache now.
                let v = mesh.inner.tets().vertices(t);
                let (rank, at) = (rank_of::<C>(mesh, v), mesh.point(v[0]));
                all[usize::from(is_inner)].push(Foremost { t, v, rank, at });
            }
        });
        bad.truncate(kept);
        self.bad = bad;
        all
    }

    /// The tetrahedra here, by their ranks.
    fn ranked<'k, 'c, C: Rules>(&'k self, mesh: &'k DomainMesh<'c>) -> RankedHere<'k, 'c, C> {
        RankedHere { keys: self, mesh, rules: PhantomData }
    }

    /// Does one that is another worker's come before one that nothing here comes before?
    fn is_beaten_from_afar<C: Rules>(&self, mesh: &DomainMesh<'_>, t: TetId) -> bool {
        let tets = mesh.inner.tets();
        let around = tets.neighbours(t).map(tet_of);
        // Of most neither it nor a neighbour has an interface face.
        if !around.iter().chain([&t]).any(|t| self.is_beside[t.index()]) {
            return false;
        }
        let told =
            |exchange: usize, t: TetId, slot: usize| self.told_beyond(mesh, exchange, t, slot);
        let mut best = None::<Rank>;
        let mut meet = |rank: Option<Rank>| best = [best, rank].into_iter().flatten().min();
        for (slot, n) in around.into_iter().enumerate() {
            if tets.far(n).is_some() {
                meet(told(0, t, slot));
                meet(told(1, t, slot));
                continue;
            }
            for (k, face) in tets.neighbours(n).into_iter().enumerate() {
                if tets.far(tet_of(face)).is_some() {
                    meet(told(0, n, k));
                }
            }
        }
        best.is_some_and(|best| self.rank::<C>(mesh, t).is_some_and(|own| best < own))
    }
}

/// A worker's tetrahedra by their ranks. Others' count for nothing.
struct RankedHere<'k, 'c, C> {
    keys: &'k Keys,
    mesh: &'k DomainMesh<'c>,
    rules: PhantomData<C>,
}

impl<C: Rules> RankedHere<'_, '_, C> {
    /// Does one tetrahedron come before another one with the same key?
    #[cold]
    #[inline(never)]
    fn is_first_by_place(&self, one: TetId, other: TetId) -> bool {
        self.keys.rank::<C>(self.mesh, one) < self.keys.rank::<C>(self.mesh, other)
    }
}

impl<C: Rules> Ranked for RankedHere<'_, '_, C> {
    #[inline(always)]
    fn stamp(&self, t: TetId) -> u32 {
        self.keys.stamps[t.index()]
    }

    #[inline(always)]
    fn neighbours(&self, t: TetId) -> [TetId; 4] {
        self.mesh.inner.tets().neighbours(t).map(tet_of)
    }

    #[inline(always)]
    fn prefetch(&self, t: TetId) {
        self.mesh.inner.tets().topology().prefetch(t);
        prefetch(self.keys.keys.as_ptr().wrapping_add(t.index()));
    }

    #[inline(always)]
    fn one_before(&self, t: TetId) -> Option<[TetId; 2]> {
        let (keys, key) = (&self.keys.keys, self.keys.keys[t.index()]);
        // The slot of a far face has no key, or while points are inserted one of before: a witness
        // that `start` forgets.
        let is_before = |&one: &TetId| {
            let other = keys[one.index()];
            // R26.
            (other > key && (C::BREAKS_TIES || !Rank::is_tie(other, key)))
                || other == key && one != t && self.is_first_by_place(one, t)
        };
        let around = |way: TetId| self.mesh.inner.tets().is_live(way).then(|| self.neighbours(way));
        witness(t, self.neighbours(t), around, is_before)
    }
}
