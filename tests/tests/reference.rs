//! The reference itself: CGAL's server against brute force by definition, over all exponents, and
//! its own hash. What CGAL gets wrong must not become our golden data.

use ltbw::{Point, canonical_hash};
use ltbw_tests::cgal::{Ask, Cgal, Failure};
use ltbw_tests::families::{Rng, grid, scaled, skew_lines, snapped, spheres, uniform};
use ltbw_tests::oracle::{self, brute_force};
use ltbw_tests::require::skip;

fn sorted<const N: usize>(simplices: &[[u32; N]]) -> Vec<[u32; N]> {
    let mut rows: Vec<[u32; N]> = simplices.to_vec();
    rows.iter_mut().for_each(|row| row.sort_unstable());
    rows.sort_unstable();
    rows
}

fn small_degenerate_sets() -> Vec<Vec<Point>> {
    let octahedron = spheres(&[1]);
    let two_spheres = spheres(&[1, 2]);
    let plane: Vec<Point> = grid(3).into_iter().map(|[x, y, z]| [x + z, y, z - x]).collect();
    let mut random: Vec<Vec<Point>> =
        (0..40).map(snapped).filter(|points| points.len() <= 14).collect();
    random.extend([grid(2), octahedron, two_spheres, plane, skew_lines(6)]);
    random
}

/// CGAL has interval filters with a fall-back to exact numbers, so exponents do not matter to it,
/// up to sums and products that overflow in the exact numbers' conversions. Nothing it documents
/// says so for 2^-700; hence this test.
#[test]
fn cgal_is_right_far_outside_the_comfortable_range() {
    let Some(mut cgal) = Cgal::for_test("cgal_is_right_far_outside_the_comfortable_range") else {
        return;
    };
    let mut count = 0;
    for points in small_degenerate_sets() {
        let expected = brute_force(&points);
        for e in [0, -60, -120, -190, -250, -340, -500, -700, -1000, 100, 190, 250, 340, 600, 1000]
        {
            let moved = scaled(&points, e);
            if scaled(&moved, -e) != points {
                continue; // an overflow or a rounded subnormal: another set
            }
            count += 1;
            let reply = cgal.triangulate(&moved).expect("CGAL answers");
            assert_eq!(sorted(&reply.tets), expected, "times 2^{e}: {points:?}");
        }
    }
    assert!(count > 100, "{count} scaled sets are too few to tell");
}

#[test]
fn cgal_sees_the_smallest_numbers() {
    let Some(mut cgal) = Cgal::for_test("cgal_sees_the_smallest_numbers") else { return };
    // A grid of subnormals, one of the largest numbers, and both at once.
    let tiny: Vec<Point> = grid(3).iter().map(|p| p.map(|c| c * f64::from_bits(1))).collect();
    let mixed: Vec<Point> = tiny.iter().chain(&grid(2)).copied().skip(14).collect();
    for points in [tiny, mixed] {
        let reply = cgal.triangulate(&points).expect("CGAL answers");
        assert_eq!(sorted(&reply.tets), brute_force(&points), "{points:?}");
    }
}

#[test]
fn the_reply_is_oriented_and_closed_and_carries_the_hash_of_its_own_mesh() {
    let Some(mut cgal) =
        Cgal::for_test("the_reply_is_oriented_and_closed_and_carries_the_hash_of_its_own_mesh")
    else {
        return;
    };
    for points in [grid(4), snapped(3), spheres(&[41])] {
        let reply = cgal.triangulate(&points).expect("CGAL answers");
        let at = |v: u32| &points[v as usize];
        for &[a, b, c, d] in &reply.tets {
            assert_eq!(oracle::orient3d(at(a), at(b), at(c), at(d)), ltbw::Sign::Positive);
        }
        for &[a, b, c] in &reply.hull {
            let beyond = points
                .iter()
                .any(|p| oracle::orient3d(at(a), at(b), at(c), p) == ltbw::Sign::Positive);
            assert!(!beyond, "hull facet {a} {b} {c} has a point beyond it");
        }
        let hash = canonical_hash(&points, &reply.tets).expect("a mesh of distinct points");
        assert_eq!(reply.hash, Some(hash));
    }
}

#[test]
fn cgal_is_one_function_of_the_point_set_for_twenty_orders() {
    let Some(mut cgal) = Cgal::for_test("cgal_is_one_function_of_the_point_set") else { return };
    let mut rng = Rng::new(5);
    let mut points = grid(5);
    let hash = cgal.hash(&points).expect("CGAL answers");
    assert!(hash.is_some());
    for _ in 0..20 {
        rng.shuffle(&mut points);
        let ask = Ask { hash: true, input_order: true, ..Ask::default() };
        assert_eq!(cgal.ask(&points, ask).expect("CGAL answers").hash, hash);
    }
}

#[test]
fn sets_of_lower_dimension_are_a_status() {
    let Some(mut cgal) = Cgal::for_test("sets_of_lower_dimension_are_a_status") else { return };
    let flat: Vec<Point> = grid(3).into_iter().map(|[x, y, _]| [x, y, x]).collect();
    let line: Vec<Point> = (0..9).map(|i| [f64::from(i); 3]).collect();
    let sets = [(vec![], -1), (vec![[1.0; 3]; 2], 0), (line, 1), (flat, 2), (grid(2), 3)];
    for (points, dimension) in sets {
        let reply = cgal.triangulate(&points).expect("CGAL answers");
        assert_eq!(reply.dimension, dimension);
        assert_eq!(reply.hash.is_some(), dimension == 3);
        assert_eq!(reply.tets.is_empty(), dimension < 3);
    }
    assert!(cgal.triangulate(&[[f64::NAN; 3]]).is_err());
}

#[test]
fn cgal_on_two_threads_gives_the_same_mesh() {
    let test = "cgal_on_two_threads_gives_the_same_mesh";
    let mut parallel = match Cgal::start_tbb() {
        Ok(cgal) => cgal,
        Err(Failure::Missing(missing)) => {
            return skip(test, "tbb", &missing.to_string()).expect("TBB is not demanded");
        }
        Err(failure) => panic!("{failure}"),
    };
    let Some(mut cgal) = Cgal::for_test(test) else { return };
    for points in [grid(12), uniform(5_000, 9)] {
        let ask = Ask { hash: true, threads: 2, ..Ask::default() };
        let hash = parallel.ask(&points, ask).expect("CGAL answers").hash;
        assert!(hash.is_some());
        assert_eq!(hash, cgal.hash(&points).expect("CGAL answers"));
    }
}
