//! The thread runtime: the sequential kernel's mesh for any number of threads.

use ltbw::generate::{PointKind, generate};
use ltbw::protocol::Rule;
use ltbw::threads::{Parallel, RunError};
use ltbw::{BuildError, Builder, CancelToken, Outcome, PointSet, invariants};
use std::time::Duration;

fn set(kind: PointKind, count: u64, seed: u64) -> PointSet {
    PointSet::new(generate(kind, count as usize, seed)).expect("finite points")
}

#[test]
fn any_number_of_threads_gives_one_mesh() {
    for kind in [PointKind::Uniform, PointKind::Grid, PointKind::Clusters, PointKind::Sphere] {
        let set = set(kind, 8000, 5);
        let expected = Builder::new().build(&set).expect("a mesh").mesh.hash().expect("a hash");
        for workers in [1, 2, 3, 4, 8, 16] {
            let run = Parallel::new(workers).build(&set).expect("a mesh");
            assert_eq!(run.outcome, Outcome::Complete);
            assert_eq!(run.mesh.hash().expect("a hash"), expected, "{kind:?} on {workers}");
            let operations: u64 = run.workers.iter().map(|w| w.operations).sum();
            assert_eq!(operations > 0, workers > 1);
        }
    }
}

#[test]
fn the_result_is_a_sound_mesh() {
    let run = Parallel::new(3).build(&set(PointKind::Uniform, 3000, 1)).expect("a mesh");
    invariants::check_all(&run.mesh).expect("invariants");
    let mut mesh = run.mesh;
    mesh.insert([0.5, 0.25, 0.125]).expect("one more point");
    invariants::check_all(&mesh).expect("invariants");
}

#[test]
fn rules_and_latency_change_nothing() {
    let set = set(PointKind::Uniform, 1500, 9);
    let expected = Builder::new().build(&set).expect("a mesh").mesh.hash().expect("a hash");
    for rule in [Rule::WoundWait, Rule::WaitDie, Rule::Paper] {
        for latency in [0, 300] {
            let run = Parallel::new(4).rule(rule).latency(Duration::from_micros(latency));
            let run = run.build(&set).expect("a mesh");
            assert_eq!(run.mesh.hash().expect("a hash"), expected, "{rule}, {latency} us");
        }
    }
}

#[test]
fn errors_are_those_of_the_builder() {
    let flat = (0..50).map(|i| [f64::from(i % 7), f64::from(i / 7), 0.0]).collect();
    let flat = PointSet::new(flat).expect("finite points");
    let error = Parallel::new(2).build(&flat).expect_err("no mesh");
    assert_eq!(error, RunError::Build(BuildError::Coplanar { distinct: 50 }));
    for count in 0..4 {
        let few = set(PointKind::Uniform, count, 1);
        let error = Parallel::new(2).build(&few).expect_err("no mesh");
        assert!(matches!(error, RunError::Build(BuildError::TooFewPoints { .. })), "{error}");
    }
}

#[test]
fn a_cancelled_run_has_a_mesh_of_some_points() {
    let token = CancelToken::new();
    token.cancel();
    let set = set(PointKind::Uniform, 20_000, 2);
    let run = Parallel::new(4).cancel(&token).build(&set).expect("a mesh");
    assert_eq!(run.outcome, Outcome::Cancelled);
    assert!((4..20_000).contains(&run.mesh.num_vertices()), "{}", run.mesh.num_vertices());
    invariants::check_all(&run.mesh).expect("invariants");
}
