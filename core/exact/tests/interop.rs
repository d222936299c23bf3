//! Points and `nalgebra`'s, there and back.
#![cfg(feature = "nalgebra")]

use ltbw_exact::interop::{from_nalgebra, to_nalgebra};
use ltbw_exact::{PointError, PointSet};
use nalgebra::Point3;

#[test]
fn points_survive_bit_for_bit() {
    let points = vec![[0.1, 0.2, 0.1 + 0.2], [-0.0, 5e-324, f64::MAX], [f64::MIN, 1e-308, -1.0]];
    let there = to_nalgebra(&points);
    assert_eq!(there[1], Point3::from(points[1]));
    let bits = |points: &[[f64; 3]]| -> Vec<[u64; 3]> {
        points.iter().map(|p| p.map(f64::to_bits)).collect()
    };
    assert_eq!(bits(&from_nalgebra(&there)), bits(&points));
}

#[test]
fn a_point_set_is_made_and_validated() {
    let points: Vec<[f64; 3]> = (0..50).map(|i| [f64::from(i), f64::from(i * i), 0.5]).collect();
    let set = PointSet::try_from(&to_nalgebra(&points)[..]).expect("finite points");
    assert_eq!(set, PointSet::new(points).expect("finite points"));
    let error = PointSet::try_from(&[Point3::new(1.0, 2.0, f64::INFINITY)][..]);
    assert_eq!(error, Err(PointError::NotFinite { index: 0, axis: 'z', value: f64::INFINITY }));
}
