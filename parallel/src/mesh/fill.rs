//! The home's retriangulation: the star of the point over the cavity's boundary, as one patch for
//! every worker that loses, gets or links a tetrahedron.

use super::wire::Link;
use super::{At, LocalMesh, NewTet, Patch, Piece, Relink, Site, To};
use crate::protocol::{BlockId, Directory, Handle, Name, WorkerId};
use ltbw_core::cavity::OTHERS;
use ltbw_core::topology::{TetId, VertexId};

/// A face of the cavity's boundary, and the new tetrahedron on it.
struct Wall {
    /// The new tetrahedron: the point, then the face.
    v: [Site; 4],
    block: BlockId,
    /// Its owner, and its index among that owner's new ones.
    owner: WorkerId,
    index: u32,
    name: Option<Name>,
    /// Neighbours by slot, other walls: wall and slot there. Entry 0 is not used.
    beside: [(usize, u8); 4],
    /// The ring tetrahedron behind the face: who has it, where, the slot, its block and name.
    worker: WorkerId,
    at: At,
    slot: u8,
    ring_block: BlockId,
    ring_name: Option<Name>,
}

/// The handle of wall `wall`'s new tetrahedron at `slot`.
fn handle_of(wall: &Wall, slot: u8) -> Option<Handle> {
    wall.name.map(|name| Handle { name, block: wall.block, face: slot })
}

impl LocalMesh {
    pub(super) fn fill_cavity(
        &mut self,
        point: &Site,
        parts: &[(WorkerId, Vec<Piece>)],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) -> Vec<(WorkerId, Patch)> {
        let mut walls = self.walls(point, parts, whereabouts, directory);
        // By worker; few have a part.
        let mut patches: Vec<(WorkerId, Patch)> = Vec::with_capacity(parts.len());
        for (worker, pieces) in parts.iter().filter(|(_, pieces)| !pieces.is_empty()) {
            let patch = patch_of(&mut patches, *worker, walls.len());
            patch.remove.extend(pieces.iter().map(|piece| piece.tet));
        }
        let mut counts: Vec<(WorkerId, u32)> = Vec::with_capacity(parts.len());
        for wall in &mut walls {
            let place = place_of(&mut counts, wall.owner, || 0);
            wall.index = counts[place].1;
            counts[place].1 += 1;
        }
        self.edges.join(&mut walls);
        self.name_walls(&mut walls);
        for wall in &walls {
            let n = [0, 1, 2, 3].map(|slot| lead(&walls, wall, slot));
            let new = NewTet { name: wall.name, v: wall.v, n };
            patch_of(&mut patches, wall.owner, walls.len()).create.push(new);
            if wall.worker != wall.owner
                && let Some(to) = handle_of(wall, 0)
            {
                let relink = Relink { at: wall.at, slot: wall.slot, name: wall.ring_name, to };
                patch_of(&mut patches, wall.worker, walls.len()).relink.push(relink);
            }
        }
        patches.sort_unstable_by_key(|&(worker, _)| worker);
        patches
    }

    /// The boundary of the cavity.
    fn walls(
        &self,
        point: &Site,
        parts: &[(WorkerId, Vec<Piece>)],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) -> Vec<Wall> {
        let pieces = || parts.iter().flat_map(|(w, list)| list.iter().map(move |p| (*w, p)));
        let mut named: Vec<Name> = pieces().filter_map(|(_, p)| p.name).collect();
        named.sort_unstable();
        let links = || pieces().flat_map(|(_, p)| &p.n);
        let mut walls = Vec::with_capacity(links().filter(|&l| *l != Link::Inside).count());
        for (worker, piece) in pieces() {
            for (slot, link) in piece.n.iter().enumerate() {
                let (worker, at, slot_there, ring_block, ring_name) = match *link {
                    Link::Inside => continue,
                    Link::Far(handle) if named.binary_search(&handle.name).is_ok() => continue,
                    Link::Near { tet, slot, block, name } => {
                        (worker, At::Tet(tet), slot, block, name)
                    }
                    Link::Far(Handle { name, block, face }) => {
                        let worker = whereabouts(name).unwrap_or_else(|| directory.owner(block));
                        (worker, At::Named(name), face, block, Some(name))
                    }
                };
                let [a, b, c] = OTHERS[slot].map(|k| piece.v[k]);
                let v = [*point, a, b, c];
                let block = self.blocks.of_tet(v.map(|site| site.vertex));
                walls.push(Wall {
                    v,
                    block,
                    owner: directory.owner(block),
                    index: 0,
                    name: None,
                    beside: [(0, 0); 4],
                    worker,
                    at,
                    slot: slot_there,
                    ring_block,
                    ring_name,
                });
            }
        }
        walls
    }

    /// Names what another worker must know: new tetrahedra beside those of others, and ring
    /// tetrahedra behind those of others.
    fn name_walls(&mut self, walls: &mut [Wall]) {
        // Several faces of one ring tetrahedron may be among the walls: few have a new name.
        let mut ring: Vec<((WorkerId, TetId), Name)> = Vec::new();
        for k in 0..walls.len() {
            let (owner, worker) = (walls[k].owner, walls[k].worker);
            let beside = walls[k].beside[1..].iter().any(|&(other, _)| walls[other].owner != owner);
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

/// Where face `slot` of the new tetrahedron of `wall` leads.
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
    let (other, there) = wall.beside[slot];
    let other = &walls[other];
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

/// The patch of a worker, with room for `create` new tetrahedra.
fn patch_of(patches: &mut Vec<(WorkerId, Patch)>, worker: WorkerId, create: usize) -> &mut Patch {
    let empty = || Patch { create: Vec::with_capacity(create), ..Patch::default() };
    let place = place_of(patches, worker, empty);
    &mut patches[place].1
}

/// Edges of the boundary: a table with open addressing, kept for the next cavity.
#[derive(Debug, Default)]
pub(super) struct Edges {
    /// Both vertices in one word; `u64::MAX` where the table is empty.
    keys: Vec<u64>,
    /// Wall and slot.
    sides: Vec<(u32, u8)>,
}

impl Edges {
    /// Finds the walls beside each other: two of them have an edge in common.
    fn join(&mut self, walls: &mut [Wall]) {
        // At most half full: every search meets an empty place.
        let size = (4 * walls.len()).next_power_of_two();
        self.keys.clear();
        self.keys.resize(size, u64::MAX);
        self.sides.resize(self.sides.len().max(size), (0, 0));
        for k in 0..walls.len() {
            let [_, a, b, c] = walls[k].v.map(|site| site.vertex);
            for (from, to, slot) in [(a, b, 3), (b, c, 1), (c, a, 2)] {
                let place = self.place(from, to);
                let (other, there) = self.sides[place];
                if self.keys[place] == u64::MAX {
                    self.keys[place] = key_of(from, to);
                    self.sides[place] = (k as u32, slot);
                } else {
                    walls[k].beside[slot as usize] = (other as usize, there);
                    walls[other as usize].beside[there as usize] = (k, slot);
                }
            }
        }
    }

    /// Where an edge is, or would be.
    fn place(&self, from: VertexId, to: VertexId) -> usize {
        let (key, last) = (key_of(from, to), self.keys.len() - 1);
        let mut place = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & last;
        while self.keys[place] != key && self.keys[place] != u64::MAX {
            place = (place + 1) & last;
        }
        place
    }
}

fn key_of(a: VertexId, b: VertexId) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}
