//! A redeal as a worker sees it: what it has beside the mesh goes where the mesh goes.
//!
//! At rest between two rounds that is little. Ranks and what was refused go with tetrahedra, items
//! to be split with those they wait for to their keepers, which are functions of the cuts. What
//! all workers know stays where it is. Of a worker whose item waits for another's neither knows
//! where the other will be: the word says it, and the cargo says it on.

use super::demands::Pending;
use super::keys::OverHere;
use super::pace::{OVER, Part, TET};
use super::source::{Rounds, Stage, Waves};
use crate::mesh::redeal::{Dealt, Leaving, Turned};
use crate::mesh::{Blocks, Mark};
use crate::protocol::{Directory, Rules, SubmeshError, WorkerId};
use crate::refining::domain::{DomainMesh, DomainParcel};
use crate::refining::flags::Flags;
use ltbw_core::topology::{INFINITE, TetId};
use ltbw_exact::Point;
use ltbw_refine::{Asked, ItemPlace, Refusal};
use std::collections::BTreeMap;

/// The words of one worker for another: what lies beyond its interface faces, and where what its
/// items wait for is kept.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Word {
    turned: Vec<Turned>,
    waits: Vec<(ItemPlace, WorkerId)>,
}

/// An item that waits for another one.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
struct Waiter {
    of: ItemPlace,
    keeper: WorkerId,
    place: ItemPlace,
}

/// Tetrahedra and items that go from one worker to another.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Cargo {
    parcel: DomainParcel,
    /// Tetrahedra over their bounds, with their keys.
    over: Vec<(u32, u64)>,
    /// Tetrahedra that may have tiny dihedral angles.
    thin: Vec<u32>,
    refused: Vec<(u32, Refusal)>,
    asked: Vec<Asked>,
    waiters: Vec<Waiter>,
}

/// The bytes of words and cargo beside the mesh, about.
const WAIT: u64 = 80;
const TURNED: u64 = 13;

impl Word {
    pub(super) fn bytes(&self) -> u64 {
        TURNED * self.turned.len() as u64 + WAIT * self.waits.len() as u64
    }
}

impl Cargo {
    /// The number of its tetrahedra.
    pub(super) fn tets(&self) -> u64 {
        self.parcel.len() as u64
    }

    pub(super) fn bytes(&self) -> u64 {
        let items = self.asked.len() + self.refused.len() + 2 * self.waiters.len();
        let parts = self.over.len() * 12 + self.thin.len() * 4;
        self.parcel.bytes() + parts as u64 + WAIT * items as u64
    }
}

impl<C: Rules> Rounds<C> {
    /// The places of the work to come, by their keys along the curve.
    pub(super) fn work(&self, mesh: &DomainMesh<'_>) -> Part {
        let tets = mesh.inner.tets();
        let key = |p: &Point| mesh.inner.key(p);
        let inside = tets.tets().filter(|&(t, v)| v[3] != INFINITE && mesh.region(t) != 0);
        let inside = inside.map(|(t, v)| {
            let more = if self.keys.own.at(t) != 0 { OVER } else { 0 };
            Mark { key: key(&mesh.point(v[0])), weight: TET + more }
        });
        let items = self.demands.pending.values().map(|own| key(&own.item.corners()[0].point));
        Part::of(inside, items)
    }

    /// The cuts are others from now on: the words for other workers.
    pub(super) fn recut(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        cuts: &Blocks,
        directory: &Directory,
    ) -> (Dealt, Vec<(WorkerId, Word)>) {
        let first = self.me.number() * self.blocks_each;
        let own = cuts.stretch(first..first + self.blocks_each);
        let mut dealt = mesh.inner.recut(cuts, directory, own);
        let mut words: BTreeMap<WorkerId, Word> = BTreeMap::new();
        for (to, turned) in std::mem::take(&mut dealt.words) {
            words.entry(to).or_default().turned = turned;
        }
        for (place, waiters) in &self.demands.waiters {
            let Some(own) = self.demands.pending.get(place) else { continue };
            let keeper = self.keeper(mesh, &own.item);
            for &(to, waiter) in waiters {
                words.entry(to).or_default().waits.push((waiter, keeper));
            }
        }
        (dealt, words.into_iter().collect())
    }

    /// Packs what leaves.
    ///
    /// # Errors
    /// [`SubmeshError`] if a word makes no sense, or there is no room.
    pub(super) fn send_off(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        dealt: &Dealt,
        words: Vec<(WorkerId, Word)>,
    ) -> Result<Vec<(WorkerId, Cargo)>, SubmeshError> {
        let (mut turned, mut keepers) = (Vec::new(), BTreeMap::new());
        for (_, word) in words {
            turned.extend(word.turned);
            keepers.extend(word.waits);
        }
        let mut cargos: BTreeMap<WorkerId, Cargo> = BTreeMap::new();
        let mut is_thin = Flags::default();
        self.keys.thin(mesh).into_iter().for_each(|t| is_thin.set(t.index(), true));
        for Leaving { to, tets } in &dealt.leaving {
            let cargo = cargos.entry(*to).or_default();
            for (k, &t) in (0..).zip(tets) {
                let key = self.keys.own.at(t);
                cargo.over.extend((key != 0).then_some((k, key)));
                cargo.thin.extend(is_thin.has(t.index()).then_some(k));
                cargo.refused.extend(self.keys.refusal(mesh, t).map(|why| (k, why)));
            }
        }
        self.keys.leave(dealt.leaving.iter().flat_map(|own| &own.tets).copied());
        for (to, parcel) in mesh.send_off(dealt, turned.into_iter())? {
            cargos.entry(to).or_default().parcel = parcel;
        }
        for (place, Pending { item, first, limit, .. }) in std::mem::take(&mut self.demands.pending)
        {
            let keeper = self.keeper(mesh, &item);
            cargos.entry(keeper).or_default().asked.push(Asked { item, first, limit });
            if let Some((of, &to)) = first.and_then(|of| Some((of, keepers.get(&place)?))) {
                cargos.entry(to).or_default().waiters.push(Waiter { of, keeper, place });
            }
        }
        Ok(cargos.into_iter().collect())
    }

    /// Counts the tetrahedra that have come.
    pub(super) fn count_moved(&mut self, came: u64) {
        self.figures.moved += came;
    }

    /// Takes in what comes.
    ///
    /// # Errors
    /// [`SubmeshError`] if a parcel makes no sense, or there is no room.
    pub(super) fn unpack(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        cargos: Vec<(WorkerId, Cargo)>,
        directory: &Directory,
    ) -> Result<(), SubmeshError> {
        let parcels: Vec<&DomainParcel> = cargos.iter().map(|(_, own)| &own.parcel).collect();
        let slots = mesh.unpack(&parcels, directory)?;
        self.keys.come(mesh, slots.iter().flatten().copied());
        self.demands.waiters.clear();
        let mut over = Vec::new();
        for ((_, cargo), slots) in cargos.into_iter().zip(&slots) {
            let slot = |k: u32| {
                let unknown =
                    SubmeshError::Unknown { what: "a tetrahedron of the cargo", number: k };
                slots.get(k as usize).copied().ok_or(unknown)
            };
            for (k, key) in cargo.over {
                over.push(OverHere { t: slot(k)?, key });
            }
            for k in cargo.thin {
                self.keys.enter_thin(mesh, slot(k)?);
            }
            for (k, why) in cargo.refused {
                let t: TetId = slot(k)?;
                self.keys.refuse_again((t, mesh.inner.tets().vertices(t)), why);
            }
            for Asked { item, first, limit } in cargo.asked {
                let own = Pending { item, first, limit, near: None };
                self.demands.pending.insert(item.place(), own);
            }
            for Waiter { of, keeper, place } in cargo.waiters {
                self.demands.waiters.entry(of).or_default().push((keeper, place));
            }
        }
        self.keys.enter_over::<C>(mesh, &over);
        Ok(())
    }

    /// The cuts were looked at, and have moved or not.
    pub(super) fn have_looked(&mut self, have_moved: bool) {
        self.pace.looked(self.figures.rounds[0], have_moved);
        self.figures.redeals += u64::from(have_moved);
    }

    /// The next round begins, and nothing of the one before is left.
    pub(super) fn begin_again(&mut self) {
        self.stage = Stage::Counting;
        self.waves = Waves::new(self.me, self.workers);
        self.exchange = Default::default();
        self.choice = Default::default();
        self.conductor = Default::default();
        // Nothing counted is under way.
        self.counts = Default::default();
        self.ahead.clear();
        self.created.clear();
        self.ending = None;
    }
}
