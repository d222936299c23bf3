//! Leaders: at small angles, where many tetrahedra may be refused, one is probed of those whose
//! circumspheres are nearly equal. They may be several workers', so that one, the conductor, says
//! which.

use super::candidate::What;
use super::contest::{CONDUCTOR, Contest};
use super::keys::Foremost;
use super::ranked::rank_of;
use super::source::Rounds;
use super::stages::along_curve;
use crate::protocol::{Rules, WorkerId};
use crate::refining::domain::DomainMesh;
use crate::refining::news::{DomainNews, Entrant};
use rustc_hash::FxHashSet;

impl<C: Rules> Rounds<C> {
    /// Are only some of the foremost tetrahedra probed, though none has its turn?
    pub(super) fn has_leaders(&self, mesh: &DomainMesh<'_>) -> bool {
        mesh.complex.has_angles() && !self.has_turns(mesh)
    }

    /// Tells the conductor of the foremost tetrahedra here.
    pub(super) fn enter_foremost(&mut self, mesh: &DomainMesh<'_>, foremost: [Vec<Foremost>; 2]) {
        let (mut entered, mut entrants) = (Vec::new(), Vec::new());
        // Candidates at interface faces come first: others are waited for there.
        for list in &foremost {
            for k in along_curve(list.iter().map(|own| own.at)) {
                let Foremost { t, v, .. } = list[k];
                let group = mesh.complex.group_of(v.map(|v| mesh.point(v)));
                entrants.push(Entrant { rank: rank_of::<C>(mesh, v), tet: Some(t), group });
                entered.push(list[k]);
            }
        }
        self.keys.take_back(foremost);
        // R30.
        if !C::shares_leaders() {
            let own = Contest::of(vec![entrants]).probed().next().unwrap_or_default();
            return self.probe_leaders(&entered, &own);
        }
        (self.choice.foremost, self.choice.entered) = (Some(0), Some(entered));
        self.send(CONDUCTOR, DomainNews::Entrants(entrants));
    }

    /// The conductor tells all workers which of theirs are probed.
    pub(super) fn tell_leaders(&mut self, contest: &Contest) {
        for (home, numbers) in (0..).map(WorkerId::new).zip(contest.probed()) {
            self.send(home, DomainNews::Launch(numbers));
        }
    }

    /// The foremost tetrahedra with these numbers are probed.
    pub(super) fn probe_leaders(&mut self, entered: &[Foremost], numbers: &[u32]) {
        self.choice.foremost = Some(numbers.len() as i64);
        let is_probed: FxHashSet<u32> = numbers.iter().copied().collect();
        let others = (0..).zip(entered).filter(|own| !is_probed.contains(&own.0));
        self.barriers.followers = others.map(|(_, own)| (own.t, own.v)).collect();
        for &Foremost { t, v, lead, .. } in numbers.iter().map(|&k| &entered[k as usize]) {
            let k = self.add_probe(What::Tet(t, v), lead, 0);
            self.choice.to_launch.push_back(k);
        }
    }
}
