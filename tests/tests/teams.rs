//! Teams whose members share nothing but letters: always the sequential mesh, to its hash, its
//! excuses and its numbers; and letters as bytes.

use ltbw::distributed;
use ltbw::domain::{Domain, PrepareOptions, Prepared};
use ltbw::mesh::{Layout, LocalMesh, Ownership, Redeal};
use ltbw::protocol::WorkerId;
use ltbw::refine::{Refined, Refiner};
use ltbw::refining::{DomainMesh, Ending, RoundFigures, TeamRounds, Wishes, rounds_on_team};
use ltbw::team::{Kind, LONGEST, Post, Team, Threads};
use ltbw::threads::Parallel;
use ltbw::transport::Mail;
use ltbw::wire::{Wire, charged, open};
use ltbw::{Builder, CancelToken, PointSet};
use ltbw_generate::layers::stack;
use ltbw_generate::{DomainKind, PointKind, Shape, generate, generate_domain, surfaces};
use ltbw_tests::domains::NAMED;
use ltbw_tests::fuzz::wire::{DOMAIN, PARTS, POINTS, together, wire};
use ltbw_tests::teams::{on_team, recorded, slice_of};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
use std::time::Duration;

fn uniform(count: usize) -> PointSet {
    PointSet::new(generate(PointKind::Uniform, count, 5)).expect("points")
}

#[test]
fn mails_may_be_late() {
    let set = uniform(2000);
    let hash = Builder::new().build(&set).expect("a mesh").mesh.hash().expect("a hash");
    let member = |post| {
        let mut team = Team::new(post).latency(Duration::from_micros(300));
        let slice = slice_of(&mut team, set.points());
        let built = Builder::new().build_on(&mut team, &slice).expect("a mesh");
        distributed::hash(&mut team, &built.part).expect("a hash").hash
    };
    let hashes: Vec<_> = std::thread::scope(|scope| {
        let run = |post| scope.spawn(move || member(post));
        let all: Vec<_> = ltbw::team::threads(3).into_iter().map(run).collect();
        all.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    assert_eq!(hashes, [hash; 3]);
}

/// Compares all that can be told of two meshes.
fn same(name: &str, one: &Refined, other: &Refined) {
    let [a, b] = [one, other].map(Refined::with_exterior);
    assert!(a.points == b.points && a.tets == b.tets, "{name}");
    assert!(a.tet_tags == b.tet_tags && a.faces == b.faces, "{name}");
    assert_eq!(one.outcome, other.outcome, "{name}");
    let excuses = |refined: &Refined| -> Vec<_> {
        refined.excuses.iter().map(|e| (refined.tet(e.tet), e.reason)).collect()
    };
    assert!(excuses(one) == excuses(other), "{name}: other excuses");
    let stats = [one, other].map(|refined| refined.stats);
    let figures = stats.map(|s| (s.rounds, s.rounds_with, s.widest, s.round_points, s.searches));
    assert_eq!(figures[0], figures[1], "{name}");
}

/// The rounds of a team, and their end.
struct Rounds {
    figures: RoundFigures,
    ending: Option<Ending>,
}

/// Refines on a team with each of these numbers of members whose cuts move at these times: the
/// engine's mesh. Returns the rounds of each.
fn on_teams_of(
    name: &str,
    refiner: &Refiner<'_>,
    ready: &Prepared,
    teams: &[(u32, Redeal)],
) -> Vec<Rounds> {
    let whole = (&ready.domain, &ready.lattice);
    let engine = refiner.refine(whole.0, whole.1).expect("a mesh");
    let run = |&(members, redeal): &(u32, Redeal)| {
        let ownership = Ownership::Newest;
        let layout = Layout { ownership, redeal, ..Layout::new(0, members) };
        let ends = on_team(members, |team| {
            let (token, parallel) =
                (CancelToken::new(), Parallel::new(members).among_processes().layout(layout));
            let threads = (&parallel.cancel(&token), &token);
            rounds_on_team(refiner, whole, threads, team, Wishes::default())
        });
        let mut ends = ends.into_iter().map(|end| end.expect("a mesh"));
        let first = ends.next().and_then(TeamRounds::into_whole).expect("the first one's mesh");
        let is_elsewhere = |end| matches!(end, TeamRounds::Elsewhere);
        assert!(ends.all(is_elsewhere), "{name}: one member has the mesh");
        same(&format!("{name} on {members} members, {redeal:?}"), &first.refined, &engine);
        if let Ok(ending) = first.ending {
            assert_eq!(first.workers.len(), members as usize, "{name}: {ending:?}");
        }
        Rounds { figures: first.figures, ending: first.ending.ok() }
    };
    teams.iter().map(run).collect()
}

/// Refines on teams of 1, 2 and 3; the rounds of each.
fn on_teams(name: &str, refiner: &Refiner<'_>, ready: &Prepared) -> Vec<Rounds> {
    on_teams_of(name, refiner, ready, &[1, 2, 3].map(|members| (members, Redeal::Never)))
}

#[test]
fn domains_on_teams_have_the_engines_mesh() {
    let mut by_members = 0;
    for (kind, volume, angle, _) in NAMED {
        let usual = Shape::default();
        let shape = Shape { angle: angle.or(usual.angle), ..usual };
        let domain = generate_domain(kind, &shape).expect("a shape");
        let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
        let refiner = Refiner::new().max_volume(volume).start(0);
        let rounds = on_teams(&format!("{kind:?} {volume} {angle:?}"), &refiner, &ready);
        by_members += usize::from(rounds.iter().all(|own| own.figures.points > 0));
    }
    // Of some nothing is left for rounds.
    assert!(by_members >= 12, "members have refined {by_members} of {} domains", NAMED.len());
}

#[test]
fn a_surface_with_patches_on_teams_has_the_engines_mesh() {
    let domain = surfaces::single(surfaces::torus(10));
    let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
    let ready = domain.prepare(&options).expect("a sound domain");
    let refiner = Refiner::new().flat_tolerance(5e-7).max_volume(1e-3).start(64);
    for rounds in on_teams("a torus", &refiner, &ready) {
        assert_eq!(rounds.ending, Some(Ending::Done));
        assert!(rounds.figures.points > 0, "members have refined nothing");
    }
}

/// Cuts between the members' parts move as often as they are told to, and tetrahedra with them:
/// also where there are patches, and circles.
#[test]
fn cuts_move_between_rounds_of_teams() {
    let ready = |domain: Domain, oriented| {
        let options = PrepareOptions { oriented, ..PrepareOptions::default() };
        domain.prepare(&options).expect("a sound domain")
    };
    let cube = generate_domain(DomainKind::CubeOctahedron, &Shape::default()).expect("a shape");
    let torus = surfaces::single(surfaces::torus(10));
    let plates = stack([3.0, 2.0], &[42.0 / 64.0, 6.0 / 64.0, 4.0 / 64.0], false);
    let usual = Refiner::new();
    let cases = [
        ("a cube", ready(cube, false), usual.max_volume(3e-4).start(64)),
        ("a torus", ready(torus, true), usual.flat_tolerance(5e-7).max_volume(1e-3).start(64)),
        ("plates", ready(plates, false), usual.max_volume(6.0 * 52.0 / 64.0 / 5000.0).start(0)),
    ];
    let teams = [(1, 1), (2, 1), (3, 4), (5, 1)];
    for (name, ready, refiner) in cases {
        let often = teams.map(|(members, every)| (members, Redeal::Every(every)));
        for (own, (members, every)) in on_teams_of(name, &refiner, &ready, &often).iter().zip(teams)
        {
            let (figures, redeals) = (own.figures, own.figures.rounds[0] / every);
            assert_eq!(figures.redeals > 0 && figures.moved > 0, members > 1, "{name} {figures:?}");
            assert!(figures.redeals <= redeals, "{name}: {figures:?}");
            assert!(members == 1 || 2 * figures.redeals > redeals, "{name}: {figures:?}");
        }
    }
}

/// Items that wait for each other are split by the first member, which is lent what lies around,
/// also if one cannot be split.
#[test]
fn circles_are_split_by_the_first_member() {
    let cases: [([f64; 2], &[u32]); 2] =
        [([3.0, 2.0], &[42, 6, 4]), ([1.0, 1.0], &[52, 54, 19, 27, 38, 22, 30, 55])];
    let (mut again, mut cut_short) = (0, 0);
    for (base, layers) in cases {
        let thicknesses: Vec<f64> = layers.iter().map(|&t| f64::from(t) / 64.0).collect();
        let domain = stack(base, &thicknesses, false);
        let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
        let volume = base[0] * base[1] * thicknesses.iter().sum::<f64>();
        for (parts, most) in [(5000.0, None), (500.0, None), (5000.0, Some(1)), (500.0, Some(1))] {
            let refiner = Refiner::new().max_volume(volume / parts).start(0);
            let refiner = most.map_or(refiner, |most| refiner.joint_most(most));
            let rounds = on_teams(&format!("{layers:?}, {parts}, {most:?}"), &refiner, &ready);
            let gone_on = rounds.iter().filter(|own| own.figures.parted > 0).count();
            again += gone_on;
            cut_short += if most.is_some() { gone_on } else { 0 };
        }
    }
    assert!(again > 0 && cut_short > 0, "{again} went on after circles, {cut_short} with refusals");
}

/// All letters of runs on three members: about points, and about a domain.
fn letters() -> [Vec<Vec<u8>>; 2] {
    let set = uniform(3000);
    let run = |team: &mut Team| {
        let slice = slice_of(team, set.points());
        Builder::new().build_on(team, &slice).expect("a mesh");
    };
    let of_points = recorded(3, Kind::Mail, run).concat();
    let domain = generate_domain(DomainKind::CubeOctahedron, &Shape::default()).expect("a shape");
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refiner = Refiner::new().max_volume(3e-4).start(0);
    let of_domain = recorded(3, Kind::Mail, |team| {
        let (token, parallel) = (CancelToken::new(), Parallel::new(3).among_processes());
        let whole = (&ready.domain, &ready.lattice);
        let none = Wishes::default();
        rounds_on_team(&refiner, whole, (&parallel, &token), team, none).expect("a mesh");
    });
    [of_points, of_domain.concat()]
}

/// Reads and writes letters: each comes as it was. By kind of message the bytes, and those that the
/// simulator charges.
fn round_trip<M: Wire>(letters: &[Vec<u8>], charge: impl Fn(&M) -> u64) -> Vec<[u64; 2]> {
    let mut sizes = Vec::new();
    for letter in letters {
        let (mut again, mut count) = (Vec::new(), 0);
        open(WorkerId::default(), letter, |mail: M| {
            let before = again.len();
            mail.put(WorkerId::default(), &mut again).expect("bytes");
            sizes.push([(again.len() - before) as u64, charge(&mail)]);
            count += 1;
        })
        .expect("a letter");
        assert!(&again == letter, "it comes as it was");
        assert!(letter.len() <= LONGEST || count == 1, "a letter of {count} is too long");
    }
    sizes
}

#[test]
fn letters_come_as_they_were_sent_and_cost_no_more_than_the_simulator_charges() {
    let [of_points, of_domain] = letters();
    let points = round_trip(&of_points, charged::<LocalMesh>);
    let domain = round_trip(&of_domain, charged::<DomainMesh<'_>>);
    for (name, sizes) in [("points", points), ("a domain", domain)] {
        assert!(sizes.len() > 500, "{name}: {} messages", sizes.len());
        let more = sizes.iter().filter(|[real, charge]| real > charge).count();
        let [real, charge] = [0, 1].map(|k| sizes.iter().map(|own| own[k]).sum::<u64>());
        println!("{name}: {} messages, {real} bytes, {charge} charged, {more} above", sizes.len());
        assert!(real <= charge, "{name}: {real} bytes, {charge} charged");
        // Handles of a domain's messages may have long names; none about points is above.
        assert!(more * 5 <= sizes.len() * usize::from(name != "points"), "{name}: {more} above");
    }
}

#[test]
fn letters_that_make_no_sense_are_refused_by_name() {
    let [of_points, of_domain] = letters();
    let longest = |all: Vec<Vec<u8>>| all.into_iter().max_by_key(Vec::len).expect("letters");
    let all = [(POINTS, longest(of_points)), (DOMAIN, longest(of_domain))];
    let mut refused = 0;
    for (kind, letter) in &all {
        for length in 0..letter.len().min(600) {
            wire(&[&[*kind], &letter[..length]].concat());
            let cut = &letter[..length];
            let read = match *kind {
                POINTS => open(WorkerId::new(5), cut, |_: Mail<LocalMesh>| ()),
                _ => open(WorkerId::new(5), cut, |_: Mail<DomainMesh<'_>>| ()),
            };
            refused += usize::from(read.is_err_and(|error| error.from == WorkerId::new(5)));
        }
    }
    assert!(refused > 600, "{refused} of the beginnings are refused");
    let garbage = (any::<prop::sample::Index>(), any::<prop::sample::Index>(), any::<u8>());
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::default() };
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(config, rng);
    let cases = (0..2_usize, prop::collection::vec(garbage, 1..8));
    runner
        .run(&cases, |(which, changes)| {
            let (kind, letter) = &all[which];
            let mut bytes = [&[*kind], &letter[..]].concat();
            for (at, length, byte) in changes {
                let k = 1 + at.index(bytes.len() - 1);
                bytes[k] = byte;
                let end = k + length.index(16);
                if byte > 250 && end < bytes.len() {
                    bytes.drain(k..end);
                }
            }
            wire(&bytes);
            Ok(())
        })
        .expect("every letter is read or refused");
}

/// One of two members sends nonsense while they hash and check a mesh in parts.
#[test]
fn letters_about_parts_that_make_no_sense_are_refused_by_name() {
    let sent = recorded(2, Kind::Team, together).pop().expect("the second member's letters");
    let script = |letters: &[Vec<u8>]| {
        let mut bytes = vec![PARTS];
        for letter in letters {
            bytes.extend((letter.len() as u16).to_le_bytes());
            bytes.extend(letter);
        }
        bytes
    };
    let whole = script(&sent);
    wire(&whole);
    for k in 0..sent.len() {
        // Cut, longer, all ones, or empty; and one letter too few.
        let mut spoilt = sent.clone();
        _ = spoilt[k].pop();
        wire(&script(&spoilt));
        spoilt[k].extend([1, 2, 3]);
        wire(&script(&spoilt));
        spoilt[k].iter_mut().skip(1).for_each(|byte| *byte = 0xff);
        wire(&script(&spoilt));
        spoilt[k].truncate(1);
        wire(&script(&spoilt));
        spoilt.remove(k);
        wire(&script(&spoilt));
    }
    let change = (any::<prop::sample::Index>(), any::<u8>());
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::default() };
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(config, rng);
    runner
        .run(&prop::collection::vec(change, 1..6), |changes| {
            let mut bytes = whole.clone();
            changes.iter().for_each(|(at, byte)| bytes[1 + at.index(whole.len() - 1)] = *byte);
            wire(&bytes);
            Ok(())
        })
        .expect("all letters are understood or refused");
}

/// News in news in news would take the stack, two bytes a level.
#[test]
fn news_within_news_within_news_are_refused() {
    // A load of 0, a message, which is news, which are several: one, which are several, ...
    let sample = letters()[1].iter().find_map(|letter| {
        let mut several = None;
        let seek = |mail: Mail<DomainMesh<'_>>| {
            let text = format!("{mail:?}");
            if text.contains("Several") && several.is_none() {
                let mut bytes = Vec::new();
                mail.put(WorkerId::default(), &mut bytes).expect("bytes");
                several = Some(bytes);
            }
        };
        open(WorkerId::default(), letter, seek).expect("a letter");
        several
    });
    let several = sample.expect("news that are told together");
    // The load is 0 and the count small: a byte each, after message and news.
    let head = &several[..4];
    for depth in [1, 2, 100_000] {
        let mut bytes = head[..3].to_vec();
        for _ in 0..depth {
            bytes.extend([head[3], 1]);
        }
        // A sum of the tree ends it: its variant, and ten numbers.
        bytes.push(1);
        bytes.extend([0; 10]);
        let read = open(WorkerId::new(3), &bytes, |_: Mail<DomainMesh<'_>>| ());
        assert_eq!(read.is_ok(), depth == 1, "{depth} levels: {read:?}");
    }
}

/// A post that changes what it sends.
struct Garbled(Threads);

impl Post for Garbled {
    fn me(&self) -> WorkerId {
        self.0.me()
    }

    fn members(&self) -> u32 {
        self.0.members()
    }

    fn send(&mut self, to: WorkerId, kind: Kind, mut letter: Vec<u8>) {
        if self.me() == WorkerId::new(1) && kind == Kind::Mail {
            letter.iter_mut().for_each(|byte| *byte = 0xff);
        }
        self.0.send(to, kind, letter);
    }

    fn flush(&mut self) {
        self.0.flush();
    }

    fn take(&mut self) -> Option<(WorkerId, Kind, Vec<u8>)> {
        self.0.take()
    }

    fn wait(&mut self, timeout: Option<Duration>) {
        self.0.wait(timeout);
    }

    fn failed(&self) -> Option<WorkerId> {
        self.0.failed()
    }

    fn fail(&mut self) {
        self.0.fail();
    }
}

#[test]
fn a_letter_that_makes_no_sense_ends_all_members_by_the_name_of_its_sender() {
    let set = uniform(3000);
    let errors: Vec<String> = std::thread::scope(|scope| {
        let set = &set;
        let run = |post| {
            scope.spawn(move || {
                let mut team = Team::new(Garbled(post));
                let slice = slice_of(&mut team, set.points());
                let built = Builder::new().build_on(&mut team, &slice);
                built.expect_err("no mesh").to_string()
            })
        };
        let all: Vec<_> = ltbw::team::threads(3).into_iter().map(run).collect();
        all.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    let named = errors.iter().filter(|e| e.contains("a letter of worker 1 makes no sense")).count();
    assert!(named > 0, "{errors:?}");
    assert!(errors.iter().all(|e| e.contains("worker")), "{errors:?}");
}
