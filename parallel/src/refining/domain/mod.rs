//! The paper's mode on domains: bad tetrahedra and the boundary split on many processors at once.
//!
//! The sequential engine brings the boundary into the mesh; then workers own parts of it. Every
//! worker's source is the list of its own bad tetrahedra, and of boundary items that others have
//! asked for (`list`). An operation begins at the tetrahedron, or at one that has the boundary
//! item, at its owner. When its closure is locked its home takes the *verdict*, which is that of
//! the rounds (`Survey` of `ltbw_refine`), over what the owners have told of the tetrahedra at
//! which something may be boundary (`closure`); which faces and edges are, the carriers of their
//! vertices tell. A point inside a region that encroaches one, and a point of the boundary that
//! would take another one out of the mesh, is not inserted: the item goes first (of several the
//! nearest), in the list of the owner of a tetrahedron at it, and the other is asked again
//! afterwards. So everything that was in the mesh at the start stays in it, at any time.
//!
//! An item that waits for one of the same worker is asked again when that is done. A tetrahedron
//! that waits for another worker's item hears from it when that has ended; a boundary item begins
//! again at once, and goes to that worker for its locks. An item that cannot be split bars what it
//! is in the way of.
//!
//! Which points are made depends on the timing: the mesh conforms to the domain and keeps the
//! bounds, but it is not the same one twice.

mod bytes;
mod carriers;
mod chosen;
mod closure;
mod describe;
mod list;
mod mesh;
mod regions;
mod values;

pub(super) use describe::is_near;
pub use list::{BadItems, Splits};
pub use mesh::DomainMesh;
pub use values::{DomainCargo, DomainPatch, DomainPiece, DomainPoint};

use super::RefineError;
use super::whole::{Owners, Whole, put_together};
use crate::mesh::{Blocks, Layout, Prepared, SharedInput, VertexName, given};
use crate::metrics::Summary;
use crate::protocol::{BlockId, Config, Correct, Rule, Rules, Source, Worker, WorkerId};
use crate::simulate::{MeshError, Options, Simulation, simulate};
use crate::threads::{Parallel, WorkerStats};
use ltbw_core::order::{Curve, bounding_box};
use ltbw_domain::{Domain, Lattice};
use ltbw_exact::{Mode, Point, PointSet};
use ltbw_refine::{Carrier, Complex, ComplexError, Delegated, Handed, Refined, Refiner, Start};
use rustc_hash::FxHashMap;
use std::sync::Arc;

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

/// A worker that refines a domain.
pub type DomainNode<'c, C> = Worker<DomainMesh<'c>, BadItems, C>;

/// A domain that workers have refined, with their figures and what their run has told.
struct Refining<R> {
    refined: Refined,
    splits: Splits,
    owners: Owners,
    told: R,
}

/// The work of workers, whichever way they run: `run` is given them, gives them back, and tells of
/// the run. What they leave, such as slivers, the engine does that has begun.
///
/// # Errors
/// Those of `run`; [`RefineError`] if the domain has no mesh.
fn refine<'a, C: Rules, R>(
    delegated: Delegated<'a>,
    (complex, start): (Complex<'a>, &Start),
    (layout, config): (Layout, Config),
    run: impl FnOnce(Vec<DomainNode<'a, C>>) -> Result<(Vec<DomainNode<'a, C>>, R), RefineError>,
) -> Result<Refining<R>, RefineError> {
    // The budget is shared out beforehand: workers do not know what others have made.
    let is_made = |c: &&Carrier| !matches!(c, Carrier::Corner(_));
    let left = start.most.saturating_sub(start.carriers.iter().filter(is_made).count() as u64);
    let share = left / u64::from(layout.workers);
    let items = |me, mesh: &mut DomainMesh<'_>| {
        mesh.let_blocks_move();
        BadItems::new(me, share, mesh)
    };
    let (workers, common) = prepare::<_, C>(complex, start, &layout, config, items)?;
    let (mut splits, mut parts) = (Splits::default(), Vec::new());
    let (workers, told) = run(workers)?;
    for worker in workers {
        let (mesh, source, _) = worker.into_parts();
        splits.add(&source.splits);
        parts.push(mesh);
    }
    let Whole { mesh, carriers, regions, firsts } = put_together(parts, common, start)?;
    let (asked, candidates, thin, stats) = (Vec::new(), 0, None, delegated.stats());
    let handed = Handed { mesh, carriers, regions, asked, candidates, thin, stats };
    Ok(Refining { refined: delegated.finish(handed)?, splits, owners: Owners(firsts), told })
}

/// Refines a domain on simulated processors, from the mesh on that the sequential engine has where
/// rounds would begin ([`Refiner::start`]). Virtual time is that of the processors, from there on.
///
/// # Errors
/// [`RefineError`] if the domain has no mesh, or one that only the rounds can refine, or if the run
/// has not ended properly.
pub fn simulate_domain<C: Rules>(
    refiner: &Refiner<'_>,
    (domain, lattice): (&Domain, &Lattice),
    layout: impl Fn(usize) -> (Layout, Config),
    options: &Options,
) -> Result<SimulatedDomain, RefineError> {
    // Nothing depends on the number of points.
    if layout(0).1.rule == Rule::Paper {
        return Err(RefineError::Ageless);
    }
    let mut delegated = refiner.delegate(domain, lattice)?;
    let (complex, start) = delegated.complex_without_circles()?;
    let run = |workers| {
        let run = simulate(workers, options).map_err(MeshError::from)?;
        let Simulation { workers, summary, events, .. } = run;
        Ok((workers, (summary, events)))
    };
    let started = start.points.len();
    let done = refine::<C, _>(delegated, (complex, &start), layout(started), run)?;
    let Refining { refined, splits, told: (summary, events), .. } = done;
    Ok(SimulatedDomain { refined, splits, started, summary, events })
}

/// Refines a domain on the threads of `parallel`, which share no mesh, as points come. The mesh
/// depends on the timing. A domain that only rounds can refine is refined by these.
///
/// # Errors
/// [`RefineError`] if the domain has no mesh, or if a worker has failed.
pub fn domain_on_threads(
    refiner: &Refiner<'_>,
    (domain, lattice): (&Domain, &Lattice),
    parallel: &Parallel<'_>,
) -> Result<ThreadedDomain, RefineError> {
    let config = parallel.config();
    if config.rule == Rule::Paper {
        return Err(RefineError::Ageless);
    }
    let mut delegated = refiner.delegate(domain, lattice)?;
    let (complex, start) = match delegated.complex_without_circles() {
        Ok(whole) => whole,
        Err(unfit) => {
            let (refined, owners) = (delegated.go_on()?, Owners::default());
            return Ok(ThreadedDomain { refined, workers: Vec::new(), owners, splits: Err(unfit) });
        }
    };
    let run = |nodes| Ok(parallel.run_workers(nodes)?.into_iter().unzip());
    let layout = (parallel.plan_for(start.points.len()), config);
    let done = refine::<Correct, _>(delegated, (complex, &start), layout, run)?;
    let Refining { refined, splits, owners, told: workers } = done;
    Ok(ThreadedDomain { refined, workers, owners, splits: Ok(splits) })
}

/// Workers, and all that they share.
type Begun<'c, Q, C> = (Vec<Worker<DomainMesh<'c>, Q, C>>, SharedInput);

/// Places whose weights tell where a worker's part of a domain ends, a worker.
const PLACES: usize = 4096;

/// The curve that is cut into the workers' parts: of some the one that divides the fewest
/// tetrahedra.
///
/// Domains end at halves and quarters of their box. If cells of the curve meet there, all vertices
/// on such an end may be in cells outside the domain, and so with one worker: of two unit cubes
/// side by side it had twice the others' work. The other curves have a larger box.
fn curve_for(start: &Start, weights: &[(Point, u64)], layout: &Layout) -> Curve {
    let (low, high) = bounding_box(&start.points);
    let larger = |part: f64| [0, 1, 2].map(|k| high[k] + (high[k] - low[k]) * part);
    let divided = |curve: &Curve| {
        let blocks = Blocks::weighted(*curve, &[], weights, layout.workers);
        let parts: Vec<BlockId> = start.points.iter().map(|p| blocks.of_point(p)).collect();
        let is_divided =
            |v: &[u32; 4]| v.iter().any(|&k| parts[k as usize] != parts[v[0] as usize]);
        start.tets.iter().filter(|(v, _)| is_divided(v)).count()
    };
    let curves = [0.0, 1.0 / 1024.0, 1.0 / 16.0].map(|part| Curve::of_box(low, larger(part)));
    curves.into_iter().min_by_key(divided).unwrap_or(curves[0])
}

/// Workers with parts of the mesh at the start, each with the source that it is given for its part.
pub(super) fn prepare<'c, Q: Source<DomainMesh<'c>>, C: Rules>(
    complex: Complex<'c>,
    start: &Start,
    layout: &Layout,
    config: Config,
    source: impl Fn(WorkerId, &mut DomainMesh<'c>) -> Q,
) -> Result<Begun<'c, Q, C>, RefineError> {
    let set = PointSet::new(start.points.clone()).map_err(|_| RefineError::Range)?;
    // The coordinates at the start are those that the kernel computes with.
    if set.mode() != Mode::Normal {
        return Err(RefineError::Range);
    }
    // One worker has all of the work.
    let weights = (layout.workers > 1)
        .then(|| start.weights(&complex, PLACES.saturating_mul(layout.workers as usize)));
    let cut = weights.as_ref().map(|weights| (curve_for(start, weights, layout), &weights[..]));
    let Prepared { workers, mut common, .. } = layout.prepare_all(&set, cut)?;
    common.mode = start.mode;
    let config = Config { workers: layout.workers, ..config };
    let complex = Arc::new(complex);
    let regions: FxHashMap<[u32; 4], u32> = start.tets.iter().copied().collect();
    let number = |name: VertexName| given(name).map(|place| common.numbers[place as usize - 1]);
    let carrier = |name| number(name).map_or(Carrier::Free, |k| start.carriers[k as usize]);
    let region = |names: [VertexName; 4]| {
        let mut corners = names.map(|name| number(name).unwrap_or(u32::MAX));
        corners.sort_unstable();
        regions.get(&corners).copied().unwrap_or_default()
    };
    let workers = workers.into_iter().map(|(directory, mesh, _)| {
        let (me, complex) = (directory.me(), Arc::clone(&complex));
        let mut mesh = DomainMesh::new(mesh, complex, me, carrier, region);
        // The first one receives all others in the end.
        let parts = if me == WorkerId::default() { 1 } else { layout.workers };
        mesh.expect_tets(start.expected_of(parts));
        let source = source(me, &mut mesh);
        Worker::new(config, directory, mesh, source)
    });
    Ok((workers.collect(), common))
}
