//! `protocol/` and `interleavings/`: runs of the real `Worker::step` over the line and the hull,
//! event by event, and runs of known-bad variants that must not happen.
//!
//! A flag is on a run exactly if breaking that rule changes the run's actions: the generator
//! replays every run with each of the [`Rules`](ltbw::protocol::Rules) broken. So a port that fails
//! a case is told which rules the case can tell apart.

use crate::line::{Cuts, Line, Queue};
use crate::world::{Chances, Node, Run, Start, Turn, World, differs, play, replay, to_the_end};
use crate::{Case, File, letters};
use ltbw::protocol::{Config, Correct, Directory, Rule, Worker, WorkerId};
use ltbw_models::graph::{Graph, Limits};
use ltbw_models::hull::Hull;
use ltbw_models::system::{Choice, Migration, System};
use ltbw_models::variants::{Defect, KnownBad, Variant};
use ltbw_models::world::{Points, World as Polygon};
use ltbw_models::worlds;
use ltbw_tests::families::Rng;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Events after which a run that has not ended is given up: it is not used.
const LONGEST: usize = 120;
/// Seeds tried for the runs of one flag.
const SEEDS: u64 = 1_500;

/// The start of a run over the line.
#[derive(Clone, Debug)]
pub struct Setup {
    rule: Rule,
    window: usize,
    cuts: Cuts,
    owners: Vec<WorkerId>,
    start: Vec<i64>,
    /// By worker.
    points: Vec<Vec<i64>>,
}

impl Start for Setup {
    type Mesh<C: Variant> = Line;
    type Points<C: Variant> = Queue;

    fn workers<C: Variant>(&self) -> Vec<Node<Self, C>> {
        let config = Config {
            rule: self.rule,
            window: self.window,
            ..Config::new(self.points.len() as u32)
        };
        let worker = |(me, points): (usize, &Vec<i64>)| {
            let me = WorkerId::at(me);
            let mesh = Line::new(me, self.cuts, &self.start, &self.owners);
            let directory = Directory::new(me, &self.owners);
            Worker::new(config, directory, mesh, Queue::new(points, self.cuts))
        };
        self.points.iter().enumerate().map(worker).collect()
    }

    fn json(&self) -> (&'static str, Value) {
        let setup = json!({
            "rule": self.rule.to_string(), "window": self.window, "range": self.cuts.range,
            "blocks": self.cuts.blocks, "owners": self.owners, "start": self.start,
            "points": self.points,
        });
        ("line", setup)
    }

    fn rule(&self) -> Rule {
        self.rule
    }

    /// The line of all points.
    fn certify(&self, workers: &[Node<Self, Correct>]) {
        let mut cells: Vec<(i64, i64)> = workers.iter().flat_map(|w| w.mesh().ends()).collect();
        cells.sort_unstable();
        let points = self.points.iter().flatten().chain(&self.start);
        let mut vertices: Vec<i64> = points.chain(&[-1, self.cuts.range]).copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let expected: Vec<(i64, i64)> =
            vertices.windows(2).map(|pair| (pair[0], pair[1])).collect();
        assert_eq!(cells, expected, "{self:?}");
    }
}

impl Start for Polygon {
    type Mesh<C: Variant> = Hull<C>;
    type Points<C: Variant> = Points;

    fn workers<C: Variant>(&self) -> Vec<Node<Self, C>> {
        self.nodes()
    }

    fn json(&self) -> (&'static str, Value) {
        let home = |v: &&ltbw_models::hull::Vertex| self.owners[usize::from(v.block)];
        let points =
            |w| self.points.iter().filter(move |v| home(v) == w).map(|&v| letters::vertex(v));
        let points: Vec<Value> =
            (0..self.workers()).map(|w| points(WorkerId::new(w)).collect()).collect();
        let polygon: Vec<Value> = self.polygon.iter().map(|&v| letters::vertex(v)).collect();
        let setup = json!({
            "rule": self.rule.to_string(), "window": self.window, "owners": self.owners,
            "polygon": polygon, "points": points,
        });
        ("hull", setup)
    }

    fn rule(&self) -> Rule {
        self.rule
    }

    fn certify(&self, workers: &[Node<Self, Correct>]) {
        let workers: Vec<_> = workers.iter().collect();
        assert_eq!(self.fault_at_end(&workers, false), None, "{}", self.name);
    }
}

/// The flags of known-bad variants.
const BROKEN: [(&str, Defect); 15] = [
    ("closure-ring", Defect::BareCavity),
    ("release", Defect::LeakyRollback),
    ("release", Defect::ForgetfulRollback),
    ("regrant", Defect::NaiveRegrant),
    ("place", Defect::LostPlace),
    ("acknowledge", Defect::HastyRestart),
    ("late-wound", Defect::LateWound),
    ("token", Defect::WhiteSafra),
    ("idle-migration", Defect::IdleMigration),
    ("forward", Defect::NoForwarding),
    ("waiters", Defect::LeftWaiters),
    ("relink", Defect::StaleInterface),
    ("names", Defect::ReusedName),
    ("installation", Defect::ImpatientExpand),
    ("cancel", Defect::RestlessCancel),
];

/// A replay of `turns` with a defect.
fn broken<T: Start>(defect: Defect, start: &T, turns: &[Turn]) -> Run {
    defect.planted(|| replay::<T, KnownBad>(start, turns))
}

/// A small random line, and the moves of its run.
pub fn line(rule: Rule, random: &mut Rng) -> (Setup, u64) {
    let workers = 2 + random.below(2) as u32;
    let cuts = Cuts { range: 16, blocks: 2 * workers };
    let owners = (0..cuts.blocks).map(|block| WorkerId::new(block / 2)).collect();
    let start = [3, 6, 9, 12].into_iter().filter(|_| random.below(2) == 0).collect();
    let mut points = vec![Vec::new(); workers as usize];
    for _ in 0..2 + random.below(4) {
        points[random.below(u64::from(workers)) as usize].push(random.below(16) as i64);
    }
    let setup = Setup { rule, window: 1 + random.below(3) as usize, cuts, owners, start, points };
    (setup, random.below(4))
}

/// Polygons, and the moves of their runs: the smaller worlds of the models, and a triangle.
pub fn polygons() -> Vec<(Polygon, u64)> {
    // A point sees two of three edges. The third is the ring, at both ends of the cavity.
    let triangle = [(-20, 0, 0), (20, 0, 1), (0, 10, 2)];
    let seen = [(0, 90, 0), (9, 120, 1)];
    let all_but_one = Polygon::new("a triangle", &[0, 1, 2], &triangle, &seen);
    let all = [all_but_one].into_iter().chain(worlds::contests()).chain(worlds::journeys());
    // The kit has no rounds.
    let all = all.filter(|world| world.second.is_none());
    let moves = |world: &Polygon| 2 * world.moves.len() as u64;
    all.map(|world| (moves(&world), world)).map(|(moves, world)| (world, moves)).collect()
}

/// Does a message of the run have this in its text?
fn says(run: &Run, text: &str) -> bool {
    run.steps.iter().any(|step| step.to_string().contains(text))
}

/// The patches of a run.
fn patches(run: &Run) -> impl Iterator<Item = &Value> {
    let actions = run.steps.iter().filter_map(Value::as_array).flatten();
    actions.map(|action| &action["send"]["patch"]).filter(|patch| !patch.is_null())
}

/// The length of a list of a patch or a message.
fn count(list: &Value) -> usize {
    list.as_array().map_or(0, Vec::len)
}

/// Is a ring cell linked anew at both ends?
fn has_two_faces(patch: &Value) -> bool {
    let relink = patch["relink"].as_array().into_iter().flatten();
    let cells: Vec<&Value> = relink.map(|change| &change["of"]).collect();
    cells.iter().enumerate().any(|(k, cell)| cells[..k].contains(cell))
}

/// The flags of a run of the correct protocol.
fn flags<T: Start>(start: &T, run: &Run) -> Vec<&'static str> {
    let mut flags: Vec<&'static str> = Vec::new();
    for (flag, defect) in BROKEN {
        if !flags.contains(&flag) && differs(run, &broken(defect, start, &run.turns)).is_some() {
            flags.push(flag);
        }
    }
    let shown = [
        ("wound", says(run, r#""kind":"wound""#)),
        ("bounce", says(run, r#""bounced":[["#)),
        ("locked-migration", refuses_locked(start, run)),
        ("rule", start.rule() != Rule::WoundWait && says(run, r#""kind":"deny""#)),
        ("cells", patches(run).any(|patch| count(&patch["remove"]) > 1)),
        ("two-faces", patches(run).any(has_two_faces)),
    ];
    flags.extend(shown.iter().filter(|(_, is_shown)| *is_shown).map(|(flag, _)| flag));
    flags
}

/// Is there a move that nothing but a lock forbids?
fn refuses_locked<T: Start>(start: &T, run: &Run) -> bool {
    let mut world = World::<T, Correct>::new(start);
    run.turns.iter().any(|&turn| {
        let refused = match turn {
            Turn::Migrate { worker, block, to } => {
                let node = &world.workers[worker.index()];
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
fn case<T: Start>(name: &str, flags: Vec<&'static str>, start: &T, run: &Run) -> Case {
    let turns: Vec<Value> = run.turns.iter().map(|turn| turn.json()).collect();
    let (op, setup) = start.json();
    Case {
        name: name.to_string(),
        flags,
        ask: json!({"op": op, "setup": setup, "events": turns}),
        expect: json!({"steps": run.steps, "state": run.state}),
    }
}

/// A start, and the number of blocks that may move.
type Begin<T> = (T, u64);

/// A run that is shown, and its flags.
type Shown<T> = (T, Run, Vec<&'static str>);

/// For every flag, the shortest of the first few runs that have it.
fn selected<T: Start>(
    wanted: &[&'static str],
    mut start: impl FnMut(u64, &mut Rng) -> Begin<T>,
) -> Vec<Shown<T>> {
    const TRIED: u32 = 8;
    let mut best: BTreeMap<&str, (u32, Shown<T>)> = BTreeMap::new();
    for seed in 0..SEEDS {
        if wanted.iter().all(|flag| best.get(flag).is_some_and(|(tried, _)| *tried >= TRIED)) {
            break;
        }
        let mut random = Rng::new(seed);
        let (start, moves) = start(seed, &mut random);
        let cancels = random.below(4) == 0;
        let Some(run) = play(&start, &[], Chances { moves, cancels }, LONGEST, &mut random) else {
            continue;
        };
        let found = flags(&start, &run);
        for flag in wanted.iter().filter(|flag| found.contains(flag)) {
            let new = || (start.clone(), run.clone(), found.clone());
            let (tried, old) = best.entry(flag).or_insert_with(|| (0, new()));
            if *tried < TRIED && run.turns.len() < old.1.turns.len() {
                *old = new();
            }
            *tried += 1;
        }
    }
    let missing: Vec<_> = wanted.iter().filter(|flag| !best.contains_key(*flag)).collect();
    assert!(missing.is_empty(), "no run shows {missing:?}");
    let mut shown: Vec<Shown<T>> = Vec::new();
    for (_, (_, one)) in best {
        if shown.iter().all(|(_, run, _)| *run != one.1) {
            shown.push(one);
        }
    }
    shown
}

/// Rules of the default protocol that runs over the line can tell.
const ON_THE_LINE: &[&str] = &[
    "closure-ring",
    "release",
    "acknowledge",
    "late-wound",
    "token",
    "idle-migration",
    "forward",
    "wound",
    "bounce",
    "locked-migration",
    "cancel",
];

/// Rules that runs over the hull can tell, or tell better.
const ON_THE_HULL: &[&str] = &[
    "closure-ring",
    "release",
    "regrant",
    "acknowledge",
    "late-wound",
    "relink",
    "names",
    "installation",
    "cancel",
    "cells",
    "two-faces",
];

/// The files of both folders.
#[must_use]
pub fn files() -> Vec<File> {
    let lines = selected(ON_THE_LINE, |_, random| line(Rule::WoundWait, random));
    let paper = selected(&["rule"], |_, random| line(Rule::Paper, random));
    let worlds = polygons();
    let mut hulls = selected(ON_THE_HULL, |seed, _| worlds[seed as usize % worlds.len()].clone());
    hulls.push(shortest("place", Defect::LostPlace, worlds::asked_again()));
    hulls.push(shortest("waiters", Defect::LeftWaiters, worlds::late_elsewhere()));
    // R1 to R15, each by its own variant; line and hull know nothing of R16 to R18.
    for (flag, defect) in BROKEN {
        let is_shown = shows(&lines, defect) || shows(&hulls, defect);
        assert!(is_shown, "a variant of `{flag}` passes every case");
    }
    let file = |folder, name, tier, about, cases| File { folder, name, tier, about, cases };
    let (protocol, wrong) = ("protocol", "interleavings");
    let about = "Runs of broken protocols: where they go wrong.";
    let traces = [forbidden(&lines), forbidden(&paper), forbidden(&hulls)].concat();
    vec![
        file(protocol, "human", 1, "Runs to be followed by hand.", by_hand()),
        file(protocol, "wound-wait", 2, "Runs of the default rule, with moves.", cases(&lines)),
        file(protocol, "rules", 3, "Runs of the paper's rule.", cases(&paper)),
        file(protocol, "hull", 3, "Cavities of several cells, on the hull.", cases(&hulls)),
        file(wrong, "forbidden", 2, about, traces),
    ]
}

/// The shortest way to a defect that is planted.
fn way(defect: Defect, world: &Polygon) -> Vec<Turn> {
    let broken = System::<KnownBad>::new(world.clone());
    let graph = Graph::explore(&broken, Limits { states: 100_000, first_fault: true });
    let bad = graph.faults.first().map(|fault| fault.0).or(graph.deadlocks.first().copied());
    let way = graph.way(bad.unwrap_or_else(|| panic!("{} is not caught", defect.title())));
    let (mut state, mut turns) = (broken.initial(), Vec::new());
    for choice in way {
        turns.extend(match choice {
            Choice::Deliver(from, to, _) => Some(Turn::Deliver { from, to }),
            Choice::Work(w) => Some(Turn::Work(w)),
            Choice::Retry(w, ticket) => Some(Turn::Retry(w, ticket)),
            Choice::Cancel(w) => Some(Turn::Cancel(w)),
            Choice::Move => {
                let next = broken.next_move(&state);
                next.map(|Migration { from, block, to }| Turn::Migrate { worker: from, block, to })
            }
        });
        state = broken.after(&state, choice);
    }
    turns
}

/// A run that begins with the shortest way to a defect, for a rule that random runs hardly ever
/// show.
fn shortest(flag: &str, defect: Defect, world: Polygon) -> Shown<Polygon> {
    let turns = defect.planted(|| way(defect, &world));
    // A step that leaves the rule need not show at once: the end is chosen at random.
    let ends = (0..200).filter_map(|seed| {
        let run = play(&world, &turns, Chances::default(), LONGEST, &mut Rng::new(seed))?;
        let found = flags(&world, &run);
        found.contains(&flag).then(|| (world.clone(), run, found))
    });
    let shortest = ends.min_by_key(|(_, run, _)| run.turns.len());
    shortest.unwrap_or_else(|| panic!("{}: no run shows {flag}", world.name))
}

/// Does a run fail under this variant?
fn shows<T: Start>(shown: &[Shown<T>], defect: Defect) -> bool {
    let fails =
        |(start, run, _): &Shown<T>| differs(run, &broken(defect, start, &run.turns)).is_some();
    shown.iter().any(fails)
}

fn cases<T: Start>(shown: &[Shown<T>]) -> Vec<Case> {
    let one = |(start, run, flags): &Shown<T>| {
        case(&format!("a run under {}", start.rule()), flags.clone(), start, run)
    };
    shown.iter().map(one).collect()
}

/// The runs under each broken rule: the steps up to where they go wrong. Of each rule, the shortest
/// two.
fn forbidden<T: Start>(shown: &[Shown<T>]) -> Vec<Case> {
    let mut cases = Vec::new();
    for (flag, defect) in BROKEN {
        let mut of: Vec<(usize, &T, &Run, Run)> = Vec::new();
        for (start, run, _) in shown {
            let wrong = broken(defect, start, &run.turns);
            let first = differs(run, &wrong).filter(|&k| k < wrong.steps.len());
            of.extend(first.map(|first| (first, start, run, wrong)));
        }
        of.sort_by_key(|&(first, ..)| first);
        for (first, start, run, wrong) in of.into_iter().take(2) {
            let turns: Vec<Value> = run.turns[..=first].iter().map(|turn| turn.json()).collect();
            let (mesh, setup) = start.json();
            cases.push(Case {
                name: format!("step {first} is not the protocol's"),
                flags: vec![flag],
                ask: json!({
                    "op": "judge", "mesh": mesh, "setup": setup, "events": turns,
                    "steps": wrong.steps[..=first],
                }),
                expect: json!({"wrong": first}),
            });
        }
    }
    cases
}

/// Two workers, two blocks: 0 to 7 and 8 to 15.
fn two(start: &[i64], points: [&[i64]; 2]) -> Setup {
    Setup {
        rule: Rule::WoundWait,
        window: 4,
        cuts: Cuts { range: 16, blocks: 2 },
        owners: vec![WorkerId::default(), WorkerId::new(1)],
        start: start.to_vec(),
        points: points.iter().map(|list| list.to_vec()).collect(),
    }
}

fn by_hand() -> Vec<Case> {
    let [one, other] = [WorkerId::new(0), WorkerId::new(1)];
    let deliver = |from, to| Turn::Deliver { from, to };
    let there_and_back = [deliver(one, other), deliver(other, one)];
    let local = (two(&[4, 8, 12], [&[2], &[14]]), vec![Turn::Work(one), Turn::Work(other)]);
    let interface = (
        two(&[4, 8, 12], [&[6], &[]]),
        [vec![Turn::Work(one)], there_and_back.to_vec(), vec![deliver(one, other)]].concat(),
    );
    let walk = (two(&[4, 8, 12], [&[13], &[]]), vec![Turn::Work(one), deliver(one, other)]);
    let duplicate = (
        two(&[4, 8, 12], [&[4, 12], &[]]),
        vec![Turn::Work(one), Turn::Work(one), deliver(one, other)],
    );
    let cancel = (
        two(&[4, 8, 12], [&[2, 3], &[14]]),
        vec![Turn::Work(one), Turn::Cancel(one), Turn::Cancel(other)],
    );
    // Both want the two cells on either side of 8.
    let conflict = (
        two(&[4, 8, 12], [&[6], &[10]]),
        vec![Turn::Work(one), Turn::Work(other), deliver(one, other), deliver(other, one)],
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
        let first = replay::<_, Correct>(&setup, &turns);
        assert_eq!(first.turns, turns, "{name}: every event is possible");
        let run = to_the_end(&setup, turns);
        let more = flags(&setup, &run).into_iter().filter(|f| *f != flag);
        case(name, [flag].into_iter().chain(more).collect(), &setup, &run)
    })
    .collect()
}
