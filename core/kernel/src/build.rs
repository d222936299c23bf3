//! Building a mesh of a point set: order, first tetrahedron, insertion of the rest.

use crate::PredicateStats;
use crate::arena::{NoMemory, ask_for};
use crate::cavity::{Admission, AdmitAll, Setback};
use crate::geometry::Geometry;
use crate::mesh::{Corner, Duplicate, Mesh, Placed, Vertex};
use crate::order::{bounding_box, brio_hilbert};
use crate::sync::CancelToken;
use crate::topology::MAX_TETS;
use ltbw_exact::points::Mode;
use ltbw_exact::predicates::{Sign, cmp_xyz, collinear, orient3d};
use ltbw_exact::{Point, PointSet};
use std::time::Instant;

/// Insertions between two looks at the cancel token, the budget and the observer.
const CHECK_EVERY: usize = 1024;

/// Growth of the mesh, in tetrahedra, after which they are looked at earlier: a point may have
/// as many new ones as there are points.
const CHECK_GROWTH: usize = 100_000;

/// A stage of long work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Phase {
    /// Points are put in order, and the work of several threads is prepared.
    Order,
    /// Given points are inserted.
    Insert,
    /// The parts of several threads are put together.
    Gather,
    /// The boundary of a domain is brought into the mesh.
    Recover,
    /// Tetrahedra over a bound are split.
    Refine,
}

/// The state of long work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The stage.
    pub phase: Phase,
    /// Points in the mesh.
    pub done: u64,
    /// Points that the mesh will have, where that is known.
    pub total: Option<u64>,
}

/// Watches long work, from the calling thread. The builder of this crate calls it at least every
/// 1024 points and, in between, when the mesh has grown by 100,000 tetrahedra; that of `ltbw` ten
/// times a second at most. A closure will do:
///
/// ```
/// use ltbw_core::{Builder, Progress};
/// use ltbw_exact::PointSet;
/// let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
/// let show = |p: Progress| println!("{} of {:?} points", p.done, p.total);
/// let built = Builder::new().observer(&show).build(&PointSet::new(cube)?)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Observer: Sync {
    /// Takes a report.
    fn progress(&self, progress: Progress);
}

impl<F: Fn(Progress) + Sync> Observer for F {
    fn progress(&self, progress: Progress) {
        self(progress);
    }
}

/// Limits on the work. The default has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Budget {
    /// Insert at most this many points (the first four are always inserted).
    pub max_points: Option<u64>,
    /// Insert no more points when the mesh has more tetrahedra than this.
    pub max_tets: Option<u64>,
}

/// In which order points are inserted. It decides the speed, never the mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Order {
    /// Biased randomized rounds, along a Hilbert curve in each.
    #[default]
    Brio,
    /// As the points are given.
    Input,
}

/// The outcome of a build: whether all points are in the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Outcome {
    /// The mesh has all points.
    Complete,
    /// The cancel token was set; the mesh has the points inserted before.
    Cancelled,
    /// The budget is exhausted; the mesh has the points inserted before.
    Budget,
    /// The mesh would exceed the limit of 2^30 - 1 tetrahedra, hull ghosts included; it has the
    /// points inserted before.
    TooManyTets,
}

/// Why there is no mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// Fewer than four distinct points.
    #[error("{distinct} distinct points: a mesh in dimension 3 needs at least 4")]
    TooFewPoints {
        /// Number of distinct points.
        distinct: usize,
    },
    /// All points lie on one line.
    #[error("the {distinct} distinct points lie on one line (dimension 1 instead of 3)")]
    Collinear {
        /// Number of distinct points.
        distinct: usize,
    },
    /// All points lie in one plane.
    #[error("the {distinct} distinct points lie in one plane (dimension 2 instead of 3)")]
    Coplanar {
        /// Number of distinct points.
        distinct: usize,
    },
    /// Cancelled before there was a first tetrahedron.
    #[error("cancelled before the first tetrahedron")]
    Cancelled,
    /// The system refuses the memory that the mesh is going to need.
    #[error(transparent)]
    Memory(#[from] NoMemory),
}

/// Figures of one build.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Stats {
    /// Seconds spent on the insertion order.
    pub order_seconds: f64,
    /// Seconds spent on insertion.
    pub insert_seconds: f64,
    /// Predicate calls.
    pub predicates: PredicateStats,
}

/// A mesh and how it came about.
#[derive(Debug)]
pub struct Built {
    /// The mesh: of all points if `outcome` is [`Outcome::Complete`].
    pub mesh: Mesh,
    /// The outcome: whether all points are in the mesh.
    pub outcome: Outcome,
    /// Figures of the build.
    pub stats: Stats,
    /// Duplicates met, by input indices, ascending.
    pub duplicates: Vec<Duplicate>,
}

/// Builds the Delaunay mesh of a point set.
///
/// ```
/// use ltbw_core::Builder;
/// use ltbw_exact::PointSet;
/// let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
/// let built = Builder::new().build(&PointSet::new(cube)?)?;
/// assert_eq!(built.mesh.num_hull_faces(), 12);
/// println!("{} tetrahedra, {}", built.mesh.num_tets(), built.mesh.hash()?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Default)]
pub struct Builder<'a> {
    order: Order,
    budget: Budget,
    cancel: Option<&'a CancelToken>,
    observer: Option<&'a dyn Observer>,
}

impl std::fmt::Debug for Builder<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Builder")
            .field("order", &self.order)
            .field("budget", &self.budget)
            .field("cancel", &self.cancel)
            .field("observer", &self.observer.is_some())
            .finish()
    }
}

impl<'a> Builder<'a> {
    /// A builder with the default order and no limits.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the insertion order.
    pub fn order(mut self, order: Order) -> Self {
        self.order = order;
        self
    }

    /// Sets limits on the work.
    pub fn budget(mut self, budget: Budget) -> Self {
        self.budget = budget;
        self
    }

    /// Sets the token that cancels the work.
    pub fn cancel(mut self, token: &'a CancelToken) -> Self {
        self.cancel = Some(token);
        self
    }

    /// Sets the observer of progress.
    pub fn observer(mut self, observer: &'a dyn Observer) -> Self {
        self.observer = Some(observer);
        self
    }

    /// Builds the mesh.
    ///
    /// Cost: expected O(n log n) time for points without large degenerate cavities; about 370
    /// bytes a point, beside the input, for uniform points.
    ///
    /// A build that stops early has the valid mesh of the points inserted before, and
    /// [`Built::outcome`] says why.
    ///
    /// # Errors
    /// [`BuildError`] says why there is no first tetrahedron. Memory is asked for before the work,
    /// as much as uniform points need; where a limit refuses more later on, the process is aborted.
    pub fn build(&self, set: &PointSet) -> Result<Built, BuildError> {
        let clock = Instant::now();
        let points = set.kernel_points();
        let mut order = self.order_of(&points);
        let order_seconds = clock.elapsed().as_secs_f64();
        if self.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        let clock = Instant::now();
        let corners = first_tet(&points, &mut order)?;
        let (low, high) = bounding_box(&*points);
        let wide = set.mode() == Mode::Wide;
        // Uniform points have 6.77 tetrahedra each. Pages that stay unused cost nothing.
        let tets = (7 * points.len() + 64).min(MAX_TETS);
        ask_for(points.len(), tets)?;
        let geometry = Geometry::new(low, high, wide, points.len(), tets);
        let mut mesh = Mesh::start(geometry, set.mode(), corners, tets);
        mesh.next_number = set.len() as Vertex;
        let outcome = self.insert_all(&mut mesh, &points, &order, &mut AdmitAll);
        for duplicate in &mut mesh.duplicates {
            duplicate.kept = mesh.numbers[duplicate.kept as usize];
        }
        mesh.duplicates.sort_unstable();
        Ok(Built {
            outcome,
            stats: Stats {
                order_seconds,
                insert_seconds: clock.elapsed().as_secs_f64(),
                predicates: mesh.predicate_stats(),
            },
            duplicates: mesh.duplicates.clone(),
            mesh,
        })
    }

    fn order_of(&self, points: &[Point]) -> Vec<u32> {
        match self.order {
            Order::Brio => brio_hilbert(points),
            Order::Input => (0..points.len() as u32).collect(),
        }
    }

    /// The points, of `count`, that the budget allows: it always allows four.
    #[doc(hidden)]
    pub fn allowed(&self, count: usize) -> usize {
        self.budget.max_points.map_or(count, |most| count.min(most.max(4) as usize))
    }

    /// The input indices of the points that the budget of points allows, in the order of their
    /// insertion; `None` if it allows all.
    ///
    /// # Errors
    /// As [`Builder::build`]: there is no first tetrahedron.
    #[doc(hidden)]
    pub fn allowed_points(&self, set: &PointSet) -> Result<Option<Vec<u32>>, BuildError> {
        let most = self.allowed(set.len());
        if most == set.len() {
            return Ok(None);
        }
        let points = set.kernel_points();
        let mut order = self.order_of(&points);
        first_tet(&points, &mut order)?;
        order.truncate(most);
        Ok(Some(order))
    }

    /// Inserts `order[4..]`. Meanwhile the kept ones of duplicates are kernel vertices.
    fn insert_all<A: Admission>(
        &self,
        mesh: &mut Mesh,
        points: &[Point],
        order: &[u32],
        admission: &mut A,
    ) -> Outcome {
        let most = self.allowed(order.len()) as u64;
        let mut batch = Vec::with_capacity(CHECK_EVERY);
        for (start, numbers) in (0..).step_by(CHECK_EVERY).zip(order.chunks(CHECK_EVERY)) {
            let mut next_look = match self.look(mesh, start, most) {
                Ok(next) => next,
                Err(outcome) => return outcome,
            };
            // Points lie anywhere in memory: fetched together, their cache misses overlap.
            batch.clear();
            batch.extend(numbers.iter().map(|&i| points[i as usize]));
            for ((k, &i), &p) in (start..).zip(numbers).zip(&batch) {
                if k < 4 {
                    continue;
                }
                if k >= most {
                    self.tell(most, most);
                    return Outcome::Budget;
                }
                if mesh.num_tets() > next_look {
                    next_look = match self.look(mesh, k, most) {
                        Ok(next) => next,
                        Err(outcome) => return outcome,
                    };
                }
                if let Err(Setback::Full | Setback::Refused(_)) = insert_next(mesh, i, p, admission)
                {
                    return Outcome::TooManyTets;
                }
            }
        }
        self.tell(most, most);
        Outcome::Complete
    }

    fn tell(&self, done: u64, total: u64) {
        if let Some(observer) = self.observer {
            observer.progress(Progress { phase: Phase::Insert, done, total: Some(total) });
        }
    }

    /// Looks at the observer, the cancel token and the budget after `done` insertions: how many
    /// tetrahedra the mesh may have until the next look, or why to stop.
    #[cold]
    fn look(&self, mesh: &Mesh, done: u64, total: u64) -> Result<usize, Outcome> {
        if done > 0 {
            self.tell(done, total);
            if self.is_cancelled() {
                return Err(Outcome::Cancelled);
            }
        }
        let tets = mesh.num_tets();
        let most = self.budget.max_tets.map_or(usize::MAX, |m| m.try_into().unwrap_or(usize::MAX));
        if done > 0 && tets > most {
            return Err(Outcome::Budget);
        }
        Ok(most.min(tets + CHECK_GROWTH))
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(CancelToken::is_cancelled)
    }
}

#[inline(always)]
fn insert_next<A: Admission>(
    mesh: &mut Mesh,
    number: u32,
    p: Point,
    admission: &mut A,
) -> Result<(), Setback> {
    if let Placed::At(v) = mesh.place(p, number, admission)? {
        let kept = &mut mesh.numbers[v.index()];
        let duplicate = number.max(*kept);
        *kept = number.min(*kept);
        mesh.duplicates.push(Duplicate { number: duplicate, kept: v.number() });
    }
    Ok(())
}

/// The indices of four affinely independent points, the earliest there are.
///
/// # Errors
/// [`BuildError`] names the dimension if there are none.
pub fn independent(points: &[Point]) -> Result<[u32; 4], BuildError> {
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    first_tet(points, &mut order)?;
    Ok([order[0], order[1], order[2], order[3]])
}

/// Brings four affinely independent points to the front of `order`, the earliest there are, and
/// returns them positively oriented.
fn first_tet(points: &[Point], order: &mut [u32]) -> Result<[Corner; 4], BuildError> {
    let at = |order: &[u32], k: usize| points[order[k] as usize];
    let mut count = 1;
    for k in 1..order.len() {
        let found = [0, 1, 2].map(|i| at(order, i.min(count - 1)));
        if is_independent(&found[..count.min(3)], &at(order, k)) {
            // The points passed over keep their order behind the first four.
            order[count..=k].rotate_right(1);
            count += 1;
            if count == 4 {
                let corner = |i: usize| Corner { p: at(order, i), number: order[i] };
                let [a, b, c, d] = [0, 1, 2, 3].map(corner);
                let positive = orient3d(&a.p, &b.p, &c.p, &d.p) == Sign::Positive;
                return Ok(if positive { [a, b, c, d] } else { [b, a, c, d] });
            }
        }
    }
    let mut sorted = points.to_vec();
    sorted.sort_unstable_by(cmp_xyz);
    sorted.dedup();
    Err(flat(count, sorted.len()))
}

/// Is a point affinely independent of up to three that are so themselves?
pub fn is_independent(found: &[Point], p: &Point) -> bool {
    match found {
        [] => true,
        [a] => p != a,
        [a, b] => !collinear(a, b, p),
        [a, b, c, ..] => orient3d(a, b, c, p) != Sign::Zero,
    }
}

/// The reason why there is no first tetrahedron, by the number of affinely independent points,
/// fewer than four, and that of different ones.
pub fn flat(independent: usize, distinct: usize) -> BuildError {
    match independent {
        _ if distinct < 4 => BuildError::TooFewPoints { distinct },
        1 | 2 => BuildError::Collinear { distinct },
        _ => BuildError::Coplanar { distinct },
    }
}

#[cfg(test)]
mod tests;
