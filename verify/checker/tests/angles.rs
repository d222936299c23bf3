//! Dihedral angles of meshes of domains: counted, and no breach.

use ltbw_verify::{Conformity, Limits, Mesh, Options, Plc, PlcFacet, VertexOrder, conforms};

/// A tetrahedron with an angle of 30 degrees and none of the others below 70.
const THIRTY: [[f64; 3]; 4] = [[0.0; 3], [2.0, -2.0, -2.0], [2.0, -2.0, 1.0], [1.0, -3.0, 1.0]];

/// The tetrahedron as a mesh of the domain that its faces bound.
fn alone(points: &[[f64; 3]; 4], min_dihedral: Option<f64>, flat_tolerance: f64) -> Conformity {
    let facet = |ring: [u32; 3]| PlcFacet { polygons: vec![ring.to_vec()], ..PlcFacet::default() };
    let plc = Plc {
        vertices: points.to_vec(),
        facets: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(facet).to_vec(),
        flat_tolerance,
        ..Plc::default()
    };
    let options = Options { vertex_order: VertexOrder::Any, ..Options::default() };
    let limits = Limits { min_dihedral, ..Limits::default() };
    conforms(&Mesh::new(points, &[[0, 1, 2, 3]]), &plc, None, &limits, &options)
}

#[test]
fn small_angles_are_counted_and_no_breach() {
    assert_eq!(alone(&THIRTY, None, 0.0).below_dihedral, None);
    // The squared cosine of 30 degrees is the double 3/4: equal is not below.
    for (bound, count) in [(12.0, 0), (30.0, 0), (30.000_000_1, 1), (90.0, 1)] {
        let found = alone(&THIRTY, Some(bound), 0.0);
        assert!(found.passed(), "{:?} {:?}", found.findings, found.mesh_defects);
        let small = found.below_dihedral.expect("asked for");
        assert_eq!((small.bound, small.count, small.tets.len()), (bound, count, count as usize));
        let least = small.least.expect("an angle");
        assert!((least.value - 30.0).abs() < 1e-12, "{least:?}");
    }
}

#[test]
fn tetrahedra_within_a_patch_count_too() {
    let height = f64::from(f32::EPSILON) * 4.0;
    let low = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.25, 0.25, height]];
    for tolerance in [0.0, 4.0 * height] {
        let found = alone(&low, Some(12.0), tolerance);
        assert!(found.passed(), "{:?} {:?}", found.findings, found.mesh_defects);
        assert_eq!(found.below_dihedral.map(|small| small.count), Some(1));
    }
}
