//! Domains refined without rounds, on threads: as many tetrahedra as in rounds, within three in a
//! hundred, and a mesh that the checker has nothing against. And on simulated processors, at any
//! time that messages take: about as many points.
//!
//! Small domains, and two of which workers make the larger part; with `LTBW_CASES` above 10 all:
//! the named ones, the paper's problems, the surfaces by formula, and that many at random of each
//! kind.

use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::mesh::Layout;
use ltbw::protocol::Config;
use ltbw::refine::{
    Order, RefineOutcome, RefineStats, Refined, Refiner, Strategy, usual_tolerance,
};
use ltbw::refining::{Plan, domain_on_threads, simulate_domain};
use ltbw::simulate::{Distribution, Network, Options};
use ltbw::threads::Parallel;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_tests::domains::{NAMED, PROBLEMS, awkward_domain, prepared, random_domain, small_volume};
use ltbw_tests::excuses::{judge_refined, limits};
use ltbw_tests::parts::generated;
use ltbw_tests::{cases, seeds};
use ltbw_verify::ConformityDefect;
use std::collections::BTreeSet;

/// Cases at random without more being asked for.
const FEW: u32 = 10;
/// Problems that are large enough for workers, each with a largest volume.
const LARGER: [(DomainKind, f64); 2] =
    [(DomainKind::CubeOctahedron, 5e-5), (DomainKind::Gear, 3e-5)];
/// Surfaces with patches and without that have few tetrahedra, by the beginnings of their names.
const SMALL: [&str; 6] =
    ["prism-6-", "prism-8-1e-6", "stack-3", "honeycomb-1", "wedge-", "shell-1"];
/// Surfaces that take half a million tetrahedra, or minutes: not even with more cases.
const LARGE: [&str; 3] = ["plate-0.001", "shell-0.001", "shell-0.01"];

/// The table, and what it comes to.
#[derive(Default)]
struct Table {
    rows: usize,
    /// Rows outside three in a hundred.
    outside: Vec<String>,
    /// Points by workers.
    points: u64,
}

impl Table {
    /// Refines a domain in rounds, and on 2 and 4 threads without.
    fn add(&mut self, name: &str, ready: &Prepared, tolerance: f64, volume: Option<f64>) {
        let refiner = Refiner::new().flat_tolerance(tolerance);
        let refiner = volume.map_or(refiner, |bound| refiner.max_volume(bound));
        let whole = (&ready.domain, &ready.lattice);
        // A domain may be out of reach for one as for the other.
        let Ok(rounds) = refiner.refine(whole.0, whole.1) else {
            println!("| {name} | no mesh |");
            return;
        };
        let tets = rounds.num_tets();
        for threads in [2, 4] {
            let run = domain_on_threads(&refiner, whole.0, whole.1, &Parallel::new(threads));
            let run = run.unwrap_or_else(|error| panic!("{name} on {threads}: {error}"));
            let points: u64 = run.splits.map_or(0, |own| own.inserted.iter().sum());
            check(&format!("{name} on {threads}"), ready, volume, &run.refined);
            let ratio = run.refined.num_tets() as f64 / tets as f64;
            let excused = [&rounds, &run.refined].map(|own| own.excuses.len());
            let row = format!(
                "| {name} | {threads} | {tets} | {ratio:.3} | {points} | {} for {} |",
                excused[1], excused[0]
            );
            println!("{row}");
            self.points += points;
            self.rows += 1;
            if !(0.97..=1.03).contains(&ratio) {
                self.outside.push(row);
            }
        }
    }

    fn add_kind(&mut self, kind: DomainKind, volume: f64, angle: Option<f64>) {
        let shape = Shape { angle, ..Shape::default() };
        let ready = prepared(&generate_domain(kind, &shape).expect("a shape"));
        let angle = angle.map_or_else(String::new, |degrees| format!(" of {degrees}"));
        self.add(&format!("{kind:?}{angle}, {volume:e}"), &ready, 0.0, Some(volume));
    }
}

/// The mesh conforms to the domain, and what is over a bound is excused.
fn check(name: &str, ready: &Prepared, volume: Option<f64>, refined: &Refined) {
    use ConformityDefect::{RatioExceeded, VolumeExceeded};
    use RefineOutcome::{Excused, Met, Unrecovered};
    let bounds = limits(&ready.domain, Some(2.0), volume);
    assert!(matches!(refined.outcome, Met | Excused | Unrecovered), "{name}");
    if refined.outcome == Unrecovered {
        return;
    }
    let (found, _) =
        judge_refined(ready, refined, &bounds).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(found.mesh_defect_count, 0, "{name}: {:?}", found.mesh_defects.first());
    let bounds = |b: &ConformityDefect| matches!(b, RatioExceeded | VolumeExceeded);
    assert!(
        !refined.lost.is_empty() || found.counts.keys().all(bounds),
        "{name}: {:?}",
        found.counts
    );
    // One tetrahedron may be over two bounds.
    let over = found.counts.values().copied().max().unwrap_or_default();
    assert!(over <= refined.excuses.len() as u64, "{name}: {:?}", found.counts);
}

#[test]
fn domains_have_as_many_tetrahedra_without_rounds_as_in_rounds() {
    let count = cases(FEW);
    let all = count > FEW;
    let mut table = Table::default();
    println!("| domain | threads | in rounds | without, times | by workers | excused |");
    println!("|---|--:|--:|--:|--:|---|");
    for (kind, volume, angle, _) in NAMED {
        table.add_kind(kind, volume, angle);
    }
    LARGER.into_iter().for_each(|(kind, volume)| table.add_kind(kind, volume, None));
    let larger = table.points;
    if all {
        PROBLEMS.into_iter().for_each(|(kind, volume, _)| table.add_kind(kind, volume, None));
    }
    for (name, domain) in generated().expect("shapes") {
        let is_one = |of: &[&str]| of.iter().any(|own| name.starts_with(own));
        if if all { is_one(&LARGE) } else { !is_one(&SMALL) } {
            continue;
        }
        let options =
            PrepareOptions { oriented: !name.ends_with(".poly"), ..PrepareOptions::default() };
        let ready = domain.prepare(&options).unwrap_or_else(|e| panic!("{name}: {e}"));
        table.add(&name, &ready, usual_tolerance(&domain, &ready.domain), None);
    }
    for seed in 0..u64::from(count) {
        for (name, domain) in [random_domain(seed), awkward_domain(seed)] {
            let ready = prepared(&domain);
            let volume = (seed % 2 == 0).then(|| small_volume(&ready.domain));
            table.add(
                &format!("{name} {seed}"),
                &ready,
                usual_tolerance(&domain, &ready.domain),
                volume,
            );
        }
    }
    let Table { rows, outside, points } = table;
    println!(
        "{} of {rows} within three in a hundred, {points} points by workers",
        rows - outside.len()
    );
    // Thin plates and the largest noisy prisms are among all.
    let most = if all { rows / 20 } else { 0 };
    assert!(outside.len() <= most, "{}", outside.join("\n"));
    assert!(rows > 100 && larger > 10_000, "{rows} rows, {larger} points by workers");
}

/// Whatever the order of tetrahedra and the place of their points: another mesh, within the bounds.
#[test]
fn every_strategy_meets_the_bounds() {
    let ready = prepared(&generate_domain(DomainKind::Gear, &Shape::default()).expect("a shape"));
    let whole = (&ready.domain, &ready.lattice);
    let volume = 4e-4;
    let refiner = Refiner::new().max_volume(volume);
    let plan = |points| Plan {
        layout: Layout::new(points, 3),
        config: Config { window: 16, ..Config::new(3) },
    };
    let mut hashes = BTreeSet::new();
    for order in Order::ALL {
        for towards in [0.0, Strategy::MOST] {
            let refiner = refiner.strategy(Strategy { order, towards }).start(200);
            let run = simulate_domain(&refiner, whole.0, whole.1, &plan, &Options::default());
            let run = run.unwrap_or_else(|error| panic!("{order}, {towards}: {error}"));
            check(&format!("{order}, {towards}"), &ready, Some(volume), &run.refined);
            assert_eq!(run.refined.outcome, RefineOutcome::Met, "{order}, {towards}");
            println!("| {order} | {towards} | {} |", run.refined.num_tets());
            hashes.insert(run.refined.mesh().hash().expect("a hash").to_string());
        }
    }
    assert_eq!(hashes.len(), 8);
}

/// Cases at random for [`no_timing_makes_far_more_points_than_rounds`].
const TIMED: u32 = 12;
/// The most points, times those of rounds and a few more: small needles have had 1.21.
const MOST: f64 = 1.5;

/// Whatever the times of messages, refinement without rounds makes about as many points as rounds
/// do: points that call for each other without end would be a run that nobody sees the end of.
#[test]
fn no_timing_makes_far_more_points_than_rounds() {
    use Distribution::{Constant, Exponential, HeavyTail, Uniform};
    let (laws, latencies) = ([Constant, Uniform, Exponential, HeavyTail], [100, 3_000, 90_000]);
    let (mut most, mut points) = (0.0_f64, 0);
    for seed in seeds(TIMED) {
        let turn = seed / 2;
        let (kind, domain) = if seed % 2 == 0 { random_domain(turn) } else { awkward_domain(turn) };
        let ready = prepared(&domain);
        // The kind hangs on the turn: all else is drawn apart from it.
        let drawn = (seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as usize;
        let volume = small_volume(&ready.domain) / (1 + seed % 5) as f64;
        let refiner = Refiner::new()
            .flat_tolerance(usual_tolerance(&domain, &ready.domain))
            .max_volume(volume)
            .start([0, 64, 256][drawn % 3]);
        let whole = (&ready.domain, &ready.lattice);
        // A domain may be out of reach for one as for the other.
        let Ok(rounds) = refiner.refine(whole.0, whole.1) else { continue };
        let made = |own: &Refined| {
            let RefineStats { segment_points, facet_points, free_points, .. } = own.stats;
            segment_points + facet_points + free_points
        };
        let expected = made(&rounds);
        // One that has no end ends so.
        let refiner = refiner.max_points(4 * expected + 4000);
        for (k, processors) in [2, 3, 5, 8].into_iter().enumerate() {
            let (distribution, latency) =
                (laws[(drawn / 3 + k) % 4], latencies[(drawn / 12 + k) % 3]);
            let name = format!("{kind} {seed} on {processors}, {distribution:?} {latency} ns");
            let network = Network { latency, distribution, ..Network::default() };
            let options = Options { network, seed, letters: k % 2 == 0, ..Options::default() };
            let plan = |points| {
                let config = Config { window: 16, ..Config::new(processors) };
                Plan { layout: Layout::new(points, processors), config }
            };
            let run = simulate_domain(&refiner, whole.0, whole.1, &plan, &options);
            let run = run.unwrap_or_else(|error| panic!("{name}: {error}"));
            let ratio = made(&run.refined) as f64 / (expected + 20) as f64;
            assert!(ratio < MOST, "{name}: {ratio} times the points of rounds, {:?}", run.splits);
            assert_ne!(run.refined.outcome, RefineOutcome::Budget, "{name}");
            most = most.max(ratio);
            points += run.splits.inserted.iter().sum::<u64>();
        }
    }
    println!("at most {most:.3} times the points of rounds, {points} by workers");
    assert!(points > 5_000, "{points} points by workers");
}
