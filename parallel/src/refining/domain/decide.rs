//! The home's verdict on a point whose closure is locked, and the patches that follow.

use super::closure::{Located, LockedClosure, LockedRuling};
use super::mesh::DomainMesh;
use super::regions::regions;
use super::values::{
    Asked, BoundVertex, DomainPatch, DomainPiece, DomainPoint, End, Regions, subface_key,
};
use crate::mesh::Patch;
use crate::protocol::{Directory, Name, Part, Submesh, WorkerId};
use ltbw_refine::Carrier;
use smallvec::{SmallVec, smallvec};

impl DomainMesh<'_> {
    /// The patches of a cavity that is filled.
    fn filled(
        &mut self,
        point: &DomainPoint,
        parts: &[Part<DomainPiece>],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) -> Vec<(WorkerId, DomainPatch)> {
        let patches = self.inner.fill_cavity(&point.vertex, parts, whereabouts, directory);
        let found = regions(parts);
        let pieces = parts.iter().flat_map(|(_, pieces)| pieces);
        let mut bound: Vec<BoundVertex> = pieces.flat_map(|own| &own.bound).copied().collect();
        if point.carrier != Carrier::Free {
            bound.push((point.vertex.name, point.carrier));
        }
        bound.sort_unstable_by_key(|&(name, _)| name);
        bound.dedup_by_key(|&mut (name, _)| name);
        let complete = |patch: Patch| {
            let mut regions: Regions = match &found {
                Ok(region) => smallvec![*region],
                Err(faces) => {
                    let name = |k: u32| patch.vertices[k as usize].name;
                    let key = |[_, a, b, c]: [u32; 4]| subface_key([a, b, c].map(name));
                    let of = |v| faces.get(&key(v)).copied().unwrap_or_default();
                    patch.create.iter().map(|new| of(new.v)).collect()
                }
            };
            if !point.labels.is_empty() {
                let corner = |k: u32| patch.vertices[k as usize].point();
                let inherited = std::mem::take(&mut regions);
                let inherited = |k: usize| inherited.get(k).or(inherited.first()).copied();
                let label = |(k, [_, a, b, c]): (usize, [u32; 4])| {
                    let own = point.label(&[a, b, c].map(corner));
                    own.or_else(|| inherited(k)).unwrap_or_default()
                };
                regions = (0..).zip(patch.create.iter().map(|new| new.v)).map(label).collect();
            }
            let bound = if patch.vertices.is_empty() { Vec::new() } else { bound.clone() };
            DomainPatch { patch, bound, regions, ..nothing() }
        };
        patches.into_iter().map(|(worker, patch)| (worker, complete(patch))).collect()
    }

    /// The end of a point that an item, of a segment or facet, goes before, and the patch that asks
    /// for that.
    fn behind(
        &self,
        point: &DomainPoint,
        Located { key, of, owner, tet, .. }: Located,
    ) -> (Vec<(WorkerId, DomainPatch)>, End) {
        let is_here = owner == self.me();
        // A point of the boundary asks again and again: two may wait for each other.
        let is_tet = point.carrier == Carrier::Free;
        let waiter = (!is_here && is_tet).then_some(self.me());
        let by = (!is_tet).then_some(point.item);
        let first = Some(Asked { key, of, tet, waiter, by });
        (vec![(owner, DomainPatch { first, ..nothing() })], End::Behind(key, is_here))
    }

    /// The verdict on a point whose closure is locked, and the patches that follow.
    pub(super) fn decide(
        &mut self,
        point: &DomainPoint,
        parts: &[Part<DomainPiece>],
        whereabouts: &dyn Fn(Name) -> Option<WorkerId>,
        directory: &Directory,
    ) -> Vec<(WorkerId, DomainPatch)> {
        if point.is_chosen {
            return self.filled(point, parts, whereabouts, directory);
        }
        let closure = LockedClosure::of(parts);
        let ruling = match parts.iter().all(|(_, pieces)| pieces.is_empty()) {
            true => LockedRuling::Useless,
            false => closure.rule(&self.complex, point),
        };
        let (mut patches, end) = match ruling {
            LockedRuling::Fill if point.may => {
                (self.filled(point, parts, whereabouts, directory), End::Inserted)
            }
            LockedRuling::Defer(first) if first.is_refused => (Vec::new(), End::Barred),
            LockedRuling::Leave => (Vec::new(), End::Barred),
            LockedRuling::Defer(first) => self.behind(point, first),
            LockedRuling::Fill | LockedRuling::Useless => (Vec::new(), End::Useless),
        };
        if end != End::Inserted {
            self.inner.forget(&point.vertex);
        }
        let own = patches.iter().position(|&(worker, _)| worker == self.me());
        let own = own.unwrap_or_else(|| {
            patches.push((self.me(), nothing()));
            patches.len() - 1
        });
        patches[own].1.end = Some(end);
        patches.sort_unstable_by_key(|&(worker, _)| worker);
        patches
    }
}

/// A patch that changes nothing.
fn nothing() -> DomainPatch {
    DomainPatch {
        patch: Patch::default(),
        bound: Vec::new(),
        regions: SmallVec::new(),
        first: None,
        end: None,
    }
}
