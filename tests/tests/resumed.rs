//! Refinements by teams that stop between rounds, and go on in teams of other sizes: always the
//! engine's mesh, from whichever checkpoint.

use ltbw::CancelToken;
use ltbw::domain::{Domain, PrepareOptions, Prepared};
use ltbw::refine::{Refined, Refiner};
use ltbw::refining::{Checkpoints, Pieces, RefineError, TeamRounds, Wishes, rounds_on_team};
use ltbw::team::Team;
use ltbw::threads::Parallel;
use ltbw_generate::layers::stack;
use ltbw_generate::{DomainKind, Shape, generate_domain, surfaces};
use ltbw_tests::teams::on_team;
use std::cell::RefCell;

/// A checkpoint, and the number of rounds before it.
struct Kept {
    rounds: u64,
    state: Vec<Vec<u8>>,
}

/// A mesh, by all that a resumed run may not change.
fn told(refined: &Refined) -> impl PartialEq + use<> {
    let whole = refined.with_exterior();
    let stats = refined.stats;
    let figures = (stats.rounds, stats.rounds_with, stats.round_points, stats.searches);
    let excuses: Vec<_> =
        refined.excuses.iter().map(|own| (refined.tet(own.tet), own.reason)).collect();
    (whole.points, whole.tets, whole.tet_tags, whole.faces, refined.outcome, figures, excuses)
}

/// One member's part in a refinement with checkpoints.
fn rounds(
    team: &mut Team,
    refiner: &Refiner<'_>,
    ready: &Prepared,
    checkpoints: Checkpoints<'_>,
) -> Result<TeamRounds, RefineError> {
    let (token, parallel) = (CancelToken::new(), Parallel::new(team.size()));
    let whole = (&ready.domain, &ready.lattice);
    let wishes = Wishes { checkpoints, ..Wishes::default() };
    rounds_on_team(refiner, whole, (&parallel, &token), team, wishes)
}

/// Stops every few rounds on two members, and goes on from each of these checkpoints on other
/// numbers of them. Returns the number of checkpoints.
fn resumes(name: &str, domain: &Domain, options: &PrepareOptions, refiner: &Refiner<'_>) -> usize {
    let ready = domain.prepare(options).expect("a sound domain");
    let engine = told(&refiner.refine(&ready.domain, &ready.lattice).expect("a mesh"));
    let run = |members: u32, every: u64, from: Option<&[Vec<u8>]>| -> Vec<Kept> {
        let ends = on_team(members, |team| {
            let kept = RefCell::new(Vec::new());
            let keep = |rounds, pieces: &mut Pieces<'_>| {
                let state = pieces.collect::<Result<_, _>>().expect("all pieces");
                kept.borrow_mut().push(Kept { rounds, state });
            };
            let checkpoints = Checkpoints { every, from, keep: Some(&keep) };
            (
                rounds(team, refiner, &ready, checkpoints).expect("a mesh").into_whole(),
                kept.into_inner(),
            )
        });
        let (first, kept) = ends.into_iter().next().expect("a member");
        let refined = first.expect("the first member's mesh").refined;
        let rounds = kept.last().map(|own| own.rounds);
        assert!(told(&refined) == engine, "{name} on {members}, {rounds:?} rounds kept");
        kept
    };
    let kept = run(2, 3, None);
    assert!(kept.is_sorted_by(|a, b| a.rounds < b.rounds), "{name}");
    // The first, one in the midst, and the last.
    for k in [0, kept.len() / 2, kept.len().saturating_sub(1)] {
        let Some(Kept { rounds, state }) = kept.get(k) else { continue };
        for (members, every) in [(1, 0), (3, 5)] {
            let later = run(members, every, Some(state));
            assert!(later.iter().all(|own| own.rounds > *rounds), "{name}: goes on, not back");
        }
    }
    kept.len()
}

#[test]
fn a_refinement_goes_on_from_its_checkpoints_on_any_team() {
    let cases = [
        (DomainKind::CubeOctahedron, 1e-3),
        (DomainKind::Tee, 2e-3),
        (DomainKind::CubeInCube, 1e-3),
        (DomainKind::Wedge, 1e-3),
    ];
    for (kind, volume) in cases {
        let domain = generate_domain(kind, &Shape::default()).expect("a shape");
        let refiner = Refiner::new().max_volume(volume).start(0);
        let options = PrepareOptions::default();
        let count = resumes(&format!("{kind:?}"), &domain, &options, &refiner);
        assert!(count >= 2, "{kind:?}: {count} checkpoints");
    }
}

/// A part is its vertices: 45 bytes for each vertex of the mesh, with those that parts share.
#[test]
fn checkpoints_are_small() {
    let domain = generate_domain(DomainKind::CubeOctahedron, &Shape::default()).expect("a shape");
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refiner = Refiner::new().max_volume(1e-4).start(0);
    let ends = on_team(2, |team| {
        let sizes = RefCell::new(Vec::new());
        let keep = |_, pieces: &mut Pieces<'_>| {
            let bytes = pieces.map(|piece| piece.expect("all pieces").len()).sum::<usize>();
            sizes.borrow_mut().push(bytes);
        };
        let checkpoints = Checkpoints { every: 4, from: None, keep: Some(&keep) };
        (
            rounds(team, &refiner, &ready, checkpoints).expect("a mesh").into_whole(),
            sizes.into_inner(),
        )
    });
    let (first, sizes) = ends.into_iter().next().expect("a member");
    let vertices = first.expect("the mesh").refined.mesh().num_vertices();
    let largest = sizes.into_iter().max().expect("a checkpoint");
    println!("{vertices} vertices: {largest} bytes at most");
    assert!(largest > 24 * vertices / 2 && largest <= 45 * vertices, "{largest}, {vertices}");
}

/// Members with members below them in their tree, each of which goes on as soon as it may; and a
/// first one that takes one piece of each second checkpoint, and none of the others.
#[test]
fn many_members_go_on_together_from_every_border() {
    let domain = generate_domain(DomainKind::CubeOctahedron, &Shape::default()).expect("a shape");
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refiner = Refiner::new().max_volume(2e-3).start(0);
    let engine = told(&refiner.refine(&ready.domain, &ready.lattice).expect("a mesh"));
    let ends = on_team(40, |team| {
        let count = RefCell::new(0);
        let keep = |_, pieces: &mut Pieces<'_>| {
            *count.borrow_mut() += 1;
            if *count.borrow() % 2 == 0 {
                pieces.next().expect("a piece").expect("the head");
            }
        };
        let checkpoints = Checkpoints { every: 1, from: None, keep: Some(&keep) };
        (
            rounds(team, &refiner, &ready, checkpoints).expect("a mesh").into_whole(),
            count.into_inner(),
        )
    });
    let (first, count) = ends.into_iter().next().expect("a member");
    assert!(told(&first.expect("the mesh").refined) == engine, "another mesh");
    assert!(count >= 20, "{count} borders");
}

/// Pieces of a checkpoint that are not all of one are refused, whatever is wrong with them.
#[test]
fn pieces_that_do_not_fit_are_refused() {
    let domain = generate_domain(DomainKind::CubeOctahedron, &Shape::default()).expect("a shape");
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refiner = Refiner::new().max_volume(1e-3).start(0);
    let run = |members: u32, every: u64, from: Option<&[Vec<u8>]>| {
        let ends = on_team(members, |team| {
            let kept = RefCell::new(Vec::new());
            let keep = |_, pieces: &mut Pieces<'_>| {
                *kept.borrow_mut() = pieces.collect::<Result<_, _>>().expect("all pieces");
            };
            let checkpoints = Checkpoints { every, from, keep: Some(&keep) };
            let refined = rounds(team, &refiner, &ready, checkpoints);
            (refined.err().map(|error| error.to_string()), kept.into_inner())
        });
        ends.into_iter().next().expect("a member")
    };
    let (error, pieces): (_, Vec<Vec<u8>>) = run(2, 4, None);
    assert_eq!((error, pieces.len()), (None, 3), "a head and two parts");
    assert_eq!(run(1, 0, Some(&pieces)).0, None, "a whole one");
    let [head, one, other] = [0, 1, 2].map(|k| pieces[k].clone());
    let cut = one[..one.len() / 2].to_vec();
    for wrong in [
        vec![],
        vec![head.clone()],
        vec![head.clone(), one.clone()],
        vec![head.clone(), one.clone(), other.clone(), one.clone()],
        vec![one.clone(), other.clone()],
        vec![head.clone(), cut, other.clone()],
    ] {
        let count = wrong.len();
        assert!(run(1, 0, Some(&wrong)).0.is_some(), "{count} pieces that do not fit");
    }
}

#[test]
fn patches_are_in_checkpoints() {
    let domain = surfaces::single(surfaces::torus(10));
    let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
    let refiner = Refiner::new().flat_tolerance(5e-7).max_volume(1e-3).start(64);
    let count = resumes("a torus", &domain, &options, &refiner);
    assert!(count > 0, "no checkpoint");
}

/// Joint steps before a checkpoint count after it, and what they have refused.
#[test]
fn circles_are_in_checkpoints() {
    let mut counts = [0; 2];
    let cases: [([f64; 2], &[u32]); 2] =
        [([3.0, 2.0], &[42, 6, 4]), ([1.0, 1.0], &[52, 54, 19, 27, 38, 22, 30, 55])];
    for (base, layers) in cases {
        let thicknesses: Vec<f64> = layers.iter().map(|&t| f64::from(t) / 64.0).collect();
        let domain = stack(base, &thicknesses, false);
        let volume = base[0] * base[1] * thicknesses.iter().sum::<f64>();
        for (count, most) in counts.iter_mut().zip([None, Some(1)]) {
            let refiner = Refiner::new().max_volume(volume / 2000.0).start(0);
            let refiner = most.map_or(refiner, |most| refiner.joint_most(most));
            let name = format!("{layers:?}, {most:?}");
            *count += resumes(&name, &domain, &PrepareOptions::default(), &refiner);
        }
    }
    assert!(counts.iter().all(|&count| count > 0), "checkpoints: {counts:?}");
}
