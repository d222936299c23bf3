//! Features that come so near to each other that a mesh with bounds would need too many points:
//! their distance is below 16 floors, and they are 256 times as wide as that or more; or it is
//! below 512 floors, and they are 512 times as wide.
//!
//! Between two such facets every tetrahedron is either flat or tiny. As with small angles, vertices
//! of one then do not encroach items of the other that the mesh has, and what is over its bounds
//! between them is excused by name.
//!
//! Distances are computed in `f64`: they choose how hard to try, never what is true of the result.

use super::plc::{Facet, Plc};
use super::ring::Ring;
use crate::RefineError;
use crate::heed::Heed;
use ltbw_domain::vector::{cross, distance2, dominant, dot, minus};
use ltbw_exact::Point;
use rstar::primitives::GeomWithData;
use rstar::{AABB, Envelope, RTree, RTreeObject};
use std::cell::OnceCell;

/// The least ratio of the features' width to their distance.
const WIDE: f64 = 256.0;

/// The least ratio of width to distance at up to `FAR` times the distance.
const WIDER: f64 = 512.0;
const FAR: f64 = 32.0;

/// Is a distance small for features of this width?
fn is_small(distance: f64, limit: f64, width: f64) -> bool {
    let nearer = distance < limit && distance * WIDE < width;
    nearer || distance < FAR * limit && distance * WIDER < width
}

/// A distance that is not small for features of this width, even if it is rounded or from a plane
/// and not along an axis: features far smaller than the limit are not looked for all around.
fn farthest(limit: f64, width: f64) -> f64 {
    (FAR * limit).min(2.0 * width / WIDE)
}

/// Two features near each other; ids are those of the complex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pair {
    /// A corner and a facet.
    CornerFacet(u32, u32),
    /// Two segments.
    Segments(u32, u32),
}

/// A box in the tree, and what is in it.
type Boxed = GeomWithData<rstar::primitives::Rectangle<Point>, u32>;

fn boxed(points: impl Iterator<Item = Point>, id: u32) -> Option<Boxed> {
    let ends = points.fold(None, |ends: Option<(Point, Point)>, p| {
        let (low, high) = ends.unwrap_or((p, p));
        Some(([0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k]))))
    });
    ends.map(|(low, high)| GeomWithData::new(AABB::from_corners(low, high).into(), id))
}

/// A box, larger by `by` on all sides.
fn grown(envelope: &AABB<Point>, by: f64) -> AABB<Point> {
    let (low, high) = (envelope.lower().map(|c| c - by), envelope.upper().map(|c| c + by));
    AABB::from_corners(low, high)
}

/// The largest side of a box.
fn side(envelope: &AABB<Point>) -> f64 {
    let (low, high) = (envelope.lower(), envelope.upper());
    (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max)
}

fn at(plc: &Plc, corner: u32) -> Point {
    plc.corners[corner as usize].map(|c| c as f64)
}

/// The facets of a complex by their polygons.
struct Polygons<'p> {
    plc: &'p Plc,
    /// Facet and corners of each.
    all: Vec<(u32, &'p Vec<u32>)>,
    /// Where each lies in its facet's plane.
    tree: RTree<Boxed>,
    /// The box of each facet.
    boxes: Vec<Option<AABB<Point>>>,
    /// Outlines in the projection along the largest entry of the facet's normal, of those that were
    /// asked for.
    rings: Vec<OnceCell<Ring>>,
}

/// The axis along which a facet is projected, and the two others.
fn axes_of(facet: &Facet) -> [usize; 3] {
    let axis = dominant(&facet.plane.normal());
    [axis, (axis + 1) % 3, (axis + 2) % 3]
}

impl<'p> Polygons<'p> {
    fn new(plc: &'p Plc) -> Self {
        let own = |facet: &'p Facet| facet.parts.iter().flat_map(|part| &part.polygons);
        let facets = || (0..).zip(&plc.facets);
        let all: Vec<(u32, &Vec<u32>)> =
            facets().flat_map(|(f, facet)| own(facet).map(move |polygon| (f, polygon))).collect();
        let lying = |(k, (f, polygon)): (u32, &(u32, &'p Vec<u32>))| {
            let facet = &plc.facets[*f as usize];
            let (n, [axis, x, y]) = (facet.plane.normal(), axes_of(facet));
            let first = at(plc, *facet.corners.first()?);
            // Corners of a patch are beside its plane: what is over the polygon is between those of
            // the plane that are over them, and a step more for rounding.
            let ends = polygon.iter().flat_map(|&v| {
                let p = at(plc, v);
                let level =
                    first[axis] - (n[x] * (p[x] - first[x]) + n[y] * (p[y] - first[y])) / n[axis];
                [-1.0, 1.0].map(|step| {
                    let mut end = p;
                    end[axis] = level + step;
                    end
                })
            });
            boxed(ends, k)
        };
        let tree = RTree::bulk_load((0..).zip(&all).filter_map(lying).collect());
        let envelope = |facet: &Facet| {
            boxed(facet.corners.iter().map(|&v| at(plc, v)), 0).map(|b| b.envelope())
        };
        let rings = all.iter().map(|_| OnceCell::new()).collect();
        Self { plc, all, tree, boxes: plc.facets.iter().map(envelope).collect(), rings }
    }

    /// Is a point over a polygon of facet `f`, in the projection?
    fn is_over(&self, k: u32, corner: u32) -> bool {
        let (f, polygon) = self.all[k as usize];
        let [_, x, y] = axes_of(&self.plc.facets[f as usize]);
        let flat = |v: u32| [x, y].map(|axis| self.plc.corners[v as usize][axis]);
        let ring = || Ring::new(polygon.iter().map(|&v| flat(v)).collect());
        self.rings[k as usize].get_or_init(ring).encloses(flat(corner))
    }

    /// The facets near a corner that is not on them (holes are not looked at); returns the number
    /// of polygons that were looked at.
    fn near_corner(&self, corner: u32, limit: f64, found: &mut Vec<Pair>) -> u64 {
        let mut facets = Vec::new();
        let (plc, p) = (self.plc, at(self.plc, corner));
        let own = &plc.facets_at[corner as usize];
        // The width at the corner is that of its widest segment.
        let lengths = plc.segments_at[corner as usize].iter().map(|&s| {
            let [a, b] = plc.segments[s as usize].ends.map(|v| at(plc, v));
            distance2(&a, &b).sqrt()
        });
        let width = lengths.fold(0.0, f64::max);
        let far = farthest(limit, width);
        let reach = grown(&AABB::from_point(p), far);
        // The distance along an axis is less than twice that from the plane.
        let near = grown(&AABB::from_point(p), 2.0 * far);
        let mut steps = 0;
        for polygon in self.tree.locate_in_envelope_intersecting(near) {
            steps += 1;
            let g = self.all[polygon.data as usize].0;
            let facet = &plc.facets[g as usize];
            let Some(bounds) = self.boxes[g as usize] else { continue };
            if own.binary_search(&g).is_ok() || !reach.intersects(&bounds) {
                continue;
            }
            let distance = plane_distance(plc, &p, facet);
            let is_near = distance.is_some_and(|d| is_small(d, limit, width.min(side(&bounds))));
            if is_near && self.is_over(polygon.data, corner) {
                facets.push(g);
            }
        }
        facets.sort_unstable();
        facets.dedup();
        found.extend(facets.into_iter().map(|g| Pair::CornerFacet(corner, g)));
        steps
    }
}

impl Pair {
    fn key(&self) -> (u32, u32, u32) {
        match *self {
            Pair::CornerFacet(v, f) => (0, v, f),
            Pair::Segments(s, r) => (1, s, r),
        }
    }
}

/// The pairs of features of a complex that are wide and nearer to each other than `limit`, in steps
/// of the grid, and do not meet.
///
/// # Errors
/// [`RefineError::Cancelled`].
pub(crate) fn pairs(plc: &Plc, limit: f64, heed: Heed<'_>) -> Result<Vec<Pair>, RefineError> {
    Ok(counted_pairs(plc, limit, heed)?.0)
}

/// The pairs, and the number of polygons and segments that were looked at.
fn counted_pairs(plc: &Plc, limit: f64, heed: Heed<'_>) -> Result<(Vec<Pair>, u64), RefineError> {
    let (mut found, mut steps) = (Vec::new(), 0);
    let polygons = Polygons::new(plc);
    for corner in 0..plc.corners.len() as u32 {
        heed.ask()?;
        steps += polygons.near_corner(corner, limit, &mut found);
    }
    let segment = |(s, segment): (u32, &super::plc::Segment)| {
        boxed(segment.ends.iter().map(|&v| at(plc, v)), s)
    };
    let segments = RTree::bulk_load((0..).zip(&plc.segments).filter_map(segment).collect());
    for one in &segments {
        heed.ask()?;
        let far = farthest(limit, side(&one.envelope()));
        for other in segments.locate_in_envelope_intersecting(grown(&one.envelope(), far)) {
            steps += 1;
            let (s, r) = (one.data, other.data);
            if s >= r {
                continue;
            }
            let wide = side(&one.envelope()).min(side(&other.envelope()));
            let distance = segment_distance(plc, s, r);
            if distance.is_some_and(|d| is_small(d, limit, wide)) {
                found.push(Pair::Segments(s, r));
            }
        }
    }
    found.sort_unstable_by_key(Pair::key);
    Ok((found, steps))
}

/// The distance of a point from a facet's plane.
fn plane_distance(plc: &Plc, p: &Point, facet: &Facet) -> Option<f64> {
    let n = facet.plane.normal();
    let first = at(plc, *facet.corners.first()?);
    Some(dot(&n, &minus(p, &first)).abs() / dot(&n, &n).sqrt())
}

/// The distance of two segments that have no corner in common, if it is between points inside both.
fn segment_distance(plc: &Plc, s: u32, r: u32) -> Option<f64> {
    let (s, r) = (&plc.segments[s as usize], &plc.segments[r as usize]);
    if s.ends.iter().any(|v| r.ends.contains(v)) {
        return None;
    }
    let [a, b, c, d] = [s.ends[0], s.ends[1], r.ends[0], r.ends[1]].map(|v| at(plc, v));
    let (u, v, w) = (minus(&b, &a), minus(&d, &c), minus(&c, &a));
    let n = cross(&u, &v);
    let square = dot(&n, &n);
    if square <= 1e-12 * dot(&u, &u) * dot(&v, &v) {
        return parallel_distance(&a, &u, [&c, &d]);
    }
    let (i, j) = (dot(&cross(&w, &v), &n) / square, dot(&cross(&w, &u), &n) / square);
    let inside = |t: f64| (0.0..=1.0).contains(&t);
    (inside(i) && inside(j)).then(|| dot(&w, &n).abs() / square.sqrt())
}

/// The distance of a segment from `a` along `u` from a parallel one, if they are beside each other.
fn parallel_distance(a: &Point, u: &Point, others: [&Point; 2]) -> Option<f64> {
    let square = dot(u, u);
    let [i, j] = others.map(|p| dot(&minus(p, a), u) / square);
    let beside = i.max(j) > 0.0 && i.min(j) < 1.0;
    let n = cross(&minus(others[0], a), u);
    beside.then(|| (dot(&n, &n) / square).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltbw_domain::{Domain, Facet as Polygon};

    fn complex(vertices: &[Point], facets: &[&[u32]]) -> Plc {
        let mut domain = Domain { vertices: vertices.to_vec(), ..Domain::default() };
        domain.facets.extend(facets.iter().map(|f| Polygon::polygon(f, 0)));
        let snapped = domain.snap().expect("a lattice");
        Plc::new(&snapped.domain, &snapped.lattice).expect("a complex")
    }

    fn pairs_of(plc: &Plc) -> Vec<Pair> {
        pairs(plc, 1e-5 * ONE, Heed::default()).expect("nobody cancels")
    }

    /// The number of steps of the grid in a length of 1, where the largest coordinate is 1.
    const ONE: f64 = (1 << 26) as f64;

    #[test]
    fn corners_over_a_facet_are_near_it_and_others_are_not() {
        let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        // A triangle at a height with a corner over the square, two beside it.
        let at = |h: f64| [[0.5, 0.5, h], [-0.5, 0.25, h], [-0.5, 0.75, h]];
        for (height, near) in [(1e-6, true), (1e-4, true), (1e-3, false)] {
            let vertices = [&square[..], &at(height)].concat();
            let plc = complex(&vertices, &[&[0, 1, 2, 3], &[4, 5, 6]]);
            let pairs = pairs_of(&plc);
            assert_eq!(pairs.contains(&Pair::CornerFacet(4, 0)), near, "{pairs:?}");
            // Two sides of the triangle cross the square's side x = 0, at the height.
            let crossing = pairs.iter().filter(|p| matches!(p, Pair::Segments(..))).count();
            assert_eq!((pairs.len(), crossing), if near { (3, 2) } else { (0, 0) }, "{pairs:?}");
        }
    }

    #[test]
    fn small_features_are_not_wide() {
        let small = |c: f64| 0.5 + c * 1e-6;
        let corner = |x: f64, y: f64, z: f64| [small(x), small(y), small(z)];
        let vertices = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            corner(0.0, 0.0, 1.0),
            corner(1.0, 0.0, 1.0),
            corner(0.0, 1.0, 1.0),
            corner(0.0, 0.0, 2.0),
            corner(1.0, 0.0, 2.0),
            corner(0.0, 1.0, 2.0),
        ];
        let plc = complex(&vertices, &[&[0, 1, 2], &[3, 4, 5], &[6, 7, 8]]);
        assert_eq!(pairs_of(&plc), []);
    }

    #[test]
    fn parallel_segments_are_near_where_they_are_beside_each_other() {
        let strip = |y: f64, x: f64| [[x, y, 0.0], [x + 0.25, y, 0.0], [x, y, 0.5]];
        for (x, near) in [(0.1, true), (0.6, false)] {
            let vertices = [strip(0.0, 0.0), strip(1e-6, x)].concat();
            let plc = complex(&vertices, &[&[0, 1, 2], &[3, 4, 5]]);
            let pairs = pairs_of(&plc);
            assert_eq!(pairs.iter().any(|p| matches!(p, Pair::Segments(..))), near, "{pairs:?}");
        }
    }

    #[test]
    fn each_corner_of_many_takes_few_steps() {
        let each = [1 << 8, 1 << 13].map(|teeth: u32| {
            let mut vertices: Vec<Point> = Vec::new();
            for k in 0..teeth {
                let x = f64::from(2 * k);
                let corners = [[x, 0.0, 0.0], [x, 1.0, 0.0], [x + 1.0, 1.0, 0.0]];
                vertices.extend(corners);
                vertices.push([x + 1.0, 0.0, 0.0]);
            }
            let end = f64::from(2 * teeth);
            vertices.extend([[end, 0.0, 0.0], [end, -1.0, 0.0], [0.0, -1.0, 0.0]]);
            let corners: Vec<u32> = (0..vertices.len() as u32).collect();
            let plc = complex(&vertices, &[&corners]);
            let (pairs, steps) =
                counted_pairs(&plc, 1e-4 * ONE, Heed::default()).expect("nobody cancels");
            assert_eq!(pairs, []);
            steps as f64 / f64::from(teeth)
        });
        assert!(each[1] < 1.1 * each[0], "{each:?}");
    }
}
