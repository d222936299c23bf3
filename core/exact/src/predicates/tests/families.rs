//! The input families of the tests: where predicates go wrong.

use proptest::prelude::*;
use proptest::sample::select;

use crate::Point;

/// The points of a case: five, any order, not necessarily distinct.
pub(crate) type Five = [Point; 5];

/// 2^exponent for any exponent of an `f64`, subnormal ones included.
pub(crate) fn two_to(exponent: i32) -> f64 {
    let half = exponent / 2;
    2.0_f64.powi(half) * 2.0_f64.powi(exponent - half)
}

fn points(coordinate: impl Strategy<Value = f64> + Clone) -> impl Strategy<Value = Five> {
    let point = [coordinate.clone(), coordinate.clone(), coordinate];
    [point.clone(), point.clone(), point.clone(), point.clone(), point]
}

/// Uniform in the cube.
pub(crate) fn uniform() -> impl Strategy<Value = Five> {
    points(-1.0..1.0)
}

/// Few different integers: everything degenerate happens, equal points too.
pub(crate) fn small_integers() -> impl Strategy<Value = Five> {
    select(vec![1, 2, 3, 10, 1000, 1 << 20]).prop_flat_map(|n| points((-n..=n).prop_map(f64::from)))
}

/// A vector of the lattice of `bits` bits, or of a multiple of it: many repeated coordinates.
fn lattice_point(bits: u32) -> impl Strategy<Value = Point> + Clone {
    let n = 1_i64 << bits;
    [-n..=n, -n..=n, -n..=n].prop_map(|p| p.map(|c| c as f64))
}

/// Five integer points of one plane: a + s·u + t·v with small s and t, shifted away from zero.
pub(crate) fn coplanar() -> impl Strategy<Value = Five> {
    let parameters = [-4..=4_i32, -4..=4, -4..=4, -4..=4, -4..=4, -4..=4, -4..=4, -4..=4];
    (1..20_u32, parameters, 0..30_u32)
        .prop_flat_map(|(bits, st, shift)| {
            let vectors = [lattice_point(bits), lattice_point(bits), lattice_point(bits)];
            (vectors, Just(st), Just(shift))
        })
        .prop_map(|([a, u, v], st, shift)| {
            let offset = two_to(shift as i32);
            let at = |s: i32, t: i32| -> Point {
                std::array::from_fn(|k| offset + a[k] + f64::from(s) * u[k] + f64::from(t) * v[k])
            };
            [at(0, 0), at(st[0], st[1]), at(st[2], st[3]), at(st[4], st[5]), at(st[6], st[7])]
        })
}

/// Five integer points exactly on one sphere: permutations and reflections of one vector.
pub(crate) fn cospherical() -> impl Strategy<Value = Five> {
    cospherical_of_bits(1..26)
}

/// [`cospherical`], with vectors of `bits` bits: differences have one bit more.
pub(crate) fn cospherical_of_bits(bits: std::ops::Range<u32>) -> impl Strategy<Value = Five> {
    let choice = (0..6_usize, [any::<bool>(), any::<bool>(), any::<bool>()]);
    let choices = [choice.clone(), choice.clone(), choice.clone(), choice.clone(), choice];
    bits.prop_flat_map(move |bits| (lattice_point(bits), lattice_point(bits), choices.clone()))
        .prop_map(|(vector, centre, choices)| {
            choices.map(|(permutation, signs)| {
                const ORDERS: [[usize; 3]; 6] =
                    [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
                let order = ORDERS[permutation];
                std::array::from_fn(|k| {
                    let c = vector[order[k]];
                    centre[k] + if signs[k] { -c } else { c }
                })
            })
        })
}

/// Uniform points divided by their length: on the unit sphere up to rounding.
pub(crate) fn rounded_sphere() -> impl Strategy<Value = Five> {
    uniform().prop_map(|five| {
        five.map(|p| {
            let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
            if length > 0.0 { p.map(|c| c / length) } else { [1.0, 0.0, 0.0] }
        })
    })
}

/// Points near each other, far from zero: differences of few bits.
pub(crate) fn offset() -> impl Strategy<Value = Five> {
    (uniform(), 0..50_i32).prop_map(|(five, shift)| five.map(|p| p.map(|c| c + two_to(shift))))
}

/// Points around one point at distances over many decades.
pub(crate) fn cluster() -> impl Strategy<Value = Five> {
    let exponents = [-60..0_i32, -60..0_i32, -60..0_i32, -60..0_i32, -60..0_i32];
    (uniform(), uniform(), exponents).prop_map(|(five, centre, exponents)| {
        std::array::from_fn(|i| {
            std::array::from_fn(|k| centre[0][k] + five[i][k] * two_to(exponents[i]))
        })
    })
}

/// Moves single coordinates of another family by a few units in the last place.
pub(crate) fn with_ulps(base: impl Strategy<Value = Five>) -> impl Strategy<Value = Five> {
    let step = (0..5_usize, 0..3_usize, -3..=3_i64);
    (base, prop::collection::vec(step, 0..4)).prop_map(|(mut five, steps)| {
        for (i, k, ulps) in steps {
            // Steps the magnitude, which stops at zero; the sign stays.
            let bits = five[i][k].to_bits();
            let sign = bits & (1 << 63);
            five[i][k] = f64::from_bits(sign | (bits ^ sign).saturating_add_signed(ulps));
        }
        five
    })
}

/// Every family of moderate exponents.
pub(crate) fn moderate() -> impl Strategy<Value = Five> {
    prop_oneof![
        uniform(),
        small_integers(),
        coplanar(),
        with_ulps(coplanar()),
        cospherical(),
        with_ulps(cospherical()),
        with_ulps(rounded_sphere()),
        offset(),
        cluster(),
    ]
}

/// A moderate family times a power of two from `exponents`.
pub(crate) fn scaled(exponents: std::ops::Range<i32>) -> impl Strategy<Value = Five> {
    (moderate(), exponents).prop_map(|(five, exponent)| {
        let half = exponent / 2;
        five.map(|p| p.map(|c| c * two_to(half) * two_to(exponent - half)))
    })
}

/// A moderate family that stays in the exactness window: coordinates below 2^-142 become 0.
pub(crate) fn in_window() -> impl Strategy<Value = Five> {
    prop_oneof![scaled(-142..-80), scaled(-40..40), scaled(140..148)]
        .prop_map(|five| five.map(|p| p.map(|c| if c.abs() < two_to(-142) { 0.0 } else { c })))
}

/// Any finite coordinates: bit patterns drawn at random, mostly of wildly different exponents.
pub(crate) fn any_bits() -> impl Strategy<Value = Five> {
    points(any::<u64>().prop_map(|bits| {
        let value = f64::from_bits(bits);
        if value.is_finite() { value } else { 0.0 }
    }))
}

/// A moderate family with every coordinate column at its own scale.
pub(crate) fn mixed_axes() -> impl Strategy<Value = Five> {
    (moderate(), [-600..600_i32, -600..600, -600..600]).prop_map(|(five, exponents)| {
        five.map(|p| std::array::from_fn(|k| p[k] * two_to(exponents[k])))
    })
}

/// Multiples of the least subnormal.
pub(crate) fn subnormal() -> impl Strategy<Value = Five> {
    small_integers().prop_map(|five| five.map(|p| p.map(|c| c * f64::from_bits(1))))
}

/// Differences of as many bits as a stage admits, or one more, in matrices of many signs, whose
/// determinants are as large as determinants get.
pub(crate) fn full_width() -> impl Strategy<Value = Five> {
    let widths = select(vec![9, 10, 16, 17, 62, 63, 124, 125]);
    let base = select(vec![[0.0; 3], [1.0; 3], [-1.0, 1.0, -1.0], [1.0, 0.0, 0.0]]);
    (points(select(vec![-1.0, -1.0, 1.0, 1.0, 0.0])), widths, base).prop_map(
        |(five, width, base)| {
            // 2^width - 1, or the nearest f64 below it.
            let most = two_to(width) - two_to((width - 53).max(0));
            let [a, b, c, d, _] = five.map(|p| p.map(|sign| sign * most));
            [a, b, c, d, base]
        },
    )
}

/// Everything finite.
pub(crate) fn everything() -> impl Strategy<Value = Five> {
    prop_oneof![
        4 => moderate(),
        1 => scaled(-1070..-900),
        1 => scaled(-400..-180),
        1 => scaled(180..400),
        1 => scaled(900..1020),
        1 => any_bits(),
        1 => mixed_axes(),
        1 => subnormal(),
        1 => full_width(),
    ]
    .prop_map(|five| five.map(|p| p.map(|c| if c.is_finite() { c } else { f64::MAX })))
}
