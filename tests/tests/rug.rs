//! Every public predicate against `rug` in bulk, on all families inside and outside the exactness
//! window: 200,000 calls, or `LTBW_CASES` (the full bar is 50 million, in release):
//!
//! ```text
//! LTBW_CASES=50000000 cargo test --release -p ltbw-tests --test rug -- --nocapture
//! ```

use ltbw::predicates::distance::cmp_distance;
use ltbw::predicates::{self, perturb};
use ltbw::{Point, Sign};
use ltbw_tests::cases;
use ltbw_tests::families::{Rng, two_to};
use ltbw_tests::fives::{Draw, FACTORS, WIDE, WINDOW};
use ltbw_tests::oracle::{self, Exact, exact};
use std::thread;
use std::time::Instant;

/// Names of the predicates, in the order of [`Tally::signs`].
const PREDICATES: [&str; 8] = [
    "orient3d",
    "insphere",
    "coplanar_orient",
    "side_of_bounded_circle",
    "side_of_sphere",
    "side_of_circle",
    "side_of_hull_facet",
    "cmp_distance",
];

/// Calls by predicate and by sign (negative, zero, positive).
#[derive(Clone, Copy, Default)]
struct Tally {
    signs: [[u64; 3]; PREDICATES.len()],
}

impl Tally {
    fn calls(&self) -> u64 {
        self.signs.iter().flatten().sum()
    }

    fn add(&mut self, other: &Self) {
        let theirs = other.signs.iter().flatten();
        self.signs.iter_mut().flatten().zip(theirs).for_each(|(mine, n)| *mine += n);
    }

    /// Counts one call; a sign that is not the oracle's is the end of the test.
    fn compare(&mut self, predicate: usize, ours: Sign, rug: Sign, family: &str, at: &[Point]) {
        let name = PREDICATES[predicate];
        assert_eq!(ours, rug, "{name} of the five points {at:?}, family {family}");
        self.signs[predicate][(ours as i8 + 1) as usize] += 1;
    }

    /// All predicates on one order of five points.
    fn five(&mut self, family: &str, points: &[Point; 5], scaled: &[&Exact; 5]) {
        let [a, b, c, d, e] = points.each_ref();
        let &[xa, xb, xc, xd, xe] = scaled;
        let volume = exact::orient3d(xa, xb, xc, xd);
        let mut see = |predicate, ours, rug| self.compare(predicate, ours, rug, family, points);
        see(0, predicates::orient3d(a, b, c, d), volume);
        see(1, predicates::insphere(a, b, c, d, e), exact::insphere(xa, xb, xc, xd, xe));
        let turn = exact::coplanar_orient(xa, xb, xc);
        see(2, predicates::coplanar_orient(a, b, c), turn);
        let near = Sign::from_ordering(exact::cmp_distance(xe, xa, xb));
        see(7, Sign::from_ordering(cmp_distance(e, a, b)), near);
        if turn != Sign::Zero && volume == Sign::Zero {
            let side = exact::side_of_bounded_circle(xa, xb, xc, xd);
            see(3, predicates::side_of_bounded_circle(a, b, c, d), side);
        }
        let distinct = (0..5).all(|i| (0..i).all(|j| scaled[i] != scaled[j]));
        if !distinct {
            return;
        }
        if turn != Sign::Zero {
            let side = exact::side_of_hull_facet([xa, xb, xc], xd);
            see(6, perturb::side_of_hull_facet(a, b, c, d), side);
            if volume == Sign::Zero {
                let side = exact::side_of_circle([xa, xb, xc], xd);
                assert_ne!(side, Sign::Zero, "{points:?}");
                see(5, perturb::side_of_circle(a, b, c, d), side);
            }
        }
        if volume == Sign::Positive {
            let side = exact::side_of_sphere([xa, xb, xc, xd], xe);
            assert_ne!(side, Sign::Zero, "{points:?}");
            see(4, perturb::side_of_sphere(a, b, c, d, e), side);
        }
    }
}

/// At least `calls` calls, drawn from all families in turn by `seed`.
fn compare(calls: u64, seed: u64) -> Tally {
    let mut rng = Rng::new(seed);
    let mut tally = Tally::default();
    for round in 0usize.. {
        let families = WINDOW.iter().chain(WIDE).enumerate();
        for (number, &(name, draw)) in families {
            if tally.calls() >= calls {
                return tally;
            }
            let inside = number < WINDOW.len();
            let exponent = if inside { FACTORS[round % FACTORS.len()] } else { 0 };
            drawn(&mut tally, name, draw, two_to(exponent), &mut rng);
        }
    }
    tally
}

/// One draw, in both orientations of its first four points.
fn drawn(tally: &mut Tally, name: &str, draw: Draw, factor: f64, rng: &mut Rng) {
    let mut points = draw(rng).map(|p| p.map(|c| c * factor));
    let scaled = oracle::scale(&points);
    let mut scaled: [&Exact; 5] = std::array::from_fn(|i| &scaled[i]);
    tally.five(name, &points, &scaled);
    points.swap(1, 2);
    scaled.swap(1, 2);
    tally.five(name, &points, &scaled);
}

#[test]
fn all_predicates_equal_rug_in_bulk() {
    let (calls, start) = (u64::from(cases(200_000)), Instant::now());
    let workers = thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let mut tally = Tally::default();
    thread::scope(|scope| {
        let run = |k| scope.spawn(move || compare(calls.div_ceil(workers), 1_000 + k));
        let running: Vec<_> = (0..workers).map(run).collect();
        for worker in running {
            tally.add(&worker.join().expect("no mismatch"));
        }
    });
    println!("{} calls equal to rug in {:.0} s", tally.calls(), start.elapsed().as_secs_f64());
    for (name, [negative, zero, positive]) in PREDICATES.iter().zip(tally.signs) {
        println!("{name:>24}: {negative} negative, {zero} zero, {positive} positive");
    }
    assert!(tally.calls() >= calls);
    // A family that is never degenerate, or always, would test little. The perturbed predicates
    // have no zero.
    for (name, signs) in PREDICATES.iter().zip(&tally.signs) {
        let perturbed = ["side_of_sphere", "side_of_circle"].contains(name);
        let facet = *name == "side_of_hull_facet";
        for (k, &n) in signs.iter().enumerate() {
            let never = k == 1 && (perturbed || facet);
            assert_eq!(n == 0, never, "{name}: {signs:?}");
        }
    }
}
