//! Every public predicate against `rug` in bulk, on all families inside and outside the exactness
//! window: 200,000 calls, or `LTBW_CASES` (the full bar is 50 million, in release):
//!
//! ```text
//! LTBW_CASES=50000000 cargo test --release -p ltbw-tests --test workspace rug:: -- --nocapture
//! ```

use ltbw::Point;
use ltbw_tests::cases;
use ltbw_tests::families::{Rng, two_to};
use ltbw_tests::five_points::{Draw, FACTORS, PREDICATES, WIDE, WINDOW, each_predicate};
use ltbw_tests::oracle::{self, Exact};
use std::thread;
use std::time::Instant;

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

    /// Counts the calls on one order of five points; a sign that is not `rug`'s ends the test.
    fn five(&mut self, family: &str, points: &[Point; 5], scaled: &[&Exact; 5]) {
        each_predicate(points, scaled, |predicate, ours, rug| {
            let name = PREDICATES[predicate];
            assert_eq!(ours, rug, "{name} of the five points {points:?}, family {family}");
            self.signs[predicate][(ours as i8 + 1) as usize] += 1;
        });
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
