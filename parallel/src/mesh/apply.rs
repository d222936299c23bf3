//! Patches and moves: what changes a submesh from outside.

use super::name::{NOWHERE, count_of, given};
use super::{At, Lead, LocalMesh, Moving, Patch, Relink, Tets, To, VertexName, WireVertex};
use crate::protocol::{BlockId, Directory, Handle, Name, SubmeshError, invariant};
use ltbw_core::submesh::StarTet;
use ltbw_core::topology::{FaceId, INFINITE, TetId, VertexId, slot_of, tet_of};
use rustc_hash::FxHashMap;

pub(super) fn unknown(what: &'static str, number: u32) -> SubmeshError {
    SubmeshError::Unknown { what, number }
}

/// A tetrahedron to be made, which is not linked yet.
struct Unlinked {
    name: Name,
    v: [VertexId; 4],
}

/// Is it the slot of a vertex in a tetrahedron?
fn check_slot(slot: u8) -> Result<(), SubmeshError> {
    if slot < 4 { Ok(()) } else { Err(unknown("a face by slot", u32::from(slot))) }
}

/// A face, by a slot that has been checked.
fn face_of(t: TetId, slot: u8) -> FaceId {
    FaceId::new(t, usize::from(slot))
}

impl LocalMesh {
    /// Applies a patch, no tetrahedron of which is locked. `relinks` is false for a known-bad
    /// variant only.
    ///
    /// Where there is no room for all of it, or a number in it is none of this submesh, nothing
    /// changes and the submesh has failed.
    pub(super) fn apply_patch(
        &mut self,
        patch: Patch,
        directory: &Directory,
        relinks: bool,
        made: &mut Vec<Name>,
        strays: &mut Vec<BlockId>,
    ) {
        if let Err(error) = self.check_patch(&patch) {
            self.error = Some(error);
            return;
        }
        for &t in &patch.remove {
            self.remove(t);
        }
        let mut tets = std::mem::take(&mut self.star);
        let mut rim = std::mem::take(&mut self.rim);
        rim.clear();
        rim.extend(patch.vertices.iter().map(|vertex| self.take_vertex(vertex)));
        let within = |to: To| match to {
            To::New(k, slot) => Some(face_of(TetId::new(k), slot)),
            _ => None,
        };
        let star = patch.create.iter().map(|new| StarTet {
            border: [new.v[1], new.v[2], new.v[3]],
            links: new.n.map(within),
        });
        tets.clear();
        let is_full =
            !patch.create.is_empty() && self.tets.create_star(&rim, star, &mut tets).is_none();
        self.rim = rim;
        if is_full {
            self.fail_for_room();
            return;
        }
        for (&t, new) in tets.iter().zip(&patch.create) {
            if let Some(name) = new.name {
                self.set_name(t, name);
            }
            for (slot, to) in new.n.iter().enumerate() {
                let face = FaceId::new(t, slot);
                match *to {
                    To::New(..) => {}
                    To::Old(u, there) => self.tets.link_new(face, face_of(u, there)),
                    To::Far(handle) => self.link_new_far(face, handle),
                }
            }
        }
        if relinks {
            for relink in &patch.relink {
                self.relink(relink);
                // Somebody may have asked for it by this name before it had it.
                made.extend(relink.name);
            }
        }
        for (&t, new) in tets.iter().zip(&patch.create) {
            made.extend(new.name);
            if !directory.is_mine(new.block) {
                self.strays.entry(new.block).or_default().push(t);
                strays.push(new.block);
            }
        }
        self.star = tets;
    }

    /// Is there room for a patch, and all that it names by a number? Another worker has made it.
    fn check_patch(&self, patch: &Patch) -> Result<(), SubmeshError> {
        let Patch { remove, vertices, create, relink } = patch;
        // The slots that it takes: for its tetrahedra, and for a far face at each face that may
        // lead to another worker's.
        let mut slots = create.len() + relink.len();
        for &t in remove {
            self.check_open(t)?;
        }
        // The place of the vertex at infinity, which is only ever the last of a tetrahedron.
        let mut infinite = None;
        for (place, vertex) in (0..).zip(vertices) {
            self.check_vertex(vertex.name)?;
            if vertex.name == NOWHERE && infinite.replace(place).is_some() {
                return Err(unknown("a vertex given once", INFINITE.number()));
            }
        }
        let infinite = infinite.unwrap_or(u32::MAX);
        for new in create {
            let [a, b, c, d] = new.v;
            let last = a.max(b).max(c).max(d);
            if last as usize >= vertices.len() || a == infinite || b == infinite || c == infinite {
                return Err(unknown("a vertex", last));
            }
            for to in &new.n {
                match *to {
                    To::New(k, slot) if k as usize >= create.len() || slot > 3 => {
                        return Err(unknown("a new tetrahedron", k));
                    }
                    To::New(..) => {}
                    To::Old(t, slot) => self.check_open(t).and(check_slot(slot))?,
                    To::Far(handle) => {
                        check_slot(handle.face)?;
                        slots += 1;
                    }
                }
            }
        }
        for relink in relink {
            if let At::Tet(t) = relink.at {
                self.check_open(t)?;
            }
            check_slot(relink.slot).and(check_slot(relink.to.face))?;
        }
        let slots = slots.saturating_sub(remove.len());
        if self.tets.has_room(slots) { Ok(()) } else { Err(self.no_room()) }
    }

    /// Is there room for tetrahedra that come, and all that they name by a number?
    fn check_cargo(&self, cargo: &[Moving]) -> Result<(), SubmeshError> {
        let mut slots = cargo.len();
        for moving in cargo {
            for vertex in &moving.v {
                self.check_vertex(vertex.name)?;
            }
            if moving.v[..3].iter().any(|vertex| vertex.name == NOWHERE) {
                return Err(unknown("a finite vertex", INFINITE.number()));
            }
            for lead in &moving.n {
                match *lead {
                    Lead::In(k, slot) if k as usize >= cargo.len() || slot > 3 => {
                        return Err(unknown("a tetrahedron of the block", k));
                    }
                    Lead::In(..) => {}
                    Lead::Far(handle) => {
                        check_slot(handle.face)?;
                        slots += 1;
                    }
                }
            }
        }
        if self.tets.has_room(slots) { Ok(()) } else { Err(self.no_room()) }
    }

    /// Is `t` a tetrahedron here, and unlocked?
    fn check_open(&self, t: TetId) -> Result<(), SubmeshError> {
        let open = self.tets.is_live(t) && self.tets.holder(t).is_none();
        if open { Ok(()) } else { Err(unknown("an unlocked tetrahedron", t.number())) }
    }

    /// Is it the name of a vertex, as far as that can be told: is a given one among those given?
    pub(super) fn check_vertex(&self, name: VertexName) -> Result<(), SubmeshError> {
        let known = given(name).is_none_or(|place| place < self.blocks.end());
        if known { Ok(()) } else { Err(unknown("a vertex", count_of(name))) }
    }

    /// The number here of a vertex, a new one if it has none.
    #[inline]
    pub(super) fn take_vertex(&mut self, vertex: &WireVertex) -> VertexId {
        self.vertices.number(vertex.name).unwrap_or_else(|| self.add_vertex(vertex))
    }

    fn add_vertex(&mut self, vertex: &WireVertex) -> VertexId {
        self.add_vertex_in(vertex, self.blocks.of_name(vertex.name, &vertex.point()))
    }

    /// The number here of a vertex of `block`, a new one if it has none.
    pub(super) fn add_vertex_in(&mut self, vertex: &WireVertex, block: BlockId) -> VertexId {
        let p = vertex.point();
        let v = self.vertices.add(vertex.name, block);
        self.tets.make_vertices(v);
        self.tets.set_point(v, p);
        if given(vertex.name).is_none() {
            self.tets.refine_step(&p);
        }
        v
    }

    /// Makes new tetrahedra, which are not linked yet; `None` at the limit of tetrahedra.
    fn create_all(&mut self, new: impl ExactSizeIterator<Item = Unlinked>) -> Option<Vec<TetId>> {
        let mut tets = Vec::with_capacity(new.len());
        for Unlinked { name, v } in new {
            let Some(t) = self.tets.create(v) else {
                self.fail_for_room();
                return None;
            };
            self.set_name(t, name);
            tets.push(t);
        }
        Some(tets)
    }

    /// Links `face` to the tetrahedron of `handle`: here if it is here, else by a far face.
    fn link_handle(&mut self, face: FaceId, handle: Handle) {
        match self.names.get(&handle.name) {
            Some(&u) => {
                self.tets.link(face, face_of(u, handle.face));
            }
            None => self.put(|tets| tets.link_far(face, handle)),
        }
    }

    /// Links a face of a new tetrahedron, at which nothing stands, to the one of `handle`.
    fn link_new_far(&mut self, face: FaceId, handle: Handle) {
        match self.names.get(&handle.name) {
            Some(&u) => self.tets.link_new(face, face_of(u, handle.face)),
            None => self.put(|tets| tets.put_far(face, handle)),
        }
    }

    /// Puts a far face somewhere, for which there is room.
    fn put(&mut self, far_face: impl FnOnce(&mut Tets) -> Option<()>) {
        if far_face(&mut self.tets).is_none() {
            self.fail_for_room();
        }
    }

    fn relink(&mut self, relink: &Relink) {
        let t = match relink.at {
            At::Tet(t) => t,
            At::Named(name) => match self.names.get(&name) {
                Some(&t) => t,
                None => invariant!(P6, "ring tetrahedron {name:?} of a patch is not here"),
            },
        };
        if let Some(name) = relink.name
            && !self.names.contains_key(&name)
        {
            self.set_name(t, name);
        }
        self.link_handle(face_of(t, relink.slot), relink.to);
    }

    /// Removes the tetrahedra of a block: all of them, or those made after it had moved. `leaves`
    /// is false for a known-bad variant only. `each` is told them before, in their order.
    pub(crate) fn extract_block(
        &mut self,
        block: BlockId,
        leaves: bool,
        moved: &mut dyn FnMut(TetId, Handle),
        each: impl FnMut(TetId),
    ) -> Vec<Moving> {
        let tets = self.strays.remove(&block).unwrap_or_else(|| {
            // From now on an insertion beside the block may make tetrahedra that belong to it.
            if leaves {
                let numbers = self.vertices.numbers_of(self.blocks.vertices(block));
                self.tets.leave_range(numbers);
            }
            let all = self.tets.tets().filter(|&(_, v)| self.block_with(v) == block);
            all.map(|(t, _)| t).collect()
        });
        tets.iter().copied().for_each(each);
        let index: FxHashMap<TetId, u32> = tets.iter().copied().zip(0..).collect();
        let mut cargo = Vec::with_capacity(tets.len());
        let mut far: Vec<(FaceId, Handle)> = Vec::new();
        for &t in &tets {
            let name = self.ensure_name(t);
            let mut slot = 0;
            let n = self.tets.neighbours(t).map(|face| {
                let (u, there) = (tet_of(face), slot_of(face) as u8);
                let lead = match (self.tets.far(u), index.get(&u)) {
                    (Some(handle), _) => Lead::Far(handle),
                    (None, Some(&k)) => Lead::In(k, there),
                    (None, None) => {
                        let here = Handle { name, block, face: slot };
                        far.push((face, here));
                        moved(t, here);
                        let name = self.ensure_name(u);
                        Lead::Far(Handle { name, block: self.block_of(u), face: there })
                    }
                };
                slot += 1;
                lead
            });
            cargo.push(Moving { name, v: self.wire_vertices(t), n });
        }
        // Nothing is removed unless there is room for what stands in its place.
        if !self.tets.has_room(far.len()) {
            self.fail_for_room();
            return Vec::new();
        }
        for (face, handle) in far {
            self.put(|tets| tets.link_far(face, handle));
        }
        for &t in &tets {
            self.remove(t);
        }
        cargo
    }

    /// Installs tetrahedra that come from another worker. Where there is no room for all of them,
    /// or a number is none of this submesh, nothing changes and the submesh has failed.
    pub(super) fn adopt_all(&mut self, cargo: Vec<Moving>, made: &mut Vec<Name>) {
        if let Err(error) = self.check_cargo(&cargo) {
            self.error = Some(error);
            return;
        }
        let mut new = Vec::with_capacity(cargo.len());
        for moving in &cargo {
            let v = [0, 1, 2, 3].map(|k| self.take_vertex(&moving.v[k]));
            new.push(Unlinked { name: moving.name, v });
        }
        let Some(tets) = self.create_all(new.into_iter()) else { return };
        for (&t, moving) in tets.iter().zip(&cargo) {
            for (slot, lead) in moving.n.iter().enumerate() {
                let face = FaceId::new(t, slot);
                match *lead {
                    Lead::In(k, there) => {
                        self.tets.link(face, face_of(tets[k as usize], there));
                    }
                    Lead::Far(handle) => self.link_handle(face, handle),
                }
            }
            made.push(moving.name);
        }
        for &t in &tets {
            self.tets.cache_sphere(t);
        }
        self.star = tets;
    }
}
