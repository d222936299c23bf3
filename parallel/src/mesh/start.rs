//! The start of a parallel run: vertices along the curve, a coarse mesh of a sample, its
//! tetrahedra distributed to their owners.

use super::blocks::Weight;
use super::name::NO_PLACE;
use super::{Blocks, Fixed, LocalMesh, Place, PointQueue, WireVertex};
use crate::protocol::{BlockId, Directory, Handle, Name, WorkerId};
use ltbw_core::build::independent;
use ltbw_core::order::{Curve, hilbert};
use ltbw_core::submesh::MeshParams;
use ltbw_core::topology::{FaceId, INFINITE, MAX_TETS, Tet, TetId, VertexId, slot_of, tet_of};
use ltbw_core::{BuildError, Builder, CancelToken, Duplicate, Mesh, PredicateStats, Vertex};
use ltbw_exact::{Mode, Point, PointSet};
use rayon::prelude::*;
use std::ops::Range;

/// The creator in the names of the coarse mesh: no worker has this number.
const COARSE: WorkerId = WorkerId::new(u32::MAX);

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
    /// The rule that says who owns a new tetrahedron.
    pub ownership: Ownership,
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
    /// has no interface, and starts with a few.
    pub fn new(points: usize, workers: u32) -> Self {
        let workers = workers.max(1);
        let most = (5000 * workers as usize).min(points / 10);
        // A single worker has nobody to share the coarse mesh with.
        let sample = if workers == 1 { 60 } else { (points / 100).max(most).max(60) };
        let (blocks_per_worker, cursors) = (16, 32);
        Self {
            workers,
            blocks_per_worker,
            cursors,
            max_in_flight: 0,
            sample,
            ownership: Ownership::default(),
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
    /// As [`Builder::build`]: there is no first tetrahedron.
    pub fn distribute(&self, set: &PointSet) -> Result<Prepared, BuildError> {
        self.prepare(set, &Wanted::default())
    }

    /// As [`Layout::distribute`], with all points in the mesh that is distributed; if there is
    /// a cut, blocks are of about equal weight.
    pub(crate) fn prepare_all(
        &self,
        set: &PointSet,
        cut: Option<Cut<'_>>,
    ) -> Result<Prepared, BuildError> {
        let whole = Self { sample: set.len(), ..*self };
        whole.prepare(set, &Wanted { cut, ..Wanted::default() })
    }

    /// As [`Layout::distribute`], of what is wanted.
    pub(crate) fn prepare(
        &self,
        set: &PointSet,
        wanted: &Wanted<'_>,
    ) -> Result<Prepared, BuildError> {
        let Wanted { only, cut, cancel, of } = *wanted;
        let kernel = set.kernel_points();
        let order = match only {
            None => cut.map_or_else(|| hilbert(&kernel), |cut| cut.curve.order(&kernel)),
            Some(only) => {
                let points: Vec<Point> = only.iter().map(|&i| kernel[i as usize]).collect();
                hilbert(&points).into_iter().map(|k| only[k as usize]).collect()
            }
        };
        if cancel.is_some_and(CancelToken::is_cancelled) {
            return Err(BuildError::Cancelled);
        }
        // With room for the vertex at infinity, which the gathered mesh has in front.
        let mut points: Vec<Point> = Vec::with_capacity(order.len() + 1);
        points.par_extend(order.par_iter().map(|&i| kernel[i as usize]));
        let sample = self.sample_of(&points)?;
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
        let owners: Vec<WorkerId> =
            BlockId::below(blocks.len() as u32).map(|block| self.owner_of(block)).collect();
        // The one is sequential, the other mostly waits for memory.
        let (coarse, mut workers) = rayon::join(
            || coarse_mesh(&points, &sample),
            || self.submeshes(&params, &blocks, &points, of),
        );
        let coarse = coarse?;
        let coarse = Coarse { mesh: &coarse, sample: &sample };
        distribute(coarse, &points, &blocks, &owners, &mut workers);
        let interface = match self.max_in_flight {
            0 => Vec::new(),
            _ => self.interface(coarse, &blocks, points.len() as u32),
        };
        let mut duplicates = Vec::new();
        for &Duplicate { number, kept } in coarse.mesh.duplicates() {
            duplicates.push([number, kept].map(|k| VertexId::new(1 + sample[k as usize])).into());
        }
        let workers = workers
            .into_par_iter()
            .map(|mesh| {
                let me = mesh.me;
                let range = self.range(me, &blocks);
                let ranks = [range.start, range.end]
                    .map(|v| sample.partition_point(|&rank| rank < v.saturating_sub(1)));
                let out = sample[ranks[0]..ranks[1]].iter().map(|rank| rank + 1);
                let field = PointQueue::new(blocks.clone(), range, out, self.cursors)
                    .interface(interface.iter().cloned(), self.max_in_flight);
                (Directory::new(me, &owners), mesh, field)
            })
            .collect();
        let predicates = coarse.mesh.predicate_stats();
        let mode = set.mode();
        let (numbers, next) = (order, set.len() as Vertex);
        let common = SharedInput { points, numbers, next, duplicates, mode, predicates };
        Ok(Prepared { workers, common, started: sample.len() })
    }

    /// Ranks of the sample, ascending: evenly along the curve, with four affinely independent
    /// points among them.
    fn sample_of(&self, points: &[Point]) -> Result<Vec<u32>, BuildError> {
        let mut sample: Vec<u32> = independent(points)?.to_vec();
        let n = points.len() as u64;
        let size = (self.sample as u64).clamp(4, n);
        sample.extend((0..size).map(|k| ((2 * k + 1) * n / (2 * size)) as u32));
        sample.sort_unstable();
        sample.dedup();
        Ok(sample)
    }

    /// The pieces of the curve around those vertices of the sample that have a tetrahedron with
    /// vertices of several workers.
    fn interface(&self, coarse: Coarse<'_>, blocks: &Blocks, vertices: u32) -> Vec<Range<Place>> {
        let Coarse { mesh, sample } = coarse;
        let block = |k: u32| blocks.of_vertex(1 + sample[k as usize]);
        let owner = |k: u32| self.owner_of(block(k));
        let mut at_interface = vec![false; sample.len()];
        for (_, tet) in mesh.topology().iter() {
            let numbers = tet.vertices().map(|v| mesh.number(v));
            let mut owners = numbers.iter().flatten().map(|&k| owner(k));
            let first = owners.next();
            if owners.any(|other| Some(other) != first) {
                numbers.iter().flatten().for_each(|&k| at_interface[k as usize] = true);
            }
        }
        // A vertex stands for those that are nearer to it on the curve than to others.
        let middle = |k: usize| match (k.checked_sub(1), sample.get(k)) {
            (None, _) => 1,
            (_, None) => vertices + 1,
            (Some(before), Some(&after)) => 1 + sample[before].midpoint(after),
        };
        let mut pieces: Vec<Range<Place>> = Vec::new();
        for k in (0..sample.len()).filter(|&k| at_interface[k]) {
            let (start, end) = (middle(k), middle(k + 1));
            match pieces.last_mut() {
                Some(last) if last.end == start => last.end = end,
                _ => pieces.push(start..end),
            }
        }
        pieces
    }

    /// A submesh for each worker, or for one alone, without tetrahedra, with the points of its
    /// range.
    fn submeshes(
        &self,
        params: &MeshParams,
        blocks: &Blocks,
        points: &[Point],
        of: Option<WorkerId>,
    ) -> Vec<LocalMesh> {
        let submesh = |me| {
            let me = WorkerId::new(me);
            let range = self.range(me, blocks);
            let mut mesh = LocalMesh::new(me, params, blocks.clone(), range.clone());
            if self.ownership != Ownership::Block {
                mesh.fixed =
                    Some(Fixed { ownership: self.ownership, each: self.blocks_per_worker });
            }
            if self.reserve {
                // The first one receives all others in the end, if they are here.
                let is_first = me == WorkerId::default() && of.is_none();
                let share = if is_first { points.len() } else { range.len() };
                mesh.tets.reserve(7 * share + share / 4 + 1024);
            }
            mesh.tets
                .set_points(VertexId::new(1), &points[range.start as usize - 1..][..range.len()]);
            mesh
        };
        let all = 0..self.workers;
        let wanted = all.filter(|&me| of.is_none_or(|of| of.number() == me)).collect::<Vec<_>>();
        wanted.into_par_iter().map(submesh).collect()
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

/// A curve that is cut into blocks of about equal weight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut<'a> {
    pub(crate) curve: Curve,
    /// The weights of some places.
    pub(crate) weights: &'a [Weight],
}

/// The part of a start that is wanted.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wanted<'a> {
    /// The points, by index, or all.
    pub(crate) only: Option<&'a [u32]>,
    /// The cut into blocks, if not by numbers of points.
    pub(crate) cut: Option<Cut<'a>>,
    /// May end it early.
    pub(crate) cancel: Option<&'a CancelToken>,
    /// The only worker that is made: the others are elsewhere.
    pub(crate) of: Option<WorkerId>,
}

/// Workers ready to run.
#[derive(Debug)]
pub struct Prepared {
    /// By worker: directory, submesh, points.
    pub workers: Vec<(Directory, LocalMesh, PointQueue)>,
    /// Data to put their submeshes together afterwards.
    pub common: SharedInput,
    /// Points of the coarse mesh, its duplicates included.
    pub started: usize,
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

/// The coarse mesh, and the ranks of its points.
#[derive(Clone, Copy)]
struct Coarse<'a> {
    mesh: &'a Mesh,
    sample: &'a [u32],
}

/// A tetrahedron of the coarse mesh, where it has gone.
#[derive(Clone, Copy, Default)]
struct Gone {
    block: BlockId,
    owner: WorkerId,
    /// Its handle there.
    local: TetId,
}

fn coarse_mesh(points: &[Point], sample: &[u32]) -> Result<Mesh, BuildError> {
    let chosen: Vec<Point> = sample.iter().map(|&rank| points[rank as usize]).collect();
    // Kernel coordinates are finite, and no more than the input's.
    let distinct = chosen.len();
    let set = PointSet::new(chosen).map_err(|_| BuildError::TooFewPoints { distinct })?;
    Ok(Builder::new().build(&set)?.mesh)
}

/// Gives every tetrahedron of the coarse mesh to the owner of its block.
fn distribute(
    coarse: Coarse<'_>,
    points: &[Point],
    blocks: &Blocks,
    owners: &[WorkerId],
    workers: &mut [LocalMesh],
) {
    let Coarse { mesh: whole, sample } = coarse;
    let topology = whole.topology();
    let vertex = |v: VertexId| whole.number(v).map_or(NO_PLACE, |k| 1 + sample[k as usize]);
    let corners = |t: TetId| topology.get(t).map(|tet| tet.vertices().map(vertex));
    let tets: Vec<TetId> = topology.iter().map(|(t, _)| t).collect();
    // By coarse tetrahedron.
    let mut gone = vec![Gone::default(); topology.slots()];
    let block_of = |&t: &TetId| corners(t).map_or(BlockId::default(), |v| blocks.of_tet(v));
    let block_of_each: Vec<BlockId> = tets.par_iter().map(block_of).collect();
    // The worker whose tetrahedra are made: all of them, or one alone if nobody else is here.
    let first = workers.first().map_or(0, |mesh| mesh.me.index());
    let mut theirs: Vec<Vec<TetId>> = vec![Vec::new(); workers.len()];
    for (&t, block) in tets.iter().zip(block_of_each) {
        let owner = owners[block.index()];
        gone[t.index()] = Gone { block, owner, local: TetId::default() };
        if let Some(own) = owner.index().checked_sub(first).and_then(|k| theirs.get_mut(k)) {
            own.push(t);
        }
    }
    let create = |(mesh, tets): (&mut LocalMesh, &Vec<TetId>)| {
        let mut made = Vec::with_capacity(tets.len());
        for v in tets.iter().filter_map(|&t| corners(t)) {
            let v = v.map(|w| match w {
                NO_PLACE => INFINITE,
                w => mesh.take_vertex(&WireVertex::new(w, points[w as usize - 1])),
            });
            // Without room the run fails before anything looks at the submesh.
            let Some(local) = mesh.tets.create(v) else {
                mesh.fail_for_room();
                break;
            };
            made.push(local);
        }
        made.resize(tets.len(), TetId::default());
        made
    };
    let made: Vec<Vec<TetId>> = workers.par_iter_mut().zip(&theirs).map(create).collect();
    for (&t, local) in theirs.iter().flatten().zip(made.into_iter().flatten()) {
        gone[t.index()].local = local;
    }
    let sound = workers.par_iter_mut().zip(&theirs).filter(|(mesh, _)| mesh.error.is_none());
    sound.for_each(|(mesh, tets)| {
        for &t in tets {
            link(mesh, whole, t, &gone);
        }
        let (first, end) = (VertexId::new(1), mesh.vertices.after_run());
        mesh.tets.set_own_range(first..end);
    });
}

/// Links the faces of coarse tetrahedron `t`, which `mesh` has got.
fn link(mesh: &mut LocalMesh, coarse: &Mesh, t: TetId, gone: &[Gone]) {
    let Gone { block, owner, local } = gone[t.index()];
    debug_assert!(mesh.fixed.is_some() || block == mesh.block_of(local));
    let faces = coarse.topology().get(t).map(Tet::neighbours).unwrap_or_default();
    for (slot, face) in faces.into_iter().enumerate() {
        let (u, there) = (tet_of(face), slot_of(face));
        let other = gone[u.index()];
        if other.owner == owner {
            // Both ways at once.
            if t < u {
                mesh.tets.link(FaceId::new(local, slot), FaceId::new(other.local, there));
            }
            continue;
        }
        let name = Name { by: COARSE, number: u.number() };
        let far = Handle { name, block: other.block, face: there as u8 };
        if mesh.tets.link_far(FaceId::new(local, slot), far).is_none() {
            mesh.fail_for_room();
        }
        mesh.set_name(local, Name { by: COARSE, number: t.number() });
    }
}
