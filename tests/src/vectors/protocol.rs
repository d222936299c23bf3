//! `protocol/` and `interleavings/`: runs of the real `Worker::step` over the line, event by event,
//! and runs of known-bad variants that must not happen.
//!
//! A flag is on a run exactly if breaking that rule changes the run's actions: the generator
//! replays every run with each of the [`Rules`] broken. So a port that fails a case is told which
//! rules the case can tell apart.

use super::line::{Cuts, Line, Queue};
use super::quiet::quietly;
use super::{Case, File, letters};
use crate::families::Rng;
use ltbw::protocol::{
    Action, BlockId, Config, Correct, Directory, Event, Message, Rule, Rules, Ticket, Worker,
    WorkerId,
};
use serde_json::{Value, json};
use std::collections::{BTreeMap, VecDeque};

/// Events after which a run that has not ended is given up: it is not used.
const LONGEST: usize = 90;
/// Seeds tried for the runs of one flag.
const SEEDS: u64 = 60_000;

/// The start of a run.
#[derive(Clone, Debug)]
struct Setup {
    rule: Rule,
    window: usize,
    cuts: Cuts,
    owners: Vec<WorkerId>,
    start: Vec<i64>,
    /// By worker.
    points: Vec<Vec<i64>>,
}

impl Setup {
    fn workers(&self) -> u32 {
        self.points.len() as u32
    }

    fn json(&self) -> Value {
        json!({
            "rule": self.rule.to_string(), "window": self.window, "range": self.cuts.range,
            "blocks": self.cuts.blocks, "owners": self.owners, "start": self.start,
            "points": self.points,
        })
    }
}

/// The next event of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Turn {
    Work(WorkerId),
    /// The first message under way on this pair arrives.
    Deliver {
        from: WorkerId,
        to: WorkerId,
    },
    Migrate {
        worker: WorkerId,
        block: BlockId,
        to: WorkerId,
    },
    Retry(WorkerId, Ticket),
    Cancel(WorkerId),
}

impl Turn {
    fn json(self) -> Value {
        match self {
            Self::Work(w) => json!({"worker": w, "event": "work"}),
            Self::Deliver { from, to } => json!({"worker": to, "event": "deliver", "from": from}),
            Self::Migrate { worker, block, to } => {
                json!({"worker": worker, "event": "migrate", "block": block, "to": to})
            }
            Self::Retry(w, ticket) => {
                json!({"worker": w, "event": "retry", "ticket": letters::ticket(ticket)})
            }
            Self::Cancel(w) => json!({"worker": w, "event": "cancel"}),
        }
    }
}

/// Workers and the messages between them.
struct World<C> {
    workers: Vec<Worker<Line, Queue, C>>,
    channels: BTreeMap<(WorkerId, WorkerId), VecDeque<Message<Line>>>,
    resting: Vec<(WorkerId, Ticket)>,
}

impl<C: Rules> World<C> {
    fn new(setup: &Setup) -> Self {
        let config =
            Config { rule: setup.rule, window: setup.window, ..Config::new(setup.workers()) };
        let worker = |(me, points): (WorkerId, &Vec<i64>)| {
            let mesh = Line::new(me, setup.cuts, &setup.start, &setup.owners);
            let directory = Directory::new(me, &setup.owners);
            Worker::new(config, directory, mesh, Queue::new(points, setup.cuts))
        };
        let workers = (0..).zip(&setup.points).map(worker).collect();
        Self { workers, channels: BTreeMap::new(), resting: Vec::new() }
    }

    /// The actions of a turn; `None` if there is no such message or operation.
    fn turn(&mut self, turn: Turn) -> Option<Vec<Action<Line>>> {
        let (worker, event) = match turn {
            Turn::Work(w) => (w, Event::Work),
            Turn::Deliver { from, to } => {
                let message = self.channels.get_mut(&(from, to))?.pop_front()?;
                (to, Event::Message { from, message })
            }
            Turn::Migrate { worker, block, to } => (worker, Event::Migrate { block, to }),
            Turn::Retry(w, ticket) => {
                let at = self.resting.iter().position(|&rest| rest == (w, ticket))?;
                self.resting.swap_remove(at);
                (w, Event::Retry(ticket))
            }
            Turn::Cancel(w) => (w, Event::Cancel),
        };
        let mut out = Vec::new();
        // A known-bad variant may break an invariant: its run ends here.
        let worker_of = &mut self.workers[worker as usize];
        quietly(|| worker_of.step(event, &mut out))?;
        for action in &out {
            match action {
                Action::Send { to, message } => {
                    self.channels.entry((worker, *to)).or_default().push_back(message.clone());
                }
                Action::Backoff { ticket, .. } => self.resting.push((worker, *ticket)),
                Action::Note(_) => {}
            }
        }
        Some(out)
    }

    /// The events that can happen.
    fn choices(&self) -> Vec<Turn> {
        let open = self.channels.iter().filter(|(_, queue)| !queue.is_empty());
        let deliver = open.map(|(&(from, to), _)| Turn::Deliver { from, to });
        let busy = self.workers.iter().filter(|w| w.has_work()).map(|w| Turn::Work(w.id()));
        let retry = self.resting.iter().map(|&(w, ticket)| Turn::Retry(w, ticket));
        deliver.chain(busy).chain(retry).collect()
    }

    /// The state: cells by worker, and which workers have stopped.
    fn state(&self) -> Value {
        let cells: Vec<_> = self.workers.iter().map(|w| w.mesh().ends()).collect();
        let stopped: Vec<bool> = self.workers.iter().map(Worker::is_stopped).collect();
        json!({"cells": cells, "stopped": stopped})
    }
}

/// A run: what happened, the actions of each turn, the state after it.
#[derive(Clone, Debug, PartialEq)]
struct Run {
    turns: Vec<Turn>,
    steps: Vec<Value>,
    state: Value,
}

/// Replays `turns` under the rules C, as far as it goes.
fn replay<C: Rules>(setup: &Setup, turns: &[Turn]) -> Run {
    let mut world = World::<C>::new(setup);
    let mut steps = Vec::new();
    for &turn in turns {
        let Some(actions) = world.turn(turn) else { break };
        steps.push(actions.iter().filter_map(letters::action).collect());
    }
    Run { turns: turns[..steps.len()].to_vec(), steps, state: world.state() }
}

/// The first step at which two runs of the same turns differ.
fn differs(sound: &Run, broken: &Run) -> Option<usize> {
    let pairs = sound.steps.iter().zip(&broken.steps);
    let first = pairs.take_while(|(a, b)| a == b).count();
    (first < sound.steps.len() || sound.state != broken.state).then_some(first)
}

/// Known-bad variants: the flag, and the replay under it.
type Broken = (&'static str, fn(&Setup, &[Turn]) -> Run);

macro_rules! broken {
    ($($piece:ident: $rule:ident, $flag:literal;)*) => {
        $(
            #[derive(Debug)]
            struct $piece;

            impl Rules for $piece {
                const $rule: bool = false;
            }
        )*

        const BROKEN: &[Broken] = &[$(($flag, replay::<$piece>)),*];
    };
}

broken! {
    BareCavity: LOCKS_RING, "closure-ring";
    LeakyRollback: RELEASES_ALL, "release";
    ForgetfulRollback: WAKES_ON_ABORT, "release";
    HastyRestart: AWAITS_RELEASES, "acknowledge";
    LateWound: IGNORES_LATE_WOUND, "late-wound";
    WhiteSafra: BLACKENS, "token";
    IdleMigration: ONLY_BUSY_MIGRATE, "idle-migration";
    NoForwarding: FORWARDS, "forward";
    NoInstallation: AWAITS_INSTALLATION, "installation";
}

/// A small random start.
fn setup(rule: Rule, random: &mut Rng) -> Setup {
    let workers = 2 + random.below(2) as u32;
    let cuts = Cuts { range: 16, blocks: 2 * workers };
    let owners = (0..cuts.blocks).map(|block| block / 2).collect();
    let start = [3, 6, 9, 12].into_iter().filter(|_| random.below(2) == 0).collect();
    let mut points = vec![Vec::new(); workers as usize];
    for _ in 0..2 + random.below(4) {
        points[random.below(u64::from(workers)) as usize].push(random.below(16) as i64);
    }
    Setup { rule, window: 1 + random.below(3) as usize, cuts, owners, start, points }
}

/// A random run of the correct protocol; `None` if it takes too long.
fn play(setup: &Setup, moves: u64, random: &mut Rng) -> Option<Run> {
    let mut world = World::<Correct>::new(setup);
    let (mut turns, mut steps, mut moves) = (Vec::new(), Vec::new(), moves);
    for _ in 0..LONGEST {
        let mut choices = world.choices();
        if choices.is_empty() {
            check(&world, setup);
            return Some(Run { turns, steps, state: world.state() });
        }
        if moves > 0 && random.below(6) == 0 {
            moves -= 1;
            let [worker, to] = [(); 2].map(|()| random.below(u64::from(setup.workers())) as u32);
            let block = random.below(u64::from(setup.cuts.blocks)) as u32;
            choices = vec![Turn::Migrate { worker, block, to }];
        }
        let turn = choices[random.below(choices.len() as u64) as usize];
        let actions = world.turn(turn).expect("a choice");
        turns.push(turn);
        steps.push(actions.iter().filter_map(letters::action).collect());
    }
    None
}

/// At the end of a sound run: the line of all points, nothing locked, everybody stopped.
fn check(world: &World<Correct>, setup: &Setup) {
    let mut cells: Vec<(i64, i64)> = world.workers.iter().flat_map(|w| w.mesh().ends()).collect();
    cells.sort_unstable();
    let mut vertices: Vec<i64> = setup
        .points
        .iter()
        .flatten()
        .chain(&setup.start)
        .chain(&[-1, setup.cuts.range])
        .copied()
        .collect();
    vertices.sort_unstable();
    vertices.dedup();
    let expected: Vec<(i64, i64)> = vertices.windows(2).map(|pair| (pair[0], pair[1])).collect();
    assert_eq!(cells, expected, "{setup:?}");
    assert!(world.workers.iter().all(|w| w.is_stopped() && w.is_quiescent()), "{setup:?}");
}

/// Does a message of the run have this in its text?
fn says(run: &Run, text: &str) -> bool {
    run.steps.iter().any(|step| step.to_string().contains(text))
}

/// The flags of a run of the correct protocol.
fn flags(setup: &Setup, run: &Run) -> Vec<&'static str> {
    let mut flags: Vec<&'static str> = Vec::new();
    for (flag, broken) in BROKEN {
        if differs(run, &broken(setup, &run.turns)).is_some() && !flags.contains(flag) {
            flags.push(flag);
        }
    }
    if says(run, r#""kind":"wound""#) {
        flags.push("wound");
    }
    if says(run, r#""bounced":[["#) {
        flags.push("bounce");
    }
    if refuses_locked(setup, run) {
        flags.push("locked-migration");
    }
    if setup.rule != Rule::WoundWait && says(run, r#""kind":"deny""#) {
        flags.push("rule");
    }
    flags
}

/// Is there a move that nothing but a lock forbids?
fn refuses_locked(setup: &Setup, run: &Run) -> bool {
    let mut world = World::<Correct>::new(setup);
    run.turns.iter().any(|&turn| {
        let refused = match turn {
            Turn::Migrate { worker, block, to } => {
                let node = &world.workers[worker as usize];
                to != worker
                    && node.directory().is_mine(block)
                    && !node.is_passive()
                    && !node.is_stopped()
                    && !node.can_migrate(block)
            }
            _ => false,
        };
        world.turn(turn);
        refused
    })
}

/// The case of a run.
fn case(name: &str, flags: Vec<&'static str>, setup: &Setup, run: &Run) -> Case {
    let turns: Vec<Value> = run.turns.iter().map(|turn| turn.json()).collect();
    Case {
        name: name.to_string(),
        flags,
        ask: json!({"op": "line", "setup": setup.json(), "events": turns}),
        expect: json!({"steps": run.steps, "state": run.state}),
    }
}

/// For every flag, the shortest of the first few runs under `rule` that have it.
fn selected(rule: Rule, wanted: &[&'static str]) -> Vec<(Setup, Run, Vec<&'static str>)> {
    const TRIED: u32 = 8;
    let mut best: BTreeMap<&str, (u32, Setup, Run, Vec<&'static str>)> = BTreeMap::new();
    for seed in 0..SEEDS {
        if wanted.iter().all(|flag| best.get(flag).is_some_and(|(tried, ..)| *tried >= TRIED)) {
            break;
        }
        let mut random = Rng::new(seed);
        let setup = setup(rule, &mut random);
        let Some(run) = play(&setup, random.below(4), &mut random) else { continue };
        let found = flags(&setup, &run);
        for flag in wanted.iter().filter(|flag| found.contains(flag)) {
            let entry = best.entry(flag);
            let old = entry.or_insert_with(|| (0, setup.clone(), run.clone(), found.clone()));
            if old.0 < TRIED && run.turns.len() < old.2.turns.len() {
                (old.1, old.2, old.3) = (setup.clone(), run.clone(), found.clone());
            }
            old.0 += 1;
        }
    }
    let missing: Vec<_> = wanted.iter().filter(|flag| !best.contains_key(*flag)).collect();
    assert!(missing.is_empty(), "{rule}: no run shows {missing:?}");
    best.into_values().map(|(_, setup, run, flags)| (setup, run, flags)).collect()
}

/// Rules of the default protocol that runs over the line can tell.
const WOUND_WAIT: &[&str] = &[
    "closure-ring",
    "release",
    "acknowledge",
    "late-wound",
    "token",
    "idle-migration",
    "forward",
    "installation",
    "wound",
    "bounce",
    "locked-migration",
];

/// The files of both folders.
#[must_use]
pub fn files() -> Vec<File> {
    let shown = selected(Rule::WoundWait, WOUND_WAIT);
    let cases: Vec<Case> = shown
        .iter()
        .map(|(setup, run, flags)| case("a run under wound-wait", flags.clone(), setup, run))
        .collect();
    let others: Vec<(Setup, Run, Vec<&'static str>)> = selected(Rule::Paper, &["rule"]);
    let rules = others.iter().map(|(setup, run, flags)| {
        case(&format!("a run under {}", setup.rule), flags.clone(), setup, run)
    });
    let file = |folder, name, tier, about, cases| File { folder, name, tier, about, cases };
    let rules = rules.collect();
    let traces = shown.iter().chain(&others).flat_map(|(setup, run, _)| forbidden(setup, run));
    let traces = traces.collect();
    vec![
        file("protocol", "human", 1, "Runs to be followed by hand.", by_hand()),
        file("protocol", "wound-wait", 2, "Runs of the default rule, with moves.", cases),
        file("protocol", "rules", 3, "Runs of the other two rules.", rules),
        file(
            "interleavings",
            "forbidden",
            2,
            "Runs of broken protocols: where they go wrong.",
            traces,
        ),
    ]
}

/// The run under each broken rule: the steps up to where it goes wrong.
fn forbidden(setup: &Setup, run: &Run) -> Vec<Case> {
    let mut cases = Vec::new();
    for (flag, broken) in BROKEN {
        let wrong = broken(setup, &run.turns);
        let Some(first) = differs(run, &wrong).filter(|&k| k < wrong.steps.len()) else { continue };
        let turns: Vec<Value> = run.turns[..=first].iter().map(|turn| turn.json()).collect();
        cases.push(Case {
            name: format!("step {first} is not the protocol's"),
            flags: vec![flag],
            ask: json!({
                "op": "judge", "setup": setup.json(), "events": turns,
                "steps": wrong.steps[..=first],
            }),
            expect: json!({"wrong": first}),
        });
    }
    cases
}

/// Two workers, two blocks: 0 to 7 and 8 to 15.
fn two(start: &[i64], points: [&[i64]; 2]) -> Setup {
    Setup {
        rule: Rule::WoundWait,
        window: 4,
        cuts: Cuts { range: 16, blocks: 2 },
        owners: vec![0, 1],
        start: start.to_vec(),
        points: points.iter().map(|list| list.to_vec()).collect(),
    }
}

fn by_hand() -> Vec<Case> {
    let deliver = |from, to| Turn::Deliver { from, to };
    let there_and_back = [deliver(0, 1), deliver(1, 0)];
    let local = (two(&[4, 8, 12], [&[2], &[14]]), vec![Turn::Work(0), Turn::Work(1)]);
    let interface = (
        two(&[4, 8, 12], [&[6], &[]]),
        [vec![Turn::Work(0)], there_and_back.to_vec(), vec![deliver(0, 1)]].concat(),
    );
    let walk = (two(&[4, 8, 12], [&[13], &[]]), vec![Turn::Work(0), deliver(0, 1)]);
    let duplicate =
        (two(&[4, 8, 12], [&[4, 12], &[]]), vec![Turn::Work(0), Turn::Work(0), deliver(0, 1)]);
    let cancel =
        (two(&[4, 8, 12], [&[2, 3], &[14]]), vec![Turn::Work(0), Turn::Cancel(0), Turn::Cancel(1)]);
    // Both want the two cells on either side of 8.
    let conflict = (
        two(&[4, 8, 12], [&[6], &[10]]),
        vec![Turn::Work(0), Turn::Work(1), deliver(0, 1), deliver(1, 0)],
    );
    [
        ("two local insertions: no message", local, "local"),
        ("a closure of two workers", interface, "local"),
        ("a walk that leaves", walk, "local"),
        ("duplicates: here, and there", duplicate, "duplicate"),
        ("cancel drops what is not begun", cancel, "local"),
        ("two operations want each other's cells: the older wounds", conflict, "wound"),
    ]
    .into_iter()
    .map(|(name, (setup, turns), flag)| {
        let first = replay::<Correct>(&setup, &turns);
        assert_eq!(first.turns, turns, "{name}: every event is possible");
        let run = to_the_end(&setup, turns);
        let more = flags(&setup, &run).into_iter().filter(|f| *f != flag);
        case(name, [flag].into_iter().chain(more).collect(), &setup, &run)
    })
    .collect()
}

/// The run goes on by the first choice each time, to the end.
fn to_the_end(setup: &Setup, mut turns: Vec<Turn>) -> Run {
    let mut world = World::<Correct>::new(setup);
    for &turn in &turns {
        world.turn(turn);
    }
    // Ends: the first choice is a delivery where there is one, and every run of the protocol ends.
    while let Some(&turn) = world.choices().first() {
        world.turn(turn);
        turns.push(turn);
    }
    replay::<Correct>(setup, &turns)
}
