//! The sizes of messages and submeshes: what the simulator charges for, and what threads report.

use crate::mesh::{Link, LocalMesh, Moving, Patch, Piece, Side, WireVertex};
use crate::metrics::SubmeshSize;
use crate::protocol::{Message, NoNews, Submesh};

/// Bytes of a submesh's payloads in messages.
pub trait Payload: Submesh {
    /// Bytes of a point.
    fn point_bytes(point: &Self::Point) -> u64;

    /// Bytes of a piece.
    fn piece_bytes(piece: &Self::Piece) -> u64;

    /// Bytes of a patch.
    fn patch_bytes(patch: &Self::Patch) -> u64;

    /// Bytes of a block's tetrahedra.
    fn cargo_bytes(cargo: &Self::Cargo) -> u64;

    /// Bytes of news.
    fn news_bytes(news: &Self::News) -> u64;
}

/// Kind, sender, load, ticket and attempt.
const HEADER: u64 = 32;
/// Name, block and face.
const HANDLE: u64 = 13;
/// A block, its owner and its epoch.
const NEWS: u64 = 12;

/// Bytes of `message`, as a compact encoding would have them.
pub(crate) fn bytes<S: Payload>(message: &Message<S>) -> u64 {
    HEADER
        + match message {
            Message::Walk { point, at, .. } => S::point_bytes(point) + 1 + at.map_or(0, |_| HANDLE),
            Message::Expand { point, seeds, around, .. } => {
                S::point_bytes(point) + handles(seeds.len()) + 4 * around.len() as u64
            }
            Message::Grant { pieces, foreign, bounced, moved, .. } => {
                8 + pieces.iter().map(S::piece_bytes).sum::<u64>()
                    + handles(foreign.len() + bounced.len())
                    + 4
                    + NEWS * moved.len() as u64
            }
            Message::Commit { patch, .. } => 1 + patch.as_ref().map_or(0, S::patch_bytes),
            Message::Migrate { cargo, points, .. } => {
                8 + S::cargo_bytes(cargo) + 4 + points.iter().map(S::point_bytes).sum::<u64>()
            }
            Message::Stray { cargo, .. } => 4 + S::cargo_bytes(cargo),
            Message::News(news) => S::news_bytes(news),
            Message::Token(_) => 9,
            _ => 0,
        }
}

/// Bytes of a message about load alone.
pub(crate) const LOAD_BYTES: u64 = HEADER;

fn handles(count: usize) -> u64 {
    4 + HANDLE * count as u64
}

/// The name of a vertex, which is short if it was given, and its coordinates.
fn vertex_bytes(vertex: &WireVertex) -> u64 {
    let name = if u32::try_from(vertex.name).is_ok() { 4 } else { 8 };
    name + 24
}

fn vertices_bytes(all: &[WireVertex]) -> u64 {
    all.iter().map(vertex_bytes).sum()
}

/// A name, or none.
const NAME: u64 = 9;
/// A kind and a handle: the longest of the ways to say where a face leads.
const FACE: u64 = 14;
/// A new tetrahedron: a name, four indices of vertices, a block, four faces.
const NEW: u64 = NAME + 4 * 2 + 4 + 4 * FACE;

impl Payload for LocalMesh {
    fn point_bytes(point: &WireVertex) -> u64 {
        vertex_bytes(point)
    }

    fn piece_bytes(piece: &Piece) -> u64 {
        let Piece { tets, names, sides, .. } = piece;
        let near = |side: &&Side| matches!(side.link, Link::Near { .. });
        // A near link has a local number, a slot, a vertex and perhaps a name.
        let more = sides.iter().filter(near).count() as u64 * (NAME - 3);
        16 + 4 * tets.len() as u64
            + (NAME - 1) * names.len() as u64
            + vertices_bytes(&piece.vertices)
            + (3 * 2 + FACE) * sides.len() as u64
            + more
    }

    fn patch_bytes(patch: &Patch) -> u64 {
        let Patch { remove, create, relink, .. } = patch;
        16 + 4 * remove.len() as u64
            + vertices_bytes(&patch.vertices)
            + create.len() as u64 * NEW
            + relink.len() as u64 * (NAME + 1 + NAME + FACE)
    }

    fn cargo_bytes(cargo: &Vec<Moving>) -> u64 {
        // A tetrahedron of four vertices and four faces.
        4 + cargo.iter().map(|tet| NAME + 4 * FACE + vertices_bytes(&tet.v)).sum::<u64>()
    }

    fn news_bytes(news: &NoNews) -> u64 {
        match *news {}
    }
}

impl SubmeshSize for LocalMesh {
    fn tets(&self) -> u64 {
        self.num_tets() as u64
    }

    fn interface_faces(&self) -> u64 {
        self.num_interface_faces() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::made;
    use crate::protocol::WorkerId;

    #[test]
    fn the_name_of_a_vertex_that_was_made_is_longer() {
        let vertices =
            [WireVertex::new(7u32, [0.5; 3]), WireVertex::new(made(WorkerId::new(3), 7), [0.5; 3])];
        assert_eq!(vertices.map(|v| LocalMesh::point_bytes(&v)), [28, 32]);
        let patch = |vertex| Patch { vertices: vec![vertex], ..Patch::default() };
        assert_eq!(vertices.map(|v| LocalMesh::patch_bytes(&patch(v))), [44, 48]);
    }
}
