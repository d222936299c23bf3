//! Domains refined by workers that share no mesh: the sequential engine's mesh, outcome, excuses
//! and files, whatever the domain, the number of workers and the network.
//!
//! Random domains: 10 by default, `LTBW_CASES` for more (200 for the full bar). Surfaces: some by
//! formula, and those of the folder `LTBW_PARTS`, if it is set.

use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::mesh::Layout;
use ltbw::protocol::Config;
use ltbw::refine::{Refined, Refiner, usual_tolerance};
use ltbw::refining::{Plan, rounds_on_threads, simulate_rounds};
use ltbw::simulate::{Distribution, Network, Options};
use ltbw::threads::Parallel;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_tests::cases;
use ltbw_tests::compare::same_refined;
use ltbw_tests::domains::{prepared, random_domain, small_volume};
use ltbw_tests::parts::for_each_surface;

/// A domain, and the engine's mesh of it.
struct Case<'a> {
    name: String,
    ready: &'a Prepared,
    refiner: Refiner<'a>,
    engine: Refined,
}

impl<'a> Case<'a> {
    fn new(name: String, refiner: Refiner<'a>, ready: &'a Prepared) -> Self {
        let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
        Self { name, ready, refiner, engine }
    }

    /// Refines on numbers of threads; by how many workers' points, if by any.
    fn on_threads(&self, all: &[u32]) -> Option<u64> {
        let whole = (&self.ready.domain, &self.ready.lattice);
        let mut points = None;
        for &threads in all {
            let name = format!("{} on {threads} threads", self.name);
            let run = rounds_on_threads(&self.refiner, whole, &Parallel::new(threads));
            let run = run.unwrap_or_else(|e| panic!("{name}: {e}"));
            same_refined(&name, &run.refined, &self.engine);
            points = run.ending.ok().map(|_| run.figures.points);
        }
        points
    }

    /// Refines on simulated processors, with latencies in nanoseconds and their laws.
    fn on_processors(&self, all: &[(u32, u64, Distribution)]) {
        for &(processors, latency, distribution) in all {
            let law = distribution.name();
            let name = format!("{} on {processors} processors, {law} {latency} ns", self.name);
            let network = Network { latency, distribution, ..Network::default() };
            let options = Options { network, max_events: 1_000_000_000, ..Options::default() };
            let plan = |points| Plan {
                layout: Layout::new(points, processors),
                config: Config::new(processors),
            };
            let whole = (&self.ready.domain, &self.ready.lattice);
            let run = simulate_rounds(&self.refiner, whole.0, whole.1, &plan, &options);
            let run = run.unwrap_or_else(|e| panic!("{name}: {e}"));
            same_refined(&name, &run.refined, &self.engine);
            assert!(run.ending.is_err() || run.figures.points > 0, "{name}");
        }
    }
}

#[test]
fn random_domains_have_the_engines_mesh() {
    let count = cases(10);
    let (mut by_workers, mut points) = (0, 0);
    for seed in 0..count as u64 {
        let (name, domain) = random_domain(seed);
        let ready = prepared(&domain);
        let refiner = Refiner::new().max_volume(small_volume(&ready.domain)).start(0);
        let case = Case::new(format!("{name} {seed}"), refiner, &ready);
        let inserted = case.on_threads(&[4]);
        by_workers += usize::from(inserted.is_some());
        points += inserted.unwrap_or(0);
        let distribution = Distribution::ALL[seed as usize % 4];
        case.on_processors(&[(2 + seed as u32 % 30, 3_000, distribution)]);
    }
    println!("{count} domains, {by_workers} of them by workers, who inserted {points} points");
    assert!(
        2 * by_workers > count as usize && points > 100 * count as u64,
        "{by_workers} {points}"
    );
}

/// Of all kinds of domains `parallel/tests/refining_rounds.rs` has the matrix of workers and
/// threads. Here are very many workers, and all laws of latencies.
#[test]
fn many_workers_have_the_engines_mesh() {
    let problems = [
        (DomainKind::CubeOctahedron, 2e-3),
        (DomainKind::CubeInCube, 2e-3),
        (DomainKind::Tee, 2e-3),
        (DomainKind::Gear, 1e-3),
    ];
    for ((kind, volume), law) in problems.into_iter().zip(Distribution::ALL) {
        let ready = prepared(&generate_domain(kind, &Shape::default()).expect("a domain"));
        let refiner = Refiner::new().max_volume(volume).start(0);
        let case = Case::new(format!("{kind:?}"), refiner, &ready);
        assert!(case.on_threads(&[16]).is_some(), "{kind:?}");
        let laws = Distribution::ALL.map(|law| [(2, 1_000, law), (16, 30_000, law)]);
        case.on_processors(laws.as_flattened());
        // Most of 1024 have no tetrahedron at the start.
        let most = if kind == DomainKind::CubeOctahedron { 1024 } else { 64 };
        case.on_processors(&[(most, 10_000, law)]);
    }
}

/// Surfaces with patches within the usual tolerance, and without.
#[test]
fn surfaces_have_the_engines_mesh() {
    let mut with_patches = 0;
    for_each_surface(|name, domain, oriented| {
        let options = PrepareOptions { oriented, ..PrepareOptions::default() };
        let Ok(ready) = domain.prepare(&options) else { return false };
        let refiner = Refiner::new().max_volume(small_volume(&ready.domain)).start(0);
        for tolerance in [usual_tolerance(domain, &ready.domain), 0.0] {
            let case = Case::new(name.to_owned(), refiner.flat_tolerance(tolerance), &ready);
            let points = case.on_threads(&[1, 2, 3]);
            let is_patched = case.engine.stats.patches > 0;
            with_patches += if is_patched { points.unwrap_or(0) } else { 0 };
            println!("{name}, tolerance {tolerance:e}: points by workers {points:?}");
        }
        true
    });
    assert!(with_patches > 1000, "{with_patches} points by workers beside patches");
}
