//! Bowyer-Watson in the smallest dimension that has cavities: the convex hull in the plane.
//!
//! A *cell* is a directed hull edge, counter-clockwise; a point conflicts with the edges that it
//! sees. Its cavity is a chain of edges, its ring the two edges at the ends of the chain, and the
//! fill makes two new edges:
//!
//! ```text
//!            p                      p
//!                                 /   \
//!      ___________              /       \
//!     /  cavity   \           /           \
//!    / ring   ring \         / ring   ring \
//! ```
//! The lifting map makes a Delaunay triangulation the same thing two dimensions higher. Blocks,
//! names, handles, patches and cargo are as in the real submesh. Nothing here panics: what should
//! not happen sets [`Hull::broken`], which the models' safety property looks at.

use crate::told::Told;
use crate::variants::Variant;
use ltbw::check::{Inspect, Seen, Sent};
use ltbw::protocol::{
    BlockId, Directory, Handle, Insert, Message, Name, Neighbour, Part, Rules, Submesh, Ticket,
    Walk, WorkerId,
};
use ltbw::topology::INFINITE;
use std::collections::{BTreeMap, BTreeSet};
use std::marker::PhantomData;

/// A point of the plane, and the block that its place belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Vertex {
    /// First coordinate.
    pub x: i16,
    /// Second coordinate.
    pub y: i16,
    /// Its block.
    pub block: u8,
}

/// A message over the abstract mesh.
pub type Letter<C> = Message<Hull<C>>;

/// Twice the area of the triangle, positive if it is counter-clockwise.
pub fn orient(a: Vertex, b: Vertex, c: Vertex) -> i32 {
    let [ax, ay, bx, by, cx, cy] = [a.x, a.y, b.x, b.y, c.x, c.y].map(i32::from);
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

/// A hull edge, as messages describe it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Piece {
    /// Its name.
    pub name: Name,
    /// Its vertices, counter-clockwise.
    pub ends: [Vertex; 2],
    /// `links[i]` is the neighbour opposite `ends[i]`: 0 is the edge after it, 1 that before it.
    pub links: [Link; 2],
}

/// A handle less its face, which the side that has the link determines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Link {
    /// The cell's name.
    pub name: Name,
    /// Its block.
    pub block: BlockId,
}

impl Link {
    /// The handle; `side` is the side of the cell that has this link.
    fn handle(self, side: usize) -> Handle {
        Handle { name: self.name, block: self.block, face: 1 - side as u8 }
    }
}

/// The block of an edge: the majority of its vertices' blocks, the smaller one at a tie.
pub fn block_of(ends: [Vertex; 2]) -> BlockId {
    BlockId::new(u32::from(ends[0].block.min(ends[1].block)))
}

/// A worker that there is not.
const NOBODY: WorkerId = WorkerId::new(u32::MAX);

impl Piece {
    /// Its block.
    pub fn block(&self) -> BlockId {
        block_of(self.ends)
    }

    fn link(&self) -> Link {
        Link { name: self.name, block: self.block() }
    }
}

/// The changes that a filled cavity brings to one worker's submesh.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Patch {
    /// Edges of the cavity.
    pub delete: Vec<Name>,
    /// New edges.
    pub create: Vec<Piece>,
    /// Edge, side and new neighbour of each link that changes.
    pub relink: Vec<(Name, usize, Link)>,
}

/// An edge in a worker's hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Cell {
    /// The edge.
    pub piece: Piece,
    /// The operation that has locked it.
    pub holder: Option<Ticket>,
}

/// The edges of one worker.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Hull<C> {
    me: WorkerId,
    /// By slot. A slot is used again; a local handle is a slot.
    cells: Vec<Option<Cell>>,
    /// Names given so far.
    named: u32,
    /// Numbers to be given again, under the known-bad variant that does.
    free: BTreeSet<u32>,
    /// An event that should not have happened.
    pub broken: Option<&'static str>,
    rules: PhantomData<C>,
}

impl<C: Variant> Hull<C> {
    /// The edges of worker `me`, with names that it has given.
    pub fn new(me: WorkerId, edges: Vec<Piece>) -> Self {
        let named = edges.iter().filter(|e| e.name.by == me).map(|e| e.name.number + 1).max();
        let cells = edges.into_iter().map(|piece| Some(Cell { piece, holder: None })).collect();
        let (free, broken) = (BTreeSet::new(), None);
        Self { me, cells, named: named.unwrap_or(0), free, broken, rules: PhantomData }
    }

    /// Its cells.
    pub fn cells(&self) -> impl Iterator<Item = &Cell> {
        self.cells.iter().flatten()
    }

    /// Is any cell locked?
    pub fn has_locks(&self) -> bool {
        self.cells().any(|cell| cell.holder.is_some())
    }

    fn fail(&mut self, what: &'static str) {
        self.broken = self.broken.or(Some(what));
    }

    fn cell(&self, t: u8) -> Option<&Cell> {
        self.cells.get(usize::from(t)).and_then(Option::as_ref)
    }

    /// The name of the cell in a slot.
    pub fn name_of(&self, t: u8) -> Option<Name> {
        self.cell(t).map(|cell| cell.piece.name)
    }

    fn fresh(&mut self) -> Name {
        let number = match self.free.pop_first() {
            Some(again) => again,
            None => {
                self.named += 1;
                self.named - 1
            }
        };
        Name { by: self.me, number }
    }

    /// Takes a cell out of its slot.
    fn remove(&mut self, name: Name) -> Option<Cell> {
        let t = self.resolve(name)?;
        if !C::fresh_names() && name.by == self.me {
            self.free.insert(name.number);
        }
        let cell = self.cells[usize::from(t)].take();
        while self.cells.last().is_some_and(Option::is_none) {
            self.cells.pop();
        }
        cell
    }

    fn place(&mut self, piece: Piece) {
        if self.resolve(piece.name).is_some() {
            self.fail("a name is given twice");
        }
        let cell = Some(Cell { piece, holder: None });
        match self.cells.iter_mut().find(|slot| slot.is_none()) {
            Some(slot) => *slot = cell,
            None => self.cells.push(cell),
        }
    }

    /// The cavity as a chain, in counter-clockwise order with the worker of each edge.
    fn chain(parts: &[Part<Piece>]) -> Result<Vec<(WorkerId, Piece)>, &'static str> {
        let mut by_name: BTreeMap<Name, (WorkerId, Piece)> = BTreeMap::new();
        for (worker, pieces) in parts {
            for &piece in pieces {
                if by_name.insert(piece.name, (*worker, piece)).is_some() {
                    return Err("a cell is granted twice");
                }
            }
        }
        let mut firsts = by_name.values().filter(|(_, e)| !by_name.contains_key(&e.links[1].name));
        let (Some(&first), None) = (firsts.next(), firsts.next()) else {
            return Err("a cavity is not a chain");
        };
        let mut chain = vec![first];
        let mut at = first.1;
        // Ends: no edge is visited twice, else the chain would be longer than its cells.
        while let Some(&next) = by_name.get(&at.links[0].name) {
            if next.1.ends[0] != at.ends[1] || chain.len() == by_name.len() {
                return Err("a cavity has wrong links");
            }
            at = next.1;
            chain.push(next);
        }
        if chain.len() == by_name.len() { Ok(chain) } else { Err("a cavity is not connected") }
    }

    /// The patches that replace the cavity by the two edges at `point`.
    fn star(
        &mut self,
        point: Vertex,
        parts: &[Part<Piece>],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) -> Vec<(WorkerId, Patch)> {
        let chain = match Self::chain(parts) {
            Ok(chain) => chain,
            Err(what) => {
                self.fail(what);
                return Vec::new();
            }
        };
        let [(first_at, first), (last_at, last)] = [chain[0], chain[chain.len() - 1]];
        let ends = [[first.ends[0], point], [point, last.ends[1]]];
        let links = ends.map(|ends| Link { name: self.fresh(), block: block_of(ends) });
        let (before, after) = (first.links[1], last.links[0]);
        let new = [
            Piece { name: links[0].name, ends: ends[0], links: [links[1], before] },
            Piece { name: links[1].name, ends: ends[1], links: [after, links[0]] },
        ];
        let mut patches: BTreeMap<WorkerId, Patch> = BTreeMap::new();
        for (worker, edge) in &chain {
            patches.entry(*worker).or_default().delete.push(edge.name);
        }
        for edge in new {
            patches.entry(directory.owner(edge.block())).or_default().create.push(edge);
        }
        for (ring, near, side, link) in
            [(before, first_at, 0, links[0]), (after, last_at, 1, links[1])]
        {
            let owner = whereabouts(ring.name).unwrap_or(near);
            patches.entry(owner).or_default().relink.push((ring.name, side, link));
        }
        patches.into_iter().collect()
    }

    /// The closure of `point` around `seed`, if all of it is here and unlocked.
    fn local_cavity(&self, point: Vertex, seed: u8) -> Result<Vec<Piece>, Insert<u8>> {
        let mut cavity: Vec<Piece> = Vec::new();
        let mut is_whole = true;
        let mut todo = vec![seed];
        // Ends: every cell is tested once per neighbour.
        while let Some(t) = todo.pop() {
            let cell = self.cell(t).ok_or(Insert::Blocked)?;
            if cell.holder.is_some() {
                return Err(Insert::Locked(t));
            }
            let [a, b] = cell.piece.ends;
            if orient(a, b, point) < 0 && !cavity.iter().any(|e| e.name == cell.piece.name) {
                cavity.push(cell.piece);
                for link in cell.piece.links {
                    match self.resolve(link.name) {
                        Some(next) => todo.push(next),
                        None => is_whole = false,
                    }
                }
            }
        }
        if is_whole { Ok(cavity) } else { Err(Insert::Blocked) }
    }
}

/// A key that tells an edge from all others.
fn key([a, b]: [Vertex; 2]) -> Vec<u64> {
    let place = |v: Vertex| u64::from(v.x as u16) << 16 | u64::from(v.y as u16);
    vec![place(a), place(b)]
}

fn sent(edges: &[Piece]) -> Vec<Sent> {
    edges.iter().map(|edge| (Some(edge.name), key(edge.ends))).collect()
}

impl<C: Variant> Inspect for Hull<C> {
    fn seen(&self) -> Vec<Seen<u8>> {
        let look = |(t, cell): (usize, &Cell)| {
            let mut links = Vec::new();
            self.neighbours(t as u8, |link| links.push(link));
            let Cell { piece, holder } = *cell;
            let (name, block) = (Some(piece.name), piece.block());
            Seen { tet: t as u8, name, vertices: key(piece.ends), block, holder, links }
        };
        let cells = self.cells.iter().enumerate();
        cells.filter_map(|(t, cell)| Some((t, cell.as_ref()?))).map(look).collect()
    }

    fn made(patch: &Patch) -> Vec<Sent> {
        sent(&patch.create)
    }

    fn carried(cargo: &Vec<Piece>) -> Vec<Sent> {
        sent(cargo)
    }

    fn kinds(told: &Told) -> Vec<&'static str> {
        told.kind().into_iter().collect()
    }
}

impl<C: Variant> Submesh for Hull<C> {
    type Tet = u8;
    type Point = Vertex;
    type Piece = Piece;
    type Patch = Patch;
    type News = Told;
    type Cargo = Vec<Piece>;

    /// Goes round counter-clockwise: every edge that the point sees lies ahead.
    fn walk(&mut self, point: &Vertex, from: Option<Name>) -> Walk<u8> {
        let first = || self.cells().map(|cell| cell.piece.name).min();
        let start = from.filter(|&name| self.resolve(name).is_some()).or_else(first);
        let Some(mut t) = start.and_then(|name| self.resolve(name)) else {
            return Walk::NoTets;
        };
        for _ in 0..=self.cells.len() {
            let Some(cell) = self.cell(t) else { break };
            let Piece { ends: [a, b], links, .. } = cell.piece;
            if a == *point || b == *point {
                return Walk::Duplicate(INFINITE); // vertices have no numbers here
            }
            if cell.holder.is_some() {
                return Walk::Locked(t);
            }
            if orient(a, b, *point) < 0 {
                return Walk::At(t);
            }
            match self.resolve(links[0].name) {
                Some(next) => t = next,
                None => return Walk::Exits(links[0].handle(0)),
            }
        }
        Walk::Duplicate(INFINITE)
    }

    fn insert(&mut self, point: &Vertex, seed: u8, directory: &Directory) -> Insert<u8> {
        let cavity = match self.local_cavity(*point, seed) {
            Ok(cavity) => cavity,
            Err(obstacle) => return obstacle,
        };
        let ends = match Self::chain(&[(self.me, cavity.clone())]) {
            Ok(chain) => [chain[0].1.ends[0], chain[chain.len() - 1].1.ends[1]],
            Err(what) => {
                self.fail(what);
                return Insert::Blocked;
            }
        };
        let mine = |v| directory.is_mine(block_of([v, *point]));
        if !ends.into_iter().all(mine) {
            return Insert::Blocked;
        }
        for (_, patch) in self.star(*point, &[(self.me, cavity)], &|_| None, directory) {
            self.apply::<C>(patch, directory, &mut Vec::new(), &mut Vec::new());
        }
        Insert::Done
    }

    fn resolve(&self, name: Name) -> Option<u8> {
        let here = |cell: &Option<Cell>| cell.as_ref().is_some_and(|c| c.piece.name == name);
        self.cells.iter().position(here).map(|slot| slot as u8)
    }

    fn holder(&self, t: u8) -> Option<Ticket> {
        self.cell(t).and_then(|cell| cell.holder)
    }

    fn set_holder(&mut self, t: u8, holder: Option<Ticket>) {
        match self.cells.get_mut(usize::from(t)) {
            Some(Some(cell)) => cell.holder = holder,
            _ => self.fail("a lock of a cell that is not here"),
        }
    }

    fn in_conflict(&mut self, t: u8, point: &Vertex) -> bool {
        match self.cell(t) {
            Some(cell) => orient(cell.piece.ends[0], cell.piece.ends[1], *point) < 0,
            None => {
                self.fail("a test of a cell that is not here");
                false
            }
        }
    }

    fn neighbours(&self, t: u8, mut f: impl FnMut(Neighbour<u8>)) {
        let Some(cell) = self.cell(t) else { return };
        for (side, link) in cell.piece.links.into_iter().enumerate().rev() {
            f(match self.resolve(link.name) {
                Some(near) => Neighbour::Near(near),
                None => Neighbour::Far(link.handle(side)),
            });
        }
    }

    fn pieces(&mut self, tets: &[u8]) -> Vec<Piece> {
        let nobody = Vertex { x: 0, y: 0, block: 0 };
        let nowhere = Link { name: Name { by: NOBODY, number: 0 }, block: BlockId::default() };
        let lost = Piece { name: nowhere.name, ends: [nobody; 2], links: [nowhere; 2] };
        tets.iter().map(|&t| self.cell(t).map_or(lost, |cell| cell.piece)).collect()
    }

    fn fill(
        &mut self,
        point: &Vertex,
        parts: &[Part<Piece>],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) -> Vec<(WorkerId, Patch)> {
        self.star(*point, parts, whereabouts, directory)
    }

    fn apply<D: Rules>(
        &mut self,
        patch: Patch,
        directory: &Directory,
        made: &mut Vec<Name>,
        strays: &mut Vec<BlockId>,
    ) {
        for name in patch.delete {
            if self.remove(name).is_none() {
                self.fail("a deleted cell is not here");
            }
        }
        for edge in &patch.create {
            made.push(edge.name);
            if !directory.is_mine(edge.block()) {
                strays.push(edge.block());
            }
            self.place(*edge);
        }
        for (name, side, link) in patch.relink {
            if !D::relinks_interface() && self.resolve(link.name).is_none() {
                continue;
            }
            let here = self.resolve(name).map(usize::from);
            match here.and_then(|t| self.cells[t].as_mut()) {
                Some(cell) => cell.piece.links[side] = link,
                None => self.fail("a ring cell is not here"),
            }
        }
    }

    fn is_block_locked(&self, block: BlockId) -> bool {
        let touches = |e: &Piece| e.block() == block || e.links.iter().any(|l| l.block == block);
        self.cells().any(|cell| touches(&cell.piece) && cell.holder.is_some())
    }

    fn extract<D: Rules>(
        &mut self,
        block: BlockId,
        moved: &mut dyn FnMut(u8, Handle),
    ) -> Vec<Piece> {
        let mut cargo = Vec::new();
        for t in 0..self.cells.len() {
            let Some(cell) = self.cells[t].as_ref().filter(|c| c.piece.block() == block) else {
                continue;
            };
            moved(t as u8, cell.piece.link().handle(0));
            cargo.push(cell.piece);
            if cell.holder.is_some() {
                self.fail("a locked cell moves");
            }
        }
        for edge in &cargo {
            self.remove(edge.name);
        }
        cargo.sort_unstable();
        cargo
    }

    fn adopt(&mut self, cargo: Vec<Piece>, made: &mut Vec<Name>) {
        for edge in cargo {
            made.push(edge.name);
            self.place(edge);
        }
    }
}
