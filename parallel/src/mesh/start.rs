//! The start of a parallel run: vertices along the curve, cut into blocks, and workers with their
//! parts of a coarse mesh.

use super::blocks::Weight;
use super::coarse::Coarse;
pub(crate) use super::coarse::{Sample, Sampled};
use super::{Blocks, Fixed, LocalMesh, Place, PointQueue};
use crate::protocol::{BlockId, Directory, WorkerId};
use ltbw_core::build::independent;
use ltbw_core::order::{Curve, hilbert};
use ltbw_core::submesh::MeshParams;
use ltbw_core::topology::{MAX_TETS, Tet, TetId, VertexId};
use ltbw_core::{BuildError, CancelToken, PredicateStats, Vertex};
use ltbw_exact::{Mode, Point, PointSet};
use rayon::prelude::*;
use std::ops::Range;

/// The rule that says who owns a new tetrahedron.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Ownership {
    /// The owner of its block, a function of its vertices: submeshes keep their shape.
    #[default]
    Block,
    /// The owner of its newest vertex's block: the star of a point is not divided, and what a
    /// worker inserts at once is its own without a look. Submeshes have rougher borders, and blocks
    /// do not move: what a worker has cannot be told from the vertices.
    Newest,
    /// The paper's: its creator, the home of the operation. Submeshes grow into each other, and
    /// blocks do not move. To reproduce the paper's figures.
    Creator,
}

impl Ownership {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Block, Self::Newest, Self::Creator];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Block => "block",
            Self::Newest => "newest",
            Self::Creator => "creator",
        }
    }

    /// The message when blocks are to move although they do not tell the owners of tetrahedra.
    pub(crate) const STAYS: &str = "blocks cannot move where new tetrahedra belong to their \
                                    creator or to the owner of their newest vertex: no balance, \
                                    no storm";
}

impl std::str::FromStr for Ownership {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|o| o.name() == text);
        found.ok_or_else(|| format!("no ownership `{text}`: block, newest or creator"))
    }
}

/// When the cuts between the parts of workers that refine a domain in rounds move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Redeal {
    /// Never.
    #[default]
    Never,
    /// When one worker has had much more to do than others, and it seems to go on like that.
    AsNeeded,
    /// After every such number of rounds, whether it helps or not: for tests.
    Every(u64),
}

impl std::str::FromStr for Redeal {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.parse()) {
            ("never", _) => Ok(Self::Never),
            ("needed", _) => Ok(Self::AsNeeded),
            (_, Ok(rounds)) if rounds > 0 => Ok(Self::Every(rounds)),
            _ => Err(format!("no redeal `{text}`: never, needed or a number of rounds")),
        }
    }
}

/// The layout of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Number of workers, at least 1.
    pub workers: u32,
    /// Blocks of each worker at the start.
    pub blocks_per_worker: u32,
    /// Cursors of each worker's queue of points, per round.
    pub cursors: usize,
    /// Points of a worker that are to be under way before points that need no other worker go
    /// first; 0 if points are to come as they lie.
    pub max_in_flight: usize,
    /// Points of the coarse mesh, or all if there are fewer.
    pub sample: usize,
    /// Each worker takes its points along a curve through these alone, as processes do, not along
    /// its stretch of the curve through all. Blocks are no stretches of that one then. For points
    /// without a mesh.
    pub own_curves: bool,
    /// The rule that says who owns a new tetrahedron.
    pub ownership: Ownership,
    /// When cuts move between rounds.
    pub redeal: Redeal,
    /// Reserve memory for all tetrahedra to come, for uniform points: pages that stay unused cost
    /// nothing but address space.
    pub reserve: bool,
    /// Most tetrahedra of a worker, hull ghosts and interface faces included: a run that needs more
    /// fails. The default is the largest number that can be named.
    pub max_tets: usize,
}

impl Layout {
    /// The default layout for `points` points on `workers` workers.
    ///
    /// The sample is one point in a hundred, or 5,000 a worker if that is more, but at most one in
    /// ten: the smaller a worker's part, the more cavities are interface cavities. One worker alone
    /// has no interface, and starts with a few. The sample is inserted by one, for whom all others
    /// wait: it is no more than 10,000, or a twentieth of one worker's points if that is more.
    pub fn new(points: usize, workers: u32) -> Self {
        let workers = workers.max(1);
        let most = (5000 * workers as usize).min(points / 10);
        // A single worker has nobody to share the coarse mesh with.
        let alone = (points / (20 * workers as usize)).max(10_000);
        let sample = if workers == 1 { 60 } else { (points / 100).max(most).min(alone).max(60) };
        let (blocks_per_worker, cursors) = (16, 32);
        Self {
            workers,
            blocks_per_worker,
            cursors,
            max_in_flight: 0,
            sample,
            own_curves: false,
            ownership: Ownership::default(),
            redeal: Redeal::default(),
            reserve: false,
            max_tets: MAX_TETS,
        }
    }

    /// The layout for processors whose messages take long: what lies at the interface goes first.
    pub fn for_high_latency(points: usize, workers: u32) -> Self {
        Self { max_in_flight: 80, ..Self::new(points, workers) }
    }

    /// Builds the coarse mesh and distributes it.
    ///
    /// # Errors
    /// There is no first tetrahedron: too few points, or all of them in a plane.
    pub fn distribute(&self, set: &PointSet) -> Result<Prepared, BuildError> {
        self.prepare(set, &Wanted::default())
    }

    /// As [`Layout::distribute`], of what is wanted.
    pub(crate) fn prepare(
        &self,
        set: &PointSet,
        wanted: &Wanted<'_>,
    ) -> Result<Prepared, BuildError> {
        let Wanted { only, given, cancel } = *wanted;
        let cut = given.and_then(|given| given.cut);
        let kernel = set.kernel_points();
        let mut order = match only {
            None => cut.map_or_else(|| hilbert(&kernel), |cut| cut.curve.order(&kernel)),
            Some(only) => along_own(&kernel, only),
        };
        if cancel.is_some_and(CancelToken::is_cancelled) {
            return Err(BuildError::Cancelled);
        }
        if self.own_curves && given.is_none() && only.is_none() {
            let workers = self.workers as usize;
            let ends: Vec<usize> = (0..=workers).map(|w| w * order.len() / workers).collect();
            for pair in ends.windows(2) {
                let own = &mut order[pair[0]..pair[1]];
                own.copy_from_slice(&along_own(&kernel, own));
            }
        }
        // With room for the vertex at infinity, which the gathered mesh has in front.
        let mut points: Vec<Point> = Vec::with_capacity(order.len() + 1);
        points.par_extend(order.par_iter().map(|&i| kernel[i as usize]));
        let params = MeshParams::of(&points, set.mode()).at_most(self.max_tets);
        let (low, high) = params.bounds();
        let count = self.workers * self.blocks_per_worker;
        let blocks = match cut {
            None => {
                let curve = Curve::of_box(low, high);
                Blocks::even(points.len() as u32, count).along(curve, &points)
            }
            Some(Cut { curve, weights }) => Blocks::weighted(curve, &points, weights, count),
        };
        // The one is sequential, the other mostly waits for memory.
        let coarse = || match given {
            None => Coarse::of(self.sample_of(&points)?),
            Some(Given { tets, .. }) => Ok(Coarse::given(tets, &order, &points)),
        };
        let (coarse, meshes) = rayon::join(coarse, || self.submeshes(&params, &blocks, &points));
        let coarse = coarse?;
        let started = coarse.points();
        let Begun { workers, slots } = self.begin(&coarse, &blocks, meshes);
        let Coarse { duplicates, predicates, .. } = coarse;
        let mode = set.mode();
        let (numbers, next) = (order, set.len() as Vertex);
        let common = SharedInput { points, numbers, next, duplicates, mode, predicates };
        Ok(Prepared { workers, common, started, slots })
    }

    /// The part of a start that is one worker's, whose others are elsewhere, and the predicate
    /// calls of the coarse mesh.
    ///
    /// # Errors
    /// As [`Layout::distribute`].
    #[cfg(feature = "wire")]
    pub(crate) fn prepare_one(
        &self,
        stretch: Stretch<'_>,
    ) -> Result<(Vec<Ready>, PredicateStats), BuildError> {
        let Stretch { me, points, vertices, params, sample } = stretch;
        let params = params.at_most(self.max_tets);
        let blocks = Blocks::even(vertices, self.workers * self.blocks_per_worker);
        let (coarse, mesh) = rayon::join(
            || Coarse::of(sample),
            || self.submesh(me, &params, &blocks, Room { points, most: points.len() }),
        );
        let coarse = coarse?;
        Ok((self.begin(&coarse, &blocks, vec![mesh]).workers, coarse.predicates))
    }

    /// Gives submeshes the tetrahedra of the coarse mesh, and the points that they are to insert.
    fn begin(&self, coarse: &Coarse<'_>, blocks: &Blocks, mut meshes: Vec<LocalMesh>) -> Begun {
        let owners: Vec<WorkerId> =
            BlockId::below(blocks.len() as u32).map(|block| self.owner_of(block)).collect();
        let slots = coarse.distribute(blocks, &owners, &mut meshes);
        let interface = match self.max_in_flight {
            0 => Vec::new(),
            _ => coarse.interface(blocks.end(), |place| owners[blocks.of_vertex(place).index()]),
        };
        let ready = |mesh: LocalMesh| {
            let me = mesh.me;
            let range = self.range(me, blocks);
            let out = coarse.places_in(&range);
            let field = PointQueue::new(blocks.clone(), range, out, self.cursors)
                .interface(interface.iter().cloned(), self.max_in_flight);
            (Directory::new(me, &owners), mesh, field)
        };
        Begun { workers: meshes.into_par_iter().map(ready).collect(), slots }
    }

    /// The sample: evenly along the curve, with four affinely independent points among them.
    fn sample_of(&self, points: &[Point]) -> Result<Sample, BuildError> {
        let mut ranks = independent(points)?.to_vec();
        ranks.extend(self.evenly(points.len() as u32));
        let point = |rank: u32| Sampled { place: 1 + rank, at: points[rank as usize] };
        Ok(Sample::of(ranks.into_iter().map(point).collect()))
    }

    /// Ranks among `points` points along the curve: those of the sample, ascending.
    pub(crate) fn evenly(&self, points: u32) -> impl Iterator<Item = u32> + use<> {
        let n = u64::from(points);
        let size = (self.sample as u64).max(4).min(n);
        (0..size).map(move |k| ((2 * k + 1) * n / (2 * size)) as u32)
    }

    /// A submesh for each worker, without tetrahedra, with the points of its range.
    fn submeshes(&self, params: &MeshParams, blocks: &Blocks, points: &[Point]) -> Vec<LocalMesh> {
        let submesh = |me| {
            let me = WorkerId::new(me);
            let range = self.range(me, blocks);
            // The first one receives all others in the end.
            let most = if me == WorkerId::default() { points.len() } else { range.len() };
            let points = &points[range.start as usize - 1..][..range.len()];
            self.submesh(me, params, blocks, Room { points, most })
        };
        (0..self.workers).into_par_iter().map(submesh).collect()
    }

    /// A submesh without tetrahedra, with the points of its range.
    fn submesh(
        &self,
        me: WorkerId,
        params: &MeshParams,
        blocks: &Blocks,
        room: Room<'_>,
    ) -> LocalMesh {
        let Room { points, most } = room;
        let mut mesh = LocalMesh::new(me, params, blocks.clone(), self.range(me, blocks));
        if self.ownership != Ownership::Block {
            mesh.fixed = Some(Fixed { ownership: self.ownership, each: self.blocks_per_worker });
        }
        if self.reserve {
            mesh.tets.reserve(7 * most + most / 4 + 1024);
        }
        mesh.tets.set_points(VertexId::new(1), points);
        mesh
    }

    /// The owner of a block at the start.
    fn owner_of(&self, block: BlockId) -> WorkerId {
        WorkerId::new(block.number() / self.blocks_per_worker)
    }

    /// The vertices of a worker at the start.
    fn range(&self, me: WorkerId, blocks: &Blocks) -> Range<Place> {
        let block = |number: u32| blocks.vertices(BlockId::new(number));
        let first = me.number() * self.blocks_per_worker;
        block(first).start..block(first + self.blocks_per_worker - 1).end
    }
}

/// Some points, by index, along a curve through these alone.
fn along_own(kernel: &[Point], some: &[u32]) -> Vec<u32> {
    let points: Vec<Point> = some.iter().map(|&i| kernel[i as usize]).collect();
    hilbert(&points).into_iter().map(|k| some[k as usize]).collect()
}

/// A curve that is cut into blocks of about equal weight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut<'a> {
    pub(crate) curve: Curve,
    /// The weights of some places.
    pub(crate) weights: &'a [Weight],
}

/// A mesh of all points that is there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given<'a> {
    /// By slot; vertex v is point v - 1.
    pub(crate) tets: &'a [Tet],
    /// The cut into blocks, if not by numbers of points.
    pub(crate) cut: Option<Cut<'a>>,
}

/// Workers with their parts, and the slots in the coarse mesh of their tetrahedra.
struct Begun {
    workers: Vec<Ready>,
    slots: Vec<Vec<TetId>>,
}

/// The part of a start that is wanted.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wanted<'a> {
    /// The points, by index, or all.
    pub(crate) only: Option<&'a [u32]>,
    /// The coarse mesh, if it is not to be made.
    pub(crate) given: Option<Given<'a>>,
    /// May end it early.
    pub(crate) cancel: Option<&'a CancelToken>,
}

/// The points of a worker, and the number of those whose tetrahedra it may have in the end.
#[derive(Clone, Copy)]
struct Room<'a> {
    points: &'a [Point],
    most: usize,
}

/// A start as one worker has to know it: its stretch of the curve, and a little of the whole.
#[cfg(feature = "wire")]
#[derive(Clone, Debug)]
pub(crate) struct Stretch<'a> {
    pub(crate) me: WorkerId,
    /// Kernel coordinates of its stretch.
    pub(crate) points: &'a [Point],
    /// Vertices of the whole mesh.
    pub(crate) vertices: u32,
    /// Parameters of the whole mesh.
    pub(crate) params: MeshParams,
    /// The vertices of the coarse mesh.
    pub(crate) sample: Sample,
}

/// A worker ready to run: directory, submesh, points.
pub type Ready = (Directory, LocalMesh, PointQueue);

/// Workers ready to run.
#[derive(Debug)]
pub struct Prepared {
    /// By worker.
    pub workers: Vec<Ready>,
    /// Data to put their submeshes together afterwards.
    pub common: SharedInput,
    /// Points of the coarse mesh, its duplicates included.
    pub started: usize,
    /// By worker and slot, the slots in the coarse mesh of its tetrahedra.
    pub(crate) slots: Vec<Vec<TetId>>,
}

/// Data that no worker has: the whole set of points.
#[derive(Debug)]
pub struct SharedInput {
    /// Kernel coordinates by vertex less 1.
    pub points: Vec<Point>,
    /// Input index by vertex less 1.
    pub numbers: Vec<u32>,
    /// Number that the next inserted point gets.
    pub next: Vertex,
    /// Points of the sample that equal another one: vertex numbers of both.
    pub duplicates: Vec<(VertexId, VertexId)>,
    /// The mode of computing with the points.
    pub mode: Mode,
    /// Predicate calls of the coarse mesh.
    pub predicates: PredicateStats,
}

#[cfg(test)]
mod tests {
    use super::Layout;

    #[test]
    fn the_sample_is_little_work_beside_that_of_a_worker() {
        let of = |points, workers| Layout::new(points, workers).sample;
        assert_eq!([of(9, 1), of(1_000_000, 1), of(300, 2)], [60, 60, 60]);
        assert_eq!([of(20_000, 4), of(100_000, 16), of(1_000_000, 2)], [2_000, 10_000, 10_000]);
        assert_eq!([of(4_000_000, 8), of(4_000_000, 16)], [25_000, 12_500]);
        assert_eq!([of(128 * 60_000, 128), of(128 * 600_000, 128)], [10_000, 30_000]);
    }
}
