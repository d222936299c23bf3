//! Domains that workers refine in rounds, one event at a time.

use super::{Case, Chooser, Figures, World, ending};
use crate::compare::same_refined;
use ltbw::domain::Prepared;
use ltbw::mesh::Layout;
use ltbw::protocol::{Config, Correct};

use ltbw::refine::{ComplexError, Refiner};
use ltbw::refining::{Ending, rounds_by};

impl Case {
    /// Refines `ready` by workers, in the order that `chooser` makes; checks the end. Blocks do not
    /// move, and nothing goes through bytes. Returns how the workers' rounds have ended, or why
    /// there were none.
    ///
    /// # Panics
    /// If a run does not end, or not as it must.
    pub fn refine(
        &self,
        refiner: &Refiner<'_>,
        ready: &Prepared,
        chooser: &mut Chooser,
    ) -> (Figures, Result<Ending, ComplexError>) {
        let engine = refiner.refine(&ready.domain, &ready.lattice);
        let engine = engine.unwrap_or_else(|error| panic!("{error}"));
        let case = Self { moves: 0, bytes: false, ..*self };
        let layout = |points| {
            let Layout { workers, blocks_per_worker, ownership, .. } = self.layout;
            let layout = Layout { blocks_per_worker, ownership, ..Layout::new(points, workers) };
            (layout, Config { rule: self.rule, closure: self.closure, ..Config::new(workers) })
        };
        let mut figures = Figures::default();
        let points = engine.mesh().num_vertices();
        let whole = (&ready.domain, &ready.lattice);
        let run = rounds_by::<Correct>(refiner, whole, layout, |nodes| {
            let mut world = World::new(case, nodes, points, |message| message);
            world.run(chooser).unwrap_or_else(|error| panic!("{error}"));
            world.check_rest();
            figures.add(&world.figures);
            Ok(world.nodes)
        });
        let (refined, end) = run.unwrap_or_else(|error| panic!("{error}"));
        if self.cancel.is_none() {
            same_refined(&format!("{self:?}"), &refined, &engine);
        } else {
            ending::same_as_anew(refined.mesh());
        }
        (figures, end)
    }
}
