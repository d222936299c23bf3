//! Tests of the parting: that it is cheap, and that it parts nothing that meets.

use super::*;
use crate::check::{DomainReport, Findings, pairs};
use crate::{CheckOptions, DefectKind, Domain, Facet};
use proptest::prelude::*;

/// The outline of a comb on a back as high as the teeth are wide.
fn comb_ring(teeth: u32, length: f64) -> Vec<[f64; 2]> {
    let mut ring = Vec::new();
    for k in 0..teeth {
        let corners = [[0, 0], [0, 1], [1, 1], [1, 0]];
        ring.extend(corners.map(|[x, y]| [f64::from(2 * k + x), f64::from(y) * length]));
    }
    let end = f64::from(2 * teeth);
    ring.extend([[end, 0.0], [end, -1.0], [0.0, -1.0]]);
    ring
}

/// The prism over an outline: two facets of very many corners, whose triangles run along all of
/// them, and narrow ones between.
fn prism(ring: &[[f64; 2]]) -> Domain {
    let mut domain = Domain::default();
    let count = ring.len() as u32;
    for z in [0.0, 1.0] {
        domain.vertices.extend(ring.iter().map(|&[x, y]| [x, y, z]));
    }
    let front: Vec<u32> = (0..count).collect();
    let back: Vec<u32> = (count..2 * count).collect();
    domain.facets = vec![Facet::polygon(&front, 0), Facet::polygon(&back, 0)];
    domain.facets.extend((0..count).map(|k| {
        let next = (k + 1) % count;
        Facet::polygon(&[k, next, next + count, k + count], 0)
    }));
    domain
}

/// A comb with teeth of length 1.
fn comb(teeth: u32) -> Domain {
    prism(&comb_ring(teeth, 1.0))
}

/// A comb with long teeth.
fn tall_comb(teeth: u32) -> Domain {
    prism(&comb_ring(teeth, 8.0))
}

/// A strip wound around its beginning, of this many pieces.
fn spiral(arms: u32) -> Domain {
    let way = |k: u32| [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][k as usize % 4];
    let mut outer = vec![[0.0, 0.0]];
    for k in 0..arms {
        let ([x, y], [dx, dy]) = (outer[k as usize], way(k));
        let length = f64::from(2 * (k / 2 + 2));
        outer.push([x + length * dx, y + length * dy]);
    }
    // To the left of both pieces at a corner.
    let inner = (0..=arms).rev().map(|k| {
        let ([x, y], before, after) = (outer[k as usize], way(k + 3), way(k));
        let turn = [before, after].map(|[dx, dy]| [-dy, dx]);
        let on = [k > 0, k < arms].map(f64::from);
        [0, 1].map(|i| [x, y][i] + on[0] * turn[0][i] + on[1] * turn[1][i])
    });
    let ring: Vec<[f64; 2]> = outer.iter().copied().chain(inner.collect::<Vec<_>>()).collect();
    prism(&ring)
}

/// A cone over a comb: a facet of many corners, and as many triangles at the apex.
fn cone(teeth: u32) -> Domain {
    let ring = comb_ring(teeth, 4.0);
    let count = ring.len() as u32;
    let mut domain = Domain::default();
    domain.vertices.extend(ring.iter().map(|&[x, y]| [x, y, 0.0]));
    domain.vertices.push([f64::from(teeth) + 0.5, 1.5, f64::from(teeth)]);
    domain.facets = vec![Facet::polygon(&(0..count).collect::<Vec<u32>>(), 0)];
    domain.facets.extend((0..count).map(|k| Facet::polygon(&[k, (k + 1) % count, count], 0)));
    domain
}

/// A box with faces of `size`² squares of two triangles.
fn plate(size: u32) -> Domain {
    let mut domain = Domain::default();
    let at = |x: u32, y: u32| y * (size + 1) + x;
    let count = (size + 1) * (size + 1);
    for z in [0.0, 1.0] {
        let points = (0..count).map(|k| [k % (size + 1), k / (size + 1)].map(f64::from));
        domain.vertices.extend(points.map(|[x, y]| [x, y, z]));
    }
    for (x, y) in (0..size * size).map(|k| (k % size, k / size)) {
        for up in [0, count] {
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            domain.facets.push(Facet::polygon(&[a, b, c].map(|v| v + up), 0));
            domain.facets.push(Facet::polygon(&[a, c, d].map(|v| v + up), 0));
        }
    }
    for k in 0..size {
        let ends = [
            [at(k, 0), at(k + 1, 0)],
            [at(k, size), at(k + 1, size)],
            [at(0, k), at(0, k + 1)],
            [at(size, k), at(size, k + 1)],
        ];
        let side = |[a, b]: [u32; 2]| Facet::polygon(&[a, b, b + count, a + count], 0);
        domain.facets.extend(ends.map(side));
    }
    domain
}

/// Two cones over a polygon: very many triangles at either apex.
fn bipyramid(count: u32) -> Domain {
    let mut domain = Domain::default();
    domain.vertices.extend([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]);
    for k in 0..count {
        // A square with many corners along each side, bent outwards.
        let t = f64::from(4 * k / count) + f64::from(k % (count / 4)) / f64::from(count / 4);
        let s = 2.0 * t.fract() - 1.0;
        let out = 2.0 - s * s;
        let [x, y] = [[s, -out], [out, s], [-s, out], [-out, -s]][t as usize];
        domain.vertices.push([x, y, 0.0]);
    }
    for k in 0..count {
        let (a, b) = (2 + k, 2 + (k + 1) % count);
        domain.facets.push(Facet::polygon(&[0, a, b], 0));
        domain.facets.push(Facet::polygon(&[1, b, a], 0));
    }
    domain
}

/// A domain of a size.
type Make = fn(u32) -> Domain;

fn report(domain: &Domain) -> DomainReport {
    domain.check(&CheckOptions::default()).expect("a report")
}

fn complex(domain: &Domain) -> Complex<'_> {
    let mut findings = Findings {
        defects: Default::default(),
        counts: Default::default(),
        listed: 0,
        errors: Vec::new(),
    };
    Complex::new(domain, &mut findings)
}

#[test]
fn each_piece_takes_few_steps_of_many() {
    let makes: [(Make, u32); 6] = [
        (comb, 1 << 8),
        (tall_comb, 1 << 8),
        (spiral, 1 << 8),
        (cone, 1 << 8),
        (plate, 1 << 4),
        (bipyramid, 1 << 10),
    ];
    for (make, size) in makes {
        let steps = [1, 2, 4].map(|times| {
            let domain = make(size * times);
            assert!(report(&domain).passed(), "{}", report(&domain));
            let complex = complex(&domain);
            let pieces = complex.pieces();
            let parted = part(&complex, &pieces);
            let pairs = pairs::compared(&complex, &parted.lists);
            [parted.steps, pairs].map(|n| n as f64 / pieces.len() as f64)
        });
        for pair in steps.windows(2) {
            // For each piece a logarithm of steps, and no more pairs than before.
            assert!(pair[1][0] < 1.3 * pair[0][0] + 4.0, "{steps:?}");
            assert!(pair[1][1] < 1.3 * pair[0][1] + 1.0, "{steps:?}");
        }
    }
}

#[test]
fn what_crosses_a_facet_of_many_corners_is_found() {
    let mut domain = comb(64);
    // A needle through the middle of a tooth, one beside it, and one along the back.
    let needles = [([20.5, 0.5, -1.0], 1), ([21.5, 0.5, -1.0], 0), ([100.5, -0.5, -1.0], 1)];
    for (at, crossings) in needles {
        let before = domain.clone();
        let first = domain.vertices.len() as u32;
        domain.vertices.extend([at, [at[0], at[1], 0.5], [at[0] + 0.125, at[1], 0.5]]);
        domain.facets.push(Facet::polygon(&[first, first + 1, first + 2], 0));
        assert_eq!(report(&domain).count(DefectKind::Intersection), crossings, "{at:?}");
        domain = before;
    }
}

/// A comb's facet, and a triangle, an edge and a vertex with corners of it and others, by the
/// numbers of these.
fn beside_a_comb(points: &[Point], picks: &[u32]) -> Domain {
    let ring = comb_ring(3, 2.0);
    let count = ring.len() as u32;
    let mut domain = Domain::default();
    domain.vertices.extend(ring.iter().map(|&[x, y]| [x, y, 1.0]));
    domain.vertices.extend(points);
    let all = domain.vertices.len() as u32;
    // Half of the picks are corners of the comb.
    let pick = |k: usize| {
        let n = picks[k];
        if n.is_multiple_of(2) { n / 2 % count } else { count + n / 2 % (all - count) }
    };
    domain.facets = vec![
        Facet::polygon(&(0..count).collect::<Vec<u32>>(), 0),
        Facet::polygon(&[pick(0), pick(1), pick(2)], 0),
    ];
    domain.segments.push(([pick(3), pick(4)], 0));
    domain
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

    #[test]
    fn what_is_apart_from_a_large_facet_has_no_contact_with_it(
        points in prop::collection::vec([0..7_i32, -1..4, 0..3], 4),
        picks in prop::collection::vec(0..1000_u32, 5),
    ) {
        let points: Vec<Point> = points.into_iter().map(|p| p.map(f64::from)).collect();
        let domain = beside_a_comb(&points, &picks);
        let complex = complex(&domain);
        let own = complex.facet_of.iter().take_while(|&&f| f == 0).count() as u32;
        prop_assert!(own > 8);
        let large = Large::of(&complex, 8);
        for n in own..complex.count() as u32 {
            let has = |t: u32| pairs::contact(&complex, t, n).is_some();
            prop_assert!(!large.is_apart(0, n) || !(0..own).any(has), "{:?}", complex.shape(n));
        }
    }
}

#[test]
fn what_a_large_facet_draws_is_apart_from_it() {
    let domain = comb(32);
    let complex = complex(&domain);
    let large = Large::of(&complex, 8);
    // All of a prism but the facet itself, of which nobody asks.
    assert!((0..complex.count() as u32).all(|n| large.is_apart(0, n) && large.is_apart(1, n)));
    // A wall through both is not.
    let mut domain = comb(8);
    domain.vertices.extend([[0.5, 0.5, -1.0], [0.5, 0.5, 2.0], [3.0, -3.0, 0.5]]);
    let first = domain.vertices.len() as u32 - 3;
    domain.facets.push(Facet::polygon(&[first, first + 1, first + 2], 0));
    let complex = self::complex(&domain);
    let large = Large::of(&complex, 8);
    let wall = complex.triangles.len() as u32 - 1;
    assert!(!large.is_apart(0, wall) && !large.is_apart(1, wall));
}
