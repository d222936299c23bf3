//! Meshes in parts: what is sound passes however it is divided, and every defect is found wherever
//! it lies, in letters that may be anything.

use crate::common::team::{Lost, Member, on_team};
use crate::common::{GENERAL, IntPoint, Owned, cube, delaunay, kinds};
use ltbw_verify::{
    Depth, Exchange, Hash, Kind, Level, Mesh, Options, Outcome, Part, Report, check, check_parted,
};

/// A division: the member that has a tetrahedron, whatever the number of members.
type Division<'d> = &'d (dyn Fn(usize) -> usize + Sync);

/// A member's part of a mesh.
struct OwnPart {
    points: Vec<[f64; 3]>,
    numbers: Vec<u32>,
    tets: Vec<[u32; 4]>,
    given: Vec<[f64; 3]>,
}

impl OwnPart {
    /// That of member `me`; a vertex that there is not stays one.
    fn of(mesh: &Owned, division: Division<'_>, [me, members]: [usize; 2]) -> Self {
        let own = (0..mesh.tets.len()).filter(|&t| division(t) % members == me);
        let mut tets: Vec<[u32; 4]> = own.map(|t| mesh.tets[t]).collect();
        let count = mesh.points.len();
        let mut numbers: Vec<u32> =
            tets.iter().flatten().copied().filter(|&v| (v as usize) < count).collect();
        // Not in the order of the mesh.
        numbers.sort_unstable_by_key(|&v| (v % 3, v));
        numbers.dedup();
        let place = |v: u32| numbers.iter().position(|&w| w == v).map_or(u32::MAX, |k| k as u32);
        tets.iter_mut().for_each(|tet| *tet = tet.map(place));
        let stretch = |k: usize| k * count / members;
        Self {
            points: numbers.iter().map(|&v| mesh.points[v as usize]).collect(),
            numbers,
            tets,
            given: mesh.points[stretch(me)..stretch(me + 1)].to_vec(),
        }
    }

    fn part(&self) -> Part<'_> {
        let Self { points, numbers, tets, given } = self;
        Part { points, numbers, tets, given }
    }
}

/// The options of all tests here, at a depth.
fn options(depth: Depth) -> Options {
    Options { depth, all_points: true, ..Options::default() }
}

/// The report of all members, which is one.
fn report(mesh: &Owned, division: Division<'_>, members: usize, depth: Depth) -> Report {
    let mut all = on_team(members, |team| {
        let own = OwnPart::of(mesh, division, [team.me(), members]);
        check_parted(team, &own.part(), &options(depth)).expect("a report")
    });
    let first = all.remove(0);
    // As text: a coordinate may be NaN, which is not itself.
    let text = |report: &Report| format!("{report:?}");
    assert!(all.iter().all(|other| text(other) == text(&first)), "different reports");
    first
}

/// Ways to divide: in turn, at random, in stretches of three, all at one, and none at the first.
const DIVISIONS: [Division<'static>; 5] =
    [&|t| t, &|t| t * 7919 % 97 / 5, &|t| t / 3, &|_| 1, &|t| t % 3 + 1];

const MEMBERS: [usize; 5] = [1, 2, 3, 5, 8];

fn meshes() -> Vec<(&'static str, Owned)> {
    let grid: Vec<IntPoint> = (0..18).map(|k| [k / 6, k / 2 % 3, k % 2]).collect();
    vec![
        ("general", delaunay(&GENERAL)),
        ("cube", delaunay(&cube())),
        ("grid", delaunay(&grid)),
        ("one", delaunay(&GENERAL[..4])),
    ]
}

/// For all divisions of a mesh among all teams, at both depths.
fn each(mesh: &Owned, mut asked: impl FnMut(&Report, &str)) {
    for members in MEMBERS {
        for (k, division) in DIVISIONS.into_iter().enumerate() {
            for depth in [Depth::Fast, Depth::Full] {
                let name = format!("{members} members, division {k}, {depth:?}");
                asked(&report(mesh, division, members, depth), &name);
            }
        }
    }
}

#[test]
fn sound_meshes_pass_and_have_the_counts_and_the_hash_of_the_whole() {
    for (name, mesh) in meshes() {
        let view = Mesh::new(&mesh.points, &mesh.tets);
        let whole = [Depth::Fast, Depth::Full].map(|depth| check(&view, &options(depth)));
        each(&mesh, |report, how| {
            let is_full = report.level(Level::Canonical).outcome == Outcome::Passed;
            let expected = &whole[usize::from(is_full)];
            assert!(report.passed(), "{name}, {how}: {:?}", report.defects);
            assert_eq!(report.counts, expected.counts, "{name}, {how}");
            assert_eq!(report.hash, expected.hash, "{name}, {how}");
            // Each test is made once, from the one side or from the other.
            for (own, other) in report.levels.iter().zip(&expected.levels) {
                let tests = |level: &ltbw_verify::LevelReport| level.filter + level.exact;
                assert!(
                    own.level == Level::Canonical || tests(own) == tests(other),
                    "{name}, {how}: {own:?} {other:?}"
                );
                assert_eq!(own.outcome, other.outcome, "{name}, {how}");
            }
            assert!((report.volume - expected.volume).abs() < 1e-9 * expected.volume);
        });
        let json = report(&mesh, DIVISIONS[0], 3, Depth::Full).certificate().to_json().unwrap();
        assert!(json.contains("\"parts\": 3"), "{json}");
    }
}

/// Every tetrahedron of every mesh is taken away, is there twice, is turned around, or gets another
/// vertex.
#[test]
fn spoilt_tetrahedra_are_found_wherever_they_lie() {
    for (name, mesh) in meshes() {
        for t in 0..mesh.tets.len() {
            let mut spoilt = mesh.clone();
            spoilt.tets.remove(t);
            let mut all = vec![("gone", spoilt)];
            let mut spoilt = mesh.clone();
            spoilt.tets.push(mesh.tets[t]);
            all.push(("twice", spoilt));
            let mut spoilt = mesh.clone();
            spoilt.tets[t].swap(1, 2);
            all.push(("turned", spoilt));
            let mut spoilt = mesh.clone();
            let other = (0..mesh.points.len() as u32).find(|v| !mesh.tets[t].contains(v));
            if let Some(other) = other {
                spoilt.tets[t][t % 4] = other;
                all.push(("renamed", spoilt));
            }
            let mut spoilt = mesh.clone();
            spoilt.tets[t][t % 4] = mesh.points.len() as u32 + 3;
            all.push(("no vertex", spoilt));
            let mut spoilt = mesh.clone();
            spoilt.tets[t][0] = spoilt.tets[t][2];
            all.push(("repeated", spoilt));
            for (what, spoilt) in all {
                for members in [1, 2, 3, 5] {
                    let division: Division<'_> = DIVISIONS[(t + members) % DIVISIONS.len()];
                    let report = report(&spoilt, division, members, Depth::Full);
                    assert!(!report.passed(), "{name}, {t} is {what}, {members} members");
                    assert_eq!(report.counts.components, 0);
                }
            }
        }
    }
}

/// Defects that have a name of their own, with the tetrahedra and the vertices that it tells.
#[test]
fn defects_are_named_by_the_numbers_of_the_whole() {
    let mesh = delaunay(&GENERAL);
    let of_kind = |report: &Report, kind| {
        let found = report.defects.iter().filter(|defect| defect.kind == kind);
        found.map(|d| (d.tets.clone(), d.vertices.clone(), d.at.clone())).collect::<Vec<_>>()
    };
    // A tetrahedron in the hands of two members.
    let mut spoilt = mesh.clone();
    spoilt.tets.push(mesh.tets[0]);
    let last = mesh.tets.len();
    let division = |t: usize| usize::from(t == last);
    let r = report(&spoilt, &division, 2, Depth::Full);
    assert_eq!(of_kind(&r, Kind::DuplicateTet), [(vec![0, last as u32], vec![], vec![])]);

    // A vertex that is none of the points, at one member: its number is another one's.
    let r = on_team(2, |team| {
        let mut own = OwnPart::of(&mesh, DIVISIONS[0], [team.me(), 2]);
        if team.me() == 1 {
            own.numbers[0] = 11;
        }
        check_parted(team, &own.part(), &options(Depth::Full)).expect("a report")
    })
    .remove(0);
    let found = of_kind(&r, Kind::IndexOutOfRange);
    assert_eq!(found.len(), 1, "{:?}", r.defects);
    assert_eq!(found[0].1, [11]);
    assert_eq!(r.count(Kind::EqualVertices), 1, "two numbers at one place");

    // A point more, one that is not finite, and two at one place.
    let mut spoilt = mesh.clone();
    spoilt.points.push([50.0, 50.0, 50.5]);
    let r = report(&spoilt, DIVISIONS[0], 3, Depth::Fast);
    let expected = (vec![], vec![12], vec![Some([50.0, 50.0, 50.5])]);
    assert_eq!(of_kind(&r, Kind::PointLeftOut), [expected]);
    assert_eq!((r.counts.places_left_out, r.counts.unused_points), (1, 1));
    spoilt.points[12] = mesh.points[3];
    assert!(report(&spoilt, DIVISIONS[0], 3, Depth::Full).passed(), "a duplicate is none too many");
    let mut spoilt = mesh.clone();
    spoilt.points[8][1] = f64::NAN;
    assert!(report(&spoilt, DIVISIONS[0], 3, Depth::Full).count(Kind::NotFinite) > 0);
    spoilt.points[8] = spoilt.points[9];
    let r = report(&spoilt, DIVISIONS[0], 3, Depth::Full);
    assert_eq!(of_kind(&r, Kind::EqualVertices)[0].1, [8, 9]);
    assert!(matches!(r.hash, Hash::None(_)));

    let none = Owned { points: Vec::new(), tets: Vec::new() };
    assert_eq!(kinds(&report(&none, DIVISIONS[0], 3, Depth::Full)), [Kind::Empty]);
}

/// Two bodies, a hole, and a fan that goes twice around: sound but for what only the whole shows.
#[test]
fn what_only_the_whole_shows_is_found() {
    let mut mesh = delaunay(&cube());
    let n = mesh.points.len() as u32;
    mesh.points.extend(delaunay(&cube()).points.iter().map(|p| p.map(|c| c + 3.0)));
    let copy: Vec<[u32; 4]> = mesh.tets.iter().map(|tet| tet.map(|v| v + n)).collect();
    let first = mesh.tets.len();
    mesh.tets.extend(copy);
    // Each body is one member's.
    let r = report(&mesh, &|t| usize::from(t >= first), 2, Depth::Full);
    assert!(r.count(Kind::Euler) == 1 && r.count(Kind::HullEuler) == 1, "{:?}", r.defects);
    let r = report(&mesh, &|t| usize::from(t >= first), 2, Depth::Fast);
    assert!(r.count(Kind::HullTurnedAway) > 0, "{:?}", r.defects);

    // Without its inner vertex's star the mesh has a hole.
    let mesh = delaunay(&GENERAL);
    let keeps = |tet: &&[u32; 4]| !tet.contains(&8);
    let hole = Owned { tets: mesh.tets.iter().filter(keeps).copied().collect(), ..mesh };
    for members in MEMBERS {
        let r = report(&hole, DIVISIONS[1], members, Depth::Fast);
        assert!(!r.passed(), "{members}: {:?}", r.defects);
    }
}

/// Bytes that are cut, that are longer, or that are all ones, in each exchange of a check.
#[test]
fn bytes_that_make_no_sense_are_refused_by_all_means() {
    let mesh = delaunay(&GENERAL);
    let run = |change: &(dyn Fn(&mut Member) + Sync)| {
        on_team(2, |team| {
            if team.me() == 1 {
                change(team);
            }
            let own = OwnPart::of(&mesh, DIVISIONS[0], [team.me(), 2]);
            let end = check_parted(team, &own.part(), &options(Depth::Full));
            (end.map(|report| report.passed()), team.exchanges())
        })
    };
    let sound = run(&|_| ());
    assert_eq!(sound[0].0, Ok(true));
    let hows: [fn(&mut Vec<u8>); 3] =
        [|bytes| _ = bytes.pop(), |bytes| bytes.push(7), |bytes| bytes.fill(0xff)];
    let (mut named, mut all) = (0, 0);
    for k in 0..sound[0].1 {
        for (h, how) in hows.into_iter().enumerate() {
            let ends = run(&|team: &mut Member| team.garble(k, how));
            let is_named = matches!(ends[0].0, Err(Lost::Nonsense(1, _)));
            // Ones may be numbers of the wrong size, which is found as a defect.
            assert!(h == 2 || is_named || ends[0].0 == Ok(true), "{k}, {h}: {:?}", ends[0]);
            named += usize::from(is_named);
            all += 1;
        }
    }
    assert!(2 * named > all, "{named} of {all} are refused by name");
}
