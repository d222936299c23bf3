//! The vertices of one worker's submesh: their names among workers, and their numbers here.
//!
//! A *name* is who made the vertex and that one's counter. The points of the input have no maker:
//! their counter is the place along the curve, which all workers share and none changes. A submesh
//! numbers what it has from 1 up without gaps: first its own stretch of the curve, so that name and
//! number differ by a constant, then all others in the order in which they come.

use super::Blocks;
use super::name::{NOWHERE, Place, VertexName, made_by};
use crate::protocol::{BlockId, WorkerId};
use ltbw_core::expect;
use ltbw_core::topology::{INFINITE, VertexId};
use ltbw_exact::Point;
use rustc_hash::FxHashMap;
use std::ops::Range;

/// A vertex that is not of the worker's own stretch of the curve.
#[derive(Clone, Copy, Debug)]
struct Other {
    name: VertexName,
    block: BlockId,
}

/// Counters that an array of them may leave out at a time.
const GAP: usize = 4096;

/// Names and numbers.
#[derive(Clone, Debug)]
pub(super) struct Vertices {
    blocks: Blocks,
    me: WorkerId,
    /// The place along the curve before that of number 1.
    before: Place,
    /// The number of vertices of the own stretch.
    run: u32,
    /// The vertices with the numbers after those.
    others: Vec<Other>,
    /// By the counter of a vertex that this worker has made: its number; 0 if it has none here.
    made: Vec<VertexId>,
    /// The numbers of all others, and of those that came long before their turn.
    numbers: FxHashMap<VertexName, VertexId>,
}

impl Vertices {
    /// The vertices of the stretch `own`, which worker `me` has.
    pub(super) fn new(blocks: Blocks, me: WorkerId, own: Range<Place>) -> Self {
        let (before, run) = (own.start.saturating_sub(1), own.len() as u32);
        let (others, made, numbers) = (Vec::new(), Vec::new(), FxHashMap::default());
        Self { blocks, me, before, run, others, made, numbers }
    }

    /// Takes memory for this many vertices. A hint.
    pub(super) fn expect(&mut self, vertices: usize) {
        expect(&mut self.others, vertices);
    }

    /// Other blocks, of vertices at these places.
    pub(super) fn recut(&mut self, blocks: Blocks, point: impl Fn(VertexId) -> Point) {
        for (other, v) in self.others.iter_mut().zip(self.run + 1..) {
            other.block = blocks.of_name(other.name, &point(VertexId::new(v)));
        }
        self.blocks = blocks;
    }

    /// The numbers of vertices at places of the own stretch.
    pub(super) fn numbers_of(&self, places: Range<Place>) -> Range<VertexId> {
        let number = |place: Place| VertexId::new(place.max(self.before + 1) - self.before);
        number(places.start)..number(places.end)
    }

    /// The largest number of the own stretch.
    pub(super) fn run(&self) -> VertexId {
        VertexId::new(self.run)
    }

    /// The number after it.
    pub(super) fn after_run(&self) -> VertexId {
        VertexId::new(self.run + 1)
    }

    /// The number that the next vertex gets.
    pub(super) fn next(&self) -> VertexId {
        VertexId::at(self.run as usize + 1 + self.others.len())
    }

    /// The name of the vertex with number `v`, which is one here, or 0.
    #[inline]
    pub(super) fn name(&self, v: VertexId) -> VertexName {
        match v {
            INFINITE => NOWHERE,
            v if v <= self.run() => VertexName::from(self.before + v.number()),
            v => self.others[self.place_of(v)].name,
        }
    }

    /// The number here of a vertex; `None` if it has none.
    #[inline]
    pub(super) fn number(&self, name: VertexName) -> Option<VertexId> {
        let place = name.wrapping_sub(VertexName::from(self.before));
        if place.wrapping_sub(1) < VertexName::from(self.run) {
            return Some(VertexId::new(place as u32));
        }
        if name == NOWHERE {
            return Some(INFINITE);
        }
        let own = made_by(self.me, name).and_then(|count| self.made.get(count as usize));
        let known = own.filter(|&&v| v != INFINITE).or_else(|| self.numbers.get(&name));
        known.copied()
    }

    /// Gives a vertex of this block that has no number the next one.
    pub(super) fn add(&mut self, name: VertexName, block: BlockId) -> VertexId {
        let number = self.next();
        self.others.push(Other { name, block });
        // Others may name what this worker has never made: such a counter takes no memory.
        let near = self.made.len() + GAP;
        match made_by(self.me, name).map(|count| count as usize).filter(|&count| count < near) {
            Some(count) => {
                self.made.resize(self.made.len().max(count + 1), INFINITE);
                self.made[count] = number;
            }
            None => _ = self.numbers.insert(name, number),
        }
        number
    }

    /// The block of a finite vertex here.
    #[inline]
    pub(super) fn block(&self, v: VertexId) -> BlockId {
        if v <= self.run() {
            self.blocks.of_vertex(self.before + v.number())
        } else {
            self.others[self.place_of(v)].block
        }
    }

    /// The place among the others of a vertex after the own stretch.
    #[inline]
    fn place_of(&self, v: VertexId) -> usize {
        (v.number() - self.run) as usize - 1
    }

    /// The place along the curve of number 1, and the names from the end of the own stretch on.
    pub(super) fn all(&self) -> (Place, impl ExactSizeIterator<Item = VertexName> + '_) {
        (self.before + 1, self.others.iter().map(|other| other.name))
    }
}

#[cfg(test)]
mod tests {
    use super::super::name::{self, given};
    use super::*;

    fn made(by: u32, count: u32) -> VertexName {
        name::made(WorkerId::new(by), count)
    }

    #[test]
    fn names_and_numbers_are_inverse() {
        let mut vertices = Vertices::new(Blocks::even(100, 4), WorkerId::new(3), 26..51);
        assert_eq!(
            (vertices.name(VertexId::new(1)), vertices.name(VertexId::new(25)), vertices.next()),
            (26, 50, VertexId::new(26))
        );
        assert_eq!((vertices.number(26), vertices.number(51)), (Some(VertexId::new(1)), None));
        let far = made(3, u32::MAX);
        let names = [51, 25, made(0, 1), made(3, 5), far, made(3, 2), made(4, 2), 100, 1];
        for (number, name) in (26..).map(VertexId::new).zip(names) {
            assert_eq!((vertices.number(name), vertices.next()), (None, number));
            let block = vertices.blocks.of_name(name, &[0.5; 3]);
            assert_eq!(vertices.add(name, block), number);
        }
        assert!(vertices.made.len() <= 6, "a counter of no vertex made here takes no memory");
        for v in VertexId::below(vertices.next().number()) {
            assert_eq!(vertices.number(vertices.name(v)), Some(v));
        }
        let blocks: Vec<u32> = (1..33).map(|v| vertices.block(VertexId::new(v)).number()).collect();
        assert_eq!(blocks[..27], [[1; 25].as_slice(), &[2, 0]].concat());
        assert_eq!(
            (vertices.numbers_of(30..41), given(made(0, 7))),
            (VertexId::new(5)..VertexId::new(16), None)
        );
    }

    #[test]
    fn a_worker_without_a_stretch_numbers_what_comes() {
        let mut vertices = Vertices::new(Blocks::even(3, 8), WorkerId::default(), 3..3);
        assert_eq!((vertices.next(), vertices.number(3)), (VertexId::new(1), None));
        assert_eq!(
            (vertices.add(3, BlockId::new(7)), vertices.name(VertexId::new(1))),
            (VertexId::new(1), 3)
        );
    }
}
