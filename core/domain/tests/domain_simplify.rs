//! Surfaces that are simplified: within the tolerance, with the topology that they had, the same
//! for every order of facets.

use ltbw_domain::{Domain, Facet, PrepareError, PrepareOptions, Prepared, Simplified};
use ltbw_exact::Point;
use ltbw_generate::{Random, surfaces};
use std::collections::{BTreeMap, BTreeSet};

fn prepared(domain: &Domain, simplify: f64, oriented: bool) -> Prepared {
    domain.prepare(&PrepareOptions { simplify, oriented, ..PrepareOptions::default() }).unwrap()
}

/// Both, without and with simplification.
fn both(domain: &Domain, tolerance: f64, oriented: bool) -> (Prepared, Prepared, Simplified) {
    let (before, after) = (prepared(domain, 0.0, oriented), prepared(domain, tolerance, oriented));
    assert!(before.simplified.is_none());
    let told = after.simplified.unwrap();
    assert!(told.distance() <= tolerance, "{told:?}");
    assert_eq!(told.removed, before.domain.vertices.len() - after.domain.vertices.len());
    (before, after, told)
}

/// A triangle by the places of its corners.
type Corners = [Point; 3];

fn triangles(domain: &Domain) -> Vec<Corners> {
    let triangles =
        (0..domain.facets.len() as u32).flat_map(|f| domain.triangulate(f).unwrap().triangles);
    triangles.map(|t| t.map(|v| domain.vertices[v as usize])).collect()
}

fn minus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The distance of a point from a triangle, by the case where its foot is (Ericson).
fn distance(p: Point, [a, b, c]: Corners) -> f64 {
    let (ab, ac, ap) = (minus(b, a), minus(c, a), minus(p, a));
    let (bb, bc, cc, pb, pc) = (dot(ab, ab), dot(ab, ac), dot(ac, ac), dot(ap, ab), dot(ap, ac));
    let all = bb * cc - bc * bc;
    let (v, w) = ((cc * pb - bc * pc) / all, (bb * pc - bc * pb) / all);
    let at = |v: f64, w: f64| [0, 1, 2].map(|k| a[k] + v * ab[k] + w * ac[k]);
    let far = |q: Point| dot(minus(p, q), minus(p, q)).sqrt();
    if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
        return far(at(v, w));
    }
    let on = |from: Point, to: Point| {
        let along = minus(to, from);
        let s = (dot(minus(p, from), along) / dot(along, along)).clamp(0.0, 1.0);
        far([0, 1, 2].map(|k| from[k] + s * along[k]))
    };
    on(a, b).min(on(b, c)).min(on(c, a))
}

/// The solid angle of a triangle from a point (Van Oosterom and Strackee).
fn solid_angle(p: Point, corners: Corners) -> f64 {
    let [a, b, c] = corners.map(|q| minus(q, p));
    let [la, lb, lc] = [a, b, c].map(|v| dot(v, v).sqrt());
    let volume = a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0]);
    2.0 * volume.atan2(la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
}

/// The farthest that some points of a surface are from another.
fn farthest(from: &[Corners], other: &[Corners]) -> f64 {
    let mut random = Random::new(7);
    let mut most = 0.0_f64;
    for &[a, b, c] in from {
        for _ in 0..8 {
            let (mut v, mut w) = (random.unit(), random.unit());
            if v + w > 1.0 {
                (v, w) = (1.0 - v, 1.0 - w);
            }
            let p = [0, 1, 2].map(|k| a[k] + v * (b[k] - a[k]) + w * (c[k] - a[k]));
            most = most.max(other.iter().map(|&t| distance(p, t)).fold(f64::INFINITY, f64::min));
        }
    }
    most
}

/// Facets as sets of places, with their markers.
fn facets(domain: &Domain) -> BTreeSet<(Vec<[u64; 3]>, i32)> {
    let place = |v: &u32| domain.vertices[*v as usize].map(f64::to_bits);
    let facet = |f: &Facet| {
        let mut corners: Vec<_> = f.polygons.iter().flatten().map(place).collect();
        corners.sort_unstable();
        (corners, f.marker)
    };
    domain.facets.iter().map(facet).collect()
}

#[test]
fn the_stated_distance_bounds_that_of_points_of_either_surface() {
    for (domain, tolerance) in [
        (surfaces::globe(20, 30, 0.02, 3), 0.05),
        (surfaces::torus(20), 0.02),
        (surfaces::globe(12, 40, 0.0, 1), 0.01),
    ] {
        let (before, after, told) = both(&domain, tolerance, true);
        let (first, last) = (triangles(&before.domain), triangles(&after.domain));
        assert_eq!(told.triangles, [first.len(), last.len()]);
        assert!(3 * last.len() < 2 * first.len(), "{told:?}");
        let (there, back) = (farthest(&first, &last), farthest(&last, &first));
        assert!(there <= told.from_before && back <= told.from_after, "{there} {back} {told:?}");
        // The bounds are of the size of what they bound.
        assert!(told.distance() < 6.0 * there.max(back), "{there} {back} {told:?}");
        let places: BTreeSet<_> =
            before.domain.vertices.iter().map(|p| p.map(f64::to_bits)).collect();
        assert!(after.domain.vertices.iter().all(|p| places.contains(&p.map(f64::to_bits))));
        let numbers = |ready: &Prepared, v: usize| {
            ready.domain.vertices.get(ready.vertex_map[v] as usize).copied()
        };
        for v in 0..domain.vertices.len() {
            let left = numbers(&after, v);
            assert!(left.is_none() || left == numbers(&before, v));
        }
    }
}

#[test]
fn the_order_of_facets_and_vertices_does_not_matter() {
    let domain = surfaces::globe(14, 20, 0.03, 5);
    let (_, plain, told) = both(&domain, 0.06, true);
    let mut random = Random::new(1);
    let count = domain.vertices.len();
    let mut order: Vec<usize> = (0..count).collect();
    (1..count).for_each(|k| order.swap(k, random.below(k as u64 + 1) as usize));
    let mut other = Domain { vertices: vec![[0.0; 3]; count], ..domain.clone() };
    order.iter().zip(&domain.vertices).for_each(|(&place, p)| other.vertices[place] = *p);
    other.facets.reverse();
    for (k, facet) in other.facets.iter_mut().enumerate() {
        facet.polygons[0].iter_mut().for_each(|v| *v = order[*v as usize] as u32);
        facet.polygons[0].rotate_left(k % 3);
    }
    let (_, shuffled, again) = both(&other, 0.06, true);
    assert_eq!((facets(&plain.domain), told), (facets(&shuffled.domain), again));
}

/// A cube of n³ squares a side, each in two triangles; markers by sides.
fn fine_cube(n: u32) -> Domain {
    let mut numbers: BTreeMap<[u32; 3], u32> = BTreeMap::new();
    let mut domain = Domain::default();
    for axis in 0..3 {
        for end in [0, n] {
            for k in 0..n * n {
                let corner = |i: u32, j: u32| {
                    let mut place = [0; 3];
                    place[axis] = end;
                    place[(axis + 1) % 3] = k / n + i;
                    place[(axis + 2) % 3] = k % n + j;
                    place
                };
                let mut square = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if end == 0 {
                    square.reverse();
                }
                let square = square.map(|place| {
                    *numbers.entry(place).or_insert_with(|| {
                        domain.vertices.push(place.map(f64::from));
                        domain.vertices.len() as u32 - 1
                    })
                });
                for t in [[0, 1, 2], [0, 2, 3]] {
                    domain.facets.push(Facet::polygon(&t.map(|k| square[k]), axis as i32));
                }
            }
        }
    }
    domain
}

#[test]
fn flat_sides_lose_their_vertices_and_sharp_edges_stay() {
    for tolerance in [1e-6, 0.3] {
        let (_, after, told) = both(&fine_cube(8), tolerance, true);
        assert!(told.triangles[1] < 100 && told.distance() < 1e-9, "{told:?}");
        assert_eq!(after.report.volume().unwrap().to_f64(), 512.0);
        for corner in 0..8 {
            let corner = [0, 1, 2].map(|k| if corner >> k & 1 == 1 { 8.0 } else { 0.0 });
            assert!(after.domain.vertices.contains(&corner));
        }
    }
}

#[test]
fn borders_of_markers_stay_where_they_are() {
    let mut domain = surfaces::globe(20, 24, 0.0, 1);
    for facet in &mut domain.facets {
        let high =
            facet.polygons[0].iter().filter(|&&v| domain.vertices[v as usize][2] > 0.01).count();
        facet.marker = i32::from(high > 0);
    }
    let border = |domain: &Domain| {
        let mut sides: BTreeMap<[u32; 2], BTreeSet<i32>> = BTreeMap::new();
        for f in &domain.facets {
            let t = &f.polygons[0];
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                sides.entry([a.min(b), a.max(b)]).or_default().insert(f.marker);
            }
        }
        let drawn = sides.into_iter().filter(|(_, markers)| markers.len() > 1);
        drawn.flat_map(|(ends, _)| ends).map(|v| domain.vertices[v as usize]).collect::<Vec<_>>()
    };
    let (before, after, _) = both(&domain, 0.05, true);
    let (first, last) = (border(&before.domain), border(&after.domain));
    assert!(!last.is_empty() && last.len() < first.len(), "{} {}", last.len(), first.len());
    assert!(last.iter().all(|p| first.contains(p)));
}

#[test]
fn surfaces_nearer_than_the_tolerance_do_not_cross() {
    // A shell thinner than the tolerance.
    let ball = surfaces::globe(16, 24, 0.0, 1);
    let inner = surfaces::map_points(&ball, |p| p.map(|c| 0.99 * c));
    let cells = |ready: &Prepared| {
        let mut volumes: Vec<f64> =
            ready.report.cells.iter().flatten().map(|c| c.volume.to_f64()).collect();
        volumes.sort_by(f64::total_cmp);
        volumes
    };
    let (before, after, told) = both(&ball.clone().join(inner), 0.02, false);
    assert_eq!((cells(&before).len(), cells(&after).len()), (2, 2));
    assert!(told.removed > 50, "{told:?}");
}

/// A cube of side 4 with a tent of four triangles on it, lower than the tolerance of 0.3.
fn tent() -> Domain {
    let mut domain = Domain::cuboid([0.0; 3], [4.0; 3]);
    domain.facets.retain(|f| f.marker != 6);
    domain.vertices.push(TOP);
    let sides = [[4, 5], [5, 7], [7, 6], [6, 4]];
    domain.facets.extend(sides.map(|[a, b]| Facet::polygon(&[a, b, 8], 6)));
    let fans = domain.facets.iter().flat_map(|f| {
        let p = &f.polygons[0];
        (1..p.len() - 1).map(|k| Facet::polygon(&[p[0], p[k], p[k + 1]], f.marker))
    });
    domain.facets = fans.collect();
    domain
}

const TOP: Point = [2.0, 2.0, 4.25];

#[test]
fn no_body_and_no_seed_is_passed() {
    let (_, flat, _) = both(&tent(), 0.3, false);
    assert_eq!(flat.domain.vertices.len(), 8);
    // A seed in the tent, which touches no triangle before or after.
    let seed = [2.0, 2.0, 4.125];
    let region = ltbw_domain::Region { seed, attribute: 7.0, max_volume: None };
    let (_, after, _) = both(&Domain { regions: vec![region], ..tent() }, 0.3, false);
    assert_eq!(after.report.cells.as_ref().unwrap()[0].regions, [0]);
    // A body in its place.
    let far = 1.0 / 64.0;
    let corners = [[0.0; 3], [far, 0.0, 0.0], [0.0, far, 0.0], [0.0, 0.0, far]];
    let vertices = corners.map(|p| [0, 1, 2].map(|k| p[k] + seed[k])).to_vec();
    let sides = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let facets = sides.iter().map(|t| Facet::polygon(t, 9)).collect();
    let mote = Domain { vertices, facets, ..Domain::default() };
    let (_, after, _) = both(&tent().join(mote), 0.3, false);
    let corners: Vec<Corners> = triangles(&after.domain);
    let is_mote = |t: &&Corners| t.iter().all(|p| dot(minus(*p, seed), minus(*p, seed)) < 0.01);
    let (mote, others): (Vec<&Corners>, Vec<&Corners>) = corners.iter().partition(is_mote);
    assert_eq!(mote.len(), 4);
    for p in mote.into_iter().flatten() {
        let turns =
            others.iter().map(|t| solid_angle(*p, **t)).sum::<f64>() / (4.0 * std::f64::consts::PI);
        assert!((turns.abs() - 1.0).abs() < 1e-6, "{turns}");
    }
}

#[test]
fn seeds_stay_in_their_cells_and_segments_stay() {
    let ball = surfaces::globe(16, 24, 0.0, 1);
    let near = ltbw_domain::Region { seed: [0.0, 0.0, 0.4985], attribute: 7.0, max_volume: None };
    let center = ball.vertices.len() as u32;
    let mut domain = Domain { regions: vec![near], ..ball };
    domain.vertices.extend([[0.0; 3], [0.0, 0.0, 0.495]]);
    domain.segments = vec![([center, center + 1], 5)];
    let (_, after, told) = both(&domain, 0.025, false);
    assert!(told.removed > 50, "{told:?}");
    assert_eq!(after.report.cells.as_ref().unwrap()[0].regions, [0]);
    let (ends, marker) = after.domain.segments[0];
    let ends = ends.map(|v| after.domain.vertices[v as usize][2]);
    assert!(ends[0] == 0.0 && (ends[1] - 0.495).abs() < 1e-6 && marker == 5);
}

#[test]
fn sheets_keep_their_borders_and_polygons_of_a_domain_stay() {
    // Three pages on one spine, each of many triangles.
    let mut pages = Domain::default();
    let mut numbers: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    for page in 0..3 {
        let angle = 2.0 * f64::from(page);
        for k in 0..36_u32 {
            let corner = |i: u32, j: u32| {
                let r = f64::from(k / 6 + i) / 8.0;
                [r * angle.cos(), r * angle.sin(), f64::from(k % 6 + j) / 8.0 - 0.4]
            };
            for t in [
                [corner(0, 0), corner(1, 0), corner(1, 1)],
                [corner(0, 0), corner(1, 1), corner(0, 1)],
            ] {
                let t = t.map(|p| {
                    let key = p.map(|c| ((c * 1e6).round() + 0.0).to_bits());
                    *numbers.entry(key).or_insert_with(|| {
                        pages.vertices.push(p);
                        pages.vertices.len() as u32 - 1
                    })
                });
                pages.facets.push(Facet::polygon(&t, 0));
            }
        }
    }
    let domain = Domain::cuboid([-1.0; 3], [1.0; 3]).join(pages);
    let (before, after, told) = both(&domain, 1e-4, false);
    assert!(told.triangles[0] == 216 && told.triangles[1] < 60, "{told:?}");
    assert_eq!(after.domain.facets.iter().filter(|f| f.polygons[0].len() == 4).count(), 6);
    let area = |domain: &Domain| {
        let twice = |[a, b, c]: &Corners| {
            let (u, v) = (minus(*b, *a), minus(*c, *a));
            (dot(u, u) * dot(v, v) - dot(u, v) * dot(u, v)).sqrt()
        };
        triangles(domain).iter().map(twice).sum::<f64>()
    };
    assert!((area(&before.domain) - area(&after.domain)).abs() < 1e-3);
}

#[test]
fn tolerances_that_make_no_sense_are_refused() {
    let ball = surfaces::globe(6, 8, 0.0, 1);
    for simplify in [f64::NAN, -1e-9, 0.051 * ball.diagonal(), f64::INFINITY] {
        let refused = ball.prepare(&PrepareOptions { simplify, ..PrepareOptions::default() });
        let error = refused.unwrap_err();
        assert!(matches!(error, PrepareError::Simplify { .. }), "{error}");
        assert_eq!(error.code(), "domain.simplify");
    }
}

/// The facet that a point is on may be gone afterwards.
#[test]
fn points_are_not_given_in_a_surface_that_is_simplified() {
    let mut ball = surfaces::globe(6, 8, 0.0, 1);
    ball.points.push([0.0; 3]);
    let options = PrepareOptions { simplify: 1e-3, ..PrepareOptions::default() };
    let error = ball.prepare(&options).unwrap_err();
    assert_eq!(error, PrepareError::SimplifyPoints { count: 1 });
    assert_eq!(error.code(), "domain.simplify-points");
    // A vertex on the surface that nothing names is no vertex of the simpler one.
    ball.points.clear();
    let without = prepared(&ball, 1e-3, false);
    let corners = triangles(&ball)[0];
    let spare = ball.vertices.len();
    ball.vertices.push([0, 1, 2].map(|k| (corners[0][k] + corners[1][k]) / 2.0));
    let with = prepared(&ball, 1e-3, false);
    assert_eq!(with.domain, without.domain);
    assert_eq!(with.vertex_map[spare], ltbw_domain::exterior::LEFT_OUT);
}
