//! Patches of facets that are coplanar within a tolerance.

use ltbw_verify::{Limits, Mesh, Options, Plc, PlcFacet, VertexOrder, conforms};

/// A tetrahedron lower than the tolerance: its sides are a patch above its base, which is exactly
/// on a facet of its own although its corners are the patch's. Its face was taken for a tile of the
/// patch, which seemed covered twice.
#[test]
fn a_face_on_another_facet_is_no_tile_of_the_patch_above_it() {
    let height = f64::from(f32::EPSILON) * 4.0;
    let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.25, 0.25, height]];
    let facet =
        |ring: [u32; 3]| PlcFacet { polygons: vec![ring.to_vec()], holes: Vec::new(), marker: 0 };
    let plc = |flat_tolerance: f64| Plc {
        vertices: vertices.clone(),
        facets: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(facet).to_vec(),
        segments: Vec::new(),
        holes: Vec::new(),
        regions: Vec::new(),
        flat_tolerance,
    };
    let tets = [[0, 1, 2, 3]];
    let mesh = Mesh::new(&vertices, &tets);
    let options = Options { vertex_order: VertexOrder::Any, ..Options::default() };
    for (tolerance, patches) in [(0.0, 0), (4.0 * height, 1)] {
        let found = conforms(&mesh, &plc(tolerance), None, &Limits::default(), &options);
        assert!(found.passed(), "{tolerance}: {:?} {:?}", found.findings, found.mesh_defects);
        assert_eq!((found.patches, found.subfaces), (patches, 4));
    }
}
