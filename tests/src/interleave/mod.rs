//! The parallel kernel one event at a time, in an order that the caller chooses: workers'
//! units of work, deliveries (first in, first out between each pair of workers), ends of backoffs,
//! moves of blocks and a cancel.
//!
//! [`Case::play`] runs a point set to its end and checks what must hold there, whatever the order
//! was: nothing locked, awaited or under way; one owner for each block, and a way to it from every
//! worker; the mesh whole, certified by the independent checker, and the sequential kernel's.
//! [`Case::refine`] does so with a domain that the workers refine in rounds.

mod ending;
mod rounds;

use crate::families::Rng;
use ltbw::check::{Between, History, Inspect, NewsNumbers, UnderWay, check_news, count_news};
use ltbw::mesh::{Gathered, Layout, LocalMesh};
use ltbw::protocol::{
    Action, BlockId, Closure, Config, Event, Message, Note, Rule, Source, Submesh, SubmeshError,
    Worker, WorkerId,
};
use ltbw::{BuildError, Mesh, PointSet};
use std::collections::{BTreeMap, VecDeque};

/// Turns after which a run counts as hanging, per point.
const TURNS_PER_POINT: usize = 4000;

/// Turns after which an event that [`Tempo`] or slowness holds back may happen all the same.
const RESPITE: usize = 16;

/// Which events come before others, while there are any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tempo {
    /// All are alike.
    Even,
    /// Local work first: messages are under way for long.
    LateMail,
    /// Messages first.
    EarlyMail,
    /// Messages between workers whose numbers differ by an odd number are under way for long: the
    /// others overtake them.
    FarHalf,
}

impl Tempo {
    /// Every one of them.
    pub const ALL: [Self; 4] = [Self::Even, Self::LateMail, Self::EarlyMail, Self::FarHalf];

    fn prefers(self, choice: Choice) -> bool {
        match (self, choice) {
            (Self::LateMail, Choice::Deliver(..)) => false,
            (Self::EarlyMail, Choice::Work(_)) => false,
            (Self::FarHalf, Choice::Deliver(from, to)) => (from + to).is_multiple_of(2),
            _ => true,
        }
    }
}

/// An event that can happen next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Choice {
    Deliver(usize, usize),
    Work(usize),
    /// The end of a backoff, by its place in the list.
    Retry(usize),
    Move,
    Cancel(usize),
}

/// All that determines a run but the order of its events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Case {
    /// Workers, blocks, cursors, sample.
    pub layout: Layout,
    /// The conflict rule.
    pub rule: Rule,
    /// The closure that operations lock.
    pub closure: Closure,
    /// The kind of events that comes first.
    pub tempo: Tempo,
    /// A worker to which something happens each 16th turn only, while it does to others.
    pub slow: Option<usize>,
    /// Moves of blocks that are tried.
    pub moves: u32,
    /// The turn from which on workers hear of a cancel, each at its own time.
    pub cancel: Option<usize>,
    /// Every message goes through bytes: nothing in it can point to shared memory.
    pub bytes: bool,
}

/// Figures of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Figures {
    /// Events.
    pub turns: usize,
    /// Operations set back, each time counted.
    pub setbacks: usize,
    /// Operations whose closure was locked.
    pub committed: usize,
    /// Blocks that have moved.
    pub moved: usize,
}

impl Figures {
    /// Adds those of another run.
    fn add(&mut self, other: &Self) {
        self.turns += other.turns;
        self.setbacks += other.setbacks;
        self.committed += other.committed;
        self.moved += other.moved;
    }
}

/// A run that ended as it must.
#[derive(Debug)]
pub struct Played {
    /// The mesh gathered.
    pub mesh: Mesh,
    /// Figures of the run.
    pub figures: Figures,
}

/// The source of choices: first the bytes, then a seed.
#[derive(Clone, Debug)]
pub struct Chooser<'a> {
    bytes: std::slice::Iter<'a, u8>,
    rest: Rng,
}

impl<'a> Chooser<'a> {
    /// Each byte is one choice; when there are none left, `seed` goes on.
    #[must_use]
    pub fn new(bytes: &'a [u8], seed: u64) -> Self {
        Self { bytes: bytes.iter(), rest: Rng::new(seed) }
    }

    /// A number below `bound`, which is not 0.
    fn below(&mut self, bound: usize) -> usize {
        match self.bytes.next() {
            Some(&byte) => usize::from(byte) % bound,
            None => self.rest.below(bound as u64) as usize,
        }
    }
}

/// Why a run has no mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The points have none: the sequential kernel says so, too.
    Build(BuildError),
    /// This worker's submesh has failed.
    Submesh(WorkerId, SubmeshError),
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Build(error) => error.fmt(f),
            Self::Submesh(worker, error) => write!(f, "worker {worker}: {error}"),
        }
    }
}

impl Case {
    /// Builds `set` in the order that `chooser` makes; checks the end.
    ///
    /// # Errors
    /// That of the sequential kernel, which the start of the run has to share, or that of a
    /// submesh that has failed.
    ///
    /// # Panics
    /// If the run does not end, or not as it must.
    pub fn play(&self, set: &PointSet, chooser: &mut Chooser) -> Result<Played, Refusal> {
        let expected = ltbw::Builder::new().build(set);
        let (prepared, expected) = match (self.layout.distribute(set), expected) {
            (Ok(prepared), Ok(built)) => (prepared, built.mesh),
            (Err(error), Err(_)) => return Err(Refusal::Build(error)),
            (one, other) => panic!("one is refused: {:?}, {:?}", one.err(), other.err()),
        };
        let config =
            Config { rule: self.rule, closure: self.closure, ..Config::new(self.layout.workers) };
        let nodes = prepared
            .workers
            .into_iter()
            .map(|(directory, mesh, field)| Worker::new(config, directory, mesh, field))
            .collect();
        let way = if self.bytes { through_bytes } else { |message| message };
        let mut world = World::new(*self, nodes, set.len(), way);
        world.run(chooser)?;
        world.check_rest();
        world.check_places();
        let World { nodes, figures, .. } = world;
        let meshes = nodes.into_iter().map(|node| node.into_parts().0).collect();
        let gathered = ltbw::mesh::gather(meshes, prepared.common);
        let Gathered { mesh, duplicates } = gathered.unwrap_or_else(|error| panic!("{error}"));
        ending::certify(set, &mesh, self.cancel.is_none());
        if self.cancel.is_none() {
            assert_eq!(mesh.hash().ok(), expected.hash().ok(), "not the sequential mesh");
            assert_eq!(mesh.duplicates(), expected.duplicates());
            assert_eq!(duplicates, expected.duplicates(), "duplicates are lost");
        } else {
            ending::same_as_anew(&mesh);
        }
        Ok(Played { mesh, figures })
    }
}

/// Workers, and what is under way between them.
struct World<S: Submesh, Q> {
    case: Case,
    nodes: Vec<Worker<S, Q>>,
    channels: BTreeMap<(usize, usize), VecDeque<Message<S>>>,
    /// The fate of a message on its way.
    way: fn(Message<S>) -> Message<S>,
    /// Worker, event, and the turn from which on it may happen.
    backoff: Vec<(usize, Event<S>, usize)>,
    /// Moves left.
    moves: u32,
    /// Workers that have heard of the cancel.
    cancelled: Vec<bool>,
    figures: Figures,
    /// Turns after which a run counts as hanging.
    limit: usize,
    history: History,
    /// News under way.
    news: NewsNumbers,
    /// The invariants are checked each time this number of turns have passed.
    check_every: usize,
}

impl<S: Submesh + Inspect, Q: Source<S>> World<S, Q> {
    fn new(
        case: Case,
        nodes: Vec<Worker<S, Q>>,
        points: usize,
        way: fn(Message<S>) -> Message<S>,
    ) -> Self {
        Self {
            case,
            cancelled: vec![false; nodes.len()],
            nodes,
            channels: BTreeMap::new(),
            way,
            backoff: Vec::new(),
            moves: case.moves,
            figures: Figures::default(),
            limit: TURNS_PER_POINT * (points + 100),
            history: History::default(),
            news: NewsNumbers::default(),
            // A check looks at the whole mesh.
            check_every: if points <= 50 { 1 } else { 2 * points },
        }
    }

    /// Runs until nothing can happen any more.
    fn run(&mut self, chooser: &mut Chooser) -> Result<(), Refusal> {
        loop {
            let failed = self.nodes.iter().find_map(|node| Some((node.id(), node.error()?)));
            if let Some((worker, error)) = failed {
                return Err(Refusal::Submesh(worker, error));
            }
            if !self.turn(chooser) {
                return Ok(());
            }
            assert!(self.figures.turns < self.limit, "no end:\n{}", self.describe());
        }
    }

    /// The events that can happen now; none when all is done.
    fn choices(&self) -> Vec<Choice> {
        let workers = 0..self.nodes.len();
        let mut all: Vec<Choice> =
            self.channels.keys().map(|&(from, to)| Choice::Deliver(from, to)).collect();
        all.extend(workers.clone().filter(|&w| self.nodes[w].has_work()).map(Choice::Work));
        let due = |&k: &usize| self.backoff[k].2 <= self.figures.turns;
        all.extend((0..self.backoff.len()).filter(due).map(Choice::Retry));
        if all.is_empty() {
            all.extend((0..self.backoff.len()).map(Choice::Retry));
        }
        if self.case.cancel.is_some_and(|turn| turn <= self.figures.turns) {
            let open = |&w: &usize| !self.cancelled[w] && !self.nodes[w].is_stopped();
            all.extend(workers.filter(open).map(Choice::Cancel));
        }
        // A move alone keeps no run going.
        if self.moves > 0 && !all.is_empty() {
            all.push(Choice::Move);
        }
        all
    }

    /// The worker to which it happens.
    fn place(&self, choice: Choice) -> Option<usize> {
        match choice {
            Choice::Deliver(_, w) | Choice::Work(w) | Choice::Cancel(w) => Some(w),
            Choice::Retry(k) => Some(self.backoff[k].0),
            Choice::Move => None,
        }
    }

    /// One event; `false` if nothing can happen any more.
    fn turn(&mut self, chooser: &mut Chooser) -> bool {
        let mut choices = self.choices();
        if choices.is_empty() {
            return false;
        }
        self.figures.turns += 1;
        if !self.figures.turns.is_multiple_of(RESPITE) {
            let Case { tempo, slow, .. } = self.case;
            let mut first = choices.clone();
            first.retain(|&c| tempo.prefers(c) && (slow.is_none() || self.place(c) != slow));
            if first.iter().any(|&c| c != Choice::Move) {
                choices = first;
            }
        }
        let choice = choices[chooser.below(choices.len())];
        let mut out = Vec::new();
        let w = match choice {
            Choice::Deliver(from, to) => self.deliver(from, to, &mut out),
            Choice::Work(w) => {
                self.nodes[w].step(Event::Work, &mut out);
                w
            }
            Choice::Retry(k) => {
                let (w, event, _) = self.backoff.swap_remove(k);
                self.nodes[w].step(event, &mut out);
                w
            }
            Choice::Move => self.move_block(chooser, &mut out),
            Choice::Cancel(w) => {
                self.nodes[w].step(Event::Cancel, &mut out);
                self.cancelled[w] = true;
                w
            }
        };
        self.carry_out(w, out, chooser);
        let checked = self.nodes.iter().try_for_each(|node| check_news(node, &self.news));
        if let Err(broken) = checked {
            panic!("{broken}\n{}", self.describe());
        }
        if self.figures.turns.is_multiple_of(self.check_every) {
            self.check_invariants();
        }
        // Nothing gives a cancelled worker more points, be it a block that moves in. (A source that
        // watches ends a round that others have chosen with it.)
        let has_none = Q::WATCHES || self.nodes[w].source().is_empty();
        assert!(!self.cancelled[w] || has_none, "{w} is cancelled");
        true
    }

    fn deliver(&mut self, from: usize, to: usize, out: &mut Vec<Action<S>>) -> usize {
        let Some(queue) = self.channels.get_mut(&(from, to)) else { return to };
        let message = queue.pop_front();
        if queue.is_empty() {
            self.channels.remove(&(from, to));
        }
        if let Some(message) = message {
            count_news(&message, &mut self.news, -1);
            let message = (self.way)(message);
            self.nodes[to].step(Event::Message { from: WorkerId::at(from), message }, out);
        }
        to
    }

    /// A block's owner is told to give it away. It need not.
    fn move_block(&mut self, chooser: &mut Chooser, out: &mut Vec<Action<S>>) -> usize {
        self.moves -= 1;
        let block = BlockId::at(chooser.below(self.nodes[0].directory().blocks().len()));
        let to = WorkerId::at(chooser.below(self.nodes.len()));
        // None: it is under way.
        let owner = self.nodes.iter().position(|node| node.directory().is_mine(block));
        let owner = owner.unwrap_or(0);
        self.nodes[owner].step(Event::Migrate { block, to }, out);
        owner
    }

    fn carry_out(&mut self, w: usize, out: Vec<Action<S>>, chooser: &mut Chooser) {
        for action in out {
            if let Action::Note(note) = action {
                let noted = self.history.note(note);
                assert!(noted.is_ok(), "{noted:?}\n{}", self.describe());
            }
            match action {
                Action::Send { to, message } => {
                    count_news(&message, &mut self.news, 1);
                    self.channels.entry((w, to.index())).or_default().push_back(message);
                }
                Action::Backoff { ticket, attempt } => {
                    // Up to twice as long with each setback: the paper's rule may never end else.
                    let longest = 16_u64 << attempt.number().min(10);
                    let due = self.figures.turns + chooser.rest.below(longest) as usize;
                    self.backoff.push((w, Event::Retry(ticket), due));
                }
                Action::Note(Note::SetBack { .. }) => self.figures.setbacks += 1,
                Action::Note(Note::Committed { .. }) => self.figures.committed += 1,
                Action::Note(Note::Migrated(_)) => self.figures.moved += 1,
                Action::Note(_) => {}
            }
        }
    }

    /// The invariants over all workers and all messages under way.
    fn check_invariants(&mut self) {
        let mail = self.channels.iter().flat_map(|(&(from, to), queue)| {
            let (from, to) = (WorkerId::at(from), WorkerId::at(to));
            queue.iter().map(move |message| UnderWay { from, to, message })
        });
        let between = Between::new(&self.nodes, mail);
        let checked = between.check().and_then(|()| self.history.look(&between));
        if let Err(broken) = checked {
            panic!("{broken}\n{}", self.describe());
        }
    }

    fn describe(&self) -> String {
        let nodes: Vec<String> = self.nodes.iter().map(Worker::describe).collect();
        let mail: Vec<_> = self
            .channels
            .iter()
            .map(|(pair, queue)| (pair, queue.len(), queue[0].kind()))
            .collect();
        format!("{:?}\n{}\n{mail:?}", self.case, nodes.join("\n"))
    }
}

/// The message, written to bytes and read back.
fn through_bytes(message: Message<LocalMesh>) -> Message<LocalMesh> {
    let bytes = serde_json::to_vec(&message).unwrap_or_else(|error| panic!("{error}"));
    let back: Message<LocalMesh> =
        serde_json::from_slice(&bytes).unwrap_or_else(|error| panic!("{error}"));
    let again = serde_json::to_vec(&back).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(bytes, again, "a message changes on its way");
    back
}
