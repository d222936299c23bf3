//! [`Needles`]: how many triangles of a surface have an angle that no mesh can keep to.

use crate::triangulate::sorted;
use crate::vector::{cross, distance2, dot, minus};
use crate::{Domain, Facet};
use ltbw_exact::Point;
use std::collections::HashMap;

/// The square of the cosine of 5 degrees.
const COS2: f64 = 0.992_403_876_506_104;

/// The triangles of a domain, and those of them that are needles: with an angle below 5 degrees of
/// which both sides have to be in the mesh.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Needles {
    /// Facets that are triangles.
    pub triangles: usize,
    /// The needles among them.
    pub needles: usize,
    /// The mean length of their sides.
    pub mean_side: f64,
}

/// Triangles on an edge, the first two.
#[derive(Clone, Copy, Default)]
struct Beside {
    count: usize,
    facets: [usize; 2],
}

/// The corners of a facet that is a triangle.
fn corners(facet: &Facet) -> Option<[u32; 3]> {
    match (facet.polygons.as_slice(), facet.holes.as_slice()) {
        ([polygon], []) => polygon.as_slice().try_into().ok(),
        _ => None,
    }
}

impl Needles {
    /// Counts them; sides of triangles that are coplanar within a tolerance need not be in a mesh.
    #[must_use]
    pub fn of(domain: &Domain, flat_tolerance: f64) -> Self {
        let at = |v: u32| &domain.vertices[v as usize];
        let triangles =
            || domain.facets.iter().enumerate().filter_map(|(f, t)| Some((f, corners(t)?)));
        let mut edges: HashMap<[u32; 2], Beside> = HashMap::new();
        let (mut count, mut sum) = (0_usize, 0.0);
        for (f, [a, b, c]) in triangles() {
            count += 1;
            for [v, w] in [[a, b], [b, c], [c, a]] {
                sum += distance2(at(v), at(w)).sqrt();
                let beside = edges.entry(sorted([v, w])).or_default();
                if let Some(place) = beside.facets.get_mut(beside.count) {
                    *place = f;
                }
                beside.count += 1;
            }
        }
        let is_inner = |v: u32, w: u32| {
            let Some(Beside { count: 2, facets }) = edges.get(&sorted([v, w])) else {
                return false;
            };
            let [one, other] = facets.map(|f| &domain.facets[f]);
            let both = corners(one).zip(corners(other));
            one.marker == other.marker
                && both.is_some_and(|(t, u)| {
                    is_flat(t.map(at), u.map(at), flat_tolerance)
                        && is_flat(u.map(at), t.map(at), flat_tolerance)
                })
        };
        let is_needle = |[a, b, c]: [u32; 3]| {
            let angle =
                |v, w, x| is_sharp(at(v), at(w), at(x)) && !is_inner(v, w) && !is_inner(v, x);
            angle(a, b, c) || angle(b, c, a) || angle(c, a, b)
        };
        let needles = triangles().filter(|(_, t)| is_needle(*t)).count();
        Self { triangles: count, needles, mean_side: sum / (3 * count.max(1)) as f64 }
    }
}

/// Is the angle at a point between two others below 5 degrees?
fn is_sharp(p: &Point, q: &Point, r: &Point) -> bool {
    let (u, v) = (minus(q, p), minus(r, p));
    let along = dot(&u, &v);
    along > 0.0 && along * along > COS2 * dot(&u, &u) * dot(&v, &v)
}

/// Are the corners of the second triangle within the tolerance of the first one's plane?
fn is_flat([a, b, c]: [&Point; 3], other: [&Point; 3], tolerance: f64) -> bool {
    let n = cross(&minus(b, a), &minus(c, a));
    let most = tolerance * dot(&n, &n).sqrt();
    other.iter().all(|p| dot(&n, &minus(p, a)).abs() <= most)
}

#[cfg(test)]
mod tests {
    use super::Needles;
    use crate::{Domain, Facet};

    #[test]
    fn needles_are_counted_where_both_sides_stay() {
        // A fan of twelve needles, in a plane but for a bump of 0.01 at each second one.
        let rim = |k: u32| {
            let angle = f64::from(k) * 0.05;
            [angle.cos(), angle.sin(), if k % 2 == 1 { 0.01 } else { 0.0 }]
        };
        let vertices = std::iter::once([0.0; 3]).chain((0..13).map(rim)).collect();
        let facets = (1..13).map(|k| Facet::polygon(&[0, k, k + 1], 0)).collect();
        let mut fan = Domain { vertices, facets, ..Domain::default() };
        let found = |fan: &Domain, tolerance: f64| {
            let found = Needles::of(fan, tolerance);
            assert_eq!(found.triangles, 12);
            assert!(found.mean_side > 0.6 && found.mean_side < 0.7, "{}", found.mean_side);
            found.needles
        };
        assert_eq!(found(&fan, 0.0), 12);
        assert_eq!(found(&fan, 0.03), 0);
        // Markers part what is flat: the first three, and then two by two, each with a drawn side.
        fan.facets[1].marker = 1;
        assert_eq!(found(&fan, 0.03), 2, "the first, and the one with a marker");
    }
}
