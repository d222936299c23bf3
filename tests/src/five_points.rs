//! Five points at a time: the families on which predicates are compared with their oracles, and
//! the comparison.
//!
//! Every family is a function of its seed, on every machine. Those of [`WINDOW`] stay inside the
//! exactness window for every factor of [`FACTORS`]; those of [`WIDE`] go to the ends of `f64`.

use crate::families::{Rng, mixed_exponents, random_bits, spheres, two_to};
use crate::oracle::{Exact, exact};
use ltbw::predicates::distance::cmp_distance;
use ltbw::predicates::{coplanar_orient, insphere, orient3d, perturb, side_of_bounded_circle};
use ltbw::{Point, Sign};
use std::sync::OnceLock;

/// Draws five points of one family.
pub type Draw = fn(&mut Rng) -> [Point; 5];

/// Families inside the exactness window: 0 or 2^-142 <= |c| < 2^200.
pub const WINDOW: &[(&str, Draw)] = &[
    ("uniform", uniform),
    ("coplanar", coplanar),
    ("coplanar +- ulps", |rng| jitter(rng, coplanar)),
    ("cospherical", cospherical),
    ("cospherical +- ulps", |rng| jitter(rng, cospherical)),
    ("small integers", small_integers),
    ("small integers +- ulps", |rng| jitter(rng, small_integers)),
    ("offset", offset),
    ("offset +- ulps", |rng| jitter(rng, offset)),
    ("clusters", clusters),
    ("mixed exponents", mixed),
];

/// Exponents of the factors that keep [`WINDOW`] inside the window.
pub const FACTORS: [i32; 5] = [0, -80, 80, 160, -30];

/// Families outside the window.
pub const WIDE: &[(&str, Draw)] = &[
    ("small integers * 2^-1074", |rng| subnormal(rng, small_integers)),
    ("cospherical * 2^-1074", |rng| subnormal(rng, cospherical)),
    ("cospherical * 2^-600", |rng| times(rng, cospherical, -600)),
    ("cospherical +- ulps * 2^-360", |rng| times(rng, |r| jitter(r, cospherical), -360)),
    ("coplanar +- ulps * 2^900", |rng| times(rng, |r| jitter(r, coplanar), 900)),
    ("uniform * 2^1023", |rng| times(rng, uniform, 1023)),
    ("two scales", two_scales),
    ("exponents +-1000", |rng| wide(rng, |seed| mixed_exponents(5, 1000, seed))),
    ("random bits", |rng| wide(rng, |seed| random_bits(5, seed))),
];

fn five(mut draw: impl FnMut() -> Point) -> [Point; 5] {
    std::array::from_fn(|_| draw())
}

fn uniform(rng: &mut Rng) -> [Point; 5] {
    five(|| std::array::from_fn(|_| 2.0 * rng.unit() - 1.0))
}

/// Lattice points of one random plane: a + i u + j v in integers.
fn coplanar(rng: &mut Rng) -> [Point; 5] {
    let mut small = |n: u64| rng.below(2 * n + 1) as f64 - n as f64;
    let [a, u, v] = std::array::from_fn(|_| [small(5), small(5), small(5)]);
    five(|| {
        let (i, j) = (small(3), small(3));
        std::array::from_fn(|k| a[k] + i * u[k] + j * v[k])
    })
}

/// Integer points of one sphere, moved by an integer vector.
fn cospherical(rng: &mut Rng) -> [Point; 5] {
    static SPHERES: OnceLock<[Vec<Point>; 4]> = OnceLock::new();
    let spheres = SPHERES.get_or_init(|| [3, 9, 41, 101].map(|square| spheres(&[square])));
    let sphere = &spheres[rng.below(4) as usize];
    let move_by: Point = std::array::from_fn(|_| rng.below(1000) as f64);
    five(|| {
        let p = sphere[rng.below(sphere.len() as u64) as usize];
        std::array::from_fn(|k| p[k] + move_by[k])
    })
}

fn small_integers(rng: &mut Rng) -> [Point; 5] {
    five(|| std::array::from_fn(|_| rng.below(4) as f64))
}

/// Small integers far from the origin: differences are exact, coordinates are not small.
fn offset(rng: &mut Rng) -> [Point; 5] {
    let far: Point = std::array::from_fn(|_| two_to(rng.below(50) as i32));
    five(|| std::array::from_fn(|k| far[k] + rng.below(4) as f64))
}

fn clusters(rng: &mut Rng) -> [Point; 5] {
    let [centre, ..] = uniform(rng);
    five(|| {
        let scale = two_to(-(rng.below(40) as i32));
        std::array::from_fn(|k| centre[k] + scale * (rng.unit() - 0.5))
    })
}

/// Coordinates of the window's own spread: 2^-60 to 2^38 here, times the factors.
fn mixed(rng: &mut Rng) -> [Point; 5] {
    five(|| std::array::from_fn(|_| (1.0 + rng.unit()) * two_to(rng.below(98) as i32 - 60)))
}

/// Moves some coordinates that are not zero by an ulp.
fn jitter(rng: &mut Rng, draw: Draw) -> [Point; 5] {
    let mut points = draw(rng);
    for c in points.iter_mut().flatten().filter(|c| **c != 0.0) {
        match rng.below(6) {
            0 => *c = c.next_up(),
            1 => *c = c.next_down(),
            _ => {}
        }
    }
    points
}

fn times(rng: &mut Rng, draw: Draw, exponent: i32) -> [Point; 5] {
    draw(rng).map(|p| p.map(|c| c * two_to(exponent)))
}

/// Integers in steps of the smallest subnormal number.
fn subnormal(rng: &mut Rng, draw: Draw) -> [Point; 5] {
    draw(rng).map(|p| p.map(|c| c * f64::from_bits(1)))
}

/// Degenerate points of a huge and of a tiny scale together.
fn two_scales(rng: &mut Rng) -> [Point; 5] {
    let (large, small) = (times(rng, cospherical, 600), subnormal(rng, small_integers));
    std::array::from_fn(|i| if rng.below(2) == 0 { large[i] } else { small[i] })
}

fn wide(rng: &mut Rng, points: impl Fn(u64) -> Vec<Point>) -> [Point; 5] {
    points(rng.bits()).try_into().unwrap_or([[0.0; 3]; 5])
}

/// Names of the predicates that [`each_predicate`] calls, by number.
pub const PREDICATES: [&str; 8] = [
    "orient3d",
    "insphere",
    "coplanar_orient",
    "side_of_bounded_circle",
    "side_of_sphere",
    "side_of_circle",
    "side_of_hull_facet",
    "cmp_distance",
];

/// Calls every predicate whose conditions the points fulfil in their order, and the oracle on the
/// same points as integers (`scaled`): `see` gets the number of the predicate, our sign and
/// `rug`'s.
///
/// # Panics
/// If the oracle's perturbed sign is zero.
pub fn each_predicate(
    points: &[Point; 5],
    scaled: &[&Exact; 5],
    mut see: impl FnMut(usize, Sign, Sign),
) {
    let [a, b, c, d, e] = points;
    let &[xa, xb, xc, xd, xe] = scaled;
    let volume = exact::orient3d(xa, xb, xc, xd);
    see(0, orient3d(a, b, c, d), volume);
    see(1, insphere(a, b, c, d, e), exact::insphere(xa, xb, xc, xd, xe));
    let turn = exact::coplanar_orient(xa, xb, xc);
    see(2, coplanar_orient(a, b, c), turn);
    let near = Sign::from_ordering(exact::cmp_distance(xe, xa, xb));
    see(7, Sign::from_ordering(cmp_distance(e, a, b)), near);
    let coplanar = turn != Sign::Zero && volume == Sign::Zero;
    if coplanar {
        let side = exact::side_of_bounded_circle(xa, xb, xc, xd);
        see(3, side_of_bounded_circle(a, b, c, d), side);
    }
    let distinct = (0..5).all(|i| (0..i).all(|j| scaled[i] != scaled[j]));
    if distinct && turn != Sign::Zero {
        let side = exact::side_of_hull_facet([xa, xb, xc], xd);
        see(6, perturb::side_of_hull_facet(a, b, c, d), side);
        if coplanar {
            let side = exact::side_of_circle([xa, xb, xc], xd);
            assert_ne!(side, Sign::Zero, "the oracle's circle: {points:?}");
            see(5, perturb::side_of_circle(a, b, c, d), side);
        }
    }
    if distinct && volume == Sign::Positive {
        let side = exact::side_of_sphere([xa, xb, xc, xd], xe);
        assert_ne!(side, Sign::Zero, "the oracle's sphere: {points:?}");
        see(4, perturb::side_of_sphere(a, b, c, d, e), side);
    }
}
