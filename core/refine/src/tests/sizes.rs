//! Sizing functions that give no lengths, or different ones for one place.

use super::{model, refine};
use crate::{RefineError, Refiner, SizeField};
use ltbw_exact::Point;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The vertices from which on there are rounds.
const STARTS: [usize; 2] = [usize::MAX, 64];

fn error(field: &SizeField<'_>, start: usize) -> RefineError {
    let ready = model();
    let refiner = Refiner::new().sizing(field).start(start);
    refiner.refine(&ready.domain, &ready.lattice).expect_err("a wrong sizing function")
}

#[test]
fn what_is_no_length_is_named_with_its_place() {
    for wrong in [f64::NAN, 0.0, -1.0, f64::NEG_INFINITY, 1e-300] {
        let field = |p: Point| if p[0] > 0.5 { wrong } else { 0.1 };
        for start in STARTS {
            let RefineError::Size { at, value } = error(&field, start) else {
                panic!("{wrong} from {start}");
            };
            assert!(at[0] > 0.5 && value.to_bits() == wrong.to_bits(), "{at:?} {value} {wrong}");
        }
    }
    let text = RefineError::Size { at: [0.5, 1.0, 2.0], value: f64::NAN }.to_string();
    assert_eq!(
        text,
        "the size at [0.5, 1.0, 2.0] is NaN: an edge length is positive, and so is its cube"
    );
}

#[test]
fn an_infinite_length_asks_for_nothing() {
    let ready = model();
    let plain = refine(&Refiner::new(), &ready).mesh().hash().expect("a hash");
    for start in STARTS {
        let refined = refine(&Refiner::new().sizing(&|_| f64::INFINITY).start(start), &ready);
        if start == usize::MAX {
            assert_eq!(refined.mesh().hash().expect("a hash"), plain);
        }
        assert!(refined.excuses.is_empty());
    }
}

#[test]
fn one_thread_asks_all_sizes() {
    let caller = std::thread::current().id();
    let elsewhere = AtomicUsize::new(0);
    let field = |_: Point| {
        if std::thread::current().id() != caller {
            elsewhere.fetch_add(1, Ordering::Relaxed);
        }
        0.05
    };
    let refiner = Refiner::new().sizing(&field).start(0);
    let alone = refine(&refiner.one_thread(), &model());
    assert_eq!((elsewhere.into_inner(), alone.stats.round_threads), (0, 1));
    assert!(alone.stats.rounds > 0);
    let all = refine(&Refiner::new().sizing(&|_| 0.05).start(0), &model());
    assert_eq!(alone.mesh().hash().expect("a hash"), all.mesh().hash().expect("a hash"));
}

#[test]
fn a_function_that_changes_its_mind_is_told() {
    for start in STARTS {
        let calls = AtomicUsize::new(0);
        let coarse = |_: Point| {
            calls.fetch_add(1, Ordering::Relaxed);
            0.25
        };
        // On several threads the number of calls depends on the time.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        pool.install(|| refine(&Refiner::new().sizing(&coarse).start(start), &model()));
        // The last calls are about the whole mesh, in the end.
        let most = calls.swap(0, Ordering::Relaxed);
        let field = |_: Point| match calls.fetch_add(1, Ordering::Relaxed) {
            k if k + 20 < most => 0.25,
            _ => 0.02,
        };
        let found = pool.install(|| error(&field, start));
        assert!(matches!(found, RefineError::ImpureSize { .. }), "{found:?} from {start}");
    }
}
