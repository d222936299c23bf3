//! The sides of a tetrahedron where there are patches: which of them are subfaces the regions
//! beyond tell, and beyond an interface face these are others'. Its owner asks for them.

use super::candidate::{Probe, Told, What};
use super::serve::{Answer, LookedAt, describe};
use super::source::Rounds;
use crate::protocol::{Directory, Handle, Rules, Submesh, WorkerId};
use crate::refining::domain::{DomainMesh, labels_at};
use crate::refining::news::{DomainNews, PartEnd, ProbeId, WireClosure};
use ltbw_core::cavity::OTHERS;
use ltbw_core::topology::{TetId, VertexId, tet_of};
use ltbw_exact::Point;
use ltbw_refine::{BoundaryItem, Carrier, NOWHERE};
use std::collections::BTreeMap;

/// The others' tetrahedra whose regions tell which sides of a tetrahedron are subfaces.
fn far_sides(mesh: &DomainMesh<'_>, t: TetId) -> impl Iterator<Item = Handle> {
    let tets = mesh.inner.tets();
    let v = tets.vertices(t);
    let is_bound = move |slot: usize| OTHERS[slot].into_iter().all(|k| mesh.is_bound(v[k]));
    let far = move |slot: usize| tets.far(tet_of(tets.neighbours(t)[slot]));
    let has_patches = mesh.complex.has_patches();
    (0..4).filter(move |&slot| has_patches && is_bound(slot)).filter_map(far)
}

/// The region of the tetrahedron among those told that has a face.
fn region_told(told: &Told, face: [Point; 3]) -> Option<u32> {
    let closure = &told.closure;
    let has = |v: &[u32; 4], p: Point| {
        v.iter().any(|&v| v != NOWHERE && closure.corners[v as usize].point == p)
    };
    let place = closure.tets.iter().position(|(v, _)| face.into_iter().all(|p| has(v, p)))?;
    closure.regions.get(place).copied()
}

impl Probe {
    /// The sides of a tetrahedron that are subfaces, with what others have told; `None` if some
    /// have still to tell.
    pub(super) fn sides(
        &self,
        mesh: &DomainMesh<'_>,
        t: TetId,
        v: [VertexId; 4],
    ) -> Option<Vec<BoundaryItem>> {
        let told = self.told.as_deref().filter(|_| self.asks_beyond);
        if told.is_none() && far_sides(mesh, t).next().is_some() {
            return None;
        }
        let beyond = |slot: usize| {
            let face = OTHERS[slot].map(|k| mesh.point(v[k]));
            Some([mesh.region(t), region_told(told?, face)?])
        };
        let labels = |slot: usize| labels_at(mesh, t, slot).or_else(|| beyond(slot));
        Some(mesh.complex.sides_of(v.map(|v| mesh.corner(v)), labels))
    }
}

impl<C: Rules> Rounds<C> {
    /// Asks the owners of the tetrahedra beyond the sides of a probe's own for their regions.
    pub(super) fn ask_beyond(&mut self, mesh: &mut DomainMesh<'_>, directory: &Directory, k: u32) {
        let k = self.anew(k);
        let What::Tet(t, _) = self.choice.probes[k as usize].what else {
            return self.give_up(mesh, k);
        };
        let mut asked: BTreeMap<WorkerId, Vec<Handle>> = BTreeMap::new();
        for handle in far_sides(mesh, t) {
            asked.entry(directory.owner(handle.block)).or_default().push(handle);
        }
        let (me, id) = (self.me, self.id(k));
        let probe = &mut self.choice.probes[k as usize];
        probe.told = Some(Box::default());
        (probe.asks_beyond, probe.open) = (true, asked.len() as u32);
        for (owner, at) in asked {
            match owner == me {
                true => self.tell_beyond(mesh, directory, id, &at),
                false => self.send(owner, DomainNews::Beyond { probe: id, at }),
            }
        }
    }

    /// Tells the home of a probe of some tetrahedra of this worker.
    pub(super) fn tell_beyond(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        probe: ProbeId,
        at: &[Handle],
    ) {
        let looked = |handle: &Handle| {
            let t = mesh.resolve(handle.name)?;
            Some(LookedAt { t, is_in: false })
        };
        let here: Vec<LookedAt> = at.iter().filter_map(looked).collect();
        let found = describe(mesh, &here, Carrier::Free, true);
        let answer = Answer { found, ..Answer::bare(PartEnd::Found) };
        self.answer(mesh, directory, probe, answer);
    }

    /// An owner has told of tetrahedra beyond the sides of a probe's own: when all have, its sides
    /// are known.
    pub(super) fn take_beyond(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        from: WorkerId,
        k: u32,
        found: &WireClosure,
    ) {
        let probe = &mut self.choice.probes[k as usize];
        probe.told.get_or_insert_default().add(from, found);
        if probe.open > 0 {
            return;
        }
        let What::Tet(t, v) = probe.what else { return self.give_up(mesh, k) };
        let Some(sides) = probe.sides(mesh, t, v) else { return self.give_up(mesh, k) };
        probe.asks_beyond = false;
        match probe.sliver.as_ref().map(|own| own.0) {
            None => self.conclude_with(mesh, k, &sides),
            Some(n) => {
                self.look_beside(mesh, n, sides);
                self.try_on(mesh, directory, k);
            }
        }
    }
}
