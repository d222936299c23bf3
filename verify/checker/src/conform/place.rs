//! Places of points and facets: planes, tetrahedra, edges.

use super::facet::FlatFacet;
use super::whole::Whole;
use crate::mesh::{Mesh, Point};
use crate::predicates::{Tally, orient3d};
use num_bigint::BigInt;
use std::collections::HashMap;

/// Per facet the first one of its plane.
pub(super) fn groups(facets: &[Option<FlatFacet>], corners: &[Whole]) -> Vec<u32> {
    let mut planes: HashMap<([i128; 3], BigInt), u32> = HashMap::new();
    let group = |(f, flat): (u32, &Option<FlatFacet>)| match flat {
        Some(flat) => *planes.entry(flat.plane(corners)).or_insert(f),
        None => f,
    };
    (0u32..).zip(facets).map(group).collect()
}

/// Is `p` in the closed tetrahedron `t`?
pub(super) fn holds(mesh: &Mesh, t: usize, p: &Point) -> bool {
    let corners = mesh.tets[t].map(|v| &mesh.points[v as usize]);
    let outside = (0..3).any(|k| {
        let all = || corners.iter().map(|c| c[k]);
        all().fold(f64::INFINITY, f64::min) > p[k] || all().fold(f64::NEG_INFINITY, f64::max) < p[k]
    });
    if outside || !p.iter().all(|c| c.is_finite()) {
        return false;
    }
    let mut tally = Tally::default();
    let whole = orient3d(corners, &mut tally);
    (0..4).all(|i| {
        let mut with = corners;
        with[i] = p;
        whole * orient3d(with, &mut tally) >= 0
    })
}

/// The place of `p` along the edge from `a` to `b`, if it is on it.
pub(super) fn along(a: Whole, b: Whole, p: Whole) -> Option<i128> {
    let (d, e) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| p[k] - a[k]));
    let collinear = [(0, 1), (1, 2), (0, 2)].iter().all(|&(i, j)| d[i] * e[j] == d[j] * e[i]);
    let between = (0..3).all(|k| a[k].min(b[k]) <= p[k] && p[k] <= a[k].max(b[k]));
    let axis = (0..3).max_by_key(|&k| d[k].abs())?;
    (collinear && between).then(|| e[axis] * d[axis].signum())
}
