//! Domains whose parts stay where they were refined: together they are the engine's mesh, to its
//! numbers, its regions and its triangles, and conform as it does.

use ltbw::distributed::{self, Hashed};
use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::refine::{RefineOutcome, RefineStats, Refined, Refiner};
use ltbw::refining::{Late, RefinedPart, TeamRounds, Wishes, rounds_on_team};
use ltbw::team::Team;
use ltbw::threads::Parallel;
use ltbw::{BoundaryFace, CancelToken, TetMesh, canonical_hash};
use ltbw_cli::plc_of;
use ltbw_cli::ranks::Judge;
use ltbw_generate::{Shape, generate_domain};
use ltbw_tests::domains::NAMED;
use ltbw_tests::teams::on_team;
use ltbw_verify as verify;

/// One member's part, and what all have found of the whole.
struct Kept {
    own: RefinedPart,
    hashed: Hashed,
    found: verify::Conformity,
    /// The regions of this part are others than they say, if it has any tetrahedra.
    spoilt: verify::Conformity,
}

/// The ends of a team.
enum Ends {
    Parts(Vec<Kept>),
    Whole(Late),
}

/// The checker's findings of a mesh in parts. Of the last part a region is another one if it is
/// `spoilt`.
fn judged(
    team: &mut Team,
    own: &RefinedPart,
    ready: &Prepared,
    spoilt: bool,
) -> verify::Conformity {
    let mut tags: Vec<i64> = own.regions.iter().map(|&region| i64::from(region)).collect();
    if spoilt && team.me().number() + 1 == team.size() {
        tags.iter_mut().take(1).for_each(|tag| *tag += 1);
    }
    let distributed::Part { points, numbers, tets, .. } = &own.part;
    let part = verify::DomainPart { points, numbers, tets, tags: Some(&tags) };
    let plc = plc_of(ready.judged(), own.whole.stats.flat_tolerance);
    let options = verify::Options { numbered_regions: true, ..verify::Options::default() };
    verify::conforms_parted(&mut Judge(team), &part, &plc, &verify::Limits::default(), &options)
        .expect("findings")
}

/// Refines on a team whose members are to keep their parts.
fn in_parts(
    refiner: &Refiner<'_>,
    ready: &Prepared,
    members: u32,
    markers: Option<&[i32]>,
) -> Ends {
    let whole = (&ready.domain, &ready.lattice);
    let ends = on_team(members, |team| {
        let (token, parallel) = (CancelToken::new(), Parallel::new(members).among_processes());
        let threads = (&parallel.cancel(&token), &token);
        let wishes = Wishes { in_parts: true, markers, ..Wishes::default() };
        let end = rounds_on_team(refiner, whole, threads, team, wishes).expect("a mesh");
        let found = match &end {
            TeamRounds::Part(own) => {
                let hashed = distributed::hash(team, &own.part).expect("a hash");
                Some((hashed, [false, true].map(|spoilt| judged(team, own, ready, spoilt))))
            }
            TeamRounds::Whole(..) | TeamRounds::Elsewhere => None,
        };
        (end, found)
    });
    let (mut parts, mut late) = (Vec::new(), None);
    for end in ends {
        match end {
            (TeamRounds::Part(own), Some((hashed, [found, spoilt]))) => {
                parts.push(Kept { own: *own, hashed, found, spoilt });
            }
            (TeamRounds::Whole(_, own), _) => late = Some(own.why),
            _ => {}
        }
    }
    match late {
        None => {
            assert_eq!(parts.len(), members as usize, "all keep their parts");
            Ends::Parts(parts)
        }
        Some(why) => {
            assert!(parts.is_empty(), "one has the mesh, or all have their parts");
            Ends::Whole(why)
        }
    }
}

/// A triangle by numbers, marker, and its tetrahedron by numbers.
type Triangle = ([u32; 3], i64, [u32; 4]);

fn triangles(
    faces: &[BoundaryFace],
    tets: &[[u32; 4]],
    number: impl Fn(u32) -> u32,
) -> Vec<Triangle> {
    let told =
        |face: &BoundaryFace| (face.corners.map(&number), face.marker, tets[face.tet].map(&number));
    faces.iter().map(told).collect()
}

/// Compares parts with a mesh that one has.
fn same(name: &str, parts: &[Kept], engine: &Refined, ready: &Prepared) {
    let TetMesh { points, tets, tet_tags, faces, .. } = engine.inside();
    let hash = canonical_hash(&points, &tets).expect("a hash");
    let regions = tet_tags.expect("regions");
    let plc = plc_of(ready.judged(), engine.stats.flat_tolerance);
    let (limits, options) = (verify::Limits::default(), verify::Options::default());
    let mesh = verify::Mesh::new(&points, &tets);
    let judged = verify::conforms(&mesh, &plc, Some(&regions), &limits, &options);
    let has_tets = |own: &&Kept| !own.own.part.tets.is_empty();
    let is_spoilt = parts.last().filter(has_tets).is_some();
    let (mut all, mut found) = (Vec::new(), Vec::new());
    for Kept { own, hashed, found: conformity, spoilt } in parts {
        assert!(
            conformity.passed(),
            "{name}: {:?} {:?}",
            conformity.mesh_defects,
            conformity.findings
        );
        let counts = |own: &verify::Conformity| (own.subfaces, own.tets, own.cells);
        assert_eq!(counts(conformity), counts(&judged), "{name}");
        assert_eq!(conformity.volume, judged.volume, "{name}");
        assert_eq!(spoilt.passed(), !is_spoilt, "{name}: a region that is another one");
        assert_eq!((hashed.hash, hashed.tets), (hash, tets.len() as u64), "{name}");
        let part = &own.part;
        assert!(part.numbers.is_sorted(), "{name}");
        let is_there = |(&v, p): (&u32, &[f64; 3])| points[v as usize] == *p;
        assert!(part.numbers.iter().zip(&part.points).all(is_there), "{name}: other points");
        let number = |v: u32| part.numbers[v as usize];
        let told: Vec<[u32; 4]> = part.tets.iter().map(|tet| tet.map(number)).collect();
        assert!(told.is_sorted(), "{name}: in the order of the whole");
        all.extend(told.into_iter().zip(own.regions.iter().map(|&r| i64::from(r))));
        let own_faces = triangles(&own.faces, &part.tets, number);
        assert!(own.faces.is_sorted_by_key(|face| (face.tet, face.corners)), "{name}");
        found.extend(own_faces);
        let whole = &own.whole;
        assert_eq!(whole.vertices, engine.mesh().num_vertices() as u64, "{name}");
        assert_eq!(whole.tets, tets.len() as u64, "{name}");
        assert_eq!(whole.hull_faces, engine.mesh().num_hull_faces() as u64, "{name}");
        assert_eq!(whole.regions, engine.regions, "{name}");
        assert_eq!(whole.workers.len(), parts.len(), "{name}");
        let slivers: Vec<_> = whole.slivers.iter().map(|s| (s.tet, s.angle, s.near)).collect();
        let tet = |t| engine.tet(t).expect("a tetrahedron");
        let expected: Vec<_> =
            engine.slivers.iter().map(|s| (tet(s.tet), s.angle, s.near)).collect();
        assert_eq!(slivers, expected, "{name}");
        assert_eq!(figures(&whole.stats), figures(&engine.stats), "{name}");
    }
    all.sort_unstable();
    assert!(all == tets.iter().copied().zip(regions).collect::<Vec<_>>(), "{name}");
    found.sort_unstable_by_key(|own| (own.2, own.0));
    assert!(found == triangles(&faces, &tets, |v| v), "{name}: other triangles");
}

/// Figures that do not depend on time, threads or who is asked.
fn figures(stats: &RefineStats) -> RefineStats {
    RefineStats {
        deferred: 0,
        refused: 0,
        barred: 0,
        round_threads: 0,
        recover_seconds: 0.0,
        start_seconds: 0.0,
        refine_seconds: 0.0,
        ..*stats
    }
}

#[test]
fn parts_of_domains_are_the_engines_mesh() {
    let mut kept = 0;
    for (k, (kind, volume, angle, _)) in NAMED.into_iter().enumerate() {
        let usual = Shape::default();
        let shape = Shape { angle: angle.or(usual.angle), ..usual };
        let domain = generate_domain(kind, &shape).expect("a shape");
        let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
        let markers: Vec<i32> = (0..ready.domain.facets.len() as i32).map(|f| f % 5 + 1).collect();
        let markers = (k % 2 == 1).then_some(&markers[..]);
        for degrees in [0.0, 8.0] {
            let refiner = Refiner::new().max_volume(volume).min_dihedral(degrees).start(0);
            let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
            let engine = match markers {
                Some(markers) => engine.with_markers(markers.to_vec()),
                None => engine,
            };
            for members in [1, 2, 3, 5] {
                let name = format!("{kind:?} {volume} {angle:?} {degrees} on {members}");
                match in_parts(&refiner, &ready, members, markers) {
                    Ends::Parts(parts) => {
                        assert_eq!(engine.outcome, RefineOutcome::Met, "{name}");
                        same(&name, &parts, &engine, &ready);
                        kept += 1;
                    }
                    Ends::Whole(why) => println!("{name}: {why}"),
                }
            }
        }
    }
    // The others are at angles so small that something cannot be split.
    assert!(kept >= 100, "{kept} runs have ended in parts");
}
