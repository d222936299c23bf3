//! Random bodies with what is no part of them: spare vertices, sheets, flaps outside and inside,
//! voids beside, and bodies inside them. Each is meshed as if only the bodies were there, and the
//! checker, which is given all, finds that right.

use ltbw::domain::{DefectKind, Domain, Facet, PrepareOptions, Prepared};
use ltbw::refine::{Refined, Refiner};
use ltbw_tests::domains::{plc_of, random_domain};
use ltbw_verify::{Conformity, ConformityDefect, Limits, Mesh, Options, Plc, conforms};

const SEEDS: u64 = 24;

/// A linear congruence, for numbers that are the same on every machine.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        ((self.0 >> 33) as u32) % n
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.below(1 << 20)) / f64::from(1 << 20)
    }
}

/// A random star-shaped body about the origin, its triangles outwards.
fn body(seed: u64) -> Domain {
    let (kind, mut domain) = random_domain(6 * seed + 1);
    assert_eq!(kind, "star");
    let vertices = &domain.vertices;
    for ring in domain.facets.iter_mut().flat_map(|f| &mut f.polygons) {
        let [a, b, c] = [0, 1, 2].map(|k| vertices[ring[k] as usize]);
        let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
        if a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1) < 0.0 {
            ring.reverse();
        }
    }
    domain
}

fn moved(domain: &Domain, by: f64, scale: f64) -> Domain {
    let place = |p: &[f64; 3]| [by + scale * p[0], scale * p[1], scale * p[2]];
    Domain { vertices: domain.vertices.iter().map(place).collect(), ..domain.clone() }
}

/// Triangles that stand on edges of the body, away from its middle: outside, as it is
/// star-shaped, and without any contact but at vertices.
fn stand(domain: &mut Domain, random: &mut Random, count: u32, flap: bool) {
    let triangles = domain.facets.len() as u32;
    let mut edges: Vec<[u32; 2]> = Vec::new();
    while edges.len() < count as usize {
        let ring = &domain.facets[random.below(triangles) as usize].polygons[0];
        let k = random.below(3) as usize;
        let (a, b) = (ring[k], ring[(k + 1) % 3]);
        let edge = [a.min(b), a.max(b)];
        if !edges.contains(&edge) {
            edges.push(edge);
        }
    }
    for [a, b] in edges {
        let [p, q] = [a, b].map(|v| domain.vertices[v as usize]);
        let scale = random.between(1.25, 2.0) / 2.0;
        domain.vertices.push([0, 1, 2].map(|k| scale * (p[k] + q[k])));
        let top = domain.vertices.len() as u32 - 1;
        domain.facets.push(Facet::polygon(&[a, b, top], 3));
        if flap {
            domain.facets.push(Facet::polygon(&[top, b, a], 3));
        }
    }
}

/// A body with additions; how many cells are inside, and their volume in volumes of the body.
fn domain(seed: u64) -> (Domain, bool, usize, f64) {
    let (own, mut random) = (body(seed), Random(seed));
    let (mut domain, mut cells, mut volume) = (own.clone(), 1, 1.0);
    // Flaps are of oriented surfaces, hole points of others.
    let oriented = seed.is_multiple_of(2);
    stand(&mut domain, &mut random, 1 + random_count(seed), oriented);
    for _ in 0..random.below(4) {
        let far = [0; 3]
            .map(|_| random.between(2.0, 9.0) * if seed.is_multiple_of(3) { 1.0 } else { -1.0 });
        domain.vertices.push(far);
    }
    if random.below(2) == 0 {
        // Inside, and turned likewise.
        let scale = random.between(0.25, 0.5);
        domain = domain.join(moved(&own, 0.0, scale));
        cells += 1;
    }
    if !oriented {
        let mut void = moved(&own, 8.0, 1.0);
        void.holes.push([8.0, 0.0, 0.0]);
        domain = domain.join(void);
        if random.below(2) == 0 {
            // A body in it; its own inside is not what the hole point is in.
            let place = domain.holes.len() - 1;
            domain.holes[place] = [8.0, 0.0, 0.625];
            domain = domain.join(moved(&own, 8.0, 0.375));
            (cells, volume) = (cells + 1, 1.0 + 0.375f64.powi(3));
        }
        let first = domain.vertices.len() as u32;
        domain.vertices.extend([[0.0, 5.0, 5.0], [1.0, 5.0, 5.0], [0.0, 6.0, 5.5]]);
        domain.facets.push(Facet::polygon(&[first, first + 1, first + 2], 0));
    }
    if oriented && random.below(2) == 0 {
        // In the midst of the body, without any contact.
        let first = domain.vertices.len() as u32;
        domain.vertices.extend([
            [0.015625, 0.0, 0.03125],
            [0.03125, 0.0, 0.03125],
            [0.0, 0.03125, 0.0],
        ]);
        let [a, b, c] = [0, 1, 2].map(|k| first + k);
        domain.facets.extend([[a, b, c], [c, b, a]].map(|ring| Facet::polygon(&ring, 5)));
    }
    (domain, oriented, cells, volume)
}

fn random_count(seed: u64) -> u32 {
    (seed % 5) as u32
}

fn judged(ready: &Prepared, refined: &Refined, change: impl Fn(&mut Plc)) -> Conformity {
    let (mesh, mut plc) = (refined.inside(), plc_of(ready.judged()));
    change(&mut plc);
    let view = Mesh::new(&mesh.points, &mesh.tets);
    let limits = Limits::default();
    conforms(&view, &plc, mesh.tet_tags.as_deref(), &limits, &Options::default())
}

#[test]
fn what_is_no_part_of_a_domain_changes_nothing_and_is_told() {
    let (mut ended, mut flaps, mut nested, mut spare) = (0, 0, 0, 0);
    for seed in 0..SEEDS {
        let (domain, oriented, cells, volume) = domain(seed);
        let options = PrepareOptions { oriented, ..PrepareOptions::default() };
        let ready = domain.prepare(&options).unwrap_or_else(|e| panic!("{seed}: {e}"));
        let filled = ready.report.cells.iter().flatten().filter(|c| c.filled).count();
        assert_eq!(filled, cells, "{seed}");
        let own = body(seed).prepare(&PrepareOptions::default()).expect("a sound body");
        let [all, own] = [&ready, &own].map(|r| r.report.volume().expect("cells").to_f64());
        assert!((all / own - volume).abs() < 1e-5, "{seed}: {all} {own} {volume}");
        let refined = Refiner::new().any_shape().refine(&ready.domain, &ready.lattice);
        let refined = refined.unwrap_or_else(|e| panic!("{seed}: {e}"));
        let found = judged(&ready, &refined, |_| ());
        assert!(found.passed(), "{seed}: {:?} {:?}", found.findings, found.mesh_defects);
        let exact = ready.report.volume().map(|v| v.to_string());
        assert_eq!(found.volume.as_ref().map(ToString::to_string), exact, "{seed}");
        // A sheet inside that the mesh lacks is missed all the same, and a vertex there.
        let found = judged(&ready, &refined, |plc| plc.vertices.push([0.125, 0.0625, 0.03125]));
        assert_eq!(found.count(ConformityDefect::VertexMissing), 1, "{seed}");
        let found = judged(&ready, &refined, |plc| {
            let first = plc.vertices.len() as u32;
            let corners = [[0.0, 0.0, 0.09375], [0.0625, 0.0, 0.09375], [0.0, 0.0625, 0.09375]];
            plc.vertices.extend(corners);
            let mut sheet = plc.facets[0].clone();
            sheet.polygons = vec![vec![first, first + 1, first + 2]];
            plc.facets.push(sheet);
        });
        assert!(found.count(ConformityDefect::FacetNotTiled) > 0, "{seed}");
        let repairs = &ready.repairs;
        ended += repairs.ends.len();
        flaps += repairs.flaps.len();
        spare += repairs.exterior_vertices;
        nested += ready.report.count(DefectKind::Nested);
        let strict = PrepareOptions { strict: true, ..options };
        assert!(domain.prepare(&strict).is_err(), "{seed}");
    }
    // Of every kind there were some.
    assert!(
        ended > 20 && flaps > 40 && spare > 100 && nested > 3,
        "{ended} {flaps} {spare} {nested}"
    );
}
