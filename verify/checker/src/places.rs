//! The points in the order by (x, y, z), which the structure level and the hash both need.

use crate::mesh::Point;
use crate::perturb::order;
use rayon::prelude::*;

/// The indices of the finite points, sorted by (x, y, z), then by index.
///
/// The points are sorted by x alone as integers; only runs of one x look at the rest. Cost:
/// O(V log V) time, 16 bytes of memory per point beside the result.
pub(crate) fn sorted(points: &[Point]) -> Vec<u32> {
    let mut keyed: Vec<(u64, u32)> = points
        .par_iter()
        .enumerate()
        .filter(|(_, p)| p.iter().all(|c| c.is_finite()))
        .map(|(v, p)| (ascending(p[0]), v as u32))
        .collect();
    keyed.par_sort_unstable();
    let at = |v: u32| &points[v as usize];
    keyed.par_chunk_by_mut(|a, b| a.0 == b.0).filter(|run| run.len() > 1).for_each(|run| {
        run.sort_unstable_by(|&(_, v), &(_, w)| order(at(v), at(w)).then(v.cmp(&w)));
    });
    keyed.into_iter().map(|(_, v)| v).collect()
}

/// An integer that sorts as the finite number `x` does; `-0.0` equals `0.0`.
pub(crate) fn ascending(x: f64) -> u64 {
    // Adding zero turns -0.0 into 0.0 and changes nothing else.
    let bits = (x + 0.0).to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sorted_as_the_order_has_it(points in prop::collection::vec(
            prop::array::uniform3(prop_oneof![
                any::<f64>(), Just(0.0), Just(-0.0), Just(1.0), Just(-5e-324), Just(f64::INFINITY),
            ]), 0..40,
        )) {
            let finite = |v: &u32| points[*v as usize].iter().all(|c| c.is_finite());
            let mut expected: Vec<u32> = (0..points.len() as u32).filter(finite).collect();
            // A stable sort: equal places stay in the order of their indices.
            expected.sort_by(|&v, &w| {
                points[v as usize].partial_cmp(&points[w as usize]).unwrap()
            });
            prop_assert_eq!(sorted(&points), expected);
        }
    }
}
