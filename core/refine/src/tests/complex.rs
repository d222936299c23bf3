//! The boundary told by carriers alone, against the tables of the sequential engine.

use super::ready;
use crate::Refiner;
use crate::mesh::marks::ENDS;
use crate::mesh::state::FACE;
use crate::rules::complex::{Complex, Start};
use crate::table::{edge, triangle};
use ltbw_core::topology::{TetId, VertexId};
use ltbw_generate::{DomainKind, Shape};

#[test]
fn carriers_tell_the_boundary() {
    for kind in DomainKind::ALL {
        let ready = ready(kind, &Shape::default());
        for vertices in [0, 2000] {
            let refiner = Refiner::new().max_volume(1e-4);
            let (mut run, _) = refiner.recovered(&ready.domain, &ready.lattice).expect("a mesh");
            run.refine(vertices).expect("a mesh");
            let own = run.refinement;
            let state = &own.state;
            if !state.is_complete() {
                continue;
            }
            let at = |v: VertexId| state.corner(v);
            let (mut edges, mut faces) = (Vec::new(), Vec::new());
            for t in state.mesh.tet_ids().collect::<Vec<TetId>>() {
                let v = state.vertices(t);
                for [i, j] in ENDS {
                    let known = state.segments.get(&edge(v[i], v[j])).copied();
                    edges.push(([v[i], v[j]].map(at).map(|end| end.carrier), known));
                }
                for face in FACE {
                    let [a, b, c] = face.map(|k| v[k]);
                    let known = state.subfaces.get(&triangle(a, b, c)).copied();
                    faces.push(([a, b, c].map(at), known));
                }
            }
            let count = [&own.state.segments.len(), &own.state.subfaces.len()].map(|n| *n);
            assert!(count[0] > 4 && count[1] > 4, "{kind:?}: {count:?}");
            let bounds = own.bounds.expect("all is there");
            let complex = Complex::of(&own.state, bounds, own.floor, own.joint_most);
            for (ends, known) in edges {
                assert_eq!(complex.segment(ends), known, "{kind:?} {vertices}: {ends:?}");
            }
            for (corners, known) in faces {
                assert_eq!(complex.facet(corners), known, "{kind:?} {vertices}: {corners:?}");
            }
        }
    }
}

/// A start has all slots of the mesh, with their regions; one of which something is cut off leads
/// nowhere.
#[test]
fn a_start_fits_together_or_is_told_apart() {
    let ready = ready(DomainKind::TwoMaterial, &Shape::default());
    let refiner = Refiner::new().max_volume(1e-2);
    let delegated = refiner.delegate(&ready.domain, &ready.lattice).expect("a mesh");
    let (_, start) = delegated.complex().expect("all is there");
    assert!(start.fits());
    let regions: Vec<u32> = start.finite().map(|own| own.1).collect();
    assert!([1, 2].iter().all(|region| regions.contains(region)));
    assert!(start.finite().all(|(v, _)| v.is_sorted() && v[3] < start.points.len() as u32));
    let spoils: [fn(&mut Start); 7] = [
        |own| own.tets.swap(9, 10),
        |own| own.tets[9] = own.tets[10],
        |own| own.points.truncate(9),
        |own| own.carriers.truncate(9),
        |own| own.labels.truncate(9),
        |own| (own.points.truncate(9), own.carriers.truncate(9)).0,
        |own| (own.tets.truncate(9), own.labels.truncate(9)).0,
    ];
    for (k, spoil) in spoils.into_iter().enumerate() {
        let mut spoilt = start.clone();
        spoil(&mut spoilt);
        assert!(!spoilt.fits(), "{k}");
    }
}
