//! An owner or a home gets an event in a given state: every row of the two tables of
//! `docs/protocol.md` against the real `step`, in random runs over the line and the hull, and every
//! message that the tables say cannot come. Twenty of these pairs, drawn by seed, are the self-test
//! of `docs/porting.md`.

#[path = "questions/tables.rs"]
mod tables;

use ltbw::balance::Workload;
use ltbw::check::{OperationView, RequestView};
use ltbw::protocol::{Action, Attempt, Correct, Event, Message, Note, Rule};
use ltbw::protocol::{Submesh, Ticket, Worker, WorkerId};
use ltbw_kit::line::Line;
use ltbw_kit::protocol::{line, polygons};
use ltbw_kit::quiet::quietly;
use ltbw_kit::world::{Start, Turn, World};
use ltbw_tests::families::Rng;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use tables::{Look, Step, WITHIN, at_home, at_owner, home, look, owner};

fn page(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(name);
    std::fs::read_to_string(path).expect("a page")
}

/// The rows of the table of a section, cell by cell: state, event, guard, action, next.
fn table(section: &str) -> Vec<Vec<String>> {
    let page = page("protocol.md");
    let section = page.split("\n## ").find(|part| part.starts_with(section)).expect("a section");
    let rows = section.lines().filter(|line| line.starts_with("| ") && !line.contains("| state"));
    let cells = |row: &str| {
        let cells: Vec<String> = row.split('|').map(|cell| cell.trim().to_owned()).collect();
        cells[1..cells.len() - 1].to_vec()
    };
    let rows: Vec<Vec<String>> = rows.map(cells).collect();
    assert!(rows.iter().all(|row| row.len() == 5), "{rows:#?}");
    rows
}

/// Where a question comes from: role, state, event, and the row (none: it cannot happen).
type Pair = (&'static str, String, &'static str, Option<usize>);

/// All that was seen: questions with their answers.
#[derive(Default)]
struct Seen(BTreeMap<Pair, Vec<[String; 2]>>);

/// Questions of one kind that are kept.
const KEPT: usize = 30;

impl Seen {
    fn add(&mut self, pair: Pair, question: impl FnOnce() -> [String; 2]) {
        let of = self.0.entry(pair).or_default();
        if of.len() < KEPT {
            of.push(question());
        }
    }
}

fn list<T: ToString>(items: &[T]) -> String {
    items.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// The state in words.
fn state<T>(role: &str, look: &Look<T>) -> String {
    match (role, &look.home, &look.request) {
        ("home", Some(OperationView { state, attempt, asked }), _) if asked.is_empty() => {
            format!("`{state}`, attempt {attempt}")
        }
        ("home", Some(OperationView { state, attempt, asked }), _) => {
            format!("`{state}`, attempt {attempt}, has asked {}", list(asked))
        }
        ("home", None, _) => "no operation".to_owned(),
        (_, _, Some(RequestView { attempt, owed, held, .. })) => {
            let held = held.len();
            format!("{}, attempt {attempt}, {held} locked, {owed} owed", look.owner())
        }
        _ => "no request".to_owned(),
    }
}

fn messages<S: Submesh>(sent: &[(WorkerId, &Message<S>)]) -> String {
    let each: Vec<String> = sent.iter().map(|(to, m)| format!("{} to {to}", m.kind())).collect();
    if each.is_empty() {
        "nothing is sent".to_owned()
    } else {
        format!("sent: {}", each.join(", "))
    }
}

fn question<S: Submesh + Clone>(
    (role, me): (&str, WorkerId),
    state: &str,
    message: Option<(WorkerId, &Message<S>)>,
    is_mine: bool,
) -> String {
    let event = match message {
        None => "`Work`".to_owned(),
        Some((from, message)) => {
            let attempt = message.clone().attempt_mut().map(|(_, attempt)| *attempt);
            let attempt = attempt.unwrap_or_default();
            let more = match message {
                Message::Commit { patch: Some(_), .. } => "with a patch".to_owned(),
                Message::Commit { .. } => "without a patch".to_owned(),
                Message::Walk { .. } if is_mine => "into a block that is here".to_owned(),
                Message::Walk { .. } => "into a block that has left".to_owned(),
                _ => format!("of attempt {attempt}"),
            };
            format!("`{}` {more} from {from}", message.kind())
        }
    };
    format!("worker {me} as {role}: {state} | {event}")
}

/// One turn: compares what it does with the tables, and notes it.
fn observe<T: Start>(world: &mut World<T, Correct>, turn: Turn, seen: &mut Seen) {
    let me = turn.worker();
    let before = world.workers[me.index()].clone();
    let message = match turn {
        Turn::Deliver { from, to } => {
            world.channels.get(&(from, to)).and_then(|queue| queue.front()).cloned()
        }
        _ => None,
    };
    let actions = world.turn(turn).expect("the correct protocol breaks nothing");
    let after = &world.workers[me.index()];
    let sent: Vec<(WorkerId, &Message<T::Mesh<Correct>>)> = actions
        .iter()
        .filter_map(|action| match action {
            Action::Send { to, message } => Some((*to, message)),
            _ => None,
        })
        .collect();
    let notes: Vec<Note> = actions
        .iter()
        .filter_map(|action| if let Action::Note(note) = action { Some(*note) } else { None })
        .collect();
    let attempt =
        message.clone().and_then(|mut m| m.attempt_mut().map(|(_, a)| *a)).unwrap_or_default();
    let (event, from) = match (turn, &message) {
        (Turn::Deliver { from, .. }, Some(message)) => (message.kind(), from),
        (Turn::Work(_), _) => ("work", me),
        _ => ("", me),
    };
    let ready = before.operations().find(|&t| look(&before, t).phase() == "Ready");
    let new = after.operations().find(|&t| before.operation_of(t).is_none());
    let ticket = match event {
        "work" => ready.or(new).or_else(|| sent.iter().find_map(|(_, m)| m.ticket())),
        _ => message.as_ref().and_then(Message::ticket),
    };
    let committed = notes.iter().find_map(|note| match note {
        Note::Committed { ticket, .. } => Some(*ticket),
        _ => None,
    });
    let ticket = ticket.or(committed).unwrap_or(Ticket { clock: 0, worker: me, sequence: 0 });
    let is_mine = match &message {
        Some(Message::Walk { at: Some(at), .. }) => before.directory().is_mine(at.block),
        _ => true,
    };
    let patched = matches!(&message, Some(Message::Commit { patch: Some(_), .. }));
    let step = Step {
        me,
        is_mine,
        from,
        ticket,
        attempt: if event == "work" { look(&before, ticket).attempt() } else { attempt },
        before: look(&before, ticket),
        after: look(after, ticket),
        sent,
        notes,
    };
    // The rest of `Work` is the token's.
    let points = before.source().left() > after.source().left();
    let worked = event != "work" || ready.is_some() || points;
    let (role, row, rows) = match event {
        "work" | "walk" | "grant" | "wound" | "aborted" if worked => {
            ("home", at_home(event, &step.before, attempt, step.is_mine), home())
        }
        "expand" | "abort" | "commit" => {
            ("owner", at_owner(event, &step.before, attempt, patched), owner())
        }
        _ => ("", None, Vec::new()),
    };
    if !role.is_empty() {
        let before = state(role, &step.before);
        let row = row.unwrap_or_else(|| panic!("no row: {role}, {before}, {event}"));
        let ([.., action, next], test) = rows[row];
        assert!(
            test(&step),
            "{role}, {before}, {event}: not \"{action}\", but {}: {:?}",
            messages(&step.sent),
            step.after
        );
        let plain = if role == "home" { step.before.phase() } else { step.before.owner() };
        seen.add((role, plain.to_owned(), event_name(event), Some(row)), || {
            let action = if action.is_empty() { "nothing" } else { action };
            let here = format!("{}; {}", messages(&step.sent), state(role, &step.after));
            let answer = format!("{action}. Next: {next}. (In this run: {here})");
            let message = message.as_ref().map(|m| (from, m));
            [question((role, me), &before, message, step.is_mine), answer]
        });
    }
    within::<T>(&before, &step, after, seen);
}

/// Operations that the event is not about: they change by the rows inside a step only, or by
/// messages of the worker to itself.
fn within<T: Start>(
    before: &Worker<T::Mesh<Correct>, T::Points<Correct>, Correct>,
    step: &Step<'_, T::Mesh<Correct>>,
    after: &Worker<T::Mesh<Correct>, T::Points<Correct>, Correct>,
    seen: &mut Seen,
) {
    let others: BTreeSet<Ticket> = before.operations().chain(before.requests()).collect();
    for ticket in others.into_iter().filter(|&t| t != step.ticket) {
        let (old, new) = (look(before, ticket), look(after, ticket));
        if old.phase() == "Walking" && new.phase() == "Ready" {
            seen.add(("home", "Walking".into(), "within", None), Default::default);
        } else if old.home.is_some() && old.phase() != new.phase() {
            let cause = |note: &Note| match note {
                Note::Committed { ticket: of, .. } | Note::SetBack { ticket: of, .. } => {
                    *of == ticket
                }
                _ => false,
            };
            assert!(step.has(cause), "{} becomes {} by itself", old.phase(), new.phase());
        }
        if old.home.is_some() || old.owner() == new.owner() {
            continue;
        }
        assert_eq!((old.owner(), new.owner()), ("stalled", "granted"), "{ticket:?}");
        seen.add(("owner", "stalled".into(), "within", None), Default::default);
    }
}

/// The events by their names on the page.
fn event_name(event: &str) -> &'static str {
    let all = ["work", "walk", "grant", "wound", "aborted", "expand", "abort", "commit"];
    all.into_iter().find(|name| *name == event).expect("an event")
}

/// Sends a worker what cannot come in its state, by the tables, and sees it stop.
fn forge<T: Start>(world: &World<T, Correct>, sample: &Mail<T>, seen: &mut Seen) {
    for worker in &world.workers {
        let nobody = Ticket { clock: 1 << 20, worker: worker.id(), sequence: 1 };
        let known: BTreeSet<Ticket> = worker.operations().chain(worker.requests()).collect();
        for ticket in known.into_iter().chain([nobody]) {
            let old = look(worker, ticket);
            for attempt in [old.attempt(), old.attempt().next()] {
                for message in forged(ticket, attempt, sample) {
                    let event = event_name(message.kind());
                    let (role, plain, row) = if ["expand", "abort", "commit"].contains(&event) {
                        ("owner", old.owner(), at_owner(event, &old, attempt, false))
                    } else {
                        ("home", old.phase(), at_home(event, &old, attempt, true))
                    };
                    let pair = (role, plain.to_owned(), event, None);
                    if row.is_some() || seen.0.get(&pair).is_some_and(|of| of.len() >= KEPT) {
                        continue;
                    }
                    let mut copy = worker.clone();
                    let to = (role, worker.id());
                    let asked = question(
                        to,
                        &state(role, &old),
                        Some((WorkerId::default(), &message)),
                        true,
                    );
                    let event = Event::Message { from: worker.id(), message };
                    let answered = quietly(|| copy.step(event, &mut Vec::new()));
                    assert!(answered.is_none(), "{pair:?}, attempt {attempt}: {old:?}");
                    let answer = "cannot happen (P8): the run stops with an error".to_owned();
                    seen.add(pair, || [asked, answer]);
                }
            }
        }
    }
}

type Mail<T> = Option<(Message<<T as Start>::Mesh<Correct>>, Message<<T as Start>::Mesh<Correct>>)>;

/// Messages about an operation, made up; `sample` is a `Walk` and an `Expand` seen before.
fn forged<S: Submesh>(
    ticket: Ticket,
    attempt: Attempt,
    sample: &Option<(Message<S>, Message<S>)>,
) -> Vec<Message<S>> {
    let (pieces, foreign, bounced) = (Vec::new(), Vec::new(), Vec::new());
    let moved = Vec::new();
    let mut all = vec![
        Message::Grant { ticket, attempt, answers: 1, pieces, foreign, bounced, moved },
        Message::Aborted { ticket, attempt },
        Message::Abort { ticket, attempt },
        Message::Commit { ticket, patch: None },
    ];
    if let Some((Message::Walk { point, at, .. }, Message::Expand { seeds, .. })) = sample {
        let (point, around) = (point.clone(), Vec::new());
        all.push(Message::Walk { ticket, attempt, point: point.clone(), at: *at });
        all.push(Message::Expand { ticket, attempt, point, seeds: seeds.clone(), around });
    }
    all
}

/// A random run, each turn compared with the tables.
fn run<T: Start>(start: &T, mut moves: u64, random: &mut Rng, seen: &mut Seen) {
    let mut world = World::<T, Correct>::new(start);
    let (mut walk, mut expand) = (None, None);
    // Ends: every run of the protocol does, and moves are few.
    while let Some(turn) = world.draw(&mut moves, false, random) {
        for message in world.channels.values().flatten() {
            match message {
                Message::Walk { .. } => walk = Some(message.clone()),
                Message::Expand { .. } => expand = Some(message.clone()),
                _ => {}
            }
        }
        if random.below(8) == 0 {
            forge(&world, &walk.clone().zip(expand.clone()), seen);
        }
        observe(&mut world, turn, seen);
    }
}

fn observed() -> Seen {
    let (mut seen, polygons) = (Seen::default(), polygons());
    for seed in 0..1_500 {
        let mut random = Rng::new(seed);
        let (start, moves) = line(Rule::WoundWait, &mut random);
        run(&start, moves, &mut random, &mut seen);
        let (start, moves) = &polygons[seed as usize % polygons.len()];
        run(start, *moves, &mut random, &mut seen);
    }
    seen
}

/// The tables have these rows and no others.
#[test]
fn the_tables_of_the_page_are_those_tested() {
    for (section, rows) in [("The home", home::<Line>()), ("The owner", owner::<Line>())] {
        let inside = |row: &[String]| WITHIN.iter().any(|w| w.0 == row[0] && w.1 == row[1]);
        let rest: Vec<Vec<String>> = table(section).into_iter().filter(|r| !inside(r)).collect();
        let tested: Vec<Vec<String>> =
            rows.iter().map(|(cells, _)| cells.map(str::to_owned).to_vec()).collect();
        assert_eq!(rest, tested, "{section}");
    }
}

#[test]
fn steps_answer_as_the_tables_say() {
    let seen = observed();
    let (at_home, at_owner) = (home::<Line>().len(), owner::<Line>().len());
    let at_home = (0..at_home).map(|row| ("home", row));
    let rows: Vec<(&str, usize)> = at_home.chain((0..at_owner).map(|row| ("owner", row))).collect();
    for (role, row) in &rows {
        let has = seen.0.keys().any(|pair| pair.0 == *role && pair.3 == Some(*row));
        assert!(has, "{role}: row {row} never happens");
    }
    for role in ["home", "owner"] {
        assert!(seen.0.keys().any(|pair| pair.0 == role && pair.2 == "within"), "{role}");
    }
    let pairs: Vec<&Pair> = seen.0.keys().filter(|pair| pair.2 != "within").collect();
    assert!(pairs.len() >= 30, "{pairs:#?}");

    // One question for each row, the rest about what cannot happen; which and where, by seed.
    let mut random = Rng::new(20);
    let mut left: Vec<&Pair> = pairs.clone();
    let mut drawn: Vec<&Pair> = Vec::new();
    for row in rows.into_iter().map(Some).chain([None; 20]).take(20) {
        let fits = |pair: &Pair| {
            row.map_or(pair.3.is_none(), |(role, k)| (pair.0, pair.3) == (role, Some(k)))
        };
        let of: Vec<usize> = (0..left.len()).filter(|&k| fits(left[k])).collect();
        let one = left.swap_remove(of[random.below(of.len() as u64) as usize]);
        drawn.insert(random.below(drawn.len() as u64 + 1) as usize, one);
    }
    let (mut asked, mut answers) = (String::new(), String::new());
    for (k, pair) in drawn.into_iter().enumerate() {
        let of = &seen.0[pair];
        let [question, answer] = &of[random.below(of.len() as u64) as usize];
        asked += &format!("| {} | {question} |\n", k + 1);
        answers += &format!("{}. {answer}.\n", k + 1);
    }
    let head = "| | the worker and the operation | the event |\n|---|---|---|\n";
    let text = format!("{head}{asked}\nThe answers:\n\n{answers}");
    let porting = page("porting.md");
    assert!(porting.contains(&text), "docs/porting.md has not these questions:\n{text}");
}
