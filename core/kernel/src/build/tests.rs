use super::*;
use crate::invariants::check_all;
use ltbw_generate::{PointKind, generate};
use std::sync::atomic::{AtomicU64, Ordering};

/// Points of the moment curve: every two of them share an edge, n^2 / 2 tetrahedra.
fn curve(count: u32) -> PointSet {
    let points = (0..count).map(f64::from).map(|t| [t, t * t, t * t * t]).collect();
    PointSet::new(points).expect("finite points")
}

#[derive(Default)]
struct Calls(AtomicU64, Option<CancelToken>);

impl Observer for Calls {
    fn progress(&self, _: Progress) {
        self.0.fetch_add(1, Ordering::Relaxed);
        if let Some(token) = &self.1 {
            token.cancel();
        }
    }
}

#[test]
fn fast_growth_is_looked_at_between_batches() {
    let set = curve(800);
    let calls = Calls::default();
    let built = Builder::new().observer(&calls).build(&set).expect("a mesh");
    let tets = built.mesh.num_tets();
    assert!(tets > 300_000, "{tets}");
    // One call is that of the end: all points are one batch.
    let looks = calls.0.load(Ordering::Relaxed) - 1;
    assert!((1..=(tets / CHECK_GROWTH) as u64).contains(&looks), "{looks}");

    let calls = Calls(AtomicU64::new(0), Some(CancelToken::new()));
    let token = calls.1.as_ref().expect("a token");
    let built = Builder::new().observer(&calls).cancel(token).build(&set).expect("a mesh");
    assert_eq!(built.outcome, Outcome::Cancelled);
    let tets = built.mesh.num_tets();
    assert!((CHECK_GROWTH..CHECK_GROWTH + 2000).contains(&tets), "{tets}");

    for most in [1, 5_000, 150_000] {
        let budget = Budget { max_tets: Some(most), ..Budget::default() };
        let built = Builder::new().budget(budget).build(&set).expect("a mesh");
        assert_eq!(built.outcome, Outcome::Budget);
        let tets = built.mesh.num_tets() as u64;
        assert!((most + 1..most + 2000).contains(&tets), "{tets} for {most}");
    }
}

#[test]
fn an_exhausted_mesh_is_kept() {
    let points = generate(PointKind::Uniform, 500, 3);
    let set = PointSet::new(points).expect("finite points");
    let budget = Budget { max_points: Some(4), ..Budget::default() };
    let mut mesh = Builder::new().budget(budget).build(&set).expect("a mesh").mesh;
    let mut order = brio_hilbert(set.points());
    first_tet(set.points(), &mut order).expect("a tetrahedron");
    let mut left = 3000;
    let mut refuse = |_, _| {
        left -= 1;
        left > 0
    };
    let points = set.kernel_points();
    let outcome = Builder::new().insert_all(&mut mesh, &points, &order, &mut refuse);
    assert_eq!(outcome, Outcome::TooManyTets);
    assert!((5..500).contains(&mesh.num_vertices()));
    check_all(&mesh).expect("invariants");
}
