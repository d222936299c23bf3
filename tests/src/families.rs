//! The input families of the bars: point sets on which kernels go wrong, or slow.
//!
//! Every family is a function of its sizes and a seed, on every machine: integers, `+ - * /` and
//! `sqrt` only. Coordinates are exact where the family's point is that they are (grids, spheres,
//! rings, planes, lines).

use ltbw::Point;
use ltbw_generate::{PointKind, generate};

pub use ltbw_generate::Random as Rng;

/// A named point set.
#[derive(Debug, Clone)]
pub struct Family {
    /// Name, as tables and failures print it.
    pub name: String,
    /// The points.
    pub points: Vec<Point>,
}

/// The size of the sets of [`all`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// Some 100 points each: twenty insertion orders of each are cheap.
    Small,
    /// Some 10,000 points each: for `cargo test`.
    Moderate,
    /// The full bars: a million points where the bar says so.
    Full,
}

/// 2^e for a normal result.
#[must_use]
pub fn two_to(e: i32) -> f64 {
    assert!((-1022..=1023).contains(&e), "2^{e} is not a normal f64");
    f64::from_bits(((1023 + e) as u64) << 52)
}

/// `n` points uniform in the unit cube.
#[must_use]
pub fn uniform(n: usize, seed: u64) -> Vec<Point> {
    let mut rng = Rng::new(seed);
    (0..n).map(|_| std::array::from_fn(|_| rng.unit())).collect()
}

/// The integer grid 0..k in each direction: k^3 points.
#[must_use]
pub fn grid(k: usize) -> Vec<Point> {
    let at = |i: usize| [i / (k * k), i / k % k, i % k].map(|c| c as f64);
    (0..k * k * k).map(at).collect()
}

/// The grid, moved to [1, 2) so that all units in the last place are equal, each coordinate then
/// moved by -1, 0 or +1 of them.
#[must_use]
pub fn grid_ulps(k: usize, seed: u64) -> Vec<Point> {
    let mut rng = Rng::new(seed);
    let step = two_to(-(k.ilog2() as i32 + 1));
    let mut moved = |c: f64| (1.0 + c * step) + (rng.below(3) as f64 - 1.0) * f64::EPSILON;
    // Below 1 the units are half as large, so the lowest layer starts one cell in.
    grid(k - 1).into_iter().map(|p| p.map(|c| moved(c + 1.0))).collect()
}

/// The body-centred grid: k^3 cells, corners and centres, on even and odd integers.
#[must_use]
pub fn body_centred(k: usize) -> Vec<Point> {
    let corners = grid(k + 1).into_iter().map(|p| p.map(|c| 2.0 * c));
    let centres = grid(k).into_iter().map(|p| p.map(|c| 2.0 * c + 1.0));
    corners.chain(centres).collect()
}

/// Integer points exactly on spheres around the origin, of the squared radii `squares`.
#[must_use]
pub fn spheres(squares: &[i64]) -> Vec<Point> {
    let mut points = Vec::new();
    for &square in squares {
        let r = square.isqrt();
        for x in -r..=r {
            let rest = square - x * x;
            let s = rest.isqrt();
            for y in -s..=s {
                let z = (rest - y * y).isqrt();
                if z * z == rest - y * y {
                    points.extend(
                        [z, -z]
                            .iter()
                            .take(if z == 0 { 1 } else { 2 })
                            .map(|&z| [x, y, z].map(|c| c as f64)),
                    );
                }
            }
        }
    }
    points
}

/// Rings of integer points exactly on a cylinder: `height` layers of all (x, y) with
/// x^2 + y^2 = `square`.
#[must_use]
pub fn cylinder(square: i64, height: usize) -> Vec<Point> {
    let r = square.isqrt();
    let mut ring = Vec::new();
    for x in -r..=r {
        let y = (square - x * x).isqrt();
        if y * y == square - x * x {
            ring.extend([y, -y].iter().take(if y == 0 { 1 } else { 2 }).map(|&y| [x, y]));
        }
    }
    let at =
        |layer: usize| ring.iter().map(move |&[x, y]| [x as f64, y as f64, layer as f64 * 16.0]);
    (0..height).flat_map(at).collect()
}

/// Clusters over nine decades: `n` points around 30 random centres, at distances from 1 to 1e-9.
#[must_use]
pub fn clusters(n: usize, seed: u64) -> Vec<Point> {
    let mut rng = Rng::new(seed);
    let centres = uniform(30, seed ^ 1);
    (0..n)
        .map(|_| {
            let centre = centres[rng.below(30) as usize];
            let scale = (0..rng.below(10)).fold(1.0, |scale, _| scale / 10.0);
            centre.map(|c| c + (rng.unit() - 0.5) * scale)
        })
        .collect()
}

/// `n` integer points on five planes: x = 0, y = 7, z = -3, x + y + z = 100 and x = 2 y.
#[must_use]
pub fn planes(n: usize, side: u64, seed: u64) -> Vec<Point> {
    let mut rng = Rng::new(seed);
    (0..n)
        .map(|i| {
            let [u, v] = [rng.below(side), rng.below(side)].map(|c| c as f64);
            match i % 5 {
                0 => [0.0, u, v],
                1 => [u, 7.0, v],
                2 => [u, v, -3.0],
                3 => [u, v, 100.0 - u - v],
                _ => [2.0 * u, u, v],
            }
        })
        .collect()
}

/// Every point of `points` three times, in random order.
#[must_use]
pub fn triplicated(points: &[Point], seed: u64) -> Vec<Point> {
    let mut all = [points, points, points].concat();
    Rng::new(seed).shuffle(&mut all);
    all
}

/// All coordinates times 2^e.
#[must_use]
pub fn scaled(points: &[Point], e: i32) -> Vec<Point> {
    let factor = two_to(e);
    points.iter().map(|p| p.map(|c| c * factor)).collect()
}

/// `n` points (t, t^2, t^3), t = i/n: about n^2 / 2 tetrahedra.
#[must_use]
pub fn moment_curve(n: usize) -> Vec<Point> {
    (0..n).map(|i| i as f64 / n as f64).map(|t| [t, t * t, t * t * t]).collect()
}

/// `n` points on each of two skew lines: (n - 1)^2 tetrahedra.
#[must_use]
pub fn skew_lines(n: usize) -> Vec<Point> {
    let at = |i: usize| i as f64;
    (0..n).map(|i| [at(i), 0.0, 0.0]).chain((0..n).map(|i| [0.0, at(i), 1.0])).collect()
}

/// The grid around the origin with zeros of both signs: equal points with different bits.
#[must_use]
pub fn signed_zeros(k: usize, seed: u64) -> Vec<Point> {
    let mut rng = Rng::new(seed);
    let centred: Vec<Point> = grid(k).into_iter().map(|p| p.map(|c| c - (k / 2) as f64)).collect();
    let mut both = [centred.clone(), centred].concat();
    for c in both.iter_mut().flatten().filter(|c| **c == 0.0) {
        *c = if rng.below(2) == 0 { 0.0 } else { -0.0 };
    }
    both
}

/// Points from numbers, full of coincidences: the one generator behind the random degenerate sets
/// of proptest, of the fuzzer and of [`snapped`].
///
/// `style` chooses a carrier (a lattice of 1 to 9 values a side; integer points of one sphere; a
/// sheared lattice; a cylinder of rings), a step (1, 0.1, 1/3, powers of two far from 1) and an
/// offset. Each cell is a point on the carrier; in half of the styles its last number moves some
/// points by an ulp.
#[must_use]
pub fn snap(style: u32, cells: &[[u8; 4]]) -> Vec<Point> {
    let choose = |shift: u32, n: u32| (style >> shift) % n;
    let side = [2, 3, 4, 5, 9, 17][choose(0, 6) as usize];
    let carrier = choose(4, 5);
    let step = match choose(8, 8) {
        0..=2 => 1.0,
        3 => 0.1,
        4 => 1.0 / 3.0,
        5 => two_to(-120),
        6 => two_to(190),
        _ => two_to(-700),
    };
    let offset = [0.0, 0.0, -2.0, 1e6][choose(12, 4) as usize];
    let (noisy, flat) = (choose(16, 2) == 1, choose(20, 8) == 7);
    let table: Vec<Point> = match carrier {
        0 => spheres(&[9, 41]),
        1 => cylinder(25, 4),
        _ => Vec::new(),
    };
    let shear = if carrier == 2 { 2.0 } else { 0.0 };
    cells
        .iter()
        .map(|&[x, y, z, jitter]| {
            let [x, y, z] = if table.is_empty() {
                let layers = if flat { 1 } else { side };
                [f64::from(x % side), f64::from(y % side), f64::from(z % layers)]
            } else {
                table[(usize::from(x) << 8 | usize::from(y)) % table.len()]
            };
            let mut p = [x, y, z + shear * x].map(|c| (c + offset) * step);
            if noisy && jitter < 48 {
                let c = &mut p[usize::from(jitter % 3)];
                *c = if jitter % 2 == 0 { c.next_up() } else { c.next_down() };
            }
            p
        })
        .collect()
}

/// A random degenerate set of 5 to 60 points, by [`snap`].
#[must_use]
pub fn snapped(seed: u64) -> Vec<Point> {
    let mut rng = Rng::new(seed);
    let n = 5 + rng.below(56);
    let style = rng.bits() as u32;
    let cells: Vec<[u8; 4]> = (0..n).map(|_| (rng.bits() as u32).to_le_bytes()).collect();
    snap(style, &cells)
}

/// `n` points of random directions, rounded onto the unit sphere: nearly cospherical.
#[must_use]
pub fn rounded_sphere(n: usize, seed: u64) -> Vec<Point> {
    generate(PointKind::Sphere, n, seed)
}

/// `n` points in a thin spherical shell.
#[must_use]
pub fn shell(n: usize, seed: u64) -> Vec<Point> {
    generate(PointKind::Shell, n, seed)
}

/// `n` points, each coordinate of either sign, times a random power of two in +-`span`: the
/// exactness window holds none of it.
#[must_use]
pub fn mixed_exponents(n: usize, span: u64, seed: u64) -> Vec<Point> {
    let mut rng = Rng::new(seed);
    let mut coordinate = || {
        let sign = if rng.below(2) == 0 { 1.0 } else { -1.0 };
        sign * (1.0 + rng.unit()) * two_to(rng.below(2 * span + 1) as i32 - span as i32)
    };
    (0..n).map(|_| std::array::from_fn(|_| coordinate())).collect()
}

/// `n` points of random bits: every finite number is as likely as its neighbours, subnormal and
/// largest ones included.
#[must_use]
pub fn random_bits(n: usize, seed: u64) -> Vec<Point> {
    let mut rng = Rng::new(seed);
    let mut coordinate = || {
        // The exponent 0x7ff, infinities and NaN, is never drawn.
        let exponent = rng.below(0x7ff) << 52;
        f64::from_bits(rng.bits() & !(0x7ff << 52) | exponent)
    };
    (0..n).map(|_| std::array::from_fn(|_| coordinate())).collect()
}

/// The grid in steps of the smallest subnormal number, 2^-1074.
#[must_use]
pub fn subnormal_grid(k: usize) -> Vec<Point> {
    grid(k).into_iter().map(|p| p.map(|c| f64::from_bits(c as u64))).collect()
}

/// The grid, turned by an angle without exact sine: nearly cospherical everywhere, and nearly flat
/// tetrahedra of rounding noise.
#[must_use]
pub fn turned_grid(k: usize) -> Vec<Point> {
    // The matrix of the quaternion (1, 0.3, 0.5, 0.7), scaled to a rotation in rounded arithmetic.
    let [w, x, y, z] = [1.0f64, 0.3, 0.5, 0.7];
    let n = w * w + x * x + y * y + z * z;
    let rows = [
        [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ];
    let turn = |p: Point| rows.map(|r| (r[0] * p[0] + r[1] * p[1] + r[2] * p[2]) / n);
    grid(k).into_iter().map(turn).collect()
}

/// Sets outside the exactness window: for the big-integer mode.
#[must_use]
pub fn wide(size: Size) -> Vec<Family> {
    let (n, k) = match size {
        Size::Small => (60, 4),
        Size::Moderate => (1_500, 12),
        Size::Full => (20_000, 40),
    };
    let family = |name: &str, points| Family { name: name.to_string(), points };
    let mut mixed = scaled(&grid(k), 600);
    mixed.extend(subnormal_grid(k));
    vec![
        family("exponents +-300", mixed_exponents(n, 300, 1)),
        family("exponents +-1000", mixed_exponents(n, 1000, 2)),
        family("random bits", random_bits(n, 3)),
        family("grid*2^600", scaled(&grid(k), 600)),
        family("subnormal grid", subnormal_grid(k)),
        family("grid*2^600 and subnormal grid", mixed),
    ]
}

/// The sets whose speed is measured beside [`all`]'s.
#[must_use]
pub fn more_speed(size: Size) -> Vec<Family> {
    let (n, k) = match size {
        Size::Small => (150, 5),
        Size::Moderate => (20_000, 20),
        Size::Full => (1_000_000, 70),
    };
    let family = |name: &str, points| Family { name: name.to_string(), points };
    vec![
        family("rounded-sphere", rounded_sphere(n, 1)),
        family("shell", shell(n, 1)),
        family("turned-grid", turned_grid(k)),
    ]
}

/// All families, at one size.
#[must_use]
pub fn all(size: Size) -> Vec<Family> {
    // n: points of a random set; k: side of a grid; curve: points of the quadratic sets.
    let (n, k, curve) = match size {
        Size::Small => (150, 5, 30),
        Size::Moderate => (20_000, 20, 150),
        Size::Full => (1_000_000, 100, 2_000),
    };
    // Sums of three squares, and of two, in many ways: spheres of 10^5 points at full size.
    let (squares, ring): (&[i64], i64) = match size {
        Size::Small => (&[9, 41], 65),
        Size::Moderate => (&[41, 1_001, 100_001], 5_525),
        Size::Full => (&[41, 100_001, 10_000_001, 100_000_001], 48_612_265),
    };
    let (layers, seed) = (curve / 2, 1);
    let family = |name: &str, points| Family { name: name.to_string(), points };
    let cube = |side: usize, e: i32| family(&format!("grid*2^{e}"), scaled(&grid(side), e));
    let side = k.min(40);
    vec![
        family("uniform", uniform(n, seed)),
        family("grid", grid(k)),
        family("grid+-ulps", grid_ulps(k, seed)),
        family("body-centred", body_centred(k * 3 / 4)),
        family("spheres", spheres(squares)),
        family("cylinder", cylinder(ring, layers)),
        family("clusters", clusters(n, seed)),
        family("planes", planes(n / 2, (n as u64).isqrt(), seed)),
        family("triplicated", triplicated(&grid(k * 3 / 5), seed)),
        cube(side, -120),
        cube(side, 190),
        cube(side, -700),
        family("moment-curve", moment_curve(curve)),
        family("skew-lines", skew_lines(curve / 2)),
        family("signed-zeros", signed_zeros(side / 2 * 2 + 1, seed)),
    ]
}

#[cfg(test)]
mod tests {
    use super::{Rng, Size, all, cylinder, grid_ulps, snapped, spheres};

    #[test]
    fn spheres_and_rings_are_exact_and_complete() {
        assert_eq!(spheres(&[9]).len(), 30); // (3,0,0) 6 ways, (2,2,1) 24 ways
        assert!(spheres(&[41]).iter().all(|[x, y, z]| x * x + y * y + z * z == 41.0));
        assert_eq!(cylinder(65, 2).len(), 2 * 16); // 65 = 1 + 64 = 16 + 49
    }

    #[test]
    fn ulps_are_ulps() {
        let points = grid_ulps(5, 1);
        assert_eq!(points.len(), 64);
        assert!(points.iter().flatten().all(|&c| (1.0..2.0).contains(&c)));
    }

    #[test]
    fn families_are_functions_of_their_seed_and_hold_points() {
        let (a, b) = (all(Size::Small), all(Size::Small));
        assert!(a.iter().zip(&b).all(|(a, b)| a.points == b.points && a.points.len() > 10));
        assert_eq!(snapped(7), snapped(7));
        assert!((0..1000).all(|seed| (5..=60).contains(&snapped(seed).len())));
    }

    #[test]
    fn shuffling_permutes() {
        let mut items: Vec<u32> = (0..100).collect();
        Rng::new(3).shuffle(&mut items);
        assert_ne!(items, (0..100).collect::<Vec<u32>>());
        items.sort_unstable();
        assert_eq!(items, (0..100).collect::<Vec<u32>>());
    }
}
