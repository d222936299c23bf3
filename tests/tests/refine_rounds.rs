//! Refinement in rounds: one mesh whatever the order of insertion, judged by the independent
//! checker and against splitting one item after the other.
//!
//! Random domains: 50 by default, `LTBW_CASES` for more (500 for the full bar). Named domains: five
//! orders, `LTBW_ORDERS` for more (22). Surfaces: some by formula, and those of the folder
//! `LTBW_PARTS`, if it is set.

use ltbw::Random;
use ltbw::domain::{Domain, Facet, PrepareOptions, Prepared};
use ltbw::quality::{Quality, SMALL_ANGLES};
use ltbw::refine::{InsertOrder, RefineOutcome, Refined, Refiner, usual_tolerance};
use ltbw_generate::surfaces::book;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_tests::cases;
use ltbw_tests::compare::same_refined;
use ltbw_tests::domains::{NAMED, PROBLEMS, prepared, random_domain, small_volume};
use ltbw_tests::excuses::judge_refined;
use ltbw_tests::parts::for_each_surface;
use ltbw_verify::{ConformityDefect, Limits};

/// The orders that every domain is refined in.
const ORDERS: [InsertOrder; 5] = [
    InsertOrder::Hilbert,
    InsertOrder::Forwards,
    InsertOrder::Backwards,
    InsertOrder::Random(1),
    InsertOrder::Random(2),
];

/// These orders, and as many by chance as `LTBW_ORDERS` asks for.
fn orders() -> Vec<InsertOrder> {
    let text = std::env::var("LTBW_ORDERS").unwrap_or_else(|_| ORDERS.len().to_string());
    let count: u64 = text.parse().expect("LTBW_ORDERS is a whole number");
    let more = (ORDERS.len() as u64..count).map(InsertOrder::Random);
    ORDERS.into_iter().chain(more).collect()
}

/// Refines in some orders, from `start` vertices on: one hash, one list of excuses, the same
/// arrays, of which files are made. Judges the mesh.
fn one_mesh(
    (ready, name): (&Prepared, &str),
    refiner: &Refiner<'_>,
    start: usize,
    orders: &[InsertOrder],
) -> Refined {
    let run = |order| {
        let refiner = refiner.insert_order(order).start(start);
        refiner.refine(&ready.domain, &ready.lattice).unwrap_or_else(|e| panic!("{name}: {e}"))
    };
    let first = run(orders[0]);
    for order in &orders[1..] {
        same_refined(&format!("{name} {order:?}"), &first, &run(*order));
    }
    let limits = Limits { radius_edge: Some(2.0), ..Limits::default() };
    assert!(first.lost.is_empty(), "{name}: {:?}", first.lost.first());
    let judged = judge_refined(ready, &first, &limits);
    let (found, count) = judged.unwrap_or_else(|defect| panic!("{name}: {defect}"));
    assert!(!count.is_broken(), "{name}: {count}");
    let bounds = |b: &ConformityDefect| matches!(b, ConformityDefect::RatioExceeded);
    assert!(found.counts.keys().all(bounds), "{name}: {:?}", found.findings.first());
    first
}

/// Sheets at small angles are split together for the sake of size.
#[test]
fn sheets_have_one_mesh_for_all_orders() {
    for (sheets, angle) in [(2, 10.0), (3, 5.0), (6, 10.0)] {
        let (ready, name) = (prepared(&book(sheets, angle)), format!("{sheets} sheets, {angle}"));
        let refiner = Refiner::new().max_volume(5e-3);
        let refined = one_mesh((&ready, &name), &refiner, 0, &orders());
        let excused: f64 = refined.excused().iter().map(|own| own.volume).sum();
        assert!(excused <= 0.04 * refined.volume(), "{name}: {excused:e}");
    }
}

#[test]
fn random_domains_have_one_mesh_for_all_orders() {
    let count = cases(50);
    let (mut excused, mut excused_singly, mut points) = (0, 0, 0);
    for seed in 0..count as u64 {
        let (name, domain) = random_domain(seed);
        let (name, ready) = (format!("{name} {seed}"), prepared(&domain));
        // One in two has a bound on volumes, or few would need any point.
        let volume = small_volume(&ready.domain);
        let refiner = Refiner::new();
        let refiner = if seed % 2 == 0 { refiner.max_volume(volume) } else { refiner };
        let rounds = one_mesh((&ready, &name), &refiner, 0, &ORDERS);
        let single =
            refiner.start(usize::MAX).refine(&ready.domain, &ready.lattice).expect("a mesh");
        if single.outcome == RefineOutcome::Met {
            assert_eq!(rounds.outcome, RefineOutcome::Met, "{name}");
        }
        excused += rounds.excuses.len();
        excused_singly += single.excuses.len();
        points += rounds.stats.round_points;
    }
    println!("{count} domains, {points} points by rounds; excused: {excused} tetrahedra");
    println!("excused one by one: {excused_singly}");
    assert!(points > 10 * count as u64);
    assert!(excused <= excused_singly, "{excused} {excused_singly}");
}

/// 20 random domains by default, `LTBW_CASES` for more (100 for the full bar). Beside small angles
/// of the domain, and where a bound is excused, tetrahedra may stay flat.
#[test]
fn random_domains_have_few_small_angles() {
    let count = cases(20);
    let (mut plain, mut tets, mut below, mut left) = (0, 0, 0, 0);
    for seed in 0..count as u64 {
        let (name, domain) = random_domain(seed);
        let (name, ready) = (format!("{name} {seed}"), prepared(&domain));
        let volume = small_volume(&ready.domain);
        let refiner = Refiner::new();
        let refiner = if seed % 2 == 0 { refiner.max_volume(volume) } else { refiner };
        let refine = |refiner: Refiner<'_>| {
            refiner.refine(&ready.domain, &ready.lattice).unwrap_or_else(|e| panic!("{name}: {e}"))
        };
        let refined = refine(refiner);
        plain += refine(refiner.min_dihedral(0.0)).num_tets();
        tets += refined.num_tets();
        let mesh = refined.inside();
        let quality = Quality::of(&mesh.points, &mesh.tets).expect("tetrahedra");
        let own = refined.slivers.iter().filter(|sliver| sliver.angle < SMALL_ANGLES[1]);
        assert_eq!(own.clone().count() as u64, quality.small[1], "{name}: all are told");
        let is_excused = |tet| refined.excuses.iter().any(|excuse| excuse.tet == tet);
        let nameless = own.filter(|sliver| sliver.near.is_none() && !is_excused(sliver.tet));
        below += quality.small[1];
        left += nameless.count();
    }
    let more = tets as f64 / plain as f64;
    println!(
        "{count} domains, {tets} tetrahedra, {more:.3} times those without; below 5 degrees: \
         {below}, {left} of them without a small angle of the domain beside"
    );
    assert!(left * 2000 <= tets, "{left} of {tets}");
    assert!(more <= 1.12, "{more}");
}

#[test]
fn the_problems_of_the_paper_need_no_more_tetrahedra_than_tetgen() {
    for (kind, volume, most) in PROBLEMS {
        let ready = prepared(&generate_domain(kind, &Shape::default()).expect("a domain"));
        let refiner = Refiner::new().max_volume(volume).start(4096);
        let plain = refiner.min_dihedral(0.0).refine(&ready.domain, &ready.lattice);
        let plain = plain.expect("a mesh").num_tets();
        assert!(plain <= most, "{kind:?}: {plain}");
        let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
        assert_eq!(refined.outcome, RefineOutcome::Met, "{kind:?}");
        // No sliver is left, for one in twenty tetrahedra more.
        let tets = refined.num_tets();
        assert!(refined.slivers.is_empty(), "{kind:?}: {:?}", refined.slivers);
        assert!(tets * 20 <= plain * 21, "{kind:?}: {plain} {tets}");
        let stats = refined.stats;
        let searches = stats.searches as f64 / stats.round_points as f64;
        assert!(searches <= 1.6, "{kind:?}: {searches}");
        assert!(stats.rounds <= 100, "{kind:?}: {:?}", stats.rounds);
    }
}

/// The files of a refined domain.
fn files(refined: &Refined, name: &str) -> Vec<Vec<u8>> {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    let mesh = refined.with_exterior();
    for end in ["vtu", "mesh", "msh", "ele"] {
        let path = folder.join(format!("{name}.{end}"));
        ltbw::io::write_mesh(&path, &mesh).expect("a file");
    }
    let read = |end| std::fs::read(folder.join(format!("{name}.{end}"))).expect("a file");
    ["vtu", "mesh", "msh", "ele", "node"].map(read).to_vec()
}

#[test]
fn files_are_equal_byte_for_byte_for_all_orders() {
    let cases =
        [(DomainKind::Gear, 1e-3), (DomainKind::TwoMaterial, 1e-2), (DomainKind::Tee, 1e-3)];
    for (kind, volume) in cases {
        let ready = prepared(&generate_domain(kind, &Shape::default()).expect("a domain"));
        let run = |order| {
            let refiner = Refiner::new().max_volume(volume).insert_order(order).start(0);
            let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
            assert!(refined.stats.round_points > 0, "{kind:?}");
            files(&refined, &format!("rounds-{kind:?}"))
        };
        let first = run(ORDERS[0]);
        assert!(first.iter().all(|file| file.len() > 1000), "{kind:?}");
        for order in &ORDERS[1..] {
            assert!(run(*order) == first, "{kind:?} {order:?}");
        }
    }
}

/// Every order of every round: a round of n points has n! of them, which all numbers below m! go
/// through, m being the widest round.
#[test]
fn every_order_of_every_round_of_tiny_domains_gives_one_mesh() {
    let (mut domains, mut rounds, mut runs) = (0, 0, 0);
    for (kind, angle) in [
        (DomainKind::LBlock, None),
        (DomainKind::Schoenhardt, None),
        (DomainKind::TwoMaterial, None),
        (DomainKind::Stair, None),
        (DomainKind::Wedge, Some(45.0)),
        (DomainKind::Wedge, Some(10.0)),
        (DomainKind::Spike, Some(20.0)),
        (DomainKind::Spike, Some(5.0)),
        (DomainKind::CubeInCube, None),
    ] {
        let ready = prepared(
            &generate_domain(kind, &Shape { angle, ..Shape::default() }).expect("a domain"),
        );
        for (volume, start) in [(0.3, 0), (0.1, 0), (0.03, 0), (0.03, 60), (0.01, 0), (0.01, 90)] {
            let run = |n| {
                let refiner = Refiner::new()
                    .max_volume(volume)
                    .insert_order(InsertOrder::Nth(n))
                    .start(start);
                refiner.refine(&ready.domain, &ready.lattice).expect("a mesh")
            };
            let first = run(0);
            let (hash, widest) = (first.mesh().hash().expect("a hash"), first.stats.widest);
            if !(2..=6).contains(&widest) {
                continue;
            }
            let orders: u64 = (1..=widest).product();
            for n in 1..orders {
                let (other, name) = (run(n), format!("{kind:?} {volume} order {n}"));
                assert_eq!(other.mesh().hash().expect("a hash"), hash, "{name}");
                assert_eq!(other.stats.rounds, first.stats.rounds, "{name}");
                assert!(other.with_exterior() == first.with_exterior(), "{name}");
            }
            domains += 1;
            rounds += first.stats.rounds;
            runs += orders;
        }
    }
    println!("{domains} domains, {rounds} rounds, {runs} runs");
    assert!(domains >= 14 && rounds >= 400 && runs >= 240, "{domains} {rounds} {runs}");
}

#[test]
fn refined_domains_have_their_golden_hashes() {
    let mut wrong = Vec::new();
    for (kind, volume, angle, golden) in NAMED {
        let shape = Shape { angle, ..Shape::default() };
        let ready = prepared(&generate_domain(kind, &shape).expect("a domain"));
        let refiner = Refiner::new().max_volume(volume).start(256);
        let found = [refiner, refiner.min_dihedral(0.0)].map(|refiner| {
            let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
            refined.mesh().hash().expect("a hash").to_string()[..16].to_owned()
        });
        if found != golden {
            wrong.push(format!("(DomainKind::{kind:?}, {volume:e}, {angle:?}, {found:?}),"));
        }
    }
    assert!(wrong.is_empty(), "other hashes:\n{}", wrong.join("\n"));
}

/// A prism over a polygon of n corners, its sides cut into triangles, with noise: sides that are
/// long, narrow and nearly coplanar wait for each other in circles.
fn prism(n: u32) -> Domain {
    let mut random = Random::new(1);
    let mut domain = Domain::default();
    for z in [-0.5, 0.5] {
        for k in 0..n {
            let turn = 2.0 * std::f64::consts::PI * f64::from(k) / f64::from(n);
            let factor = 1.0 + 1e-7 * (2.0 * random.unit() - 1.0);
            domain.vertices.push([0.5 * turn.cos(), 0.5 * turn.sin(), z].map(|c| c * factor));
        }
    }
    let mut add = |corners: [u32; 3]| domain.facets.push(Facet::polygon(&corners, 0));
    for k in 0..n {
        let l = (k + 1) % n;
        add([k, l, n + l]);
        add([k, n + l, n + k]);
    }
    for k in 1..n - 1 {
        add([0, k + 1, k]);
        add([n, n + k, n + k + 1]);
    }
    domain
}

#[test]
fn joint_steps_at_the_hull_are_the_same_for_all_orders() {
    let mut phases = 0;
    for n in [8, 12, 16, 24, 32, 48] {
        let ready = prepared(&prism(n));
        let name = format!("a prism of {n} sides");
        let refined = one_mesh((&ready, &name), &Refiner::new(), 0, &orders());
        phases += refined.stats.joint_phases;
    }
    assert!(phases > 0);
}

#[test]
fn named_domains_have_one_mesh_for_all_orders() {
    let (orders, mut points) = (orders(), 0);
    for (kind, volume, angle, _) in NAMED {
        let shape = Shape { angle, ..Shape::default() };
        let ready = prepared(&generate_domain(kind, &shape).expect("a domain"));
        let (name, refiner) = (format!("{kind:?} {volume}"), Refiner::new().max_volume(volume));
        points += one_mesh((&ready, &name), &refiner, 0, &orders).stats.round_points;
    }
    println!("{} domains in {} orders, {points} points by rounds", NAMED.len(), orders.len());
    assert!(points > 5_000, "{points}");
}

/// Surfaces by formula, rounded to 32-bit floats, some turned; then the parts of the folder
/// `LTBW_PARTS`, if it is set. All with patches within the usual tolerance, and without.
#[test]
fn surfaces_have_one_mesh_for_all_orders() {
    for_each_surface(judged);
}

/// Refines a surface in all orders, and judges it beside one item after the other; `false` if it is
/// not sound or not recovered.
fn judged(name: &str, domain: &Domain, oriented: bool) -> bool {
    let options = PrepareOptions { oriented, ..PrepareOptions::default() };
    let Ok(ready) = domain.prepare(&options) else { return false };
    for tolerance in [usual_tolerance(domain, &ready.domain), 0.0] {
        let refiner = Refiner::new().flat_tolerance(tolerance);
        let single =
            refiner.start(usize::MAX).refine(&ready.domain, &ready.lattice).expect("a mesh");
        if !single.lost.is_empty() {
            println!("{name}: not recovered, {} items", single.lost.len());
            return false;
        }
        let rounds = one_mesh((&ready, name), &refiner, 0, &orders());
        let both = [&rounds, &single];
        let (excused, tets) = (both.map(|r| r.excuses.len()), both.map(Refined::num_tets));
        let patches = rounds.stats.patches;
        println!("{name}: {patches} patches, excused {excused:?} of {tets:?} (rounds, one by one)");
        assert_eq!(patches, single.stats.patches, "{name}");
        if single.outcome == RefineOutcome::Met {
            assert_eq!(rounds.outcome, RefineOutcome::Met, "{name}");
        }
    }
    true
}
