//! Random points, tags and meshes for the tests of the file formats.

use ltbw_core::TetMesh;
use proptest::prelude::*;

/// Any finite float: subnormals, huge ones and both zeros among them.
pub(crate) fn coordinate() -> impl Strategy<Value = f64> {
    any::<u64>().prop_map(|bits| {
        let v = f64::from_bits(bits);
        if v.is_finite() { v } else { f64::from_bits(bits & !(1 << 62)) }
    })
}

pub(crate) fn points() -> impl Strategy<Value = Vec<[f64; 3]>> {
    prop::collection::vec([coordinate(), coordinate(), coordinate()], 0..40)
}

pub(crate) fn tags(count: usize) -> impl Strategy<Value = Option<Vec<i64>>> {
    prop::option::of(prop::collection::vec(any::<i64>(), count))
}

pub(crate) fn meshes() -> impl Strategy<Value = TetMesh> {
    points().prop_flat_map(|points| {
        let n = points.len();
        let tets = match n {
            0 => Just(Vec::new()).boxed(),
            _ => prop::collection::vec(prop::array::uniform4(0..n as u32), 0..30).boxed(),
        };
        (Just(points), tags(n), tets).prop_flat_map(|(points, point_tags, tets)| {
            let count = tets.len();
            (Just(points), Just(point_tags), Just(tets), tags(count)).prop_map(
                |(points, point_tags, tets, tet_tags)| TetMesh {
                    points,
                    tets,
                    point_tags,
                    tet_tags,
                    ..TetMesh::default()
                },
            )
        })
    })
}

pub(crate) fn bits(points: &[[f64; 3]]) -> Vec<[u64; 3]> {
    points.iter().map(|p| p.map(f64::to_bits)).collect()
}

/// Tags that formats with doubles for tags can hold: 54 bits and less.
pub(crate) fn float_tags(tags: &Option<Vec<i64>>) -> Option<Vec<i64>> {
    tags.as_ref().map(|t| t.iter().map(|v| v >> 10).collect())
}
