use super::*;
use proptest::prelude::*;

/// Has an edge a smaller angle than that of a squared cosine? By the components of the other
/// edges that are perpendicular to each, in integers.
fn by_definition(corners: [[i128; 3]; 4], cos2: f64) -> bool {
    let (mantissa, exponent) = dyadic(cos2);
    PAIRS.iter().any(|&[k, l, i, j]| {
        let edge = |to: usize| [0, 1, 2].map(|x| BigInt::from(corners[to][x] - corners[i][x]));
        let dot = |p: &[BigInt; 3], q: &[BigInt; 3]| -> BigInt {
            p.iter().zip(q).map(|(x, y)| x * y).sum()
        };
        let e = edge(j);
        let ee = dot(&e, &e);
        let across = |to: usize| {
            let v = edge(to);
            let along = dot(&v, &e);
            [0, 1, 2].map(|x| &ee * &v[x] - &along * &e[x])
        };
        let (v, w) = (across(k), across(l));
        let product = dot(&v, &w);
        let left = (&product * &product) << exponent.unsigned_abs();
        product > BigInt::ZERO && left > mantissa * dot(&v, &v) * dot(&w, &w)
    })
}

/// Compares all ways to the answer, for some squared cosines around those of the angles.
fn agrees(corners: [[i128; 3]; 4], other: f64) {
    let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|k| corners[i][k] - corners[3][k]));
    let rounded = rows.map(|row| row.map(|x| x as f64));
    let near = scaled(rounded).map(|rows| Bound { cos2: 1.0 }.rounded(rows).0);
    let near = near.map_or(0.5, |cotangent| cotangent * cotangent / (1.0 + cotangent * cotangent));
    for cos2 in [near, other, 0.25, 0.5, 0.75].into_iter().filter(|c| *c > 0.0 && *c < 1.0) {
        for cos2 in [cos2.next_down(), cos2, cos2.next_up()] {
            let (bound, expected) = (Bound { cos2 }, by_definition(corners, cos2));
            assert_eq!(bound.of_whole(corners).is_below, expected, "{corners:?}, {cos2}");
            let exactly = bound.is_below_exactly(&rows.map(|row| row.map(BigInt::from)));
            assert_eq!(exactly, expected, "{corners:?}, {cos2}");
            // Coordinates of 53 bits, of any size.
            let points = corners.map(|p| p.map(|c| c as f64));
            if points.iter().zip(&corners).all(|(p, q)| (0..3).all(|k| p[k] as i128 == q[k])) {
                for scale in [1.0, 2f64.powi(-1060), 2f64.powi(960)] {
                    let [a, b, c, d] = points.map(|p| p.map(|c| c * scale));
                    let found = bound.of_points([&a, &b, &c, &d]).is_below;
                    assert_eq!(found, expected, "{corners:?} times {scale}, {cos2}");
                }
            }
        }
    }
}

fn coordinate() -> impl Strategy<Value = i128> {
    prop_oneof![
        3 => -3i128..4,
        2 => (-40i128..40).prop_map(|c| c << 40),
        1 => -(1i128 << 53)..=1 << 53,
        1 => -(1i128 << 60)..=1 << 60,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn angles_are_what_they_are_defined_to_be(
        p in proptest::array::uniform3(coordinate()), q in proptest::array::uniform3(coordinate()),
        r in proptest::array::uniform3(coordinate()), s in proptest::array::uniform3(coordinate()),
        other in 0.001f64..0.999,
    ) {
        agrees([p, q, r, s], other);
        agrees([p, q, r, std::array::from_fn(|k| q[k] + r[k] - p[k])], other);
    }

    #[test]
    fn slivers_have_small_angles(
        height in -40i128..40, shift in 0u32..50, noise in any::<[[u8; 3]; 4]>(),
    ) {
        let square = [[100, 0, height], [0, 100, 0], [-100, 0, height], [0, -100, 0]];
        let corner = |i: usize| {
            std::array::from_fn(|k| (square[i][k] << shift) + i128::from(noise[i][k] % 7) - 3)
        };
        agrees([0, 1, 2, 3].map(corner), 0.957);
    }
}

#[test]
fn degrees_become_squared_cosines() {
    let cos2 = |degrees: f64| Bound::new(degrees).cos2;
    // The double 3/4; else within some roundings.
    assert_eq!(cos2(30.0), 0.75);
    assert_eq!(cos2(90.0), 0.0);
    for tenths in 1..900 {
        let degrees = f64::from(tenths) / 10.0;
        let expected = degrees.to_radians().cos().powi(2);
        assert!((cos2(degrees) - expected).abs() < 1e-15, "{degrees}");
    }
}

/// A tetrahedron with an angle of 30 degrees, between faces with the normals (1, 1, 0) and
/// (2, 1, 1); the others are above 70.
const THIRTY: [[f64; 3]; 4] = [[0.0; 3], [2.0, -2.0, -2.0], [2.0, -2.0, 1.0], [1.0, -3.0, 1.0]];

#[test]
fn equality_is_not_below() {
    let mesh = Mesh::new(&THIRTY, &[[0, 1, 2, 3]]);
    let found = small_angles(&mesh, 30.0, 10);
    assert_eq!((found.count, found.tets.len()), (0, 0));
    let least = found.least.expect("an angle");
    assert!((least.value - 30.0).abs() < 1e-12 && least.tet == 0, "{least:?}");
    assert_eq!(small_angles(&mesh, 30.000_000_1, 10).count, 1);
    assert_eq!(small_angles(&mesh, 29.999_999_9, 10).count, 0);
    // Three edges of a cube: right angles at them, and 54.7 degrees.
    let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let edge = |cos2: f64| Bound { cos2 }.of_points(corner.each_ref()).is_below;
    assert!(edge(0.333_333_333) && !edge(0.333_333_334));
    assert!(edge(0.0), "54.7 degrees are acute");
}

#[test]
fn all_are_counted_and_some_are_listed() {
    let points = [THIRTY[0], THIRTY[1], THIRTY[2], THIRTY[3], [3.0, -5.0, 2.0]];
    // 30 degrees, a parallelogram, a point that is not there, and one twice.
    let tets = [[0, 1, 2, 3], [0, 2, 3, 4], [0, 1, 2, 9], [0, 1, 2, 2]];
    let many: Vec<[u32; 4]> = (0..40_000).map(|t| tets[t % 4]).collect();
    let found = small_angles(&Mesh::new(&points, &many), 31.0, 3);
    assert_eq!((found.count, &found.tets[..]), (30_000, &[0, 1, 3][..]));
    let least = found.least.expect("an angle");
    assert_eq!((least.value, least.tet), (0.0, 1));
    let none = small_angles(&Mesh::new(&points, &[[0, 1, 2, 9]]), 31.0, 3);
    assert_eq!((none.count, none.least), (0, None));
    let nan = [[f64::NAN; 3], points[1], points[2], points[3]];
    assert_eq!(small_angles(&Mesh::new(&nan, &[[0, 1, 2, 3]]), 90.0, 3).count, 0);
}

#[test]
fn the_least_angle_is_told_at_any_size() {
    for exponent in [-1070, -500, 0, 500, 1020] {
        let half = 2f64.powi(exponent / 2);
        let points = THIRTY.map(|p| p.map(|c| c * half * 2f64.powi(exponent - exponent / 2)));
        let found = small_angles(&Mesh::new(&points, &[[2, 1, 3, 0]]), 30.0, 3);
        assert_eq!(found.count, 0, "{exponent}");
        let least = found.least.expect("an angle").value;
        assert!((least - 30.0).abs() < 1e-12, "{exponent}: {least}");
    }
    let line = [[0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3]];
    assert_eq!(small_angles(&Mesh::new(&line, &[[0, 1, 2, 3]]), 90.0, 3).least, None);
    assert_eq!(small_angles(&Mesh::new(&line, &[[0, 0, 0, 0]]), 90.0, 3).least, None);
}
