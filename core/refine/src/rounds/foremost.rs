//! Which tetrahedra over their bounds are candidates of a round: functions of the mesh and its
//! keys, whatever the order in which they are found.

use super::Rounds;
use super::ranked::Ranked;
use crate::complex::measure::Shape;
use crate::mesh::item::Item;
use crate::mesh::key::order_key;
use crate::mesh::state::State;
use crate::rules::group::Group;
use crate::table::Map;
use ltbw_core::order::hilbert;
use ltbw_core::topology::{TetId, VertexId};
use ltbw_exact::Point;
use rayon::prelude::*;
use std::cmp::Ordering;

/// Tetrahedra that one thread sifts at a time.
const SHARE: usize = if cfg!(test) { 5 } else { 2048 };

/// A tetrahedron that comes before all those around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foremost {
    key: u64,
    pub(super) t: TetId,
    /// Its corners, sorted by coordinates, and its shape by them.
    pub(super) corners: [VertexId; 4],
    pub(super) shape: Shape,
    pub(super) centre: Option<Point>,
    /// The number of those whose circumspheres are nearly its own.
    group: u32,
}

/// The tetrahedra that come before all around them.
#[derive(Debug, Default)]
pub(super) struct Front {
    pub(super) foremost: Vec<Foremost>,
    /// By group of the foremost: the index of the one that comes first.
    pub(super) leaders: Vec<u32>,
    /// The leaders when last counted.
    pub(super) counted: usize,
    /// Are there patches or small angles? Then many may be refused: of those whose circumspheres
    /// are nearly equal one is probed.
    in_groups: bool,
}

impl Front {
    pub(super) fn new(in_groups: bool) -> Self {
        Self { in_groups, ..Self::default() }
    }
}

impl Rounds<'_, '_> {
    /// Finds the tetrahedra over their bounds that come before all those around them: their face
    /// neighbours, and the face neighbours of these. Forgets those that are gone.
    pub(super) fn find_foremost(&mut self) {
        let (keys, state) = (&mut self.keys, &self.own.state);
        if self.threads > 1 && keys.count() >= 2 * SHARE {
            self.front.foremost =
                keys.sift_in_shares(state, SHARE, |t, key| state.foremost_at(t, key));
        } else {
            self.front.foremost.clear();
            keys.sift(state, |t, key| self.front.foremost.push(state.foremost_at(t, key)));
        }
        self.find_leaders();
    }

    pub(super) fn neighbours(&self, t: TetId) -> [TetId; 4] {
        self.own.state.neighbours(t)
    }

    /// Finds, of each group of the foremost, the one that comes before the others: its centre is in
    /// their circumspheres.
    fn find_leaders(&mut self) {
        let mut foremost = std::mem::take(&mut self.front.foremost);
        let mut numbers: Map<Group, u32> = Map::default();
        let leaders = &mut self.front.leaders;
        leaders.clear();
        for k in 0..foremost.len() {
            let own = &foremost[k];
            let next = leaders.len() as u32;
            let group = match own.centre.filter(|_| self.front.in_groups) {
                Some(centre) => {
                    *numbers.entry(Group::of(&centre, own.shape.radius())).or_insert(next)
                }
                None => next,
            };
            foremost[k].group = group;
            match leaders.get_mut(group as usize) {
                None => leaders.push(k as u32),
                Some(leader) => {
                    if self.own.state.compare(&foremost[k], &foremost[*leader as usize]).is_lt() {
                        *leader = k as u32;
                    }
                }
            }
        }
        self.front.foremost = foremost;
        self.front.counted = self.front.leaders.len();
    }

    /// The leaders' ranks, after those of boundary items, by their numbers, and their numbers along
    /// a Hilbert curve.
    pub(super) fn ranks(&self) -> (Vec<u32>, Vec<u32>) {
        let leader = |&k: &u32| self.leader(k);
        let count = self.front.leaders.len() as u32;
        let mut falling: Vec<(u64, u32)> = (0..count).map(|k| (leader(&k).key, k)).collect();
        let state = &self.own.state;
        falling.par_sort_unstable_by(|(a, j), (b, k)| {
            b.cmp(a).then_with(|| state.compare(leader(j), leader(k)))
        });
        let mut ranks = vec![0; self.front.leaders.len()];
        for (rank, &(_, k)) in self.reserved.of_tets().zip(&falling) {
            ranks[k as usize] = rank;
        }
        let first = |k: &u32| self.own.state.at(leader(k).corners[0]);
        let corners: Vec<Point> = falling.iter().map(|(_, k)| first(k)).collect();
        // Of leaders with one corner the foremost comes first, as they are numbered by chance.
        let order = hilbert(&corners).into_iter().map(|k| falling[k as usize].1).collect();
        (ranks, order)
    }

    /// The leader of this number.
    pub(super) fn leader(&self, k: u32) -> &Foremost {
        &self.front.foremost[self.front.leaders[k as usize] as usize]
    }

    /// The foremost that are no leaders.
    pub(super) fn followers(&self) -> impl Iterator<Item = &Foremost> + '_ {
        let is_leader = |k: u32, own: &Foremost| self.front.leaders[own.group as usize] == k;
        let all = (0..).zip(&self.front.foremost);
        all.filter(move |&(k, own)| !is_leader(k, own)).map(|(_, own)| own)
    }
}

impl Ranked for State {
    #[inline(always)]
    fn neighbours(&self, t: TetId) -> [TetId; 4] {
        Self::neighbours(self, t)
    }

    #[inline(always)]
    fn around(&self, way: TetId) -> Option<[TetId; 4]> {
        Some(self.neighbours(way))
    }

    #[inline(always)]
    fn prefetch(&self, t: TetId) {
        self.mesh.prefetch(t);
    }

    #[cold]
    fn is_first_by_place(&self, one: TetId, other: TetId) -> bool {
        let place = |t: TetId| self.place_of(Item::Tet(t, self.vertices(t)));
        place(one) < place(other)
    }
}

impl State {
    /// A tetrahedron, with this key, that comes before all around it.
    pub(super) fn foremost_at(&self, t: TetId, key: u64) -> Foremost {
        let mut corners = self.vertices(t);
        corners.sort_unstable_by_key(|&v| order_key(&self.at(v)));
        let [a, b, c, d] = corners.map(|v| self.at(v));
        let shape = Shape::of([&a, &b, &c, &d]);
        Foremost { key, t, corners, shape, centre: shape.circumcentre(&d), group: 0 }
    }

    /// Which of two tetrahedra comes first?
    fn compare(&self, a: &Foremost, b: &Foremost) -> Ordering {
        let place = |own: &Foremost| own.corners.map(|v| order_key(&self.at(v)));
        b.key.cmp(&a.key).then_with(|| place(a).cmp(&place(b)))
    }
}
