//! Refusals: what cannot be split. All workers know the boundary items that were refused, for
//! anybody's verdict may ask for one; its keeper tells them, between two rounds. Of a tetrahedron
//! its owner knows.

use super::candidate::{Outcome, What};
use super::demands::{ItemRefusal, Refused};
use super::source::Rounds;
use crate::protocol::Rules;
use crate::refining::domain::DomainMesh;
use crate::refining::news::{DomainNews, WireItemRefusal, WireRefusal};
use ltbw_refine::{Past, Reason, Refusal};

impl<C: Rules> Rounds<C> {
    /// All that a verdict asks of earlier rounds.
    pub(super) fn past(&self, what: &What) -> Past<'_> {
        let limit = match what {
            What::Tet(..) => None,
            What::Item(item) => self.demands.pending.get(&item.place()).and_then(|own| own.limit),
        };
        let num_vertices = (self.budget.others + self.budget.total) as usize;
        Past { num_vertices, spent: self.spent, limit, refused: &self.demands.refused.all }
    }

    /// A probe ends with a refusal.
    pub(super) fn refuse(&mut self, mesh: &DomainMesh<'_>, k: u32, reason: Reason) {
        self.conclude(k, Outcome::Refused(reason));
        self.report(mesh, k);
    }

    /// No aim is left for a boundary item.
    pub(super) fn refuse_without_aim(&mut self, mesh: &DomainMesh<'_>, k: u32) {
        if let What::Item(item) = &self.choice.probes[k as usize].what {
            let reason = mesh.complex.reason_without_aim(item);
            self.refuse(mesh, k, reason);
        }
    }

    /// A probe's tetrahedron, or item, is refused.
    pub(super) fn carry_out_refusal(&mut self, mesh: &DomainMesh<'_>, k: u32, reason: Reason) {
        let Refused { new, count, .. } = &mut self.demands.refused;
        *count += 1;
        match &self.choice.probes[k as usize].what {
            &What::Tet(t, v) => self.keys.refuse(mesh, (t, v), Refusal::under(reason, None)),
            What::Item(item) => new.push((item.place(), reason)),
        }
    }

    /// Tells all others which items of this keeper are refused, or are not any more.
    pub(super) fn tell_refusals(&mut self, told: &[ItemRefusal]) {
        // R29.
        if told.is_empty() || !C::tells_refusals() {
            return;
        }
        let wire = |own: &ItemRefusal| WireItemRefusal::new(own.place, own.why);
        let news = DomainNews::Refused(told.iter().map(wire).collect());
        self.counts.releases += self.send_to_others(&news);
    }

    /// Another keeper tells. Nobody asks before the next round.
    pub(super) fn take_refusals(&mut self, told: Vec<WireItemRefusal>) {
        self.counts.releases -= 1;
        for WireItemRefusal { place, why } in told {
            self.demands.refused.set(place, why.map(WireRefusal::refusal));
        }
    }
}
