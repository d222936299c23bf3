//! Points given in a domain: one mesh for any number of threads and of workers, and every point is
//! a vertex of it.

use ltbw::domain::exterior::LEFT_OUT;
use ltbw::domain::{Domain, PrepareOptions};
use ltbw::refine::{Refined, Refiner};
use ltbw::refining::rounds_on_threads;
use ltbw::threads::Parallel;
use ltbw_generate::scattered::scattered;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use rayon::ThreadPoolBuilder;
use std::collections::HashSet;

/// The vertices of a mesh that tetrahedra of the domain have.
fn used(refined: &Refined) -> HashSet<u32> {
    refined.inside().tets.iter().flatten().copied().collect()
}

#[test]
fn vertices_move_alike_after_rounds_of_workers() {
    let domain = generate_domain(DomainKind::TwoMaterial, &Shape::default()).expect("a domain");
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refiner = Refiner::new().max_volume(1e-3).start(64).smooth(2);
    let whole = (&ready.domain, &ready.lattice);
    let engine = refiner.refine(whole.0, whole.1).expect("a mesh");
    assert!(engine.stats.moved > 100, "{}", engine.stats.moved);
    for workers in [1, 2, 3] {
        let run = rounds_on_threads(&refiner, whole, &Parallel::new(workers)).expect("a run ends");
        assert!(run.figures.points > 0, "{workers}");
        let refined = run.refined;
        assert_eq!(refined.mesh().hash(), engine.mesh().hash(), "{workers}");
        assert_eq!(refined.stats.moved, engine.stats.moved, "{workers}");
    }
}

#[test]
fn a_thousand_points_have_one_mesh_by_threads_and_workers() {
    for (kind, volume) in [(DomainKind::CubeOctahedron, 2e-3), (DomainKind::Tee, 1e-2)] {
        let domain = generate_domain(kind, &Shape::default()).expect("a domain");
        // As many inside, on facets and on edges: 1,000.
        let given = scattered(&domain, 11, 333);
        let in_box = given.in_box.len();
        let all = Domain { points: given.all(), ..domain.clone() };
        let ready = all.prepare(&PrepareOptions::default()).expect("a sound domain");
        let is_inside = |k: &usize| ready.placed.map[*k] != LEFT_OUT;
        let kept = (0..in_box).filter(is_inside).take(334).chain(in_box..all.points.len());
        let points = kept.map(|k| all.points[k]).collect();
        let ready = Domain { points, ..domain }.prepare(&PrepareOptions::default());
        let ready = ready.expect("a sound domain");
        let placed = &ready.placed;
        assert_eq!((placed.map.len(), ready.repairs.exterior_points), (1000, 0), "{kind:?}");
        assert!(placed.on_edges > 300 && placed.on_facets > 300, "{placed:?}");

        let refiner = Refiner::new().max_volume(volume).start(64);
        let mut hashes = HashSet::new();
        for threads in [1, 2] {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| {
                let whole = (&ready.domain, &ready.lattice);
                let engine = refiner.refine(whole.0, whole.1).expect("a mesh");
                let workers = [1, 2, 3].map(|workers| {
                    let run = rounds_on_threads(&refiner, whole, &Parallel::new(workers));
                    run.expect("a run ends").refined
                });
                for refined in [engine].iter().chain(&workers) {
                    hashes.insert(refined.mesh().hash().expect("a hash").to_string());
                    let used = used(refined);
                    assert!(placed.map.iter().all(|number| used.contains(number)), "{kind:?}");
                }
            });
        }
        assert_eq!(hashes.len(), 1, "{kind:?}: {hashes:?}");
    }
}
