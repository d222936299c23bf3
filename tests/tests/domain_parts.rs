//! Domains whose parts stay where they were refined: together they are the engine's mesh, to its
//! numbers, its regions and its triangles, and conform as it does.

use ltbw::distributed::{self, Hashed, Joined};
use ltbw::domain::{Domain, PrepareOptions, Prepared};
use ltbw::refine::{RefineOutcome, RefineStats, Refined, Refiner, usual_tolerance};
use ltbw::refining::{Late, RefinedPart, TeamRounds, Wishes, rounds_on_team};
use ltbw::team::Team;
use ltbw::threads::Parallel;
use ltbw::{BoundaryFace, CancelToken, TetMesh, canonical_hash};
use ltbw_cli::plc_of;
use ltbw_cli::ranks::Judge;
use ltbw_generate::surfaces::{globe, prism, shell, single, torus, turned};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_tests::domains::NAMED;
use ltbw_tests::teams::on_team;
use ltbw_verify as verify;
use std::collections::BTreeMap;

/// One member's part, and what all have found of the whole.
struct Kept {
    own: RefinedPart,
    hashed: Hashed,
    found: verify::Conformity,
    /// The regions of this part are others than they say, if it has any tetrahedra.
    spoilt: verify::Conformity,
    /// At the first member, all parts in one place: those of the domain, and with the exterior.
    joined: Option<[Joined; 2]>,
}

/// The ends of a team.
enum Ends {
    Parts(Vec<Kept>),
    Whole(Late),
}

/// The checker's findings of a mesh in parts. Of the last part a region is another one if it is
/// `spoilt`.
pub(super) fn judged(
    team: &mut Team,
    own: &RefinedPart,
    ready: &Prepared,
    spoilt: bool,
) -> verify::Conformity {
    let mut tags: Vec<i64> = own.inside.regions.iter().map(|&region| i64::from(region)).collect();
    if spoilt && team.me().number() + 1 == team.size() {
        tags.iter_mut().take(1).for_each(|tag| *tag += 1);
    }
    let distributed::Part { points, numbers, tets, .. } = &own.inside.part;
    let part = verify::DomainPart { points, numbers, tets, tags: Some(&tags) };
    let plc = plc_of(ready.judged(), own.whole.stats.flat_tolerance);
    let options = verify::Options { numbered_regions: true, ..verify::Options::default() };
    verify::conforms_parted(&mut Judge(team), &part, &plc, &verify::Limits::default(), &options)
        .expect("findings")
}

/// The mesh of the domain at the first member.
pub(super) fn joined(team: &mut Team, own: &RefinedPart) -> Option<Joined> {
    let RefinedPart { inside, outside, whole, .. } = own;
    distributed::join(team, inside.clone().into_piece(), outside.clone(), whole.vertices)
        .expect("a mesh")
}

/// The mesh with the exterior at the first member.
pub(super) fn joined_all(team: &mut Team, own: &RefinedPart) -> Option<Joined> {
    let all = own.with_exterior.as_ref().expect("the exterior is asked for");
    let none = distributed::Part::default();
    distributed::join(team, all.clone().into_piece(), none, own.whole.vertices).expect("a mesh")
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
        let wishes = Wishes { in_parts: true, with_exterior: true, markers, ..Wishes::default() };
        let end = rounds_on_team(refiner, whole, threads, team, wishes).expect("a mesh");
        let found = match &end {
            TeamRounds::Part(own) => {
                let hashed = distributed::hash(team, &own.inside.part).expect("a hash");
                let found = [false, true].map(|spoilt| judged(team, own, ready, spoilt));
                let all = [joined(team, own), joined_all(team, own)];
                let joined =
                    if let [Some(inside), Some(all)] = all { Some([inside, all]) } else { None };
                Some((hashed, found, joined))
            }
            TeamRounds::Whole(..) | TeamRounds::Elsewhere => None,
        };
        (end, found)
    });
    let (mut parts, mut late) = (Vec::new(), None);
    for end in ends {
        match end {
            (TeamRounds::Part(own), Some((hashed, [found, spoilt], joined))) => {
                parts.push(Kept { own: *own, hashed, found, spoilt, joined });
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
    let inside = TetMesh { tet_attributes: None, ..engine.inside() };
    assert_eq!(parts.iter().filter(|own| own.joined.is_some()).count(), 1, "{name}");
    let Some([Joined { mesh, owners }, all]) = &parts[0].joined else {
        panic!("{name}: the first one has no mesh");
    };
    assert!(*mesh == inside, "{name}: another mesh in one place");
    let exterior = TetMesh { tet_attributes: None, ..engine.with_exterior() };
    assert!(all.mesh == exterior, "{name}: another mesh with the exterior");
    let lengths = parts.iter().map(|own| own.own.inside.part.tets.len());
    assert!((0..).zip(lengths).all(|(k, n)| owners.iter().filter(|&&own| own == k).count() == n));
    let TetMesh { points, tets, tet_tags, faces, .. } = inside;
    let hash = canonical_hash(&points, &tets).expect("a hash");
    let regions = tet_tags.expect("regions");
    let plc = plc_of(ready.judged(), engine.stats.flat_tolerance);
    let (limits, options) = (verify::Limits::default(), verify::Options::default());
    let mesh = verify::Mesh::new(&points, &tets);
    let judged = verify::conforms(&mesh, &plc, Some(&regions), &limits, &options);
    let has_tets = |own: &&Kept| !own.own.inside.part.tets.is_empty();
    let is_spoilt = parts.last().filter(has_tets).is_some();
    let (mut all, mut found) = (Vec::new(), Vec::new());
    for Kept { own, hashed, found: conformity, spoilt, .. } in parts {
        assert!(
            conformity.passed(),
            "{name}: {:?} {:?}",
            conformity.mesh_defects,
            conformity.findings
        );
        let counts = |own: &verify::Conformity| [own.subfaces, own.tets, own.cells, own.patches];
        assert_eq!(counts(conformity), counts(&judged), "{name}");
        assert_eq!(conformity.volume_within, judged.volume_within, "{name}");
        assert_eq!(conformity.volume, judged.volume, "{name}");
        assert_eq!(spoilt.passed(), !is_spoilt, "{name}: a region that is another one");
        assert_eq!((hashed.hash, hashed.tets), (hash, tets.len() as u64), "{name}");
        let part = &own.inside.part;
        assert!(part.numbers.is_sorted(), "{name}");
        let is_there = |(&v, p): (&u32, &[f64; 3])| points[v as usize] == *p;
        assert!(part.numbers.iter().zip(&part.points).all(is_there), "{name}: other points");
        let number = |v: u32| part.numbers[v as usize];
        let told: Vec<[u32; 4]> = part.tets.iter().map(|tet| tet.map(number)).collect();
        assert!(told.is_sorted(), "{name}: in the order of the whole");
        all.extend(told.into_iter().zip(own.inside.regions.iter().map(|&r| i64::from(r))));
        let own_faces = triangles(&own.inside.faces, &part.tets, number);
        assert!(own.inside.faces.is_sorted_by_key(|face| (face.tet, face.corners)), "{name}");
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

/// The number of teams that keep a domain's mesh in parts, where it is the engine's; with markers
/// in place of the domain's own if it `is_marked`.
fn kept_by_teams(
    name: &str,
    refiner: &Refiner<'_>,
    ready: &Prepared,
    engine: Refined,
    is_marked: bool,
) -> usize {
    let markers: Vec<i32> = (0..ready.domain.facets.len() as i32).map(|f| f % 5 + 1).collect();
    let markers = is_marked.then_some(&markers[..]);
    let engine = match markers {
        Some(markers) => engine.with_markers(markers.to_vec()),
        None => engine,
    };
    let mut kept = 0;
    for members in [1, 2, 3, 5] {
        let name = format!("{name} on {members}");
        match in_parts(refiner, ready, members, markers) {
            Ends::Parts(parts) => {
                assert_eq!(engine.outcome, RefineOutcome::Met, "{name}");
                same(&name, &parts, &engine, ready);
                kept += 1;
            }
            Ends::Whole(why) => println!("{name}: {why}"),
        }
    }
    kept
}

#[test]
fn parts_of_domains_are_the_engines_mesh() {
    let mut kept = 0;
    for (k, (kind, volume, angle, _)) in NAMED.into_iter().enumerate() {
        let usual = Shape::default();
        let shape = Shape { angle: angle.or(usual.angle), ..usual };
        let domain = generate_domain(kind, &shape).expect("a shape");
        let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
        for degrees in [0.0, 8.0] {
            let refiner = Refiner::new().max_volume(volume).min_dihedral(degrees).start(0);
            let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
            let name = format!("{kind:?} {volume} {angle:?} {degrees}");
            kept += kept_by_teams(&name, &refiner, &ready, engine, k % 2 == 1);
        }
    }
    // The others are at angles so small that something cannot be split.
    assert!(kept >= 100, "{kept} runs have ended in parts");
}

/// A vertex that no tetrahedron of the domain has is a point of the mesh in one place, too.
#[test]
fn vertices_outside_are_told_with_the_parts() {
    let domain = generate_domain(DomainKind::Gear, &Shape::default()).expect("a shape");
    let mut ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let (low, high) = ready.domain.bounds().expect("vertices");
    // Corners of its box are beyond the teeth.
    ready.domain.vertices.extend([low, [high[0], high[1], low[2]]]);
    let refiner = Refiner::new().max_volume(1e-3).min_dihedral(0.0).start(64);
    let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    for members in [1, 2, 3, 5] {
        let name = format!("a gear with points beside it on {members}");
        let Ends::Parts(parts) = in_parts(&refiner, &ready, members, None) else {
            panic!("{name}: one has the mesh");
        };
        same(&name, &parts, &engine, &ready);
        let outside = parts.iter().map(|own| own.own.outside.numbers.len());
        assert!(outside.sum::<usize>() >= 2, "{name}");
    }
}

/// A surface on its lattice, and the tolerance that its patches are flat within. What it encloses
/// twice is a void if it is `oriented`, else a region.
fn surface(domain: &Domain, oriented: bool) -> (Prepared, f64) {
    let options = PrepareOptions { oriented, ..PrepareOptions::default() };
    let ready = domain.prepare(&options).expect("a sound domain");
    let tolerance = usual_tolerance(domain, &ready.domain);
    (ready, tolerance.max(5e-7))
}

/// A domain with patches between two regions.
const CORE: &str = "a cube with a core, turned";

#[test]
fn parts_of_surfaces_with_patches_are_the_engines_mesh() {
    let solid = |kind| turned(&generate_domain(kind, &Shape::default()).expect("a shape"));
    let mut kept = 0;
    for (k, (name, domain, volume)) in [
        ("a torus", single(torus(10)), 1e-3),
        ("a torus, turned", turned(&single(torus(10))), 3e-4),
        ("a shell, turned", single(turned(&shell(0.1))), 3e-4),
        ("a globe", single(globe(12, 12, 0.0, 1)), 3e-4),
        ("a prism", single(prism(12, 1e-7, 1)), 3e-4),
        ("a tee, turned", solid(DomainKind::Tee), 1e-3),
        ("a cube in a cube, turned", solid(DomainKind::CubeInCube), 1e-3),
        (CORE, single(turned(&shell(0.2))), 1e-3),
    ]
    .into_iter()
    .enumerate()
    {
        let (ready, tolerance) = surface(&domain, name != CORE);
        for degrees in [0.0, 8.0] {
            let refiner = Refiner::new().flat_tolerance(tolerance).max_volume(volume);
            let refiner = refiner.min_dihedral(degrees).start(64);
            let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
            assert!(engine.stats.patches > 0, "{name}");
            assert_eq!(engine.regions.len(), 2 + usize::from(name == CORE), "{name}");
            let name = format!("{name} {degrees}");
            kept += kept_by_teams(&name, &refiner, &ready, engine, k % 2 == 1);
        }
    }
    assert!(kept >= 56, "{kept} runs have ended in parts");
}

/// A mesh with regions, as whole and in parts.
#[derive(Clone)]
struct Tagged {
    points: Vec<[f64; 3]>,
    tets: Vec<[u32; 4]>,
    tags: Vec<i64>,
}

/// Options of all checks here.
fn options() -> verify::Options {
    verify::Options { numbered_regions: true, ..verify::Options::default() }
}

impl Tagged {
    fn judged(&self, plc: &verify::Plc) -> verify::Conformity {
        let mesh = verify::Mesh::new(&self.points, &self.tets);
        verify::conforms(&mesh, plc, Some(&self.tags), &verify::Limits::default(), &options())
    }

    /// The findings of a team among whose members tetrahedra are dealt out one by one.
    fn judged_in_parts(&self, plc: &verify::Plc, members: u32) -> verify::Conformity {
        let mut all = on_team(members, |team| {
            let own = |t: &usize| t % members as usize == team.me().index();
            let list: Vec<usize> = (0..self.tets.len()).filter(own).collect();
            let mut numbers: Vec<u32> = list.iter().flat_map(|&t| self.tets[t]).collect();
            numbers.sort_unstable();
            numbers.dedup();
            let place = |v: u32| numbers.partition_point(|&n| n < v) as u32;
            let tets: Vec<[u32; 4]> = list.iter().map(|&t| self.tets[t].map(place)).collect();
            let points: Vec<[f64; 3]> = numbers.iter().map(|&v| self.points[v as usize]).collect();
            let tags: Vec<i64> = list.iter().map(|&t| self.tags[t]).collect();
            let tags = Some(&tags[..]);
            let part = verify::DomainPart { points: &points, numbers: &numbers, tets: &tets, tags };
            let limits = verify::Limits::default();
            verify::conforms_parted(&mut Judge(team), &part, plc, &limits, &options())
                .expect("findings")
        });
        let first = all.swap_remove(0);
        assert!(all.iter().all(|other| format!("{other:?}") == format!("{first:?}")));
        first
    }
}

/// Nearly all faces are between parts here. What is wrong at a patch is found as in the whole mesh,
/// and counted as there.
#[test]
fn wrong_parts_at_patches_are_found() {
    let (ready, tolerance) = surface(&single(turned(&shell(0.2))), false);
    let refiner = Refiner::new().flat_tolerance(tolerance).max_volume(5e-3);
    let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    let TetMesh { points, tets, tet_tags, faces, .. } = refined.inside();
    let good = Tagged { points, tets, tags: tet_tags.expect("regions") };
    let plc = plc_of(ready.judged(), refined.stats.flat_tolerance);
    let compare = |name: &str, mesh: &Tagged, plc: &verify::Plc| {
        let whole = mesh.judged(plc);
        for members in [1, 2, 3, 5] {
            let parts = mesh.judged_in_parts(plc, members);
            let counts = |own: &verify::Conformity| {
                (own.counts.clone(), own.mesh_defect_count > 0, own.subfaces, own.cells)
            };
            assert_eq!(counts(&parts), counts(&whole), "{name} on {members}");
            assert_eq!(parts.volume, whole.volume, "{name} on {members}");
            assert_eq!(parts.patches, whole.patches, "{name} on {members}");
        }
        whole
    };
    let found = compare("as it is", &good, &plc);
    assert!(found.passed() && found.patches > 2 && found.cells > 1, "{:?}", found.findings);
    // Exact facets have edges that the mesh does not have.
    let exact = verify::Plc { flat_tolerance: 0.0, ..plc.clone() };
    assert!(!compare("no tolerance", &good, &exact).passed());
    let mut seen = BTreeMap::new();
    let mut wrong = |name: &'static str, mesh: &Tagged| {
        let found = compare(name, mesh, &plc);
        assert!(!found.passed(), "{name}");
        let is_untiled = found.count(verify::ConformityDefect::FacetNotTiled) > 0;
        *seen.entry(name).or_insert(0) += usize::from(is_untiled);
    };
    for face in faces.iter().step_by(7) {
        let (mut lacking, mut mixed) = (good.clone(), good.clone());
        lacking.tets.remove(face.tet);
        lacking.tags.remove(face.tet);
        wrong("without a tetrahedron at a patch", &lacking);
        mixed.tags[face.tet] = 3 - good.tags[face.tet];
        wrong("the region beyond on both sides", &mixed);
        for (k, by) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
            // Above the tolerance, and a multiple of all units.
            let mut moved = good.clone();
            moved.points[face.corners[2] as usize][k] += by / 131_072.0;
            wrong("a vertex off its patch", &moved);
        }
    }
    assert!(seen.len() == 3 && seen.values().all(|&untiled| untiled > 0), "{seen:?}");
}
