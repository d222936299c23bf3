//! Teams one of whose members is stopped: all of them are, whatever they do.

use ltbw::distributed;
use ltbw::domain::PrepareOptions;
use ltbw::protocol::WorkerId;
use ltbw::refine::{RefineOutcome, RefineStats, Refiner};
use ltbw::refining::{TeamEnd, TeamRounds, Wishes, domain_on_team, rounds_on_team};
use ltbw::threads::{Parallel, RunError};
use ltbw::{BuildError, Builder, CancelToken, Outcome, Phase, PointSet, Progress, canonical_hash};
use ltbw_generate::{DomainKind, PointKind, Shape, generate, generate_domain};
use ltbw_tests::teams::{on_team, slice_of};
use ltbw_verify as verify;
use std::sync::atomic::{AtomicBool, Ordering};

/// Its own token is all that a member sees of a signal.
#[test]
fn a_member_that_is_stopped_stops_all() {
    let set = PointSet::new(generate(PointKind::Uniform, 30_000, 5)).expect("points");
    for victim in 0..3 {
        let ends = on_team(3, |team| {
            let token = CancelToken::new();
            let is_victim = team.me() == WorkerId::new(victim);
            let stop = |progress: Progress| {
                // The start is over.
                if is_victim && progress.phase == Phase::Insert {
                    token.cancel();
                }
            };
            let builder = Builder::new().cancel(&token).observer(&stop);
            let slice = slice_of(team, set.points());
            let built = builder.build_on(team, &slice).expect("a mesh");
            let hashed = distributed::hash(team, &built.part).expect("a hash");
            (built, hashed)
        });
        let tets: Vec<[u32; 4]> = ends.iter().flat_map(|(own, _)| own.part.numbered()).collect();
        let hash = canonical_hash(set.points(), &tets).expect("a hash");
        for (built, hashed) in &ends {
            assert_eq!(built.outcome, Outcome::Cancelled, "member {victim}");
            assert!(hashed.vertices < set.len() as u64);
            assert_eq!((hashed.hash, hashed.tets), (hash, tets.len() as u64));
        }
        // It is the mesh of its vertices.
        let mesh = verify::Mesh::new(set.points(), &tets);
        let report = verify::check(&mesh, &verify::Options::default());
        assert!(report.passed(), "member {victim}: {report}");
    }
    let stopped = on_team(2, |team| {
        let token = CancelToken::new();
        if !team.is_first() {
            token.cancel();
        }
        let slice = slice_of(team, set.points());
        Builder::new().cancel(&token).build_on(team, &slice).err()
    });
    let expected = Some(RunError::Build(BuildError::Cancelled));
    assert_eq!(stopped, [expected.clone(), expected]);
}

#[test]
fn a_refinement_that_is_stopped_at_one_member_is_stopped() {
    let domain = generate_domain(DomainKind::CubeOctahedron, &Shape::default()).expect("a shape");
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refiner = Refiner::new().max_volume(1e-3).start(0);
    for victim in 0..2 {
        let ends = on_team(2, |team| {
            let (token, parallel) = (CancelToken::new(), Parallel::new(2).among_processes());
            if team.me() == WorkerId::new(victim) {
                token.cancel();
            }
            let refiner = refiner.cancel(&token);
            let whole = (&ready.domain, &ready.lattice);
            let threads = (&parallel.cancel(&token), &token);
            rounds_on_team(&refiner, whole, threads, team, Wishes::default())
        });
        let first = ends.into_iter().next().expect("the first member");
        match first {
            Ok(TeamRounds::Whole(run, _)) => {
                assert_eq!(run.refined.outcome, RefineOutcome::Cancelled);
            }
            Ok(other) => panic!("the first member has {other:?}"),
            Err(error) => assert!(error.to_string().contains("cancelled"), "{error}"),
        }
    }
}

/// A member that is stopped stops all; a share of the budget that is used up ends the work, too.
/// The first member has the mesh so far then.
#[test]
fn what_is_stopped_without_rounds_is_one_members() {
    let domain = generate_domain(DomainKind::CubeOctahedron, &Shape::default()).expect("a shape");
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refiner = Refiner::new().max_volume(1e-4).min_dihedral(0.0).start(256);
    let refined = |refiner: &Refiner<'_>, stopped: Option<u32>| {
        let ends = on_team(3, |team| {
            let (token, parallel) = (CancelToken::new(), Parallel::new(3).among_processes());
            if stopped == Some(team.me().number()) {
                token.cancel();
            }
            let (whole, threads) = ((&ready.domain, &ready.lattice), parallel.cancel(&token));
            let wishes = Wishes { in_parts: true, ..Wishes::default() };
            let refiner = refiner.cancel(&token);
            domain_on_team(&refiner, whole, (&threads, &token), team, wishes)
        });
        let mut ends = ends.into_iter().map(|end| end.map(TeamEnd::into_whole));
        let first = ends.next().expect("the first member");
        assert!(ends.all(|end| end.is_ok_and(|end| end.is_none())), "the others have nothing");
        first.map(|whole| whole.expect("the first one has the mesh").refined)
    };
    for member in 0..3 {
        match refined(&refiner, Some(member)) {
            Ok(whole) => assert_eq!(whole.outcome, RefineOutcome::Cancelled, "{member}"),
            // It was stopped before there was a mesh.
            Err(error) => assert!(error.to_string().contains("cancelled"), "{member}: {error}"),
        }
    }
    let small = refined(&refiner.max_points(1000), None).expect("a mesh");
    assert_eq!(small.outcome, RefineOutcome::Budget);
    let RefineStats { segment_points, facet_points, free_points, .. } = small.stats;
    let points = segment_points + facet_points + free_points;
    assert!(points <= 1000, "{points}");
}

/// While the first member goes on alone the others wait: one of them that is stopped stops it.
#[test]
fn a_member_that_waits_for_the_first_one_stops_it() {
    let domain = generate_domain(DomainKind::CubeOctahedron, &Shape::default()).expect("a shape");
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let whole = (&ready.domain, &ready.lattice);
    let is_late = AtomicBool::new(false);
    let refine = |is_freely: bool, victim: Option<u32>| {
        is_late.store(false, Ordering::Relaxed);
        let ends = on_team(3, |team| {
            let (token, here) = (CancelToken::new(), std::thread::current().id());
            let parallel = Parallel::new(3).among_processes();
            let threads = (&parallel.cancel(&token), &token);
            let is_victim = victim == Some(team.me().number());
            // Work alone runs on a thread beside the letters.
            let observer = |_: Progress| {
                if victim.is_some() && std::thread::current().id() != here {
                    is_late.store(true, Ordering::Relaxed);
                    wait_until(|| token.is_cancelled());
                }
            };
            let refiner =
                Refiner::new().max_volume(1e-3).min_dihedral(12.0).smooth(4).start(0).one_thread();
            let refiner = refiner.cancel(&token).observer(&observer);
            std::thread::scope(|scope| {
                if is_victim {
                    scope.spawn(|| {
                        wait_until(|| is_late.load(Ordering::Relaxed));
                        token.cancel();
                    });
                }
                match is_freely {
                    true => domain_on_team(&refiner, whole, threads, team, Wishes::default())
                        .map(|end| end.into_whole().map(|run| run.refined)),
                    false => rounds_on_team(&refiner, whole, threads, team, Wishes::default())
                        .map(|end| end.into_whole().map(|run| run.refined)),
                }
            })
        });
        let mut ends = ends.into_iter().map(|end| end.expect("a mesh"));
        let first = ends.next().flatten().expect("the first one's mesh");
        assert!(ends.all(|end| end.is_none()), "one member has the mesh");
        first
    };
    for is_freely in [false, true] {
        assert_eq!(refine(is_freely, None).outcome, RefineOutcome::Met);
        for victim in 0..3 {
            let stopped = refine(is_freely, Some(victim));
            assert_eq!(stopped.outcome, RefineOutcome::Cancelled, "{is_freely} {victim}");
        }
    }
}

/// Waits for what another thread does, for a minute at most.
fn wait_until(is_so: impl Fn() -> bool) {
    for _ in 0..60_000 {
        if is_so() {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    panic!("nothing has happened for a minute");
}
