//! Random degenerate sets of 5 to 60 snapped points, all equal to CGAL: 2,000 of them, or
//! `LTBW_CASES` (100,000 for the full bar). A failure is shrunk to a small set and printed.

use ltbw::Order;
use ltbw_tests::cases;
use ltbw_tests::cgal::Cgal;
use ltbw_tests::compare::compare_with;
use ltbw_tests::families::snap;
use proptest::collection::vec;
use proptest::prelude::any;
use proptest::test_runner::{Config, TestCaseError, TestRunner};
use std::cell::RefCell;

#[test]
fn random_degenerate_sets_equal_cgal() {
    let Some(cgal) = Cgal::for_test("random_degenerate_sets_equal_cgal") else { return };
    let cgal = RefCell::new(cgal);
    let config = Config { cases: cases(2_000), failure_persistence: None, ..Config::default() };
    let sets = (any::<u32>(), vec(any::<[u8; 4]>(), 5..=60));
    let result = TestRunner::new(config).run(&sets, |(style, cells)| {
        let points = snap(style, &cells);
        let reply = cgal.borrow_mut().triangulate(&points);
        let reply = reply.map_err(|failure| TestCaseError::fail(failure.to_string()))?;
        for order in [Order::Brio, Order::Input] {
            compare_with(&reply, &points, order)
                .map_err(|difference| TestCaseError::fail(format!("{difference}: {points:?}")))?;
        }
        Ok(())
    });
    if let Err(failure) = result {
        panic!("{failure}");
    }
}
