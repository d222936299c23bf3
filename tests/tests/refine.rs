//! Meshes of domains, judged by the independent checker: conformity, bounds, exact volume.
//!
//! Random domains: 40 by default, `LTBW_CASES` for more (500 for the full bar).

use ltbw::domain::Prepared;
use ltbw::refine::{RefineOutcome, Refined, Refiner};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_tests::cases;
use ltbw_tests::domains::{plc_of, prepared, random_domain};
use ltbw_tests::excuses::{judge_refined, limits};
use ltbw_verify::{Conformity, ConformityDefect, Limits, Mesh, Options, Plc, conforms};

/// Refines, and has the result checked against domain and bounds.
fn refine_and_judge(ready: &Prepared, volume: Option<f64>, ratio: f64) -> (Refined, Conformity) {
    let mut refiner = Refiner::new().radius_edge(ratio);
    if let Some(volume) = volume {
        refiner = refiner.max_volume(volume);
    }
    let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    let bounds = limits(&ready.domain, Some(ratio), volume);
    let (found, count) = judge_refined(ready, &refined, &bounds).expect("a sound mesh");
    assert!(!count.is_broken(), "{count}");
    (refined, found)
}

/// Everything is met and certified, and the volume is the domain's own.
fn assert_certified(ready: &Prepared, volume: Option<f64>, name: &str) -> Refined {
    let (refined, found) = refine_and_judge(ready, volume, 2.0);
    assert!(
        found.passed(),
        "{name}: {:?} {:?}",
        found.findings.first(),
        found.mesh_defects.first()
    );
    assert_eq!(refined.outcome, RefineOutcome::Met, "{name}");
    let own = ready.report.volume().expect("a volume").to_string();
    assert_eq!(found.volume.expect("an exact volume").to_string(), own, "{name}");
    refined
}

fn generated(kind: DomainKind, shape: &Shape) -> Prepared {
    prepared(&generate_domain(kind, shape).expect("a domain"))
}

#[test]
fn the_model_problem_meets_the_bars() {
    let ready = generated(DomainKind::CubeOctahedron, &Shape::default());
    let (refined, found) = refine_and_judge(&ready, Some(1.73783e-5), 2.0);
    assert_eq!(refined.outcome, RefineOutcome::Met);
    assert!(found.passed(), "{:?}", found.findings.first());
    assert_eq!(found.volume.expect("a volume").to_string(), "47/48");
    // At most 1.03 times TetGen's 104,182.
    assert!(refined.num_tets() <= 107_307, "{}", refined.num_tets());
}

#[test]
fn the_model_domains_are_certified() {
    let bars = [
        (DomainKind::CubeInCube, 1.68e-5, 104_956.0 * 1.03),
        (DomainKind::Tee, 5e-5, 109_003.0 * 1.06),
        (DomainKind::Gear, 1e-4, f64::INFINITY),
        (DomainKind::LBlock, 1e-3, f64::INFINITY),
        (DomainKind::Stair, 1e-2, f64::INFINITY),
        (DomainKind::TwoMaterial, 1e-3, f64::INFINITY),
    ];
    for (kind, volume, most) in bars {
        let ready = generated(kind, &Shape::default());
        let refined = assert_certified(&ready, Some(volume), kind.name());
        assert!(refined.num_tets() as f64 <= most, "{kind:?}: {}", refined.num_tets());
    }
}

#[test]
fn a_damaged_mesh_does_not_conform() {
    let ready = generated(DomainKind::CubeOctahedron, &Shape::default());
    let refiner = Refiner::new().max_volume(5e-3);
    let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    let good = refined.inside();
    let plc = plc_of(&ready.domain);
    let judge = |mesh: &ltbw::TetMesh, plc: &Plc, limits: &Limits| {
        let view = Mesh::new(&mesh.points, &mesh.tets);
        conforms(&view, plc, mesh.tet_tags.as_deref(), limits, &Options::default())
    };
    let none = Limits::default();
    assert!(judge(&good, &plc, &none).passed());
    // A tetrahedron less: a hole in the mesh.
    let mut bad = good.clone();
    bad.tets.pop();
    assert!(judge(&bad, &plc, &none).count(ConformityDefect::HullFaceOffFacet) > 0);
    // A tetrahedron with another tag.
    let mut bad = good.clone();
    bad.tet_tags.as_mut().expect("tags")[7] = 9;
    assert!(judge(&bad, &plc, &none).count(ConformityDefect::TagsDiffer) > 0);
    // A point off its facet, by one unit in the last place.
    let mut bad = good.clone();
    let moved = bad.points.iter().position(|p| p[0] == 0.0 && p[1] > 0.0 && p[1] < 1.0);
    bad.points[moved.expect("a point on x = 0")][0] = 1e-15;
    assert!(!judge(&bad, &plc, &none).passed());
    // The exterior is meshed, too.
    let whole = refined.with_exterior();
    let whole = ltbw::TetMesh { tet_tags: None, ..whole };
    assert!(judge(&whole, &plc, &none).count(ConformityDefect::HoleMeshed) > 0);
    // A domain with another vertex, another edge, another facet.
    let mut other = plc.clone();
    other.vertices.push([0.123, 0.5, 0.5]);
    assert_eq!(judge(&good, &other, &none).count(ConformityDefect::VertexMissing), 1);
    let mut other = plc.clone();
    other.segments.push([0, 6]);
    assert_eq!(judge(&good, &other, &none).count(ConformityDefect::SegmentBroken), 1);
    let mut other = plc.clone();
    other.facets[0].polygons[0].pop();
    let found = judge(&good, &other, &none);
    assert!(
        found.count(ConformityDefect::SegmentBroken) == 1
            && found.count(ConformityDefect::FacetNotTiled) == 1
    );
    assert!(found.count(ConformityDefect::HullFaceOffFacet) > 0);
    // Bounds that the mesh does not have.
    let limits = Limits { max_volume: Some(1e-4), radius_edge: Some(1.0), ..Limits::default() };
    let found = judge(&good, &plc, &limits);
    assert!(
        found.count(ConformityDefect::VolumeExceeded) > 0
            && found.count(ConformityDefect::RatioExceeded) > 0
    );
}

#[test]
fn random_domains_are_certified() {
    let count = cases(40);
    let mut met = 0;
    let mut work = Vec::new();
    for seed in 0..count as u64 {
        let (name, domain) = random_domain(seed);
        let ready = prepared(&domain);
        let (refined, found) = refine_and_judge(&ready, None, 2.0);
        // Small angles may leave bounds unmet, by name; the boundary is always there.
        assert!(refined.lost.is_empty(), "{name} {seed}: {:?}", refined.lost.first());
        assert_eq!(found.mesh_defect_count, 0, "{name} {seed}: {:?}", found.mesh_defects.first());
        let bounds = |b: &ConformityDefect| {
            matches!(b, ConformityDefect::RatioExceeded | ConformityDefect::VolumeExceeded)
        };
        assert!(found.counts.keys().all(bounds), "{name} {seed}: {:?}", found.findings.first());
        let over: u64 = found.counts.values().sum();
        assert_eq!(over, refined.excuses.len() as u64, "{name} {seed}");
        let own = ready.report.volume().expect("a volume").to_string();
        assert_eq!(found.volume.expect("a volume").to_string(), own, "{name} {seed}");
        if name == "voxels" {
            // No angle of these is below the theory's limits. (The faces of a turned box are not
            // planar on the lattice: the diagonals that divide them make small angles. Layers
            // leave what the counter of excuses allows.)
            assert_eq!(refined.outcome, RefineOutcome::Met, "{name} {seed}");
        }
        met += u64::from(refined.outcome == RefineOutcome::Met);
        let stats = refined.stats;
        let inserted = stats.segment_points + stats.facet_points + stats.free_points;
        let steps = inserted + stats.deferred + stats.refused;
        work.push((steps as f64 / refined.num_tets() as f64, name, seed));
    }
    // No domain takes more than ten times the transactions that others take for a tetrahedron.
    work.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (median, most) = (work[work.len() / 2], work[work.len() - 1]);
    println!("transactions for a tetrahedron: median {:.3}, most {:.3}", median.0, most.0);
    // Many need no point at all: then a tenth of a transaction stands for the median.
    assert!(most.0 <= 10.0 * median.0.max(0.1), "{most:?} against {median:?}");
    println!("{count} random domains certified, {met} of them with every bound met");
}
