//! Cost of the predicates by stage, beside the crate `robust` in the same run.
//!
//! `cargo run --release -p ltbw-core --example predicate_speed`
//!
//! Each row is one kind of input: nanoseconds per call of our predicate (the best of several
//! passes), the same for `robust`, and the ratio. Nanoseconds vary with the machine and its
//! load; ratios much less.

use std::hint::black_box;
use std::time::Instant;

use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, exact, filter, insphere, orient3d, perturb};

/// Inputs of a row: more than the branch predictor learns, fewer than leave the cache.
const COUNT: usize = 32768;
const PASSES: usize = 25;

type Five = [Point; 5];

/// A small generator of pseudo-random numbers (SplitMix64): no dependency, the same everywhere.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [-1, 1).
    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Uniform in 0..n.
    fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    fn point(&mut self) -> Point {
        std::array::from_fn(|_| self.unit())
    }
}

fn inputs(seed: u64, mut one: impl FnMut(&mut Random) -> Five) -> Vec<Five> {
    let mut random = Random(seed);
    (0..COUNT).map(|_| one(&mut random)).collect()
}

/// Five corners of a cell of edge `edge` in a grid of `n` cells: always cospherical.
fn cell(random: &mut Random, n: u64, edge: u64) -> Five {
    let base: [u64; 3] = std::array::from_fn(|_| random.below(n));
    let first = random.below(8);
    std::array::from_fn(|i| {
        let corner = (first + i as u64) % 8;
        std::array::from_fn(|k| ((base[k] + (corner >> k & 1)) * edge) as f64)
    })
}

/// Five integer points of one sphere, coordinates of about `bits` bits, not of one cell.
fn shell(random: &mut Random, bits: u32) -> Five {
    let v: [f64; 3] = std::array::from_fn(|_| (random.below(1 << bits) | 1) as f64);
    std::array::from_fn(|_| {
        let turn = random.below(3) as usize;
        let signs = random.bits();
        std::array::from_fn(|k| {
            let c = v[(k + turn) % 3];
            if signs >> k & 1 == 1 { -c } else { c }
        })
    })
}

/// Five points rounded onto the unit sphere, within `radius` of each other.
fn sphere(random: &mut Random, radius: f64) -> Five {
    let centre = random.point();
    std::array::from_fn(|_| {
        let offset = random.point();
        let p: Point = std::array::from_fn(|k| centre[k] + radius * offset[k]);
        let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
        p.map(|c| c / length)
    })
}

/// Nanoseconds per call: the best pass, which the rest of the machine disturbed least.
fn time(points: &[Five], mut call: impl FnMut(&Five) -> i64) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..PASSES {
        let start = Instant::now();
        let mut sum = 0;
        for five in points {
            sum += call(black_box(five));
        }
        black_box(sum);
        best = best.min(start.elapsed().as_secs_f64());
    }
    best * 1e9 / points.len() as f64
}

fn coord(p: &Point) -> robust::Coord3D<f64> {
    robust::Coord3D { x: p[0], y: p[1], z: p[2] }
}

fn robust_orient(five: &Five) -> i64 {
    let [a, b, c, d, _] = five.each_ref().map(coord);
    Sign::from_f64(robust::orient3d(a, b, c, d)) as i64
}

fn robust_insphere(five: &Five) -> i64 {
    let [a, b, c, d, e] = five.each_ref().map(coord);
    Sign::from_f64(robust::insphere(a, b, c, d, e)) as i64
}

fn optional(sign: Option<Sign>) -> i64 {
    sign.map_or(2, |sign| sign as i64)
}

fn row(name: &str, ours: f64, robust: f64) {
    println!("{name:<52} {ours:>8.1} {robust:>8.1} {:>7.2}", ours / robust);
}

fn orient_rows(name: &str, points: &[Five]) {
    let robust = time(points, robust_orient);
    row(
        &format!("orient3d exact stage   {name}"),
        time(points, |[a, b, c, d, _]| exact::orient3d(a, b, c, d) as i64),
        robust,
    );
}

fn insphere_rows(name: &str, points: &[Five]) {
    let undecided =
        points.iter().filter(|[a, b, c, d, e]| filter::insphere_window(a, b, c, d, e).is_none());
    let share = undecided.count() as f64 / points.len() as f64;
    let robust = time(points, robust_insphere);
    let staged = time(points, |[a, b, c, d, e]| exact::insphere(a, b, c, d, e) as i64);
    let whole = time(points, |[a, b, c, d, e]| insphere(a, b, c, d, e) as i64);
    row(&format!("insphere exact stage   {name}"), staged, robust);
    row(&format!("insphere, {:>3.0} % to it   {name}", share * 100.0), whole, robust);
}

fn main() {
    println!("{:<52} {:>8} {:>8} {:>7}", "ns per call", "ours", "robust", "ratio");
    let random = inputs(1, |r| std::array::from_fn(|_| r.point()));
    let orient = time(&random, robust_orient);
    row(
        "orient3d filter, window      random",
        time(&random, |[a, b, c, d, _]| optional(filter::orient3d_window(a, b, c, d))),
        orient,
    );
    row(
        "orient3d, any coordinates    random",
        time(&random, |[a, b, c, d, _]| orient3d(a, b, c, d) as i64),
        orient,
    );
    let side = time(&random, robust_insphere);
    row(
        "insphere filter, window      random",
        time(&random, |[a, b, c, d, e]| optional(filter::insphere_window(a, b, c, d, e))),
        side,
    );
    row(
        "insphere, any coordinates    random",
        time(&random, |[a, b, c, d, e]| insphere(a, b, c, d, e) as i64),
        side,
    );

    orient_rows("unit cells (few bits)", &inputs(2, |r| cell(r, 100, 1)));
    orient_rows("random (small)", &random);
    insphere_rows("unit cells (few bits)", &inputs(2, |r| cell(r, 100, 1)));
    insphere_rows("shells of 9 bits", &inputs(3, |r| shell(r, 8)));
    insphere_rows("shells of 15 bits", &inputs(4, |r| shell(r, 14)));
    insphere_rows("shells of 24 bits (small)", &inputs(5, |r| shell(r, 23)));
    insphere_rows("shells of 50 bits (small)", &inputs(6, |r| shell(r, 49)));
    insphere_rows("sphere, radius 2^-9", &inputs(7, |r| sphere(r, 1.0 / 512.0)));
    insphere_rows("sphere, radius 1", &inputs(8, |r| sphere(r, 1.0)));
    insphere_rows("random (small)", &random);

    let flat = |r: &mut Random, exponent: i32| -> Five {
        std::array::from_fn(|_| {
            let p = r.point();
            [p[0], p[1], p[2] * 2.0_f64.powi(exponent)]
        })
    };
    insphere_rows("z times 2^-40 (medium)", &inputs(9, |r| flat(r, -40)));
    insphere_rows("z times 2^-120 (big)", &inputs(10, |r| flat(r, -120)));

    let cells = inputs(11, |r| {
        loop {
            let five = cell(r, 100, 1);
            let [a, b, c, d, _] = &five;
            if orient3d(a, b, c, d) == Sign::Positive {
                return five;
            }
        }
    });
    row(
        "perturbed in-sphere          unit cells",
        time(&cells, |[a, b, c, d, e]| perturb::side_of_sphere(a, b, c, d, e) as i64),
        time(&cells, robust_insphere),
    );
}
