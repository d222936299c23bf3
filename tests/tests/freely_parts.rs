//! Domains that a team refines without rounds: parts that stay where they are, or the mesh of one.

use super::domain_parts::{joined, joined_all, judged};
use ltbw::distributed::{self, Joined};
use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::refine::Refiner;
use ltbw::refining::{TeamEnd, Wishes, domain_on_team};
use ltbw::threads::Parallel;
use ltbw::{CancelToken, TetMesh, canonical_hash};
use ltbw_cli::plc_of;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_tests::teams::on_team;
use ltbw_verify as verify;

/// Without rounds members keep their parts, too, or one of them has the mesh: certified, with about
/// as many tetrahedra as rounds have.
#[test]
fn parts_are_refined_without_rounds() {
    let mut kept = 0;
    for (kind, volume) in [
        (DomainKind::CubeOctahedron, 2e-4),
        (DomainKind::Tee, 5e-4),
        (DomainKind::CubeInCube, 2e-4),
        (DomainKind::TwoMaterial, 2e-4),
    ] {
        let domain = generate_domain(kind, &Shape::default()).expect("a shape");
        let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
        let mut sums = [0; 2];
        for degrees in [0.0, 8.0] {
            let refiner = Refiner::new().max_volume(volume).min_dihedral(degrees).start(256);
            let engine = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
            for members in [1, 2, 3, 5] {
                let name = format!("{kind:?} {degrees} on {members}");
                let tets = refined_freely(&name, &refiner, &ready, members, &mut kept);
                sums[0] += tets.unwrap_or_else(|| panic!("{name}: nobody has the mesh"));
                sums[1] += engine.num_tets();
            }
        }
        let ratio = sums[0] as f64 / sums[1] as f64;
        assert!((ratio - 1.0).abs() < 0.03, "{kind:?}: {ratio} times the tetrahedra of rounds");
    }
    assert!(kept >= 12, "{kept} runs have ended in parts");
}

/// The tetrahedra of a domain that a team has refined without rounds, whose mesh conforms; a run
/// that ends in parts is counted as `kept`.
fn refined_freely(
    name: &str,
    refiner: &Refiner<'_>,
    ready: &Prepared,
    members: u32,
    kept: &mut usize,
) -> Option<usize> {
    let ends = on_team(members, |team| {
        let (token, parallel) = (CancelToken::new(), Parallel::new(members).among_processes());
        let whole = (&ready.domain, &ready.lattice);
        let wishes = Wishes { in_parts: true, with_exterior: true, ..Wishes::default() };
        let threads = (&parallel.cancel(&token), &token);
        let end = domain_on_team(refiner, whole, threads, team, wishes).expect("a mesh");
        let found = match &end {
            TeamEnd::Part(own) => {
                let found = judged(team, own, ready, false);
                let hashed = distributed::hash(team, &own.inside.part).expect("a hash");
                Some((found, hashed, joined(team, own), joined_all(team, own)))
            }
            TeamEnd::Whole(..) | TeamEnd::Elsewhere => None,
        };
        (end, found)
    });
    let (mut tets, mut parts) = (None, 0);
    for end in ends {
        match end {
            (TeamEnd::Part(own), Some((found, hashed, joined, all))) => {
                assert!(found.passed(), "{name}: {:?} {:?}", found.mesh_defects, found.findings);
                let splits = own.whole.splits.expect("figures of the splits");
                assert_eq!(splits.refused, [0; 2], "{name}");
                assert_eq!((hashed.tets, found.tets), (own.whole.tets, own.whole.tets));
                if let (Some(Joined { mesh, .. }), Some(Joined { mesh: all, .. })) = (joined, all) {
                    let regions = all.tet_tags.iter().flatten();
                    let inside = all.tets.iter().zip(regions).filter(|own| *own.1 != 0);
                    assert!(inside.map(|own| *own.0).eq(mesh.tets.iter().copied()), "{name}");
                    assert_eq!(
                        (all.faces.len(), all.points),
                        (mesh.faces.len(), mesh.points.clone())
                    );
                    let hash = canonical_hash(&mesh.points, &mesh.tets).expect("a hash");
                    assert_eq!(hash, hashed.hash, "{name}");
                    tets = Some(mesh.tets.len());
                }
                parts += 1;
            }
            (TeamEnd::Whole(run, late), _) => {
                let TetMesh { points, tets: all, tet_tags, .. } = run.refined.inside();
                let plc = plc_of(ready.judged(), 0.0);
                let (limits, options) = (verify::Limits::default(), verify::Options::default());
                let mesh = verify::Mesh::new(&points, &all);
                let found = verify::conforms(&mesh, &plc, tet_tags.as_deref(), &limits, &options);
                assert!(found.passed(), "{name}: {:?} {:?}", found.mesh_defects, found.findings);
                assert!(run.splits.is_ok_and(|own| own.inserted[2] > 0), "{name}");
                println!("{name}: {}", late.why);
                tets = Some(all.len());
            }
            _ => {}
        }
    }
    assert!(parts == 0 || parts == members, "{name}: one has the mesh, or all have their parts");
    *kept += usize::from(parts > 0);
    tets
}
