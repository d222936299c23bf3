//! The canonical hash: what it depends on, what it does not, and which meshes have none.

use ltbw_core::{HashError, canonical_hash};
use ltbw_exact::Point;

const POINTS: [Point; 5] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
const TETS: [[u32; 4]; 2] = [[0, 1, 2, 3], [1, 2, 3, 4]];

#[test]
fn it_is_that_of_the_description() {
    // Computed from the description with another SHA-256 (Python's hashlib).
    let expected = "276ce0fabe6d03052ab65f955c790fa4a9e47cb8ca9fef4aed58859cb0c8c5ff";
    let hash = canonical_hash(&POINTS, &TETS).expect("a hash");
    assert_eq!(hash.to_string(), expected);
    assert_eq!(format!("{hash:?}"), format!("MeshHash({expected})"));
}

#[test]
fn numbering_order_and_unused_points_do_not_matter() {
    let expected = canonical_hash(&POINTS, &TETS);
    let unused = f64::NAN;
    let mut points = vec![[unused; 3]];
    points.extend(POINTS.iter().rev().map(|p| p.map(|c| if c == 0.0 { -0.0 } else { c })));
    let tets: Vec<[u32; 4]> =
        TETS.iter().rev().map(|t| [5 - t[2], 5 - t[0], 5 - t[3], 5 - t[1]]).collect();
    assert_eq!(canonical_hash(&points, &tets), expected);
}

#[test]
fn every_bit_of_a_mesh_matters() {
    let expected = canonical_hash(&POINTS, &TETS);
    for k in 0..15 {
        let mut points = POINTS;
        points[k / 3][k % 3] = points[k / 3][k % 3].next_up();
        assert_ne!(canonical_hash(&points, &TETS), expected, "coordinate {k}");
    }
    assert_ne!(canonical_hash(&POINTS, &TETS[..1]), expected);
    assert_ne!(canonical_hash(&POINTS, &[TETS[0], [0, 1, 2, 4]]), expected);
    assert_ne!(canonical_hash(&[], &[]), expected);
}

#[test]
fn broken_meshes_have_none() {
    let of = |points: &[Point], tets: &[[u32; 4]]| canonical_hash(points, tets);
    assert_eq!(
        of(&POINTS, &[[0, 1, 2, 3], [0, 1, 2, 5]]),
        Err(HashError::Index { tet: 1, vertex: 5, vertices: 5 })
    );
    let mut points = POINTS;
    points[3][1] = f64::INFINITY;
    let error = of(&points, &TETS).expect_err("not finite");
    assert_eq!(error, HashError::NotFinite { vertex: 3, at: points[3] });
    points[3] = [0.0, -0.0, 0.0];
    let error = of(&points, &TETS).expect_err("equal vertices");
    assert_eq!(error, HashError::EqualVertices { first: 0, second: 3, at: [0.0; 3] });
    // Points that no tetrahedron uses may be equal.
    assert!(of(&points, &TETS[1..]).is_ok());
}
