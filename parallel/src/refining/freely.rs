//! Refinement without rounds, from its start to its end, on simulated processors and on threads; on
//! processes in `team`.

#[cfg(feature = "wire")]
mod team;

#[cfg(feature = "wire")]
pub use team::domain_on_team;

use super::RefineError;
use super::domain::{BadItems, Begun, DomainMesh, DomainNode, Plan, Splits, prepare};
use super::whole::{Owners, Part, Whole, put_together};
use crate::mesh::{Layout, Redeal, SharedInput};
use crate::metrics::Summary;
use crate::protocol::{Config, Correct, Rules};
use crate::simulate::{MeshError, Options, Simulation, simulate};
use crate::threads::{Parallel, WorkerStats};
use ltbw_domain::{Domain, Lattice};
use ltbw_refine::{Complex, ComplexError, Delegated, Handed, Refined, Refiner, Start};

/// Vertices of each worker at the start: with fewer, most cavities reach an interface.
#[doc(hidden)]
pub const START_EACH: usize = 2048;

/// A domain that simulated processors have refined.
#[derive(Debug)]
pub struct SimulatedDomain {
    /// The refined domain.
    pub refined: Refined,
    /// The figures of the splits, over all workers.
    pub splits: Splits,
    /// Points at the start.
    pub started: usize,
    /// The figures of time.
    pub summary: Summary,
    /// Events of the simulation.
    pub events: u64,
}

/// A domain that threads have refined.
#[derive(Debug)]
pub struct ThreadedDomain {
    /// The refined domain.
    pub refined: Refined,
    /// The figures of each worker; of none if one thread has refined all.
    pub workers: Vec<WorkerStats>,
    /// The workers that have its tetrahedra.
    pub owners: Owners,
    /// The figures of the splits, over all workers, or why they have made none.
    pub splits: Result<Splits, ComplexError>,
}

/// A domain that workers have refined, with their figures and what their run has told.
struct Refining<R> {
    refined: Refined,
    splits: Splits,
    owners: Owners,
    told: R,
}

/// Workers that have run, and what their run has told.
struct Ran<'a, C: Rules, R> {
    workers: Vec<DomainNode<'a, C>>,
    told: R,
}

/// Workers with their lists, and all that they share.
///
/// # Errors
/// [`RefineError`] if the domain has no mesh.
fn begin<'a, C: Rules>(
    complex: Complex<'a>,
    start: &Start,
    layout: Layout,
    config: Config,
) -> Result<Begun<'a, BadItems, C>, RefineError> {
    // The budget is shared out beforehand: workers do not know what others have made.
    let share = start.most.saturating_sub(start.made()) / u64::from(layout.workers);
    let items = |me, mesh: &mut DomainMesh<'_>| {
        mesh.let_blocks_move();
        BadItems::new(me, share, mesh)
    };
    // Blocks move one by one there.
    let layout = Layout { redeal: Redeal::Never, ..layout };
    prepare::<_, C>(complex, start, &layout, config, items)
}

/// Puts together what workers have, and lets the engine go on that has begun: with all that they
/// leave, such as slivers.
///
/// # Errors
/// [`RefineError`] if the parts do not fit, or an item is not in the mesh.
fn end(
    delegated: Delegated<'_>,
    parts: Vec<Part>,
    common: SharedInput,
    start: &Start,
) -> Result<(Refined, Owners), RefineError> {
    let Whole { mesh, carriers, regions, firsts } = put_together(parts, common, start)?;
    let (asked, candidates, stats) = (Vec::new(), 0, delegated.stats());
    let (thin, slivers) = (None, None);
    let (refused, refused_tets) = (Vec::new(), Vec::new());
    let handed = Handed {
        mesh,
        carriers,
        regions,
        asked,
        refused,
        refused_tets,
        candidates,
        spent: 0,
        thin,
        slivers,
        blocks: Vec::new(),
        stats,
    };
    Ok((delegated.finish(handed)?, Owners(firsts)))
}

/// The work of workers, whichever way they run: `run` is given them, gives them back, and tells of
/// the run.
///
/// # Errors
/// Those of `run`; [`RefineError`] if the domain has no mesh.
fn refine<'a, C: Rules, R>(
    delegated: Delegated<'a>,
    complex: Complex<'a>,
    start: &Start,
    plan: Plan,
    run: impl FnOnce(Vec<DomainNode<'a, C>>) -> Result<Ran<'a, C, R>, RefineError>,
) -> Result<Refining<R>, RefineError> {
    let (workers, common) = begin::<C>(complex, start, plan.layout, plan.config)?;
    let (mut splits, mut parts) = (Splits::default(), Vec::new());
    let Ran { workers, told } = run(workers)?;
    for worker in workers {
        let (mesh, source, _) = worker.into_parts();
        splits.add(&source.splits);
        parts.push(Part::of(mesh));
    }
    let (refined, owners) = end(delegated, parts, common, start)?;
    Ok(Refining { refined, splits, owners, told })
}

/// Refines a domain on simulated processors, from the mesh on that the sequential engine has where
/// rounds would begin ([`Refiner::start`]). Virtual time is that of the processors, from there on.
///
/// # Errors
/// [`RefineError`] if the domain has no mesh, or if the run has not ended properly.
pub fn simulate_domain(
    refiner: &Refiner<'_>,
    domain: &Domain,
    lattice: &Lattice,
    plan: &dyn Fn(usize) -> Plan,
    options: &Options,
) -> Result<SimulatedDomain, RefineError> {
    simulate_domain_as::<Correct>(refiner, domain, lattice, plan, options)
}

/// As [`simulate_domain`], under other rules: a known-bad variant, for checkers.
///
/// # Errors
/// As [`simulate_domain`].
#[doc(hidden)]
pub fn simulate_domain_as<C: Rules>(
    refiner: &Refiner<'_>,
    domain: &Domain,
    lattice: &Lattice,
    plan: impl Fn(usize) -> Plan,
    options: &Options,
) -> Result<SimulatedDomain, RefineError> {
    let delegated = refiner.delegate(domain, lattice)?;
    let (complex, start) = delegated.complex()?;
    let run = |workers| {
        let run = simulate(workers, options).map_err(MeshError::from)?;
        let Simulation { workers, summary, events, .. } = run;
        Ok(Ran { workers, told: (summary, events) })
    };
    let started = start.points.len();
    let done = refine::<C, _>(delegated, complex, &start, plan(started), run)?;
    let Refining { refined, splits, told: (summary, events), .. } = done;
    Ok(SimulatedDomain { refined, splits, started, summary, events })
}

/// Refines a domain on the threads of `parallel`, which share no mesh, as points come, from some
/// vertices for each on ([`Refiner::start`] says otherwise). The mesh depends on the timing. What
/// is at small angles or patches is left to rounds at the end.
///
/// # Errors
/// [`RefineError`] if the domain has no mesh, or if a worker has failed.
pub fn domain_on_threads(
    refiner: &Refiner<'_>,
    domain: &Domain,
    lattice: &Lattice,
    parallel: &Parallel<'_>,
) -> Result<ThreadedDomain, RefineError> {
    let config = parallel.config();
    let wanted = parallel.plan_for(0).workers as usize * START_EACH;
    let delegated = refiner.delegate_to(domain, lattice, wanted)?;
    let (complex, start) = match delegated.complex() {
        Ok(whole) => whole,
        Err(ComplexError::Refine(error)) => return Err(error.into()),
        Err(unfit) => {
            let (refined, owners) = (delegated.go_on()?, Owners::default());
            return Ok(ThreadedDomain { refined, workers: Vec::new(), owners, splits: Err(unfit) });
        }
    };
    let run = |nodes| {
        let (workers, told) = parallel.run_workers(nodes)?.into_iter().unzip();
        Ok(Ran { workers, told })
    };
    let plan = Plan { layout: parallel.plan_for(start.points.len()), config };
    let done = refine::<Correct, _>(delegated, complex, &start, plan, run)?;
    let Refining { refined, splits, owners, told: workers } = done;
    Ok(ThreadedDomain { refined, workers, owners, splits: Ok(splits) })
}
