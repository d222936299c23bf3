//! The verdict on a probe's point, by a closure that is all here or that others have told of.

use super::candidate::{Outcome, Probe, Told, What};
use super::here::Here;
use super::serve::describe;
use crate::refining::domain::{DomainMesh, WallRegion};
use crate::refining::news::point;
use ltbw_core::topology::TetId;
use ltbw_refine::{
    Block, BoundaryItem, Collected, ItemPlace, Past, Reason, Ruling, Survey, Surveyed, Watch,
};
use std::collections::BTreeSet;

/// The verdict on a probe's point.
#[derive(Debug, PartialEq)]
pub(super) enum Verdict {
    Is(Outcome),
    /// It does not do what it was made for; another one may.
    Useless,
    /// Its tetrahedron cannot be split, since the point would take subfaces out of the mesh that
    /// may not be split: from then on others are refused for that.
    Blocked(Reason, Vec<Block>),
}

impl Probe {
    /// May its closure have a part in the boundary though none of its cavity is near?
    pub(super) fn may_meet_boundary(&self, mesh: &DomainMesh<'_>) -> bool {
        matches!(self.what, What::Item(_)) || self.sliver.is_some() || mesh.complex.has_patches()
    }

    /// The survey of a closure of its point.
    pub(super) fn survey<'c, R: Surveyed>(
        &self,
        mesh: &'c DomainMesh<'_>,
        closure: &'c R,
    ) -> Survey<'c, R> {
        Survey::of(&mesh.complex, closure, &point(&self.to), self.carrier)
    }

    /// The verdict on its point by a survey of its closure and its past, and what makes it wait for
    /// others.
    pub(super) fn rule<R: Surveyed>(
        &self,
        mesh: &DomainMesh<'_>,
        survey: &Survey<'_, R>,
        past: &Past,
    ) -> (Verdict, Option<Watch<R::Tet>>) {
        let ruling = match &self.what {
            What::Tet(..) => survey.rule_on_tet(),
            What::Item(item) => survey.rule_on_item(item, self.may, past),
        };
        match ruling {
            Ruling::Fill(filled) => {
                let watch = match &self.what {
                    What::Tet(..) => survey.watch_in_tet(),
                    What::Item(item) => Some(survey.watch_at_item(item)),
                };
                (Verdict::Is(Outcome::Fits(filled)), watch)
            }
            Ruling::Defer(first) if first.is_empty() => (Verdict::Useless, None),
            Ruling::Defer(first) => match self.what.asks(mesh, &first, past) {
                Outcome::Refused(reason) if matches!(self.what, What::Tet(..)) => {
                    let blocks = survey.blocks(&self.what.under_limit(mesh, past));
                    (Verdict::Blocked(reason, blocks), None)
                }
                outcome => (Verdict::Is(outcome), None),
            },
            Ruling::Useless => (Verdict::Useless, None),
            Ruling::Refuse(reason) => (Verdict::Is(Outcome::Refused(reason)), None),
        }
    }

    /// Is the verdict the same if the closure is told by values?
    pub(super) fn rules_so_by_values(
        &self,
        here: &Here<'_, '_>,
        verdict: &Verdict,
        watch: Option<&Watch<TetId>>,
        past: &Past,
    ) -> bool {
        let order = here.listed();
        let mut told = Told::default();
        told.add(here.mesh.me(), &describe(here.mesh, &order, self.carrier, false));
        let closure = Collected::of(&told.closure);
        let (by_values, other) = self.rule(here.mesh, &self.survey(here.mesh, &closure), past);
        let sorted = |verdict: &Verdict| match verdict {
            Verdict::Is(Outcome::Fits(filled)) => {
                let walls: BTreeSet<_> = filled.relabelled.iter().map(WallRegion::of).collect();
                let gone: BTreeSet<ItemPlace> =
                    filled.gone.iter().map(BoundaryItem::place).collect();
                Some((gone, walls, filled.is_alone))
            }
            _ => None,
        };
        let is_same = match sorted(verdict) {
            Some(gone) => sorted(&by_values) == Some(gone),
            None => by_values == *verdict,
        };
        let watch = watch.map(|watch| watch.named(|t| t));
        is_same && watch == other.map(|other| other.named(|place| order[place].t))
    }
}
