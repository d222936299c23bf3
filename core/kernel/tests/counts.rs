//! The counters of predicate calls, where they can be counted by hand or in another way: a filter
//! that passes everything on to exact arithmetic is right, and only its counter tells.

use ltbw_core::{Builder, Inserted, Mesh, PredicateStats};
use ltbw_exact::{Point, PointSet};
use ltbw_generate::{PointKind, generate};

fn build(points: Vec<Point>) -> Mesh {
    let set = PointSet::new(points).expect("finite points");
    Builder::new().build(&set).expect("a mesh").mesh
}

/// One tetrahedron: the corner of a cube.
fn corner(unit: f64) -> Mesh {
    let [x, y, z] = [[unit, 0.0, 0.0], [0.0, unit, 0.0], [0.0, 0.0, unit]];
    build(vec![[0.0; 3], x, y, z])
}

/// Inserts `p`; what was counted meanwhile, and how often an admission was asked.
fn insert(mesh: &mut Mesh, p: Point) -> (PredicateStats, u64) {
    let before = mesh.predicate_stats();
    let mut asked = 0;
    let inserted = mesh.insert_with(p, &mut |_, _| {
        asked += 1;
        true
    });
    assert!(matches!(inserted, Ok(Inserted::Vertex(_))), "{inserted:?}");
    let after = mesh.predicate_stats();
    let counted = PredicateStats {
        orient3d_calls: after.orient3d_calls - before.orient3d_calls,
        orient3d_exact: after.orient3d_exact - before.orient3d_exact,
        insphere_calls: after.insphere_calls - before.insphere_calls,
        insphere_exact: after.insphere_exact - before.insphere_exact,
        insphere_perturbed: after.insphere_perturbed - before.insphere_perturbed,
        sphere_undecided: after.sphere_undecided - before.sphere_undecided,
    };
    (counted, asked)
}

#[test]
fn a_point_inside_asks_for_the_four_hull_facets() {
    let (counted, asked) = insert(&mut corner(1.0), [0.25; 3]);
    // The sphere decides where the walk starts; each ghost is an orientation.
    let expected =
        PredicateStats { orient3d_calls: 4, insphere_calls: 4, ..PredicateStats::default() };
    assert_eq!((counted, asked), (expected, 5));
}

#[test]
fn a_point_on_the_sphere_is_decided_by_perturbation() {
    let (counted, _) = insert(&mut corner(1.0), [1.0; 3]);
    assert_eq!((counted.sphere_undecided, counted.insphere_perturbed), (1, 1));
    // Few steps of the lattice: the filter is exact.
    assert_eq!((counted.insphere_exact, counted.orient3d_exact), (0, 0));
}

#[test]
fn a_tie_with_many_bits_is_decided_exactly() {
    // As above, but with bits far below those of the corner.
    let odd = 1.0 + f64::EPSILON * 8.0;
    let (counted, _) = insert(&mut corner(odd), [odd; 3]);
    assert_eq!((counted.sphere_undecided, counted.insphere_perturbed), (1, 1));
    assert_eq!((counted.insphere_exact, counted.orient3d_exact), (1, 0));

    // In the plane of x, y and z, beyond the edge from x to y.
    let third = odd / 4.0;
    let (counted, _) = insert(&mut corner(odd), [3.0 * third, 3.0 * third, -2.0 * third]);
    assert!(counted.orient3d_exact >= 1, "{counted:?}");
    assert!(counted.orient3d_exact < counted.orient3d_calls, "{counted:?}");
}

#[test]
fn spheres_of_generic_points_leave_nothing_to_the_filter() {
    let (counted, _) = insert(&mut corner(1.0), [0.9, 0.8, 0.7]);
    assert_eq!((counted.sphere_undecided, counted.insphere_exact), (0, 0));
    // Outside the frame no sphere answers, and the filter does.
    let (counted, _) = insert(&mut corner(1.0), [0.5, 0.5, 9.0]);
    assert_eq!((counted.sphere_undecided, counted.insphere_exact), (1, 0));
}

/// An admission is asked once for every tetrahedron of the cavity and once for every boundary face:
/// that is one more than there are conflict tests.
#[test]
fn conflict_tests_are_those_that_admissions_see() {
    for kind in PointKind::ALL {
        let mut points = generate(kind, 160, 5);
        let later = points.split_off(points.len() / 2);
        let mut mesh = build(points);
        for p in later {
            let next = mesh.predicate_stats();
            let mut asked = 0;
            let inserted = mesh.insert_with(p, &mut |_, _| {
                asked += 1;
                true
            });
            let stats = mesh.predicate_stats();
            let calls = stats.insphere_calls - next.insphere_calls;
            match inserted.expect("a finite point") {
                Inserted::Vertex(_) => assert_eq!(calls + 1, asked, "{kind:?}"),
                Inserted::Duplicate(_) => assert_eq!((calls, asked), (0, 0), "{kind:?}"),
            }
            assert!(stats.insphere_perturbed <= stats.sphere_undecided, "{kind:?}: {stats:?}");
            assert!(stats.insphere_exact <= stats.sphere_undecided, "{kind:?}: {stats:?}");
            assert!(stats.orient3d_exact <= stats.orient3d_calls, "{kind:?}: {stats:?}");
        }
    }
}

#[test]
fn a_grid_needs_perturbation_and_no_exact_stage() {
    let stats = build(generate(PointKind::Grid, 1000, 1)).predicate_stats();
    assert_eq!((stats.insphere_exact, stats.orient3d_exact), (0, 0), "{stats:?}");
    assert!(stats.insphere_perturbed > 1000, "{stats:?}");
    // Nearly all of the tests that the spheres leave open are ties.
    assert!(stats.insphere_perturbed * 10 > stats.sphere_undecided * 9, "{stats:?}");
    assert!(stats.orient3d_calls < 20 * 1000, "{stats:?}");
}
