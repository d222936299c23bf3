//! The home's retriangulation: the star of the point over the cavity's boundary, as one patch for
//! every worker that loses, gets or links a tetrahedron.

use super::wire::Link;
use super::{At, LocalMesh, NewTet, Patch, Piece, Relink, Site, To};
use crate::protocol::{BlockId, Directory, Handle, Name, WorkerId};
use ltbw_core::cavity::OTHERS;
use ltbw_core::topology::{TetId, VertexId};
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;

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
        let mut patches: BTreeMap<WorkerId, Patch> = BTreeMap::new();
        for (worker, pieces) in parts {
            if !pieces.is_empty() {
                let removed = pieces.iter().map(|piece| piece.tet);
                patches.entry(*worker).or_default().remove.extend(removed);
            }
        }
        let mut walls = self.walls(point, parts, whereabouts, directory);
        let mut counts: BTreeMap<WorkerId, u32> = BTreeMap::new();
        for wall in &mut walls {
            let count = counts.entry(wall.owner).or_default();
            wall.index = *count;
            *count += 1;
        }
        join(&mut walls);
        self.name_walls(&mut walls);
        for wall in &walls {
            let n = [0, 1, 2, 3].map(|slot| lead(&walls, wall, slot));
            let new = NewTet { name: wall.name, v: wall.v, n };
            patches.entry(wall.owner).or_default().create.push(new);
            if wall.worker != wall.owner
                && let Some(to) = handle_of(wall, 0)
            {
                let relink = Relink { at: wall.at, slot: wall.slot, name: wall.ring_name, to };
                patches.entry(wall.worker).or_default().relink.push(relink);
            }
        }
        patches.into_iter().collect()
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
        let inside: FxHashSet<(WorkerId, TetId)> = pieces().map(|(w, p)| (w, p.tet)).collect();
        let named: FxHashSet<Name> = pieces().filter_map(|(_, p)| p.name).collect();
        let mut walls = Vec::new();
        for (worker, piece) in pieces() {
            for (slot, link) in piece.n.iter().enumerate() {
                let (worker, at, slot_there, ring_block, ring_name) = match *link {
                    Link::Near { tet, .. } if inside.contains(&(worker, tet)) => continue,
                    Link::Far(handle) if named.contains(&handle.name) => continue,
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
        let owners: Vec<WorkerId> = walls.iter().map(|wall| wall.owner).collect();
        let mut ring: FxHashMap<(WorkerId, TetId), Name> = FxHashMap::default();
        for wall in walls {
            let beside = wall.beside[1..].iter().any(|&(k, _)| owners[k] != wall.owner);
            if beside || wall.worker != wall.owner {
                wall.name = Some(self.fresh_name());
            }
            if let At::Tet(tet) = wall.at
                && wall.worker != wall.owner
                && wall.ring_name.is_none()
            {
                let name = *ring.entry((wall.worker, tet)).or_insert_with(|| self.fresh_name());
                wall.ring_name = Some(name);
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

/// Finds the walls beside each other: every edge of the boundary is passed once in each direction.
fn join(walls: &mut [Wall]) {
    let mut edges: FxHashMap<(VertexId, VertexId), (usize, u8)> = FxHashMap::default();
    edges.reserve(3 * walls.len());
    let around = |v: &[Site; 4]| {
        let [_, a, b, c] = v.map(|site| site.vertex);
        [(a, b, 3), (b, c, 1), (c, a, 2)]
    };
    for (k, wall) in walls.iter().enumerate() {
        for (from, to, slot) in around(&wall.v) {
            edges.insert((from, to), (k, slot));
        }
    }
    for wall in walls {
        for (from, to, slot) in around(&wall.v) {
            // A closed surface has the opposite edge, too.
            if let Some(&beside) = edges.get(&(to, from)) {
                wall.beside[slot as usize] = beside;
            }
        }
    }
}
