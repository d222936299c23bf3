//! The sizes of a domain's messages, and how checkers see its submesh.

use super::mesh::DomainMesh;
use super::values::{
    ASKED, BoundVertex, DomainCargo, DomainPatch, DomainPiece, DomainPoint, KEY, NEAR,
    carriers_bytes,
};
use crate::check::{Inspect, Seen, Sent};
use crate::mesh::{LocalMesh, WireVertex};
use crate::metrics::SubmeshSize;
use crate::payload::Payload;
use crate::protocol::Name;
use crate::refining::news::DomainNews;
use ltbw_core::topology::TetId;

/// Bytes of the carriers of vertices and of regions, with the number of what follows.
fn extra_bytes(vertices: &[WireVertex], bound: &[BoundVertex], regions: &[u32]) -> u64 {
    carriers_bytes(vertices.len(), bound) + 4 * regions.len() as u64 + 2
}

impl Payload for DomainMesh<'_> {
    /// The item and the carrier matter at home alone.
    fn point_bytes(point: &DomainPoint) -> u64 {
        LocalMesh::point_bytes(&point.vertex)
    }

    fn piece_bytes(own: &DomainPiece) -> u64 {
        let near = NEAR * own.near.len() as u64 + KEY * own.refused.len() as u64 + 1;
        let extra = extra_bytes(&own.piece.vertices, &own.bound, &own.regions);
        LocalMesh::piece_bytes(&own.piece) + extra + near
    }

    fn patch_bytes(own: &DomainPatch) -> u64 {
        let first = own.first.map_or(0, |_| ASKED);
        let extra = extra_bytes(&own.patch.vertices, &own.bound, &own.regions);
        LocalMesh::patch_bytes(&own.patch) + extra + first + 1
    }

    fn cargo_bytes(cargo: &DomainCargo) -> u64 {
        let DomainCargo { tets, bound, regions } = cargo;
        let mut names: Vec<_> = tets.iter().flat_map(|own| own.v).map(|own| own.name).collect();
        names.sort_unstable();
        names.dedup();
        let extra = carriers_bytes(names.len(), bound) + 4 * regions.len() as u64;
        LocalMesh::cargo_bytes(tets) + extra
    }

    fn news_bytes(news: &DomainNews) -> u64 {
        news.bytes()
    }
}

impl SubmeshSize for DomainMesh<'_> {
    fn tets(&self) -> u64 {
        self.inner.num_tets() as u64
    }

    fn interface_faces(&self) -> u64 {
        self.inner.num_interface_faces() as u64
    }
}

impl Inspect for DomainMesh<'_> {
    fn seen(&self) -> Vec<Seen<TetId>> {
        self.inner.seen()
    }

    fn made(patch: &DomainPatch) -> Vec<Sent> {
        LocalMesh::made(&patch.patch)
    }

    fn named(patch: &DomainPatch) -> Vec<Name> {
        LocalMesh::named(&patch.patch)
    }

    fn carried(cargo: &DomainCargo) -> Vec<Sent> {
        LocalMesh::carried(&cargo.tets)
    }

    fn kinds(news: &DomainNews) -> Vec<&'static str> {
        news.kinds()
    }
}
