//! The work to do: segments, subfaces and tetrahedra that have to be split.

use crate::complex::carrier::Carrier;
use ltbw_core::topology::{TetId, VertexId};
use std::collections::VecDeque;

/// Something to be split. Each names its vertices, so that it can be found gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Item {
    /// A subsegment: its ends, ascending.
    Segment([VertexId; 2]),
    /// A subface: its corners, ascending.
    Subface([VertexId; 3]),
    /// A tetrahedron: its slot, and the vertices that it had there.
    Tet(TetId, [VertexId; 4]),
}

impl Item {
    /// Its kind in a word: for messages.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Segment(_) => "segment",
            Self::Subface(_) => "subface",
            Self::Tet(..) => "tetrahedron",
        }
    }
}

/// Has a boundary item an input vertex for a corner?
pub(crate) fn has_corner(item: Item, corner: u32, carrier: impl Fn(VertexId) -> Carrier) -> bool {
    let is = |&v: &VertexId| carrier(v) == Carrier::Corner(corner);
    match item {
        Item::Segment(s) => s.iter().any(is),
        Item::Subface(s) => s.iter().any(is),
        Item::Tet(..) => false,
    }
}

/// Buckets of tetrahedra by weight: powers of two.
const BUCKETS: usize = 24;

/// The paper's list of bad elements before the first round, and in joint steps: first in, first
/// out, in the order of priority; of tetrahedra, those farthest over their bounds first.
///
/// A transaction takes nothing itself: it is given an item and puts what it finds.
#[derive(Debug)]
pub(crate) struct Queues {
    /// Boundary items of which each waits for the next; the last one is split first.
    waiting: Vec<Item>,
    segments: VecDeque<[VertexId; 2]>,
    subfaces: VecDeque<[VertexId; 3]>,
    tets: [VecDeque<(TetId, [VertexId; 4])>; BUCKETS],
    /// No bucket above this one has entries.
    highest: usize,
}

impl Default for Queues {
    fn default() -> Self {
        Self {
            waiting: Vec::new(),
            segments: VecDeque::new(),
            subfaces: VecDeque::new(),
            tets: std::array::from_fn(|_| VecDeque::new()),
            highest: 0,
        }
    }
}

impl Queues {
    /// The tetrahedron that may be the next one.
    pub(crate) fn upcoming(&self) -> Option<(TetId, [VertexId; 4])> {
        self.tets[self.highest].front().copied()
    }

    /// The next boundary item, where the first by its place comes first of those that do not wait.
    pub(crate) fn next_by_place<K: Ord>(&mut self, place: impl Fn(Item) -> K) -> Option<Item> {
        let Self { waiting, segments, subfaces, .. } = self;
        if let Some(item) = waiting.pop() {
            return Some(item);
        }
        let all = segments.iter().enumerate();
        let first = all.min_by_key(|&(_, &s)| place(Item::Segment(s))).map(|own| own.0);
        if let Some(s) = first.and_then(|k| segments.swap_remove_back(k)) {
            return Some(Item::Segment(s));
        }
        let all = subfaces.iter().enumerate();
        let first = all.min_by_key(|&(_, &s)| place(Item::Subface(s))).map(|own| own.0);
        first.and_then(|k| subfaces.swap_remove_back(k)).map(Item::Subface)
    }

    /// Adds an item; `weight` says how far a tetrahedron is over its bounds.
    pub(crate) fn put(&mut self, item: Item, weight: f64) {
        match item {
            Item::Segment(s) => self.segments.push_back(s),
            Item::Subface(s) => self.subfaces.push_back(s),
            Item::Tet(t, v) => {
                let bucket = bucket(weight);
                self.highest = self.highest.max(bucket);
                self.tets[bucket].push_back((t, v));
            }
        }
    }

    /// Adds an item that has to wait, and the boundary item that it waits for.
    pub(crate) fn put_behind(&mut self, item: Item, first: Item) {
        match item {
            Item::Segment(_) | Item::Subface(_) => self.waiting.push(item),
            Item::Tet(t, v) => self.tets[self.highest].push_front((t, v)),
        }
        self.waiting.push(first);
    }

    /// The next boundary item: what others wait for, then segments before subfaces.
    pub(crate) fn next_boundary(&mut self) -> Option<Item> {
        let waiting = self.waiting.pop();
        let segment = || self.segments.pop_front().map(Item::Segment);
        let subface = || self.subfaces.pop_front().map(Item::Subface);
        waiting.or_else(segment).or_else(subface)
    }

    /// The next tetrahedron, when no boundary item is left.
    pub(crate) fn next_tet(&mut self) -> Option<Item> {
        loop {
            if let Some((t, v)) = self.tets[self.highest].pop_front() {
                return Some(Item::Tet(t, v));
            }
            self.highest = self.highest.checked_sub(1)?;
        }
    }
}

/// The bucket of a weight, which is at least 1.
fn bucket(weight: f64) -> usize {
    let exponent = (weight.max(1.0).to_bits() >> 52) as usize - 1023;
    exponent.min(BUCKETS - 1)
}
