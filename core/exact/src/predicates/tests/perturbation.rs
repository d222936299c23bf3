//! The perturbation against its definition, by brute force.

use num_bigint::BigInt;
use num_traits::Zero;
use proptest::prelude::*;

use super::families;
use crate::Point;
use crate::predicates::perturb::{
    perturbed_side, side_of_circle, side_of_hull_facet, side_of_sphere,
};
use crate::predicates::{Sign, cmp_xyz, coplanar_orient, insphere, orient3d};

/// The ranks of the points: 1 for the largest, whose lift is raised by ε^1.
fn ranks<const N: usize>(points: &[Point; N]) -> [usize; N] {
    std::array::from_fn(|i| {
        1 + points.iter().filter(|other| cmp_xyz(other, &points[i]).is_gt()).count()
    })
}

/// Determinant of a matrix of integers, by the sum over permutations.
fn determinant(rows: &[Vec<i64>]) -> BigInt {
    fn expand(
        rows: &[Vec<i64>],
        row: usize,
        used: &mut Vec<usize>,
        sum: &mut BigInt,
        term: BigInt,
    ) {
        if row == rows.len() {
            *sum += term;
            return;
        }
        for column in 0..rows.len() {
            if used.contains(&column) {
                continue;
            }
            let inversions = used.iter().filter(|&&earlier| earlier > column).count();
            let sign = if inversions % 2 == 0 { 1 } else { -1 };
            let next = &term * rows[row][column] * sign;
            used.push(column);
            expand(rows, row + 1, used, sum, next);
            used.pop();
        }
    }
    let mut sum = BigInt::zero();
    expand(rows, 0, &mut Vec::new(), &mut sum, BigInt::from(1));
    sum
}

/// The sign, for small ε, of the determinant with rows (1, coordinates, |p|² + ε^rank): the
/// polynomial in ε is linear in each lift, so its coefficient of ε^rank is the determinant with
/// the lift column replaced by the unit vector of that point.
fn polynomial_sign<const N: usize>(points: &[Point; N], axes: &[usize]) -> Sign {
    let lift = |p: &Point| p.iter().map(|&c| (c * c) as i64).sum::<i64>();
    let ranks = ranks(points);
    for power in 0..=N {
        let rows: Vec<Vec<i64>> = (0..N)
            .map(|i| {
                let mut row = vec![1];
                row.extend(axes.iter().map(|&k| points[i][k] as i64));
                row.push(match power {
                    0 => lift(&points[i]),
                    _ => i64::from(ranks[i] == power),
                });
                row
            })
            .collect();
        let coefficient = determinant(&rows);
        if !coefficient.is_zero() {
            return Sign::from_ordering(coefficient.cmp(&BigInt::zero()));
        }
    }
    Sign::Zero
}

/// Positive inside the perturbed sphere, by definition: being lifted less than the hyperplane
/// through p0 to p3.
fn sphere_oracle(points: &[Point; 5]) -> Sign {
    -polynomial_sign(points, &[0, 1, 2])
}

/// As [`sphere_oracle`], in the first projection in which p0, p1, p2 are not collinear.
fn circle_oracle(points: &[Point; 4]) -> Sign {
    for axes in [[0, 1], [1, 2], [0, 2]] {
        let rows: Vec<Vec<i64>> =
            points[..3].iter().map(|p| vec![1, p[axes[0]] as i64, p[axes[1]] as i64]).collect();
        let local = determinant(&rows);
        if !local.is_zero() {
            // With rows (1, x, y, lift), the determinant is positive when the last point lies
            // above the plane through the lifts of a counterclockwise triangle: outside.
            return -polynomial_sign(points, &axes)
                * Sign::from_ordering(local.cmp(&BigInt::zero()));
        }
    }
    Sign::Zero
}

/// All permutations of the first `N` of the numbers, each with its parity.
fn permutations<const N: usize>() -> Vec<([usize; N], Sign)> {
    fn extend<const N: usize>(prefix: &mut Vec<usize>, all: &mut Vec<([usize; N], Sign)>) {
        if let Ok(permutation) = <[usize; N]>::try_from(prefix.clone()) {
            let pairs = (0..N).flat_map(|j| (0..j).map(move |i| (i, j)));
            let odd = pairs.filter(|&(i, j)| permutation[i] > permutation[j]).count() % 2 == 1;
            all.push((permutation, if odd { Sign::Negative } else { Sign::Positive }));
            return;
        }
        for i in 0..N {
            if !prefix.contains(&i) {
                prefix.push(i);
                extend(prefix, all);
                prefix.pop();
            }
        }
    }
    let mut all = Vec::new();
    extend(&mut Vec::new(), &mut all);
    all
}

/// Checks five distinct integer points in every role and order; returns whether the in-sphere
/// determinant of a proper tetrahedron was zero.
fn check_sphere(points: &[Point; 5]) -> bool {
    let mut degenerate = false;
    for (order, _) in permutations::<5>() {
        let [p0, p1, p2, p3, p] = order.map(|i| &points[i]);
        if !orient3d(p0, p1, p2, p3).is_positive() {
            continue;
        }
        let side = side_of_sphere(p0, p1, p2, p3, p);
        assert_eq!(side, sphere_oracle(&order.map(|i| points[i])), "{points:?} {order:?}");
        assert!(!side.is_zero());
        if insphere(p0, p1, p2, p3, p).is_zero() {
            degenerate = true;
            assert_eq!(perturbed_side(p0, p1, p2, p3, p), side);
        }
    }
    degenerate
}

/// Checks four distinct coplanar integer points in every role and order.
fn check_circle(points: &[Point; 4]) {
    for (order, _) in permutations::<4>() {
        let [p0, p1, p2, p] = order.map(|i| &points[i]);
        if coplanar_orient(p0, p1, p2).is_zero() {
            continue;
        }
        let side = side_of_circle(p0, p1, p2, p);
        assert_eq!(side, circle_oracle(&order.map(|i| points[i])), "{points:?} {order:?}");
        assert!(!side.is_zero());
        assert_eq!(side_of_hull_facet(p0, p1, p2, p), side);
    }
}

/// The corners of {0, ..., n-1}^3.
fn lattice(n: u32) -> Vec<Point> {
    (0..n * n * n).map(|i| [i / (n * n), i / n % n, i % n].map(f64::from)).collect()
}

/// Every subset of `size` indices below `count`, ascending.
fn subsets(count: usize, size: usize) -> Vec<Vec<usize>> {
    (0..1_u64 << count)
        .filter(|mask| mask.count_ones() as usize == size)
        .map(|mask| (0..count).filter(|&i| mask >> i & 1 == 1).collect())
        .collect()
}

#[test]
fn every_five_corners_of_the_cube() {
    let corners = lattice(2);
    let mut degenerate = 0;
    for subset in subsets(8, 5) {
        degenerate += usize::from(check_sphere(&std::array::from_fn(|i| corners[subset[i]])));
    }
    // All corners are cospherical, and no plane holds five of them: every subset has a
    // tetrahedron.
    assert_eq!(degenerate, 56);
}

#[test]
fn every_four_coplanar_corners_of_the_cube() {
    let corners = lattice(2);
    let mut coplanar = 0;
    for subset in subsets(8, 4) {
        let points: [Point; 4] = std::array::from_fn(|i| corners[subset[i]]);
        let [a, b, c, d] = &points;
        if orient3d(a, b, c, d).is_zero() {
            coplanar += 1;
            check_circle(&points);
        }
    }
    // Six faces and six diagonal planes.
    assert_eq!(coplanar, 12);
}

/// Exactly one of two diagonals: four points around a convex quadrilateral have two
/// triangulations, and the perturbed circles of both triangles of either choose the same one.
#[test]
fn triangles_of_a_quadrilateral_agree() {
    let points = lattice(3);
    let mut convex = 0;
    for (i, a) in points.iter().enumerate() {
        for (b, c, d) in triples(&points[i + 1..]) {
            let turns = [[a, b, c], [b, c, d], [c, d, a], [d, a, b]]
                .map(|[p, q, r]| coplanar_orient(p, q, r));
            let strictly_convex = turns[0] != Sign::Zero && turns.iter().all(|&t| t == turns[0]);
            if !orient3d(a, b, c, d).is_zero() || !strictly_convex {
                continue;
            }
            convex += 1;
            let keeps_ac = side_of_circle(a, b, c, d).is_negative();
            assert_eq!(keeps_ac, side_of_circle(a, c, d, b).is_negative());
            assert_eq!(!keeps_ac, side_of_circle(a, b, d, c).is_negative());
            assert_eq!(!keeps_ac, side_of_circle(b, c, d, a).is_negative());
        }
    }
    // Nine planes parallel to the axes hold 70 each (of 126 quadruples of a 3x3 grid); slanted
    // ones hold more.
    assert!(convex > 9 * 70, "only {convex} convex quadrilaterals");
}

/// All ordered triples of different points.
fn triples(points: &[Point]) -> impl Iterator<Item = (&Point, &Point, &Point)> {
    let n = points.len();
    (0..n * n * n)
        .map(move |t| (t / (n * n), t / n % n, t % n))
        .filter(|&(i, j, k)| i != j && j != k && i != k)
        .map(|(i, j, k)| (&points[i], &points[j], &points[k]))
}

/// Distinct points of {0, 1, 2}^3.
fn small_lattice<const N: usize>() -> impl Strategy<Value = [Point; N]> {
    prop::sample::subsequence(lattice(3), N)
        .prop_shuffle()
        .prop_map(|points| <[Point; N]>::try_from(points).expect("a subsequence of N points"))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn five_points_of_a_small_lattice(points in small_lattice::<5>()) {
        check_sphere(&points);
    }

    #[test]
    fn four_points_of_a_small_lattice(points in small_lattice::<4>()) {
        let [a, b, c, d] = &points;
        let side = orient3d(a, b, c, d);
        if side.is_zero() {
            check_circle(&points);
        } else {
            prop_assert_eq!(side_of_hull_facet(a, b, c, d), side);
        }
    }

    /// The perturbed determinant alternates: whichever of the five points is the one in question
    /// and however the others are ordered, the answer changes with the parity alone.
    #[test]
    fn the_answer_belongs_to_the_set(five in families::moderate()) {
        let distinct = (0..5).all(|j| (0..j).all(|i| cmp_xyz(&five[i], &five[j]).is_ne()));
        prop_assume!(distinct);
        // A power of two scales every coefficient of the polynomial, without a change of sign.
        let scaled = five.map(|p| p.map(|x| x * 4.0));
        let mut reference = None;
        for (order, parity) in permutations::<5>() {
            let [p0, p1, p2, p3, p] = order.map(|i| &five[i]);
            if !orient3d(p0, p1, p2, p3).is_positive() {
                continue;
            }
            let side = side_of_sphere(p0, p1, p2, p3, p);
            prop_assert!(!side.is_zero());
            prop_assert_eq!(side * parity, *reference.get_or_insert(side * parity));
            let [p0, p1, p2, p3, p] = order.map(|i| &scaled[i]);
            prop_assert_eq!(side_of_sphere(p0, p1, p2, p3, p), side);
        }
    }
}
