//! The points that one worker has to insert: the paper's field `Fd`.
//!
//! Points lie in rounds of a biased randomized insertion order; a round is cut into *cursors*,
//! each a piece of the Hilbert curve. One cursor is followed while its points are inserted at
//! once. A point that has to wait for another worker keeps its cursor: its neighbours on the curve
//! would only meet its locks. Meanwhile other cursors are followed. With a single one a worker
//! would mostly wait. A cursor that has waited comes first when it may go on: it lies at the
//! interface, and its points should be under way while there are others that need no other worker,
//! or a round would end in nothing but waiting. When all cursors wait the next round
//! begins; in the last round the far half of a waiting cursor's piece becomes a cursor of its own.
//!
//! Where messages take long that is not enough. The coarse mesh tells where the interface is: there
//! cursors are short, and go first while fewer than a number of points are under way
//! ([`PointQueue::interface`]).
//!
//! While its part of the mesh is small, few points of a worker can be under way without being in
//! each other's way: so few are, then.

mod cursor;

use super::{Blocks, LocalMesh, Place, VertexName, WireVertex};
use crate::protocol::{BlockId, Source};
use cursor::{Cursor, Own, SHORTEST, Track};
use std::collections::VecDeque;
use std::ops::Range;

/// Times this, numbers in a row lie far apart: 2^32 times the golden section.
const SCATTER: u32 = 0x9E37_79B9;

/// The number of points that may be under way however small the mesh is.
const LEAST_UNDER_WAY: usize = 8;

/// Points of one worker, on many cursors.
#[derive(Clone, Debug)]
pub struct PointQueue {
    blocks: Blocks,
    own: Own,
    /// Cursors of a round.
    cursors: usize,
    /// The round to begin next.
    next_round: u32,
    /// Has one of the rounds to come a point?
    more: bool,
    /// The cursor that is followed.
    current: Option<Cursor>,
    /// The number of points under way below which points at the interface go first.
    max_in_flight: usize,
    /// Cursors that have waited and may go on, the one to follow next last.
    resumed: Vec<Cursor>,
    /// Cursors at the interface that may go on, the one to follow next first.
    interface: VecDeque<Cursor>,
    /// Other cursors that may go on, the one to follow next first.
    ready: VecDeque<Cursor>,
    /// Cursors whose point is under way.
    waiting: Vec<Cursor>,
    left: usize,
    given: usize,
    /// Vertices of its blocks that were in the mesh before it gave one.
    begun_with: usize,
}

impl PointQueue {
    /// The vertices `range` in curve order, in rounds of `cursors` cursors each. Those of `out` are
    /// not to be given.
    pub fn new(
        blocks: Blocks,
        range: Range<Place>,
        out: impl IntoIterator<Item = Place>,
        cursors: usize,
    ) -> Self {
        let mut left = range.len();
        let mut own = Own::new(range.clone());
        for v in out {
            if range.contains(&v) && !own.take_out(v) {
                left -= 1;
            }
        }
        let begun_with = range.len() - left;
        Self {
            blocks,
            own,
            cursors,
            next_round: 0,
            more: left > 0,
            current: None,
            max_in_flight: 0,
            resumed: Vec::new(),
            interface: VecDeque::new(),
            ready: VecDeque::new(),
            waiting: Vec::new(),
            left,
            given: 0,
            begun_with,
        }
    }

    /// Lets the points of the pieces `interface`, ascending and disjoint, go first while fewer than
    /// `max_in_flight` points are under way.
    #[must_use]
    pub fn interface(
        mut self,
        interface: impl IntoIterator<Item = Range<Place>>,
        max_in_flight: usize,
    ) -> Self {
        let Range { start, end } = self.own.range;
        let meets = |piece: &Range<Place>| piece.start < end && start < piece.end;
        self.own.interface = interface.into_iter().filter(meets).collect();
        self.max_in_flight = max_in_flight;
        self
    }

    /// Number of points left.
    pub fn left(&self) -> usize {
        self.left
    }

    /// Number of points given so far.
    pub fn given(&self) -> usize {
        self.given
    }

    /// Number of vertices of `block`, be they inserted or not.
    pub fn size_of(&self, block: BlockId) -> usize {
        self.blocks.vertices(block).len()
    }

    /// Number of points left in `block`.
    pub fn in_block(&self, block: BlockId) -> usize {
        let range = self.blocks.vertices(block);
        let begun: usize = self.begun().map(|c| c.count_in(&range, &self.own)).sum();
        if self.more {
            begun + self.own.since_round(&range, self.next_round).count()
        } else {
            begun
        }
    }

    /// All cursors.
    fn begun(&self) -> impl Iterator<Item = &Cursor> {
        let Self { current, resumed, interface, ready, waiting, .. } = self;
        current.iter().chain(resumed).chain(interface).chain(ready).chain(waiting)
    }

    /// Sees to it that the cursor that is followed may give a point; false if none may.
    ///
    /// The next round begins when no cursor of those begun may go on. After the last one what lies
    /// before a waiting point is followed from its middle on: the far half of a piece of the curve
    /// is far from the point that waits.
    fn choose(&mut self) -> bool {
        if self.is_full() {
            return false;
        }
        let interface_first = !self.interface.is_empty() && self.under_way() < self.max_in_flight;
        let goes_on = |c: &Cursor| c.is_ready() && (c.is_interface || !interface_first);
        if self.resumed.is_empty() && self.current.as_ref().is_some_and(goes_on) {
            return true;
        }
        let Some(next) = self.following(interface_first) else { return false };
        match self.current.replace(next) {
            Some(before) if !before.is_ready() => self.waiting.push(before),
            Some(before) if before.is_interface => self.interface.push_front(before),
            Some(before) => self.ready.push_front(before),
            None => {}
        }
        true
    }

    /// Number of points that are under way.
    fn under_way(&self) -> usize {
        self.waiting.len() + usize::from(!self.current.as_ref().is_none_or(Cursor::is_ready))
    }

    /// Are as many points under way as may be, the square root of the number of vertices so far?
    /// In proportion to these they would be too many: only at a surface do any wait.
    fn is_full(&self) -> bool {
        let (under_way, vertices) = (self.under_way(), self.begun_with + self.given);
        under_way >= LEAST_UNDER_WAY && (under_way + 1).saturating_pow(2) > vertices
    }

    /// The cursor to follow next, not the current one.
    fn following(&mut self, interface_first: bool) -> Option<Cursor> {
        let next = self.resumed.pop();
        let next = next.or_else(|| self.interface.pop_front_if(|_| interface_first));
        let next = next.or_else(|| self.ready.pop_front());
        let next = next.or_else(|| self.interface.pop_front());
        next.or_else(|| self.begin_round()).or_else(|| self.split())
    }

    /// The first cursor of the next round. Ends: a round without points is followed by another one
    /// as long as some have points.
    fn begin_round(&mut self) -> Option<Cursor> {
        while self.more {
            let round = self.next_round;
            self.next_round += 1;
            let range = self.own.range.clone();
            self.look_for_more();
            let size = range.len().div_ceil(self.cursors.max(1)).max(1);
            let mut interface = Vec::new();
            for start in range.clone().step_by(size) {
                let piece = start..range.end.min(start.saturating_add(size as Place));
                for (Range { start, end }, is_interface) in self.own.stretches(piece) {
                    let next = self.own.first(start, end, round);
                    let track = Track::Own { next, end, round };
                    let cursor = Cursor { is_interface, ..Cursor::new(track) };
                    if !cursor.is_empty() && is_interface {
                        interface.push((start, cursor));
                    } else if !cursor.is_empty() {
                        self.ready.push_back(cursor);
                    }
                }
            }
            // Points that follow each other on the curve would be under way together, and in each
            // other's way.
            interface.sort_unstable_by_key(|(start, _)| start.wrapping_mul(SCATTER));
            self.interface.extend(interface.into_iter().map(|(_, cursor)| cursor));
            let first = self.interface.pop_front().or_else(|| self.ready.pop_front());
            if first.is_some() {
                return first;
            }
        }
        None
    }

    /// Finds out whether a round to come has a point: near the front, if there is one.
    fn look_for_more(&mut self) {
        let Self { own, next_round, .. } = self;
        self.more =
            *next_round <= own.rounds && own.since_round(&own.range, *next_round).next().is_some();
    }

    /// The far half of the longest piece before a point that waits. Ends: a piece whose far half
    /// has no point loses it.
    fn split(&mut self) -> Option<Cursor> {
        let Self { own, waiting, current, .. } = self;
        loop {
            let all = waiting.iter_mut().chain(current.as_mut());
            let half = all.max_by_key(|c| c.length(own))?.split(own)?;
            if !half.is_empty() {
                return Some(half);
            }
        }
    }

    /// Could a point be given?
    fn can_give(&self) -> bool {
        let Self { own, current, resumed, interface, ready, waiting, more, .. } = self;
        if self.is_full() {
            return false;
        }
        current.as_ref().is_some_and(Cursor::is_ready)
            || !(resumed.is_empty() && interface.is_empty() && ready.is_empty())
            || waiting.iter().chain(current).any(|c| c.length(own) >= SHORTEST)
            || *more
    }

    /// Takes out the cursor, not the one followed, that gave `vertex`; `None` if it has no more.
    fn free(&mut self, vertex: VertexName) -> Option<Cursor> {
        let k = self.waiting.iter().position(|c| c.given == Some(vertex))?;
        let mut cursor = self.waiting.swap_remove(k);
        cursor.given = None;
        (!cursor.is_empty()).then_some(cursor)
    }

    /// If the cursor that is followed gave `vertex` it may go on.
    fn free_current(&mut self, vertex: VertexName) -> bool {
        match &mut self.current {
            Some(cursor) if cursor.given == Some(vertex) => {
                cursor.given = None;
                self.current.take_if(|cursor| cursor.is_empty());
                true
            }
            _ => false,
        }
    }

    /// A cursor whose turn comes after that of others.
    fn put_last(&mut self, cursor: Cursor) {
        if cursor.is_interface {
            self.interface.push_back(cursor);
        } else {
            self.ready.push_back(cursor);
        }
    }

    /// Drops empty cursors whose last point is not under way.
    fn tidy(&mut self) {
        let Self { current, resumed, interface, ready, waiting, .. } = self;
        current.take_if(|cursor| cursor.is_ready() && cursor.is_empty());
        resumed.retain(|c| !c.is_empty());
        interface.retain(|c| !c.is_empty());
        ready.retain(|c| !c.is_empty());
        waiting.retain(|c| !c.is_ready() || !c.is_empty());
    }
}

impl Source<LocalMesh> for PointQueue {
    fn next(&mut self, mesh: &LocalMesh) -> Option<WireVertex> {
        if !self.choose() {
            return None;
        }
        let cursor = self.current.as_mut()?;
        let vertex = cursor.next(&self.own, mesh)?;
        self.left -= 1;
        self.given += 1;
        cursor.given = Some(vertex.name);
        Some(vertex)
    }

    fn is_empty(&self) -> bool {
        self.left == 0
    }

    fn is_ready(&self) -> bool {
        self.can_give()
    }

    fn inserted(&mut self, _: &LocalMesh, point: &WireVertex) {
        if !self.free_current(point.name)
            && let Some(cursor) = self.free(point.name)
        {
            self.resumed.push(cursor);
        }
    }

    fn released(&mut self, point: &WireVertex) {
        if self.free_current(point.name) {
            // It has walked to another worker. The next ones of its cursor would follow it there
            // and meet its locks: other cursors first.
            let later = self.current.take().into_iter().chain(std::mem::take(&mut self.resumed));
            later.for_each(|cursor| self.put_last(cursor));
        } else if let Some(cursor) = self.free(point.name) {
            self.put_last(cursor);
        }
    }

    fn remove_block(&mut self, mesh: &LocalMesh, block: BlockId) -> Vec<WireVertex> {
        let Self { blocks, own, current, resumed, interface, ready, waiting, .. } = self;
        let range = blocks.vertices(block);
        let mut taken = Vec::new();
        let begun = current.iter_mut().chain(resumed).chain(interface).chain(ready).chain(waiting);
        begun.for_each(|cursor| cursor.take_in(&range, own, mesh, &mut taken));
        let to_come: Vec<Place> = own.since_round(&range, self.next_round).collect();
        for v in to_come {
            own.take_out(v);
            taken.push(mesh.vertex_at(v));
        }
        self.look_for_more();
        self.left -= taken.len();
        self.begun_with = self.begun_with.saturating_sub(range.len() - taken.len());
        self.tidy();
        taken
    }

    fn add(&mut self, block: BlockId, points: Vec<WireVertex>) {
        self.left += points.len();
        self.begun_with += self.blocks.vertices(block).len().saturating_sub(points.len());
        let points: VecDeque<_> = points.into();
        if !points.is_empty() {
            self.ready.push_back(Cursor::new(Track::Moved(points)));
        }
    }

    fn clear(&mut self) {
        // A block that moves away later has no points in rounds to come.
        self.next_round = self.own.rounds + 1;
        self.more = false;
        self.current = None;
        self.resumed.clear();
        self.interface.clear();
        self.ready.clear();
        self.waiting.clear();
        self.left = 0;
    }
}

#[cfg(test)]
mod tests;
