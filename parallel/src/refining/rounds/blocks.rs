//! Blocks between workers: all keep the same ones, by coordinates. The worker that finds one tells
//! all before the choice ends, and one whose point takes a tetrahedron beside one away tells all
//! before the next.
//!
//! When all probes have ended, the foremost tetrahedra that were not probed are asked whether a
//! block bars them: the choice has a second part then.

use super::barriers::Barriers;
use super::candidate::{Outcome, What};
use super::ranked::Own;
use super::source::{Rounds, Stage};
use crate::protocol::{Rules, WorkerId};
use crate::refining::domain::DomainMesh;
use crate::refining::news::{DomainNews, Fate, PartEnd, ProbeId, bits, point};
use ltbw_core::Point;
use ltbw_refine::{Aim, Block, Blocks, ItemPlace, KeptBlock, RankLead, Reason};

/// A block of which no more is known than what it is.
fn kept(block: Block) -> KeptBlock<()> {
    KeptBlock { block, here: () }
}

impl<C: Rules> Rounds<C> {
    /// Blocks that others have left.
    pub(super) fn resume_blocks(&mut self, left: &[Block]) {
        self.barriers.all = Blocks::of(left.iter().cloned().map(kept).collect());
    }

    /// A round that splits tetrahedra begins: forgets blocks whose subfaces may be split by now.
    pub(super) fn check_blocks(&mut self) {
        let refused = &self.demands.refused.all;
        self.barriers.all.retain(|own| refused.contains_key(&own.block.place()));
        self.barriers.followers.clear();
    }

    /// The foremost tetrahedra of which the conductor says that they are not probed.
    pub(super) fn note_followers(&mut self, fates: &[Fate]) {
        let all = fates.iter().zip(&self.choice.current);
        let tets = all.filter(|own| *own.0 == Fate::Follows).filter_map(|(_, &k)| {
            match self.choice.probes[k as usize].what {
                What::Tet(t, v) => Some((t, v)),
                What::Item(_) => None,
            }
        });
        self.barriers.followers = tets.collect();
    }

    /// The reason why a tetrahedron with a point is refused, if a block bars it.
    fn barred(&self, mesh: &DomainMesh<'_>, own: Own, p: &Point) -> Option<Reason> {
        if self.barriers.all.kept().is_empty() {
            return None;
        }
        let what = What::Tet(own.0, own.1);
        let past = what.under_limit(mesh, &self.past(&what));
        let near = || mesh.complex.reason_near(own.1.map(|v| mesh.corner(v)));
        let bars = |own: &KeptBlock<()>| past.bars(own.block.place());
        self.barriers.all.refuse(|own| own.block.is_lost_to(p), bars, near)
    }

    /// Notes whether a block bars the tetrahedron of a probe, whose point is known.
    pub(super) fn note_barred(&mut self, mesh: &DomainMesh<'_>, k: u32) {
        let probe = &self.choice.probes[k as usize];
        if let What::Tet(t, v) = probe.what
            && !probe.follows
        {
            let reason = self.barred(mesh, (t, v), &point(&probe.to));
            self.choice.probes[k as usize].barred = reason;
        }
    }

    /// Is a probe one of this worker, for a tetrahedron that a block bars?
    pub(super) fn is_barred(&self, probe: ProbeId) -> bool {
        let own = || self.choice.probes.get(probe.number as usize);
        probe.home == self.me && own().is_some_and(|own| own.barred.is_some())
    }

    /// The way of a probe for a tetrahedron that a block bars, or that follows another one, has
    /// ended: it is refused if the way has come to the point. Was it one?
    pub(super) fn end_barred(
        &mut self,
        mesh: &DomainMesh<'_>,
        from: WorkerId,
        k: u32,
        end: &PartEnd,
    ) -> bool {
        let me = self.me;
        let probe = &mut self.choice.probes[k as usize];
        match (end, probe.barred) {
            (PartEnd::Found | PartEnd::Vertex, Some(reason)) => {
                if from != me {
                    probe.told.get_or_insert_default().owners.push(from);
                }
                self.drop_parts(k);
                self.refuse(mesh, k, reason);
            }
            _ if probe.follows => self.conclude(k, Outcome::Dropped),
            _ => return false,
        }
        true
    }

    /// A refusal has left blocks behind: tells all.
    pub(super) fn tell_blocks(&mut self, blocks: &[Block]) {
        self.take_blocks(blocks.to_vec());
        // R32.
        if blocks.is_empty() || !C::shares_blocks() {
            return;
        }
        self.counts.notes += self.send_to_others(&DomainNews::Blocks(blocks.to_vec()));
    }

    pub(super) fn take_blocks(&mut self, blocks: Vec<Block>) {
        self.barriers.all.note(blocks.into_iter().map(kept));
    }

    /// All probes have ended, and there are `followers` in all: those here that a block bars are
    /// looked at. Does the choice go on with that?
    pub(super) fn begins_second(&mut self, mesh: &DomainMesh<'_>, followers: i64) -> bool {
        if std::mem::take(&mut self.barriers.is_second) {
            return false;
        }
        // Of rounds that split tetrahedra alone.
        if self.choice.foremost.is_none() || !self.barriers.all.keep() || followers == 0 {
            return false;
        }
        self.barriers.is_second = true;
        for (t, v) in std::mem::take(&mut self.barriers.followers) {
            let Aim::At { point: p, carrier, may: true } =
                mesh.complex.aim_at_tet(v.map(|v| mesh.point(v)), 0)
            else {
                continue;
            };
            let Some(reason) = self.barred(mesh, (t, v), &p) else { continue };
            let k = self.add_probe(What::Tet(t, v), RankLead::of_tet(0), 0);
            let probe = &mut self.choice.probes[k as usize];
            (probe.to, probe.carrier, probe.may) = (bits(&p), carrier, true);
            (probe.follows, probe.barred) = (true, Some(reason));
            self.choice.to_launch.push_back(k);
        }
        true
    }

    /// A point is chosen: notes the blocks beside which it takes tetrahedra away.
    pub(super) fn touch_blocks(&mut self, p: &Point) {
        let Barriers { all, touched, .. } = &mut self.barriers;
        let kept = all.kept().iter().map(|own| &own.block);
        touched.extend(kept.filter(|own| own.is_touched_by(p)).map(Block::place));
    }

    /// The points of a round are in: tells all which blocks are no more.
    pub(super) fn tell_touched(&mut self) {
        let touched: Vec<ItemPlace> = self.barriers.touched.drain().collect();
        self.forget_blocks(&touched);
        // R33.
        if touched.is_empty() || !C::forgets_blocks() {
            return;
        }
        self.counts.releases += self.send_to_others(&DomainNews::Unblocked(touched));
    }

    pub(super) fn forget_blocks(&mut self, touched: &[ItemPlace]) {
        self.barriers.all.retain(|own| !touched.contains(&own.block.place()));
    }

    /// The blocks that are left.
    pub(super) fn blocks_left(&self) -> Vec<Block> {
        self.barriers.all.kept().iter().map(|own| own.block.clone()).collect()
    }

    /// The refusals of tetrahedra that follow others are carried out, whoever is in their place.
    pub(super) fn refuse_followers(&mut self, mesh: &mut DomainMesh<'_>) {
        debug_assert_eq!(self.stage, Stage::Deciding);
        for k in 0..self.choice.probes.len() as u32 {
            if self.choice.probes[k as usize].follows {
                self.carry_out(mesh, k);
            }
        }
    }
}
