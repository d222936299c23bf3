//! Test point sets: uniform, gridded, degenerate and awkward, the same on every machine. Test
//! domains are in [`domains`], [`surfaces`], [`layers`] and [`plates`], points in them in
//! [`scattered`].
//!
//! Random numbers come from a generator of our own, and coordinates are made with + − × ÷ √
//! only, whose results IEEE 754 fixes to the bit. A point set is a function of its kind, size and
//! seed; golden tests hold it still.

#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

pub mod domains;
pub mod layers;
pub mod plates;
pub mod scattered;
pub mod surfaces;

pub use domains::{DomainKind, Shape, ShapeError, generate_domain};
pub use ltbw_core::Random;
use ltbw_exact::Point;

/// The kinds of point sets. Unless a kind says otherwise it has exactly the size asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum PointKind {
    /// Uniform in the unit cube.
    Uniform,
    /// The integer grid `0..k` in each axis, `k` the least with `k³ ≥ n`: `k³` points.
    Grid,
    /// Body-centred grid, integer coordinates: corners at even, centres at odd places; `2k³`
    /// points, `k` the least with `2k³ ≥ n`.
    Bcc,
    /// Directions uniform on the unit sphere, rounded to doubles: nearly cospherical.
    Sphere,
    /// Uniform in a thin shell: radius 0.99 to 1.
    Shell,
    /// Ten clusters, of size 1 down to 1e-9, at random places in the unit cube.
    Clusters,
    /// Half the points on each of two skew lines. The mesh has about `n²/4` tetrahedra.
    Lines,
    /// The moment curve (i, i², i³) for i from 0. The mesh has about `n²/2` tetrahedra. From
    /// i = 208,064 on the cubes are rounded.
    Moment,
    /// Points exactly on four planes: z = 0, z = 1, x = y and x + y = 1.
    Planes,
    /// Integer points exactly on concentric spheres about the origin.
    Cospherical,
    /// Integer points on equal rings, exactly cocircular, stacked into a cylinder.
    Cylinder,
    /// [`PointKind::Grid`] from 1 on, each coordinate moved by −2 to 2 units in the last place.
    Ulps,
    /// Uniform points, each three times, in random order; the last may be there less often.
    Duplicates,
}

impl PointKind {
    /// Every kind.
    pub const ALL: [PointKind; 13] = [
        PointKind::Uniform,
        PointKind::Grid,
        PointKind::Bcc,
        PointKind::Sphere,
        PointKind::Shell,
        PointKind::Clusters,
        PointKind::Lines,
        PointKind::Moment,
        PointKind::Planes,
        PointKind::Cospherical,
        PointKind::Cylinder,
        PointKind::Ulps,
        PointKind::Duplicates,
    ];

    /// Its name, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            PointKind::Uniform => "uniform",
            PointKind::Grid => "grid",
            PointKind::Bcc => "bcc",
            PointKind::Sphere => "sphere",
            PointKind::Shell => "shell",
            PointKind::Clusters => "clusters",
            PointKind::Lines => "lines",
            PointKind::Moment => "moment",
            PointKind::Planes => "planes",
            PointKind::Cospherical => "cospherical",
            PointKind::Cylinder => "cylinder",
            PointKind::Ulps => "ulps",
            PointKind::Duplicates => "duplicates",
        }
    }

    /// The kind in a few words.
    pub fn about(self) -> &'static str {
        match self {
            PointKind::Uniform => "uniform in the unit cube",
            PointKind::Grid => "integer grid (the least cube of at least N points)",
            PointKind::Bcc => "body-centred integer grid (at least N points)",
            PointKind::Sphere => "on the unit sphere, rounded",
            PointKind::Shell => "in a thin shell, radius 0.99 to 1",
            PointKind::Clusters => "ten clusters of size 1 down to 1e-9",
            PointKind::Lines => "on two skew lines (about N*N/4 tetrahedra)",
            PointKind::Moment => "moment curve (about N*N/2 tetrahedra)",
            PointKind::Planes => "exactly on four planes",
            PointKind::Cospherical => "integer points exactly on concentric spheres",
            PointKind::Cylinder => "integer points on stacked rings, exactly cocircular",
            PointKind::Ulps => "integer grid moved by up to 2 ulps (at least N points)",
            PointKind::Duplicates => "uniform, each point three times",
        }
    }
}

impl std::fmt::Display for PointKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is no kind of point set.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a kind of point set")]
pub struct UnknownKind(pub String);

impl std::str::FromStr for PointKind {
    type Err = UnknownKind;

    fn from_str(name: &str) -> Result<Self, UnknownKind> {
        let kind = Self::ALL.into_iter().find(|k| k.name() == name);
        kind.ok_or_else(|| UnknownKind(name.to_owned()))
    }
}

/// Generates a point set of about `n` points (see [`PointKind`]), the same on every machine.
///
/// Cost: linear in `n`; [`PointKind::Cospherical`] takes about `n²/200,000` more steps.
pub fn generate(kind: PointKind, n: usize, seed: u64) -> Vec<Point> {
    let mut random = Random::new(seed);
    let r = &mut random;
    match kind {
        PointKind::Uniform => (0..n).map(|_| r.cube()).collect(),
        PointKind::Grid => grid(n, 1).map(|p| p.map(|c| c as f64)).collect(),
        PointKind::Bcc => grid(n, 2)
            .flat_map(|p| [p.map(|c| (2 * c) as f64), p.map(|c| (2 * c + 1) as f64)])
            .collect(),
        PointKind::Sphere => (0..n).map(|_| r.direction()).collect(),
        PointKind::Shell => (0..n)
            .map(|_| {
                let radius = 0.99 + 0.01 * r.unit();
                r.direction().map(|c| c * radius)
            })
            .collect(),
        PointKind::Clusters => clusters(n, r),
        PointKind::Lines => (0..n)
            .map(|i| if i % 2 == 0 { [r.unit(), 0.0, 0.0] } else { [0.5, r.unit(), 1.0] })
            .collect(),
        PointKind::Moment => (0..n).map(|i| i as f64).map(|t| [t, t * t, t * t * t]).collect(),
        PointKind::Planes => (0..n).map(|i| on_plane(i, r)).collect(),
        PointKind::Cospherical => cospherical(n, r),
        PointKind::Cylinder => cylinder(n),
        PointKind::Ulps => grid(n, 1)
            .map(|p| {
                p.map(|c| {
                    let bits = ((c + 1) as f64).to_bits();
                    // Coordinates are 1 at least: two ulps keep sign and exponent range.
                    f64::from_bits(bits + r.below(5) - 2)
                })
            })
            .collect(),
        PointKind::Duplicates => {
            let mut points: Vec<Point> =
                (0..n.div_ceil(3)).map(|_| r.cube()).flat_map(|p| [p; 3]).take(n).collect();
            r.shuffle(&mut points);
            points
        }
    }
}

/// The integer points of the least cube that holds `n / layers` of them.
fn grid(n: usize, layers: u64) -> impl Iterator<Item = [u64; 3]> {
    let wanted = (n as u64).div_ceil(layers);
    // At most 2^21 turns: a cube of 2^63 points fits no memory.
    let k = (0..=1_u64 << 21).find(|k| k.pow(3) >= wanted).unwrap_or(1 << 21);
    (0..k).flat_map(move |x| (0..k).flat_map(move |y| (0..k).map(move |z| [x, y, z])))
}

fn clusters(n: usize, r: &mut Random) -> Vec<Point> {
    const SIZES: [f64; 10] = [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];
    let centres = SIZES.map(|_| r.cube());
    (0..n)
        .map(|i| {
            let (centre, size) = (centres[i % 10], SIZES[i % 10]);
            let offset = r.cube();
            [0, 1, 2].map(|k| centre[k] + size * (offset[k] - 0.5))
        })
        .collect()
}

/// A point exactly on the plane `i mod 4`: 1 − u is exact for a multiple of 2^-53 below 1.
fn on_plane(i: usize, r: &mut Random) -> Point {
    let (u, v) = (r.unit(), r.unit());
    match i % 4 {
        0 => [u, v, 0.0],
        1 => [u, v, 1.0],
        2 => [u, u, v],
        _ => [u, 1.0 - u, v],
    }
}

/// Integer points on up to 64 spheres of consecutive squared radii.
///
/// About 2πR integer points lie on a sphere of radius R, so the radius follows from the number
/// wanted; squared radii that are no sum of three squares stay empty, so the last sphere moves
/// outwards until there are enough.
fn cospherical(n: usize, r: &mut Random) -> Vec<Point> {
    let spheres = (n as u64 / 100).clamp(1, 64);
    let radius = (n as u64 / (6 * spheres)).max(3);
    let least = radius * radius;
    let mut points: Vec<Point> = Vec::with_capacity(n + n / 4);
    let (mut from, mut width) = (least, spheres);
    // Every turn moves outwards, and of any few squared radii in a row at least one is a sum of
    // three squares, so every few turns add points.
    while points.len() < n {
        shell_points(from, from + width, &mut points);
        from += width;
        width = spheres.div_ceil(4);
    }
    r.shuffle(&mut points);
    points.truncate(n);
    points
}

/// Appends the integer points with `from ≤ x² + y² + z² < to`.
fn shell_points(from: u64, to: u64, points: &mut Vec<Point>) {
    let reach = (to - 1).isqrt();
    for x in 0..=reach {
        for y in 0..=(to - 1 - x * x).isqrt() {
            let flat = x * x + y * y;
            let mut z = from.saturating_sub(flat).isqrt();
            if flat + z * z < from {
                z += 1;
            }
            while flat + z * z < to {
                mirror([x as f64, y as f64, z as f64], points);
                z += 1;
            }
        }
    }
}

/// Appends `p`, which has no negative coordinate, and its mirror images.
fn mirror(p: Point, points: &mut Vec<Point>) {
    let signs = |c: f64| if c == 0.0 { &[1.0][..] } else { &[1.0, -1.0][..] };
    for sx in signs(p[0]) {
        for sy in signs(p[1]) {
            points.extend(signs(p[2]).iter().map(|sz| [sx * p[0], sy * p[1], sz * p[2]]));
        }
    }
}

/// Rings of integer points with x² + y² = m, for an m that is a sum of two squares in many ways:
/// 65 (16 points), 5·13·17·29 (64 points) or its square (324 points).
fn cylinder(n: usize) -> Vec<Point> {
    let m: u64 = match n {
        0..200 => 65,
        200..5000 => 32_045,
        _ => 32_045 * 32_045,
    };
    let mut ring = Vec::new();
    for x in 0..=m.isqrt() {
        let y = (m - x * x).isqrt();
        if x * x + y * y == m {
            let mut images = Vec::with_capacity(8);
            mirror([x as f64, y as f64, 0.0], &mut images);
            ring.extend(images);
        }
    }
    // Rings as far apart as the mean distance of neighbours on a ring.
    let step = 1 + (6 * m.isqrt()) / ring.len() as u64;
    (0_u64..)
        .flat_map(|k| ring.iter().map(move |p| [p[0], p[1], (k * step) as f64]))
        .take(n)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn bits(p: &Point) -> [u64; 3] {
        p.map(f64::to_bits)
    }

    fn distinct(points: &[Point]) -> usize {
        points.iter().map(bits).collect::<HashSet<_>>().len()
    }

    #[test]
    fn sizes_finiteness_and_determinism() {
        for kind in PointKind::ALL {
            for n in [0, 1, 4, 60, 1000] {
                let points = generate(kind, n, 7);
                assert_eq!(points, generate(kind, n, 7), "{kind} {n}");
                assert!(points.iter().flatten().all(|c| c.is_finite()), "{kind} {n}");
                match kind {
                    PointKind::Grid | PointKind::Bcc | PointKind::Ulps => {
                        assert!(points.len() >= n, "{kind} {n}");
                    }
                    _ => assert_eq!(points.len(), n, "{kind} {n}"),
                }
                match kind {
                    PointKind::Duplicates => assert_eq!(distinct(&points), n.div_ceil(3)),
                    _ => assert_eq!(distinct(&points), points.len(), "{kind} {n}"),
                }
            }
            assert_eq!(kind.name().parse(), Ok(kind));
        }
        assert_ne!(generate(PointKind::Uniform, 9, 1), generate(PointKind::Uniform, 9, 2));
    }

    #[test]
    fn cospherical_and_cocircular_sets_are_exactly_so() {
        for n in [60, 1000, 20_000] {
            let squares: HashSet<i64> = generate(PointKind::Cospherical, n, 1)
                .iter()
                .map(|p| p.iter().map(|&c| (c as i64).pow(2)).sum())
                .collect();
            assert!(squares.len() <= 130, "{n}: {} spheres", squares.len());
        }
        for n in [60, 1000, 6000] {
            let squares: HashSet<i64> = generate(PointKind::Cylinder, n, 1)
                .iter()
                .map(|p| (p[0] as i64).pow(2) + (p[1] as i64).pow(2))
                .collect();
            assert_eq!(squares.len(), 1);
        }
    }

    /// Point sets are golden: a change of any coordinate is a breaking change.
    #[test]
    fn golden() {
        let fold = |kind| {
            generate(kind, 1000, 42).iter().flatten().fold(0_u64, |h, c| {
                (h ^ c.to_bits()).wrapping_mul(0x0000_0100_0000_01B3).rotate_left(29)
            })
        };
        let got: Vec<(PointKind, u64)> = PointKind::ALL.into_iter().map(|k| (k, fold(k))).collect();
        assert_eq!(got, GOLDEN);
    }

    const GOLDEN: [(PointKind, u64); 13] = [
        (PointKind::Uniform, 0x241c_5b78_8870_c1e9),
        (PointKind::Grid, 0x0996_2028_ce32_2e32),
        (PointKind::Bcc, 0x5eae_72a8_c09a_07e0),
        (PointKind::Sphere, 0x2a3b_f015_7256_5392),
        (PointKind::Shell, 0x5ecf_aaee_67c6_2848),
        (PointKind::Clusters, 0xe94b_513a_ade0_b18e),
        (PointKind::Lines, 0xae88_13bc_d8d5_3da0),
        (PointKind::Moment, 0x677d_f428_9787_3ee5),
        (PointKind::Planes, 0x182d_4233_0b16_067a),
        (PointKind::Cospherical, 0x5738_336e_2892_2007),
        (PointKind::Cylinder, 0x8f16_a7bf_8396_d0b5),
        (PointKind::Ulps, 0x4da9_521d_edd4_6f3d),
        (PointKind::Duplicates, 0x5bf6_cac8_adc1_8350),
    ];
}

/// Examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
