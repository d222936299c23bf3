//! The time of the exact check of a surface, against meshing its vertices.
//!
//! `cargo run --release -p ltbw-core --example domain_speed -- 1000000`

use ltbw_core::Builder;
use ltbw_domain::{CheckOptions, Domain, Facet};
use ltbw_exact::PointSet;
use ltbw_generate::Random;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let triangles = std::env::args().nth(1).map_or(Ok(1_000_000), |n| n.parse::<u64>())?;
    let domain = blob(triangles);
    let count = domain.facets.len();
    let clock = Instant::now();
    let report = domain.check(&CheckOptions { oriented: true, ..CheckOptions::default() })?;
    let check = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    let built = Builder::new().build(&PointSet::new(domain.vertices)?)?;
    let mesh = clock.elapsed().as_secs_f64();
    println!("{count} triangles, passed: {}, {:?}", report.passed(), report.counts);
    println!(
        "check {check:.2} s; mesh of their vertices {mesh:.2} s ({} tets)",
        built.mesh.num_tets()
    );
    println!("ratio {:.2}", check / mesh);
    Ok(())
}

/// A bumpy sphere: rings of latitude and two poles, radius between 1 and 1.05 at random.
fn blob(triangles: u64) -> Domain {
    // Rings of n vertices, n of them: 2 n² triangles.
    let n = ((triangles / 2) as f64).sqrt() as u32;
    let mut random = Random::new(1);
    let mut domain = Domain::default();
    for ring in 0..n {
        let latitude = std::f64::consts::PI * (f64::from(ring) + 1.0) / (f64::from(n) + 1.0);
        for step in 0..n {
            let longitude = 2.0 * std::f64::consts::PI * f64::from(step) / f64::from(n);
            let radius = 1.0 + 1e-5 * random.unit();
            let (s, c) = latitude.sin_cos();
            let p = [s * longitude.cos(), s * longitude.sin(), c].map(|x| radius * x);
            domain.vertices.push(p);
        }
    }
    let [north, south] = [n * n, n * n + 1];
    domain.vertices.extend([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]);
    let mut add = |t: [u32; 3]| domain.facets.push(Facet::polygon(&t, 0));
    for step in 0..n {
        let next = (step + 1) % n;
        add([north, step, next]);
        add([south, (n - 1) * n + next, (n - 1) * n + step]);
        for ring in 0..n - 1 {
            let [a, b] = [ring * n + step, ring * n + next];
            add([a, a + n, b + n]);
            add([a, b + n, b]);
        }
    }
    domain
}
