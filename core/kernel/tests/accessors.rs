//! Figures that meshes, builders and generators tell about themselves.

use ltbw_core::{Budget, Builder, Order};
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
