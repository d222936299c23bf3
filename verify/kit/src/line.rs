//! The mesh of `protocol/`: Bowyer–Watson in dimension 1, small enough to be followed by hand.
//!
//! Cells are intervals between neighbouring integers of a set; the outermost ends are -1 and the
//! range. A point conflicts with the interval that holds it, its ring are the neighbours of that,
//! and two intervals fill the cavity. `verify/vectors/README.md` defines it for ports. Nothing here
//! panics but [`joined`]: runs of known-bad variants meet states that must not be.

use ltbw::balance::Workload;
use ltbw::check::{Inspect, Seen, Sent};
use ltbw::metrics::SubmeshSize;
use ltbw::protocol::{
    BlockId, Costs, Directory, Handle, Insert, Name, Neighbour, NoNews, Part, Rules, Source,
    Submesh, Ticket, Walk, Worker, WorkerId,
};
use ltbw::simulate::Payload;
use ltbw::topology::INFINITE;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// The creator in the names of the first cells: no worker has this number.
pub const START: WorkerId = WorkerId::new(u32::MAX);

/// A cell's name and block.
pub type Place = (Name, BlockId);

/// A neighbour's place; none beyond the ends.
pub type Link = Option<Place>;

/// A link that changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Relink {
    /// The cell.
    pub of: Name,
    /// Its side: 0 left, 1 right.
    pub side: usize,
    /// Its new neighbour there.
    pub to: Place,
}

/// An interval.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Cell {
    /// Left and right end.
    pub ends: (i64, i64),
    /// To the left and to the right.
    pub links: [Link; 2],
}

/// A cell with its name.
pub type Piece = (Name, Cell);

/// The changes that a filled cavity brings to one worker.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Patch {
    /// Cells of the cavity.
    pub remove: Vec<Name>,
    /// New cells.
    pub add: Vec<Piece>,
    /// Links that change.
    pub relink: Vec<Relink>,
}

/// The blocks that the line is cut into.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Cuts {
    /// Vertices are 0 to this, less 1.
    pub range: i64,
    /// Number of blocks, equal parts of the range.
    pub blocks: u32,
}

impl Cuts {
    /// The block of a vertex, and of the cell whose left end it is.
    #[must_use]
    pub fn block(&self, vertex: i64) -> BlockId {
        BlockId::at(
            (vertex.clamp(0, self.range - 1) * i64::from(self.blocks) / self.range) as usize,
        )
    }
}

/// The cells of one worker.
#[derive(Clone, Debug)]
pub struct Line {
    me: WorkerId,
    cuts: Cuts,
    cells: BTreeMap<Name, Cell>,
    locks: BTreeMap<Name, Ticket>,
    named: u32,
    costs: Costs,
}

impl Line {
    /// The part of worker `me` of the line with the vertices `start`.
    #[must_use]
    pub fn new(me: WorkerId, cuts: Cuts, start: &[i64], owners: &[WorkerId]) -> Self {
        let ends: Vec<i64> =
            [-1].into_iter().chain(start.iter().copied()).chain([cuts.range]).collect();
        let count = ends.len() - 1;
        let at = |k: usize| (Name { by: START, number: k as u32 }, cuts.block(ends[k]));
        let mut cells = BTreeMap::new();
        for k in (0..count).filter(|&k| owners[at(k).1.index()] == me) {
            let links = [k.checked_sub(1).map(at), (k + 1 < count).then(|| at(k + 1))];
            cells.insert(at(k).0, Cell { ends: (ends[k], ends[k + 1]), links });
        }
        Self { me, cuts, cells, locks: BTreeMap::new(), named: 0, costs: Costs::default() }
    }

    /// The ends of all cells, from the left.
    #[must_use]
    pub fn ends(&self) -> Vec<(i64, i64)> {
        let mut ends: Vec<(i64, i64)> = self.cells.values().map(|cell| cell.ends).collect();
        ends.sort_unstable();
        ends
    }

    /// The two cells that replace `cell`.
    fn split(&mut self, cell: &Cell, p: i64) -> [Piece; 2] {
        let [left, right] = [1, 2].map(|k| Name { by: self.me, number: self.named + k });
        self.named += 2;
        self.costs.created += 2;
        let (a, b) = cell.ends;
        let [here, there] = [(left, self.cuts.block(a)), (right, self.cuts.block(p))];
        [
            (left, Cell { ends: (a, p), links: [cell.links[0], Some(there)] }),
            (right, Cell { ends: (p, b), links: [Some(here), cell.links[1]] }),
        ]
    }

    fn relink(&mut self, Relink { of, side, to }: Relink) {
        if let Some(cell) = self.cells.get_mut(&of) {
            cell.links[side] = Some(to);
        }
    }

    fn is_free(&self, name: Name) -> bool {
        self.cells.contains_key(&name) && !self.locks.contains_key(&name)
    }

    fn block_of(&self, name: Name) -> Option<BlockId> {
        self.cells.get(&name).map(|cell| self.cuts.block(cell.ends.0))
    }
}

fn handle((name, block): Place) -> Handle {
    Handle { name, block, face: 0 }
}

impl Submesh for Line {
    type Tet = Name;
    type Point = i64;
    type Piece = Piece;
    type Patch = Patch;
    type News = NoNews;
    type Cargo = Vec<Piece>;

    fn walk(&mut self, &p: &i64, from: Option<Name>) -> Walk<Name> {
        self.costs.walk_steps += 3;
        let holds = |cell: &Cell| cell.ends.0 <= p && p <= cell.ends.1;
        let named = from.filter(|name| self.cells.get(name).is_some_and(holds));
        let nearest = || {
            let below = self.cells.iter().filter(|(_, cell)| cell.ends.0 <= p);
            let below = below.max_by_key(|(_, cell)| cell.ends.0);
            below.or_else(|| self.cells.iter().min_by_key(|(_, c)| c.ends.0)).map(|(&name, _)| name)
        };
        let Some(name) = named.or_else(nearest) else { return Walk::NoTets };
        let Some(cell) = self.cells.get(&name) else { return Walk::NoTets };
        let (a, b) = cell.ends;
        if p == a || p == b {
            return Walk::Duplicate(INFINITE); // vertices have no numbers here
        }
        if self.locks.contains_key(&name) {
            return Walk::Locked(name);
        }
        if a < p && p < b {
            return Walk::At(name);
        }
        cell.links[usize::from(p > b)].map_or(Walk::NoTets, |link| Walk::Exits(handle(link)))
    }

    fn insert(&mut self, &p: &i64, seed: Name, directory: &Directory) -> Insert<Name> {
        let Some(cell) = self.cells.get(&seed).cloned() else { return Insert::Blocked };
        let ring = cell.links.iter().flatten().map(|&(name, _)| name);
        if let Some(locked) = [seed].into_iter().chain(ring).find(|n| self.locks.contains_key(n)) {
            return Insert::Locked(locked);
        }
        let mine = [cell.ends.0, p].iter().all(|&v| directory.is_mine(self.cuts.block(v)));
        let free = |link: &Link| link.is_none_or(|(name, _)| self.is_free(name));
        if !mine || !self.is_free(seed) || !cell.links.iter().all(free) {
            return Insert::Blocked;
        }
        self.cells.remove(&seed);
        for (side, (name, made)) in self.split(&cell, p).into_iter().enumerate() {
            if let Some((ring, _)) = cell.links[side] {
                let to = (name, self.cuts.block(made.ends.0));
                self.relink(Relink { of: ring, side: 1 - side, to });
            }
            self.cells.insert(name, made);
        }
        Insert::Done
    }

    fn resolve(&self, name: Name) -> Option<Name> {
        self.cells.contains_key(&name).then_some(name)
    }

    fn holder(&self, t: Name) -> Option<Ticket> {
        self.locks.get(&t).copied()
    }

    fn set_holder(&mut self, t: Name, holder: Option<Ticket>) {
        match holder {
            Some(ticket) => self.locks.insert(t, ticket),
            None => self.locks.remove(&t),
        };
    }

    fn in_conflict(&mut self, t: Name, &p: &i64) -> bool {
        self.costs.tests += 1;
        self.cells.get(&t).is_some_and(|cell| cell.ends.0 < p && p < cell.ends.1)
    }

    fn neighbours(&self, t: Name, mut f: impl FnMut(Neighbour<Name>)) {
        for link in self.cells.get(&t).into_iter().flat_map(|cell| cell.links).flatten() {
            f(if self.cells.contains_key(&link.0) {
                Neighbour::Near(link.0)
            } else {
                Neighbour::Far(handle(link))
            });
        }
    }

    fn pieces(&mut self, tets: &[Name]) -> Vec<Piece> {
        let lost = || Cell { ends: (-1, self.cuts.range), links: [None; 2] };
        tets.iter().map(|&t| (t, self.cells.get(&t).cloned().unwrap_or_else(lost))).collect()
    }

    fn fill(
        &mut self,
        &p: &i64,
        parts: &[Part<Piece>],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) -> Vec<(WorkerId, Patch)> {
        let mut patches: BTreeMap<WorkerId, Patch> = BTreeMap::new();
        for (owner, (old, cell)) in parts.iter().flat_map(|(w, l)| l.iter().map(move |p| (*w, p))) {
            patches.entry(owner).or_default().remove.push(*old);
            let home = self.cuts.block(cell.ends.0);
            for (side, (name, made)) in self.split(cell, p).into_iter().enumerate() {
                let block = self.cuts.block(made.ends.0);
                if let Some((ring, _)) = cell.links[side] {
                    let at = whereabouts(ring).unwrap_or(owner);
                    let relink = Relink { of: ring, side: 1 - side, to: (name, block) };
                    patches.entry(at).or_default().relink.push(relink);
                }
                let to = if block == home { owner } else { directory.owner(block) };
                patches.entry(to).or_default().add.push((name, made));
            }
        }
        patches.into_iter().collect()
    }

    fn apply<C: Rules>(
        &mut self,
        patch: Patch,
        directory: &Directory,
        made: &mut Vec<Name>,
        strays: &mut Vec<BlockId>,
    ) {
        for name in patch.remove {
            self.cells.remove(&name);
        }
        for (name, cell) in patch.add {
            let block = self.cuts.block(cell.ends.0);
            if !directory.is_mine(block) {
                strays.push(block);
            }
            made.push(name);
            self.cells.insert(name, cell);
        }
        if C::relinks_interface() {
            patch.relink.into_iter().for_each(|relink| self.relink(relink));
        }
    }

    fn is_block_locked(&self, block: BlockId) -> bool {
        self.locks.keys().any(|&name| self.block_of(name) == Some(block))
    }

    fn extract<C: Rules>(
        &mut self,
        block: BlockId,
        moved: &mut dyn FnMut(Name, Handle),
    ) -> Vec<Piece> {
        let mut out: Vec<Piece> = Vec::new();
        let cuts = self.cuts;
        self.cells.retain(|&name, cell| {
            let goes = cuts.block(cell.ends.0) == block;
            if goes {
                moved(name, handle((name, block)));
                out.push((name, cell.clone()));
            }
            !goes
        });
        out
    }

    fn adopt(&mut self, cargo: Vec<Piece>, made: &mut Vec<Name>) {
        for (name, cell) in cargo {
            made.push(name);
            self.cells.insert(name, cell);
        }
    }

    fn take_costs(&mut self) -> Costs {
        std::mem::take(&mut self.costs)
    }
}

impl Inspect for Line {
    fn seen(&self) -> Vec<Seen<Name>> {
        let look = |(&name, cell): (&Name, &Cell)| {
            let mut links = Vec::new();
            self.neighbours(name, |link| links.push(link));
            Seen {
                tet: name,
                name: Some(name),
                vertices: key(cell),
                block: self.cuts.block(cell.ends.0),
                holder: self.locks.get(&name).copied(),
                links,
            }
        };
        self.cells.iter().map(look).collect()
    }

    fn made(patch: &Patch) -> Vec<Sent> {
        sent(&patch.add)
    }

    fn carried(cargo: &Vec<Piece>) -> Vec<Sent> {
        sent(cargo)
    }
}

/// A key that tells a cell from all others.
fn key(cell: &Cell) -> Vec<u64> {
    vec![cell.ends.0 as u64, cell.ends.1 as u64]
}

fn sent(cells: &[Piece]) -> Vec<Sent> {
    cells.iter().map(|(name, cell)| (Some(*name), key(cell))).collect()
}

impl SubmeshSize for Line {
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

    fn news_bytes(news: &NoNews) -> u64 {
        match *news {}
    }
}

/// The vertices of a finished run's lines together.
///
/// # Panics
/// If the cells do not cover the line, are locked or at the wrong worker, or if links are not
/// mutual.
#[must_use]
pub fn joined<C: Rules>(workers: &[Worker<Line, Queue, C>]) -> BTreeSet<i64> {
    let mut ends: Vec<(i64, i64)> = workers.iter().flat_map(|w| w.mesh().ends()).collect();
    ends.sort_unstable();
    assert!(ends.windows(2).all(|pair| pair[0].1 == pair[1].0), "a gap or an overlap");
    let mut all: BTreeMap<Name, &Cell> = BTreeMap::new();
    workers.iter().for_each(|w| all.extend(w.mesh().cells.iter().map(|(&name, c)| (name, c))));
    for worker in workers {
        let line = worker.mesh();
        assert!(line.locks.is_empty(), "a lock is left");
        for (&name, cell) in &line.cells {
            let block = line.cuts.block(cell.ends.0);
            assert!(worker.directory().is_mine(block), "a cell is not where its block is");
            for (side, link) in cell.links.iter().enumerate() {
                let Some((far, block)) = link else { continue };
                let back = all.get(far).and_then(|other| other.links[1 - side]);
                assert_eq!(back.map(|(name, _)| name), Some(name), "links are not mutual");
                assert_eq!(line.cuts.block(all[far].ends.0), *block, "a link to another block");
            }
        }
    }
    ends[1..].iter().map(|cell| cell.0).collect()
}

/// Points in a queue.
#[derive(Clone, Debug, Default)]
pub struct Queue {
    points: VecDeque<i64>,
    cuts: Option<Cuts>,
}

impl Queue {
    /// These points, the first one first.
    #[must_use]
    pub fn new(points: &[i64], cuts: Cuts) -> Self {
        Self { points: points.iter().copied().collect(), cuts: Some(cuts) }
    }
}

impl Source<Line> for Queue {
    fn next(&mut self, _: &Line) -> Option<i64> {
        self.points.pop_front()
    }

    fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    fn inserted(&mut self, _: &Line, _: &i64) {}

    fn remove_block(&mut self, _: &Line, block: BlockId) -> Vec<i64> {
        let cuts = self.cuts;
        let goes = |p: &i64| cuts.is_some_and(|cuts| cuts.block(*p) == block);
        let taken = self.points.iter().copied().filter(goes).collect();
        self.points.retain(|p| !goes(p));
        taken
    }

    fn add(&mut self, _: BlockId, points: Vec<i64>) {
        self.points.extend(points);
    }

    fn clear(&mut self) {
        self.points.clear();
    }
}

impl Workload for Queue {
    fn left(&self) -> u64 {
        self.points.len() as u64
    }

    fn in_block(&self, block: BlockId) -> u64 {
        let Some(cuts) = self.cuts else { return 0 };
        self.points.iter().filter(|&&p| cuts.block(p) == block).count() as u64
    }
}
