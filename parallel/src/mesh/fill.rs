//! The home's retriangulation: the star of the point over the cavity's boundary, as one patch for
//! every worker that loses, gets or links a tetrahedron.

use super::blocks::{prevailing, prevailing_of};
use super::corners::Corners;
use super::name::NOWHERE;
use super::{At, Link, LocalMesh, NewTet, Patch, Piece, Relink, To, VertexName, WireVertex};
use crate::protocol::{BlockId, Directory, Handle, Name, Part, WorkerId};
use ltbw_core::edges::{EdgeTable, Met};
use ltbw_core::topology::{FaceId, TetId, slot_of, tet_of};

/// A face of the cavity's boundary, and the new tetrahedron on it.
#[derive(Debug)]
struct BoundaryFace {
    /// The face, as indices of the cavity's corners.
    v: [u32; 3],
    /// The new tetrahedron's block.
    block: BlockId,
    /// Its owner, the place of that one's patch, and its index among the new ones there.
    owner: WorkerId,
    patch: u32,
    index: u32,
    name: Option<Name>,
    /// Neighbours by slot, faces of other boundary faces' new tetrahedra by the boundary faces'
    /// places. Entry 0 is not used.
    beside: [FaceId; 4],
    /// The ring tetrahedron behind the face: its worker, place, slot, block and name.
    worker: WorkerId,
    at: At,
    slot: u8,
    ring_block: BlockId,
    ring_name: Option<Name>,
}

/// Scratch memory for filling a cavity, kept for the next one.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub(super) corners: Corners,
    /// The blocks of the corners; that of the one at infinity means nothing.
    corner_blocks: Vec<BlockId>,
    boundary: Vec<BoundaryFace>,
    /// Names of the cavity's tetrahedra, ascending.
    named: Vec<Name>,
    /// The corners of one owner's part, as indices of the cavity's corners.
    places: Vec<u32>,
    edges: EdgeTable,
}

/// The handle of boundary face `boundary face`'s new tetrahedron at `slot`.
fn handle_of(border: &BoundaryFace, slot: u8) -> Option<Handle> {
    border.name.map(|name| Handle { name, block: border.block, face: slot })
}

impl LocalMesh {
    /// The patches that fill a cavity with the star of its point, one for each worker concerned.
    pub(crate) fn fill_cavity(
        &mut self,
        point: &WireVertex,
        parts: &[Part<impl AsRef<Piece>>],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) -> Vec<(WorkerId, Patch)> {
        self.located.remove(&point.name);
        let mut scratch = std::mem::take(&mut self.scratch);
        self.find_boundary(&mut scratch, point, parts, whereabouts, directory);
        let Scratch { corners, boundary, edges, .. } = &mut scratch;
        // By worker; few have a part.
        let mut counts: Vec<Kept<WorkerId, u32>> = Vec::with_capacity(parts.len() + 1);
        for border in &mut *boundary {
            let place = place_of(&mut counts, border.owner, || 0);
            border.patch = place as u32;
            border.index = counts[place].value;
            counts[place].value += 1;
        }
        join(boundary, edges);
        self.name_boundary(boundary);
        let mut patches: Vec<Kept<WorkerId, Patch>> =
            Vec::with_capacity(counts.len() + parts.len());
        for Kept { key, value: count } in counts {
            let create = Vec::with_capacity(count as usize);
            let vertices = corners.vertices.clone();
            let value = Patch { vertices, create, ..Patch::default() };
            patches.push(Kept { key, value });
        }
        for (worker, pieces) in parts.iter().filter(|(_, pieces)| !pieces.is_empty()) {
            let patch = patch_of(&mut patches, *worker);
            patch.remove.reserve_exact(pieces.iter().map(|piece| piece.as_ref().tets.len()).sum());
            patch.remove.extend(pieces.iter().flat_map(|piece| &piece.as_ref().tets));
        }
        for border in &*boundary {
            let n = [0, 1, 2, 3].map(|slot| lead(boundary, border, slot));
            let [a, b, c] = border.v;
            let new = NewTet { name: border.name, v: [0, a, b, c], block: border.block, n };
            patches[border.patch as usize].value.create.push(new);
            if border.worker != border.owner
                && let Some(to) = handle_of(border, 0)
            {
                let relink =
                    Relink { at: border.at, slot: border.slot, name: border.ring_name, to };
                let relinks = &mut patch_of(&mut patches, border.worker).relink;
                if relinks.is_empty() {
                    relinks.reserve(16);
                }
                relinks.push(relink);
            }
        }
        patches.sort_unstable_by_key(|kept| kept.key);
        self.scratch = scratch;
        patches.into_iter().map(|Kept { key, value }| (key, value)).collect()
    }

    /// The boundary of the cavity, and its corners.
    fn find_boundary(
        &self,
        scratch: &mut Scratch,
        point: &WireVertex,
        parts: &[Part<impl AsRef<Piece>>],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) {
        let Scratch { corners, corner_blocks, boundary, named, places, .. } = scratch;
        let pieces =
            || parts.iter().flat_map(|(w, list)| list.iter().map(move |p| (*w, p.as_ref())));
        named.clear();
        named.extend(pieces().flat_map(|(_, piece)| &piece.names));
        named.sort_unstable();
        boundary.clear();
        corners.start(1 + pieces().map(|(_, piece)| piece.vertices.len()).sum::<usize>());
        corners.index(point.name, || *point);
        corner_blocks.clear();
        for (worker, piece) in pieces() {
            places.clear();
            places
                .extend(piece.vertices.iter().map(|vertex| corners.index(vertex.name, || *vertex)));
            let new = &corners.vertices[corner_blocks.len()..];
            corner_blocks.extend(new.iter().map(|vertex| self.block_of_vertex(vertex)));
            for side in &piece.sides {
                let v = side.v.map(|k| places[k as usize]);
                let names = v.map(|k| corners.vertices[k as usize].name);
                let (worker, at, slot, ring_name) = match side.link {
                    Link::Far(handle) if named.binary_search(&handle.name).is_ok() => continue,
                    Link::Near { tet, slot, name, .. } => (worker, At::Tet(tet), slot, name),
                    Link::Far(Handle { name, block, face }) => {
                        let worker = whereabouts(name).unwrap_or_else(|| directory.owner(block));
                        (worker, At::Named(name), face, Some(name))
                    }
                };
                let block = self.block_by(corner_blocks, v, names[2]);
                let owner = directory.owner(block);
                let ring_block = match side.link {
                    Link::Far(handle) => handle.block,
                    // The block matters only to a worker that has not got the ring tetrahedron.
                    Link::Near { .. } if worker == owner => BlockId::default(),
                    Link::Near { apex, .. } => {
                        let block =
                            |k: usize| (names[k] != NOWHERE).then(|| corner_blocks[v[k] as usize]);
                        let blocks = || prevailing_of([block(0), block(1), block(2), apex]);
                        self.fixed.map_or_else(blocks, |fixed| fixed.block_of(worker))
                    }
                };
                boundary.push(BoundaryFace {
                    v,
                    block,
                    owner,
                    patch: 0,
                    index: 0,
                    name: None,
                    beside: [FaceId::default(); 4],
                    worker,
                    at,
                    slot,
                    ring_block,
                    ring_name,
                });
            }
        }
    }

    /// The block of a new tetrahedron on corners `v`, the last of which is vertex `last`.
    fn block_by(&self, blocks: &[BlockId], v: [u32; 3], last: VertexName) -> BlockId {
        if let Some(fixed) = self.fixed {
            return fixed.block_of(fixed.owner_of_new(blocks[0], self.me));
        }
        let [a, b, c] = v.map(|k| blocks[k as usize]);
        prevailing([blocks[0], a, b], (last != NOWHERE).then_some(c))
    }

    /// Names what another worker must know: new tetrahedra beside those of others, and ring
    /// tetrahedra behind those of others.
    fn name_boundary(&mut self, boundary: &mut [BoundaryFace]) {
        // Several faces of one ring tetrahedron may be among the boundary faces: few have a new
        // name.
        let mut ring: Vec<Kept<(WorkerId, TetId), Name>> = Vec::new();
        for k in 0..boundary.len() {
            let (owner, worker) = (boundary[k].owner, boundary[k].worker);
            let beside = boundary[k].beside[1..]
                .iter()
                .any(|&face| boundary[tet_of(face).index()].owner != owner);
            if beside || worker != owner {
                boundary[k].name = Some(self.fresh_name());
            }
            if let At::Tet(tet) = boundary[k].at
                && worker != owner
                && boundary[k].ring_name.is_none()
            {
                let place = place_of(&mut ring, (worker, tet), || self.fresh_name());
                boundary[k].ring_name = Some(ring[place].value);
            }
        }
    }
}

/// The other side of face `slot` of the new tetrahedron of `boundary face`.
fn lead(boundary: &[BoundaryFace], border: &BoundaryFace, slot: usize) -> To {
    if slot == 0 {
        let name = border.ring_name;
        return match (border.at, name) {
            (At::Tet(tet), _) if border.worker == border.owner => To::Old(tet, border.slot),
            (At::Named(name), _) | (At::Tet(_), Some(name)) => {
                To::Far(Handle { name, block: border.ring_block, face: border.slot })
            }
            (At::Tet(tet), None) => To::Old(tet, border.slot),
        };
    }
    let (other, there) = (tet_of(border.beside[slot]), slot_of(border.beside[slot]) as u8);
    let other = &boundary[other.index()];
    match handle_of(other, there) {
        Some(handle) if other.owner != border.owner => To::Far(handle),
        _ => To::New(other.index, there),
    }
}

/// The value of a key in a short list.
struct Kept<K, V> {
    key: K,
    value: V,
}

/// The place of `key` in a short list, where it is put with `value` if it is not there.
fn place_of<K: PartialEq, V>(
    list: &mut Vec<Kept<K, V>>,
    key: K,
    value: impl FnOnce() -> V,
) -> usize {
    list.iter().position(|kept| kept.key == key).unwrap_or_else(|| {
        list.push(Kept { key, value: value() });
        list.len() - 1
    })
}

/// The patch of a worker.
fn patch_of(patches: &mut Vec<Kept<WorkerId, Patch>>, worker: WorkerId) -> &mut Patch {
    let place = place_of(patches, worker, Patch::default);
    &mut patches[place].value
}

/// The message of a defect of the protocol: the boundary of a cavity is a closed surface.
const OPEN_BOUNDARY: &str = "an edge of a cavity's boundary has no second face";

/// Finds the boundary faces beside each other: two of them have an edge in common, which they pass
/// in opposite directions.
fn join(boundary: &mut [BoundaryFace], edges: &mut EdgeTable) {
    edges.start(boundary.len());
    let mut joined = 0;
    for k in 0..boundary.len() {
        let [a, b, c] = boundary[k].v;
        for (from, to, slot) in [(a, b, 3), (b, c, 1), (c, a, 2)] {
            let face = FaceId::new(TetId::at(k), slot);
            match edges.meet(from, to, face) {
                Met::Nothing => {}
                Met::Face(other) => {
                    boundary[k].beside[slot] = other;
                    boundary[tet_of(other).index()].beside[slot_of(other)] = face;
                    joined += 1;
                }
                Met::Defect => panic!("{OPEN_BOUNDARY}"),
            }
        }
    }
    assert!(2 * joined == 3 * boundary.len(), "{OPEN_BOUNDARY}");
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pyramids over a ring of `n` corners, as seen from corner 0 inside.
    fn boundary(n: u32) -> Vec<BoundaryFace> {
        let faces = (0..n).flat_map(|k| {
            let (a, b) = (3 + k, 3 + (k + 1) % n);
            [[1, a, b], [2, b, a]]
        });
        let border = |v| BoundaryFace {
            v,
            block: BlockId::default(),
            owner: WorkerId::default(),
            patch: 0,
            index: 0,
            name: None,
            beside: [FaceId::default(); 4],
            worker: WorkerId::default(),
            at: At::Tet(TetId::default()),
            slot: 0,
            ring_block: BlockId::default(),
            ring_name: None,
        };
        faces.map(border).collect()
    }

    /// A boundary with a hole is a defect of the protocol, not a mesh.
    #[test]
    fn an_open_boundary_is_refused() {
        for n in [3, 40, 61, 62, 200] {
            for hole in 0..2 * n as usize {
                let mut open = boundary(n);
                open.remove(hole);
                let join = || join(&mut open, &mut EdgeTable::default());
                let panic = std::panic::catch_unwind(std::panic::AssertUnwindSafe(join));
                let text = crate::protocol::message_of(&*panic.expect_err("a hole"));
                assert_eq!(text, OPEN_BOUNDARY);
            }
        }
    }

    #[test]
    fn boundary_faces_meet_at_common_edges() {
        let mut edges = EdgeTable::default();
        // Large and small ones in turn: the table is used again.
        for n in [3, 61, 5, 62, 200, 4] {
            let mut boundary = boundary(n);
            join(&mut boundary, &mut edges);
            for (k, border) in (0..).map(TetId::new).zip(&boundary) {
                for slot in 1..4 {
                    let (other, there) =
                        (tet_of(border.beside[slot]), slot_of(border.beside[slot]));
                    let other = &boundary[other.index()];
                    assert_eq!(other.beside[there], FaceId::new(k, slot));
                    // All corners but the one opposite are common.
                    let kept = |v: [u32; 3], out: usize| {
                        let mut v = v.to_vec();
                        v.remove(out - 1);
                        v.sort_unstable();
                        v
                    };
                    assert_eq!(kept(border.v, slot), kept(other.v, there));
                }
            }
        }
    }
}
