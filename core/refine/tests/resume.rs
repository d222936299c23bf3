//! Meshes that are gone on with.

use ltbw_core::{TetMesh, canonical_hash};
use ltbw_domain::{PrepareOptions, PreparedSkin, Skin, SkinError};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use ltbw_refine::{Marked, RefineOutcome, Refined, Refiner, ResumeError};

fn hash(mesh: &TetMesh) -> String {
    canonical_hash(&mesh.points, &mesh.tets).expect("a hash").to_string()
}

fn meshed(kind: DomainKind, refiner: &Refiner<'_>) -> Refined {
    let domain = generate_domain(kind, &Shape::default()).expect("a domain");
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    refiner.refine(&ready.domain, &ready.lattice).expect("a mesh")
}

fn skin_of(mesh: &TetMesh) -> PreparedSkin {
    let skin = Skin::of(mesh).expect("a boundary");
    skin.prepare(&PrepareOptions::default()).expect("a domain")
}

const KINDS: [(DomainKind, f64); 7] = [
    (DomainKind::CubeOctahedron, 3e-4),
    (DomainKind::CubeInCube, 1e-3),
    (DomainKind::Gear, 3e-3),
    (DomainKind::Tee, 1e-3),
    (DomainKind::LBlock, 1e-2),
    (DomainKind::Stair, 1e-2),
    (DomainKind::TwoMaterial, 1e-3),
];

#[test]
fn a_mesh_that_meets_its_bounds_comes_back_as_it_is() {
    for (kind, volume) in KINDS {
        let refiner = Refiner::new().max_volume(volume);
        let first = meshed(kind, &refiner);
        assert_eq!(first.outcome, RefineOutcome::Met, "{kind:?}");
        assert!(first.slivers.is_empty(), "{kind:?}");
        let mesh = first.inside();
        let PreparedSkin { ready, flat_tolerance: flat } = skin_of(&mesh);
        assert_eq!((flat, ready.moved, ready.placed.farthest), (0.0, 0, 0.0), "{kind:?}");
        let few = generate_domain(kind, &Shape::default()).expect("a domain").vertices.len();
        assert!(ready.domain.vertices.len() <= few + few / 4, "{kind:?}: {few}");
        let again = refiner.resume(&mesh).expect("a mesh");
        let points =
            again.stats.segment_points + again.stats.facet_points + again.stats.free_points;
        assert_eq!(points, 0, "{kind:?}");
        let other = again.inside();
        assert_eq!(hash(&mesh), hash(&other), "{kind:?}");
        // Tags and markers are kept.
        let tags = |mesh: &TetMesh| {
            let mut tags = mesh.tet_tags.clone().expect("tags");
            tags.sort_unstable();
            tags
        };
        assert_eq!(tags(&mesh), tags(&other), "{kind:?}");
        let markers = |mesh: &TetMesh| {
            let mut all: Vec<i64> = mesh.faces.iter().map(|face| face.marker).collect();
            all.sort_unstable();
            all
        };
        assert_eq!(markers(&mesh), markers(&other), "{kind:?}");
        // A finer one has all of its vertices.
        let finer = Refiner::new().max_volume(volume / 2.0).resume(&mesh).expect("a mesh");
        assert_eq!(finer.outcome, RefineOutcome::Met, "{kind:?}");
        let finer = finer.inside();
        let known: std::collections::HashSet<[u64; 3]> =
            finer.points.iter().map(|p| p.map(f64::to_bits)).collect();
        assert!(mesh.points.iter().all(|p| known.contains(&p.map(f64::to_bits))), "{kind:?}");
        let at_once = meshed(kind, &Refiner::new().max_volume(volume / 2.0)).num_tets();
        let share = finer.tets.len() as f64 / at_once as f64;
        println!(
            "{kind:?}: {} to {}, at once {at_once}: {share}",
            mesh.tets.len(),
            finer.tets.len()
        );
        assert!(share < 1.25, "{kind:?}: {share}");
    }
}

#[test]
fn marked_tetrahedra_are_split() {
    let refiner = Refiner::new().max_volume(1e-2);
    let mesh = meshed(DomainKind::Tee, &refiner).inside();
    let marks = [3, 17];
    let marked = Marked::new(&mesh, &marks).expect("tetrahedra");
    let field = |p| marked.at(p);
    let finer = Refiner::new().sizing(&field).resume(&mesh).expect("a mesh");
    let points = finer.stats.segment_points + finer.stats.facet_points + finer.stats.free_points;
    assert!((1..40).contains(&points), "{points}");
    let corners = |mesh: &TetMesh, v: &[u32; 4]| {
        let mut own = v.map(|v| mesh.points[v as usize].map(f64::to_bits));
        own.sort_unstable();
        own
    };
    let other = finer.inside();
    let left: std::collections::HashSet<_> =
        other.tets.iter().map(|v| corners(&other, v)).collect();
    assert!(marks.iter().all(|&t| !left.contains(&corners(&mesh, &mesh.tets[t]))));
}

#[test]
fn what_cannot_be_gone_on_with_is_named() {
    let refuse = |mesh: &TetMesh| match Refiner::new().resume(mesh) {
        Err(ResumeError::Mesh(error)) => error,
        other => panic!("{other:?}"),
    };
    assert_eq!(refuse(&TetMesh::default()), SkinError::Empty);
    let points = vec![
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.25, 0.25, -0.125],
        [1.0, 1.0, 0.0],
    ];
    let of = |tets: &[[u32; 4]]| TetMesh {
        points: points.clone(),
        tets: tets.to_vec(),
        ..TetMesh::default()
    };
    assert_eq!(refuse(&of(&[[0, 1, 2, 9]])), SkinError::Index { tet: 0 });
    let flat = refuse(&of(&[[0, 1, 2, 3], [0, 1, 2, 5]]));
    assert_eq!(flat, SkinError::Flat { tet: 1, at: [0.0; 3] });
    // Both on one side.
    let overlap = refuse(&of(&[[0, 1, 2, 3], [1, 0, 5, 3], [0, 1, 2, 4], [0, 1, 2, 3]]));
    assert!(matches!(overlap, SkinError::Overlap { .. }), "{overlap}");
    let sphere = refuse(&of(&[[0, 1, 2, 3], [0, 2, 1, 4]]));
    let told = SkinError::NotDelaunay { tet: 0, corner: [0.0; 3], vertex: 4, at: points[4] };
    assert_eq!(sphere, told);
    assert!(sphere.to_string().contains("not Delaunay"), "{sphere}");
    // Its vertices and its boundary make a mesh nevertheless.
    let mesh = of(&[[0, 1, 2, 3], [0, 2, 1, 4]]);
    let skin = Skin::of(&mesh).expect("a boundary");
    let prepared = skin.prepare(&PrepareOptions::default());
    let PreparedSkin { ready, flat_tolerance } = prepared.expect("a domain");
    let refiner = Refiner::new().flat_tolerance(flat_tolerance);
    let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    assert!(refined.lost.is_empty());
    // Two parts are two bodies.
    let far = |p: &[f64; 3]| p.map(|c| c + 4.0);
    let mut two = of(&[[0, 1, 2, 3]]);
    two.points.extend(points.iter().map(far));
    two.tets.push([6, 7, 8, 9]);
    let refined = Refiner::new().max_volume(0.01).resume(&two).expect("two bodies");
    assert_eq!(refined.regions.len(), 3);
}
