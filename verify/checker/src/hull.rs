//! The hull's part of the levels *Delaunay* and *canonical*: the surface is convex, exactly.
//!
//! *Locally*: at every edge of the hull, the far vertex of one facet is not beyond the plane of
//! the other. Facets in one plane are allowed; then the four vertices lie on one face of the
//! hull, and the perturbation decides the diagonal if they are cocircular.
//!
//! That the fourth vertex is in the circle of the facet of the other three changes no verdict: the
//! level fails without this test, too, which names the place on the hull. For let the facets abc
//! and bcd be coplanar, on two sides of bc, and t1 to tk the tetrahedra around bc between them,
//! with the spheres S1 to Sk. The powers of a point to Si and S(i+1) are equal on the plane of
//! their common face, which goes through bc; if the apex of t(i+1) is not inside Si, then beyond
//! the face the power to Si is the larger one, or equal. The faces turn by less than π from a to d,
//! so that d is beyond each of them, and its power to S1 is at least that to Sk, which is 0. So d
//! is inside S1 only if an apex is inside the sphere beside it.
//!
//! *Globally*: a closed surface can be convex at each of its edges and yet wind around twice (a
//! fan of tetrahedra that goes around an axis twice). Let O be the centre of the first
//! tetrahedron and Q the centre of the first hull facet. Two tests exclude it (Mehlhorn et al.,
//! *Checking geometric programs or verification of geometric structures*, Comput. Geom.
//! 12:85–103, 1999): O lies strictly inside every facet's plane, and the ray from O through Q
//! meets no other facet. O and Q are not representable, but `orient3d` is affine in each point:
//! the first test needs the four vertices of the tetrahedron on the inner side and not all of
//! them on the plane; the second is exact in big integers behind a filter.

use crate::chunks::{Levels, Partial, pieces};
use crate::defect::Kind;
use crate::determinant::{det3, differences};
use crate::exact::{big, big_sign, lowest_bit};
use crate::geometry::Oriented;
use crate::mesh::{Point, Side, split};
use crate::perturb;
use crate::predicates::{orient3d, sign_beyond};
use crate::topology::HullPair;
use num_bigint::BigInt;

/// Tests every edge of the hull.
pub(crate) fn edges(
    mesh: &Oriented,
    facets: &[u32],
    pairs: &[HullPair],
    canonical: bool,
    limit: usize,
) -> Levels {
    let parts = pieces(pairs.len(), |range| {
        let mut levels = Levels::new(limit);
        for pair in &pairs[range] {
            edge(mesh, facets, pair, canonical, &mut levels);
        }
        levels
    });
    Partial::both(parts, limit)
}

fn edge(
    mesh: &Oriented,
    facets: &[u32],
    &[(g, gk), (h, hk)]: &HullPair,
    canonical: bool,
    Levels { delaunay: part, canonical: ties }: &mut Levels,
) {
    let (Side { t, i }, Side { t: u, i: j }) = (split(facets[g]), split(facets[h]));
    if mesh.sign(t) == 0 || mesh.sign(u) == 0 {
        part.untested += 1;
        ties.untested += 1;
        return;
    }
    // The sides were numbered in the given order of vertices: read the far vertices there.
    let far = |t: usize, i: usize, k: usize| crate::mesh::face(&mesh.mesh.tets[t], i)[k];
    let (p, q) = (far(t, i, gk), far(u, j, hk));
    let facet = mesh.outward(t, i);
    let [a, b, c] = facet.map(|v| mesh.at(v));
    let ids = || {
        let [x, y] = ends(facet, p);
        ([t as u32, u as u32], [x, y, p, q])
    };
    let sign = orient3d([a, b, c, mesh.at(q)], &mut part.tally);
    if sign > 0 {
        let (tets, vertices) = ids();
        part.findings.add(Kind::ConcaveHull, &tets, &vertices);
    }
    if sign != 0 {
        return;
    }
    // Coplanar: the circle of the facet lies on the sphere of its tetrahedron.
    match mesh.in_sphere(t, q, &mut part.tally) {
        1 => {
            let (tets, vertices) = ids();
            part.findings.add(Kind::NotDelaunay, &tets, &vertices);
        }
        0 if canonical => {
            let off = mesh.at(mesh.mesh.tets[t][i]);
            if perturb::side_in_plane([a, b, c], mesh.at(q), off, &mut ties.tally) > 0 {
                let (tets, vertices) = ids();
                ties.findings.add(Kind::HullNotCanonical, &tets, &vertices);
            }
        }
        _ => {}
    }
}

/// The two vertices of a facet other than `p`, in its order.
fn ends([a, b, c]: [u32; 3], p: u32) -> [u32; 2] {
    if p == a {
        [b, c]
    } else if p == b {
        [c, a]
    } else {
        [a, b]
    }
}

/// The global test; `inner` is a tetrahedron that is not flat. Presumes that hull edges pair
/// hull facets, that no tetrahedron is flat and no face folded, and convexity at every edge.
pub(crate) fn once_around(mesh: &Oriented, facets: &[u32], inner: usize, limit: usize) -> Partial {
    let mut out = Partial::new(limit);
    let Some(&first) = facets.first() else { return out };
    let outward = |code: u32| {
        let Side { t, i } = split(code);
        mesh.outward(t, i)
    };
    let corners = mesh.mesh.tets[inner].map(|v| mesh.at(v));
    let ray = Ray::new(corners, outward(first).map(|v| mesh.at(v)));
    let parts = pieces(facets.len(), |range| {
        let mut part = Partial::new(limit);
        for &code in &facets[range] {
            let facet = outward(code);
            let points = facet.map(|v| mesh.at(v));
            match ray.turned(corners, points, code == first, &mut part) {
                None => {}
                Some(Turned::Away) => {
                    part.findings.add(Kind::HullTurnedAway, &[code >> 2], &facet);
                }
                Some(Turned::Twice) => {
                    part.findings.add(Kind::HullWoundTwice, &[first >> 2, code >> 2], &facet);
                }
            }
        }
        part
    });
    parts.into_iter().for_each(|part| out.merge(part));
    out
}

/// Why a facet of the hull is not where the facets of a convex body are.
pub(crate) enum Turned {
    /// Its outer side faces the inner tetrahedron.
    Away,
    /// The ray leaves through it, too.
    Twice,
}

/// The ray from the centre O of four points through the centre Q of three.
pub(crate) struct Ray {
    origin: [Point; 4],
    target: [Point; 3],
    /// O and Q, rounded.
    rounded: (Point, Point),
    /// Upper bound of all coordinates of `origin` and `target`.
    size: f64,
}

impl Ray {
    pub(crate) fn new(origin: [&Point; 4], target: [&Point; 3]) -> Self {
        let mean = |points: &[&Point], weight: f64| {
            [0, 1, 2].map(|k| points.iter().map(|p| p[k] * weight).sum::<f64>())
        };
        let all = origin.iter().chain(&target).flat_map(|p| p.iter());
        let size = all.fold(0.0f64, |m, c| m.max(c.abs()));
        let rounded = (mean(&origin, 0.25), mean(&target, 1.0 / 3.0));
        Self { origin: origin.map(|p| *p), target: target.map(|p| *p), rounded, size }
    }

    /// Tests a facet of the hull, outward; `corners` are those of the ray's origin, and the facet
    /// may be the `first` one, through which the ray goes.
    pub(crate) fn turned(
        &self,
        corners: [&Point; 4],
        [a, b, c]: [&Point; 3],
        first: bool,
        part: &mut Partial,
    ) -> Option<Turned> {
        let signs = corners.map(|p| orient3d([a, b, c, p], &mut part.tally));
        if signs.contains(&1) || signs == [0; 4] {
            return Some(Turned::Away);
        }
        (!first && self.meets([a, b, c], part)).then_some(Turned::Twice)
    }

    /// Whether the ray meets the triangle `abc`, whose plane has O strictly inside.
    ///
    /// Then det(a - O, b - O, c - O) > 0, and by Cramer's rule Q is in the closed cone of the
    /// triangle exactly if det(a - O, b - O, Q - O) and its two rotations are not negative.
    fn meets(&self, [a, b, c]: [&Point; 3], part: &mut Partial) -> bool {
        let edges = [[a, b], [b, c], [c, a]];
        if edges.iter().any(|&edge| self.turn_rounded(edge) == Some(-1)) {
            part.tally.filter += 1;
            return false;
        }
        part.tally.exact += 1;
        edges.iter().all(|&edge| self.turn(edge) >= 0)
    }

    /// The sign of det(a - O, b - O, Q - O) if it is far from zero.
    ///
    /// All coordinates, those of O and Q too, are at most `s` in absolute value, and rounded
    /// with an absolute error below 2^-49 s (underflow apart); the differences are at most 2s
    /// with error 2^-47 s; a sum of 6 products of three such differences has an error below
    /// 6 · 3 · (2s)² · 2^-47 s plus rounding of at most 6 · γ(8) · (2s)³: together below
    /// 2^-40 s³. The bound used is 2^-36 s³; s between 1e-80 and 1e80 excludes overflow and
    /// makes every underflow negligible.
    fn turn_rounded(&self, [a, b]: [&Point; 2]) -> Option<i8> {
        let s = [a, b].iter().flat_map(|p| p.iter()).fold(self.size, |m, c| m.max(c.abs()));
        let rows = differences([a, b, &self.rounded.1], &self.rounded.0);
        if !(1e-80..1e80).contains(&s) {
            return None;
        }
        let (det, bound) = (det3(&rows), s * s * s / (1u64 << 36) as f64);
        sign_beyond(det, bound)
    }

    /// The exact sign of det(a - O, b - O, Q - O), with O and Q multiplied by 4 and 3.
    fn turn(&self, [a, b]: [&Point; 2]) -> i8 {
        let points: Vec<&Point> = self.origin.iter().chain(&self.target).chain([a, b]).collect();
        let low = lowest_bit(&points);
        let whole = |p: &Point| p.map(|c| big(c, low));
        let sum = |points: &[Point]| {
            points.iter().map(whole).fold([0, 0, 0].map(BigInt::from), |s, p| {
                let [x, y, z] = s;
                let [px, py, pz] = p;
                [x + px, y + py, z + pz]
            })
        };
        let (o, q) = (sum(&self.origin), sum(&self.target));
        let from_o = |p: &Point| {
            let p = whole(p);
            [0, 1, 2].map(|k| &p[k] * 4 - &o[k])
        };
        let ray = [0, 1, 2].map(|k| &q[k] * 4 - &o[k] * 3);
        big_sign(&det3(&[from_o(a), from_o(b), ray]))
    }
}
