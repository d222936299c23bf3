//! The points that one worker has to insert: the paper's field `Fd`.
//!
//! Points lie in rounds of a biased randomized insertion order; a round is cut into *cursors*,
//! each a piece of the Hilbert curve. One cursor is followed while its points are inserted at
//! once. When a point has to wait for another worker, so would its neighbours on the curve: the
//! next cursor goes on elsewhere. With a single cursor a worker would mostly wait.

use super::{Blocks, LocalMesh, Site};
use crate::protocol::{BlockId, Source};
use ltbw_core::Point;
use ltbw_core::order::round_of;
use ltbw_core::topology::VertexId;
use std::collections::VecDeque;

/// A piece of a Hilbert curve, from its front.
type Cursor = VecDeque<(VertexId, Point)>;

/// Points of one worker, on many cursors.
#[derive(Clone, Debug)]
pub struct Field {
    blocks: Blocks,
    /// By round, the first one in work; no cursor is empty.
    rounds: VecDeque<VecDeque<Cursor>>,
    left: usize,
    /// The point given last, if nothing was heard of it.
    given: Option<VertexId>,
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
            list.chunks(size).map(|c| c.iter().copied().collect()).collect::<VecDeque<Cursor>>()
        };
        let rounds: VecDeque<VecDeque<Cursor>> =
            lists.into_iter().map(cut).filter(|round| !round.is_empty()).collect();
        Self { blocks, rounds, left: points.len(), given: None }
    }

    /// Number of points left.
    pub fn left(&self) -> usize {
        self.left
    }

    /// Number of points left in `block`.
    pub fn in_block(&self, block: BlockId) -> usize {
        let range = self.blocks.vertices(block);
        let points = self.rounds.iter().flatten().flatten();
        points.filter(|(v, _)| range.contains(v)).count()
    }

    fn tidy(&mut self) {
        for round in &mut self.rounds {
            round.retain(|cursor| !cursor.is_empty());
        }
        self.rounds.retain(|round| !round.is_empty());
        self.left = self.rounds.iter().flatten().map(VecDeque::len).sum();
    }
}

impl Source<LocalMesh> for Field {
    fn next(&mut self, _: &LocalMesh) -> Option<Site> {
        let round = self.rounds.front_mut()?;
        if self.given.take().is_some() {
            round.rotate_left(1);
        }
        let cursor = round.front_mut()?;
        let (v, p) = cursor.pop_front()?;
        if cursor.is_empty() {
            round.pop_front();
        }
        if round.is_empty() {
            self.rounds.pop_front();
        } else {
            self.given = Some(v);
        }
        self.left -= 1;
        Some(Site::new(v, p))
    }

    fn is_empty(&self) -> bool {
        self.left == 0
    }

    fn inserted(&mut self, _: &LocalMesh, point: &Site) {
        if self.given == Some(point.vertex) {
            self.given = None;
        }
    }

    fn take_block(&mut self, block: BlockId) -> Vec<Site> {
        let range = self.blocks.vertices(block);
        let mut taken = Vec::new();
        for cursor in self.rounds.iter_mut().flatten() {
            cursor.retain(|&(v, p)| {
                let goes = range.contains(&v);
                if goes {
                    taken.push(Site::new(v, p));
                }
                !goes
            });
        }
        self.tidy();
        taken
    }

    fn give(&mut self, _: BlockId, points: Vec<Site>) {
        if points.is_empty() {
            return;
        }
        let cursor = points.iter().map(|site| (site.vertex, site.point())).collect();
        match self.rounds.back_mut() {
            Some(round) => round.push_back(cursor),
            None => self.rounds.push_back(VecDeque::from([cursor])),
        }
        self.left += points.len();
    }

    fn clear(&mut self) {
        self.rounds.clear();
        self.left = 0;
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
    fn every_point_comes_once_and_a_waiting_one_changes_the_cursor() {
        let (mut field, mesh) = field(9000);
        let mut seen = vec![0; 9001];
        let mut jumps = 0;
        let mut last: Option<u32> = None;
        while let Some(site) = field.next(&mesh) {
            seen[site.vertex as usize] += 1;
            if let Some(last) = last {
                jumps += u32::from(site.vertex.abs_diff(last) > 1000);
            }
            last = Some(site.vertex);
            if site.vertex % 100 != 0 {
                field.inserted(&mesh, &site);
            }
        }
        assert!(field.is_empty());
        assert!(seen[1..].iter().all(|&n| n == 1));
        assert!((80..110).contains(&jumps), "{jumps}");
    }

    #[test]
    fn a_block_moves_with_its_points() {
        let (mut field, mesh) = field(1000);
        for _ in 0..10 {
            field.next(&mesh);
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
