//! Every filter against the exact value of its expression, on both sides of its bound.
//!
//! A filter must tell the sign of a value beyond twice its bound, for its error is at most the
//! bound, and must not tell that of a value below half of it, for its error is much less in
//! practice. So a bound that is too low or too high by more than that is noticed, and so is any
//! change of the expression. Exact values are those of [`super::references`].

use num_bigint::{BigInt, Sign as BigSign};
use num_traits::{Signed, ToPrimitive, Zero};

use super::references::{self as exact, Place};
use crate::Point;
use crate::predicates::filter::{self, power_of_two};
use crate::predicates::{PLANES, Sign};

/// Bits of a coordinate: differences have one more and are exact.
const BITS: u32 = 51;
/// The bounds are in sixteenths of u: 2^-57.
const BOUND_BITS: u32 = 57;
/// The parameters of `exceeds_radius_edge` and `below_dihedral` are integers over this.
const RATIO_UNIT: u32 = 256;

/// A filter and what is known about it. Its parameter, if it has one, comes as an integer.
struct Filter {
    name: &'static str,
    /// The number of points that it takes.
    points: usize,
    /// The filter, of points in units of the last argument, a power of two.
    decide: fn(&[Point], f64, f64) -> Option<Sign>,
    value: fn(&[Place], &BigInt) -> BigInt,
    /// The pairs of points whose differences it computes.
    pairs: &'static [(usize, usize)],
    /// The bound in sixteenths of u, from the extents in the axes and the largest of them.
    bound: fn(&Place, &BigInt, &BigInt) -> BigInt,
    parameter: Parameter,
    /// Units of the points, as exponents of two, with which all extents are within the guard.
    units: [i32; 3],
}

#[derive(Clone, Copy)]
enum Parameter {
    No,
    Ratio,
    Volume,
    Cosine,
}

/// Units for the guards from 2^-190 to 2^200, and for those from 2^-100 to 2^100.
const WIDE: [i32; 3] = [-150, -20, 120];
const NARROW: [i32; 3] = [-100, -48, 30];

const TO_C: &[(usize, usize)] = &[(0, 2), (1, 2)];
const TO_D: &[(usize, usize)] = &[(0, 3), (1, 3), (2, 3)];
const TO_E: &[(usize, usize)] = &[(0, 4), (1, 4), (2, 4), (3, 4)];
const EQUATORIAL: &[(usize, usize)] = &[(0, 1), (0, 2), (1, 2), (0, 3)];
const FROM_A: &[(usize, usize)] = &[(0, 1), (0, 2), (0, 3)];
const EDGES: &[(usize, usize)] = &[(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];

/// All filters; those of projections once for each plane.
fn all() -> Vec<Filter> {
    let mut all = Vec::from(in_space());
    all.extend([orient2d::<0>(), orient2d::<1>(), orient2d::<2>()]);
    all.extend([incircle::<0>(), incircle::<1>(), incircle::<2>()]);
    all.extend(of_refinement());
    all
}

fn in_space() -> [Filter; 4] {
    let orient3d = Filter {
        name: "orient3d_any",
        points: 4,
        decide: |p, _, _| filter::orient3d_any(&p[0], &p[1], &p[2], &p[3]),
        value: |p, _| exact::orient3d(p),
        pairs: TO_D,
        bound: |[x, y, z], _, _| 737 * x * y * z,
        parameter: Parameter::No,
        units: WIDE,
    };
    let insphere = Filter {
        name: "insphere_any",
        points: 5,
        decide: |p, _, _| filter::insphere_any(&p[0], &p[1], &p[2], &p[3], &p[4]),
        value: |p, _| exact::insphere(p),
        pairs: TO_E,
        bound: |[x, y, z], m, _| 17_665 * x * y * z * m * m,
        ..orient3d
    };
    let orient3d_window = Filter {
        name: "orient3d_window",
        decide: |p, _, _| filter::orient3d_window(&p[0], &p[1], &p[2], &p[3]),
        ..orient3d
    };
    let insphere_window = Filter {
        name: "insphere_window",
        decide: |p, _, _| filter::insphere_window(&p[0], &p[1], &p[2], &p[3], &p[4]),
        ..insphere
    };
    [orient3d, insphere, orient3d_window, insphere_window]
}

fn orient2d<const PLANE: usize>() -> Filter {
    Filter {
        name: ["orient2d_any xy", "orient2d_any yz", "orient2d_any xz"][PLANE],
        points: 3,
        decide: |p, _, _| filter::orient2d_any(&p[0], &p[1], &p[2], PLANES[PLANE]),
        value: |p, _| exact::orient2d(p, PLANES[PLANE]),
        pairs: TO_C,
        bound: |e, _, _| 129 * &e[PLANES[PLANE][0]] * &e[PLANES[PLANE][1]],
        parameter: Parameter::No,
        units: WIDE,
    }
}

fn incircle<const PLANE: usize>() -> Filter {
    Filter {
        name: ["incircle_any xy", "incircle_any yz", "incircle_any xz"][PLANE],
        points: 4,
        decide: |p, _, _| filter::incircle_any(&p[0], &p[1], &p[2], &p[3], PLANES[PLANE]),
        value: |p, _| exact::incircle(p, PLANES[PLANE]),
        pairs: TO_D,
        bound: |e, m, _| 3265 * &e[PLANES[PLANE][0]] * &e[PLANES[PLANE][1]] * m * m,
        parameter: Parameter::No,
        units: WIDE,
    }
}

fn of_refinement() -> [Filter; 5] {
    let diametral = Filter {
        name: "in_diametral_ball_any",
        points: 3,
        decide: |p, _, _| filter::in_diametral_ball_any(&p[0], &p[1], &p[2]),
        value: |p, _| exact::diametral(p),
        pairs: TO_C,
        bound: |_, m, _| 225 * m * m,
        parameter: Parameter::No,
        units: WIDE,
    };
    let equatorial = Filter {
        name: "in_equatorial_ball_any",
        points: 4,
        decide: |p, _, _| filter::in_equatorial_ball_any(&p[0], &p[1], &p[2], &p[3]),
        value: |p, _| exact::equatorial(p),
        pairs: EQUATORIAL,
        bound: |_, m, _| 25_681 * m.pow(6),
        parameter: Parameter::No,
        units: NARROW,
    };
    let radius_edge = Filter {
        name: "exceeds_radius_edge_any",
        points: 4,
        decide: |p, ratio, _| {
            let ratio = ratio / f64::from(RATIO_UNIT);
            filter::exceeds_radius_edge_any(&p[0], &p[1], &p[2], &p[3], ratio)
        },
        value: |p, ratio| exact::radius_edge(p, ratio, RATIO_UNIT),
        pairs: EDGES,
        bound: |_, m, ratio| {
            (409_537 * BigInt::from(RATIO_UNIT).pow(2) + 186_625 * ratio * ratio) * m.pow(8)
        },
        parameter: Parameter::Ratio,
        units: NARROW,
    };
    let volume = Filter {
        name: "exceeds_volume_any",
        points: 4,
        decide: |p, volume, unit| {
            let volume = volume * unit * unit * unit;
            filter::exceeds_volume_any(&p[0], &p[1], &p[2], &p[3], volume)
        },
        value: |p, volume| exact::volume(p, volume),
        pairs: TO_D,
        bound: |[x, y, z], _, volume| 833 * x * y * z + 193 * volume,
        parameter: Parameter::Volume,
        units: WIDE,
    };
    [diametral, equatorial, radius_edge, volume, dihedral()]
}

fn dihedral() -> Filter {
    Filter {
        name: "below_dihedral_any",
        points: 4,
        decide: |p, cosine, _| {
            let cos2 = cosine / f64::from(RATIO_UNIT);
            filter::below_dihedral_any(&p[0], &p[1], &p[2], &p[3], cos2)
        },
        value: |p, cosine| exact::below_dihedral(p, cosine, RATIO_UNIT),
        pairs: FROM_A,
        bound: |_, m, cosine| (53_761 * BigInt::from(RATIO_UNIT) + 56_065 * cosine) * m.pow(8),
        parameter: Parameter::Cosine,
        units: NARROW,
    }
}

/// Numbers that look random, always the same ones.
struct Draw(u64);

impl Draw {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 3) % bound
    }

    /// A coordinate in an axis: those of z may be as much less as `flat` says.
    fn coordinate(&mut self, axis: usize, flat: u32) -> i64 {
        (self.below(2 << BITS) as i64 - (1 << BITS)) >> if axis == 2 { flat } else { 0 }
    }

    fn parameter(&mut self, kind: Parameter, points: &[[i64; 3]], flat: u32) -> BigInt {
        match kind {
            Parameter::No => BigInt::zero(),
            // From ½ to 3, or to 200 if tetrahedra are flat.
            Parameter::Ratio => BigInt::from((128 + self.below(640)) << flat),
            // Angles between 3 and 87 degrees.
            Parameter::Cosine => BigInt::from(1 + self.below(255)),
            // About a third of the tetrahedron's, as far as an `f64` can tell it.
            Parameter::Volume => {
                let third: BigInt = exact::orient3d(&places(points)).abs() / 18;
                let excess = third.bits().saturating_sub(50);
                ((third >> excess) + 1) << excess
            }
        }
    }
}

fn places(points: &[[i64; 3]]) -> Vec<Place> {
    points.iter().map(|p| p.map(BigInt::from)).collect()
}

fn sign(value: &BigInt) -> Sign {
    match value.sign() {
        BigSign::Minus => Sign::Negative,
        BigSign::NoSign => Sign::Zero,
        BigSign::Plus => Sign::Positive,
    }
}

/// Points with a parameter, of which one coordinate will be moved.
struct Probe<'a> {
    filter: &'a Filter,
    points: Vec<[i64; 3]>,
    parameter: BigInt,
    mover: (usize, usize),
}

impl Probe<'_> {
    fn places(&self, at: i64) -> Vec<Place> {
        let mut points = self.points.clone();
        points[self.mover.0][self.mover.1] = at;
        places(&points)
    }

    fn value(&self, at: i64) -> BigInt {
        (self.filter.value)(&self.places(at), &self.parameter)
    }

    /// Neighbours between which the value changes its sign, or turns zero, if there are such
    /// between `low` and `high`.
    fn change(&self, mut low: i64, mut high: i64) -> Option<i64> {
        let first = sign(&self.value(low));
        if first.is_zero() || sign(&self.value(high)) != -first {
            return None;
        }
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if sign(&self.value(middle)) == first { low = middle } else { high = middle }
        }
        Some(high)
    }

    /// Compares filter and value at `at`; returns -1 if the value is below half of the bound, 1 if
    /// it is beyond twice the bound, else 0.
    fn check(&self, at: i64) -> i32 {
        let Filter { name, decide, bound, pairs, units, .. } = self.filter;
        let places = self.places(at);
        let value = self.value(at);
        let extents = exact::extents(&places, pairs);
        let largest = extents.iter().max().expect("three extents");
        let bound = bound(&extents, largest, &self.parameter);
        let scaled = value.abs() << BOUND_BITS;
        let beyond = i32::from(scaled > 2 * &bound) - i32::from(2 * &scaled < bound);
        for unit in units {
            let unit = power_of_two(*unit);
            let point =
                |p: &Place| -> Point { p.each_ref().map(|c| c.to_f64().unwrap_or(0.0) * unit) };
            let points: Vec<Point> = places.iter().map(point).collect();
            let found = decide(&points, self.parameter.to_f64().unwrap_or(0.0), unit);
            let case = || format!("{name}: {points:?} {} {value} {bound}", self.parameter);
            if let Some(found) = found {
                assert_eq!(found, sign(&value), "{}", case());
            }
            assert!(beyond < 1 || found.is_some(), "not decided: {}", case());
            assert!(beyond > -1 || found.is_none(), "decided: {}", case());
        }
        beyond
    }
}

#[test]
fn filters_decide_beyond_their_bounds_and_not_below() {
    let mut draw = Draw(0x9e37_79b9_7f4a_7c15);
    for filter in &all() {
        // The number of each sort, and of changes of sign.
        let mut counts = [0; 4];
        for round in 0..400 {
            let flat = [0, 6][round % 2];
            let points: Vec<[i64; 3]> = (0..filter.points)
                .map(|_| [0, 1, 2].map(|axis| draw.coordinate(axis, flat)))
                .collect();
            let parameter = draw.parameter(filter.parameter, &points, flat);
            let mover = (round % filter.points, round / filter.points % 3);
            let [low, high] = [0; 2].map(|_| draw.coordinate(mover.1, flat));
            let probe = Probe { filter, points, parameter, mover };
            let Some(change) = probe.change(low.min(high), low.max(high)) else {
                continue;
            };
            counts[3] += 1;
            for step in (0..40).map(|k| 1_i64 << k).chain([0]) {
                for at in [change - step, change + step] {
                    counts[(probe.check(at) + 1) as usize] += 1;
                }
            }
            if counts[3] == 16 {
                break;
            }
        }
        println!("{}: {counts:?}", filter.name);
        assert!(counts.iter().all(|&count| count >= 10), "{}: {counts:?}", filter.name);
    }
}

const O: Point = [0.0; 3];
const X: Point = [1.0, 0.0, 0.0];
const Y: Point = [0.0, 1.0, 0.0];
const Z: Point = [0.0, 0.0, 1.0];
const CORNER: [Point; 4] = [O, X, Y, Z];
const AROUND: [Point; 5] = [X, Y, Z, [-1.0; 3], O];

/// The points with their coordinates in some axes times a factor.
fn stretched<const N: usize>(points: [Point; N], axes: &[usize], factor: f64) -> [Point; N] {
    points.map(|mut p| {
        axes.iter().for_each(|&k| p[k] *= factor);
        p
    })
}

/// Checks that `decided` is true of numbers strictly between two powers of two alone.
fn between(low: i32, high: i32, decided: impl Fn(f64) -> bool) {
    let [low, high] = [low, high].map(power_of_two);
    for (value, expected) in [
        (low.next_down(), false),
        (low, false),
        (low.next_up(), true),
        (1.0, true),
        (high.next_down(), true),
        (high, false),
        (high.next_up(), false),
    ] {
        assert_eq!(decided(value), expected, "{value:e}");
    }
}

/// The limit adds much less to the bound of a volume than the rest does: seen where the arithmetic
/// is exact.
#[test]
fn the_bound_of_a_volume_grows_with_the_limit() {
    let [p, q, r] = [131_072.0, 131_072.0, 131_074.0];
    let corners = [O, [p, 0.0, 0.0], [0.0, q, 0.0], [0.0, 0.0, r]];
    let [a, b, c, d] = corners;
    // In units of u p q r, nearly a quarter, the bound is 52 and 1/16 and a sixth of 12.
    let limit = |excess: f64| (p * q * r - excess) / 6.0;
    assert_eq!(6.0 * limit(13.0), p * q * r - 13.0, "exact");
    assert_eq!(filter::exceeds_volume_any(&a, &b, &c, &d, limit(13.0)), None);
    assert_eq!(6.0 * limit(16.0), p * q * r - 16.0, "exact");
    assert_eq!(filter::exceeds_volume_any(&a, &b, &c, &d, limit(16.0)), Some(Sign::Positive));
}

#[test]
fn guards_begin_and_end_where_they_are_proved() {
    for axis in [0, 1, 2] {
        between(-190, 200, |size| {
            let [a, b, c, d] = stretched(CORNER, &[axis], size);
            filter::orient3d_any(&a, &b, &c, &d).is_some()
        });
        between(-190, 200, |size| {
            let [a, b, c, d, e] = stretched(AROUND, &[axis], size);
            filter::insphere_any(&a, &b, &c, &d, &e).is_some()
        });
        between(-190, 200, |size| {
            let [a, b, c, d] = stretched(CORNER, &[axis], size);
            filter::exceeds_volume_any(&a, &b, &c, &d, 0.1 * size).is_some()
        });
    }
    for plane @ [i, j] in PLANES {
        let at = |x: f64, y: f64| {
            let mut p = O;
            (p[i], p[j]) = (x, y);
            p
        };
        let points = [at(1.0, 0.0), at(0.0, 1.0), at(-1.0, -1.0), O];
        for axis in plane {
            between(-190, 200, |size| {
                let [a, b, _, d] = stretched(points, &[axis], size);
                filter::orient2d_any(&a, &b, &d, plane).is_some()
            });
            between(-190, 200, |size| {
                let [a, b, c, d] = stretched(points, &[axis], size);
                filter::incircle_any(&a, &b, &c, &d, plane).is_some()
            });
        }
        // The axis that is projected away counts only for the lift.
        let high = power_of_two(200);
        for (size, decided) in [(0.0, true), (high.next_down(), true), (high, false)] {
            let [mut a, b, c, d] = points;
            a[3 - i - j] = size;
            let found = filter::incircle_any(&a, &b, &c, &d, plane);
            assert_eq!(found.is_some(), decided, "{plane:?} {size:e}");
        }
    }
}

#[test]
fn guards_of_refinement_begin_and_end_where_they_are_proved() {
    let all = [0, 1, 2];
    between(-190, 200, |size| {
        let [a, b, p] = stretched([X, X.map(|c| -c), O], &all, size);
        filter::in_diametral_ball_any(&a, &b, &p).is_some()
    });
    between(-100, 100, |size| {
        let [a, b, c, p] = stretched([O, X, Y, [0.5, 0.5, 0.25]], &all, size);
        filter::in_equatorial_ball_any(&a, &b, &c, &p).is_some()
    });
    between(-100, 100, |size| {
        let [a, b, c, d] = stretched(CORNER, &all, size);
        filter::exceeds_radius_edge_any(&a, &b, &c, &d, 0.5).is_some()
    });
    between(-20, 20, |ratio| filter::exceeds_radius_edge_any(&O, &X, &Y, &Z, ratio).is_some());
    between(-100, 100, |size| {
        let [a, b, c, d] = stretched(CORNER, &all, size);
        filter::below_dihedral_any(&a, &b, &c, &d, 0.5).is_some()
    });
    between(-20, 20, |cos2| filter::below_dihedral_any(&Y, &Z, &O, &X, cos2).is_some());
    between(-600, 600, |volume| filter::exceeds_volume_any(&O, &X, &Y, &Z, volume).is_some());
}

#[test]
fn no_extent_in_one_axis_means_zero_at_any_size() {
    for exponent in [-1000, 0, 300] {
        let size = power_of_two(exponent);
        for axis in [0, 1, 2] {
            let flat = stretched(AROUND.map(|p| p.map(|c| c * size)), &[axis], 0.0);
            let [a, b, c, d, e] = flat;
            assert_eq!(filter::orient3d_any(&a, &b, &c, &d), Some(Sign::Zero));
            assert_eq!(filter::insphere_any(&a, &b, &c, &d, &e), Some(Sign::Zero));
            assert_eq!(filter::exceeds_volume_any(&a, &b, &c, &d, 1.0), None);
            for plane in PLANES.into_iter().filter(|plane| plane.contains(&axis)) {
                assert_eq!(filter::orient2d_any(&a, &b, &d, plane), Some(Sign::Zero));
                assert_eq!(filter::incircle_any(&a, &b, &c, &d, plane), Some(Sign::Zero));
            }
        }
    }
}
