//! Edge lengths mean what they say: the usual edge, and the longest one.

use ltbw_domain::vector::{cross, dot, minus};
use ltbw_domain::{Domain, Facet, PrepareOptions, Prepared};
use ltbw_generate::surfaces;
use ltbw_refine::{RefineOutcome, Refined, Refiner, Sizes};
use std::collections::{HashMap, HashSet};

fn ready(domain: &Domain) -> Prepared {
    let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
    domain.prepare(&options).expect("a sound domain")
}

/// The lengths of the edges of a mesh.
fn edges(refined: &Refined) -> Vec<f64> {
    let mesh = refined.inside();
    let ends = |t: &[u32; 4]| {
        let [a, b, c, d] = *t;
        [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]].map(|[v, w]| [v.min(w), v.max(w)])
    };
    let all: HashSet<[u32; 2]> = mesh.tets.iter().flat_map(ends).collect();
    let length = |[v, w]: &[u32; 2]| {
        let [p, q] = [v, w].map(|v| mesh.points[*v as usize]);
        (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()
    };
    all.iter().map(length).collect()
}

/// The mean edge over `length`, and the number of tetrahedra over that of regular ones with such
/// edges.
fn measured(refined: &Refined, length: f64) -> [f64; 2] {
    let (edges, mesh) = (edges(refined), refined.inside());
    let six = |t: &[u32; 4]| {
        let [a, b, c, d] = t.map(|v| mesh.points[v as usize]);
        dot(&cross(&minus(&b, &a), &minus(&c, &a)), &minus(&d, &a)).abs()
    };
    let volume = mesh.tets.iter().map(six).sum::<f64>() / 6.0;
    let regular = length * length * length / 72f64.sqrt();
    let mean = edges.iter().sum::<f64>() / edges.len() as f64;
    [mean / length, refined.num_tets() as f64 * regular / volume]
}

/// A ball of radius 1/2: an octahedron whose triangles are divided into four, `times` times.
fn ball(times: u32) -> Domain {
    let mut vertices = Vec::new();
    for k in 0..3 {
        vertices.extend([0.5, -0.5].map(|c| [0, 1, 2].map(|i| if i == k { c } else { 0.0 })));
    }
    let mut triangles = Vec::new();
    for (x, y, z) in (0..8).map(|i| (i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2))) {
        let is_even = (x + y + z) % 2 == 0;
        triangles.push(if is_even { [x, y, z] } else { [x, z, y] });
    }
    for _ in 0..times {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let mut middle = |v: u32, w: u32| {
            *middles.entry([v.min(w), v.max(w)]).or_insert_with(|| {
                let [p, q] = [v, w].map(|v| vertices[v as usize]);
                let sum = [0, 1, 2].map(|k| p[k] + q[k]);
                let length = 2.0 * dot(&sum, &sum).sqrt();
                vertices.push(sum.map(|c| c / length));
                vertices.len() as u32 - 1
            })
        };
        let divided = triangles.iter().flat_map(|&[a, b, c]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        });
        triangles = divided.collect();
    }
    let facets = triangles.iter().map(|t| Facet::polygon(t, 0)).collect();
    Domain { vertices, facets, ..Domain::default() }
}

#[test]
fn the_mean_edge_is_the_size_and_the_count_that_of_regular_tetrahedra() {
    let all = [
        ("box", Domain::cuboid([0.0; 3], [1.0, 1.3, 0.8]), [0.2, 0.1, 0.06]),
        ("ball", ball(2), [0.16, 0.1, 0.06]),
        ("cylinder", surfaces::prism(24, 0.0, 1), [0.13, 0.1, 0.06]),
    ];
    for (name, domain, lengths) in all {
        let ready = ready(&domain);
        for length in lengths {
            let sizes = Sizes::new(&ready).everywhere(length).expect("a length");
            let field = |p| sizes.at(p);
            let refiner = Refiner::new().sizing(&field);
            let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
            let [mean, count] = measured(&refined, length);
            println!("{name} {length}: mean {mean:.3}, count {count:.3}");
            assert!((0.9..=1.1).contains(&mean), "{name} {length}: mean {mean}");
            assert!((0.9..=1.35).contains(&count), "{name} {length}: count {count}");
        }
    }
}

#[test]
fn no_edge_is_longer_than_the_longest() {
    for domain in [Domain::cuboid([0.0; 3], [1.0; 3]), surfaces::prism(12, 0.0, 1)] {
        let ready = ready(&domain);
        let mut hash = None;
        for start in [usize::MAX, 0] {
            let refiner = Refiner::new().max_edge(0.15).start(start);
            let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
            assert_eq!(refined.outcome, RefineOutcome::Met);
            let longest = edges(&refined).into_iter().fold(0.0, f64::max);
            assert!(longest <= 0.15 && longest > 0.14, "{longest}");
            if start == 0 {
                hash = Some(refined.mesh().hash().expect("a hash"));
            }
        }
        // One mesh, whatever the threads.
        let alone = Refiner::new().max_edge(0.15).start(0).one_thread();
        let alone = alone.refine(&ready.domain, &ready.lattice).expect("a mesh");
        assert_eq!(Some(alone.mesh().hash().expect("a hash")), hash);
    }
    let ready = ready(&Domain::cuboid([0.0; 3], [1.0; 3]));
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-30] {
        let refined = Refiner::new().max_edge(wrong).refine(&ready.domain, &ready.lattice);
        let text = refined.expect_err("no length").to_string();
        assert!(text.contains("max-edge"), "{text}");
    }
}
