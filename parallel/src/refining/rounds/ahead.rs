//! Cavities found ahead. A worker that waits for others, at the end of a round or before the next
//! choice, looks for tetrahedra that will come before all around them, and finds the cavities of
//! their points, as the choice will.
//!
//! All this is a guess. Others may still insert points, and the next rounds may split boundary
//! items alone. So the choice takes a cavity only if nothing of its closure was written since
//! (R27): then it is what a search would find, as are the aim and the way to it.

use super::ranked::Own;
use super::source::{Rounds, Stage};
use super::way::{Entry, WayEnd, walk_way};
use crate::protocol::{Rules, Standing};
use crate::refining::domain::DomainMesh;
use crate::refining::news::bits;
use ltbw_refine::{Aim, middle};

/// New tetrahedra that are looked at in one step, while others are waited for.
const FEW: usize = 32;

impl<C: Rules> Rounds<C> {
    /// Is there something to do ahead while others are waited for?
    pub(super) fn looks_ahead(&self, standing: Standing) -> bool {
        let waits = match self.stage {
            // The regions of what circles make are not known before all of it is in.
            Stage::Inserting | Stage::Counting if self.circles.are_inserted() => false,
            Stage::Inserting | Stage::Counting => self.waves.tree.has_put() && standing.is_passive,
            Stage::Exchanging(_) => true,
            Stage::Looking | Stage::Choosing | Stage::Parting | Stage::Deciding | Stage::Over => {
                false
            }
        };
        let is_left = || !self.ahead.next.is_empty() || !self.keys.own.is_sifted_ahead();
        waits && self.workers > 1 && (!self.created.is_empty() || is_left())
    }

    /// Does a little of it: a message may come.
    pub(super) fn look_ahead(&mut self, mesh: &mut DomainMesh<'_>) {
        if !self.created.is_empty() {
            return self.look_at_created(mesh, FEW);
        }
        match self.ahead.next.pop() {
            Some(own) => self.find_ahead(mesh, own),
            None => self.keys.sift_ahead::<C>(mesh, &mut self.ahead.next),
        }
    }

    /// Finds the cavity of a tetrahedron's point, if nothing of its closure is another worker's.
    fn find_ahead(&mut self, mesh: &mut DomainMesh<'_>, (t, v): Own) {
        if !mesh.has(t, v) {
            return;
        }
        let points = v.map(|v| mesh.point(v));
        let Aim::At { point, carrier, may } = mesh.complex.aim_at_tet(points, 0) else { return };
        let (start, to) = (bits(&middle(points)), bits(&point));
        let WayEnd::At(seed) = walk_way(mesh, Entry { t, by: None }, &start, &to, may) else {
            return;
        };
        let Some(cavity) = mesh.cavity_of(seed, &point) else { return };
        self.ahead.enter((t, v), to, carrier, self.keys.own.look(), cavity);
    }

    /// Enters the aim and the cavity of the first probe for a tetrahedron as they were found ahead;
    /// `false` if they were not, or do not hold any more.
    pub(super) fn take_found(&mut self, mesh: &mut DomainMesh<'_>, k: u32, own: Own) -> bool {
        let found = self.ahead.of::<C>(mesh, &self.keys.own, own);
        let Some((to, carrier, cavity)) = found else { return false };
        mesh.count_steps(cavity.len() as u64 / 2);
        self.served.enter_found(self.id(k), cavity);
        let probe = &mut self.choice.probes[k as usize];
        (probe.to, probe.carrier, probe.open, probe.is_ahead) = (to, carrier, 1, true);
        true
    }
}
