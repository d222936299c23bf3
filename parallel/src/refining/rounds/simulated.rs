//! Rounds on simulated processors.

use super::{AllRounds, Ending, Late, RoundFigures, refine};
use crate::mesh::redeal::Moved;
use crate::metrics::Summary;
use crate::protocol::{Correct, Rules};
use crate::refining::RefineError;
use crate::refining::domain::Plan;
use crate::simulate::{MeshError, Options, Simulation, simulate};
use ltbw_domain::{Domain, Lattice};
use ltbw_refine::{ComplexError, Refined, Refiner};

/// A domain refined in rounds on simulated processors.
#[derive(Debug)]
pub struct SimulatedRounds {
    /// The refined domain.
    pub refined: Refined,
    /// The figures of the processors' time in the rounds that they carried out; `None` if they
    /// carried out none.
    pub summary: Option<Summary>,
    /// Events of the simulation.
    pub events: u64,
    /// The end of the processors' rounds, or why they carried out none.
    pub ending: Result<Ending, ComplexError>,
    /// The figures of their rounds.
    pub figures: RoundFigures,
    /// Why processors that share nothing could not keep their parts in the end; `None` if they
    /// could, or have carried out no rounds.
    pub late: Option<Late>,
}

/// Refines a domain in rounds on simulated processors. Virtual time is that of the processors, from
/// the start of the rounds to where one takes over.
///
/// # Errors
/// [`RefineError`] if the domain has no mesh, or if the run has not ended properly.
pub fn simulate_rounds(
    refiner: &Refiner<'_>,
    domain: &Domain,
    lattice: &Lattice,
    plan: &dyn Fn(usize) -> Plan,
    options: &Options,
) -> Result<SimulatedRounds, RefineError> {
    simulate_rounds_as::<Correct>(refiner, domain, lattice, plan, options)
}

/// As [`simulate_rounds`], under other rules: a known-bad variant, for checkers.
///
/// # Errors
/// As [`simulate_rounds`].
#[doc(hidden)]
pub fn simulate_rounds_as<C: Rules>(
    refiner: &Refiner<'_>,
    domain: &Domain,
    lattice: &Lattice,
    plan: impl Fn(usize) -> Plan,
    options: &Options,
) -> Result<SimulatedRounds, RefineError> {
    let options = Options { balance: None, storm: None, ..options.clone() };
    let (mut summary, mut events) = (None::<Summary>, 0);
    let run = |workers, moved: &[Moved]| {
        if let Some(all) = summary.as_mut().filter(|_| !moved.is_empty()) {
            let pause = options.redeal(moved);
            all.pause(pause.all, &pause.own);
        }
        let run = simulate(workers, &options).map_err(MeshError::from)?;
        let Simulation { workers, summary: own, events: more, .. } = run;
        events += more;
        match &mut summary {
            Some(all) => all.go_on(&own),
            None => summary = Some(own),
        }
        Ok(workers)
    };
    let layout = |vertices: usize| {
        let Plan { layout, config } = plan(vertices);
        (layout, config)
    };
    let all = refine::<C>(refiner, (domain, lattice), layout, run, true)?;
    let AllRounds { refined, ending, figures, late, .. } = all;
    Ok(SimulatedRounds { refined, summary, events, ending, figures, late })
}
