//! Random worlds, for sizes that cannot be explored: one seed is one world.

use crate::hull::{Vertex, orient};
use crate::world::{World, brute_force};

/// SplitMix64.
#[derive(Clone, Debug)]
pub struct Rng(pub u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `n`, which is not 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// True once in `n` times.
    pub(crate) fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
}

/// A world of 1 to 6 workers.
pub fn world(seed: u64) -> World {
    let workers = 1 + Rng(!seed).below(6);
    world_of(seed, workers)
}

/// A world of `workers` workers, 1 to 3 blocks each, up to 13 points on the final hull, some of
/// them twice, in one round or, in nearly a third, in two, and up to 7 moves, with termination
/// detection.
pub fn world_of(seed: u64, workers: usize) -> World {
    let mut rng = Rng(seed);
    let blocks = workers * (1 + rng.below(3));
    let owners: Vec<u32> = (0..blocks).map(|b| (b % workers) as u32).collect();
    let (polygon, mut points) = convex(&mut rng, blocks);
    for k in 0..points.len() {
        if rng.once_in(8) {
            points.push(points[k]);
        }
    }
    let mut at = owners.clone();
    let mut moves = Vec::new();
    if workers > 1 && rng.once_in(2) {
        for _ in 0..rng.below(8) {
            let block = rng.below(blocks);
            let to = (at[block] + 1 + rng.below(workers - 1) as u32) % workers as u32;
            at[block] = to;
            moves.push((block as u32, to));
        }
    }
    let mut world = World::new("random", &owners, &[], &[]).terminating().moving(&moves);
    world.polygon = polygon;
    world.points = points;
    world.window = 1 + rng.below(4);
    world.cancels = rng.once_in(8);
    // A worker that is cancelled in a model has no way to tell the rounds of others.
    if !world.cancels && rng.once_in(3) {
        let first = rng.below(world.points.len() + 1);
        world.second = Some(world.points.split_off(first));
    }
    world
}

/// A convex polygon and points outside it that all are vertices of the hull of everything.
fn convex(rng: &mut Rng, blocks: usize) -> (Vec<Vertex>, Vec<Vertex>) {
    let sectors = rng.once_in(2);
    let (n, m) = (3 + rng.below(12), 2 + rng.below(12));
    let reach = 1 + rng.below(9_000);
    let mut place = |radius: usize, angle: f64| {
        let [x, y] = [angle.cos(), angle.sin()].map(|c| (radius as f64 * c) as i16);
        let sector = (angle / std::f64::consts::TAU * blocks as f64) as usize;
        let block = if sectors { sector.min(blocks - 1) } else { rng.below(blocks) } as u8;
        (Vertex { x, y, block }, rng.below(10_000) as f64 / 10_000.0, rng.below(reach))
    };
    let turn = std::f64::consts::TAU;
    let mut polygon = Vec::new();
    let (mut points, mut angle) = (Vec::new(), 0.0);
    for k in 0..n {
        polygon.push(place(3_000, turn * k as f64 / n as f64).0);
    }
    for _ in 0..m {
        let (_, random, far) = place(0, angle);
        angle = turn * random;
        points.push(place(3_100 + far, angle).0);
    }
    // No three in a line, so that every subset has one hull: a cancelled run stops at any.
    for k in (0..points.len()).rev() {
        let others: Vec<Vertex> = polygon.iter().chain(&points).copied().collect();
        if is_in_line(points[k], &others) {
            points.swap_remove(k);
        }
    }
    let all: Vec<Vertex> = polygon.iter().chain(&points).copied().collect();
    let hull = brute_force(&all);
    points.retain(|p| hull.iter().any(|edge| edge[0] == *p));
    points.sort_unstable();
    points.dedup_by_key(|p| (p.x, p.y));
    (polygon, points)
}

/// Is `p` in a line with two of `others`, among which it may be itself?
fn is_in_line(p: Vertex, others: &[Vertex]) -> bool {
    let others: Vec<Vertex> = others.iter().filter(|v| **v != p).copied().collect();
    others.iter().enumerate().any(|(k, &a)| others[..k].iter().any(|&b| orient(a, b, p) == 0))
}
