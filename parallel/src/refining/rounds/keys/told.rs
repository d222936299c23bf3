//! The news of the workers at the two sides of an interface face: ranks, and whether something
//! behind one comes before the one beyond.

use super::{Far, Interface, SharedKeys, keep};
use crate::protocol::{Directory, Name, Rules, Submesh, WorkerId};
use crate::refining::domain::DomainMesh;
use crate::refining::news::KeysTold;
use ltbw_core::topology::{TetId, tet_of};
use std::collections::BTreeMap;

/// The news for each worker at an interface face.
type Told = BTreeMap<WorkerId, KeysTold>;

impl SharedKeys {
    /// The ranks for others, an entry for each worker that has a tetrahedron beside one of this
    /// worker.
    pub(in super::super) fn ranks_told<C: Rules>(
        &mut self,
        mesh: &DomainMesh<'_>,
        directory: &Directory,
    ) -> Told {
        let (mut news, tets) = (BTreeMap::new(), mesh.inner.tets());
        for &block in self.blocks.keys() {
            let memory = || self.spare.pop().unwrap_or_default();
            news.entry(directory.owner(block)).or_insert_with(memory);
        }
        for place in &self.changed {
            // Of one that is new nobody has heard: that it has no rank need not be told.
            if let Some(Interface { t, beyond, .. }) = self.interface[*place as usize]
                && let Some(rank) = self.rank::<C>(mesh, t)
            {
                let told = news.entry(directory.owner(beyond.block)).or_default();
                told.push((beyond.name, beyond.face, Some(rank)));
            }
        }
        for (t, v) in std::mem::take(&mut self.withdrawn) {
            // R31.
            if !C::withdraws_ranks() || !mesh.has(t, v) {
                continue;
            }
            let places = tets.neighbours(t).map(|face| tets.far_place(tet_of(face)));
            for place in places.into_iter().flatten() {
                if let Some(Some(Interface { beyond, .. })) = self.interface.get(place as usize) {
                    let told = news.entry(directory.owner(beyond.block)).or_default();
                    told.push((beyond.name, beyond.face, None));
                }
            }
        }
        news.into_iter().map(|(to, ranks)| (to, KeysTold::Ranks(ranks))).collect()
    }

    /// The answers for others whether one behind an interface face comes first, with such entries.
    pub(in super::super) fn behind_told<C: Rules>(
        &mut self,
        mesh: &DomainMesh<'_>,
        directory: &Directory,
    ) -> Told {
        let owners = self.blocks.keys().map(|&block| (directory.owner(block), Vec::new()));
        let mut news: BTreeMap<_, Vec<_>> = owners.collect();
        let mut touched = std::mem::take(&mut self.touched);
        touched.iter().for_each(|t| self.is_touched.set(t.index(), false));
        let tets = mesh.inner.tets();
        for &t in &touched {
            let places = tets.neighbours(t).map(|face| tets.far_place(tet_of(face)));
            for place in places.into_iter().flatten().map(|place| place as usize) {
                // Within its bounds the one beyond is no candidate.
                let Some(beyond) = self.far.get(place).and_then(|far| far.rank.as_ref()) else {
                    continue;
                };
                // One that is gone has the links that it had, to slots of others now.
                let Some(own) = self.interface[place].filter(|own| own.t == t) else { continue };
                let beats = self.beats::<C>(mesh, &own, beyond);
                if std::mem::replace(&mut self.far[place].told, beats) != beats {
                    let told = news.entry(directory.owner(own.beyond.block)).or_default();
                    told.push((own.beyond.name, own.beyond.face, beats));
                }
            }
        }
        touched.clear();
        self.touched = touched;
        debug_assert!(self.has_told_all::<C>(mesh));
        news.into_iter().map(|(to, behind)| (to, KeysTold::Behind(behind))).collect()
    }

    /// Do all others know what is behind the interface faces?
    fn has_told_all<C: Rules>(&self, mesh: &DomainMesh<'_>) -> bool {
        self.interface.iter().zip(&self.far).all(|(own, far)| match (own, &far.rank) {
            (Some(own), Some(beyond)) => far.told == self.beats::<C>(mesh, own, beyond),
            _ => true,
        })
    }

    /// The far face at a face of a tetrahedron here, and that tetrahedron.
    fn far_face(
        &mut self,
        mesh: &DomainMesh<'_>,
        name: Name,
        face: u8,
    ) -> Option<(TetId, &mut Far)> {
        let (t, tets) = (mesh.resolve(name)?, mesh.inner.tets());
        let there = tet_of(*tets.neighbours(t).get(usize::from(face))?);
        Some((t, self.far.get_mut(tets.far_place(there)? as usize)?))
    }

    /// Takes what another worker tells.
    pub(in super::super) fn hear(&mut self, mesh: &DomainMesh<'_>, keys: KeysTold) {
        match keys {
            KeysTold::Ranks(mut ranks) => {
                for (name, face, rank) in ranks.drain(..) {
                    let Some((t, far)) = self.far_face(mesh, name, face) else { continue };
                    far.rank = rank;
                    self.touch(t);
                }
                keep(&mut self.spare, ranks);
            }
            KeysTold::Behind(behind) => {
                for (name, face, is_beaten) in behind {
                    let Some((_, far)) = self.far_face(mesh, name, face) else { continue };
                    far.is_beaten = is_beaten;
                }
            }
        }
    }
}
