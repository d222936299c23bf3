//! One worker's part in the rounds: what it knows, what it is told, and the points that it gives.

use super::barriers::Barriers;
use super::borrowed::Circles;
use super::candidate::{ChosenPoint, Probe};
use super::contest::Conductor;
use super::demands::{Demands, Pending};
use super::figures::{Ending, RoundFigures};
use super::found::Ahead;
use super::keys::{Foremost, SharedKeys};
use super::mail::Mail;
use super::pace::Pace;
use super::serve::{Answer, Served};
use super::tree::Tree;
use super::tried::Slivers;
use super::under_way::Counts;
pub(super) use super::under_way::Stage;
use super::way::{Begin, Entry};
use crate::mesh::{Redeal, VertexName};
use crate::protocol::{
    BlockId, Correct, Directory, Item, Rules, Source, Standing, Submesh, WorkerId,
};
use crate::refining::domain::{DomainMesh, DomainPoint};
use crate::refining::news::{DomainNews, Fate, KeysTold, Sums, WireLimit};
use ltbw_core::topology::{TetId, VertexId, tet_of};
use std::collections::{BTreeSet, VecDeque};
use std::marker::PhantomData;

/// New tetrahedra that are looked at together, when it is not all that are left.
const LOOK: usize = 512;

/// Probes that are launched in one step: what they ask others for goes together.
const TOGETHER: usize = 8;

/// The barriers of a worker.
#[derive(Debug)]
pub(super) struct Waves {
    pub(super) tree: Tree,
    /// The sums of the wave before.
    pub(super) before: Option<Sums>,
    /// The sums of a wave that is over, if this worker has not gone on yet.
    pub(super) passed: Option<Sums>,
}

impl Waves {
    /// The barriers of worker `me` before the first round: no operation has been under way.
    pub(super) fn new(me: WorkerId, workers: u32) -> Self {
        Self { tree: Tree::new(me, workers), before: Some(Sums::default()), passed: None }
    }
}

/// The exchanges of keys with the workers beside.
#[derive(Debug, Default)]
pub(super) struct Exchange {
    /// Exchanges so far.
    pub(super) number: u64,
    /// Keys of later exchanges.
    pub(super) early: Vec<(WorkerId, u64, KeysTold)>,
    /// Workers beside that have still to tell.
    pub(super) awaited: BTreeSet<WorkerId>,
}

/// The choice of a round.
#[derive(Debug, Default)]
pub(super) struct Choice {
    /// The number of tetrahedra that come before all around them, if this round splits such.
    pub(super) foremost: Option<i64>,
    /// Does it split boundary items?
    pub(super) has_boundary: bool,
    pub(super) probes: Vec<Probe>,
    /// Probes to launch.
    pub(super) to_launch: VecDeque<u32>,
    /// The slot where the last probe for a boundary item has ended here.
    pub(super) near: Option<TetId>,
    /// Probes under way, or to be decided.
    pub(super) open: usize,
    /// Probes whose points may be inserted, unless others are in their way.
    pub(super) fits: i64,
    /// If candidates have turns: what becomes of them, once the conductor has told.
    pub(super) fates: Option<Option<Vec<Fate>>>,
    /// If the conductor is to tell which of these are probed: the foremost tetrahedra.
    pub(super) entered: Option<Vec<Foremost>>,
    /// By the number of an entrant: its probe, of the last attempt.
    pub(super) current: Vec<u32>,
}

/// The points that a worker gives in a round.
#[derive(Debug, Default)]
pub(super) struct Points {
    pub(super) chosen: VecDeque<ChosenPoint>,
    /// The tetrahedra that points chosen in this round begin at, by their names from `first` on.
    pub(super) starts: Vec<Start>,
    pub(super) first: VertexName,
    /// The number of points chosen in this round, by class.
    pub(super) by_class: [i64; 3],
    /// Vertices named so far: no mesh has as many as there are names.
    pub(super) made: u32,
}

/// The sizes of rounds that all workers know.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Budget {
    /// The candidates among the tetrahedra when last counted.
    pub(super) counted: i64,
    /// Points inserted so far, by all, those before the rounds included.
    pub(super) total: i64,
    pub(super) most: i64,
    /// The other vertices.
    pub(super) others: i64,
}

/// A worker among all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Among {
    pub(super) me: WorkerId,
    pub(super) workers: u32,
    /// Blocks of every worker at the start.
    pub(super) blocks_each: u32,
}

/// One worker's part in rounds.
#[derive(Debug)]
pub struct Rounds<C = Correct> {
    pub(super) me: WorkerId,
    pub(super) workers: u32,
    /// Blocks of every worker at the start.
    pub(super) blocks_each: u32,
    pub(super) stage: Stage,
    pub(super) waves: Waves,
    pub(super) exchange: Exchange,
    pub(super) keys: SharedKeys,
    /// Cavities found for the next choice.
    pub(super) ahead: Ahead,
    pub(super) served: Served,
    pub(super) choice: Choice,
    pub(super) points: Points,
    pub(super) demands: Demands,
    pub(super) barriers: Barriers,
    pub(super) circles: Circles,
    pub(super) slivers: Slivers,
    pub(super) conductor: Conductor,
    pub(super) counts: Counts,
    pub(super) mail: Mail,
    pub(super) created: Vec<TetId>,
    pub(super) budget: Budget,
    /// The transactions of joint steps in rounds so far.
    pub(super) spent: usize,
    /// Is a probe of this worker one that rounds do not know what to do with?
    pub(super) is_irregular: bool,
    pub(super) is_cancelled: bool,
    /// The rounds after which the workers stop.
    pub(super) border: Option<u64>,
    /// The times at which the cuts move.
    pub(super) pace: Pace,
    pub(super) ending: Option<Ending>,
    pub(super) figures: RoundFigures,
    pub(super) rules: PhantomData<C>,
}

/// A tetrahedron that a point begins at, and its vertices.
pub(super) type Start = Option<(TetId, [VertexId; 4])>;

impl<C: Rules> Rounds<C> {
    /// The start of rounds in a submesh; `total` points of `most` were inserted before, and there
    /// are `others`.
    pub(super) fn new(
        Among { me, workers, blocks_each }: Among,
        [total, most, others]: [u64; 3],
        mesh: &DomainMesh<'_>,
    ) -> Self {
        let most = i64::try_from(most).unwrap_or(i64::MAX);
        Self {
            me,
            workers,
            blocks_each,
            stage: Stage::Counting,
            waves: Waves::new(me, workers),
            exchange: Exchange::default(),
            keys: SharedKeys::default(),
            ahead: Ahead::default(),
            served: Served::new(me),
            choice: Choice::default(),
            points: Points::default(),
            demands: Demands::default(),
            barriers: Barriers::default(),
            circles: Circles::default(),
            slivers: Slivers::default(),
            conductor: Conductor::default(),
            counts: Counts::default(),
            mail: Mail::default(),
            created: mesh.inner.tets().tets().map(|(t, _)| t).collect(),
            budget: Budget { counted: 0, total: total as i64, most, others: others as i64 },
            spent: 0,
            is_irregular: false,
            is_cancelled: false,
            border: None,
            pace: Pace::new(Redeal::Never, workers),
            ending: None,
            figures: RoundFigures::default(),
            rules: PhantomData,
        }
    }

    /// Takes memory for about this many tetrahedra. A hint.
    pub(super) fn expect_tets(&mut self, tets: usize) {
        self.keys.own.expect_tets(tets);
        self.served.expect_tets(tets);
    }

    /// Asks the processor to fetch the cavities of the next points to insert. A hint: they may have
    /// changed.
    fn fetch(&self, mesh: &DomainMesh<'_>) {
        let tets = mesh.inner.tets();
        let cavity = |own: &ChosenPoint| self.served.cavity_at(&own.cavity);
        let next = self.points.chosen.get(1).map(cavity).unwrap_or_default();
        next.iter().for_each(|&t| mesh.prefetch(t));
        // The next cavity is in the cache by now: its neighbours are fetched.
        for &t in self.points.chosen.front().map(cavity).unwrap_or_default() {
            tets.neighbours(t).into_iter().for_each(|face| tets.prefetch(tet_of(face)));
        }
    }

    /// Are there many new tetrahedra to look at? One that waits for others looks at few at a time.
    fn has_many_created(&self) -> bool {
        let may = !self.waves.tree.has_put() && !self.circles.are_inserted();
        may && self.created.len() >= LOOK
    }

    /// The number of a point among those chosen in this round; others have numbers beyond.
    fn number(&self, point: &DomainPoint) -> usize {
        point.name().wrapping_sub(self.points.first) as usize
    }

    /// A point is not to begin at its tetrahedron any more.
    fn forget_start(&mut self, point: &DomainPoint) {
        let number = self.number(point);
        self.points.starts.get_mut(number).into_iter().for_each(|start| *start = None);
    }

    /// The vertices of the mesh, as all know.
    pub(super) fn vertices(&self) -> u64 {
        (self.budget.others + self.budget.total) as u64
    }

    pub(super) fn send(&mut self, to: WorkerId, news: DomainNews) {
        self.mail.send(to, news);
    }

    /// Tells all other workers; returns their number.
    pub(super) fn send_to_others(&mut self, news: &DomainNews) -> i64 {
        let me = self.me;
        for to in (0..self.workers).map(WorkerId::new).filter(|to| *to != me) {
            self.send(to, news.clone());
        }
        i64::from(self.workers) - 1
    }
}

impl<'c, C: Rules> Source<DomainMesh<'c>> for Rounds<C> {
    const WATCHES: bool = true;

    fn next(&mut self, mesh: &DomainMesh<'c>) -> Option<DomainPoint> {
        if self.stage != Stage::Inserting {
            return None;
        }
        let next = self.points.chosen.pop_front()?;
        self.fetch(mesh);
        mesh.remember(next.point.name(), self.served.cavity_at(&next.cavity));
        Some(next.point)
    }

    fn is_empty(&self) -> bool {
        self.stage == Stage::Over
    }

    fn is_ready(&self) -> bool {
        self.stage == Stage::Inserting && !self.points.chosen.is_empty()
    }

    fn item(&self, mesh: &DomainMesh<'c>, point: &DomainPoint) -> Item<TetId> {
        let start = self.points.starts.get(self.number(point)).and_then(Option::as_ref);
        let start = start.filter(|&&(t, v)| mesh.has(t, v));
        start.map_or(Item::Free, |&(t, _)| Item::At(t))
    }

    fn created(&mut self, _: &DomainMesh<'c>, tets: &[TetId]) {
        self.created.extend(tets);
    }

    fn released(&mut self, point: &DomainPoint) {
        self.forget_start(point);
    }

    fn inserted(&mut self, _: &DomainMesh<'c>, point: &DomainPoint) {
        self.forget_start(point);
    }

    fn remove_block(&mut self, _: &DomainMesh<'c>, _: BlockId) -> Vec<DomainPoint> {
        Vec::new()
    }

    fn add(&mut self, _: BlockId, _: Vec<DomainPoint>) {}

    fn counts(&self) -> bool {
        true
    }

    fn has_thoughts(&self, standing: Standing) -> bool {
        match self.stage {
            _ if self.waves.passed.is_some() => true,
            Stage::Looking => true,
            Stage::Exchanging(_) if self.exchange.awaited.is_empty() => true,
            Stage::Choosing if !self.choice.to_launch.is_empty() => true,
            Stage::Inserting if self.has_many_created() => true,
            _ if !self.waves.tree.has_put() && self.is_ready_for_barrier(standing) => true,
            _ => self.looks_ahead(standing),
        }
    }

    fn think(&mut self, mesh: &mut DomainMesh<'c>, directory: &Directory, standing: Standing) {
        if let Some(sums) = self.waves.passed.take() {
            return self.go_on(mesh, sums);
        }
        match self.stage {
            Stage::Looking => self.look(mesh, directory),
            Stage::Exchanging(second) if self.exchange.awaited.is_empty() => {
                self.end_exchange(mesh, directory, second);
            }
            Stage::Inserting if self.has_many_created() => self.look_at_created(mesh, LOOK),
            Stage::Choosing if !self.choice.to_launch.is_empty() => {
                for _ in 0..TOGETHER {
                    let Some(k) = self.choice.to_launch.pop_front() else { break };
                    self.fetch_ahead(mesh);
                    self.launch(mesh, directory, k);
                }
            }
            // R21.
            Stage::Choosing
                if !C::awaits_reservations()
                    && self.choice.open == 0
                    && self.choice.fates.is_none()
                    && self.choice.entered.is_none() =>
            {
                self.begin_to_decide(mesh);
                self.end_decisions();
            }
            _ if !self.waves.tree.has_put() && self.is_ready_for_barrier(standing) => {
                self.put(mesh, standing);
            }
            _ if self.looks_ahead(standing) => self.look_ahead(mesh),
            _ => {}
        }
    }

    fn hear(
        &mut self,
        mesh: &mut DomainMesh<'c>,
        directory: &Directory,
        from: WorkerId,
        news: DomainNews,
    ) {
        match news {
            DomainNews::Several(mut all) => {
                for news in all.drain(..) {
                    self.hear(mesh, directory, from, news);
                }
                self.mail.keep(all);
            }
            DomainNews::Keys { exchange, keys } => self.take_keys(mesh, from, exchange, keys),
            DomainNews::Up(sums) => {
                let step = self.waves.tree.hear(sums);
                self.take_step(step);
            }
            DomainNews::Down(sums) => self.pass_on(sums),
            DomainNews::Way { own, at, start, may, region } => {
                if let Some(t) = mesh.resolve(at.name) {
                    let entry = Entry { t, by: Some((usize::from(at.face), region)) };
                    self.go(mesh, directory, &own.into(), entry, Begin { start, may });
                }
            }
            DomainNews::Seek { own, at } => {
                let at = at.and_then(|at| mesh.resolve(at.name));
                self.seek(mesh, directory, &own.into(), at);
            }
            DomainNews::Search { own, seeds } => {
                let seeds: Vec<TetId> =
                    seeds.iter().filter_map(|handle| mesh.resolve(handle.name)).collect();
                self.serve(mesh, directory, &own.into(), &seeds);
            }
            DomainNews::Beyond { probe, at } => self.tell_beyond(mesh, directory, probe, &at),
            DomainNews::Part { number, end, found, foreign } => {
                self.take_part(mesh, directory, from, number, Answer { end, found, foreign });
            }
            DomainNews::Entrants(entrants) => self.take_entrants(mesh, from, entrants),
            DomainNews::Launch(numbers) => self.take_launch(numbers),
            DomainNews::Report(report) => self.take_report(from, report),
            DomainNews::Fates(fates) => {
                self.note_followers(&fates);
                self.choice.fates = Some(Some(fates));
            }
            DomainNews::Waiting(all) => self.take_waiting(&all),
            DomainNews::Lend(balls) => self.lend(mesh, &balls),
            DomainNews::Lent(part) => self.take_lent(mesh, from, part),
            DomainNews::Parted(told) => self.take_parted(mesh, told),
            DomainNews::Blocks(blocks) => {
                self.counts.notes -= 1;
                self.take_blocks(blocks);
            }
            DomainNews::Unblocked(places) => {
                self.counts.releases -= 1;
                self.forget_blocks(&places);
            }
            // Told by sources without rounds alone.
            DomainNews::Ended(_) => {}
            DomainNews::Void(probe) => {
                self.counts.notes -= 1;
                self.served.drop_part(probe);
            }
            DomainNews::WantRivals(probe) => {
                self.counts.notes -= 1;
                self.served.want_rivals(probe);
            }
            DomainNews::Rivals { number, rivals } => {
                self.take_rivals(from, number, &rivals);
                if self.stage == Stage::Deciding && self.is_due(number) {
                    self.decide(mesh, number);
                    self.end_decisions();
                }
            }
            DomainNews::Ask { item, limit, waiter } => {
                self.counts.asks -= 1;
                let waiter = waiter.map(|place| (from, place));
                let (item, limit) = (item.item(), limit.map(WireLimit::limit));
                self.demands.asked.push((Pending { item, first: None, limit, near: None }, waiter));
            }
            DomainNews::Gone(place) => {
                self.counts.asks -= 1;
                self.demands.gone.push(place);
            }
            DomainNews::Refused(told) => self.take_refusals(told),
            DomainNews::Release(place) => {
                self.counts.releases -= 1;
                self.demands.released.push(place);
                // One may be told before this worker knows that the round is over.
                if self.stage != Stage::Inserting {
                    self.demands.release();
                }
            }
        }
    }

    fn tell(&mut self) -> Option<(WorkerId, DomainNews)> {
        self.mail.tell(self.me)
    }

    fn excluded(&self) -> &'static [&'static str] {
        self.stage.excludes(!self.waves.tree.has_put() && self.waves.passed.is_none())
    }

    fn describe(&self) -> String {
        self.progress()
    }

    fn clear(&mut self) {
        self.is_cancelled = true;
    }
}
