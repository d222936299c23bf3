//! Domains refined by workers that share no mesh: the sequential engine's mesh, outcome, excuses
//! and files, whatever the domain, the number of workers and the network.
//!
//! Random domains: 10 by default, `LTBW_CASES` for more (200 for the full bar). Surfaces: some by
//! formula, and those of the folder `LTBW_PARTS`, if it is set.

use ltbw::domain::{Domain, PrepareOptions, Prepared};
use ltbw::mesh::Layout;
use ltbw::protocol::{Config, Correct};
use ltbw::refine::{Refined, Refiner, usual_tolerance};
use ltbw::refining::{rounds_on_threads, simulate_rounds};
use ltbw::simulate::{Distribution, Network, Options};
use ltbw::threads::Parallel;
use ltbw_generate::{DomainKind, Shape, generate_domain, surfaces};
use ltbw_tests::cases;
use ltbw_tests::domains::{prepared, random_domain};

/// A mesh is that of the engine, in all that a user sees of it.
fn same(name: &str, one: &Refined, engine: &Refined) {
    let hash = |refined: &Refined| refined.mesh().hash().expect("a hash");
    assert_eq!(hash(one), hash(engine), "{name}");
    assert_eq!(one.outcome, engine.outcome, "{name}");
    // Files are made of these.
    assert!(one.with_exterior() == engine.with_exterior(), "{name}: another mesh is written");
    let excuses = |refined: &Refined| -> Vec<_> {
        refined.excuses.iter().map(|e| (refined.tet(e.tet), e.reason)).collect()
    };
    assert!(excuses(one) == excuses(engine), "{name}: other excuses");
}

/// Of the volume of a domain's box.
fn a_two_thousandth(ready: &Prepared) -> f64 {
    let (low, high) = ready.domain.bounds().expect("vertices");
    (0..3).map(|k| high[k] - low[k]).product::<f64>() / 2000.0
}

/// Refines with the engine and on threads; by how many workers' points, if by any.
fn on_threads(name: &str, refiner: &Refiner<'_>, ready: &Prepared, all: &[u32]) -> Option<u64> {
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    let whole = (&ready.domain, &ready.lattice);
    let mut points = None;
    for &threads in all {
        let run = rounds_on_threads(refiner, whole, &Parallel::new(threads));
        let run = run.unwrap_or_else(|e| panic!("{name} on {threads} threads: {e}"));
        same(&format!("{name} on {threads} threads"), &run.refined, &engine);
        points = run.ending.ok().map(|_| run.figures.points);
    }
    points
}

/// The same on simulated processors.
fn on_processors(
    name: &str,
    refiner: &Refiner<'_>,
    ready: &Prepared,
    all: &[(u32, u64, Distribution)],
) {
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    for &(processors, latency, distribution) in all {
        let name =
            format!("{name} on {processors} processors, {} {latency} ns", distribution.name());
        let network = Network { latency, distribution, ..Network::default() };
        let options = Options { network, max_events: 1_000_000_000, ..Options::default() };
        let layout = |points| (Layout::new(points, processors), Config::new(processors));
        let whole = (&ready.domain, &ready.lattice);
        let run = simulate_rounds::<Correct>(refiner, whole, layout, &options);
        let run = run.unwrap_or_else(|e| panic!("{name}: {e}"));
        same(&name, &run.refined, &engine);
        assert!(run.ending.is_err() || run.figures.points > 0, "{name}");
    }
}

#[test]
fn random_domains_have_the_engines_mesh() {
    let count = cases(10);
    let (mut by_workers, mut points) = (0, 0);
    for seed in 0..count as u64 {
        let (name, domain) = random_domain(seed);
        let (name, ready) = (format!("{name} {seed}"), prepared(&domain));
        let refiner = Refiner::new().max_volume(a_two_thousandth(&ready)).start(0);
        let inserted = on_threads(&name, &refiner, &ready, &[4]);
        by_workers += usize::from(inserted.is_some());
        points += inserted.unwrap_or(0);
        let distribution = Distribution::ALL[seed as usize % 4];
        on_processors(&name, &refiner, &ready, &[(2 + seed as u32 % 30, 3_000, distribution)]);
    }
    println!("{count} domains, {by_workers} of them by workers, who inserted {points} points");
    assert!(
        2 * by_workers > count as usize && points > 100 * count as u64,
        "{by_workers} {points}"
    );
}

#[test]
fn the_papers_problems_have_the_engines_mesh_on_many_workers() {
    let problems = [
        (DomainKind::CubeOctahedron, 2e-3),
        (DomainKind::CubeInCube, 2e-3),
        (DomainKind::Tee, 2e-3),
        (DomainKind::Gear, 1e-3),
    ];
    for (k, (kind, volume)) in problems.into_iter().enumerate() {
        let ready = prepared(&generate_domain(kind, &Shape::default()).expect("a domain"));
        let (name, refiner) = (format!("{kind:?}"), Refiner::new().max_volume(volume).start(0));
        assert!(on_threads(&name, &refiner, &ready, &[1, 2, 3, 4, 8, 16]).is_some(), "{name}");
        let laws = Distribution::ALL.map(|law| [(2, 1_000, law), (16, 30_000, law)]);
        on_processors(&name, &refiner, &ready, laws.as_flattened());
        let law = Distribution::ALL[k];
        // Most of 1024 have no tetrahedron at the start.
        let most = if k == 0 || cases(10) > 10 { 1024 } else { 64 };
        on_processors(&name, &refiner, &ready, &[(most, 10_000, law)]);
    }
}

/// Surfaces by formula, rounded to 32-bit floats, some turned; then the parts of the folder
/// `LTBW_PARTS`, if it is set. All with patches within the usual tolerance, which one thread
/// refines, and without.
#[test]
fn surfaces_have_the_engines_mesh() {
    let by_formula = [
        ("a prism", surfaces::prism(12, 0.0, 0)),
        ("a globe", surfaces::globe(8, 10, 0.0, 0)),
        ("a torus", surfaces::torus(10)),
        ("a plate", surfaces::plate(3, 0.1)),
        ("a shell", surfaces::shell(0.1)),
    ];
    for (name, domain) in by_formula {
        for (way, domain) in [("", domain.clone()), (", turned", surfaces::turned(&domain))] {
            surface(&format!("{name}{way}"), &surfaces::single(domain), true);
        }
    }
    let Some(folder) = std::env::var_os("LTBW_PARTS") else { return };
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    for path in paths {
        let Ok(file) = ltbw::io::read_domain(&path) else { continue };
        surface(&path.display().to_string(), &file.domain, file.oriented);
    }
}

fn surface(name: &str, domain: &Domain, oriented: bool) {
    let options = PrepareOptions { oriented, ..PrepareOptions::default() };
    let Ok(ready) = domain.prepare(&options) else { return };
    let volume = a_two_thousandth(&ready);
    for tolerance in [usual_tolerance(domain, &ready.domain), 0.0] {
        let refiner = Refiner::new().flat_tolerance(tolerance).max_volume(volume).start(0);
        let points = on_threads(name, &refiner, &ready, &[4]);
        println!("{name}, tolerance {tolerance:e}: points by workers {points:?}");
    }
}
