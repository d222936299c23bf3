//! The driver: recover the boundary, find the regions, split what is over its bounds.

mod bounds;
mod budget;
mod circles;
mod complex;
mod delegated;
mod entered;
mod finish;
mod recovered;

#[doc(hidden)]
pub use circles::{Labelled, Lent, LentTet, Parted, PartedPoint, Parting, Waits, circles_among};
#[doc(hidden)]
pub use delegated::{Asked, Delegated, Handed, Remaining};

use crate::RefineError;
use crate::heed::Heed;
use crate::mesh::bounds::SizeField;
use crate::mesh::item::{Item, Queues};
use crate::outcome::{Reason, RefineStats};
use crate::output::refined::Refined;
use crate::queue::split::{Refinement, Step};
use crate::rounds::{Finished, InsertOrder, Resumed, RoundTimes, Rounds};
use crate::rules::block::Block;
use crate::rules::record::Refusal;
use crate::rules::strategy::Strategy;
use crate::thin::Thin;
use ltbw_core::CancelToken;
use ltbw_core::build::{Observer, Phase, Progress};
use ltbw_core::topology::TetId;
use ltbw_domain::{Domain, Lattice};

/// Transactions between two words to the observer.
const CHECK_EVERY: u64 = 1024;

/// The vertices from which on it refines in rounds: fewer are too few for wide ones.
const START: usize = 4096;
/// The vertices from which on rounds begin with patches, which one thread looks at twice a round.
const START_WITH_PATCHES: usize = 32_768;

/// Degrees below which a dihedral angle makes a sliver, if nothing else was asked for.
const MIN_DIHEDRAL: f64 = 8.0;

/// Features nearer to each other than this many floors are not refined towards each other.
const NEAR: f64 = 16.0;

/// Refines domains.
///
/// ```
/// use ltbw_domain::{Domain, Facet};
/// use ltbw_refine::{RefineOutcome, Refiner};
/// let mut cube = Domain::default();
/// cube.vertices = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
/// let sides =
///     [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
/// cube.facets = sides.iter().map(|corners| Facet::polygon(corners, 0)).collect();
/// let refined = Refiner::new().max_volume(0.01).mesh(&cube)?;
/// assert_eq!(refined.outcome, RefineOutcome::Met);
/// println!("{} tetrahedra", refined.num_tets());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy)]
pub struct Refiner<'a> {
    radius_edge: Option<f64>,
    min_dihedral: f64,
    max_volume: Option<f64>,
    max_edge: Option<f64>,
    field: Option<&'a SizeField<'a>>,
    floor: Option<f64>,
    flat_tolerance: Option<f64>,
    max_points: Option<u64>,
    cancel: Option<&'a CancelToken>,
    observer: Option<&'a dyn Observer>,
    order: InsertOrder,
    start: Option<usize>,
    joint_most: usize,
    strategy: Strategy,
    one_thread: bool,
    smooth: u32,
    count_angles: bool,
}

impl std::fmt::Debug for Refiner<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Refiner")
            .field("radius_edge", &self.radius_edge)
            .field("min_dihedral", &self.min_dihedral)
            .field("max_volume", &self.max_volume)
            .field("max_edge", &self.max_edge)
            .field("field", &self.field.is_some())
            .field("floor", &self.floor)
            .field("flat_tolerance", &self.flat_tolerance)
            .field("max_points", &self.max_points)
            .finish_non_exhaustive()
    }
}

impl Default for Refiner<'_> {
    fn default() -> Self {
        Self {
            radius_edge: Some(2.0),
            min_dihedral: MIN_DIHEDRAL,
            max_volume: None,
            max_edge: None,
            field: None,
            floor: None,
            flat_tolerance: None,
            max_points: None,
            cancel: None,
            observer: None,
            order: InsertOrder::default(),
            start: None,
            joint_most: usize::MAX,
            strategy: Strategy::default(),
            one_thread: false,
            smooth: 0,
            count_angles: false,
        }
    }
}

impl<'a> Refiner<'a> {
    /// Circumradius to shortest edge at most 2, no bound on volumes.
    pub fn new() -> Self {
        Self::default()
    }

    /// Bounds circumradius to shortest edge.
    pub fn radius_edge(mut self, bound: f64) -> Self {
        self.radius_edge = Some(bound);
        self
    }

    /// Leaves circumradius to shortest edge unbounded.
    pub fn any_shape(mut self) -> Self {
        self.radius_edge = None;
        self
    }

    /// Splits tetrahedra with a dihedral angle below this, in degrees, at most 12, when all other
    /// bounds are met, as far as points are found that leave none such and break no bound; 0
    /// leaves them. By default 8. Nothing is done without a bound of shape.
    pub fn min_dihedral(mut self, degrees: f64) -> Self {
        self.min_dihedral = degrees;
        self
    }

    /// Moves vertices inside in this number of sweeps, at most 16, when all bounds are met, each
    /// where the smallest dihedral angle around rises, exactly, and no bound is broken. By default
    /// none.
    pub fn smooth(mut self, sweeps: u32) -> Self {
        self.smooth = sweeps;
        self
    }

    /// Counts tetrahedra by their smallest dihedral angle before slivers are split:
    /// [`RefineStats::before_slivers`], which takes a look at all. The mesh is the same.
    pub fn count_angles(mut self) -> Self {
        self.count_angles = true;
        self
    }

    /// Bounds volumes, in all regions that have no smaller bound of their own.
    pub fn max_volume(mut self, bound: f64) -> Self {
        self.max_volume = Some(bound);
        self
    }

    /// Bounds the length of edges, of all tetrahedra of the domain: exactly, as volumes are.
    pub fn max_edge(mut self, length: f64) -> Self {
        self.max_edge = Some(length);
        self
    }

    /// Asks for a usual edge length at each place, such as [`Sizes`](crate::Sizes) has: the mean of
    /// the edges is within 10 % of it where the boundary is no finer. A tetrahedron may have the
    /// volume of the regular one with edges of 1.18 times the length at its centroid. The function
    /// has to give the same answer for the same point, a positive number: an infinite one asks for
    /// nothing.
    ///
    /// It is asked in the coordinates of the mesh: those of the input less [`Lattice::offset`],
    /// which is zero but for a domain that is small beside its distance from the origin. Whoever
    /// means places of such an input adds the offset of [`Prepared::lattice`], and then calls
    /// [`Refiner::refine`].
    ///
    /// [`Lattice::offset`]: ltbw_domain::Lattice::offset
    /// [`Prepared::lattice`]: ltbw_domain::Prepared::lattice
    pub fn sizing(mut self, field: &'a SizeField<'a>) -> Self {
        self.field = Some(field);
        self
    }

    /// Refines on the calling thread alone, which is then the only one that asks a sizing function.
    /// By default all threads of the pool refine and ask. The mesh is the same.
    pub fn one_thread(mut self) -> Self {
        self.one_thread = true;
        self
    }

    /// Sets the least distance between a new vertex on the boundary and the ends of what it
    /// splits, and the least circumradius that is split; default 2^-20 of the domain's largest
    /// side.
    pub fn floor(mut self, length: f64) -> Self {
        self.floor = Some(length);
        self
    }

    /// Sets the distance within which neighbouring facets are one plane, in the coordinates of the
    /// domain: at most 2^-10 of the diagonal of its box. By default 0, facets are what they are;
    /// but [`Refiner::mesh`] takes what is usual for a surface.
    ///
    /// Facets of one polygon that are coplanar within the tolerance make a *patch*. The edges
    /// inside a patch need not be in the mesh; its vertices and its outline are, exactly, and new
    /// vertices lie exactly on its polygons. Only surfaces that separate have patches: facets that
    /// edges connect to an edge of an odd number of facets stay what they are.
    ///
    /// If the patches cannot be brought into the mesh, the tolerance is 0 after all:
    /// [`RefineStats::flat_tolerance`] says so.
    pub fn flat_tolerance(mut self, length: f64) -> Self {
        self.flat_tolerance = Some(length);
        self
    }

    /// Sets it where nothing was set.
    pub(super) fn or_flat_tolerance(mut self, length: f64) -> Self {
        self.flat_tolerance = self.flat_tolerance.or(Some(length));
        self
    }

    /// Sets the most points to insert. By default a million, 64 for each vertex of the domain and 4
    /// for each tetrahedron of the largest allowed volume that the domain's box could hold (of a
    /// sizing field: the least at the domain's vertices): far more than a domain takes whose
    /// details the lattice resolves.
    pub fn max_points(mut self, count: u64) -> Self {
        self.max_points = Some(count);
        self
    }

    /// Sets the token that cancels the work.
    pub fn cancel(mut self, token: &'a CancelToken) -> Self {
        self.cancel = Some(token);
        self
    }

    /// Sets the observer of progress: points inserted, of an unknown number (given as 0).
    pub fn observer(mut self, observer: &'a dyn Observer) -> Self {
        self.observer = Some(observer);
        self
    }

    /// Sets the order in which the points of a round are inserted: the mesh is the same for all.
    #[doc(hidden)]
    pub fn insert_order(mut self, order: InsertOrder) -> Self {
        self.order = order;
        self
    }

    /// Sets the number of vertices from which on it refines in rounds.
    #[doc(hidden)]
    pub fn start(mut self, vertices: usize) -> Self {
        self.start = Some(vertices);
        self
    }

    /// Sets the most transactions of a joint step: with one nothing is split jointly, for tests of
    /// what follows from that.
    #[doc(hidden)]
    pub fn joint_most(mut self, count: usize) -> Self {
        self.joint_most = count;
        self
    }

    /// Sets the parameters of runs without rounds: another mesh comes of others.
    #[doc(hidden)]
    pub fn strategy(mut self, strategy: Strategy) -> Self {
        let towards = strategy.towards.clamp(0.0, Strategy::MOST);
        self.strategy = Strategy { towards, ..strategy };
        self
    }

    /// Refines a domain whose vertices are on the lattice.
    ///
    /// It has to be one that the geometric check finds no error in: [`Domain::prepare`] makes such
    /// domains.
    ///
    /// # Errors
    /// [`RefineError`] says why there is no mesh of the domain.
    pub fn refine(&self, domain: &Domain, lattice: &Lattice) -> Result<Refined, RefineError> {
        self.delegate(domain, lattice)?.go_on()
    }

    /// Tells the observer how many vertices there are.
    fn tell(&self, phase: Phase, vertices: usize) {
        if let Some(observer) = self.observer {
            observer.progress(Progress { phase, done: vertices as u64, total: None });
        }
    }
}

/// Slivers that are left to others, and the subfaces that bar many.
type SliversLeft = (Vec<Thin>, Vec<Block>);

/// One refinement under way.
pub(super) struct Run<'a> {
    refiner: Refiner<'a>,
    pub(super) refinement: Refinement<'a>,
    pub(super) work: Queues,
    stats: RefineStats,
    steps: u64,
    /// The most points to insert.
    pub(super) most: u64,
    /// Why the work stops early.
    pub(super) stop: Option<Reason>,
    /// The tetrahedra that are over their bounds, if that is known.
    over: Option<Vec<TetId>>,
    /// The rounds on the clock.
    rounds: Vec<RoundTimes>,
}

impl<'a> Run<'a> {
    /// Splits tetrahedra until none is over its bounds, boundary items first; or until there are
    /// this many vertices and no boundary item waits.
    pub(super) fn refine(&mut self, vertices: usize) -> Result<(), RefineError> {
        loop {
            if let Some(item) = self.work.next_boundary() {
                self.step(item)?;
                continue;
            }
            let enough = self.refinement.state.mesh.num_vertices() >= vertices;
            if self.stop.is_some() || enough {
                return Ok(());
            }
            let Some(item) = self.work.next_tet() else { return Ok(()) };
            if let Some((t, v)) = self.work.upcoming() {
                self.refinement.state.fetch(t, v);
            }
            self.step(item)?;
        }
    }

    /// Goes on in rounds, if there is a boundary; what was before took `start_seconds`. Others may
    /// have carried out some of them, and are left slivers, if there are `few` at least: these are
    /// returned.
    fn rounds_from(
        &mut self,
        order: InsertOrder,
        start_seconds: f64,
        resumed: Option<Resumed>,
        few: Option<usize>,
    ) -> Result<Option<SliversLeft>, RefineError> {
        if self.stop.is_some() || self.refinement.bounds.is_none() {
            return Ok(None);
        }
        let refiner = self.refiner;
        let tell = |vertices: usize| refiner.tell(Phase::Refine, vertices);
        let threads = if refiner.one_thread { 1 } else { rayon::current_num_threads() };
        let stats = RefineStats { round_threads: threads, ..self.stats };
        let mut rounds = Rounds::new(&mut self.refinement, order, self.most, stats);
        resumed.into_iter().for_each(|resumed| rounds.resume(resumed));
        few.into_iter().for_each(|few| rounds.leave_slivers(few));
        let Finished { stop, stats, over, times, slivers, blocks } =
            rounds.run_in_pool(refiner.cancel, tell)?;
        (self.stop, self.over) = (stop, Some(over));
        self.rounds.extend(times);
        self.stats = RefineStats { start_seconds, ..stats };
        Ok(slivers.map(|slivers| (slivers, blocks)))
    }

    /// Puts every tetrahedron over its bounds.
    fn put_all(&mut self) {
        let Refinement { state, bounds, inserted, .. } = &mut self.refinement;
        let Some(bounds) = bounds else { return };
        for (t, v) in bounds.over_of(state, state.mesh.tet_ids(), &mut inserted.thin.tets) {
            self.work.put(Item::Tet(t, v), bounds.excess_of(state, t));
        }
    }

    /// One transaction.
    pub(super) fn step(&mut self, item: Item) -> Result<(), RefineError> {
        self.steps += 1;
        // One cavity may be nearly the whole mesh: the token is asked before each.
        if self.steps.is_multiple_of(CHECK_EVERY) || self.heed().is_cancelled() {
            self.look()?;
        }
        let stats = &mut self.stats;
        if self.refinement.inserted.points.total() >= self.most {
            self.stop = self.stop.or(Some(Reason::Budget));
        }
        if let Some(reason) = self.stop {
            self.refinement.record.refused.insert(item, Refusal::final_for(reason));
            return Ok(());
        }
        match self.refinement.split(item, &mut self.work) {
            Step::Inserted | Step::Gone => {}
            Step::Deferred => stats.deferred += 1,
            Step::Refused(_) => stats.refused += 1,
            // `Open` refuses nothing: the mesh is full.
            Step::SetBack(_) => self.stop = Some(Reason::Budget),
        }
        Ok(())
    }

    pub(super) fn heed(&self) -> Heed<'a> {
        Heed(self.refiner.cancel)
    }

    /// Tells the observer, asks the token.
    #[cold]
    pub(super) fn look(&mut self) -> Result<(), RefineError> {
        let is_whole = self.refinement.bounds.is_some();
        let phase = if is_whole { Phase::Refine } else { Phase::Recover };
        self.refiner.tell(phase, self.refinement.state.mesh.num_vertices());
        if self.heed().is_cancelled() {
            if self.refinement.bounds.is_none() {
                return Err(RefineError::Cancelled);
            }
            self.stop = Some(Reason::Cancelled);
        }
        Ok(())
    }
}
