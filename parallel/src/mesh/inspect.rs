//! The view of a submesh that checkers have: see [`crate::check`].

use super::{LocalMesh, Moving, Patch, VertexName, WireVertex};
use crate::check::{Inspect, Seen, Sent};
use crate::protocol::Name;
use ltbw_core::topology::{TetId, VertexId, tet_of};

/// A tetrahedron's vertices, ascending.
fn key(mut v: [VertexName; 4]) -> Vec<u64> {
    v.sort_unstable();
    v.to_vec()
}

impl Inspect for LocalMesh {
    fn seen(&self) -> Vec<Seen<TetId>> {
        let look = |(t, v): (TetId, [VertexId; 4])| Seen {
            tet: t,
            name: self.tets.tag_of(t),
            vertices: key(v.map(|v| self.vertices.name(v))),
            block: self.block_of(t),
            holder: self.tets.holder(t),
            links: self.tets.neighbours(t).map(|face| self.neighbour(tet_of(face))).to_vec(),
        };
        self.tets.tets().map(look).collect()
    }

    fn made(patch: &Patch) -> Vec<Sent> {
        let vertex = |k: u32| patch.vertices[k as usize].name;
        patch.create.iter().map(|new| (new.name, key(new.v.map(vertex)))).collect()
    }

    fn named(patch: &Patch) -> Vec<Name> {
        patch.relink.iter().filter_map(|relink| relink.name).collect()
    }

    fn carried(cargo: &Vec<Moving>) -> Vec<Sent> {
        let vertices = |v: [WireVertex; 4]| key(v.map(|vertex| vertex.name));
        cargo.iter().map(|moving| (Some(moving.name), vertices(moving.v))).collect()
    }
}
