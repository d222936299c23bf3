//! The home's retriangulation: the star of the point over the cavity's boundary, as one patch for
//! every worker that loses, gets or links a tetrahedron.

use super::blocks::{prevailing, prevailing_of};
use super::corners::Corners;
use super::name::NOWHERE;
use super::{At, Link, LocalMesh, NewTet, Patch, Piece, Relink, To, VertexName, WireVertex};
use crate::protocol::{BlockId, Directory, Handle, Name, WorkerId};
use ltbw_core::edges::{EdgeTable, Met};
use ltbw_core::topology::{FaceId, TetId, slot_of, tet_of};

/// A face of the cavity's boundary, and the new tetrahedron on it.
#[derive(Debug)]
struct Wall {
    /// The face, as indices of the cavity's corners.
    v: [u32; 3],
    /// The new tetrahedron's block.
    block: BlockId,
    /// Its owner, the place of that one's patch, and its index among the new ones there.
    owner: WorkerId,
    patch: u32,
    index: u32,
    name: Option<Name>,
    /// Neighbours by slot, faces of other walls' new tetrahedra by the walls' places. Entry 0 is
    /// not used.
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
    walls: Vec<Wall>,
    /// Names of the cavity's tetrahedra, ascending.
    named: Vec<Name>,
    /// The corners of one owner's part, as indices of the cavity's corners.
    places: Vec<u32>,
    edges: EdgeTable,
}

/// The handle of wall `wall`'s new tetrahedron at `slot`.
fn handle_of(wall: &Wall, slot: u8) -> Option<Handle> {
    wall.name.map(|name| Handle { name, block: wall.block, face: slot })
}

impl LocalMesh {
    pub(super) fn fill_cavity(
        &mut self,
        point: &WireVertex,
        parts: &[(WorkerId, Vec<Piece>)],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) -> Vec<(WorkerId, Patch)> {
        let mut scratch = std::mem::take(&mut self.scratch);
        self.find_walls(&mut scratch, point, parts, whereabouts, directory);
        let Scratch { corners, walls, edges, .. } = &mut scratch;
        // By worker; few have a part.
        let mut counts: Vec<(WorkerId, u32)> = Vec::with_capacity(parts.len() + 1);
        for wall in &mut *walls {
            let place = place_of(&mut counts, wall.owner, || 0);
            wall.patch = place as u32;
            wall.index = counts[place].1;
            counts[place].1 += 1;
        }
        join(walls, edges);
        self.name_walls(walls);
        let mut patches: Vec<(WorkerId, Patch)> = Vec::with_capacity(counts.len() + parts.len());
        for (owner, count) in counts {
            let create = Vec::with_capacity(count as usize);
            let sites = corners.sites.clone();
            patches.push((owner, Patch { sites, create, ..Patch::default() }));
        }
        for (worker, pieces) in parts.iter().filter(|(_, pieces)| !pieces.is_empty()) {
            let patch = patch_of(&mut patches, *worker);
            patch.remove.reserve_exact(pieces.iter().map(|piece| piece.tets.len()).sum());
            patch.remove.extend(pieces.iter().flat_map(|piece| &piece.tets));
        }
        for wall in &*walls {
            let n = [0, 1, 2, 3].map(|slot| lead(walls, wall, slot));
            let [a, b, c] = wall.v;
            let new = NewTet { name: wall.name, v: [0, a, b, c], block: wall.block, n };
            patches[wall.patch as usize].1.create.push(new);
            if wall.worker != wall.owner
                && let Some(to) = handle_of(wall, 0)
            {
                let relink = Relink { at: wall.at, slot: wall.slot, name: wall.ring_name, to };
                let relinks = &mut patch_of(&mut patches, wall.worker).relink;
                if relinks.is_empty() {
                    relinks.reserve(16);
                }
                relinks.push(relink);
            }
        }
        patches.sort_unstable_by_key(|&(worker, _)| worker);
        self.scratch = scratch;
        patches
    }

    /// The boundary of the cavity, and its corners.
    fn find_walls(
        &self,
        scratch: &mut Scratch,
        point: &WireVertex,
        parts: &[(WorkerId, Vec<Piece>)],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) {
        let Scratch { corners, corner_blocks, walls, named, places, .. } = scratch;
        let pieces = || parts.iter().flat_map(|(w, list)| list.iter().map(move |p| (*w, p)));
        named.clear();
        named.extend(pieces().flat_map(|(_, piece)| &piece.names));
        named.sort_unstable();
        walls.clear();
        corners.start(1 + pieces().map(|(_, piece)| piece.sites.len()).sum::<usize>());
        corners.index(point.vertex, || *point);
        corner_blocks.clear();
        for (worker, piece) in pieces() {
            places.clear();
            places.extend(piece.sites.iter().map(|site| corners.index(site.vertex, || *site)));
            let new = &corners.sites[corner_blocks.len()..];
            corner_blocks.extend(new.iter().map(|site| self.block_of_site(site)));
            for side in &piece.sides {
                let v = side.v.map(|k| places[k as usize]);
                let names = v.map(|k| corners.sites[k as usize].vertex);
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
                walls.push(Wall {
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
    fn name_walls(&mut self, walls: &mut [Wall]) {
        // Several faces of one ring tetrahedron may be among the walls: few have a new name.
        let mut ring: Vec<((WorkerId, TetId), Name)> = Vec::new();
        for k in 0..walls.len() {
            let (owner, worker) = (walls[k].owner, walls[k].worker);
            let beside =
                walls[k].beside[1..].iter().any(|&face| walls[tet_of(face).index()].owner != owner);
            if beside || worker != owner {
                walls[k].name = Some(self.fresh_name());
            }
            if let At::Tet(tet) = walls[k].at
                && worker != owner
                && walls[k].ring_name.is_none()
            {
                let place = place_of(&mut ring, (worker, tet), || self.fresh_name());
                walls[k].ring_name = Some(ring[place].1);
            }
        }
    }
}

/// The other side of face `slot` of the new tetrahedron of `wall`.
fn lead(walls: &[Wall], wall: &Wall, slot: usize) -> To {
    if slot == 0 {
        let name = wall.ring_name;
        return match (wall.at, name) {
            (At::Tet(tet), _) if wall.worker == wall.owner => To::Old(tet, wall.slot),
            (At::Named(name), _) | (At::Tet(_), Some(name)) => {
                To::Far(Handle { name, block: wall.ring_block, face: wall.slot })
            }
            (At::Tet(tet), None) => To::Old(tet, wall.slot),
        };
    }
    let (other, there) = (tet_of(wall.beside[slot]), slot_of(wall.beside[slot]) as u8);
    let other = &walls[other.index()];
    match handle_of(other, there) {
        Some(handle) if other.owner != wall.owner => To::Far(handle),
        _ => To::New(other.index, there),
    }
}

/// The place of `key` in a short list, where it is put with `value` if it is not there.
fn place_of<K: PartialEq, V>(list: &mut Vec<(K, V)>, key: K, value: impl FnOnce() -> V) -> usize {
    list.iter().position(|(k, _)| *k == key).unwrap_or_else(|| {
        list.push((key, value()));
        list.len() - 1
    })
}

/// The patch of a worker.
fn patch_of(patches: &mut Vec<(WorkerId, Patch)>, worker: WorkerId) -> &mut Patch {
    let place = place_of(patches, worker, Patch::default);
    &mut patches[place].1
}

/// The message of a defect of the protocol: the boundary of a cavity is a closed surface.
const OPEN_BOUNDARY: &str = "an edge of a cavity's boundary has no second face";

/// Finds the walls beside each other: two of them have an edge in common, which they pass in
/// opposite directions.
fn join(walls: &mut [Wall], edges: &mut EdgeTable) {
    edges.start(walls.len());
    let mut joined = 0;
    for k in 0..walls.len() {
        let [a, b, c] = walls[k].v;
        for (from, to, slot) in [(a, b, 3), (b, c, 1), (c, a, 2)] {
            let face = FaceId::new(TetId::at(k), slot);
            match edges.meet(from, to, face) {
                Met::Nothing => {}
                Met::Face(other) => {
                    walls[k].beside[slot] = other;
                    walls[tet_of(other).index()].beside[slot_of(other)] = face;
                    joined += 1;
                }
                Met::Defect => panic!("{OPEN_BOUNDARY}"),
            }
        }
    }
    assert!(2 * joined == 3 * walls.len(), "{OPEN_BOUNDARY}");
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pyramids over a ring of `n` corners, as seen from corner 0 inside.
    fn walls(n: u32) -> Vec<Wall> {
        let faces = (0..n).flat_map(|k| {
            let (a, b) = (3 + k, 3 + (k + 1) % n);
            [[1, a, b], [2, b, a]]
        });
        let wall = |v| Wall {
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
        faces.map(wall).collect()
    }

    /// A boundary with a hole is a defect of the protocol, not a mesh.
    #[test]
    fn an_open_boundary_is_refused() {
        for n in [3, 40, 61, 62, 200] {
            for hole in 0..2 * n as usize {
                let mut open = walls(n);
                open.remove(hole);
                let join = || join(&mut open, &mut EdgeTable::default());
                let panic = std::panic::catch_unwind(std::panic::AssertUnwindSafe(join));
                let text = crate::protocol::message_of(&*panic.expect_err("a hole"));
                assert_eq!(text, OPEN_BOUNDARY);
            }
        }
    }

    #[test]
    fn walls_meet_at_common_edges() {
        let mut edges = EdgeTable::default();
        // Large and small ones in turn: the table is used again.
        for n in [3, 61, 5, 62, 200, 4] {
            let mut walls = walls(n);
            join(&mut walls, &mut edges);
            for (k, wall) in (0..).map(TetId::new).zip(&walls) {
                for slot in 1..4 {
                    let (other, there) = (tet_of(wall.beside[slot]), slot_of(wall.beside[slot]));
                    let other = &walls[other.index()];
                    assert_eq!(other.beside[there], FaceId::new(k, slot));
                    // All corners but the one opposite are common.
                    let kept = |v: [u32; 3], out: usize| {
                        let mut v = v.to_vec();
                        v.remove(out - 1);
                        v.sort_unstable();
                        v
                    };
                    assert_eq!(kept(wall.v, slot), kept(other.v, there));
                }
            }
        }
    }
}
