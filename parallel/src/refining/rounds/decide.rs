//! The end of the choice: each home decides alone for its own candidates, from the rivals that the
//! owners of their closures tell of.

use super::candidate::{ChosenPoint, Outcome, Waits, What};
use super::demands::Pending;
use super::source::{Rounds, Stage};
use crate::mesh::{WireVertex, made};
use crate::protocol::{Rules, WorkerId};
use crate::refining::domain::{DomainMesh, DomainPoint, WallRegion};
use crate::refining::news::{DomainNews, WireItem, WireLimit, point, rival, rival_byte};
use ltbw_core::topology::TetId;
use ltbw_refine::{BoundaryItem, Carrier, Filled, Limit};

impl<C: Rules> Rounds<C> {
    /// All cavities are reserved: rivals are told of, and the points chosen that wait for none.
    pub(super) fn begin_to_decide(&mut self, mesh: &mut DomainMesh<'_>) {
        if self.choice.fates.is_some() {
            return self.carry_out_fates(mesh);
        }
        self.stage = Stage::Deciding;
        for probe in self.served.reserve_others::<C>(mesh) {
            let rivals = self.served.rivals::<C>(mesh, probe);
            let rivals = match rivals.iter().any(|rival| rival.is_there) {
                true => rivals.iter().map(rival_byte).collect(),
                false => Vec::new(),
            };
            self.send(probe.home, DomainNews::Rivals { number: probe.number, rivals });
        }
        self.choice.open = self.choice.probes.len();
        for k in 0..self.choice.probes.len() as u32 {
            if self.is_due(k) {
                self.decide(mesh, k);
            }
        }
    }

    /// An owner tells of the rivals in its part.
    pub(super) fn take_rivals(&mut self, from: WorkerId, k: u32, rivals: &[u8]) {
        let Some(told) = &mut self.choice.probes[k as usize].told else { return };
        told.due -= 1;
        told.add_rivals(from, rivals.iter().copied().map(rival));
    }

    /// Has a probe all that its decision takes?
    pub(super) fn is_due(&self, k: u32) -> bool {
        self.choice.probes[k as usize].told.as_ref().is_none_or(|told| told.due == 0)
    }

    /// Decides what becomes of a probe.
    pub(super) fn decide(&mut self, mesh: &mut DomainMesh<'_>, k: u32) {
        self.choice.open -= 1;
        match self.yields(mesh, k) {
            true => self.choice.probes[k as usize].outcome = Outcome::Dropped,
            false => self.carry_out(mesh, k),
        }
    }

    /// Does a candidate yield to others before it?
    fn yields(&mut self, mesh: &DomainMesh<'_>, k: u32) -> bool {
        let (me, id) = (self.me, self.id(k));
        let probe = &mut self.choice.probes[k as usize];
        if probe.follows {
            return false;
        }
        // One that is killed waits for what becomes of its place.
        if let What::Tet(t, _) = probe.what
            && self.served.has_rival::<C>(mesh, id, t, &probe.rank())
        {
            return true;
        }
        let Some(waits) = probe.waits.take() else { return false };
        match (&*waits, &mut probe.told) {
            (Waits::Here(watch, all), _) => {
                // Rivals that matter anywhere are boundary items: to a tetrahedron by the rule, to
                // an item since nothing else comes before it.
                let all = self.served.cavity_at(all).iter().copied();
                let all = all.filter(|&t| self.served.reserved.may_be_boundary(t));
                watch.yields(all, self.served.rival::<C>(mesh, id))
            }
            (Waits::Told(watch), Some(told)) => {
                told.add_rivals(me, self.served.rivals::<C>(mesh, id));
                watch.yields(0..told.rivals.len(), |place| told.rivals[place])
            }
            (Waits::Told(_), None) => false,
        }
    }

    /// Carries out what a probe has found: its point is to be inserted, or another item split.
    pub(super) fn carry_out(&mut self, mesh: &mut DomainMesh<'_>, k: u32) {
        let (me, id) = (self.me, self.id(k));
        let probe = &mut self.choice.probes[k as usize];
        let Filled { gone, relabelled, .. } =
            match std::mem::replace(&mut probe.outcome, Outcome::Dropped) {
                Outcome::Open | Outcome::Dropped => return,
                Outcome::Asks(item, limit) => return self.ask_for(mesh, k, *item, limit),
                Outcome::Refused(reason) => return self.carry_out_refusal(mesh, k, reason),
                Outcome::Fits(filled) => filled,
            };
        let start = match probe.what {
            What::Tet(t, v) => Some((t, v)),
            What::Item(_) => probe.start,
        };
        let class = match probe.carrier {
            Carrier::Segment(..) => 0,
            Carrier::Facet(_) => 1,
            Carrier::Corner(_) | Carrier::Free => 2,
        };
        self.points.by_class[class] += 1;
        let p = point(&probe.to);
        self.points.made += 1;
        let vertex = WireVertex::new(made(me, self.points.made), p);
        let seed = start.map_or(TetId::default(), |(t, _)| t);
        // R28.
        let relabelled = relabelled.iter().filter(|_| C::labels_walls());
        let walls = relabelled.map(WallRegion::of).collect();
        let point = DomainPoint::chosen(vertex, probe.carrier, seed).with_labels(walls);
        let cavity = self.served.inside(id);
        self.points.chosen.push_back(ChosenPoint { point, start, cavity });
        self.touch_blocks(&p);
        for item in gone {
            self.tell_gone(mesh, &item);
        }
    }

    /// A probe's tetrahedron, or item, asks for an item that is to be split before it.
    fn ask_for(&mut self, mesh: &DomainMesh<'_>, k: u32, item: BoundaryItem, limit: Option<Limit>) {
        let place = item.place();
        let (limit, waiter) = match &self.choice.probes[k as usize].what {
            What::Tet(..) => (limit, None),
            What::Item(own) => {
                let own_place = own.place();
                let pending = self.demands.pending.get_mut(&own_place);
                let limit = pending.and_then(|pending| {
                    pending.first = Some(place);
                    pending.limit
                });
                (limit, Some(own_place))
            }
        };
        let keeper = self.keeper(mesh, &item);
        if keeper == self.me {
            let near = match self.choice.probes[k as usize].what {
                What::Tet(t, _) => Some(t),
                What::Item(_) => self.served.cavity(self.id(k)).next(),
            };
            let waiter = waiter.map(|place| (self.me, place));
            return self.demands.asked.push((Pending { item, first: None, limit, near }, waiter));
        }
        let limit = limit.map(WireLimit::new);
        self.counts.asks += 1;
        self.send(keeper, DomainNews::Ask { item: WireItem::new(&item), limit, waiter });
    }

    fn tell_gone(&mut self, mesh: &DomainMesh<'_>, item: &BoundaryItem) {
        self.counts.asks += 1;
        self.send(self.keeper(mesh, item), DomainNews::Gone(item.place()));
    }

    /// The worker that keeps a boundary item while it is to be split: a function of the item.
    pub(super) fn keeper(&self, mesh: &DomainMesh<'_>, item: &BoundaryItem) -> WorkerId {
        let block = mesh.inner.block_at(&item.corners()[0].point);
        WorkerId::new(block.number() / self.blocks_each)
    }
}
