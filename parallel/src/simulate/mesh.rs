//! The real mesh on simulated processors.

use super::{Options, Simulation, SimulationError, simulate};
use crate::mesh::{GatherError, Gathered, Layout, Ownership, gather};
use crate::metrics::{Summary, Trace};
use crate::protocol::{Config, Correct, Rules, Worker};
use ltbw_core::BuildError;
use ltbw_exact::PointSet;

/// A mesh built on simulated processors.
#[derive(Debug)]
pub struct Meshed {
    /// The mesh: the one of its points, as always.
    pub gathered: Gathered,
    /// The figures of the processors' time, from when the coarse mesh is distributed.
    pub summary: Summary,
    /// Events of the simulation.
    pub events: u64,
    /// The timeline, if one was asked for.
    pub trace: Option<Trace>,
}

/// Why there is no mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The points have no mesh.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The run did not end properly.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The submeshes do not fit together.
    #[error(transparent)]
    Gather(#[from] GatherError),
}

/// Meshes `set` on simulated processors, one for each worker of `layout`.
///
/// # Errors
///
/// [`MeshError`].
pub fn simulate_mesh(
    set: &PointSet,
    layout: &Layout,
    config: Config,
    options: &Options,
) -> Result<Meshed, MeshError> {
    simulate_as::<Correct>(set, layout, config, options)
}

/// [`simulate_mesh`] with other rules: for checkers that must find a defect.
///
/// # Errors
///
/// [`MeshError`].
pub fn simulate_as<C: Rules>(
    set: &PointSet,
    layout: &Layout,
    config: Config,
    options: &Options,
) -> Result<Meshed, MeshError> {
    if layout.ownership != Ownership::Block
        && (options.storm.is_some() || options.balance.is_some())
    {
        return Err(SimulationError::Options(Ownership::STAYS.to_owned()).into());
    }
    let prepared = layout.distribute(set)?;
    let config = Config { workers: layout.workers, ..config };
    let workers = prepared
        .workers
        .into_iter()
        .map(|(directory, mesh, field)| Worker::<_, _, C>::new(config, directory, mesh, field))
        .collect();
    let Simulation { workers, summary, events, trace } = simulate(workers, options)?;
    let meshes = workers.into_iter().map(|worker| worker.into_parts().0).collect();
    let gathered = gather(meshes, prepared.common)?;
    Ok(Meshed { gathered, summary, events, trace })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::WorkerError;
    use crate::mesh::LocalMesh;
    use crate::protocol::SubmeshError;
    use ltbw_generate::{PointKind, generate};

    /// A run whose workers have few names left ends with an error that says so.
    #[test]
    fn a_run_ends_where_names_do() {
        let set = PointSet::new(generate(PointKind::Uniform, 400, 1)).expect("finite points");
        let run = |left: Option<u32>| {
            let layout = Layout { sample: 10, ..Layout::new(set.len(), 3) };
            let workers = layout.distribute(&set).expect("a start").workers;
            let node = |(directory, mut mesh, field): (_, LocalMesh, _)| {
                left.into_iter().for_each(|left| mesh.use_up_names(left));
                Worker::<_, _, Correct>::new(Config::new(3), directory, mesh, field)
            };
            simulate(workers.into_iter().map(node).collect(), &Options::default()).map(|_| ())
        };
        assert_eq!(run(None), Ok(()));
        for left in [0, 1, 50] {
            let end = run(Some(left));
            let error = SubmeshError::NoNames { limit: u32::MAX >> 1 };
            let is = |end: &SimulationError| {
                matches!(end, SimulationError::Worker(WorkerError::Submesh { error: own, .. })
                    if *own == error)
            };
            assert!(end.as_ref().is_err_and(is), "{left} left: {end:?}");
        }
    }
}
