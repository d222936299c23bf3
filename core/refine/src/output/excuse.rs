//! The tetrahedra that are over their bounds at the end, each with the reason; and counts of them
//! by corner and segment.

use super::refined::Refined;
use crate::RefineError;
use crate::complex::measure::Shape;
use crate::mesh::bounds::Bounds;
use crate::mesh::item::Item;
use crate::mesh::key::{sorted, spot};
use crate::mesh::number::in_order;
use crate::mesh::state::State;
use crate::outcome::{Excuse, Reason, Spot};
use crate::rules::record::Record;
use crate::table::{Map, Set};
use ltbw_core::topology::TetId;
use ltbw_exact::Point;

impl State {
    /// The middle of a boundary item, in the coordinates of the mesh.
    fn spot(&self, item: Item) -> Spot {
        spot(item, |v| self.at(v), self.fine_step)
    }

    /// The reason that a boundary item and others displace each other.
    pub(crate) fn interlocked(&self, item: Item) -> Reason {
        Reason::Interlocked { at: self.spot(item) }
    }

    /// The reason that no point splits a boundary item.
    pub(crate) fn unserved(&self, item: Item) -> Reason {
        Reason::Unserved { at: self.spot(item) }
    }

    /// The excuses of the tetrahedra over their bounds, in the order of `order`, which has all;
    /// `over` lists them if they are known. What was not refused is over for the reason `stop`.
    pub(crate) fn excuses(
        &self,
        bounds: &Bounds<'_>,
        record: &Record,
        order: &[TetId],
        over: Option<Vec<TetId>>,
        stop: Option<Reason>,
    ) -> Vec<Excuse> {
        let all = || -> Vec<TetId> {
            let all = order.iter().copied();
            bounds.over_of(self, all, &mut Vec::new()).map(|(t, _)| t).collect()
        };
        let over = match over {
            None => all(),
            Some(mut over) => {
                over.sort_unstable_by_key(|&t| self.mesh.tet(t).map(in_order));
                // A field was asked once more already.
                debug_assert!(
                    bounds.field.is_some() || over == all(),
                    "all that are over their bounds are known"
                );
                over
            }
        };
        let excuse = |tet: TetId| {
            let item = Item::Tet(tet, self.vertices(tet));
            let reason = record.refused.get(&item).map(|r| r.reason).or(stop);
            Excuse { tet, reason: reason.unwrap_or(Reason::Rounding) }
        };
        over.into_iter().map(excuse).collect()
    }

    /// Has the sizing field lengths for all tetrahedra, which `order` has, and are those over their
    /// bounds now the ones of before? It is asked for each once more.
    ///
    /// # Errors
    /// A place where it has none, or another one.
    pub(crate) fn check_field(
        &self,
        bounds: &Bounds<'_>,
        order: &[TetId],
        before: &[TetId],
    ) -> Result<(), RefineError> {
        if bounds.field.is_none() {
            return Ok(());
        }
        bounds.check_sizes(self, order)?;
        let before: Set<TetId> = before.iter().copied().collect();
        let (mut thin, all) = (Vec::new(), order.iter().copied());
        let now: Set<TetId> = bounds.over_of(self, all, &mut thin).map(|(t, _)| t).collect();
        let differs = |t: &&TetId| before.contains(*t) != now.contains(*t);
        let Some(&t) = order.iter().find(differs) else { return Ok(()) };
        let corners = self.vertices(t).map(|v| self.at(v));
        Err(RefineError::ImpureSize { at: bounds.centroid(corners.each_ref()) })
    }
}

/// The tetrahedra over a bound for one reason: at one corner or segment of the input, for example.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excused {
    /// The reason that they have in common.
    pub reason: Reason,
    /// Their number.
    pub tets: usize,
    /// The volume that they fill, rounded, in the coordinates of the domain.
    pub volume: f64,
    /// The middle of the largest of them, in the same coordinates.
    pub at: Point,
}

/// A sum of rounded numbers with what rounding took off it, so that millions of them lose nothing.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    head: f64,
    rest: f64,
}

impl Sum {
    /// Adds a number that is not negative.
    fn add(&mut self, x: f64) {
        let (large, small) = if self.head < x { (x, self.head) } else { (self.head, x) };
        self.head = large + small;
        self.rest += (large - self.head) + small;
    }

    fn value(self) -> f64 {
        self.head + self.rest
    }
}

impl Refined {
    /// The excuses counted by reason, in the order of reasons: corner by corner, then segment by
    /// segment.
    pub fn excused(&self) -> Vec<Excused> {
        let mut all: Map<Reason, (usize, Sum, (f64, TetId))> = Map::default();
        for &Excuse { tet, reason } in &self.excuses {
            let volume = self.volume_of(tet);
            let (tets, sum, largest) =
                all.entry(reason).or_insert((0, Sum::default(), (-1.0, tet)));
            *tets += 1;
            sum.add(volume);
            // Of equal ones the first, which is the same for any number of threads.
            if volume > largest.0 {
                *largest = (volume, tet);
            }
        }
        let excused = |(reason, (tets, sum, (_, largest)))| {
            let (volume, at) = (Sum::value(sum), self.centroid(largest));
            Excused { reason, tets, volume, at }
        };
        let mut list: Vec<Excused> = all.into_iter().map(excused).collect();
        list.sort_unstable_by_key(|excused| excused.reason);
        list
    }

    /// The volume of all tetrahedra inside, rounded, in the coordinates of the domain.
    pub fn volume(&self) -> f64 {
        let mut sum = Sum::default();
        self.tets().for_each(|t| sum.add(self.volume_of(t)));
        sum.value()
    }

    /// The centroid of a tetrahedron, in the coordinates of the mesh.
    pub fn centroid(&self, t: TetId) -> Point {
        self.middle(&Item::Tet(t, self.state.vertices(t)))
    }

    /// The volume of a tetrahedron, rounded, with its vertices in an order that is always the same.
    pub(crate) fn volume_of(&self, t: TetId) -> f64 {
        let step = self.lattice.fine_step();
        let [a, b, c, d] = sorted(self.state.vertices(t).map(|v| self.state.at(v)));
        Shape::of([&a, &b, &c, &d]).det.abs() / 6.0 * step * step * step
    }
}

#[cfg(test)]
mod tests {
    use super::Sum;

    #[test]
    fn sums_keep_what_rounding_takes_off() {
        let mut sum = Sum::default();
        for x in [2.0_f64.powi(-60), 1.0, 2.0_f64.powi(53), 1.0, 2.0_f64.powi(-60)] {
            sum.add(x);
        }
        assert_eq!(sum.value(), 2.0_f64.powi(53) + 2.0);
    }
}
