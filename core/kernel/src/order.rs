//! Insertion order: BRIO rounds, Hilbert order inside a round.
//!
//! A biased randomized insertion order (Amenta, Choi and Rote, SoCG 2003) puts each point into
//! the last round with probability 7/8, into the one before with 7/64, and so on; the "coin" is a
//! hash of the point's index, so the order is a function of the input. Inside a round, points
//! follow a Hilbert curve, so that the next point is near. The order decides the speed alone,
//! never the result.
//!
//! Keys have a fixed depth but the order has not: a run of equal keys is sorted again in its own
//! bounding box, so clusters over any number of decades are ordered.

use ltbw_exact::Point;
use rayon::prelude::*;

/// Bits per axis of one level of keys, an even number. Round and key share 64 bits.
const BITS: u32 = 20;
/// Runs of equal keys at most this long are left as they are.
const SHORT_RUN: usize = 8;
/// Fewer points than this are not worth more than one thread.
const MANY: usize = 1 << 12;
/// Levels of refinement: each divides the box by at least 2^BITS, and all of f64 spans 2^2098.
const MAX_DEPTH: usize = 2 * (2098 / BITS as usize + 1);
/// A round is not started for fewer points than this.
const SMALLEST_ROUND: usize = 512;

/// The insertion order of `points`: a permutation of their indices.
///
/// Cost: O(n log n), in parallel on the current rayon pool.
pub fn brio_hilbert(points: &[Point]) -> Vec<u32> {
    let mut rounds = 0;
    let mut rest = points.len();
    while rest > SMALLEST_ROUND && rounds < 15 {
        rest /= 8;
        rounds += 1;
    }
    in_rounds(points, rounds, Cube::around(points.iter()))
}

/// The Hilbert order of `points` alone, in one round.
pub fn hilbert(points: &[Point]) -> Vec<u32> {
    Curve(Cube::around(points.iter())).hilbert(points)
}

/// The BRIO round, 0 to `rounds`, of the point with this index: the last one with probability 7/8.
#[inline]
pub fn round_of(index: u32, rounds: u32) -> u32 {
    // Three zero bits have probability 1/8.
    rounds - (scramble(u64::from(index)).trailing_zeros() / 3).min(rounds)
}

/// Hilbert order in each of the rounds 0 to `rounds`.
fn in_rounds(points: &[Point], rounds: u32, frame: Cube) -> Vec<u32> {
    let key = |(i, p): (usize, &Point)| {
        let round = round_of(i as u32, rounds);
        Keyed { key: u64::from(round) << (3 * BITS) | frame.key(p), index: i as u32 }
    };
    let mut keyed: Vec<Keyed> = match points.len() < MANY {
        true => points.iter().enumerate().map(key).collect(),
        false => points.par_iter().enumerate().map(key).collect(),
    };
    keyed.par_sort_unstable();
    refine(points, &mut keyed, 1);
    keyed.into_iter().map(|keyed| keyed.index).collect()
}

/// A point by its key.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Keyed {
    key: u64,
    index: u32,
}

/// Sorts each long run of equal keys in the box of its own points.
fn refine(points: &[Point], keyed: &mut [Keyed], depth: usize) {
    if depth == MAX_DEPTH {
        return;
    }
    let is_one = |a: &Keyed, b: &Keyed| a.key == b.key;
    let is_long = |run: &&mut [Keyed]| run.len() > SHORT_RUN;
    let refine_run = |run: &mut [Keyed]| {
        let frame = Cube::around(run.iter().map(|point| &points[point.index as usize]));
        if frame.side == 0.0 {
            return; // all the same point
        }
        for Keyed { key, index } in run.iter_mut() {
            *key = frame.key(&points[*index as usize]);
        }
        run.sort_unstable();
        refine(points, run, depth + 1);
    };
    match keyed.len() < MANY {
        true => keyed.chunk_by_mut(is_one).filter(is_long).for_each(refine_run),
        false => keyed.par_chunk_by_mut(is_one).filter(is_long).for_each(refine_run),
    }
}

/// A Hilbert curve through a box, of fixed depth: it says where a point that came later lies among
/// those that were ordered.
#[derive(Clone, Copy, Debug)]
pub struct Curve(Cube);

impl Curve {
    /// The curve by which [`hilbert`] orders points whose bounding box is `low`..`high`, but for
    /// what it sorts again in clusters.
    pub fn of_box(low: Point, high: Point) -> Self {
        Self(Cube::around([low, high].iter()))
    }

    /// The number of the cell of `p` along the curve. A point outside the box has that of a cell at
    /// its border.
    #[inline]
    pub fn key(&self, p: &Point) -> u64 {
        if self.0.side > 0.0 { self.0.key(p) } else { 0 }
    }

    /// The order that [`hilbert`] has, of some of the points in the box: all or none of a cell.
    pub fn hilbert(&self, points: &[Point]) -> Vec<u32> {
        in_rounds(points, 0, self.0)
    }

    /// The numbers of points along the curve; those in one cell in the order in which they are. On
    /// one thread.
    pub fn order(&self, points: &[Point]) -> Vec<u32> {
        let mut keyed: Vec<(u64, u32)> = points.iter().map(|p| self.key(p)).zip(0..).collect();
        keyed.sort_unstable();
        keyed.into_iter().map(|(_, i)| i).collect()
    }
}

/// The corners of the smallest box around points.
pub fn bounding_box<'a>(points: impl IntoIterator<Item = &'a Point>) -> (Point, Point) {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for p in points {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    (low, high)
}

/// An axis-parallel cube that holds some points. Coordinates are halved, so that the side of the
/// cube around any finite points is finite.
#[derive(Clone, Copy, Debug)]
struct Cube {
    low: Point,
    side: f64,
}

impl Cube {
    fn around<'a>(points: impl Iterator<Item = &'a Point>) -> Self {
        let (low, high) = bounding_box(points);
        let [low, high] = [low, high].map(|corner| corner.map(|c| c * 0.5));
        let side = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        Self { low, side }
    }

    /// The Hilbert number of the cell of `p`.
    #[inline]
    fn key(&self, p: &Point) -> u64 {
        const CELLS: f64 = (1u64 << BITS) as f64;
        let cell = [0, 1, 2].map(|k| {
            // A saturating cast: the quotient of a subnormal side may exceed 1 a little.
            let c = (p[k] * 0.5 - self.low[k]) / self.side * CELLS;
            (c as u32).min((1 << BITS) - 1)
        });
        hilbert_number(cell)
    }
}

/// The number of a cell along the three-dimensional Hilbert curve, two levels at a time.
#[inline]
fn hilbert_number(cell: [u32; 3]) -> u64 {
    let [x, y, z] = cell.map(|c| spread(u64::from(c)));
    let morton = x | y << 1 | z << 2;
    let (mut number, mut state) = (0u64, 0u16);
    for pair in (0..BITS / 2).rev() {
        let octants = (morton >> (6 * pair)) as u16 & 63;
        let step = STEPS[(state | octants) as usize % STEPS.len()];
        number = number << 6 | u64::from(step & 63);
        state = step & !63;
    }
    number
}

/// The curve as a table: index `state << 6 | two octants`, value `next state << 6 | two digits`.
///
/// A state is the curve's entry corner e and direction d in a cell (Hamilton, Compact Hilbert
/// Indices, Dalhousie University CS-2006-07, sections 2.1 to 2.3), numbered 3 e + d.
const STEPS: [u16; 32 * 64] = {
    let mut table = [0; 32 * 64];
    let mut index = 0;
    while index < 24 * 64 {
        let (high, state) = level((index / 64) as u16, (index >> 3 & 7) as u16);
        let (low, state) = level(state, (index & 7) as u16);
        table[index] = state << 6 | high << 3 | low;
        index += 1;
    }
    table
};

/// One level of the curve: from state and octant to digit and next state.
const fn level(state: u16, octant: u16) -> (u16, u16) {
    let (e, d) = (state / 3, state % 3);
    let turned = turn_left(octant ^ e, 3 - (d + 1));
    let digit = turned ^ turned >> 1 ^ turned >> 2; // the inverse of the Gray code
    let entry = if digit == 0 { 0 } else { gray_code((digit - 1) & !1) };
    let direction = match digit {
        0 => 0,
        w if w & 1 == 1 => w.trailing_ones() as u16 % 3,
        w => (w - 1).trailing_ones() as u16 % 3,
    };
    let e = e ^ turn_left(entry, d + 1);
    let d = (d + direction + 1) % 3;
    (digit, 3 * e + d)
}

/// The binary reflected Gray code.
const fn gray_code(v: u16) -> u16 {
    v ^ v >> 1
}

/// Rotates three bits to the left, by 0 to 3.
const fn turn_left(v: u16, by: u16) -> u16 {
    (v << by | v >> (3 - by)) & 7
}

/// Puts two zero bits between the bits of a number of at most 21 bits.
#[inline]
fn spread(mut v: u64) -> u64 {
    v = (v | v << 32) & 0x001f_0000_0000_ffff;
    v = (v | v << 16) & 0x001f_0000_ff00_00ff;
    v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
    v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
    (v | v << 2) & 0x1249_2492_4924_9249
}

/// SplitMix64's finaliser: a bijective hash.
#[inline]
fn scramble(i: u64) -> u64 {
    let mut z = i.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hilbert_steps_to_a_face_neighbour() {
        // On the coarse 8^3 grid the curve visits each cell once, one step at a time.
        let shift = BITS - 3;
        let mut cells: Vec<(u64, [i32; 3])> = Vec::new();
        for x in 0..8u32 {
            for y in 0..8 {
                for z in 0..8 {
                    let n = hilbert_number([x << shift, y << shift, z << shift]) >> (3 * shift);
                    cells.push((n, [x as i32, y as i32, z as i32]));
                }
            }
        }
        cells.sort_unstable();
        for (k, (n, _)) in cells.iter().enumerate() {
            assert_eq!(*n, k as u64);
        }
        for pair in cells.windows(2) {
            let step: i32 = (0..3).map(|k| (pair[0].1[k] - pair[1].1[k]).abs()).sum();
            assert_eq!(step, 1, "{pair:?}");
        }
    }

    /// The table takes two levels at a time; here they are taken one by one.
    #[test]
    fn the_table_is_two_levels_of_the_curve() {
        for i in 0..2000 {
            let cell = [0, 20, 40].map(|shift| (scramble(i) >> shift) as u32 & ((1 << BITS) - 1));
            let (mut number, mut state) = (0, 0);
            for bit in (0..BITS).rev() {
                let [x, y, z] = cell.map(|c| (c >> bit & 1) as u16);
                let (digit, next) = level(state, x | y << 1 | z << 2);
                number = number << 3 | u64::from(digit);
                state = next;
            }
            assert_eq!(hilbert_number(cell), number, "{cell:?}");
        }
    }

    /// SplitMix64 from seed 0: its first outputs, as published with it.
    #[test]
    fn the_coin_is_the_hash_that_it_says() {
        assert_eq!(scramble(0), 0xe220_a839_7b1d_cdaf);
        assert_eq!(scramble(0x9e37_79b9_7f4a_7c15), 0x6e78_9e6a_a1b9_65f4);
    }

    fn random(count: u64) -> Vec<Point> {
        let part = |r: u64, shift: u32| (r >> shift & 0xf_ffff) as f64;
        (0..count)
            .map(|i| scramble(i + 1_000_000))
            .map(|r| [part(r, 0), part(r, 20), part(r, 40)])
            .collect()
    }

    /// The round of a point, the first being 0: seven of eight points come in the last.
    fn round_of(i: u32, rounds: u32) -> u32 {
        let hash = scramble(u64::from(i));
        (1..=rounds).find(|k| !hash.is_multiple_of(8u64.pow(*k))).map_or(0, |k| rounds + 1 - k)
    }

    #[test]
    fn rounds_have_their_shares() {
        for (count, rounds) in [(512, 0), (513, 1), (4103, 1), (4104, 2), (40_000, 3)] {
            let points = random(count);
            let order = brio_hilbert(&points);
            let of: Vec<u32> = order.iter().map(|&i| round_of(i, rounds)).collect();
            assert!(of.is_sorted(), "{count} points: rounds are mixed");
            let last = of.iter().filter(|&&round| round == rounds).count() as f64;
            let share = if rounds == 0 { 1.0 } else { 7.0 / 8.0 };
            assert!(
                (last / count as f64 - share).abs() < 0.04,
                "{count}: {last} in the last round"
            );
            // Inside a round along the curve of the whole box.
            let frame = Cube::around(points.iter());
            let keys = order.iter().zip(&of).map(|(&i, &r)| (r, frame.key(&points[i as usize])));
            assert!(keys.is_sorted(), "{count} points");
        }
    }

    #[test]
    fn cells_are_parts_of_the_cube_around_the_points() {
        // A box of 2^20 steps: cells are steps. The least side decides nothing.
        for (low, step) in [(0.0, 1.0), (-3.0, 0.5), (1e6, 8.0)] {
            let at = |c: [f64; 3]| c.map(|c| low + c * step);
            let most = f64::from(1 << BITS);
            let corners = [at([most, 0.0, 4.0]), at([0.0, 9.0, most / 2.0]), at([0.0; 3])];
            let frame = Cube::around(corners.iter());
            let cells = [[0, 0, 0], [5, 7, 1], [(1 << BITS) - 1, 0, 3], [1, 1 << 19, 77]];
            for cell in cells {
                for part in [0.0, 0.5, 0.75] {
                    let p = at(cell.map(|c| f64::from(c) + part));
                    assert_eq!(frame.key(&p), hilbert_number(cell), "{cell:?} + {part}");
                }
            }
            // The far end belongs to the last cell.
            let last = (1 << BITS) - 1;
            assert_eq!(frame.key(&at([most, 0.0, 0.0])), hilbert_number([last, 0, 0]));
        }
    }

    #[test]
    fn longer_runs_of_one_cell_are_ordered_among_themselves() {
        // All in one cell of the box of the far corner, in the curve's own order in their box.
        let run = |count: usize| -> Vec<u32> {
            let mut points: Vec<Point> =
                random(count as u64).into_iter().map(|p| p.map(|c| c * 1e-12)).collect();
            points.push([1e9; 3]);
            let mut order = hilbert(&points);
            assert_eq!(order.pop(), Some(count as u32), "the far corner comes last");
            let frame = Cube::around(points[..count].iter());
            let sorted = order.is_sorted_by_key(|&i| frame.key(&points[i as usize]));
            assert_eq!(sorted, count > SHORT_RUN, "{count} points");
            order
        };
        run(SHORT_RUN + 1);
        run(50);
        // Short runs stay as the first keys had them: equal, so by number.
        assert!(run(SHORT_RUN).is_sorted());
    }

    #[test]
    fn orders_are_permutations_at_any_scale() {
        let mut points: Vec<Point> = Vec::new();
        for decade in -300..300 {
            for k in 0..20 {
                let s = 10f64.powi(decade);
                points.push([s * (1.0 + k as f64 / 64.0), s * (k * k) as f64, -s]);
            }
        }
        points.push([f64::MAX; 3]);
        points.push([-f64::MAX; 3]);
        points.extend(vec![[5e-324, 0.0, 0.0]; 20]);
        for mut order in [brio_hilbert(&points), hilbert(&points)] {
            order.sort_unstable();
            assert!(order.iter().enumerate().all(|(k, &i)| k == i as usize));
        }
        assert!(brio_hilbert(&[]).is_empty());
    }

    #[test]
    fn a_cluster_far_below_the_cell_size_is_ordered() {
        // Two far points make the cells huge; the cluster must still follow a curve of its own.
        let mut points = vec![[-1e9; 3], [1e9; 3]];
        points.extend((0..4096u64).map(|i| {
            let r = scramble(i);
            [0, 20, 40].map(|s| (r >> s & 0xfffff) as f64 * 1e-15)
        }));
        let order = hilbert(&points);
        let length: f64 = order
            .windows(2)
            .map(|w| (points[w[0] as usize], points[w[1] as usize]))
            .filter(|(p, q)| p[0].abs() < 1.0 && q[0].abs() < 1.0)
            .map(|(p, q)| (0..3).map(|k| (p[k] - q[k]).abs()).sum::<f64>())
            .sum();
        // In random order the mean step would be the cluster's size, about 1e-9.
        assert!(length / 4096.0 < 2e-10, "{length:e}");
    }
}
