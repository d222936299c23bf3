//! The points that one worker has to insert: the paper's field `Fd`.
//!
//! Points lie in rounds of a biased randomized insertion order; a round is cut into *cursors*,
//! each a piece of the Hilbert curve. One cursor is followed while its points are inserted at
//! once. A point that has to wait for another worker keeps its cursor: its neighbours on the curve
//! would only meet its locks. Meanwhile other cursors are followed. With a single one a worker
//! would mostly wait. A cursor that has waited comes first when it may go on: it lies at the
//! interface, and what waits for other workers had better be under way while there is work that
//! does not, or a round would end in nothing but waiting.

use super::{Blocks, LocalMesh, Site};
use crate::protocol::{BlockId, Source};
use ltbw_core::Point;
use ltbw_core::order::round_of;
use ltbw_core::topology::VertexId;
use std::collections::VecDeque;
use std::ops::Range;

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
    /// Cursors in work.
    cursors: Vec<Cursor>,
    /// The one that is followed.
    current: usize,
    /// Those that have waited and may go on.
    urgent: Vec<usize>,
    left: usize,
    /// Cursors in work that could give a point.
    ready: usize,
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
        let (cursors, urgent) = (Vec::new(), Vec::new());
        let mut field = Self { blocks, own, rounds, cursors, current: 0, urgent, left, ready: 0 };
        field.turn();
        field
    }

    /// Number of points left.
    pub fn left(&self) -> usize {
        self.left
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
        self.cursors.iter().chain(self.rounds.iter().flatten()).map(count).sum()
    }

    /// Drops empty cursors, goes to the next round when none is left, counts anew.
    fn turn(&mut self) {
        self.cursors.retain(|c| !c.is_empty());
        while self.cursors.is_empty()
            && let Some(round) = self.rounds.pop_front()
        {
            self.cursors = round;
            self.cursors.retain(|c| !c.is_empty());
        }
        self.current = 0;
        self.urgent.clear();
        self.ready = self.cursors.iter().filter(|c| c.given.is_none()).count();
    }

    /// The cursor that gave `vertex` may go on; returns its place.
    fn free(&mut self, vertex: VertexId) -> Option<usize> {
        let followed = self.cursors.get(self.current).is_some_and(|c| c.given == Some(vertex));
        let cursor = if followed {
            Some(self.current)
        } else {
            self.cursors.iter().position(|c| c.given == Some(vertex))
        };
        let k = cursor?;
        self.cursors[k].given = None;
        self.ready += 1;
        Some(k)
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
        if self.ready == 0 {
            return None;
        }
        if let Some(k) = self.urgent.pop() {
            self.current = k;
        }
        // Ends: some cursor is ready.
        while self.cursors[self.current].given.is_some() {
            self.current = (self.current + 1) % self.cursors.len();
        }
        let cursor = &mut self.cursors[self.current];
        let site = cursor.next(&self.own, mesh)?;
        self.left -= 1;
        if cursor.is_empty() {
            self.turn();
        } else {
            cursor.given = Some(site.vertex);
            self.ready -= 1;
        }
        Some(site)
    }

    fn is_empty(&self) -> bool {
        self.left == 0
    }

    fn is_ready(&self) -> bool {
        self.ready > 0
    }

    fn inserted(&mut self, _: &LocalMesh, point: &Site) {
        if let Some(k) = self.free(point.vertex)
            && k != self.current
        {
            self.urgent.push(k);
        }
    }

    fn let_go(&mut self, point: &Site) {
        // It has walked to another worker. The next ones of its cursor would follow it there and
        // meet its locks: other cursors first.
        if self.free(point.vertex) == Some(self.current) {
            self.current = (self.current + 1) % self.cursors.len();
            self.urgent.clear();
        }
    }

    fn take_block(&mut self, mesh: &LocalMesh, block: BlockId) -> Vec<Site> {
        let Self { blocks, own, rounds, cursors, .. } = self;
        let range = blocks.vertices(block);
        let mut taken = Vec::new();
        for cursor in cursors.iter_mut().chain(rounds.iter_mut().flatten()) {
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
        self.turn();
        taken
    }

    fn give(&mut self, _: BlockId, points: Vec<Site>) {
        self.left += points.len();
        let points = points.iter().map(|site| (site.vertex, site.point())).collect();
        self.cursors.push(Cursor::new(Track::Moved(points)));
        self.turn();
    }

    fn clear(&mut self) {
        self.rounds.clear();
        self.cursors.clear();
        self.left = 0;
        self.turn();
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
    fn a_cursor_whose_point_waits_gives_no_other() {
        let (mut field, mesh) = field(900);
        let given: Vec<Site> = std::iter::from_fn(|| field.next(&mesh)).collect();
        assert_eq!(given.len(), 3, "one point of each cursor");
        assert!(!field.is_ready() && !field.is_empty());
        field.let_go(&given[1]);
        let next = field.next(&mesh).expect("a point");
        assert_eq!(next.vertex, given[1].vertex + 1);
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
