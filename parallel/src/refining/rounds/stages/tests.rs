//! Barriers, and messages of one kind that are late; items that several workers ask for.

use super::super::deal::{Common, Exchange, To, Value, is_due, redeal};
use super::super::demands::Pending;
use super::super::source::Among;
use super::super::under_way::Counts;
use super::super::{Ending, RoundNode, rounds_by};
use super::*;
use crate::check::{NewsNumbers, check_news, count_news};
use crate::mesh::{Layout, Redeal};
use crate::protocol::{Action, Config, Correct, Event, Message, Source};
use crate::refining::RefineError;
use crate::refining::news::{NEWS_KINDS, WireItem, WireLimit};
use ltbw_core::MeshHash;
use ltbw_domain::{PrepareOptions, Prepared};
use ltbw_generate::layers::stack;
use ltbw_generate::{DomainKind, Shape, generate_domain, surfaces};
use ltbw_refine::{Carrier, Corner, Limit, Refined, Refiner};
use std::collections::{BTreeMap, VecDeque};

/// Waves after which a message that is late comes.
const WAVES: u64 = 3;

/// Workers, and a network on which messages of one kind are late, with those behind them.
struct Late<'c> {
    nodes: Vec<RoundNode<'c, Correct>>,
    channels: BTreeMap<(usize, usize), VecDeque<Message<DomainMesh<'c>>>>,
    news: NewsNumbers,
    kind: &'static str,
    /// Barriers that worker 0 had passed when nothing was late, or late messages came last.
    mark: u64,
    /// Late messages that came when the others had passed barriers without them.
    late: usize,
    /// Messages of the kind, between two workers.
    sent: i64,
}

impl<'c> Late<'c> {
    fn new(nodes: Vec<RoundNode<'c, Correct>>, kind: &'static str) -> Self {
        let (channels, news) = (BTreeMap::new(), NewsNumbers::default());
        Self { nodes, channels, news, kind, mark: 0, late: 0, sent: 0 }
    }

    /// Is the next message of this channel late?
    fn is_held(&self, channel: (usize, usize)) -> bool {
        self.channels[&channel].front().is_some_and(|message| {
            let mut numbers = NewsNumbers::default();
            count_news(message, &mut numbers, 1);
            numbers.of(self.kind) > 0
        })
    }

    fn step(&mut self, k: usize, event: Event<DomainMesh<'c>>) {
        let mut actions = Vec::new();
        self.nodes[k].step(event, &mut actions);
        for action in actions {
            if let Action::Send { to, message } = action {
                let before = self.news.of(self.kind);
                count_news(&message, &mut self.news, 1);
                self.sent += self.news.of(self.kind) - before;
                self.channels.entry((k, to.index())).or_default().push_back(message);
            }
        }
        for node in &self.nodes {
            let checked = check_news(node, &self.news);
            assert!(checked.is_ok(), "late {}: {checked:?}", self.kind);
        }
        // Barriers wait for what is counted: all that is under way is.
        let counted = |of: fn(&Counts) -> i64| -> i64 {
            self.nodes.iter().map(|node| of(&node.source().counts)).sum()
        };
        let under_way = |kinds: &[&str]| kinds.iter().map(|kind| self.news.of(kind)).sum();
        let counts = [counted(|c| c.notes), counted(|c| c.asks), counted(|c| c.releases)];
        let all: [&[&str]; 3] = [
            &["Void", "WantRivals", "Blocks"],
            &["Ask", "Gone"],
            &["Release", "Refused", "Unblocked"],
        ];
        assert_eq!(counts, all.map(under_way), "notes, asks, releases; late {}", self.kind);
    }

    fn deliver(&mut self, (from, to): (usize, usize)) {
        let queue = self.channels.entry((from, to)).or_default();
        let Some(message) = queue.pop_front() else { return };
        if queue.is_empty() {
            self.channels.remove(&(from, to));
        }
        count_news(&message, &mut self.news, -1);
        self.step(to, Event::Message { from: WorkerId::at(from), message });
    }

    /// Runs workers to their end: what is not late in turn.
    fn run(&mut self) {
        while self.nodes.iter().any(|node| !node.is_stopped()) {
            let mut has_stepped = false;
            for k in 0..self.nodes.len() {
                if self.nodes[k].has_work() {
                    has_stepped = true;
                    self.step(k, Event::Work);
                }
            }
            let all: Vec<(usize, usize)> = self.channels.keys().copied().collect();
            let (held, others): (Vec<_>, Vec<_>) =
                all.into_iter().partition(|&channel| self.is_held(channel));
            has_stepped |= !others.is_empty();
            others.into_iter().for_each(|channel| self.deliver(channel));
            let waves = self.nodes[0].source().figures.barriers;
            if held.is_empty() {
                self.mark = waves;
            }
            if !has_stepped || waves >= self.mark + WAVES {
                assert!(has_stepped || !held.is_empty(), "nothing can happen any more");
                self.late += held.len() * usize::from(has_stepped);
                self.mark = waves;
                held.into_iter().for_each(|channel| self.deliver(channel));
            }
        }
    }
}

fn prepared(kind: DomainKind) -> Prepared {
    let domain = generate_domain(kind, &Shape::default()).expect("a shape");
    domain.prepare(&PrepareOptions::default()).expect("a sound domain")
}

fn hash(refined: &Refined) -> MeshHash {
    refined.mesh().hash().expect("a hash")
}

/// P12 holds, and the mesh is the engine's, whatever kind of message is as late as can be: behind
/// several waves of the barrier that waits for it.
#[test]
fn no_message_is_behind_the_barrier_that_waits_for_it_however_late() {
    let ready = prepared(DomainKind::Gear);
    let refiner = Refiner::new().max_volume(1e-3).start(1);
    let counted = ["Void", "WantRivals", "Ask", "Gone", "Release"];
    assert!(counted.iter().all(|kind| NEWS_KINDS.contains(kind)));
    let others = ["Entrants", "Launch", "Report", "Fates", "Waiting", "Lend", "Lent", "Parted"];
    let kinds: Vec<_> = NEWS_KINDS.into_iter().filter(|kind| !others.contains(kind)).collect();
    let all_late = late_one_after_the_other(&refiner, &ready, &kinds, &counted);
    assert!(all_late > 10, "{all_late}");
}

/// As above, where candidates have turns.
#[test]
fn no_message_about_turns_is_behind_the_barrier_that_waits_for_it() {
    let domain = surfaces::single(surfaces::torus(8));
    let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
    let ready = domain.prepare(&options).expect("a sound domain");
    let refiner = Refiner::new().flat_tolerance(5e-7).max_volume(2e-3).start(1);
    let in_turns = ["Entrants", "Launch", "Report", "Fates"];
    late_one_after_the_other(&refiner, &ready, &in_turns, &in_turns);
}

/// As above, where boundary items wait for each other.
#[test]
fn no_message_about_circles_is_behind_the_barrier_that_waits_for_it() {
    let thicknesses = [29, 1, 3].map(|t| f64::from(t) / 64.0);
    let domain = stack([1.0, 1.0], &thicknesses, true);
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let volume = thicknesses.iter().sum::<f64>() / 500.0;
    let refiner = Refiner::new().max_volume(volume).min_dihedral(0.0).start(0);
    let of_circles = ["Waiting", "Lend", "Lent", "Parted"];
    late_one_after_the_other(&refiner, &ready, &of_circles, &of_circles);
}

/// Has one kind after the other come late; those of `sent_ones` are sent between workers. Returns
/// how many of these came late.
fn late_one_after_the_other(
    refiner: &Refiner<'_>,
    ready: &Prepared,
    kinds: &[&'static str],
    sent_ones: &[&str],
) -> usize {
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    let layout = |points| (Layout::new(points, 5), Config::new(5));
    let mut all_late = 0;
    for &kind in kinds {
        let (mut late, mut sent) = (0, 0);
        let run = rounds_by(refiner, (&ready.domain, &ready.lattice), layout, |nodes| {
            let mut network = Late::new(nodes, kind);
            network.run();
            late += network.late;
            sent += network.sent;
            Ok(network.nodes)
        });
        let (refined, ending) = run.expect("a mesh");
        assert_eq!(ending.ok(), Some(Ending::Done), "late {kind}");
        assert_eq!(hash(&refined), hash(&engine), "late {kind}");
        println!("{kind}: {late} of {sent} came behind {WAVES} waves");
        // Others are awaited by somebody who does not speak before.
        if sent_ones.contains(&kind) {
            assert!(sent > 0, "no {kind} went from one worker to another");
            all_late += late;
        }
    }
    all_late
}

/// Nobody hears how much work there is.
struct Deaf;

impl Exchange for Deaf {
    fn to_all<T: Value>(&mut self, _: Vec<T>) -> Result<Vec<T>, RefineError> {
        Ok(Vec::new())
    }

    fn to_some<T: Value>(&mut self, own: Vec<To<T>>) -> Result<Vec<To<T>>, RefineError> {
        Ok(own.iter().map(|_| Vec::new()).collect())
    }
}

/// Workers that stop between rounds, and go on with the cuts that they had, have lost nothing.
#[test]
fn a_redeal_that_moves_nothing_changes_nothing() {
    let ready = prepared(DomainKind::Gear);
    let refiner = Refiner::new().max_volume(1e-3).start(1);
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    let config = Config::new(5);
    let layout = Layout { redeal: Redeal::Every(1), ..Layout::new(1000, 5) };
    let mut stops = 0;
    let run = rounds_by(
        &refiner,
        (&ready.domain, &ready.lattice),
        |_| (layout, config),
        |nodes| {
            let mut nodes = nodes;
            loop {
                let mut network = Late::new(nodes, "");
                network.run();
                nodes = network.nodes;
                if !is_due(&nodes) {
                    return Ok(nodes);
                }
                let common = Common { points: &[], layout, config };
                nodes = redeal(nodes, common, &mut Deaf)?.0;
                stops += 1;
            }
        },
    );
    let (refined, ending) = run.expect("a mesh");
    assert_eq!(ending.ok(), Some(Ending::Done));
    assert_eq!(hash(&refined), hash(&engine));
    assert!(stops > 10, "{stops}");
}

/// A round that uses the budget up is carried out, one of a point more is not.
#[test]
fn a_budget_is_used_up_to_the_last_point() {
    let ready = prepared(DomainKind::CubeOctahedron);
    let refiner = Refiner::new().max_volume(1e-2).start(1);
    let layout = |points| (Layout::new(points, 2), Config::new(2));
    let mut sums = [0; SUMS];
    (sums[CANDIDATES], sums[FOREMOST]) = (3, 3);
    let run = rounds_by(&refiner, (&ready.domain, &ready.lattice), layout, |mut nodes| {
        for (most, ending) in [(9, None), (8, None), (7, Some(Ending::Budget))] {
            let mesh = nodes[0].mesh_mut();
            let place = Among { me: WorkerId::default(), workers: 2, blocks_each: 1 };
            let mut source = Rounds::<Correct>::new(place, [5, most, 0], mesh);
            source.stage = Stage::Choosing;
            source.end_choice(mesh, &sums);
            assert_eq!(source.ending, ending, "5 points, 3 candidates, {most} at most");
        }
        let mut network = Late::new(nodes, "");
        network.run();
        Ok(network.nodes)
    });
    assert!(run.is_ok());
}

/// Several workers ask for one item, for edges of different lengths: the smallest limit holds, in
/// whatever order they are heard, and beside a limit that the item has already.
#[test]
fn of_several_limits_for_one_item_the_smallest_holds() {
    let ready = prepared(DomainKind::CubeOctahedron);
    let refiner = Refiner::new().max_volume(1e-2).start(1);
    let layout = |points| (Layout::new(points, 3), Config::new(3));
    let corner = |x, k| Corner { point: [x, 0.0, 0.0], carrier: Carrier::Corner(k) };
    let item = BoundaryItem::new(&[corner(0.0, 0), corner(4.0, 1)], 0);
    let [first, second] =
        [1, 2].map(|k| BoundaryItem::new(&[corner(0.0, 0), corner(9.0, k)], k).place());
    let all = |least| Limit { least, along: None };
    let orders = [[0.5, 0.25, 0.75], [0.75, 0.5, 0.25], [0.25, 0.75, 0.5]].map(|own| own.map(all));
    let mut asked = 0;
    let run = rounds_by(&refiner, (&ready.domain, &ready.lattice), layout, |mut nodes| {
        for (limits, is_pending) in orders.into_iter().flat_map(|all| [(all, false), (all, true)]) {
            let directory = nodes[0].directory().clone();
            let mesh = nodes[0].mesh_mut();
            let place = Among { me: WorkerId::default(), workers: 3, blocks_each: 1 };
            let mut source = Rounds::<Correct>::new(place, [0, u64::MAX, 0], mesh);
            let [own, others @ ..] = limits;
            if is_pending {
                let own = Pending { item, first: None, limit: Some(own), near: None };
                source.demands.pending.insert(item.place(), own);
            } else {
                source
                    .demands
                    .asked
                    .push((Pending { item, first: None, limit: Some(own), near: None }, None));
            }
            for (from, limit, waiter) in
                [(1, Some(others[0]), first), (2, None, second), (2, Some(others[1]), second)]
            {
                let (item, limit) = (WireItem::new(&item), limit.map(WireLimit::new));
                let news = DomainNews::Ask { item, limit, waiter: Some(waiter) };
                source.hear(mesh, &directory, WorkerId::new(from), news);
            }
            source.settle(&[0; SUMS]);
            let kept = &source.demands.pending[&item.place()];
            assert_eq!(kept.limit, Some(all(0.25)), "{limits:?}, {is_pending}");
            let waiters = &source.demands.waiters[&item.place()];
            let expected = [(1, first), (2, second), (2, second)];
            assert_eq!(waiters[..], expected.map(|(w, place)| (WorkerId::new(w), place)));
            asked += 1;
        }
        let mut network = Late::new(nodes, "");
        network.run();
        Ok(network.nodes)
    });
    assert!(run.is_ok() && asked >= 6, "{asked}");
}
