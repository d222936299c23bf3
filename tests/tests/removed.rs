//! Vertices removed: what is left is what CGAL makes of the points that are left.

use ltbw::{Builder, Mesh, Point, PointSet, RemoveError};
use ltbw_tests::cases;
use ltbw_tests::cgal::{Ask, Cgal};
use ltbw_tests::families::{Rng, Size, all, snap};
use proptest::collection::vec;
use proptest::prelude::any;
use proptest::test_runner::{Config, TestCaseError, TestRunner};
use std::cell::RefCell;

/// Removes half of the vertices, chosen by chance, as far as there is a mesh without them; returns
/// the others.
fn halve(mesh: &mut Mesh, seed: u64) -> Result<Vec<Point>, String> {
    let mut all: Vec<(u32, Point)> = mesh.vertices().collect();
    all.sort_unstable_by_key(|v| v.0);
    Rng::new(seed).shuffle(&mut all);
    let mut left = all.split_off(all.len() / 2);
    for (v, p) in all {
        match mesh.remove(v) {
            Ok(()) => {}
            Err(RemoveError::Flat { .. }) => left.push((v, p)),
            Err(error) => return Err(format!("{p:?}: {error}")),
        }
    }
    Ok(left.into_iter().map(|v| v.1).collect())
}

/// Half of each family of the bars.
#[test]
fn half_of_each_family_equals_cgal() {
    let cgal = &mut Cgal::for_test("half_of_each_family_equals_cgal");
    for family in all(Size::Small) {
        let Ok(set) = PointSet::new(family.points) else { continue };
        let Ok(built) = Builder::new().build(&set) else { continue };
        let mut mesh = built.mesh;
        let left = halve(&mut mesh, 7).unwrap_or_else(|error| panic!("{}: {error}", family.name));
        let set = PointSet::new(left.clone()).expect("finite points");
        let built = Builder::new().build(&set).expect("a mesh").mesh;
        let hash = mesh.hash().expect("a hash");
        assert_eq!(Ok(hash), built.hash(), "{}", family.name);
        if let Some(cgal) = cgal {
            let theirs = cgal.hash(&left).unwrap_or_else(|failure| panic!("{failure}"));
            assert_eq!(theirs, Some(hash), "{}", family.name);
        }
    }
}

/// Random degenerate sets: 1,000 of them, or half of `LTBW_CASES`.
#[test]
fn half_of_random_degenerate_sets_equals_cgal() {
    let cgal = RefCell::new(Cgal::for_test("half_of_random_degenerate_sets_equals_cgal"));
    let config = Config { cases: cases(2_000) / 2, failure_persistence: None, ..Config::default() };
    let sets = (any::<u32>(), any::<u64>(), vec(any::<[u8; 4]>(), 5..=60));
    let result = TestRunner::new(config).run(&sets, |(style, seed, cells)| {
        let set = PointSet::new(snap(style, &cells));
        let set = set.map_err(|error| TestCaseError::fail(error.to_string()))?;
        // Flat sets have no mesh.
        let Ok(built) = Builder::new().build(&set) else { return Ok(()) };
        let mut mesh = built.mesh;
        let left = halve(&mut mesh, seed).map_err(TestCaseError::fail)?;
        let hash = mesh.hash().map_err(|error| TestCaseError::fail(error.to_string()))?;
        let theirs = match &mut *cgal.borrow_mut() {
            Some(cgal) => cgal.hash(&left).map_err(|e| TestCaseError::fail(e.to_string()))?,
            None => PointSet::new(left.clone())
                .ok()
                .and_then(|set| Builder::new().build(&set).ok()?.mesh.hash().ok()),
        };
        match theirs == Some(hash) {
            true => Ok(()),
            false => Err(TestCaseError::fail(format!("{theirs:?} and {hash}: {left:?}"))),
        }
    });
    if let Err(failure) = result {
        panic!("{failure}");
    }
}

/// CGAL removes the same points one by one.
#[test]
fn what_is_left_equals_what_cgal_leaves() {
    let Some(mut cgal) = Cgal::for_test("what_is_left_equals_what_cgal_leaves") else { return };
    for family in all(Size::Small) {
        let Ok(set) = PointSet::new(family.points.clone()) else { continue };
        let Ok(built) = Builder::new().build(&set) else { continue };
        let mut mesh = built.mesh;
        let later = family.points.len() / 2..family.points.len();
        let removed: Result<(), RemoveError> =
            later.map(|v| mesh.remove(v as u32)).filter(|r| !is_gone(r)).collect();
        let theirs = cgal.ask(&family.points, Ask { hash: true, remove: true, ..Ask::default() });
        let theirs = theirs.unwrap_or_else(|failure| panic!("{}: {failure}", family.name));
        match removed {
            Ok(()) => assert_eq!(theirs.hash, mesh.hash().ok(), "{}", family.name),
            Err(error) => assert!(theirs.dimension < 3, "{}: {error}", family.name),
        }
    }
}

/// Was it removed with another one at its place?
fn is_gone(removed: &Result<(), RemoveError>) -> bool {
    matches!(removed, Err(RemoveError::Unknown { .. }))
}
