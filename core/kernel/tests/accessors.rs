//! Figures that meshes, builders and generators tell about themselves.

use ltbw_core::{Budget, Builder, Inserted, Order};
use ltbw_exact::PointSet;
use ltbw_generate::{PointKind, generate};

#[test]
fn every_kind_of_points_tells_what_it_is() {
    let mut texts: Vec<&str> = PointKind::ALL.iter().map(|kind| kind.about()).collect();
    assert!(texts.iter().all(|text| text.len() > 10));
    texts.sort_unstable();
    texts.dedup();
    assert_eq!(texts.len(), PointKind::ALL.len());
}

#[test]
fn a_mesh_tells_its_size() {
    let points = generate(PointKind::Uniform, 300, 1);
    let set = PointSet::new(points.clone()).expect("finite points");
    let mesh = Builder::new().build(&set).expect("a mesh").mesh;
    let topology = mesh.topology();
    assert!(!topology.is_empty());
    assert_eq!(topology.len(), mesh.num_tets() + mesh.num_hull_faces());
    assert_eq!(topology.slots(), topology.len() + topology.free_slots().len());
    assert_eq!(topology.iter().count(), topology.len());
    assert!(ltbw_core::topology::Topology::default().is_empty());
    // A slot takes 32 bytes of topology and 16 of sphere, a vertex those of its coordinates and
    // its number; a half more at most (what was reserved counts for nothing).
    let least = topology.slots() * (32 + 16) + 301 * (24 + 4);
    let bytes = mesh.memory_bytes();
    assert!(least <= bytes && bytes < least * 3 / 2, "{bytes} bytes, not {least}");
    assert!(std::ptr::eq(mesh.queries().mesh(), &mesh));
    assert_eq!(set.into_points(), points);
}

#[test]
fn a_builder_shows_its_settings() {
    let budget = Budget { max_points: Some(7), ..Budget::default() };
    let text = format!("{:?}", Builder::new().order(Order::Input).budget(budget));
    assert!(text.contains("order: Input") && text.contains("max_points: Some(7)"), "{text}");
    assert!(text.contains("observer: false"), "{text}");
}

#[test]
fn a_vertex_has_its_point_by_number() {
    for (kind, most) in [
        (PointKind::Uniform, None),
        (PointKind::Duplicates, None),
        (PointKind::Uniform, Some(50)),
        (PointKind::Duplicates, Some(1000)),
    ] {
        let set = PointSet::new(generate(kind, 3000, 5)).expect("finite points");
        let budget = Budget { max_points: most, ..Budget::default() };
        let mut mesh = Builder::new().budget(budget).build(&set).expect("a mesh").mesh;
        for k in 0..3u32 {
            let points = mesh.points();
            for (v, p) in (0..).zip(&points) {
                let known = (!p[0].is_nan()).then_some(*p);
                assert_eq!(mesh.point(v), known, "{kind:?}, {most:?}: vertex {v}");
                assert_eq!(mesh.queries().point(v), known);
            }
            assert_eq!(mesh.point(points.len() as u32), None);
            assert_eq!(mesh.point(u32::MAX), None);
            // Asked before, it knows what comes later.
            let new = [0.1 + f64::from(k), 0.2, 0.3];
            let next = Inserted::Vertex(3000 + k);
            assert_eq!(mesh.insert(new), Ok(next));
            assert_eq!(mesh.point(3000 + k), Some(new));
        }
        let restored = mesh.snapshot().expect("a snapshot").restore().expect("a mesh");
        assert!((0..3003).all(|v| restored.point(v) == mesh.point(v)));
    }
}

#[cfg(feature = "ndarray")]
#[test]
fn arrays_become_meshes_and_meshes_arrays() {
    let at = |(i, k): (usize, usize)| ((i * [37, 53, 71][k]) % 101) as f64;
    let array = ndarray::Array2::from_shape_fn((60, 3), at);
    let set = PointSet::try_from(array.view()).expect("points");
    let mesh = Builder::new().build(&set).expect("a mesh").mesh;
    assert_eq!(mesh.points_array(), array);
    let simplices = mesh.simplices_array();
    assert_eq!(simplices.dim(), (mesh.num_tets(), 4));
    assert!(simplices.rows().into_iter().map(|row| row.to_vec()).eq(mesh.tets().map(Vec::from)));
}
