//! Which tetrahedra over their bounds are candidates of a round: functions of the mesh and its
//! keys, whatever the order in which they are found.

use super::Rounds;
use super::sift::{Bad, Ranked, sift, witness};
use crate::complex::measure::Shape;
use crate::mesh::item::Item;
use crate::mesh::key::order_key;
use crate::table::Map;
use ltbw_core::order::hilbert;
use ltbw_core::topology::{TetId, VertexId, tet_of};
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

/// The place of a circumsphere among those that are nearly equal: the power of two below its
/// radius, and the cell of its centre in a grid of half of that.
type GroupKey = (i32, [i64; 3]);

/// Where 0 is in its cell of the grid.
const SHIFT: f64 = 0.382;

/// Two spheres of one group hold each other's centres: their radii are from s to 2s, and their
/// centres at most s √3/2 apart.
fn group_of(centre: &Point, radius: f64) -> GroupKey {
    let exponent = (radius.to_bits() >> 52) as i32;
    let half = f64::from_bits(((exponent - 1).max(1) as u64) << 52);
    // Domains with a middle have it at 0, which is in one cell.
    (exponent, centre.map(|c| (c / half + SHIFT).floor() as i64))
}

impl Rounds<'_, '_> {
    /// Finds the tetrahedra over their bounds that come before all those around them: their face
    /// neighbours, and the face neighbours of these. Forgets those that are gone.
    pub(super) fn find_foremost(&mut self) {
        let mut bad = std::mem::take(&mut self.bad);
        let mut foremost = std::mem::take(&mut self.foremost);
        foremost.clear();
        let this = &*self;
        let many = this.threads > 1 && bad.len() >= 2 * SHARE;
        let share = if many { SHARE } else { bad.len().max(1) };
        let sifted: Vec<(usize, Vec<Foremost>)> = match many {
            true => bad.par_chunks_mut(share).map(|own| this.sift(own)).collect(),
            false => bad.chunks_mut(share).map(|own| this.sift(own)).collect(),
        };
        let mut kept = 0;
        for (k, (stay, found)) in sifted.into_iter().enumerate() {
            bad.copy_within(k * share..k * share + stay, kept);
            kept += stay;
            foremost.extend(found);
        }
        bad.truncate(kept);
        (self.bad, self.foremost) = (bad, foremost);
        self.find_leaders();
    }

    /// Moves those of some tetrahedra that are still there to the front, and finds the foremost
    /// among them. Returns their number, and the foremost.
    fn sift(&self, bad: &mut [Bad]) -> (usize, Vec<Foremost>) {
        let mut foremost = Vec::new();
        let kept =
            sift(bad, self.looks, self, |t| foremost.push(self.foremost_at(t, self.keys.at(t))));
        (kept, foremost)
    }

    /// Looks around the tetrahedra over their bounds from number `first` on, which are new and in
    /// the cache: what is before one of them now may be so when the round has ended.
    pub(super) fn find_witnesses(&mut self, first: usize) {
        for k in first..self.bad.len() {
            if let Some(next) = self.bad.get(k + 2) {
                self.neighbours(next.t).into_iter().for_each(|t| self.keys.prefetch(t));
            }
            let t = self.bad[k].t;
            if let Some(witness) = self.one_before(t, self.keys.at(t)) {
                self.bad[k].witness = witness;
            }
        }
    }

    /// The neighbour on the way, or `t`, and a tetrahedron around `t`, which has this key, that
    /// comes before it.
    fn one_before(&self, t: TetId, key: u64) -> Option<[TetId; 2]> {
        let around = |way: TetId| Some(self.neighbours(way));
        witness(t, self.neighbours(t), around, |&other| self.is_before(other, t, key))
    }

    pub(super) fn neighbours(&self, t: TetId) -> [TetId; 4] {
        self.own.state.mesh.topology().at(t).neighbours().map(tet_of)
    }

    /// Is one tetrahedron over its bounds, and comes before `other`, which has this key?
    #[inline(always)]
    fn is_before(&self, one: TetId, other: TetId, key: u64) -> bool {
        let own = self.keys.at(one);
        own > key || own == key && one != other && self.place(one) < self.place(other)
    }

    pub(super) fn foremost_at(&self, t: TetId, key: u64) -> Foremost {
        let state = &self.own.state;
        let mut corners = state.vertices(t);
        corners.sort_unstable_by_key(|&v| order_key(&state.at(v)));
        let [a, b, c, d] = corners.map(|v| state.at(v));
        let shape = Shape::of([&a, &b, &c, &d]);
        Foremost { key, t, corners, shape, centre: shape.circumcentre(&d), group: 0 }
    }

    /// Finds, of each group of the foremost, the one that comes before the others: its centre is in
    /// their circumspheres.
    fn find_leaders(&mut self) {
        let mut foremost = std::mem::take(&mut self.foremost);
        let mut numbers: Map<GroupKey, u32> = Map::default();
        let leaders = &mut self.leaders;
        leaders.clear();
        for k in 0..foremost.len() {
            let own = &foremost[k];
            let next = leaders.len() as u32;
            let group = match own.centre.filter(|_| self.in_groups) {
                Some(centre) => {
                    *numbers.entry(group_of(&centre, own.shape.radius())).or_insert(next)
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
        self.foremost = foremost;
        self.counted = self.leaders.len();
    }

    /// The leaders' ranks, after those of boundary items, by their numbers, and their numbers along
    /// a Hilbert curve.
    pub(super) fn ranks(&self) -> (Vec<u32>, Vec<u32>) {
        let leader = |&k: &u32| self.leader(k);
        let count = self.leaders.len() as u32;
        let mut falling: Vec<(u64, u32)> = (0..count).map(|k| (leader(&k).key, k)).collect();
        let state = &self.own.state;
        falling.par_sort_unstable_by(|(a, j), (b, k)| {
            b.cmp(a).then_with(|| state.compare(leader(j), leader(k)))
        });
        let mut ranks = vec![0; self.leaders.len()];
        for (rank, &(_, k)) in (self.boundary..).zip(&falling) {
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
        &self.foremost[self.leaders[k as usize] as usize]
    }

    /// The foremost that are no leaders.
    pub(super) fn followers(&self) -> impl Iterator<Item = &Foremost> + '_ {
        let is_leader = |k: u32, own: &Foremost| self.leaders[own.group as usize] == k;
        let all = (0..).zip(&self.foremost);
        all.filter(move |&(k, own)| !is_leader(k, own)).map(|(_, own)| own)
    }

    #[cold]
    fn place(&self, t: TetId) -> impl Ord {
        self.own.state.place_of(Item::Tet(t, self.own.state.vertices(t)))
    }
}

impl Ranked for Rounds<'_, '_> {
    #[inline(always)]
    fn stamp(&self, t: TetId) -> u32 {
        self.stamps.at(t)
    }

    #[inline(always)]
    fn neighbours(&self, t: TetId) -> [TetId; 4] {
        self.neighbours(t)
    }

    #[inline(always)]
    fn prefetch(&self, t: TetId) {
        self.own.state.mesh.prefetch(t);
        self.keys.prefetch(t);
    }

    #[inline(always)]
    fn one_before(&self, t: TetId) -> Option<[TetId; 2]> {
        self.one_before(t, self.keys.at(t))
    }
}

impl crate::mesh::state::State {
    /// Which of two tetrahedra comes first?
    fn compare(&self, a: &Foremost, b: &Foremost) -> Ordering {
        let place = |own: &Foremost| own.corners.map(|v| order_key(&self.at(v)));
        b.key.cmp(&a.key).then_with(|| place(a).cmp(&place(b)))
    }
}
