//! The points that one worker has to insert: the paper's field `Fd`.
//!
//! Points lie in rounds of a biased randomized insertion order; a round is cut into *cursors*,
//! each a piece of the Hilbert curve. One cursor is followed while its points are inserted at
//! once. A point that has to wait for another worker keeps its cursor: its neighbours on the curve
//! would only meet its locks. Meanwhile other cursors are followed. With a single one a worker
//! would mostly wait. A cursor that has waited comes first when it may go on: it lies at the
//! interface, and what waits for other workers had better be under way while there is work that
//! does not, or a round would end in nothing but waiting. When all cursors wait the next round
//! begins; in the last round the far half of a waiting cursor's piece becomes a cursor of its own.

use super::{Blocks, LocalMesh, Site};
use crate::protocol::{BlockId, Source};
use ltbw_core::Point;
use ltbw_core::order::round_of;
use ltbw_core::topology::VertexId;
use std::collections::VecDeque;
use std::ops::Range;

/// No piece of the curve with fewer points is cut in two. At least 2: the halves are shorter.
const SHORTEST: usize = 4;

/// The points that a cursor is to give.
#[derive(Clone, Debug)]
enum Track {
    /// Vertices of a round in a piece of the worker's range; `next` is one if it is not `end`.
    /// The submesh has their coordinates.
    Own { next: VertexId, end: VertexId, round: u32 },
    /// Points that have moved here.
    Moved(VecDeque<(VertexId, Point)>),
}

/// A piece of a Hilbert curve.
#[derive(Clone, Debug)]
struct Cursor {
    /// What is left of it.
    track: Track,
    /// The point given last, if it is not inserted yet.
    given: Option<VertexId>,
}

/// The worker's range of vertices: which of them are not to be given, for they are in the coarse
/// mesh or have moved away; and in which round each comes.
#[derive(Clone, Debug)]
struct Own {
    range: Range<VertexId>,
    /// A bit for each vertex.
    out: Vec<u64>,
    rounds: u32,
}

/// Points of one worker, on many cursors.
#[derive(Clone, Debug)]
pub struct Field {
    blocks: Blocks,
    own: Own,
    /// Rounds to come.
    rounds: VecDeque<Vec<Cursor>>,
    /// The cursor that is followed.
    current: Option<Cursor>,
    /// Points that it has given in a row.
    in_a_row: u32,
    /// So many may be while others may go on, too.
    turn: u32,
    /// Those that have waited and may go on, the one to follow next last.
    urgent: Vec<Cursor>,
    /// Others that may go on, the one to follow next first.
    ready: VecDeque<Cursor>,
    /// Those whose point is under way.
    waiting: Vec<Cursor>,
    left: usize,
}

impl Own {
    fn place(&self, v: VertexId) -> (usize, u64) {
        let bit = v - self.range.start;
        (bit as usize / 64, 1 << (bit % 64))
    }

    /// Is `v`, of this range, out? Then it stays so.
    fn take_out(&mut self, v: VertexId) -> bool {
        let (word, bit) = self.place(v);
        let was = self.out[word] & bit != 0;
        self.out[word] |= bit;
        was
    }

    fn is_out(&self, v: VertexId) -> bool {
        let (word, bit) = self.place(v);
        self.out[word] & bit != 0
    }

    /// The first vertex of a round in `from..end`, or `end`.
    fn first(&self, from: VertexId, end: VertexId, round: u32) -> VertexId {
        let gives = |&v: &VertexId| !self.is_out(v) && round_of(v, self.rounds) == round;
        (from..end).find(gives).unwrap_or(end)
    }
}

impl Field {
    /// The vertices `range` in curve order, in rounds of `cursors` cursors each. Those of `out` are
    /// not to be given.
    pub fn new(
        blocks: Blocks,
        range: Range<VertexId>,
        out: impl IntoIterator<Item = VertexId>,
        cursors: usize,
    ) -> Self {
        let rounds = match range.len() {
            0..4096 => 0,
            4096..65536 => 1,
            _ => 2,
        };
        let words = vec![0; range.len().div_ceil(64)];
        let mut own = Own { range: range.clone(), out: words, rounds };
        let mut left = range.len();
        for v in out {
            if range.contains(&v) && !own.take_out(v) {
                left -= 1;
            }
        }
        let size = range.len().div_ceil(cursors.max(1)).max(1);
        let cut = |round| {
            let starts = range.clone().step_by(size);
            let piece = |start: VertexId| {
                let end = range.end.min(start.saturating_add(size as VertexId));
                Cursor::new(Track::Own { next: own.first(start, end, round), end, round })
            };
            starts.map(piece).filter(|cursor| !cursor.is_empty()).collect::<Vec<_>>()
        };
        let rounds = (0..=rounds).map(cut).filter(|round| !round.is_empty()).collect();
        let (current, urgent) = (None, Vec::new());
        let (ready, waiting) = (VecDeque::new(), Vec::new());
        let (in_a_row, turn) = (0, u32::MAX);
        Self { blocks, own, rounds, current, in_a_row, turn, urgent, ready, waiting, left }
    }

    /// Sets how many points of a cursor are given in a row while others may go on, too.
    #[must_use]
    pub fn turn(mut self, turn: u32) -> Self {
        self.turn = turn;
        self
    }

    /// Number of points left.
    pub fn left(&self) -> usize {
        self.left
    }

    /// Number of vertices of `block`, be they inserted or not.
    pub fn size_of(&self, block: BlockId) -> usize {
        self.blocks.vertices(block).len()
    }

    /// Number of points left in `block`.
    pub fn in_block(&self, block: BlockId) -> usize {
        let range = self.blocks.vertices(block);
        let own = &self.own;
        let count = |cursor: &Cursor| match &cursor.track {
            Track::Own { next, end, round } => {
                let both = (*next).max(range.start)..(*end).min(range.end);
                let gives = |v: &VertexId| !own.is_out(*v) && round_of(*v, own.rounds) == *round;
                both.filter(gives).count()
            }
            Track::Moved(points) => points.iter().filter(|(v, _)| range.contains(v)).count(),
        };
        let Self { rounds, current, urgent, ready, waiting, .. } = self;
        let begun = current.iter().chain(urgent).chain(ready).chain(waiting);
        begun.chain(rounds.iter().flatten()).map(count).sum()
    }

    /// Sees to it that the cursor that is followed may give a point; false if none may.
    ///
    /// The next round begins when no cursor of those begun may go on. After the last one what lies
    /// before a waiting point is followed from its middle on: the far half of a piece of the curve
    /// is far from the point that waits.
    fn choose(&mut self) -> bool {
        let is_due = self.in_a_row >= self.turn && !self.ready.is_empty();
        let is_ready = self.current.as_ref().is_some_and(Cursor::is_ready);
        if is_ready && self.urgent.is_empty() && !is_due {
            return true;
        }
        let next = self.urgent.pop().or_else(|| self.ready.pop_front());
        let Some(next) = next.or_else(|| self.begin_round()).or_else(|| self.split()) else {
            return false;
        };
        match self.current.replace(next) {
            Some(before) if before.is_ready() && is_due => self.ready.push_back(before),
            Some(before) if before.is_ready() => self.ready.push_front(before),
            Some(before) => self.waiting.push(before),
            None => {}
        }
        self.in_a_row = 0;
        true
    }

    /// The first cursor of the next round.
    fn begin_round(&mut self) -> Option<Cursor> {
        let round = self.rounds.pop_front()?;
        self.ready.extend(round);
        self.ready.pop_front()
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
        let Self { own, rounds, current, urgent, ready, waiting, .. } = self;
        current.as_ref().is_some_and(Cursor::is_ready)
            || !urgent.is_empty()
            || !ready.is_empty()
            || !rounds.is_empty()
            || waiting.iter().chain(current).any(|c| c.length(own) >= SHORTEST)
    }

    /// Takes out the cursor, not the one followed, that gave `vertex`.
    fn free(&mut self, vertex: VertexId) -> Option<Cursor> {
        let k = self.waiting.iter().position(|c| c.given == Some(vertex))?;
        let mut cursor = self.waiting.swap_remove(k);
        cursor.given = None;
        Some(cursor)
    }

    /// If the cursor that is followed gave `vertex` it may go on.
    fn free_current(&mut self, vertex: VertexId) -> bool {
        match &mut self.current {
            Some(cursor) if cursor.given == Some(vertex) => {
                cursor.given = None;
                true
            }
            _ => false,
        }
    }

    /// Drops empty cursors.
    fn tidy(&mut self) {
        let Self { rounds, current, urgent, ready, waiting, .. } = self;
        current.take_if(|cursor| cursor.is_empty());
        urgent.retain(|c| !c.is_empty());
        ready.retain(|c| !c.is_empty());
        waiting.retain(|c| !c.is_empty());
        for round in rounds.iter_mut() {
            round.retain(|c| !c.is_empty());
        }
        rounds.retain(|round| !round.is_empty());
    }
}

impl Cursor {
    fn new(track: Track) -> Self {
        Self { track, given: None }
    }

    fn is_empty(&self) -> bool {
        match &self.track {
            Track::Own { next, end, .. } => next == end,
            Track::Moved(points) => points.is_empty(),
        }
    }

    /// Is no point of it under way?
    fn is_ready(&self) -> bool {
        self.given.is_none()
    }

    /// About how many points it has.
    fn length(&self, own: &Own) -> usize {
        match &self.track {
            Track::Own { next, end, round } => (end - next) as usize >> (3 * (own.rounds - round)),
            Track::Moved(points) => points.len(),
        }
    }

    /// Cuts off the second half, if it is not short.
    fn split(&mut self, own: &Own) -> Option<Self> {
        if self.length(own) < SHORTEST {
            return None;
        }
        let track = match &mut self.track {
            Track::Own { next, end, round } => {
                let middle = *next + (*end - *next) / 2;
                let half =
                    Track::Own { next: own.first(middle, *end, *round), end: *end, round: *round };
                *end = middle;
                half
            }
            Track::Moved(points) => Track::Moved(points.split_off(points.len() / 2)),
        };
        Some(Self::new(track))
    }

    /// The next point.
    fn next(&mut self, own: &Own, mesh: &LocalMesh) -> Option<Site> {
        match &mut self.track {
            Track::Own { next, end, .. } if next == end => None,
            Track::Own { next, end, round } => {
                let v = *next;
                *next = own.first(v + 1, *end, *round);
                Some(mesh.site(v))
            }
            Track::Moved(points) => points.pop_front().map(|(v, p)| Site::new(v, p)),
        }
    }
}

impl Source<LocalMesh> for Field {
    fn next(&mut self, mesh: &LocalMesh) -> Option<Site> {
        if !self.choose() {
            return None;
        }
        let cursor = self.current.as_mut()?;
        let site = cursor.next(&self.own, mesh)?;
        self.left -= 1;
        cursor.given = Some(site.vertex);
        self.in_a_row += 1;
        if cursor.is_empty() {
            self.current = None;
        }
        Some(site)
    }

    fn is_empty(&self) -> bool {
        self.left == 0
    }

    fn is_ready(&self) -> bool {
        self.can_give()
    }

    fn inserted(&mut self, _: &LocalMesh, point: &Site) {
        if !self.free_current(point.vertex)
            && let Some(cursor) = self.free(point.vertex)
        {
            self.urgent.push(cursor);
        }
    }

    fn let_go(&mut self, point: &Site) {
        if self.free_current(point.vertex) {
            // It has walked to another worker. The next ones of its cursor would follow it there
            // and meet its locks: other cursors first.
            self.ready.extend(self.current.take());
            self.ready.extend(self.urgent.drain(..));
        } else if let Some(cursor) = self.free(point.vertex) {
            self.ready.push_back(cursor);
        }
    }

    fn take_block(&mut self, mesh: &LocalMesh, block: BlockId) -> Vec<Site> {
        let Self { blocks, own, rounds, current, urgent, ready, waiting, .. } = self;
        let range = blocks.vertices(block);
        let mut taken = Vec::new();
        let begun = current.iter_mut().chain(urgent).chain(ready).chain(waiting);
        for cursor in begun.chain(rounds.iter_mut().flatten()) {
            match &mut cursor.track {
                Track::Own { next, end, round } => {
                    for v in (*next).max(range.start)..(*end).min(range.end) {
                        if round_of(v, own.rounds) == *round && !own.take_out(v) {
                            taken.push(mesh.site(v));
                        }
                    }
                    *next = own.first(*next, *end, *round);
                }
                Track::Moved(points) => points.retain(|&(v, p)| {
                    let goes = range.contains(&v);
                    if goes {
                        taken.push(Site::new(v, p));
                    }
                    !goes
                }),
            }
        }
        self.left -= taken.len();
        self.tidy();
        taken
    }

    fn give(&mut self, _: BlockId, points: Vec<Site>) {
        self.left += points.len();
        let points: VecDeque<_> = points.iter().map(|s| (s.vertex, s.point())).collect();
        if !points.is_empty() {
            self.ready.push_back(Cursor::new(Track::Moved(points)));
        }
    }

    fn clear(&mut self) {
        self.rounds.clear();
        self.current = None;
        self.urgent.clear();
        self.ready.clear();
        self.waiting.clear();
        self.left = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltbw_core::Mode;
    use ltbw_core::part::Setting;

    fn field(count: u32) -> (Field, LocalMesh) {
        let blocks = Blocks::even(count, 4);
        let all: Vec<Point> = (1..=count).map(|v| [f64::from(v); 3]).collect();
        let mut mesh = LocalMesh::new(0, &Setting::of(&all, Mode::Normal), blocks.clone());
        mesh.part.set_points(1, &all);
        (Field::new(blocks, 1..count + 1, [], 3), mesh)
    }

    #[test]
    fn every_point_comes_once_and_a_waiting_one_keeps_its_cursor() {
        let (mut field, mesh) = field(9000);
        let mut seen = vec![0; 9001];
        let mut waiting: Option<Site> = None;
        while !field.is_empty() {
            let Some(site) = field.next(&mesh) else {
                // Only the last cursors have nothing else to give.
                field.inserted(&mesh, &waiting.take().expect("a waiting point"));
                continue;
            };
            seen[site.vertex as usize] += 1;
            if site.vertex % 100 == 0 {
                if let Some(before) = waiting.replace(site) {
                    field.let_go(&before);
                }
            } else {
                field.inserted(&mesh, &site);
            }
        }
        assert!(seen[1..].iter().all(|&n| n == 1));
        assert!(!field.is_ready() && field.next(&mesh).is_none());
    }

    #[test]
    fn points_that_wait_are_far_from_each_other() {
        let (mut field, mesh) = field(900);
        let mut given: Vec<VertexId> = Vec::new();
        while let Some(site) = field.next(&mesh) {
            given.push(site.vertex);
        }
        assert!(!field.is_ready() && !field.is_empty());
        assert_eq!(given[..3], [1, 301, 601], "one point of each cursor");
        assert_eq!(given[3..6].iter().map(|v| v / 300).max(), Some(2), "{given:?}");
        given.sort_unstable();
        // What lies between two of them is too short to be cut.
        let gaps: Vec<u32> = given.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(gaps.iter().all(|&gap| gap > 1 && gap <= 1 + SHORTEST as u32), "{gaps:?}");
        let site = Site::new(given[1], [0.0; 3]);
        field.let_go(&site);
        let next = field.next(&mesh).expect("a point");
        assert_eq!(next.vertex, given[1] + 1);
        assert!(!field.is_ready());
    }

    #[test]
    fn the_next_round_begins_when_all_cursors_wait() {
        let (mut field, mesh) = field(9000);
        let round = |site: &Site| round_of(site.vertex, 1);
        let rounds: Vec<u32> =
            std::iter::from_fn(|| field.next(&mesh)).take(6).map(|s| round(&s)).collect();
        assert_eq!(rounds, [0, 0, 0, 1, 1, 1]);
    }

    #[test]
    fn a_block_moves_with_its_points() {
        let (mut field, mesh) = field(1000);
        for _ in 0..10 {
            let site = field.next(&mesh).expect("a point");
            field.inserted(&mesh, &site);
        }
        let before = field.left();
        assert_eq!(field.in_block(3), 250);
        let taken = field.take_block(&mesh, 3);
        assert_eq!((taken.len(), field.left(), field.in_block(3)), (250, before - 250, 0));
        field.give(3, taken);
        assert_eq!((field.in_block(3), field.left()), (250, before));
        field.clear();
        assert!(field.is_empty() && field.next(&mesh).is_none());
    }
}
