//! Other cuts for submeshes at rest: a redeal. Nothing is locked or under way; each tetrahedron
//! that belongs to another worker then goes there, and nobody gathers them.
//!
//! A tetrahedron with a far neighbour has a name (P1), and so has one that gets such a neighbour
//! now, given by its owner of before. So two exchanges will do: in the first one, of words, all
//! learn to which blocks the tetrahedra beyond their interface faces go; in the second one, of
//! parcels, these go there, and find by name what is beside them. What belongs to vertices and
//! tetrahedra beside the mesh travels beside the parcels, in their order.

use super::apply::unknown;
use super::name::NOWHERE;
use super::{Blocks, Lead, LocalMesh, Place, WireVertex, block_of_tet};
use crate::protocol::{BlockId, Directory, Handle, Name, SubmeshError, WorkerId};
use ltbw_core::topology::{FaceId, INFINITE, TetId, VertexId, slot_of, tet_of};
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::ops::Range;

/// The word that beyond a face of the receiver's is a tetrahedron of another block from now on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Turned {
    /// The receiver's tetrahedron.
    name: Name,
    /// The face, by its slot.
    face: u8,
    /// The block of what is beyond.
    block: BlockId,
}

/// Tetrahedra that go from one worker to another.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Parcel {
    tets: Vec<Sent>,
    /// Their vertices, each once.
    vertices: Vec<WireVertex>,
}

/// A tetrahedron of a parcel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Sent {
    /// Its name, if it has one.
    name: Option<Name>,
    /// Its vertices, by their places among the parcel's.
    v: [u32; 4],
    /// Its neighbours: by their places in the parcel, or elsewhere.
    n: [Lead; 4],
}

/// A submesh's tetrahedra as they are dealt from now on.
#[derive(Debug)]
pub(crate) struct Dealt {
    /// By slot: the block of its tetrahedron.
    blocks: Vec<BlockId>,
    /// The tetrahedra that leave, by receiver.
    pub(crate) leaving: Vec<Leaving>,
    /// The words for the workers beside.
    pub(crate) words: Vec<(WorkerId, Vec<Turned>)>,
}

/// The tetrahedra that leave for one worker, ascending.
#[derive(Debug)]
pub(crate) struct Leaving {
    pub(crate) to: WorkerId,
    pub(crate) tets: Vec<TetId>,
}

/// The receiver of a tetrahedron, and its place in the parcel.
#[derive(Clone, Copy)]
struct Going {
    to: WorkerId,
    place: u32,
}

/// A face of a tetrahedron that stays, and the one that goes from beyond it.
struct Facing {
    face: FaceId,
    beyond: Handle,
}

/// A parcel on its way, with the numbers that its vertices have at the sender.
#[derive(Debug)]
pub(crate) struct Posted {
    pub(crate) to: WorkerId,
    pub(crate) parcel: Parcel,
    pub(crate) vertices: Vec<VertexId>,
}

/// The slots and numbers at the receiver of a parcel's tetrahedra and vertices, in its order.
#[derive(Debug)]
pub(crate) struct Unpacked {
    pub(crate) tets: Vec<TetId>,
    pub(crate) vertices: Vec<VertexId>,
}

/// The work of a redeal for one worker.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moved {
    /// Tetrahedra that it had.
    pub(crate) had: u64,
    /// Tetrahedra that have left, and that have come.
    pub(crate) left: u64,
    pub(crate) came: u64,
    /// Bytes that it has told all.
    pub(crate) told: u64,
    /// Messages and bytes to others, and from them.
    pub(crate) messages: u64,
    pub(crate) bytes: u64,
}

impl Moved {
    /// Counts a message between two workers, if they are two.
    pub(crate) fn count(&mut self, one: WorkerId, other: WorkerId, bytes: u64) {
        if one != other {
            self.messages += 1;
            self.bytes += bytes;
        }
    }
}

impl Parcel {
    /// The number of its tetrahedra.
    pub(crate) fn len(&self) -> usize {
        self.tets.len()
    }

    /// About the bytes that it has in a compact encoding.
    pub(crate) fn bytes(&self) -> u64 {
        let face = |lead: &Lead| match lead {
            Lead::In(..) => 3,
            Lead::Far(_) => 13,
        };
        let tet = |own: &Sent| own.n.iter().map(face).sum::<u64>() + 9 + 4 * 2;
        32 * self.vertices.len() as u64 + self.tets.iter().map(tet).sum::<u64>()
    }
}

impl LocalMesh {
    /// Cuts the curve anew: says which tetrahedra leave, and what the workers beside have to know.
    /// The own stretch of given vertices is `own` then; blocks keep their owners.
    pub(crate) fn recut(
        &mut self,
        cuts: &Blocks,
        directory: &Directory,
        own: Range<Place>,
    ) -> Dealt {
        let Self { tets, vertices, .. } = self;
        vertices.recut(cuts.clone(), |v| tets.point(v));
        self.blocks = cuts.clone();
        self.located.clear();
        // The rest of the own range; vertices that come are others.
        let Range { start, end } = self.vertices.numbers_of(own);
        self.tets.leave_range(VertexId::new(1)..start);
        self.tets.leave_range(end..VertexId::new(u32::MAX));
        let before = self.fixed.map(|fixed| fixed.block_of(self.me));
        let mut blocks = vec![BlockId::default(); self.tets.topology().slots()];
        let mut leaving: BTreeMap<WorkerId, Vec<TetId>> = BTreeMap::new();
        let mut words: BTreeMap<WorkerId, Vec<Turned>> = BTreeMap::new();
        for (t, v) in self.tets.tets() {
            let block = block_of_tet(&self.vertices, v);
            let owner = directory.owner(block);
            let block = self.fixed.map_or(block, |fixed| fixed.block_of(owner));
            blocks[t.index()] = block;
            if owner != self.me {
                leaving.entry(owner).or_default().push(t);
            }
            if before == Some(block) {
                continue;
            }
            for u in self.tets.neighbours(t).map(tet_of) {
                if let Some(Handle { name, block: there, face }) = self.tets.far(u) {
                    let to = directory.owner(there);
                    words.entry(to).or_default().push(Turned { name, face, block });
                }
            }
        }
        let leaving = leaving.into_iter().map(|(to, tets)| Leaving { to, tets }).collect();
        Dealt { blocks, leaving, words: words.into_iter().collect() }
    }

    /// Packs what leaves, and has it no more. `words` are all that others have for this worker.
    ///
    /// # Errors
    /// [`SubmeshError`] if a word makes no sense, or there is no room: the submesh has failed.
    pub(crate) fn send_off(
        &mut self,
        dealt: &Dealt,
        words: impl Iterator<Item = Turned>,
    ) -> Result<Vec<Posted>, SubmeshError> {
        for word in words {
            self.turn(word)?;
        }
        let mut places: FxHashMap<TetId, Going> = FxHashMap::default();
        for Leaving { to, tets } in &dealt.leaving {
            places.extend(tets.iter().zip(0..).map(|(&t, k)| (t, Going { to: *to, place: k })));
        }
        let mut posted = Vec::with_capacity(dealt.leaving.len());
        let mut far: Vec<Facing> = Vec::new();
        for own in &dealt.leaving {
            posted.push(self.pack(dealt, own, &places, &mut far));
        }
        // Nothing is removed unless there is room for what stands in its place.
        if !self.tets.has_room(far.len()) {
            return Err(self.no_room());
        }
        for Facing { face, beyond } in far {
            self.tets.link_far(face, beyond).ok_or(self.no_room())?;
        }
        for &t in dealt.leaving.iter().flat_map(|own| &own.tets) {
            self.remove(t);
        }
        self.error.map_or(Ok(posted), Err)
    }

    /// A word of what is beyond a face.
    fn turn(&mut self, Turned { name, face, block }: Turned) -> Result<(), SubmeshError> {
        let wrong = unknown("an interface face", name.number);
        let &t = self.names.get(&name).ok_or(wrong)?;
        if face > 3 || block.index() >= self.blocks.len() {
            return Err(wrong);
        }
        let own = FaceId::new(t, usize::from(face));
        let there = tet_of(self.tets.neighbours(t)[slot_of(own)]);
        let before = self.tets.far(there).ok_or(wrong)?;
        self.tets.link_far(own, Handle { block, ..before }).ok_or(self.no_room())
    }

    /// Packs what leaves for one worker. Tetrahedra that stay beside are to be linked to it: `far`.
    fn pack(
        &mut self,
        dealt: &Dealt,
        leaving: &Leaving,
        places: &FxHashMap<TetId, Going>,
        far: &mut Vec<Facing>,
    ) -> Posted {
        let mut numbers: FxHashMap<VertexId, u32> = FxHashMap::default();
        let (mut vertices, mut tets) = (Vec::new(), Vec::with_capacity(leaving.tets.len()));
        for &t in &leaving.tets {
            let v = self.tets.vertices(t).map(|v| {
                *numbers.entry(v).or_insert_with(|| {
                    vertices.push(v);
                    vertices.len() as u32 - 1
                })
            });
            let mut slot = 0;
            let n = self.tets.neighbours(t).map(|face| {
                let (u, there) = (tet_of(face), slot_of(face) as u8);
                let lead = match (self.tets.far(u), places.get(&u)) {
                    (Some(handle), _) => Lead::Far(handle),
                    (None, Some(&Going { to, place })) if to == leaving.to => {
                        Lead::In(place, there)
                    }
                    (None, elsewhere) => {
                        let name = self.ensure_name(t);
                        if elsewhere.is_none() {
                            let block = dealt.blocks[t.index()];
                            far.push(Facing { face, beyond: Handle { name, block, face: slot } });
                        }
                        let name = self.ensure_name(u);
                        Lead::Far(Handle { name, block: dealt.blocks[u.index()], face: there })
                    }
                };
                slot += 1;
                lead
            });
            tets.push(Sent { name: self.tets.tag_of(t), v, n });
        }
        let wire = vertices.iter().map(|&v| self.wire_vertex(v)).collect();
        Posted { to: leaving.to, parcel: Parcel { tets, vertices: wire }, vertices }
    }

    /// Takes in the parcels of all others.
    ///
    /// # Errors
    /// [`SubmeshError`] if one makes no sense, or there is no room: the submesh has failed.
    pub(crate) fn unpack(
        &mut self,
        parcels: &[&Parcel],
        directory: &Directory,
    ) -> Result<Vec<Unpacked>, SubmeshError> {
        let mut all = Vec::with_capacity(parcels.len());
        for parcel in parcels {
            self.check_parcel(parcel)?;
            let vertices: Vec<VertexId> =
                parcel.vertices.iter().map(|vertex| self.take_vertex(vertex)).collect();
            let mut tets = Vec::with_capacity(parcel.tets.len());
            for sent in &parcel.tets {
                let v = sent.v.map(|k| vertices[k as usize]);
                let t = self.tets.create(v).ok_or(self.no_room())?;
                if let Some(name) = sent.name {
                    self.set_name(t, name);
                }
                tets.push(t);
            }
            all.push(Unpacked { tets, vertices });
        }
        for (parcel, own) in parcels.iter().zip(&all) {
            for (sent, &t) in parcel.tets.iter().zip(&own.tets) {
                for (slot, lead) in sent.n.iter().enumerate() {
                    self.lead(FaceId::new(t, slot), *lead, &own.tets, directory)?;
                }
            }
        }
        for &t in all.iter().flat_map(|own| &own.tets) {
            self.tets.cache_sphere(t);
        }
        Ok(all)
    }

    /// Links a face of a tetrahedron that has come, one of `own`.
    fn lead(
        &mut self,
        face: FaceId,
        lead: Lead,
        own: &[TetId],
        directory: &Directory,
    ) -> Result<(), SubmeshError> {
        match lead {
            Lead::In(k, there) => {
                self.tets.link(face, FaceId::new(own[k as usize], usize::from(there)));
            }
            Lead::Far(handle) => match self.names.get(&handle.name) {
                Some(&u) => self.tets.link(face, FaceId::new(u, usize::from(handle.face))),
                None if directory.is_mine(handle.block) => {
                    return Err(unknown("a tetrahedron beyond a face", handle.name.number));
                }
                None => self.tets.link_far(face, handle).ok_or(self.no_room())?,
            },
        }
        Ok(())
    }

    /// Is there room for a parcel, and all that it names by a number?
    fn check_parcel(&self, parcel: &Parcel) -> Result<(), SubmeshError> {
        let Parcel { tets, vertices } = parcel;
        for vertex in vertices {
            self.check_vertex(vertex.name)?;
        }
        let is_finite = |&k: &u32| vertices.get(k as usize).is_some_and(|v| v.name != NOWHERE);
        let mut slots = tets.len();
        for Sent { v, n, .. } in tets {
            let last = v[3] as usize;
            if !v[..3].iter().all(is_finite) || last >= vertices.len() {
                return Err(unknown(
                    "a vertex",
                    v.iter().copied().max().unwrap_or(INFINITE.number()),
                ));
            }
            for lead in n {
                match *lead {
                    Lead::In(k, slot) if k as usize >= tets.len() || slot > 3 => {
                        return Err(unknown("a tetrahedron of the parcel", k));
                    }
                    Lead::In(..) => {}
                    Lead::Far(handle)
                        if handle.face > 3 || handle.block.index() >= self.blocks.len() =>
                    {
                        return Err(unknown("a far face", handle.name.number));
                    }
                    Lead::Far(_) => slots += 1,
                }
            }
        }
        if self.tets.has_room(slots) { Ok(()) } else { Err(self.no_room()) }
    }
}

#[cfg(test)]
mod tests;
