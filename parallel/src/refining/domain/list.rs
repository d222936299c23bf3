//! One worker's list of what is to be split: bad tetrahedra, and boundary items that others have
//! asked for.

use super::describe::is_beyond_help;
use super::mesh::DomainMesh;
use super::splits::Splits;
use super::values::{Asked, DomainPoint, End, ItemKey};
use super::waits::Waits;
use super::way::Barrier;
use crate::balance::{Balance, Workload};
use crate::mesh::{VertexName, WireVertex, made};
use crate::protocol::{BlockId, Directory, Item, Source, WorkerId};
use crate::refining::news::DomainNews;
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_exact::Point;
use ltbw_refine::{Aim, BoundaryItem, Carrier, Corner};
use rustc_hash::{FxHashMap, FxHashSet};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// Entries that are looked at for one that nobody has locked.
const LOOKS: usize = 8;
/// Times that something is set behind boundary items before it is given up. What is behind another
/// worker's asks again at most once in the time that a message takes there and back.
const TRIES: u16 = 5000;
/// Times that a boundary item is found to wait for itself before it is given up: what is inserted
/// meanwhile may part the circle.
const CIRCLES: u16 = 8;
/// The key of a tetrahedron.
const TET: ItemKey = [0; 3];

/// Something to split, at a tetrahedron here. While the tetrahedron has these vertices it is the
/// same one: none comes back, but with a block that has moved away and back, and then it is in the
/// list anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    /// The number of vertices that an item has less than a tetrahedron: segments go first.
    class: u8,
    /// Times that it was set behind others.
    tries: Reverse<u16>,
    /// Its place in the order: the largest goes first.
    urgency: u64,
    tet: TetId,
    corners: [VertexId; 4],
    key: ItemKey,
    of: u32,
    attempt: u8,
    /// The block of its tetrahedron.
    block: BlockId,
}

/// Entries by urgency, counted by block.
#[derive(Debug, Default)]
struct Waiting {
    all: BinaryHeap<Entry>,
    counts: FxHashMap<BlockId, u64>,
}

impl Waiting {
    fn push(&mut self, entry: Entry) {
        *self.counts.entry(entry.block).or_default() += 1;
        self.all.push(entry);
    }

    fn pop(&mut self) -> Option<Entry> {
        let entry = self.all.pop()?;
        if let Some(count) = self.counts.get_mut(&entry.block) {
            *count -= 1;
        }
        Some(entry)
    }

    fn extend(&mut self, entries: impl IntoIterator<Item = Entry>) {
        entries.into_iter().for_each(|entry| self.push(entry));
    }

    /// Takes out all entries of a block.
    fn take(&mut self, block: BlockId) -> Vec<Entry> {
        self.counts.remove(&block);
        let (gone, stay): (Vec<Entry>, Vec<Entry>) =
            self.all.drain().partition(|entry| entry.block == block);
        self.all = stay.into();
        gone
    }

    fn clear(&mut self) {
        self.all.clear();
        self.counts.clear();
    }

    fn is_empty(&self) -> bool {
        self.all.is_empty()
    }
}

/// A point for an entry.
#[derive(Clone, Copy, Debug)]
struct Proposed {
    p: Point,
    carrier: Carrier,
    may: bool,
}

impl Entry {
    fn stands(&self, mesh: &DomainMesh<'_>) -> bool {
        let tets = mesh.inner.tets();
        tets.is_live(self.tet) && tets.vertices(self.tet) == self.corners
    }

    fn is_tet(&self) -> bool {
        self.key == TET
    }
}

/// The list.
#[derive(Debug)]
pub struct BadItems {
    me: WorkerId,
    waiting: Waiting,
    /// Entries behind boundary items of this list.
    behind: FxHashMap<ItemKey, Vec<Entry>>,
    /// Tetrahedra behind boundary items of other lists, which will tell of their ends.
    behind_far: FxHashMap<ItemKey, Vec<Entry>>,
    /// Workers that are to hear of the ends of boundary items of this list.
    waiters: FxHashMap<ItemKey, Vec<WorkerId>>,
    waits: Waits,
    out: VecDeque<(WorkerId, DomainNews)>,
    /// The boundary items of this list, those under way included.
    pending: FxHashSet<ItemKey>,
    under_way: FxHashMap<VertexName, Entry>,
    /// Bad tetrahedra found so far.
    found: u64,
    /// Points made so far: a name is given once, whatever becomes of its point.
    made: u32,
    /// The most points.
    most: u64,
    is_closed: bool,
    pub(in super::super) splits: Splits,
}

impl BadItems {
    /// The bad tetrahedra of a submesh.
    pub(in super::super) fn new(me: WorkerId, most: u64, mesh: &DomainMesh<'_>) -> Self {
        let mut own = Self {
            me,
            waiting: Waiting::default(),
            behind: FxHashMap::default(),
            behind_far: FxHashMap::default(),
            waiters: FxHashMap::default(),
            waits: Waits::default(),
            out: VecDeque::new(),
            pending: FxHashSet::default(),
            under_way: FxHashMap::default(),
            found: 0,
            made: 0,
            most,
            is_closed: false,
            splits: Splits::default(),
        };
        let all: Vec<TetId> = mesh.inner.tets().tets().map(|(t, _)| t).collect();
        own.created(mesh, &all);
        own
    }

    /// Was the budget of points used up?
    fn is_exhausted(&self) -> bool {
        u64::from(self.made) >= self.most
    }

    /// The point for an entry, if there is one.
    fn propose(mesh: &DomainMesh<'_>, entry: &Entry) -> Option<Proposed> {
        let all = entry.corners.map(|v| mesh.point(v));
        let complex = &mesh.complex;
        if entry.is_tet() {
            let (p, may) = complex.point_of_tet(all.each_ref(), usize::from(entry.attempt))?;
            return Some(Proposed { p, carrier: Carrier::Free, may });
        }
        let is_corner = |v: &VertexId| *v != INFINITE && entry.key.contains(&mesh.inner.name(*v));
        let corner = |v: VertexId| Corner { point: mesh.point(v), carrier: mesh.carrier(v) };
        let corners: Vec<Corner> =
            entry.corners.into_iter().filter(is_corner).map(corner).collect();
        if !(2..=3).contains(&corners.len()) {
            return None;
        }
        let item = BoundaryItem::new(&corners, entry.of);
        match complex.aim_at_item(&item, usize::from(entry.attempt)) {
            Aim::At { point: p, carrier, may } => Some(Proposed { p, carrier, may }),
            Aim::Skip | Aim::Exhausted | Aim::Refused => None,
        }
    }

    /// Ends an entry that cannot be split.
    fn refuse(&mut self, mesh: &DomainMesh<'_>, entry: &Entry) {
        self.splits.refused[usize::from(entry.is_tet())] += 1;
        if !entry.is_tet() {
            mesh.refuse(entry.key);
        }
        self.end(entry);
    }

    /// An entry is done: those behind it are asked again.
    fn end(&mut self, entry: &Entry) {
        if !entry.is_tet() {
            self.pending.remove(&entry.key);
            self.waits.end(&entry.key);
            self.waiting.extend(self.behind.remove(&entry.key).into_iter().flatten());
            let waiters = self.waiters.remove(&entry.key).into_iter().flatten();
            self.out.extend(waiters.map(|to| (to, DomainNews::Ended(entry.key))));
        }
    }

    /// An entry goes behind a boundary item: until that is done if this worker splits it, else for
    /// the time that its next operation takes.
    fn set_behind(&mut self, mesh: &DomainMesh<'_>, mut entry: Entry, key: ItemKey, is_here: bool) {
        self.splits.deferred += 1;
        entry.tries.0 += 1;
        if !entry.is_tet() {
            self.waits.set(entry.key, key);
            // One that waits for an item of this list is set back where nothing else is left.
            if !is_here && self.waits.is_circle(&entry.key) {
                entry.tries.0 += TRIES / CIRCLES;
            }
        }
        if self.is_closed {
            self.end(&entry);
        } else if entry.tries.0 > TRIES {
            self.refuse(mesh, &entry);
        } else if !is_here && entry.is_tet() {
            self.behind_far.entry(key).or_default().push(entry);
        } else if is_here && key != entry.key && self.pending.contains(&key) {
            self.behind.entry(key).or_default().push(entry);
        } else {
            self.waiting.push(entry);
        }
    }

    /// Enters the boundary item that the last patch has brought.
    fn enter_asked(&mut self, mesh: &DomainMesh<'_>) {
        if let Some(asked) = mesh.take_asked() {
            self.ask(mesh, asked);
        }
    }

    /// A tetrahedron goes behind the subface that bars the way to its point, or is given up if
    /// that is not to be split here.
    fn bar(&mut self, mesh: &DomainMesh<'_>, entry: Entry, Barrier { key, of, tet }: Barrier) {
        if mesh.is_refused(&key) || mesh.complex.is_patch(of) {
            self.refuse(mesh, &entry);
            return;
        }
        self.ask(mesh, Asked { key, of, tet, waiter: None, by: None });
        self.set_behind(mesh, entry, key, true);
    }

    /// Enters a boundary item that is asked for.
    fn ask(&mut self, mesh: &DomainMesh<'_>, asked: Asked) {
        let Asked { key, of, tet, waiter, by } = asked;
        let tets = mesh.inner.tets();
        if !tets.is_live(tet) || self.is_closed {
            // It may be split already: the waiter finds out.
            self.out.extend(waiter.map(|to| (to, DomainNews::Ended(key))));
            return;
        }
        if let Some(waiter) = waiter {
            let waiters = self.waiters.entry(key).or_default();
            if !waiters.contains(&waiter) {
                waiters.push(waiter);
            }
        }
        if let Some(by) = by.filter(|by| !self.pending.contains(by)) {
            self.waits.set_far(by, key);
        }
        if !self.pending.insert(key) {
            return;
        }
        self.waiting.push(Entry {
            class: if key[0] == 0 { 2 } else { 1 },
            tries: Reverse(0),
            urgency: 0,
            tet,
            corners: tets.vertices(tet),
            key,
            of,
            attempt: 0,
            block: mesh.inner.block_of(tet),
        });
    }

    /// All that wait for each other: nothing else is left.
    fn release(&mut self) {
        let mut all: Vec<Entry> = self.behind.drain().flat_map(|(_, entries)| entries).collect();
        for entry in all.iter_mut().filter(|entry| self.waits.is_circle(&entry.key)) {
            entry.tries.0 += TRIES / CIRCLES;
        }
        self.waiting.extend(all);
    }
}

impl<'c> Source<DomainMesh<'c>> for BadItems {
    const WATCHES: bool = true;

    fn next(&mut self, mesh: &DomainMesh<'c>) -> Option<DomainPoint> {
        if self.waiting.is_empty() && self.under_way.is_empty() {
            self.release();
        }
        let mut locked = Vec::new();
        let mut chosen = None;
        // Ends: each entry is taken out, and those behind it come once.
        while let Some(entry) = self.waiting.pop() {
            if self.is_closed || !entry.stands(mesh) {
                self.end(&entry);
                continue;
            }
            if self.is_exhausted() {
                self.refuse(mesh, &entry);
                continue;
            }
            let Some(proposed) = Self::propose(mesh, &entry) else {
                match entry.attempt {
                    0 => self.waiting.push(Entry { attempt: 1, ..entry }),
                    _ => self.refuse(mesh, &entry),
                }
                continue;
            };
            let barrier = || mesh.barrier_before(entry.tet, proposed.p, proposed.may);
            if let Some(barrier) = entry.is_tet().then(barrier).flatten() {
                self.bar(mesh, entry, barrier);
                continue;
            }
            if mesh.inner.tets().holder(entry.tet).is_some() && locked.len() < LOOKS {
                locked.push((entry, proposed));
                continue;
            }
            chosen = Some((entry, proposed));
            break;
        }
        // All are locked: the first one waits, for whatever is left of it.
        if chosen.is_none() && !locked.is_empty() {
            chosen = Some(locked.remove(0));
        }
        self.waiting.extend(locked.into_iter().map(|own| own.0));
        let (entry, Proposed { p, carrier, may }) = chosen?;
        self.made += 1;
        let name = made(self.me, self.made);
        self.under_way.insert(name, entry);
        let vertex = WireVertex::new(name, p);
        let (item, seed) = (entry.key, entry.tet);
        let labels = Box::default();
        Some(DomainPoint { vertex, carrier, item, seed, may, is_chosen: false, labels })
    }

    fn is_empty(&self) -> bool {
        self.waiting.is_empty() && self.behind.is_empty() && self.behind_far.is_empty()
    }

    fn is_ready(&self) -> bool {
        !self.waiting.is_empty() || self.under_way.is_empty() && !self.behind.is_empty()
    }

    fn item(&self, mesh: &DomainMesh<'c>, point: &DomainPoint) -> Item<TetId> {
        match self.under_way.get(&point.vertex.name) {
            // One that waits for a boundary item asks for its locks again and again, so that the
            // item would wait for ever if it did not ask for them: see `DomainMesh::walk`.
            Some(entry) if entry.stands(mesh) => match mesh.inner.tets().holder(entry.tet) {
                Some(_) if !entry.is_tet() => Item::Free,
                _ => Item::At(entry.tet),
            },
            _ => Item::Gone,
        }
    }

    fn created(&mut self, mesh: &DomainMesh<'c>, tets: &[TetId]) {
        // Others wait for what is asked for although nothing is split any more: they are told.
        let tets = if self.is_closed { &[] } else { tets };
        for &tet in tets.iter().filter(|&&t| mesh.inner.tets().is_live(t)) {
            let corners = mesh.inner.tets().vertices(tet);
            if corners[3] == INFINITE {
                continue;
            }
            let points = corners.map(|v| mesh.point(v));
            let is_over = mesh.complex.is_over(points.each_ref(), mesh.region(tet));
            let is_flat = || mesh.complex.is_flat(|k| mesh.carrier(corners[k]));
            if is_over && !is_flat() && !is_beyond_help(mesh, tet) {
                self.found += 1;
                let radius = mesh.complex.radius(points.each_ref());
                self.waiting.push(Entry {
                    class: 0,
                    tries: Reverse(0),
                    urgency: mesh.complex.order().urgency(radius, self.found),
                    tet,
                    corners,
                    key: TET,
                    of: 0,
                    attempt: 0,
                    block: mesh.inner.block_of(tet),
                });
            }
        }
        self.enter_asked(mesh);
    }

    /// Its tetrahedron is gone, or not in conflict with the point.
    fn released(&mut self, point: &DomainPoint) {
        if let Some(entry) = self.under_way.remove(&point.vertex.name) {
            self.waiting.push(Entry { attempt: entry.attempt + 1, ..entry });
        }
    }

    fn inserted(&mut self, mesh: &DomainMesh<'c>, point: &DomainPoint) {
        let Some(entry) = self.under_way.remove(&point.vertex.name) else { return };
        self.enter_asked(mesh);
        match mesh.end() {
            Some(End::Inserted) => {
                let kind = match point.carrier {
                    Carrier::Segment(..) => 0,
                    Carrier::Facet(_) => 1,
                    _ => 2,
                };
                self.splits.inserted[kind] += 1;
                self.end(&entry);
            }
            Some(End::Behind(key, is_here)) => self.set_behind(mesh, entry, key, is_here),
            Some(End::Barred) => self.refuse(mesh, &entry),
            Some(End::Useless) | None => {
                self.splits.useless += 1;
                self.waiting.push(Entry { attempt: entry.attempt + 1, ..entry });
            }
        }
    }

    /// Entries of the block are done with: its new owner looks at its tetrahedra, and splits
    /// boundary items there when somebody asks.
    fn remove_block(&mut self, _: &DomainMesh<'c>, block: BlockId) -> Vec<DomainPoint> {
        for entry in self.waiting.take(block) {
            self.end(&entry);
        }
        Vec::new()
    }

    fn add(&mut self, _: BlockId, _: Vec<DomainPoint>) {}

    fn hear(&mut self, _: &mut DomainMesh<'c>, _: &Directory, _: WorkerId, news: DomainNews) {
        if let DomainNews::Ended(key) = news {
            self.waiting.extend(self.behind_far.remove(&key).into_iter().flatten());
        }
    }

    fn tell(&mut self) -> Option<(WorkerId, DomainNews)> {
        self.out.pop_front()
    }

    fn clear(&mut self) {
        self.is_closed = true;
        self.waiting.clear();
        self.behind.clear();
        self.behind_far.clear();
        self.pending.clear();
        self.waits.clear();
        for (key, waiters) in self.waiters.drain() {
            self.out.extend(waiters.into_iter().map(|to| (to, DomainNews::Ended(key))));
        }
    }
}

impl Workload for BadItems {
    /// One whose share of the budget is used up wants no more, and has none to give.
    fn left(&self) -> u64 {
        let least = if self.is_exhausted() { Balance::default().low } else { 0 };
        least.max(self.waiting.all.len() as u64)
    }

    fn given(&self) -> u64 {
        u64::from(self.made)
    }

    fn in_block(&self, block: BlockId) -> u64 {
        self.waiting.counts.get(&block).copied().unwrap_or_default()
    }
}
