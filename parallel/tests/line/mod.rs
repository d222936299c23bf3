//! The smallest mesh that the protocol can run on: Bowyer-Watson in dimension 1.
//!
//! Cells are intervals between neighbouring integers of a set. A point conflicts with the one
//! interval that holds it; its closure has the two neighbours too; two new intervals fill the
//! cavity. The result is the sorted set, whatever the order of insertion.

use ltbw::generate::Random;
use ltbw::metrics::Survey;
use ltbw::protocol::{
    BlockId, Conduct, Config, Costs, Directory, Handle, Name, Neighbour, Source, Submesh, Ticket,
    Walk, Worker, WorkerId,
};
use ltbw::simulate::{Payload, Stock};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// A neighbour's name and block; none beyond the ends.
type Link = Option<(Name, BlockId)>;

/// An interval. Left ends are below 0 for the first one alone.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Cell {
    pub(crate) ends: (i64, i64),
    /// To the left and to the right.
    pub(crate) links: [Link; 2],
    pub(crate) holder: Option<Ticket>,
}

/// What a home must know of an interval.
pub(crate) type Piece = (Name, Cell);

/// What changes at one worker.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Patch {
    remove: Vec<Name>,
    add: Vec<(Name, Cell)>,
    /// Whose link, on which side, and the new one.
    relink: Vec<(Name, usize, Link)>,
}

/// The intervals of one worker.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    me: WorkerId,
    /// Blocks are equal parts of 0 to this.
    range: i64,
    blocks: BlockId,
    cells: BTreeMap<Name, Cell>,
    /// Left end to name.
    places: BTreeMap<i64, Name>,
    names: u32,
    costs: Costs,
}

impl Line {
    fn block(&self, vertex: i64) -> BlockId {
        block(vertex, self.range, self.blocks)
    }

    fn add(&mut self, name: Name, cell: Cell) {
        self.places.insert(cell.ends.0, name);
        self.cells.insert(name, cell);
        self.costs.created += 1;
    }

    fn remove(&mut self, name: Name) -> Option<Cell> {
        let cell = self.cells.remove(&name)?;
        self.places.remove(&cell.ends.0);
        Some(cell)
    }

    fn is_free(&self, link: Link) -> bool {
        link.is_none_or(|(name, _)| self.cells.get(&name).is_some_and(|c| c.holder.is_none()))
    }

    /// The two intervals that replace `cell`.
    fn split(&mut self, cell: &Cell, p: i64) -> [(Name, Cell); 2] {
        let [left, right] = [1, 2].map(|k| Name { by: self.me, number: self.names + k });
        self.names += 2;
        let (a, b) = cell.ends;
        let [here, there] = [Some((left, self.block(a))), Some((right, self.block(p)))];
        let near = Cell { ends: (a, p), links: [cell.links[0], there], holder: None };
        let far = Cell { ends: (p, b), links: [here, cell.links[1]], holder: None };
        [(left, near), (right, far)]
    }

    fn relink(&mut self, name: Name, side: usize, link: Link) {
        if let Some(cell) = self.cells.get_mut(&name) {
            cell.links[side] = link;
        }
    }

    /// All cells, by place.
    pub(crate) fn cells(&self) -> impl Iterator<Item = &Cell> {
        self.places.values().map(|name| &self.cells[name])
    }
}

pub(crate) fn block(vertex: i64, range: i64, blocks: BlockId) -> BlockId {
    (vertex.clamp(0, range - 1) * i64::from(blocks) / range) as BlockId
}

impl Submesh for Line {
    type Tet = Name;
    type Point = i64;
    type Piece = Piece;
    type Patch = Patch;
    type Cargo = Vec<Piece>;

    fn walk(&mut self, &p: &i64, from: Option<Name>) -> Walk<Name> {
        let named = from.and_then(|name| self.cells.get(&name).map(|cell| (name, cell)));
        let first = self.places.values().next();
        let below = self.places.range(..=p).next_back().map(|(_, name)| name).or(first);
        let Some(&below) = below else { return Walk::Nowhere };
        self.costs.walk_steps += 3;
        let nearest = (below, &self.cells[&below]);
        // From the named one if it is the right one: else the nearest.
        let (name, cell) = named.filter(|(_, c)| c.ends.0 <= p && p <= c.ends.1).unwrap_or(nearest);
        let (a, b) = cell.ends;
        if p == a || p == b {
            return Walk::Known;
        }
        if cell.holder.is_some() {
            return Walk::Locked(name);
        }
        let side = usize::from(p > b);
        match cell.links[side] {
            _ if a < p && p < b => Walk::At(name),
            Some((name, block)) => Walk::Leaves(Handle { name, block, face: 0 }),
            None => Walk::Nowhere,
        }
    }

    fn insert(&mut self, &p: &i64, seed: Name, directory: &Directory) -> bool {
        self.costs.tests += 3;
        let cell = self.cells[&seed].clone();
        let mine = [cell.ends.0, p].iter().all(|&v| directory.is_mine(self.block(v)));
        if !mine || cell.holder.is_some() || !cell.links.iter().all(|&link| self.is_free(link)) {
            return false;
        }
        self.remove(seed);
        let new = self.split(&cell, p);
        for (side, (name, made)) in new.into_iter().enumerate() {
            let link = Some((name, self.block(made.ends.0)));
            if let Some((ring, _)) = cell.links[side] {
                self.relink(ring, 1 - side, link);
            }
            self.add(name, made);
        }
        true
    }

    fn resolve(&self, name: Name) -> Option<Name> {
        self.cells.contains_key(&name).then_some(name)
    }

    fn holder(&self, t: Name) -> Option<Ticket> {
        self.cells.get(&t).and_then(|cell| cell.holder)
    }

    fn set_holder(&mut self, t: Name, holder: Option<Ticket>) {
        if let Some(cell) = self.cells.get_mut(&t) {
            cell.holder = holder;
        }
    }

    fn in_conflict(&mut self, t: Name, &p: &i64) -> bool {
        self.costs.tests += 1;
        self.cells.get(&t).is_some_and(|cell| cell.ends.0 < p && p < cell.ends.1)
    }

    fn neighbours(&self, t: Name, mut f: impl FnMut(Neighbour<Name>)) {
        for (name, block) in self.cells[&t].links.into_iter().flatten() {
            f(if self.cells.contains_key(&name) {
                Neighbour::Near(name)
            } else {
                Neighbour::Far(Handle { name, block, face: 0 })
            });
        }
    }

    fn piece(&self, t: Name) -> Piece {
        (t, self.cells[&t].clone())
    }

    fn fill(
        &mut self,
        &p: &i64,
        parts: &[(WorkerId, Vec<Piece>)],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) -> Vec<(WorkerId, Patch)> {
        let pieces = parts.iter().flat_map(|(w, pieces)| pieces.iter().map(|piece| (*w, piece)));
        let mut pieces: Vec<(WorkerId, &Piece)> = pieces.collect();
        assert_eq!(pieces.len(), 1, "one interval holds a point");
        let Some((owner, (old, cell))) = pieces.pop() else { return Vec::new() };
        let mut patches: BTreeMap<WorkerId, Patch> = BTreeMap::new();
        patches.entry(owner).or_default().remove.push(*old);
        let home = self.block(cell.ends.0);
        for (side, (name, made)) in self.split(cell, p).into_iter().enumerate() {
            let block = self.block(made.ends.0);
            if let Some((ring, _)) = cell.links[side] {
                let at = whereabouts(ring).unwrap_or(owner);
                let link = Some((name, block));
                patches.entry(at).or_default().relink.push((ring, 1 - side, link));
            }
            let to = if block == home { owner } else { directory.owner(block) };
            patches.entry(to).or_default().add.push((name, made));
        }
        patches.into_iter().collect()
    }

    fn apply<C: Conduct>(
        &mut self,
        patch: Patch,
        directory: &Directory,
        made: &mut Vec<Name>,
        strays: &mut Vec<BlockId>,
    ) {
        for name in patch.remove {
            assert!(self.remove(name).is_some(), "what a commit removes is here");
        }
        for (name, cell) in patch.add {
            let block = self.block(cell.ends.0);
            if !directory.is_mine(block) {
                strays.push(block);
            }
            made.push(name);
            self.add(name, cell);
        }
        for (name, side, link) in patch.relink {
            assert!(self.cells.contains_key(&name), "a ring is where it was locked");
            self.relink(name, side, link);
        }
    }

    fn is_block_locked(&self, block: BlockId) -> bool {
        self.cells().any(|cell| cell.holder.is_some() && self.block(cell.ends.0) == block)
    }

    fn extract(&mut self, block: BlockId, moved: &mut dyn FnMut(Name, Handle)) -> Vec<Piece> {
        let names: Vec<Name> = self
            .places
            .iter()
            .filter(|(a, _)| self.block(**a) == block)
            .map(|(_, &name)| name)
            .collect();
        names
            .into_iter()
            .filter_map(|name| {
                moved(name, Handle { name, block, face: 0 });
                self.remove(name).map(|cell| (name, cell))
            })
            .collect()
    }

    fn adopt(&mut self, cargo: Vec<Piece>, made: &mut Vec<Name>) {
        for (name, cell) in cargo {
            made.push(name);
            self.add(name, cell);
        }
    }

    fn take_costs(&mut self) -> Costs {
        std::mem::take(&mut self.costs)
    }
}

impl Survey for Line {
    fn tets(&self) -> u64 {
        self.cells.len() as u64
    }

    fn interface_faces(&self) -> u64 {
        let links = self.cells.values().flat_map(|cell| cell.links.into_iter().flatten());
        links.filter(|(name, _)| !self.cells.contains_key(name)).count() as u64
    }
}

impl Payload for Line {
    fn point_bytes(_: &i64) -> u64 {
        8
    }

    fn piece_bytes(_: &Piece) -> u64 {
        48
    }

    fn patch_bytes(patch: &Patch) -> u64 {
        8 * patch.remove.len() as u64 + 48 * patch.add.len() as u64 + 24 * patch.relink.len() as u64
    }

    fn cargo_bytes(cargo: &Vec<Piece>) -> u64 {
        48 * cargo.len() as u64
    }
}

/// Points by block; a few blocks take turns.
#[derive(Clone, Debug, Default)]
pub(crate) struct Supply {
    blocks: BTreeMap<BlockId, VecDeque<i64>>,
    turn: BlockId,
    left: u64,
}

impl Source<Line> for Supply {
    fn next(&mut self, _: &Line) -> Option<i64> {
        let after = self.blocks.range(self.turn..).next().or(self.blocks.iter().next());
        let block = after.map(|(&block, _)| block)?;
        self.turn = block + 1;
        let queue = self.blocks.get_mut(&block)?;
        let point = queue.pop_front()?;
        if queue.is_empty() {
            self.blocks.remove(&block);
        }
        self.left -= 1;
        Some(point)
    }

    fn is_empty(&self) -> bool {
        self.left == 0
    }

    fn inserted(&mut self, _: &Line, _: &i64) {}

    fn take_block(&mut self, _: &Line, block: BlockId) -> Vec<i64> {
        let points: Vec<i64> = self.blocks.remove(&block).map(Vec::from).unwrap_or_default();
        self.left -= points.len() as u64;
        points
    }

    fn give(&mut self, block: BlockId, points: Vec<i64>) {
        self.left += points.len() as u64;
        if !points.is_empty() {
            self.blocks.entry(block).or_default().extend(points);
        }
    }

    fn clear(&mut self) {
        self.blocks.clear();
        self.left = 0;
    }
}

impl Stock for Supply {
    fn left(&self) -> u64 {
        self.left
    }

    fn in_block(&self, block: BlockId) -> u64 {
        self.blocks.get(&block).map_or(0, |queue| queue.len() as u64)
    }
}

/// A problem: a set of integers, some of which are vertices at the start.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    pub(crate) start: BTreeSet<i64>,
    pub(crate) points: Vec<i64>,
    range: i64,
}

impl Problem {
    /// `n` random points and `start` vertices.
    pub(crate) fn new(n: usize, start: usize, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let range = 4 * (n + start) as i64 + 4;
        let mut any = || random.below(range as u64) as i64;
        let start = (0..start).map(|_| any()).collect();
        Self { start, points: (0..n).map(|_| any()).collect(), range }
    }

    /// All vertices at the end.
    pub(crate) fn expected(&self) -> BTreeSet<i64> {
        self.start.iter().chain(&self.points).copied().collect()
    }

    /// The problem cut into blocks, and these given to workers; `even` or most to worker 0.
    pub(crate) fn workers<C: Conduct>(
        &self,
        config: Config,
        per_worker: u32,
        even: bool,
    ) -> Vec<Worker<Line, Supply, C>> {
        let blocks = config.workers * per_worker;
        let owner = |b| if even || b >= blocks / 4 * 3 { b / per_worker } else { 0 };
        let owners: Vec<WorkerId> = (0..blocks).map(owner).collect();
        let ends: Vec<i64> =
            [-1].into_iter().chain(self.start.iter().copied()).chain([self.range]).collect();
        let at = |k: usize| {
            let block = block(ends[k], self.range, blocks);
            (Name { by: owners[block as usize], number: k as u32 }, block)
        };
        let mut workers = Vec::new();
        for me in 0..config.workers {
            let mut mesh = Line {
                me,
                range: self.range,
                blocks,
                cells: BTreeMap::new(),
                places: BTreeMap::new(),
                names: ends.len() as u32,
                costs: Costs::default(),
            };
            let cells = ends.len() - 1;
            for k in (0..cells).filter(|&k| at(k).0.by == me) {
                let links = [k.checked_sub(1).map(at), (k + 1 < cells).then(|| at(k + 1))];
                mesh.add(at(k).0, Cell { ends: (ends[k], ends[k + 1]), links, holder: None });
            }
            let mut supply = Supply::default();
            for &p in &self.points {
                let b = block(p, self.range, blocks);
                if owners[b as usize] == me {
                    supply.give(b, vec![p]);
                }
            }
            workers.push(Worker::new(config, Directory::new(me, &owners), mesh, supply));
        }
        workers
    }
}

/// The vertices of the joined mesh, and a check that its links are mutual.
pub(crate) fn joined<C: Conduct>(workers: &[Worker<Line, Supply, C>]) -> BTreeSet<i64> {
    let mut cells: Vec<(i64, i64)> =
        workers.iter().flat_map(|w| w.mesh().cells().map(|c| c.ends)).collect();
    cells.sort_unstable();
    assert!(cells.windows(2).all(|pair| pair[0].1 == pair[1].0), "no gap and no overlap");
    for worker in workers {
        for (name, cell) in &worker.mesh().cells {
            assert_eq!(cell.holder, None, "nothing is locked");
            let block = worker.mesh().block(cell.ends.0);
            assert!(worker.directory().is_mine(block), "cells are where their block is");
            for (side, link) in cell.links.iter().enumerate() {
                let Some((far, block)) = link else { continue };
                let other = workers.iter().find_map(|w| w.mesh().cells.get(far));
                let other = other.expect("a link names a cell");
                assert_eq!(other.links[1 - side].map(|l| l.0), Some(*name), "links are mutual");
                assert_eq!(worker.mesh().block(other.ends.0), *block);
            }
        }
    }
    cells.iter().map(|c| c.0).skip(1).collect()
}
