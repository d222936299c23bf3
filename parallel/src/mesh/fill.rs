//! The home's retriangulation: the star of the point over the cavity's boundary, as one patch for
//! every worker that loses, gets or links a tetrahedron.

use super::wire::Link;
use super::{At, LocalMesh, NewTet, Patch, Piece, Relink, Site, To};
use crate::protocol::{BlockId, Directory, Handle, Name, WorkerId};
use ltbw_core::cavity::OTHERS;
use ltbw_core::topology::TetId;

/// A face of the cavity's boundary, and the new tetrahedron on it.
#[derive(Debug)]
struct Wall {
    /// The face, as indices of the cavity's corners.
    v: [u32; 3],
    /// The new tetrahedron's block.
    block: BlockId,
    /// Its owner, and its index among that owner's new ones.
    owner: WorkerId,
    index: u32,
    name: Option<Name>,
    /// Neighbours by slot, other walls: wall and slot there. Entry 0 is not used.
    beside: [(u32, u8); 4],
    /// The ring tetrahedron behind the face: who has it, where, the slot, its block and name.
    worker: WorkerId,
    at: At,
    slot: u8,
    ring_block: BlockId,
    ring_name: Option<Name>,
}

/// What is used while a cavity is filled, kept for the next one.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    corners: Corners,
    walls: Vec<Wall>,
    /// Names of the cavity's tetrahedra, ascending.
    named: Vec<Name>,
    edges: Edges,
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
        let mut scratch = std::mem::take(&mut self.scratch);
        self.find_walls(&mut scratch, point, parts, whereabouts, directory);
        let Scratch { corners, walls, edges, .. } = &mut scratch;
        let mut counts: Vec<(WorkerId, u32)> = Vec::with_capacity(parts.len() + 1);
        for wall in &mut *walls {
            let place = place_of(&mut counts, wall.owner, || 0);
            wall.index = counts[place].1;
            counts[place].1 += 1;
        }
        edges.join(walls);
        self.name_walls(walls);
        // By worker; few have a part.
        let mut patches: Vec<(WorkerId, Patch)> = Vec::with_capacity(parts.len() + 1);
        for (owner, count) in counts {
            let create = Vec::with_capacity(count as usize);
            let sites = corners.sites.clone();
            patches.push((owner, Patch { sites, create, ..Patch::default() }));
        }
        for (worker, pieces) in parts.iter().filter(|(_, pieces)| !pieces.is_empty()) {
            let patch = patch_of(&mut patches, *worker);
            patch.remove.extend(pieces.iter().map(|piece| piece.tet));
        }
        for wall in &*walls {
            let n = [0, 1, 2, 3].map(|slot| lead(walls, wall, slot));
            let [a, b, c] = wall.v;
            let new = NewTet { name: wall.name, v: [0, a, b, c], block: wall.block, n };
            patch_of(&mut patches, wall.owner).create.push(new);
            if wall.worker != wall.owner
                && let Some(to) = handle_of(wall, 0)
            {
                let relink = Relink { at: wall.at, slot: wall.slot, name: wall.ring_name, to };
                patch_of(&mut patches, wall.worker).relink.push(relink);
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
        point: &Site,
        parts: &[(WorkerId, Vec<Piece>)],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) {
        let Scratch { corners, walls, named, .. } = scratch;
        let pieces = || parts.iter().flat_map(|(w, list)| list.iter().map(move |p| (*w, p)));
        named.clear();
        named.extend(pieces().filter_map(|(_, p)| p.name));
        named.sort_unstable();
        walls.clear();
        corners.start(point, parts.iter().map(|(_, list)| list.len()).sum());
        for (worker, piece) in pieces() {
            let v = piece.v.each_ref().map(|site| corners.index(site));
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
                let [a, b, c] = OTHERS[slot];
                let face = [a, b, c].map(|k| piece.v[k].vertex);
                let block = self.block_with([point.vertex, face[0], face[1], face[2]]);
                walls.push(Wall {
                    v: [a, b, c].map(|k| v[k]),
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
    }

    /// Names what another worker must know: new tetrahedra beside those of others, and ring
    /// tetrahedra behind those of others.
    fn name_walls(&mut self, walls: &mut [Wall]) {
        // Several faces of one ring tetrahedron may be among the walls: few have a new name.
        let mut ring: Vec<((WorkerId, TetId), Name)> = Vec::new();
        for k in 0..walls.len() {
            let (owner, worker) = (walls[k].owner, walls[k].worker);
            let beside =
                walls[k].beside[1..].iter().any(|&(other, _)| walls[other as usize].owner != owner);
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
    let other = &walls[other as usize];
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

/// The corners of a cavity, the point among them, each once.
#[derive(Debug, Default)]
struct Corners {
    /// The point, then the others.
    sites: Vec<Site>,
    /// By vertex, with open addressing: 1 + index, or 0.
    table: Vec<u32>,
}

impl Corners {
    /// Forgets all; a cavity of `pieces` tetrahedra is to come, around `point`.
    fn start(&mut self, point: &Site, pieces: usize) {
        self.sites.clear();
        self.sites.push(*point);
        self.table.clear();
        // At most half full, even if all tetrahedra were apart: every search meets an empty place.
        self.table.resize((8 * pieces).next_power_of_two(), 0);
    }

    /// The index of a corner.
    fn index(&mut self, site: &Site) -> u32 {
        let last = self.table.len() - 1;
        let mut place = (site.vertex.wrapping_mul(0x9e37_79b9) >> 12) as usize & last;
        loop {
            match self.table[place] {
                0 => {
                    self.sites.push(*site);
                    self.table[place] = self.sites.len() as u32;
                    return self.table[place] - 1;
                }
                k if self.sites[k as usize - 1].vertex == site.vertex => return k - 1,
                _ => place = (place + 1) & last,
            }
        }
    }
}

/// Edges of the boundary: a table with open addressing, kept for the next cavity.
#[derive(Debug, Default)]
struct Edges {
    /// Both corners in one word; `u64::MAX` where the table is empty.
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
            let [a, b, c] = walls[k].v;
            for (from, to, slot) in [(a, b, 3), (b, c, 1), (c, a, 2)] {
                let place = self.place(from, to);
                let (other, there) = self.sides[place];
                if self.keys[place] == u64::MAX {
                    self.keys[place] = key_of(from, to);
                    self.sides[place] = (k as u32, slot);
                } else {
                    walls[k].beside[slot as usize] = (other, there);
                    walls[other as usize].beside[there as usize] = (k as u32, slot);
                }
            }
        }
    }

    /// Where an edge is, or would be.
    fn place(&self, from: u32, to: u32) -> usize {
        let (key, last) = (key_of(from, to), self.keys.len() - 1);
        let mut place = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & last;
        while self.keys[place] != key && self.keys[place] != u64::MAX {
            place = (place + 1) & last;
        }
        place
    }
}

fn key_of(a: u32, b: u32) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}
