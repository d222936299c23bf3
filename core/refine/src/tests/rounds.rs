//! Rounds: one mesh whatever the order of insertion, and the rules that make it so.

use super::sharp::{larger, over, relieve};
use super::{check_conforming, check_marks, model, ready, refine};
use crate::complex::dihedral::DihedralBound;
use crate::late::relief::Goal;
use crate::{InsertOrder, Reason, RefineError, RefineOutcome, Refined, Refiner};
use ltbw_core::invariants::check_all;
use ltbw_core::mesh::Vertex;
use ltbw_core::topology::TetId;
use ltbw_domain::{Domain, Facet, PrepareOptions, Prepared};
use ltbw_exact::Point;
use ltbw_generate::{DomainKind, Shape};

/// All orders of a round that are tried.
const ORDERS: [InsertOrder; 8] = [
    InsertOrder::Hilbert,
    InsertOrder::Forwards,
    InsertOrder::Backwards,
    InsertOrder::Random(1),
    InsertOrder::Random(2),
    InsertOrder::Random(3),
    InsertOrder::Random(4),
    InsertOrder::Random(5),
];

/// An excuse by the coordinates of its tetrahedron.
type PlacedExcuse = (Vec<[u64; 3]>, Reason);

/// The excuses of a refinement, in an order of their own.
fn excuses(refined: &Refined) -> Vec<PlacedExcuse> {
    let points: std::collections::HashMap<Vertex, Point> = refined.mesh().vertices().collect();
    let place = |v: &Vertex| points[v].map(|c| (c + 0.0).to_bits());
    let mut all: Vec<PlacedExcuse> = refined
        .excuses
        .iter()
        .map(|excuse| {
            let mut corners: Vec<_> =
                refined.mesh().tet(excuse.tet).expect("a tetrahedron").iter().map(place).collect();
            corners.sort_unstable();
            (corners, excuse.reason)
        })
        .collect();
    all.sort_unstable();
    all
}

/// Refines in rounds in all orders: one hash, one list of excuses. Returns one of the results.
fn one_mesh(refiner: &Refiner<'_>, ready: &Prepared, start: usize, name: &str) -> Refined {
    let run = |order| refine(&refiner.insert_order(order).start(start), ready);
    let first = run(ORDERS[0]);
    let hash = first.mesh().hash().expect("a hash");
    for order in &ORDERS[1..] {
        let other = run(*order);
        assert_eq!(other.mesh().hash().expect("a hash"), hash, "{name} {order:?}");
        assert_eq!(other.outcome, first.outcome, "{name} {order:?}");
        assert_eq!(excuses(&other), excuses(&first), "{name} {order:?}");
        assert_eq!(other.num_tets(), first.num_tets(), "{name} {order:?}");
        let both =
            [[&other, &first].map(Refined::inside), [&other, &first].map(Refined::with_exterior)];
        for [a, b] in both {
            assert!(a.points == b.points, "{name} {order:?}: points");
            assert!(a.tets == b.tets, "{name} {order:?}: tetrahedra");
            assert!(a.tet_tags == b.tet_tags, "{name} {order:?}: regions");
            assert_eq!(a.faces, b.faces, "{name} {order:?}: boundary");
        }
        assert_eq!(other.subfaces(), first.subfaces(), "{name} {order:?}: subfaces");
    }
    check_all(first.mesh()).expect("invariants of the mesh");
    check_marks(&first.state);
    let is_beyond_help = first.num_tets() == first.excuses.len();
    let rounds = first.stats.rounds;
    assert!(rounds > 0 || is_beyond_help, "{name}: {:?}", first.stats);
    first
}

#[test]
fn the_problems_of_the_paper_have_one_mesh_for_all_orders() {
    let cases = [
        (DomainKind::CubeOctahedron, 1e-4),
        (DomainKind::CubeInCube, 1e-4),
        (DomainKind::Tee, 1e-3),
        (DomainKind::Gear, 4e-4),
    ];
    for (kind, volume) in cases {
        let ready = ready(kind, &Shape::default());
        for start in [0, 512] {
            let name = format!("{kind:?} {start}");
            let refined = one_mesh(&Refiner::new().max_volume(volume), &ready, start, &name);
            assert_eq!(refined.outcome, RefineOutcome::Met, "{name}");
            check_conforming(&refined.state);
            let single = refine(&Refiner::new().max_volume(volume).start(usize::MAX), &ready);
            // The largest circumradius first needs fewer points, but for a coarse gear.
            assert!(refined.num_tets() <= single.num_tets() * 105 / 100, "{name}");
        }
    }
}

/// Refines in rounds on some numbers of threads: all is the same, with the figures of the rounds.
fn one_mesh_on_threads(refiner: &Refiner<'_>, ready: &Prepared, name: &str) {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let refined = pool.install(|| refine(&refiner.start(64), ready));
        assert_eq!(refined.stats.round_threads, threads, "{name}");
        refined
    };
    let first = run(1);
    let hash = first.mesh().hash().expect("a hash");
    for threads in [2, 3, 4, 8] {
        let other = run(threads);
        assert_eq!(other.mesh().hash().expect("a hash"), hash, "{name} on {threads}");
        assert_eq!(other.outcome, first.outcome, "{name} on {threads}");
        assert_eq!(excuses(&other), excuses(&first), "{name} on {threads}");
        let [a, b] = [&other, &first].map(Refined::with_exterior);
        assert!(a.points == b.points && a.tets == b.tets, "{name} on {threads}");
        assert!(a.tet_tags == b.tet_tags && a.faces == b.faces, "{name} on {threads}");
        let figures = |refined: &Refined| {
            let stats = refined.stats;
            (stats.rounds, stats.widest, stats.round_points, stats.searches, stats.joint_phases)
        };
        assert_eq!(figures(&other), figures(&first), "{name} on {threads}");
    }
    check_all(first.mesh()).expect("invariants of the mesh");
    assert!(first.stats.widest > 5, "{name}: {:?}", first.stats);
}

/// Here a thread is given as little as three probes.
#[test]
fn any_number_of_threads_chooses_the_same_points() {
    let cases = [
        (DomainKind::CubeOctahedron, 1e-4),
        (DomainKind::CubeInCube, 1e-4),
        (DomainKind::Tee, 1e-3),
        (DomainKind::Gear, 4e-4),
    ];
    for (kind, volume) in cases {
        let ready = ready(kind, &Shape::default());
        one_mesh_on_threads(&Refiner::new().max_volume(volume), &ready, &format!("{kind:?}"));
    }
    for angle in [30.0, 10.0, 5.0] {
        let ready = ready(DomainKind::Wedge, &Shape { angle: Some(angle), ..Shape::default() });
        one_mesh_on_threads(&Refiner::new().max_volume(2e-5), &ready, &format!("wedge {angle}"));
    }
    let mut two = ready(DomainKind::TwoMaterial, &Shape::default());
    two.domain.regions[0].max_volume = Some(3e-4);
    two.domain.regions[1].max_volume = Some(1e-3);
    one_mesh_on_threads(&Refiner::new(), &two, "two materials");
    let field = |p: Point| 0.05 + 0.1 * p[0];
    one_mesh_on_threads(&Refiner::new().sizing(&field), &model(), "a field");
    one_mesh_on_threads(&Refiner::new().max_volume(1e-4).max_points(900), &model(), "a budget");
    let sheets = surface!(ltbw_generate::surfaces::book(2, 12.0));
    one_mesh_on_threads(&Refiner::new().max_volume(3e-4), &sheets, "sheets at a small angle");
    let ready = surface!(ltbw_generate::surfaces::torus(12));
    let refiner = Refiner::new().flat_tolerance(5e-7).max_volume(1e-3);
    one_mesh_on_threads(&refiner, &ready, "a torus with patches and slivers");
}

#[test]
fn small_angles_have_one_mesh_for_all_orders() {
    let mut excused = 0;
    let shapes = [60.0, 45.0, 30.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.1]
        .into_iter()
        .flat_map(|angle| [(DomainKind::Wedge, angle), (DomainKind::Spike, angle)]);
    for (kind, angle) in shapes.filter(|&(kind, a)| kind == DomainKind::Wedge || a < 45.0) {
        let ready = ready(kind, &Shape { angle: Some(angle), ..Shape::default() });
        let refiner = Refiner::new().max_volume(2e-3);
        let refined = one_mesh(&refiner, &ready, 0, &format!("{kind:?} {angle}"));
        assert!(refined.lost.is_empty(), "{kind:?} {angle}");
        let single = refine(&refiner.start(usize::MAX), &ready);
        if angle > 20.0 {
            let outcomes = [refined.outcome, single.outcome];
            assert_eq!(outcomes, [RefineOutcome::Met; 2], "{kind:?} {angle}");
        }
        excused += refined.excuses.len();
        // Where needles were halved in rounds alone, up to 30 were excused.
        if kind == DomainKind::Spike {
            assert!(refined.excuses.len() <= 4, "{angle}: {}", refined.excuses.len());
        }
        // Shapes are excused, not sizes: more of them the thinner the wedge is.
        let name = format!("{kind:?} {angle}");
        assert_eq!([&refined, &single].map(|r| larger(r, 2e-3)), [0, 0], "{name}");
    }
    assert!(excused > 0 && excused <= 200, "{excused}");
}

#[test]
fn regions_fields_and_re_entrant_corners_have_one_mesh_for_all_orders() {
    for kind in [DomainKind::LBlock, DomainKind::Stair, DomainKind::Schoenhardt] {
        let ready = ready(kind, &Shape::default());
        let refined = one_mesh(&Refiner::new().max_volume(1e-2), &ready, 0, &format!("{kind:?}"));
        assert_eq!(refined.outcome, RefineOutcome::Met, "{kind:?}");
    }
    let mut two = ready(DomainKind::TwoMaterial, &Shape::default());
    two.domain.regions[0].max_volume = Some(1e-3);
    two.domain.regions[1].max_volume = Some(1e-2);
    let refined = one_mesh(&Refiner::new(), &two, 0, "two materials");
    assert_eq!((refined.outcome, refined.regions.len()), (RefineOutcome::Met, 3));
    let field = |p: Point| 0.05 + 0.2 * p[0];
    let refined = one_mesh(&Refiner::new().sizing(&field), &model(), 0, "a field");
    assert_eq!(refined.outcome, RefineOutcome::Met);
}

#[test]
fn thin_plates_have_one_numbering_for_all_orders() {
    for thin in [0.05, 0.02, 0.01, 0.004] {
        let at = |i: u32, k: u32| f64::from(i >> k & 1);
        let mut plate = Domain {
            vertices: (0..8).map(|i| [at(i, 0), at(i, 1) * 0.9, at(i, 2) * thin]).collect(),
            ..Domain::default()
        };
        for corners in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            plate.facets.push(Facet::polygon(&corners, 0));
        }
        let ready = plate.prepare(&PrepareOptions::default()).expect("a sound domain");
        let refined = one_mesh(&Refiner::new(), &ready, 0, &format!("a plate of {thin}"));
        assert_eq!(refined.outcome, RefineOutcome::Met);
    }
}

#[test]
fn a_budget_ends_rounds_before_one_that_would_exceed_it() {
    let refiner = Refiner::new().max_volume(2e-4).max_points(600);
    let refined = one_mesh(&refiner, &model(), 0, "a budget");
    assert_eq!(refined.outcome, RefineOutcome::Budget);
    let stats = refined.stats;
    let points = stats.segment_points + stats.facet_points + stats.free_points;
    assert!((300..=600).contains(&points), "{points}");
    assert!(refined.lost.is_empty());
}

#[test]
fn a_wide_round_can_be_cancelled_and_leaves_a_sound_mesh() {
    let seen = std::sync::Mutex::new(Vec::new());
    let token = ltbw_core::CancelToken::new();
    for most in [u64::MAX, 6000] {
        seen.lock().expect("no panic").clear();
        let observer = |progress: ltbw_core::Progress| {
            seen.lock().expect("no panic").push(progress.done);
            if progress.done >= most {
                token.cancel();
            }
        };
        let refiner = Refiner::new().max_volume(1.2e-5).start(0);
        // A thread of the pool is told at once, one outside a little later.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
        let run = || refine(&refiner.observer(&observer).cancel(&token), &model());
        let refined = pool.install(run);
        let seen = seen.lock().expect("no panic");
        assert!(seen.windows(2).all(|pair| pair[1] <= pair[0] + 1024), "{seen:?}");
        if most == u64::MAX {
            // Some rounds are wider than what is done between two looks.
            assert!(refined.stats.widest > 1100, "{:?}", refined.stats);
            assert_eq!(refined.outcome, RefineOutcome::Met);
            continue;
        }
        assert_eq!(refined.outcome, RefineOutcome::Cancelled);
        let count = refined.mesh().num_vertices() as u64;
        assert_eq!(Some(&count), seen.last(), "nothing is inserted after the token is set");
        assert!((most..most + 1024).contains(&count), "{count}");
        check_all(refined.mesh()).expect("invariants of the mesh");
        check_marks(&refined.state);
        assert!(refined.lost.is_empty() && refined.excuses.is_empty());
    }
}

#[test]
fn rounds_tell_the_thread_that_asked_for_them_and_end_with_it() {
    use std::sync::Mutex;
    use std::thread::{ThreadId, current};

    /// Notes the threads that tell it, and panics from this number of vertices on.
    struct Told(Mutex<Vec<ThreadId>>, u64);

    impl ltbw_core::Observer for Told {
        fn progress(&self, progress: ltbw_core::Progress) {
            self.0.lock().expect("no panic with the lock").push(current().id());
            assert!(progress.done < self.1, "asked for");
        }
    }

    let ready = model();
    let refiner = Refiner::new().max_volume(2e-3).start(64);
    let told = Told(Mutex::default(), u64::MAX);
    let outside = refine(&refiner.observer(&told), &ready);
    let threads = told.0.into_inner().expect("no panic with the lock");
    assert!(threads.len() > 10 && threads.iter().all(|&id| id == current().id()), "{threads:?}");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
    let inside = pool.install(|| refine(&refiner, &ready));
    assert_eq!(inside.mesh().hash().expect("a hash"), outside.mesh().hash().expect("a hash"));
    let told = Told(Mutex::default(), 80);
    let broken = std::panic::AssertUnwindSafe(|| refine(&refiner.observer(&told), &ready));
    assert!(std::panic::catch_unwind(broken).is_err(), "a panic of the observer comes through");
}

/// Points at a patch are alone in their closures: labels of flat tetrahedra and subfaces are a
/// function of the mesh, too.
#[test]
fn patches_within_a_tolerance_have_one_mesh_for_all_orders() {
    use ltbw_generate::surfaces::{globe, prism, shell, single, torus, turned};
    let (mut patches, mut excused, mut excused_singly) = (0, 0, 0);
    for (name, made, volume) in [
        ("a globe", globe(16, 16, 0.0, 1), None),
        ("a fine globe", globe(12, 12, 0.0, 1), Some(1e-4)),
        ("a globe, turned", turned(&globe(12, 12, 0.0, 1)), None),
        ("a prism", prism(12, 1e-7, 1), None),
        ("a fine prism", prism(12, 1e-7, 1), Some(3e-4)),
        ("a prism, turned", turned(&prism(12, 1e-7, 1)), None),
        ("a torus", torus(10), None),
        ("a torus, turned", turned(&torus(10)), None),
        ("a shell, turned", single(turned(&shell(0.1))), None),
    ] {
        let ready = surface!(made);
        let tolerance = crate::usual_tolerance(&ready.domain, &ready.domain);
        let refiner = Refiner::new().flat_tolerance(tolerance.max(5e-7));
        let refiner = volume.map_or(refiner, |volume| refiner.max_volume(volume));
        let refined = one_mesh(&refiner, &ready, 0, name);
        crate::patch_tests::check_labels(&refined.state);
        let single = refine(&refiner.start(usize::MAX), &ready);
        println!(
            "{name}: {} {}, {} patches, {} {} tetrahedra, {:?} {}",
            refined.excuses.len(),
            single.excuses.len(),
            refined.stats.patches,
            refined.num_tets(),
            single.num_tets(),
            refined.stats.rounds,
            refined.stats.joint_phases
        );
        assert_eq!(refined.stats.patches, single.stats.patches, "{name}");
        if single.outcome == RefineOutcome::Met {
            assert_eq!(refined.outcome, RefineOutcome::Met, "{name}");
        }
        patches += refined.stats.patches;
        excused += refined.excuses.len();
        excused_singly += single.excuses.len();
    }
    assert!(patches > 100, "{patches}");
    assert!(excused <= excused_singly, "{excused} {excused_singly}");
}

/// Slivers are gone, and none follows: each point divides one at least and makes none.
#[test]
fn slivers_are_split_in_rounds() {
    let torus = surface!(ltbw_generate::surfaces::torus(24));
    let refiner = Refiner::new().flat_tolerance(5e-7).max_volume(1e-4);
    let cube = ready(DomainKind::CubeInCube, &Shape::default());
    for (name, ready, refiner) in
        [("a torus", torus, refiner), ("a cube in a cube", cube, Refiner::new().max_volume(2e-4))]
    {
        let before = refine(&refiner.min_dihedral(0.0).start(0), &ready);
        assert!(before.slivers.is_empty(), "{name}: none is asked for");
        let below = |refined: &Refined, degrees: f64| {
            let bound = DihedralBound::new(degrees);
            let is_below = |&t: &TetId| {
                let corners = refined.state.vertices(t).map(|v| refined.state.at(v));
                bound.is_missed(corners.each_ref())
            };
            refined.tets().filter(is_below).count()
        };
        let count = below(&before, 8.0);
        assert!(count > 20, "{name}: {count}");
        let refined = one_mesh(&refiner, &ready, 0, name);
        assert_eq!((below(&refined, 8.0), refined.slivers.len()), (0, 0), "{name}");
        let [points, more] = [&before, &refined].map(|own| own.mesh().num_vertices());
        assert!((1..=count).contains(&(more - points)), "{name}: {points} {more}, {count}");
        let few = refine(&refiner.min_dihedral(5.0).start(0), &ready);
        assert_eq!(below(&few, 5.0), 0, "{name}");
        assert!(few.num_tets() < refined.num_tets(), "{name}");
    }
}

#[test]
fn bounds_on_angles_are_numbers_that_can_be_met() {
    let cube = ready(DomainKind::CubeInCube, &Shape::default());
    for degrees in [-1.0, 12.5, f64::NAN, f64::INFINITY] {
        let error = Refiner::new().min_dihedral(degrees).refine(&cube.domain, &cube.lattice);
        let Err(RefineError::Bound { name, .. }) = error else { panic!("{degrees}") };
        assert_eq!(name, "min-dihedral");
    }
}

/// A ball of quads cut in two, flat but for rounding: its centre takes the concave ones out of the
/// mesh, and under this floor none of them may be split. One search each would be 1,701. (Slivers,
/// which are searched for one by one, have tests of their own.)
#[test]
fn tetrahedra_that_the_same_subfaces_bar_are_refused_without_a_search() {
    let made = ltbw_generate::surfaces::globe(24, 24, 0.0, 1);
    let facets = made.facets.iter().map(|f| Facet::polygon(&f.polygons[0], 0)).collect();
    let ball = Domain { vertices: made.vertices, facets, ..Domain::default() };
    let ready = ball.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refined = refine(&Refiner::new().floor(0.15).min_dihedral(0.0).start(0), &ready);
    assert_eq!(refined.outcome, RefineOutcome::Excused);
    let (excused, searches) = (refined.excuses.len(), refined.stats.searches);
    assert!(excused > 1000 && searches < 200, "{searches} searches, {excused} excused");
}

/// A tetrahedron that is to be relieved may be gone, and its slot have another one; and what is
/// counted is rounded: this prism had two meshes.
#[test]
fn relief_is_the_same_for_all_orders() {
    let ready =
        surface!(ltbw_generate::surfaces::turned(&ltbw_generate::surfaces::prism(24, 1e-7, 1)));
    let refined = one_mesh(&Refiner::new(), &ready, 0, "a prism");
    // One item after the other, without asking for shorter edges, is hardly better.
    let (mut run, _) = Refiner::new().recovered(&ready.domain, &ready.lattice).expect("sound");
    run.refine(usize::MAX).expect("no error");
    relieve(&mut run, Goal::Bounds);
    let own = refined.excuses.len() as f64 / refined.num_tets() as f64;
    let state = &run.refinement.state;
    let tets = state.mesh.tet_ids().filter(|&t| state.marks.region(t) != 0).count();
    let others = over(&run).len() as f64 / tets as f64;
    assert!(own < 1.2 * others, "{own} {others}");
}

/// A ghost on a patch was looked at as if it had four corners.
#[test]
fn patches_on_the_hull_may_bar_points() {
    let ready = surface!(ltbw_generate::surfaces::prism(12, 1e-6, 1));
    one_mesh(&Refiner::new().flat_tolerance(5e-7), &ready, 0, "a prism");
}

/// Long segments between needles are split together with their neighbours. What had been refused
/// for larger tetrahedra barred every such step (433 of 1,541 and 227 of 1,158 were excused), and
/// so did sides that are as long as their limits but for the last bits (229 of 1,936).
#[test]
fn a_joint_step_tries_what_was_refused_for_larger_tetrahedra() {
    for (noise, seed) in [(1e-2, 2), (1e-6, 2), (1e-6, 1)] {
        let ready = surface!(ltbw_generate::surfaces::prism(24, noise, seed));
        let refined = one_mesh(&Refiner::new(), &ready, 0, "a prism");
        let (excused, all) = (refined.excuses.len(), refined.num_tets());
        assert!(20 * excused < 2 * all, "{noise} {seed}: {excused} of {all}");
    }
}
