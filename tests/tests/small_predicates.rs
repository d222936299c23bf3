//! Predicates and perturbation, exhaustively: every tuple of points of {0, 1, 2}³ against the
//! polynomials in ε of `ltbw_tests::epsilon`.
//!
//! Coverage, without any use of the cube's symmetry: `orient3d`, the planar predicates and
//! the hull facets on all 27⁴ quadruples; `insphere` on all 27⁵ quintuples, equal points included;
//! the perturbed sphere on all 80,730 sets of five points, each in all of its 120 orders that make
//! the first four points positive. The one identity used: a determinant changes its sign with the
//! parity of the order of its rows, so that the oracle is asked once per set.
//!
//! All sets are asked again, in one order for each choice of the fifth point, on images of
//! the grid: moved, in steps of an ulp, and far outside the exactness window. They change neither
//! signs nor the order by (x, y, z), but other stages of the predicates answer.

use ltbw::predicates::{self, perturb};
use ltbw::{Point, Sign};
use ltbw_tests::epsilon::{self, Small};
use ltbw_tests::families::two_to;
use ltbw_tests::small_world::subsets;

/// A coordinate of an image of the grid.
type Image = fn(i64) -> f64;

/// Images k -> offset + k step that are exact.
const IMAGES: [(&str, Image); 8] = [
    ("around zero", |k| k as f64 - 1.0),
    ("offset", |k| (k - (1 << 50)) as f64),
    ("in ulps", |k| 1.0 + k as f64 * f64::EPSILON),
    ("window's lower end", |k| k as f64 * two_to(-142)),
    ("window's upper end", |k| k as f64 * two_to(198)),
    ("small", |k| (k - 1) as f64 * two_to(-600)),
    ("subnormal", |k| k as f64 * f64::from_bits(1)),
    ("huge", |k| (k - 1) as f64 * two_to(1022)),
];

/// The points of {0, 1, 2}³, ascending by (x, y, z).
fn grid() -> Vec<Small> {
    (0..27).map(|i| [i / 9, i / 3 % 3, i % 3]).collect()
}

fn floats<const N: usize>(points: [Small; N], image: Image) -> [Point; N] {
    points.map(|p| p.map(image))
}

/// All orders of N things, with their parity.
fn orders<const N: usize>() -> Vec<([usize; N], Sign)> {
    let digits =
        |code: usize| -> [usize; N] { std::array::from_fn(|i| code / N.pow(i as u32) % N) };
    let all = (0..N.pow(N as u32)).map(digits);
    let orders = all.filter(|o| (0..N).all(|i| o.contains(&i)));
    let parity = |o: &[usize; N]| {
        let inversions =
            (0..N).flat_map(|j| (0..j).map(move |i| (i, j))).filter(|&(i, j)| o[i] > o[j]);
        if inversions.count() % 2 == 0 { Sign::Positive } else { Sign::Negative }
    };
    orders.map(|o| (o, parity(&o))).collect()
}

/// The five points of each set of five.
fn quintuples() -> impl Iterator<Item = [Small; 5]> {
    let grid = grid();
    subsets(27, 5).map(move |set| {
        let mut members = (0..27).filter(|i| set >> i & 1 == 1).map(|i| grid[i]);
        std::array::from_fn(|_| members.next().expect("five members"))
    })
}

/// Checks one order of five distinct points; `side` and `perturbed` are the oracle's signs of the
/// determinants. Returns whether the perturbation decided.
fn check_five(points: &[Point; 5], side: Sign, perturbed: Sign) -> bool {
    let [a, b, c, d, e] = points;
    assert_eq!(predicates::insphere(a, b, c, d, e), side, "insphere {points:?}");
    if predicates::orient3d(a, b, c, d) != Sign::Positive {
        return false;
    }
    assert_ne!(perturbed, Sign::Zero, "the oracle is never zero for a tetrahedron: {points:?}");
    assert_eq!(perturb::side_of_sphere(a, b, c, d, e), perturbed, "side_of_sphere {points:?}");
    if side == Sign::Zero {
        assert_eq!(perturb::perturbed_side(a, b, c, d, e), perturbed, "{points:?}");
    }
    side == Sign::Zero
}

#[test]
fn all_sets_of_five_points_in_all_orders() {
    let orders = orders::<5>();
    let (mut sets, mut degenerate) = (0, 0);
    for five in quintuples() {
        let side = epsilon::insphere(&five);
        let perturbed = epsilon::perturbed_insphere(&five);
        let points = floats(five, |k| k as f64);
        let mut any = false;
        for (order, parity) in &orders {
            any |= check_five(&order.map(|i| points[i]), side * *parity, perturbed * *parity);
        }
        sets += 1;
        degenerate += u32::from(any);
    }
    assert_eq!((orders.len(), sets), (120, 80_730));
    println!("{sets} sets of five, {degenerate} of them cospherical around a tetrahedron");
    assert!(degenerate > 5_000, "{degenerate}");
}

#[test]
fn all_sets_of_five_points_on_images_of_the_grid() {
    // The fifth point is each of the five in turn, and the first four turn both ways.
    let orders = orders::<5>();
    let chosen = |last: usize, sign: Sign| orders.iter().find(|(o, s)| o[4] == last && *s == sign);
    let chosen: Vec<_> = (0..5)
        .flat_map(|last| [chosen(last, Sign::Positive), chosen(last, Sign::Negative)])
        .map(|order| order.expect("an order of each parity"))
        .collect();
    for five in quintuples() {
        let side = epsilon::insphere(&five);
        let perturbed = epsilon::perturbed_insphere(&five);
        for (_, image) in IMAGES {
            let points = floats(five, image);
            for (order, parity) in &chosen {
                check_five(&order.map(|i| points[i]), side * *parity, perturbed * *parity);
            }
        }
    }
}

#[test]
fn all_quintuples_with_equal_points() {
    let points: Vec<Point> = grid().into_iter().map(|p| p.map(|k| k as f64)).collect();
    let mut count = 0;
    for code in 0..27usize.pow(5) {
        let five: [usize; 5] = std::array::from_fn(|i| code / 27usize.pow(i as u32) % 27);
        if (0..5).any(|i| five[..i].contains(&five[i])) {
            let [a, b, c, d, e] = five.map(|i| &points[i]);
            assert_eq!(predicates::insphere(a, b, c, d, e), Sign::Zero, "{five:?}");
            count += 1;
        }
    }
    assert_eq!(count, 27u32.pow(5) - 27 * 26 * 25 * 24 * 23);
}

/// Everything that takes up to four points, for the points of one quadruple; returns whether the
/// perturbation of a circle decided.
fn check_four(four: &[Small; 4], image: Image) -> bool {
    let points = floats(*four, image);
    let [a, b, c, d] = &points;
    let volume = epsilon::orient3d(four);
    assert_eq!(predicates::orient3d(a, b, c, d), volume, "orient3d {points:?}");
    let turn = epsilon::coplanar_orient([four[0], four[1], four[2]]);
    assert_eq!(predicates::coplanar_orient(a, b, c), turn, "coplanar_orient {points:?}");
    assert_eq!(predicates::collinear(a, b, c), turn == Sign::Zero, "collinear {points:?}");
    let circle =
        (volume == Sign::Zero && turn != Sign::Zero).then(|| epsilon::side_of_circle(four, false));
    if let Some(side) = circle {
        assert_eq!(predicates::side_of_bounded_circle(a, b, c, d), side, "circle {points:?}");
    }
    let distinct = (0..4).all(|i| !four[..i].contains(&four[i]));
    if !distinct || turn == Sign::Zero {
        return false;
    }
    let side = epsilon::side_of_hull_facet(four);
    assert_ne!(side, Sign::Zero, "the oracle is never zero: {points:?}");
    assert_eq!(perturb::side_of_hull_facet(a, b, c, d), side, "hull facet {points:?}");
    if circle.is_some() {
        assert_eq!(perturb::side_of_circle(a, b, c, d), side, "side_of_circle {points:?}");
    }
    circle == Some(Sign::Zero)
}

#[test]
fn all_quadruples() {
    let grid = grid();
    let mut degenerate = 0;
    for code in 0..27usize.pow(4) {
        let four = std::array::from_fn(|i| grid[code / 27usize.pow(i as u32) % 27]);
        degenerate += u32::from(check_four(&four, |k| k as f64));
    }
    println!("{} quadruples, {degenerate} of them cocircular", 27u32.pow(4));
    assert!(degenerate > 5_000, "{degenerate}");
}

#[test]
fn all_sets_of_four_points_on_images_of_the_grid() {
    let grid = grid();
    for set in subsets(27, 4) {
        let mut members = (0..27).filter(|i| set >> i & 1 == 1).map(|i| grid[i]);
        let four: [Small; 4] = std::array::from_fn(|_| members.next().expect("four members"));
        for (order, _) in orders::<4>() {
            for (_, image) in IMAGES {
                check_four(&order.map(|i| four[i]), image);
            }
        }
    }
}
