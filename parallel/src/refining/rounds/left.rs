//! The work that workers are given at the start of their rounds, and leave at the end.

use super::Left;
use super::demands::Pending;
#[cfg(feature = "wire")]
use super::figures::Ending;
use super::figures::RoundFigures;
use super::source::Rounds;
use crate::protocol::Rules;
#[cfg(feature = "wire")]
use crate::protocol::WorkerId;
use crate::refining::domain::DomainMesh;
use ltbw_core::topology::INFINITE;
#[cfg(feature = "wire")]
use ltbw_core::topology::TetId;
use ltbw_refine::{Asked, BoundaryItem, ItemPlace, Refusal, Remaining, TetPlace};
use std::collections::{BTreeMap, BTreeSet};

impl<C: Rules> Rounds<C> {
    /// Goes on where others were: with what they have left, and figures.
    pub(super) fn resume(
        &mut self,
        mesh: &DomainMesh<'_>,
        left: &Remaining,
        figures: RoundFigures,
    ) {
        self.budget.counted = left.candidates as i64;
        (self.figures, self.spent) = (figures, left.spent);
        let asked = &left.asked;
        let items: BTreeMap<ItemPlace, BoundaryItem> =
            asked.iter().map(|own| (own.item.place(), own.item)).collect();
        for Asked { item, first, limit } in asked {
            let (item, first, limit, place) = (*item, *first, *limit, item.place());
            let keeper = self.keeper(mesh, &item);
            if keeper == self.me {
                self.demands.pending.insert(place, Pending { item, first, limit, near: None });
            }
            if let Some(other) = first.and_then(|first| items.get(&first))
                && self.keeper(mesh, other) == self.me
            {
                self.demands.waiters.entry(other.place()).or_default().push((keeper, place));
            }
        }
        self.demands.refused.all.extend(left.refused.iter().copied());
        self.resume_blocks(&left.blocks);
        let all = mesh.inner.tets();
        let finite = || {
            let finite = all.tets().map(|(t, _)| (t, all.vertices(t)));
            finite.filter(|(_, v)| !v.contains(&INFINITE))
        };
        let place = |own: &[_; 4]| TetPlace::of(own.map(|v| mesh.point(v)));
        if !left.refused_tets.is_empty() {
            let refused: BTreeMap<TetPlace, Refusal> = left.refused_tets.iter().copied().collect();
            let own = finite().filter_map(|(t, v)| Some(((t, v), *refused.get(&place(&v))?)));
            own.for_each(|(own, why)| self.keys.refuse_again(own, why));
        }
        if let Some(slivers) = &left.slivers {
            let slivers: BTreeSet<TetPlace> = slivers.iter().copied().collect();
            self.slivers.resume(finite().filter(|(_, v)| slivers.contains(&place(v))).collect());
        }
    }

    /// The boundary items that it keeps.
    pub(super) fn asked(&self) -> Vec<Asked> {
        let left = |own: &Pending| {
            let Pending { item, first, limit, .. } = *own;
            Asked { item, first, limit }
        };
        self.demands.pending.values().map(left).collect()
    }

    /// The candidates among the tetrahedra when last counted.
    pub(super) fn candidates(&self) -> usize {
        usize::try_from(self.budget.counted).unwrap_or(0)
    }

    /// The work that is left.
    pub(super) fn into_left(self, mesh: &DomainMesh<'_>) -> Left {
        let (asked, candidates, blocks) = (self.asked(), self.candidates(), self.blocks_left());
        Left {
            worker: self.me,
            asked,
            refused: self.demands.refused.all.into_iter().collect(),
            refused_tets: self.keys.refused(mesh),
            spent: self.spent,
            candidates,
            thin: self.keys.thin(mesh),
            before_slivers: self.slivers.before,
            slivers: self.slivers.into_left(mesh),
            blocks,
            ending: self.ending,
            figures: self.figures,
        }
    }
}

#[cfg(feature = "wire")]
impl Left {
    /// This work, under other numbers of tetrahedra.
    pub(super) fn by(self, number: &dyn Fn(TetId) -> Option<TetId>) -> Self {
        let all = |own: Vec<TetId>| own.into_iter().filter_map(number).collect();
        let refused = self.refused_tets.into_iter();
        Self {
            thin: all(self.thin),
            slivers: self.slivers.map(all),
            refused_tets: refused.filter_map(|(t, why)| Some((number(t)?, why))).collect(),
            ..self
        }
    }

    /// Nothing, of a worker without rounds.
    pub(in crate::refining) fn nothing(worker: WorkerId) -> Self {
        Self {
            worker,
            asked: Vec::new(),
            refused: Vec::new(),
            refused_tets: Vec::new(),
            candidates: 0,
            spent: 0,
            thin: Vec::new(),
            slivers: None,
            before_slivers: None,
            blocks: Vec::new(),
            ending: Some(Ending::Done),
            figures: RoundFigures::default(),
        }
    }
}
