//! The points that one worker has to insert: the paper's field `Fd`.
//!
//! Points lie in rounds of a biased randomized insertion order; a round is cut into *cursors*,
//! each a piece of the Hilbert curve. One cursor is followed while its points are inserted at
//! once. A point that has to wait for another worker keeps its cursor: its neighbours on the curve
//! would only meet its locks. Meanwhile other cursors are followed. With a single one a worker
//! would mostly wait.

use super::{Blocks, LocalMesh, Site};
use crate::protocol::{BlockId, Source};
use ltbw_core::Point;
use ltbw_core::order::round_of;
use ltbw_core::topology::VertexId;
use std::collections::VecDeque;

/// A piece of a Hilbert curve.
#[derive(Clone, Debug)]
struct Cursor {
    /// What is left of it.
    points: VecDeque<(VertexId, Point)>,
    /// The point given last, if it is not inserted yet.
    given: Option<VertexId>,
}

/// Points of one worker, on many cursors.
#[derive(Clone, Debug)]
pub struct Field {
    blocks: Blocks,
    /// Rounds to come.
    rounds: VecDeque<Vec<Cursor>>,
    /// Cursors in work.
    cursors: Vec<Cursor>,
    /// The one that is followed.
    current: usize,
    left: usize,
    /// Cursors in work that could give a point.
    ready: usize,
}

impl Field {
    /// The `points` in curve order, in rounds of `cursors` cursors each.
    pub fn new(blocks: Blocks, points: &[(VertexId, Point)], cursors: usize) -> Self {
        let rounds = match points.len() {
            0..4096 => 0,
            4096..65536 => 1,
            _ => 2,
        };
        let mut lists: Vec<Vec<(VertexId, Point)>> = vec![Vec::new(); rounds as usize + 1];
        for &(v, p) in points {
            lists[round_of(v, rounds) as usize].push((v, p));
        }
        let cut = |list: Vec<(VertexId, Point)>| {
            let size = list.len().div_ceil(cursors.max(1)).max(1);
            list.chunks(size).map(Cursor::new).collect::<Vec<_>>()
        };
        let rounds = lists.into_iter().map(cut).filter(|round| !round.is_empty()).collect();
        let left = points.len();
        let mut field = Self { blocks, rounds, cursors: Vec::new(), current: 0, left, ready: 0 };
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
        let cursors = self.cursors.iter().chain(self.rounds.iter().flatten());
        cursors.flat_map(|c| &c.points).filter(|(v, _)| range.contains(v)).count()
    }

    /// Drops empty cursors, goes to the next round when none is left, counts anew.
    fn turn(&mut self) {
        self.cursors.retain(|c| !c.points.is_empty());
        while self.cursors.is_empty()
            && let Some(round) = self.rounds.pop_front()
        {
            self.cursors = round;
            self.cursors.retain(|c| !c.points.is_empty());
        }
        self.current = 0;
        self.ready = self.cursors.iter().filter(|c| c.given.is_none()).count();
        let cursors = self.cursors.iter().chain(self.rounds.iter().flatten());
        self.left = cursors.map(|c| c.points.len()).sum();
    }

    /// The cursor that gave `vertex` may go on.
    fn free(&mut self, vertex: VertexId) {
        let followed = self.cursors.get(self.current).is_some_and(|c| c.given == Some(vertex));
        let cursor = if followed {
            Some(self.current)
        } else {
            self.cursors.iter().position(|c| c.given == Some(vertex))
        };
        if let Some(k) = cursor {
            self.cursors[k].given = None;
            self.ready += 1;
        }
    }
}

impl Cursor {
    fn new(points: &[(VertexId, Point)]) -> Self {
        Self { points: points.iter().copied().collect(), given: None }
    }
}

impl Source<LocalMesh> for Field {
    fn next(&mut self, _: &LocalMesh) -> Option<Site> {
        if self.ready == 0 {
            return None;
        }
        // Ends: some cursor is ready.
        while self.cursors[self.current].given.is_some() {
            self.current = (self.current + 1) % self.cursors.len();
        }
        let cursor = &mut self.cursors[self.current];
        let (v, p) = cursor.points.pop_front()?;
        self.left -= 1;
        if cursor.points.is_empty() {
            self.turn();
        } else {
            cursor.given = Some(v);
            self.ready -= 1;
        }
        Some(Site::new(v, p))
    }

    fn is_empty(&self) -> bool {
        self.left == 0
    }

    fn is_ready(&self) -> bool {
        self.ready > 0
    }

    fn inserted(&mut self, _: &LocalMesh, point: &Site) {
        self.free(point.vertex);
    }

    fn let_go(&mut self, point: &Site) {
        self.free(point.vertex);
    }

    fn take_block(&mut self, block: BlockId) -> Vec<Site> {
        let range = self.blocks.vertices(block);
        let mut taken = Vec::new();
        for cursor in self.cursors.iter_mut().chain(self.rounds.iter_mut().flatten()) {
            cursor.points.retain(|&(v, p)| {
                let goes = range.contains(&v);
                if goes {
                    taken.push(Site::new(v, p));
                }
                !goes
            });
        }
        self.turn();
        taken
    }

    fn give(&mut self, _: BlockId, points: Vec<Site>) {
        let points: Vec<_> = points.iter().map(|site| (site.vertex, site.point())).collect();
        self.cursors.push(Cursor::new(&points));
        self.turn();
    }

    fn clear(&mut self) {
        self.rounds.clear();
        self.cursors.clear();
        self.turn();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltbw_core::Mode;
    use ltbw_core::part::Setting;

    fn field(count: u32) -> (Field, LocalMesh) {
        let points: Vec<(u32, Point)> = (1..=count).map(|v| (v, [f64::from(v); 3])).collect();
        let blocks = Blocks::even(count, 4);
        let all: Vec<Point> = points.iter().map(|&(_, p)| p).collect();
        let mesh = LocalMesh::new(0, &Setting::of(&all, Mode::Normal), blocks.clone());
        (Field::new(blocks, &points, 3), mesh)
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
        let taken = field.take_block(3);
        assert_eq!((taken.len(), field.left(), field.in_block(3)), (250, before - 250, 0));
        field.give(3, taken);
        assert_eq!((field.in_block(3), field.left()), (250, before));
        field.clear();
        assert!(field.is_empty() && field.next(&mesh).is_none());
    }
}
