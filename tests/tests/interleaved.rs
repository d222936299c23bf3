//! The real mesh under `interleave`: events in random order, first in, first out between each pair
//! of workers. The mesh is the sequential kernel's, and nothing is left locked, awaited or under
//! way. Every third run sends all messages through bytes.

use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Closure, Rule, SubmeshError, WorkerId};
use ltbw::refine::Refiner;
use ltbw::{Point, PointSet};
use ltbw_generate::{DomainKind, PointKind, Shape, generate, generate_domain};
use ltbw_tests::domains::prepared;
use ltbw_tests::interleave::{Case, Chooser, Figures, Refusal, Tempo};

/// Plays `points` with ownership by the newest vertex, and by blocks, which move; returns setbacks
/// and operations committed of the latter.
fn run(points: Vec<Point>, layout: Layout, rule: Rule, moves: u32, seed: u64) -> (usize, usize) {
    let choice = (rule, Closure::Face);
    let newest = Layout { ownership: Ownership::Newest, ..layout };
    run_as(points.clone(), newest, choice, 0, seed);
    run_as(points, layout, choice, moves, seed)
}

/// [`run`] with a closure.
fn run_as(
    points: Vec<Point>,
    layout: Layout,
    (rule, closure): (Rule, Closure),
    moves: u32,
    seed: u64,
) -> (usize, usize) {
    let bytes = seed.is_multiple_of(3);
    let tempo = Tempo::Even;
    let case = Case { layout, rule, closure, tempo, slow: None, moves, cancel: None, bytes };
    let Figures { setbacks, committed, .. } = play(points, case, seed);
    (setbacks, committed)
}

fn play(points: Vec<Point>, case: Case, seed: u64) -> Figures {
    // Shown if the test fails.
    println!("seed {seed}, {} points, {case:?}", points.len());
    let set = PointSet::new(points).expect("finite points");
    let played = case.play(&set, &mut Chooser::new(&[], seed));
    played.unwrap_or_else(|error| panic!("{error}")).figures
}

fn layout(workers: u32, sample: usize) -> Layout {
    Layout {
        workers,
        blocks_per_worker: 4,
        cursors: 4,
        max_in_flight: 5,
        sample,
        ..Layout::new(0, 1)
    }
}

#[test]
fn one_worker_is_the_sequential_kernel() {
    for kind in [PointKind::Uniform, PointKind::Grid] {
        let (setbacks, committed) =
            run(generate(kind, 2000, 1), layout(1, 10), Rule::WoundWait, 0, 1);
        assert_eq!((setbacks, committed), (0, 0), "nothing is in the way of one worker");
    }
}

#[test]
fn the_mesh_is_one_for_any_number_of_workers_and_any_timing() {
    let mut total = (0, 0);
    for seed in 0..12u64 {
        for workers in [2, 3, 5, 8] {
            for kind in [PointKind::Uniform, PointKind::Grid, PointKind::Clusters] {
                let points = generate(kind, 400, seed);
                let (setbacks, committed) =
                    run(points, layout(workers, 20), Rule::WoundWait, 0, seed);
                total = (total.0 + setbacks, total.1 + committed);
            }
        }
    }
    assert!(total.0 > 20 && total.1 > 5000, "too tame to show anything: {total:?}");
}

#[test]
fn every_rule_gives_the_mesh() {
    for rule in [Rule::Paper] {
        let mut setbacks = 0;
        for seed in 0..8 {
            for workers in [2, 4, 7] {
                let points = generate(PointKind::Uniform, 300, seed);
                setbacks += run(points, layout(workers, 20), rule, 0, seed).0;
            }
        }
        assert!(setbacks > 50, "{rule} is hardly ever set back: {setbacks}");
    }
}

#[test]
fn blocks_that_move_change_nothing() {
    for rule in Rule::ALL {
        for seed in 0..12 {
            for workers in [2, 3, 6] {
                let kind = if seed % 2 == 0 { PointKind::Uniform } else { PointKind::Grid };
                run(generate(kind, 300, seed), layout(workers, 20), rule, 60, seed);
            }
        }
    }
}

#[test]
fn the_papers_closure_and_ownership_give_the_mesh() {
    let mut setbacks = 0;
    for seed in 0..12 {
        let rule = Rule::ALL[seed as usize % 2];
        let kind = if seed % 2 == 0 { PointKind::Uniform } else { PointKind::Grid };
        for workers in [2, 5] {
            let points = || generate(kind, 250, seed);
            let layout = layout(workers, 20);
            let choice = (rule, Closure::Vertex);
            setbacks += run_as(points(), layout, choice, 40, seed).0;
            let layout = Layout { ownership: Ownership::Creator, ..layout };
            setbacks += run_as(points(), layout, choice, 0, seed).0;
        }
    }
    assert!(setbacks > 500, "hardly ever set back: {setbacks}");
}

#[test]
fn stars_of_the_newest_vertex_give_the_mesh() {
    let mut setbacks = 0;
    for seed in 0..40 {
        let rule = Rule::ALL[seed as usize % 2];
        let kind =
            [PointKind::Uniform, PointKind::Grid, PointKind::Clusters][seed as usize / 3 % 3];
        for workers in [2, 3, 8] {
            let layout = Layout { ownership: Ownership::Newest, ..layout(workers, 20) };
            let choice = (rule, Closure::ALL[seed as usize / 9 % 2]);
            setbacks += run_as(generate(kind, 250, seed), layout, choice, 0, seed).0;
        }
    }
    assert!(setbacks > 100, "hardly ever set back: {setbacks}");
}

#[test]
fn small_sets_empty_workers_and_one_block() {
    for seed in 0..40 {
        for count in [4, 5, 6, 8, 10, 20] {
            for workers in [2, 9, 30] {
                let points = generate(PointKind::Uniform, count, seed);
                run(points, layout(workers, 4), Rule::WoundWait, 10, seed);
            }
        }
    }
    // All points but one in the block of one worker; many points equal.
    let mut points = generate(PointKind::Uniform, 200, 7);
    points.extend(points.clone());
    points.push([1e6; 3]);
    run(points, layout(6, 10), Rule::WoundWait, 10, 3);
}

#[test]
fn degenerate_and_wide_sets() {
    for seed in 0..4 {
        for kind in [PointKind::Grid, PointKind::Sphere, PointKind::Lines, PointKind::Moment] {
            run(generate(kind, 216, seed), layout(4, 12), Rule::WoundWait, 20, seed);
        }
        let scales = [1.0, 1e-300, 1e300];
        let points = generate(PointKind::Uniform, 200, seed);
        let wide = points.iter().zip((0..3).cycle()).map(|(p, k)| p.map(|c| c * scales[k]));
        run(wide.collect(), layout(3, 12), Rule::WoundWait, 10, seed);
    }
}

/// A worker that is told of a cancel starts no more points, not even those of a block that moves to
/// it afterwards. (The world looks at that after every event.)
#[test]
fn a_cancelled_worker_takes_in_no_points() {
    let (mut moved, mut inserted) = (0, 0);
    for (seed, ownership) in (0..80).flat_map(|seed| Ownership::ALL.map(|o| (seed, o))) {
        // Also before a worker has given its first point.
        let cancel = Some(10 * seed as usize);
        let case = Case {
            layout: Layout { ownership, ..layout(4, 20) },
            rule: Rule::WoundWait,
            closure: Closure::Face,
            tempo: Tempo::ALL[seed as usize % 4],
            slow: None,
            moves: if ownership == Ownership::Block { 400 } else { 0 },
            cancel,
            bytes: false,
        };
        let figures = play(generate(PointKind::Uniform, 300, seed), case, seed);
        moved += figures.moved;
        if ownership == Ownership::Block {
            inserted += figures.committed;
        }
    }
    assert!(moved > 100 && inserted > 100, "too tame: {moved} moves, {inserted} operations");
}

/// The limit of tetrahedra, lowered: whatever the order, the run ends with a typed error, or with
/// the whole mesh.
#[test]
fn a_run_without_room_fails_and_says_why() {
    let (mut whole, mut failed) = (0, 0);
    for seed in 0..90 {
        let kind = [PointKind::Uniform, PointKind::Lines, PointKind::Grid][seed as usize % 3];
        let points = generate(kind, 60, seed);
        let set = PointSet::new(points).expect("finite points");
        let ownership = Ownership::ALL[seed as usize / 3 % 3];
        let max_tets = 60 + 25 * (seed as usize % 19);
        let case = Case {
            layout: Layout { ownership, max_tets, ..layout(2 + seed as u32 % 3, 12) },
            rule: Rule::WoundWait,
            closure: Closure::Face,
            tempo: Tempo::ALL[seed as usize % 4],
            slow: None,
            moves: if ownership == Ownership::Block { 10 } else { 0 },
            cancel: None,
            bytes: seed % 2 == 0,
        };
        println!("seed {seed}, {case:?}");
        match case.play(&set, &mut Chooser::new(&[], seed)) {
            Ok(_) => whole += 1,
            Err(Refusal::Submesh(worker, SubmeshError::NoRoom { limit })) => {
                assert!(worker < WorkerId::new(case.layout.workers) && limit == max_tets);
                failed += 1;
            }
            Err(other) => panic!("{other}"),
        }
    }
    assert!(whole > 10 && failed > 20, "{whole} whole, {failed} failed");
}

#[test]
fn domains_in_rounds_have_the_engines_mesh() {
    let cases = [
        (DomainKind::CubeOctahedron, 1e-2),
        (DomainKind::CubeInCube, 2e-2),
        (DomainKind::LBlock, 1e-2),
        (DomainKind::TwoMaterial, 2e-2),
        (DomainKind::Stair, 2e-2),
    ];
    let (mut committed, mut setbacks, mut by_workers) = (0, 0, 0);
    for seed in 0..20 {
        let (kind, volume) = cases[seed as usize % cases.len()];
        let ready = prepared(&generate_domain(kind, &Shape::default()).expect("a domain"));
        let refiner = Refiner::new().max_volume(volume).start(0);
        let ownership = [Ownership::Newest, Ownership::Block][seed as usize / 2 % 2];
        let case = Case {
            layout: Layout { ownership, ..layout(2 + seed as u32 % 6, 10) },
            rule: Rule::WoundWait,
            closure: Closure::Face,
            tempo: Tempo::ALL[seed as usize / 5 % 4],
            slow: (seed % 3 == 0).then_some(seed as usize % 2),
            moves: 0,
            cancel: (seed % 8 == 7).then_some(50 * seed as usize),
            bytes: false,
        };
        // Shown if the test fails.
        println!("seed {seed}, {kind:?}, {case:?}");
        let (figures, end) = case.refine(&refiner, &ready, &mut Chooser::new(&[], seed));
        committed += figures.committed;
        setbacks += figures.setbacks;
        by_workers += usize::from(end.is_ok());
    }
    println!("{committed} operations on several workers, {setbacks} setbacks, {by_workers} runs");
    assert_eq!(by_workers, 20);
    assert!(committed > 1_000 && setbacks > 20, "{committed} {setbacks}");
}
