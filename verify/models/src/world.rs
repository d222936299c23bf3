//! Small worlds: a convex polygon dealt out to workers, points to insert, blocks that may move.

use crate::hull::{Hull, Link, Piece, Vertex, block_of, orient};
use crate::rounds::Rounds;
use crate::told::Told;
use crate::variants::Variant;
use crate::witness::Witness;
use ltbw::balance::Workload;
use ltbw::protocol::{BlockId, Config, Directory, Name, Rule, Source, Standing, Worker, WorkerId};
use std::collections::BTreeMap;

/// The points of one worker.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Points {
    /// Points to give, in a world with rounds those of this round.
    left: Vec<Vertex>,
    rounds: Option<Rounds>,
}

impl Points {
    /// Is it choosing the points of a round?
    pub fn is_choosing(&self) -> bool {
        self.rounds.as_ref().is_some_and(Rounds::is_choosing)
    }
}

impl<C: Variant> Source<Hull<C>> for Points {
    fn next(&mut self, _: &Hull<C>) -> Option<Vertex> {
        let may = self.rounds.as_ref().is_none_or(Rounds::inserts);
        (may && !self.left.is_empty()).then(|| self.left.remove(0))
    }

    fn is_empty(&self) -> bool {
        self.left.is_empty() && self.rounds.as_ref().is_none_or(Rounds::is_over)
    }

    fn is_ready(&self) -> bool {
        !self.left.is_empty() && self.rounds.as_ref().is_none_or(Rounds::inserts)
    }

    fn inserted(&mut self, _: &Hull<C>, _: &Vertex) {}

    fn remove_block(&mut self, _: &Hull<C>, block: BlockId) -> Vec<Vertex> {
        let (taken, kept) = self.left.iter().partition(|v| u32::from(v.block) == block.number());
        self.left = kept;
        taken
    }

    fn add(&mut self, _: BlockId, points: Vec<Vertex>) {
        self.left.extend(points);
        self.left.sort_unstable();
    }

    fn clear(&mut self) {
        self.left.clear();
    }

    fn counts(&self) -> bool {
        self.rounds.is_some()
    }

    fn has_thoughts(&self, standing: Standing) -> bool {
        let points = self.left.len();
        self.rounds.as_ref().is_some_and(|rounds| rounds.has_thoughts(standing, points))
    }

    fn think(&mut self, _: &mut Hull<C>, _: &Directory, standing: Standing) {
        if let Some(rounds) = &mut self.rounds {
            rounds.think::<C>(standing, &mut self.left);
        }
    }

    fn hear(&mut self, _: &mut Hull<C>, _: &Directory, from: WorkerId, told: Told) {
        if let Some(rounds) = &mut self.rounds {
            rounds.hear::<C>(from, told, &mut self.left);
        }
    }

    fn tell(&mut self) -> Option<(WorkerId, Told)> {
        self.rounds.as_mut()?.tell()
    }

    fn excluded(&self) -> &'static [&'static str] {
        self.rounds.as_ref().map_or(&[], Rounds::excluded)
    }
}

impl Workload for Points {
    fn left(&self) -> u64 {
        self.left.len() as u64
    }

    fn in_block(&self, block: BlockId) -> u64 {
        self.left.iter().filter(|v| u32::from(v.block) == block.number()).count() as u64
    }
}

/// A worker over the abstract mesh.
pub type Node<C> = Worker<Hull<C>, Points, C>;

/// The order in which messages arrive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Network {
    /// Messages of one sender to one receiver keep their order.
    Fifo,
    /// Any message may overtake any other.
    Unordered,
}

/// The coordinates of a vertex and the number of its block.
pub type Placed = (i16, i16, u8);

/// The numbers of a block that moves and of the worker that gets it.
pub type Moved = (u32, u32);

/// A closed world: everything that can happen follows from it.
#[derive(Clone, Debug)]
pub struct World {
    /// Its name in reports.
    pub name: &'static str,
    /// By block: the worker that owns it at the start.
    pub owners: Vec<WorkerId>,
    /// A convex polygon, counter-clockwise.
    pub polygon: Vec<Vertex>,
    /// Points to insert, at the worker that owns their block.
    pub points: Vec<Vertex>,
    /// Points of a second round, if there are rounds.
    pub second: Option<Vec<Vertex>>,
    /// Moves of blocks to workers, in this order. A move may happen at any time that the protocol
    /// allows it, or never.
    pub moves: Vec<(BlockId, WorkerId)>,
    /// May every worker be cancelled, at any time?
    pub cancels: bool,
    /// The conflict rule.
    pub rule: Rule,
    /// The network.
    pub network: Network,
    /// Is termination detected? Without that a run ends when nothing is left to do.
    pub termination: bool,
    /// Operations that a worker starts at most at a time.
    pub window: usize,
    /// Events that must happen in it.
    pub witnesses: Vec<Witness>,
}

impl World {
    /// A world under wound-wait on ordered channels: no token, no moves, no cancels. Owners are
    /// numbers of workers.
    pub fn new(name: &'static str, owners: &[u32], polygon: &[Placed], points: &[Placed]) -> Self {
        let vertex = |&(x, y, block): &Placed| Vertex { x, y, block };
        Self {
            name,
            owners: owners.iter().copied().map(WorkerId::new).collect(),
            polygon: polygon.iter().map(vertex).collect(),
            points: points.iter().map(vertex).collect(),
            second: None,
            moves: Vec::new(),
            cancels: false,
            rule: Rule::WoundWait,
            network: Network::Fifo,
            termination: false,
            window: 2,
            witnesses: Vec::new(),
        }
    }

    /// This world under another rule.
    pub fn rule(mut self, rule: Rule) -> Self {
        self.rule = rule;
        self
    }

    /// This world on another network.
    pub fn network(mut self, network: Network) -> Self {
        self.network = network;
        self
    }

    /// This world with termination detection.
    pub fn terminating(mut self) -> Self {
        self.termination = true;
        self
    }

    /// This world with a second round of points.
    pub fn then(mut self, second: &[Placed]) -> Self {
        let vertex = |&(x, y, block): &Placed| Vertex { x, y, block };
        self.second = Some(second.iter().map(vertex).collect());
        self
    }

    /// The points of all rounds.
    pub fn all_points(&self) -> impl Iterator<Item = &Vertex> {
        self.points.iter().chain(self.second.iter().flatten())
    }

    /// This world with moves of blocks to workers, by their numbers.
    pub fn moving(mut self, moves: &[Moved]) -> Self {
        let ids = |&(block, to)| (BlockId::new(block), WorkerId::new(to));
        self.moves = moves.iter().map(ids).collect();
        self
    }

    /// This world with cancels.
    pub fn cancelled(mut self) -> Self {
        self.cancels = true;
        self
    }

    /// This world with things that must happen in it.
    pub fn shows(mut self, witnesses: &[Witness]) -> Self {
        self.witnesses = witnesses.to_vec();
        self
    }

    /// Number of workers.
    pub fn workers(&self) -> u32 {
        self.owners.iter().max().map_or(1, |&w| w.number() + 1)
    }

    /// The polygon's edges with their owners.
    fn edges(&self) -> Vec<(WorkerId, Piece)> {
        let n = self.polygon.len();
        let ends = |k: usize| [self.polygon[k % n], self.polygon[(k + 1) % n]];
        let owner = |k| self.owners[block_of(ends(k)).index()];
        let mut given = vec![0; self.workers() as usize];
        let links: Vec<Link> = (0..n)
            .map(|k| {
                let by = owner(k);
                let number = given[by.index()];
                given[by.index()] += 1;
                Link { name: Name { by, number }, block: block_of(ends(k)) }
            })
            .collect();
        let piece = |k: usize| Piece {
            name: links[k].name,
            ends: ends(k),
            links: [links[(k + 1) % n], links[(k + n - 1) % n]],
        };
        (0..n).map(|k| (owner(k), piece(k))).collect()
    }

    /// The workers at the start.
    pub fn nodes<C: Variant>(&self) -> Vec<Node<C>> {
        let edges = self.edges();
        let node = |me| {
            let mine = edges.iter().filter(|(w, _)| *w == me).map(|&(_, edge)| edge).collect();
            let home = |v: &&Vertex| self.owners[usize::from(v.block)] == me;
            let left = self.points.iter().filter(home).copied().collect();
            let second = self.second.as_ref();
            let second = second.map(|all| all.iter().filter(home).copied().collect());
            let rounds = second.map(|second| Rounds::new(me, self.workers(), second));
            let points = Points { left, rounds };
            let config =
                Config { rule: self.rule, window: self.window, ..Config::new(self.workers()) };
            Worker::new(config, Directory::new(me, &self.owners), Hull::new(me, mine), points)
        };
        WorkerId::below(self.workers()).map(node).collect()
    }

    /// For every point: numbers of the owners of the edges that it sees in the polygon.
    pub fn cavities(&self) -> Vec<Vec<u32>> {
        let edges = self.edges();
        let sees = |p: Vertex| {
            let seen = edges.iter().filter(move |(_, e)| orient(e.ends[0], e.ends[1], p) < 0);
            seen.map(|(w, _)| w.number()).collect()
        };
        self.points.iter().map(|&p| sees(p)).collect()
    }

    /// The fault at the end of a run: something left over, or another mesh than the only right
    /// one. If the run was `cancelled`, any subset of the points may have been inserted.
    pub fn fault_at_end<C: Variant>(
        &self,
        nodes: &[&Node<C>],
        cancelled: bool,
    ) -> Option<&'static str> {
        if let Some(what) = nodes.iter().find_map(|node| node.mesh().broken) {
            return Some(what);
        }
        if !nodes.iter().all(|node| node.is_quiescent()) {
            return Some("something is left over at the end");
        }
        if nodes.iter().any(|node| node.mesh().has_locks()) {
            return Some("a lock is left at the end");
        }
        let mut found = Vec::new();
        let mut edges = BTreeMap::new();
        for node in nodes {
            for cell in node.mesh().cells() {
                if !node.directory().is_mine(cell.piece.block()) {
                    return Some("a cell is at the wrong worker");
                }
                found.push(cell.piece.ends);
                edges.insert(cell.piece.name, cell.piece);
            }
        }
        if !links_are_mutual(&edges) {
            return Some("links are not mutual at the end");
        }
        let mut points = self.polygon.clone();
        match cancelled {
            false => points.extend(self.all_points()),
            true => points.extend(found.iter().flatten()),
        }
        points.sort_unstable();
        points.dedup();
        found.sort_unstable();
        (found != brute_force(&points)).then_some("the mesh is wrong at the end")
    }
}

/// The convex hull by brute force: a directed pair is an edge if all other points are to its left.
pub fn brute_force(points: &[Vertex]) -> Vec<[Vertex; 2]> {
    let mut hull = Vec::new();
    for &a in points {
        for &b in points.iter().filter(|&&b| b != a) {
            let left = |&c: &Vertex| c == a || c == b || orient(a, b, c) > 0;
            if points.iter().all(left) {
                hull.push([a, b]);
            }
        }
    }
    hull.sort_unstable();
    hull
}

/// Does every link lead to the cell behind it and back?
fn links_are_mutual(edges: &BTreeMap<Name, Piece>) -> bool {
    edges.values().all(|edge| {
        let shared: [Vertex; 2] = [edge.ends[1], edge.ends[0]];
        (0..2).all(|side| {
            edges.get(&edge.links[side].name).is_some_and(|far| {
                let back = 1 - side;
                far.links[back].name == edge.name && far.ends[side] == shared[side]
            })
        })
    })
}
