//! Properties that must hold when a run has ended.

use super::World;
use ltbw::check::Inspect;
use ltbw::mesh::{LocalMesh, PointQueue};
use ltbw::protocol::{Source, Submesh};
use ltbw::{Builder, Mesh, PointSet, invariants};

impl<S: Submesh + Inspect, Q: Source<S>> World<S, Q> {
    /// Every worker has stopped with nothing left; every block has one owner, whom all find.
    pub(super) fn check_rest(&self) {
        for node in &self.nodes {
            let at_rest = node.is_stopped() && node.is_quiescent() && node.source().is_empty();
            assert!(at_rest, "worker {} is not at rest:\n{}", node.id(), self.describe());
        }
        assert!(self.channels.is_empty() && self.backoff.is_empty());
        for block in self.nodes[0].directory().blocks() {
            let owners = self.nodes.iter().filter(|node| node.directory().is_mine(block)).count();
            assert_eq!(owners, 1, "owners of block {block}:\n{}", self.describe());
            for node in &self.nodes {
                let mut at = node.directory();
                // News are newer at each step of the way: no worker is passed twice.
                for _ in 0..self.nodes.len() {
                    at = self.nodes[at.owner(block).index()].directory();
                }
                assert!(at.is_mine(block), "worker {} loses block {block}", node.id());
            }
        }
    }
}

impl World<LocalMesh, PointQueue> {
    /// Nothing is locked, and every tetrahedron is at its owner.
    pub(super) fn check_places(&self) {
        for node in &self.nodes {
            assert_eq!(node.mesh().tets().locked().count(), 0, "a lock:\n{}", self.describe());
            let misplaced = node.mesh().misplaced(node.directory());
            assert_eq!(misplaced, None, "a tetrahedron of another worker:\n{}", self.describe());
        }
    }
}

/// Our own invariants and the independent checker pass the mesh; of all points, if it is `whole`.
pub(super) fn certify(set: &PointSet, mesh: &Mesh, whole: bool) {
    invariants::check_all(mesh).unwrap_or_else(|defect| panic!("{defect}"));
    let plain = mesh.to_tet_mesh();
    let hull: Vec<[u32; 3]> = mesh.hull_facets().collect();
    let options = ltbw_verify::Options { all_points: whole, ..Default::default() };
    let view = ltbw_verify::Mesh::new(set.points(), &plain.tets).with_hull(&hull);
    let report = ltbw_verify::check(&view, &options);
    assert!(report.passed(), "{:?}", report.defects);
}

/// The sequential kernel builds the same mesh of the vertices that `mesh` has.
pub(super) fn same_as_anew(mesh: &Mesh) {
    let points = mesh.vertices().map(|(_, p)| p).collect();
    let set = PointSet::new(points).unwrap_or_else(|error| panic!("{error}"));
    let anew = Builder::new().build(&set).unwrap_or_else(|error| panic!("{error}")).mesh;
    assert_eq!(mesh.hash().ok(), anew.hash().ok(), "not the mesh of the points inserted");
}
