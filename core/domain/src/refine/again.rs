//! Tetrahedra that were refused are asked again when nothing else is left to do.
//!
//! A refusal is that of a boundary item which the tetrahedron waits for, under the limit of its
//! time: others may have been split since, or the item may be gone. So a few refusals near a small
//! angle would leave all that waits for them, in a chain, as it was.

use super::RefineError;
use super::item::{Item, Work};
use super::outcome::Reason;
use super::run::Run;
use super::table::Map;

/// The most times that refused tetrahedra are asked again.
const MOST: u32 = 5;

/// The parts of what they may usually make that edges may have when many are over at one corner.
const PARTS: [f64; 2] = [0.5, 0.25];
/// The least number by which they are more than the needles there.
const MANY: usize = 2;
/// The most tetrahedra for each vertex of the domain; with more, needles are all there is.
const DENSE: usize = 192;

impl Run<'_> {
    /// Asks refused tetrahedra again while that makes them fewer.
    pub(super) fn refine_again(&mut self) -> Result<(), RefineError> {
        let mut before = usize::MAX;
        for _ in 0..MOST {
            let over = self.refused_and_over();
            if self.stop.is_some() || over.is_empty() || over.len() >= before {
                return Ok(());
            }
            before = over.len();
            let refinement = &mut self.refinement;
            let mut refused = std::mem::take(&mut refinement.record.refused);
            // On a tip or in a collar the answer is the same.
            refused.retain(|&item, _| match item {
                Item::Tet(t, v) => {
                    refinement.state.is_live(t, v) && refinement.beyond_help(t, v).is_some()
                }
                _ => false,
            });
            refinement.record.refused = refused;
            refinement.record.limits.clear();
            refinement.record.waits.clear();
            over.into_iter().for_each(|(item, weight)| self.work.put(item, weight));
            self.refine(usize::MAX)?;
        }
        Ok(())
    }

    /// Asks again where many tetrahedra were refused because of one corner, for shorter edges.
    ///
    /// A tip that is not cut, since its side would be too short, keeps what is beside it from being
    /// split, and that the next. A shorter tip is no worse; but where needles are dense every cut
    /// leads to others.
    pub(super) fn insist(&mut self) -> Result<(), RefineError> {
        let state = &self.refinement.state;
        if self.stop.is_some() || state.mesh.num_tets() > DENSE * state.plc.corners.len() {
            return Ok(());
        }
        let needles = state.angles.needles();
        for part in PARTS {
            let over = self.refused_and_over();
            let reason = |item: &Item| self.refinement.record.refused.get(item).map(|r| r.reason);
            let mut counts: Map<Reason, usize> = Map::default();
            for reason in over.iter().filter_map(|(item, _)| reason(item)) {
                *counts.entry(reason).or_default() += 1;
            }
            let is_many = |item: &Item| {
                let reason = reason(item).filter(|reason| needles.contains_key(reason));
                reason.is_some_and(|reason| counts[&reason] >= MANY + needles[&reason])
            };
            let many: Vec<_> = over.into_iter().filter(|(item, _)| is_many(item)).collect();
            if many.is_empty() {
                break;
            }
            let record = &mut self.refinement.record;
            record.parts.clear();
            for (item, weight) in many {
                record.refused.remove(&item);
                record.parts.insert(item, part);
                self.work.put(item, weight);
            }
            self.refine(usize::MAX)?;
            self.refine_again()?;
        }
        Ok(())
    }

    /// The refused tetrahedra that are over their bounds and on no tip and in no collar, in the
    /// order of their slots, with their weights.
    fn refused_and_over(&self) -> Vec<(Item, f64)> {
        let refinement = &self.refinement;
        let Some(bounds) = &refinement.bounds else { return Vec::new() };
        let over = |&item: &Item| {
            let Item::Tet(t, v) = item else { return None };
            if !refinement.state.is_live(t, v) || refinement.beyond_help(t, v).is_some() {
                return None;
            }
            bounds.excess(&refinement.state, t).map(|weight| (item, weight))
        };
        let mut all: Vec<(Item, f64)> = refinement.record.refused.keys().filter_map(over).collect();
        all.sort_unstable_by_key(|&(item, _)| item);
        all
    }
}
