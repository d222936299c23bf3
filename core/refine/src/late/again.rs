//! Tetrahedra that were refused are asked again when nothing else is left to do, for shorter edges
//! where many were refused because of one corner.
//!
//! A refusal is that of a boundary item which the tetrahedron waits for, under the limit of its
//! time: others may have been split since, or the item may be gone. So a few refusals near a small
//! angle would leave all that waits for them, in a chain, as it was.

use crate::mesh::item::Item;
use crate::outcome::Reason;
use crate::queue::split::Refinement;
use crate::table::Map;
use ltbw_core::topology::TetId;

/// The most times in a row that refused tetrahedra are asked again.
const MOST: u32 = 5;

/// The parts of what they may usually make that edges may have when many are over at one corner.
const PARTS: [f64; 2] = [0.5, 0.25];
/// The least number by which they are more than the needles there.
const MANY: usize = 2;
/// The most needles there: with more, every cut leads to others.
const MOST_NEEDLES: usize = 40;
/// The most tetrahedra for each vertex of the domain; with more, needles are all there is.
const DENSE: usize = 192;
/// The most in a domain of [`LARGE`] vertices and more: there it takes a quarter more tetrahedra
/// to excuse a tenth fewer.
const DENSE_OF_LARGE: usize = 128;
/// The least number of vertices of a large domain.
const LARGE: usize = 1024;

/// The times that refused tetrahedra were asked again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asking {
    /// Their number since corners were looked at.
    times: u32,
    /// The tetrahedra asked at the last one of these.
    before: usize,
    /// The parts of [`PARTS`] that were used.
    parts: usize,
}

impl Default for Asking {
    fn default() -> Self {
        Self { times: 0, before: usize::MAX, parts: 0 }
    }
}

impl Refinement<'_> {
    /// Forgets the refusals of tetrahedra over their bounds, and gives these, while that makes them
    /// fewer.
    fn ask_again(&mut self, asking: &mut Asking) -> Vec<TetId> {
        let over = self.refused_and_over();
        if asking.times == MOST || over.is_empty() || over.len() >= asking.before {
            return Vec::new();
        }
        (asking.times, asking.before) = (asking.times + 1, over.len());
        let mut refused = std::mem::take(&mut self.record.refused);
        // On a tip or in a collar the answer is the same.
        refused.retain(|&item, _| match item {
            Item::Tet(t, v) => self.state.is_live(t, v) && self.beyond_help(t, v).is_some(),
            _ => false,
        });
        self.record.refused = refused;
        self.record.limits.clear();
        self.record.waits.clear();
        over.into_iter().map(|(t, _)| t).collect()
    }

    /// Gives tetrahedra that are to be asked again; none if that is of no use any more. Those asked
    /// for shorter edges are asked again while that makes them fewer.
    ///
    /// They are those of which many were refused because of one corner; from now on they may
    /// make shorter edges. A tip that is not cut, since its side would be too short, keeps what
    /// is beside it from being split, and that the next. A shorter tip is no worse; but where
    /// needles are dense every cut leads to others.
    pub(crate) fn insist(&mut self, asking: &mut Asking) -> Vec<TetId> {
        if asking.parts > 0 {
            let again = self.ask_again(asking);
            if !again.is_empty() {
                return again;
            }
        }
        let state = &self.state;
        let vertices = state.plc.count();
        let dense = if vertices < LARGE { DENSE } else { DENSE_OF_LARGE };
        if state.mesh.num_tets() > dense * vertices {
            return Vec::new();
        }
        let Some(&part) = PARTS.get(asking.parts) else { return Vec::new() };
        let needles = state.angles.needles();
        let over = self.refused_and_over();
        let mut counts: Map<Reason, usize> = Map::default();
        for &(_, (_, reason)) in &over {
            *counts.entry(reason).or_default() += 1;
        }
        let is_many = |reason: &Reason| {
            let own = needles.get(reason).filter(|&&own| own <= MOST_NEEDLES);
            own.is_some_and(|own| counts[reason] >= MANY + own)
        };
        self.record.parts.clear();
        let mut asked = Vec::new();
        for (t, (item, _)) in over.into_iter().filter(|(_, (_, reason))| is_many(reason)) {
            self.record.refused.remove(&item);
            self.record.parts.insert(item, part);
            asked.push(t);
        }
        *asking = Asking { parts: asking.parts + 1, ..Asking::default() };
        asked
    }

    /// The refused tetrahedra that are over their bounds and on no tip and in no collar, in the
    /// order of their slots, and why.
    fn refused_and_over(&self) -> Vec<(TetId, (Item, Reason))> {
        let Some(bounds) = &self.bounds else { return Vec::new() };
        let over = self.record.refused_over(bounds, &self.state);
        let over = over.filter(|&(t, v)| self.beyond_help(t, v).is_none());
        let mut all: Vec<_> = over
            .map(|(t, v)| {
                let item = Item::Tet(t, v);
                (t, (item, self.record.refused[&item].reason))
            })
            .collect();
        all.sort_unstable_by_key(|own| own.0);
        all
    }
}
