//! Points of which each member of a team has a slice, and nobody all: the sequential mesh, or the
//! sequential error at every member.

use ltbw::distributed::{self, Points, Slice, SliceError};
use ltbw::domain::Thickness;
use ltbw::team::Team;
use ltbw::threads::{BuiltPart, RunError};
use ltbw::{Budget, Builder, Point, PointError, PointSet};
use ltbw_generate::{PointKind, generate};
use ltbw_tests::families::{mixed_exponents, subnormal_grid};
use ltbw_tests::teams::{on_team, slice_of, try_slice};

/// A member's slice, if all points are that of one of them.
fn of_one(team: &mut Team, points: &[Point], whose: u32) -> Slice {
    let own = if team.me().number() == whose { points.to_vec() } else { Vec::new() };
    Slice::new(team, own).expect("finite points")
}

/// Compares the meshes of teams with the sequential one.
fn compare(name: &str, points: &[Point], members: &[u32]) {
    let set = PointSet::new(points.to_vec()).expect("finite points");
    let expected = Builder::new().build(&set).expect("a mesh");
    let hash = expected.mesh.hash().expect("a hash");
    for &members in members {
        let build = |team: &mut Team, slice: &Slice| -> BuiltPart {
            let built = Builder::new().build_on(team, slice).expect("a mesh");
            let found = distributed::hash(team, &built.part).expect("a hash").hash;
            assert_eq!(found, hash, "{name} on {members}");
            built
        };
        for whose in [None, Some(0), Some(members - 1)] {
            let ends = on_team(members, |team| {
                let slice = match whose {
                    None => slice_of(team, points),
                    Some(whose) => of_one(team, points, whose),
                };
                build(team, &slice)
            });
            assert_eq!(ends[0].duplicates, expected.duplicates, "{name} on {members}, {whose:?}");
            for BuiltPart { part, num_duplicates, .. } in &ends {
                assert_eq!(*num_duplicates, expected.duplicates.len() as u64, "{name}");
                let at = part.numbers.iter().map(|&v| set.points()[v as usize].map(f64::to_bits));
                assert!(at.eq(part.points.iter().map(|p| p.map(f64::to_bits))), "{name}");
            }
        }
    }
}

#[test]
fn slices_of_any_size_have_the_sequential_mesh() {
    let uniform = generate(PointKind::Uniform, 3000, 9);
    compare(
        "a tetrahedron",
        &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        &[1, 2, 3, 5, 8],
    );
    compare("a few points", &uniform[..9], &[1, 7, 8, 13]);
    compare("uniform", &uniform, &[1, 2, 3, 5, 7, 8]);
    let twice: Vec<Point> = uniform.iter().rev().chain(&uniform[..1000]).copied().collect();
    compare("points of one slice in another", &twice, &[1, 2, 3, 5, 8]);
    let far = [[-1e9; 3], [1e9, 1e9, -1e9], [1e9, -1e9, 1e9]];
    let cluster: Vec<Point> = far.iter().chain(&uniform).copied().collect();
    compare("one cell of the curve", &cluster, &[1, 2, 3, 8]);
    let same: Vec<Point> = [vec![[0.5; 3]; 2000], uniform[..40].to_vec()].concat();
    compare("mostly one place", &same, &[1, 2, 5, 8]);
    let signs: Vec<Point> =
        uniform[..200].iter().flat_map(|p| [[0.0, p[1], p[2]], [-0.0, p[1], p[2]], *p]).collect();
    compare("two signs of zero", &signs, &[1, 3, 8]);
}

#[test]
fn the_mode_is_that_of_all_slices() {
    compare("subnormal", &subnormal_grid(6), &[1, 2, 5]);
    compare("wide", &mixed_exponents(300, 900, 3), &[1, 2, 5]);
    // One slice alone is out of the window.
    let mut points = generate(PointKind::Uniform, 400, 2);
    points[399] = [1e-250; 3];
    compare("one tiny point", &points, &[1, 2, 5]);
    points[0] = [1e250; 3];
    compare("and a huge one", &points, &[1, 2, 5]);
}

#[test]
fn points_without_a_mesh_are_refused_at_all_members_as_by_one() {
    let line = |n: i32| (0..n).map(|k| [f64::from(k % 17); 3]).collect::<Vec<Point>>();
    let plane: Vec<Point> = (0..40).map(|k| [f64::from(k % 7), f64::from(k % 5), 0.25]).collect();
    let cases = [Vec::new(), line(1), line(3), vec![[0.5; 3]; 60], line(60), plane];
    for points in cases {
        let set = PointSet::new(points.clone()).expect("finite points");
        let expected = Builder::new().build(&set).expect_err("no mesh");
        assert!(matches!(expected, RunError::Build(_)), "{expected}");
        for members in [1, 2, 3, 5, 8] {
            let ends = on_team(members, |team| {
                let slice = slice_of(team, &points);
                Builder::new().build_on(team, &slice).expect_err("no mesh")
            });
            assert!(ends.iter().all(|error| *error == expected), "{ends:?}, not {expected:?}");
        }
    }
}

#[test]
fn a_point_of_one_slice_that_is_not_finite_is_named_by_its_number_at_all_members() {
    let points = generate(PointKind::Uniform, 50, 4);
    for (at, value) in [(0, f64::INFINITY), (23, f64::NEG_INFINITY), (49, f64::NAN)] {
        let mut bad = points.clone();
        bad[at][1] = value;
        // The first one is named.
        bad[49][2] = f64::NAN;
        for members in [1, 2, 3, 5, 8, 64] {
            for end in on_team(members, |team| try_slice(team, &bad)) {
                match end {
                    Err(SliceError::Points(PointError::NotFinite {
                        index,
                        axis,
                        value: found,
                    })) => {
                        assert_eq!((index, axis), (at, 'y'), "{members}");
                        assert_eq!(found.to_bits(), value.to_bits());
                    }
                    other => panic!("{other:?}"),
                }
            }
        }
    }
}

#[test]
fn a_budget_is_not_one_of_a_team() {
    let points = generate(PointKind::Uniform, 50, 4);
    let budget = Budget { max_points: Some(20), ..Budget::default() };
    for end in on_team(2, |team| {
        let slice = slice_of(team, &points);
        Builder::new().budget(budget).build_on(team, &slice)
    }) {
        assert!(matches!(end, Err(RunError::Settings(_))), "{end:?}");
    }
}

#[test]
fn the_thickness_of_slices_is_that_of_all_points() {
    let flat = |noise: f64| -> Vec<Point> {
        let points = generate(PointKind::Uniform, 300, 6);
        points.into_iter().map(|[x, y, z]| [x + 3.0, y, 0.5 * x + noise * z]).collect()
    };
    let cases = [flat(0.0), flat(1e-9), flat(0.1), vec![[1.0; 3]; 9], Vec::new()];
    let told = cases.iter().map(|points| Thickness::of_flat(points).is_some());
    assert_eq!(told.collect::<Vec<_>>(), [true, true, false, false, false]);
    for points in cases {
        let expected = Thickness::of_flat(&points);
        for members in [1, 2, 3, 5, 8] {
            let ends = on_team(members, |team| {
                let slice = slice_of(team, &points);
                distributed::thickness(team, &slice).expect("a team")
            });
            assert!(ends.iter().all(|found| *found == expected), "{ends:?}, not {expected:?}");
        }
    }
}

#[test]
fn points_that_one_member_has_are_dealt_and_come_back() {
    let at = generate(PointKind::Uniform, 101, 8);
    for tags in [None, Some((0..101).map(|k| i64::MIN + k).collect::<Vec<i64>>())] {
        let whole = Points { at: at.clone(), tags };
        for members in [1, 2, 3, 7, 128] {
            let ends = on_team(members, |team| {
                let own = team.is_first().then(|| whole.clone());
                let own = distributed::deal(team, own).expect("a slice");
                let count = own.at.len();
                let slice = Slice::new(team, own.at).expect("finite points");
                let back = distributed::gather_points(team, &slice, own.tags.as_deref());
                (count, back.expect("all of them"))
            });
            let share = 101_usize.div_ceil(members as usize);
            assert!(ends.iter().all(|&(count, _)| count <= share), "{members}");
            assert_eq!(ends[0].1.as_ref(), Some(&whole), "{members}");
            assert!(ends[1..].iter().all(|(_, back)| back.is_none()), "one member has them");
        }
    }
}
