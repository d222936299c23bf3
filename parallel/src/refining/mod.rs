//! The paper's mode: bad tetrahedra refined on many processors at once, without rounds.
//!
//! Every worker's source is the list of its own bad tetrahedra (`bad_tets`). An operation begins at
//! the tetrahedron, at its owner, without a walk; its point is a new vertex, which that worker
//! names; and whatever the protocol sets back asks its source again before it goes on: if the
//! tetrahedron is gone, so is the operation. While an operation collects its closure the
//! tetrahedron is locked for it, so that the verdict holds at the commit. New tetrahedra are
//! reported to the source of the worker that has them. It ends when nobody has a bad one.
//!
//! Every insertion is one of the sequential algorithm at the moment of its commit: its tetrahedron
//! stands, so that the new point has no vertex within its circumradius. Hence no edge is shorter
//! than the shortest one before or than what the bounds ask for, and the run ends. Which points
//! are made depends on the timing: the mesh is a Delaunay mesh that keeps the bounds, not the same
//! one twice.
//!
//! With points alone there are no boundary items (`domain` has them): the box of the points is the
//! boundary, and a tetrahedron whose circumcentre lies outside it stays as it is.

mod bad_tets;
mod domain;
mod flags;
mod news;
mod rounds;
mod shape;

pub use bad_tets::BadTets;
pub use domain::{
    BadItems, DomainMesh, DomainNode, DomainPatch, DomainPiece, DomainPoint, RefinedDomain,
    SimulatedDomain, Splits, simulate_domain,
};
pub use news::{
    DomainNews, KeysTold, PartEnd, ProbeId, Proposal, Sums, WireClosure, WireCorner, WireItem,
};
pub use rounds::{
    Ending, Owners, RoundFigures, RoundNode, Rounds, SENT, SimulatedRounds, Step, TAKEN,
    ThreadedRounds, Tree, is_quiet, rounds_by, rounds_on_threads, simulate_rounds, unkilled,
};

use crate::mesh::{Layout, LocalMesh, Prepared, SharedInput, gather};
use crate::protocol::{Config, Correct, Rules, Worker};
use crate::simulate::{MeshError, Meshed, Options, Simulation, simulate};
use crate::threads::{Parallel, Run, RunError};
use ltbw_core::order::bounding_box;
use ltbw_core::{BuildError, CancelToken};
use ltbw_domain::vector::dot;
use ltbw_exact::{Mode, Point, PointSet};
use shape::Shape;
use std::time::Instant;

/// Steps of the lattice of new points in the longest side of the box: about 2^40.
const LATTICE_BITS: i32 = 40;
/// The smallest step: what is a multiple of it is in the exactness window.
const LEAST_STEP: f64 = 1e-40;

/// The bounds of a refined mesh, and the box that centres must lie in.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    max_volume: f64,
    max_radius_edge: f64,
    low: Point,
    high: Point,
    /// Coordinates of new points are multiples of this power of two.
    step: f64,
}

/// Why a set of points cannot be refined.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RefineError {
    /// The bounds cannot be kept.
    #[error("cannot keep a volume of at most {volume} and a ratio of at most {ratio}")]
    Bounds {
        /// The largest volume asked for.
        volume: f64,
        /// The largest circumradius to shortest edge asked for.
        ratio: f64,
    },
    /// Coordinates are too large or too small to make new points as they are.
    #[error("the coordinates are out of the range in which new points are made")]
    Range,
    /// The points have no mesh.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The domain has no mesh.
    #[error(transparent)]
    Domain(#[from] ltbw_domain::refine::RefineError),
    /// The domain has no mesh to start with, or one that only the rounds can refine.
    #[error(transparent)]
    Complex(#[from] ltbw_domain::refine::ComplexError),
    /// Under the paper's rule operations have no age: those that wait for a boundary item would
    /// ask for its locks for ever, and the item would get none.
    #[error("the paper's rule for locks has no ages, which boundary items need")]
    Ageless,
    /// The threads have not ended properly.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The simulated processors have not ended properly.
    #[error(transparent)]
    Simulation(#[from] MeshError),
}

impl Bounds {
    /// Bounds that everything keeps.
    const NONE: Self = Self {
        max_volume: f64::INFINITY,
        max_radius_edge: f64::INFINITY,
        low: [0.0; 3],
        high: [0.0; 3],
        step: 1.0,
    };

    /// Bounds for a mesh of `set`: the largest volume, and the largest circumradius to shortest
    /// edge, above 1.02.
    ///
    /// # Errors
    /// [`RefineError`] if no refinement can keep them, or if new points might not be exact.
    pub fn new(set: &PointSet, max_volume: f64, max_radius_edge: f64) -> Result<Self, RefineError> {
        // A point may lie a hundredth of the radius off the centre: with a ratio near 1 edges would
        // get shorter.
        if !(max_volume > 0.0 && max_radius_edge > 1.02) {
            return Err(RefineError::Bounds { volume: max_volume, ratio: max_radius_edge });
        }
        let points = set.kernel_points();
        let (low, high) = bounding_box(&*points);
        let side = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        let largest = low.iter().chain(&high).map(|c| c.abs()).fold(0.0, f64::max);
        let power = f64::from_bits(side.to_bits() & 0x7ff0_0000_0000_0000);
        let step = power * 2f64.powi(-LATTICE_BITS);
        // Multiples of the step must be numbers of 53 bits.
        let exact = largest < step * 2f64.powi(52);
        if set.mode() != Mode::Normal || !(step > LEAST_STEP && side.is_finite()) || !exact {
            return Err(RefineError::Range);
        }
        Ok(Self { max_volume, max_radius_edge, low, high, step })
    }

    /// Does a tetrahedron with these corners keep the bounds, or has it its centre outside?
    #[must_use]
    pub fn keeps(&self, corners: [Point; 4]) -> bool {
        self.point_of(&Shape::of(corners)).is_none()
    }

    /// The circumradius of a bad tetrahedron and the point that is to break it: its circumcentre on
    /// the lattice. `None` if it keeps the bounds or its centre is not inside the box.
    fn point_of(&self, shape: &Shape) -> Option<(f64, Point)> {
        let Shape { volume, centre, radius, shortest } = *shape;
        let is_bad = volume > self.max_volume || radius > self.max_radius_edge * shortest;
        if !is_bad {
            return None;
        }
        let p = centre.map(|c| (c / self.step).round() * self.step);
        let is_inside = (0..3).all(|k| self.low[k] < p[k] && p[k] < self.high[k]);
        let off = [0, 1, 2].map(|k| p[k] - centre[k]);
        // Also false for what is not a number. So far from the centre it is no centre any more.
        let is_near = dot(&off, &off) < 1e-4 * radius * radius;
        (is_inside && is_near).then_some((radius, p))
    }
}

/// A worker that refines.
pub type Node<C> = Worker<LocalMesh, BadTets, C>;

/// Workers with all points of `set` in their submeshes, and their bad tetrahedra to refine.
///
/// # Errors
/// [`RefineError::Build`] if the points have no mesh.
pub fn prepare<C: Rules>(
    set: &PointSet,
    bounds: Bounds,
    layout: &Layout,
    config: Config,
) -> Result<(Vec<Node<C>>, SharedInput), RefineError> {
    prepare_unless(None, set, bounds, layout, config)
}

/// As [`prepare`]; the token may end it at any time.
fn prepare_unless<C: Rules>(
    cancel: Option<&CancelToken>,
    set: &PointSet,
    bounds: Bounds,
    layout: &Layout,
    config: Config,
) -> Result<(Vec<Node<C>>, SharedInput), RefineError> {
    let Prepared { workers, common, .. } = layout.prepare_all(set, None, cancel)?;
    let config = Config { workers: layout.workers, ..config };
    let workers = workers.into_iter().map(|(directory, mesh, _)| {
        let source = BadTets::new(directory.me(), bounds, &mesh);
        Worker::new(config, directory, mesh, source)
    });
    Ok((workers.collect(), common))
}

/// Refines the mesh of `set` on simulated processors.
///
/// # Errors
/// [`RefineError`] if the points have no mesh, or the run has not ended properly.
pub fn simulate_refined<C: Rules>(
    set: &PointSet,
    bounds: Bounds,
    layout: &Layout,
    config: Config,
    options: &Options,
) -> Result<Meshed, RefineError> {
    let (workers, common) = prepare::<C>(set, bounds, layout, config)?;
    let run = simulate(workers, options).map_err(MeshError::from)?;
    let Simulation { workers, summary, events, trace } = run;
    let meshes = workers.into_iter().map(|worker| worker.into_parts().0).collect();
    let gathered = gather(meshes, common).map_err(MeshError::from)?;
    Ok(Meshed { gathered, summary, events, trace })
}

/// Refines the mesh of `set` on the threads of `parallel`. Cancelled, it is a Delaunay mesh of the
/// points made so far.
///
/// # Errors
/// [`RefineError`] if the points have no mesh, or a worker has failed, or if it is cancelled while
/// there is no mesh of the points given.
pub fn refine_on_threads(
    set: &PointSet,
    bounds: Bounds,
    parallel: &Parallel<'_>,
) -> Result<Run, RefineError> {
    let clock = Instant::now();
    let layout = parallel.plan_for(set.len());
    let config = parallel.config();
    let (workers, common) =
        prepare_unless::<Correct>(parallel.token(), set, bounds, &layout, config)?;
    let points = set.len() as u64;
    let parts = parallel.run_nodes(workers, common, [points, points], clock)?;
    Ok(parallel.gather(parts)?)
}
