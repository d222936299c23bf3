//! The rounds of a domain's refinement, inserted by the protocol.
//!
//! The choice is made elsewhere, by the engine of `ltbw_domain` on a whole mesh: its *script* has
//! the points of each round as values. Workers whose submeshes live through all rounds insert them.
//! A point goes to the owner of a tetrahedron that is in conflict with it as the round starts, and
//! its operation begins there, without a walk, if nothing has removed that tetrahedron before; it
//! is inserted in any case. When all are in, the next round begins.
//!
//! The Delaunay mesh of a point set is unique, so that the mesh is the engine's whatever the number
//! of workers and the timing. Workers choose nothing, and have no marks.

use super::RefineError;
use crate::balance::Workload;
use crate::mesh::{Gathered, Layout, LocalMesh, Prepared, SharedInput, VertexName, WireVertex};
use crate::mesh::{gather, made};
use crate::metrics::Summary;
use crate::protocol::{BlockId, Config, Correct, Directory, Item, Rules, Source, Worker, WorkerId};
use crate::simulate::{MeshError, Options, Simulation, simulate};
use crate::threads::{Parallel, RunError, WorkerStats};
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_core::{CancelToken, Outcome};
use ltbw_domain::refine::{Chosen, Script};
use ltbw_exact::{Mode, Point, PointSet};
use rustc_hash::FxHashMap;
use std::collections::VecDeque;
use std::marker::PhantomData;

/// The corners of a tetrahedron, in ascending order of their names.
type Corners = [VertexName; 4];

/// One worker's points of a round.
#[derive(Debug, Default)]
pub struct RoundPoints {
    waiting: VecDeque<WireVertex>,
    /// The places where points of this worker begin: a tetrahedron, and its corners here.
    starts: FxHashMap<VertexName, (TetId, [VertexId; 4])>,
    /// Tetrahedra of this worker, and others that are gone since.
    places: FxHashMap<Corners, TetId>,
    /// The number of entries of `places` from which on those that are gone are forgotten.
    limit: usize,
}

impl RoundPoints {
    fn new(mesh: &LocalMesh) -> Self {
        let mut own = Self { limit: 1024, ..Self::default() };
        let all: Vec<TetId> = mesh.tets().tets().map(|(t, _)| t).collect();
        own.created(mesh, &all);
        own
    }

    /// The tetrahedron with these corners, if it is here.
    fn place(&self, mesh: &LocalMesh, corners: &Corners) -> Option<TetId> {
        self.places.get(corners).copied().filter(|&t| corners_of(mesh, t) == Some(*corners))
    }

    /// Takes a point that begins at tetrahedron `t`, or where a walk finds it.
    fn take(&mut self, mesh: &LocalMesh, point: WireVertex, t: Option<TetId>) {
        self.waiting.push_back(point);
        self.starts.extend(t.map(|t| (point.name, (t, mesh.tets().vertices(t)))));
    }
}

/// The corners of a finite tetrahedron; `None` if `t` is none.
fn corners_of(mesh: &LocalMesh, t: TetId) -> Option<Corners> {
    let tets = mesh.tets();
    let v = tets.is_live(t).then(|| tets.vertices(t)).filter(|v| v[3] != INFINITE)?;
    let mut names = v.map(|v| mesh.name(v));
    names.sort_unstable();
    Some(names)
}

impl Source<LocalMesh> for RoundPoints {
    const WATCHES: bool = true;

    fn next(&mut self, _: &LocalMesh) -> Option<WireVertex> {
        self.waiting.pop_front()
    }

    fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    fn item(&self, mesh: &LocalMesh, point: &WireVertex) -> Item<TetId> {
        let tets = mesh.tets();
        let stands = |&&(t, v): &&(TetId, _)| tets.is_live(t) && tets.vertices(t) == v;
        let start = self.starts.get(&point.name).filter(stands);
        start.map_or(Item::Free, |&(t, _)| Item::At(t))
    }

    fn created(&mut self, mesh: &LocalMesh, tets: &[TetId]) {
        let named = tets.iter().filter_map(|&t| Some((corners_of(mesh, t)?, t)));
        self.places.extend(named);
        if self.places.len() > self.limit {
            self.places.retain(|corners, &mut t| corners_of(mesh, t) == Some(*corners));
            self.limit = 2 * self.places.len() + 1024;
        }
    }

    fn released(&mut self, point: &WireVertex) {
        self.starts.remove(&point.name);
    }

    fn inserted(&mut self, _: &LocalMesh, point: &WireVertex) {
        self.starts.remove(&point.name);
    }

    /// The tetrahedra move, the points stay: they walk there.
    fn remove_block(&mut self, _: &LocalMesh, _: BlockId) -> Vec<WireVertex> {
        Vec::new()
    }

    fn add(&mut self, _: BlockId, points: Vec<WireVertex>) {
        self.waiting.extend(points);
    }

    fn clear(&mut self) {
        self.waiting.clear();
        self.starts.clear();
    }
}

impl Workload for RoundPoints {
    fn left(&self) -> u64 {
        self.waiting.len() as u64
    }

    fn in_block(&self, _: BlockId) -> u64 {
        0
    }
}

/// Rounds on simulated processors.
#[derive(Debug)]
pub struct Simulated {
    /// The mesh of all points.
    pub gathered: Gathered,
    /// The figures of each round.
    pub rounds: Vec<Summary>,
    /// Events of the simulation.
    pub events: u64,
}

impl Simulated {
    /// The figures of all rounds, one after the other; `None` if there are none.
    pub fn summary(&self) -> Option<Summary> {
        let mut rounds = self.rounds.iter();
        let mut all = rounds.next()?.clone();
        rounds.for_each(|next| all.go_on(next));
        Some(all)
    }
}

/// Rounds on threads.
#[derive(Debug)]
pub struct Threaded {
    /// The mesh of all points.
    pub gathered: Gathered,
    /// The figures of each worker, over all rounds.
    pub workers: Vec<WorkerStats>,
    /// Cancelled, if rounds are left; the mesh has some points of the last one.
    pub outcome: Outcome,
}

/// Inserts the rounds of a script on simulated processors. Virtual time is that of the insertion
/// alone: what the choice costs, and the news of it, is not in it.
///
/// # Errors
/// [`RefineError`] if the script is none of a sound mesh, or a run has not ended properly.
pub fn simulate_rounds<C: Rules>(
    script: &Script,
    layout: &Layout,
    config: Config,
    options: &Options,
) -> Result<Simulated, RefineError> {
    let mut crew = Crew::<C>::new(script, layout, config, None)?;
    let (mut rounds, mut events) = (Vec::new(), 0);
    for points in &script.rounds {
        let run = simulate(crew.start(points)?, options).map_err(MeshError::from)?;
        let Simulation { workers, summary, events: own, .. } = run;
        rounds.push(summary);
        events += own;
        crew.end(workers);
    }
    Ok(Simulated { gathered: crew.gather()?, rounds, events })
}

/// Inserts the rounds of a script on the threads of `parallel`. Cancelled, it is a Delaunay mesh of
/// the points inserted so far.
///
/// # Errors
/// [`RefineError`] if the script is none of a sound mesh, or a worker has failed, or if it is
/// cancelled while there is no mesh of the points at the start.
pub fn rounds_on_threads(
    script: &Script,
    parallel: &Parallel<'_>,
) -> Result<Threaded, RefineError> {
    let layout = parallel.plan_for(script.start.len());
    let mut crew = Crew::<Correct>::new(script, &layout, parallel.config(), parallel.token())?;
    let (mut workers, mut outcome) = (Vec::<WorkerStats>::new(), Outcome::Complete);
    for points in &script.rounds {
        let ended = parallel.run_workers(crew.start(points)?)?;
        workers.resize(ended.len(), WorkerStats::default());
        let mut nodes = Vec::new();
        for ((node, stats), sum) in ended.into_iter().zip(&mut workers) {
            sum.add(&stats);
            nodes.push(node);
        }
        let cancelled = nodes.iter().any(Worker::has_dropped_points);
        crew.end(nodes);
        if cancelled {
            outcome = Outcome::Cancelled;
            break;
        }
    }
    Ok(Threaded { gathered: crew.gather()?, workers, outcome })
}

/// The workers between rounds.
struct Crew<C> {
    config: Config,
    workers: Vec<(LocalMesh, RoundPoints)>,
    owners: Vec<WorkerId>,
    /// Vertices by the bits of their coordinates.
    names: FxHashMap<[u64; 3], VertexName>,
    /// Vertices that each worker has named.
    made: Vec<u32>,
    common: SharedInput,
    rules: PhantomData<C>,
}

fn bits(p: &Point) -> [u64; 3] {
    p.map(|c| (c + 0.0).to_bits())
}

impl<C: Rules> Crew<C> {
    fn new(
        script: &Script,
        layout: &Layout,
        config: Config,
        cancel: Option<&CancelToken>,
    ) -> Result<Self, RefineError> {
        let set = PointSet::new(script.start.clone()).map_err(|_| RefineError::Range)?;
        // The script's coordinates are those that the kernel computes with.
        if set.mode() != Mode::Normal {
            return Err(RefineError::Range);
        }
        let Prepared { workers, mut common, .. } = layout.prepare_all(&set, cancel)?;
        common.mode = script.mode;
        let names = (1..).zip(&common.points).map(|(name, p)| (bits(p), name)).collect();
        let owners = 0..layout.workers * layout.blocks_per_worker;
        let mut crew = Self {
            config: Config { workers: layout.workers, ..config },
            owners: owners.map(|block| WorkerId::new(block / layout.blocks_per_worker)).collect(),
            made: vec![0; workers.len()],
            workers: Vec::new(),
            names,
            common,
            rules: PhantomData,
        };
        for (_, mesh, _) in workers {
            let source = RoundPoints::new(&mesh);
            crew.workers.push((mesh, source));
        }
        Ok(crew)
    }

    /// The owner of the tetrahedron with these corners, and its place there.
    fn place(&self, corners: &[Point; 4]) -> Option<(usize, TetId)> {
        let mut names = [0; 4];
        for (name, p) in names.iter_mut().zip(corners) {
            *name = *self.names.get(&bits(p))?;
        }
        names.sort_unstable();
        let mut all = self.workers.iter().enumerate();
        all.find_map(|(k, (mesh, source))| Some((k, source.place(mesh, &names)?)))
    }

    /// The workers with the points of a round, each at the owner of the tetrahedron that it begins
    /// at.
    fn start(&mut self, points: &[Chosen]) -> Result<Vec<Node<C>>, RefineError> {
        for (k, chosen) in points.iter().enumerate() {
            let place = match &chosen.near {
                Some(corners) => Some(self.place(corners).ok_or(RefineError::Script)?),
                None => None,
            };
            let home = place.map_or(k % self.workers.len(), |(home, _)| home);
            self.made[home] += 1;
            let name = made(WorkerId::at(home), self.made[home]);
            self.names.insert(bits(&chosen.point), name);
            let (mesh, source) = &mut self.workers[home];
            source.take(mesh, WireVertex::new(name, chosen.point), place.map(|(_, t)| t));
        }
        let Self { config, owners, .. } = self;
        let node = |(me, (mesh, source))| {
            let me = WorkerId::at(me);
            Worker::new(*config, Directory::new(me, owners), mesh, source)
        };
        Ok(self.workers.drain(..).enumerate().map(node).collect())
    }

    /// Takes back the workers of a run that has ended: all points are in, and nothing is locked.
    fn end(&mut self, nodes: Vec<Node<C>>) {
        for node in nodes {
            let (mesh, source, directory) = node.into_parts();
            // Where blocks have moved each one knows its own for certain.
            for (block, owner) in directory.blocks().zip(&mut self.owners) {
                if directory.is_mine(block) {
                    *owner = directory.me();
                }
            }
            self.workers.push((mesh, source));
        }
    }

    fn gather(self) -> Result<Gathered, RefineError> {
        let meshes = self.workers.into_iter().map(|(mesh, _)| mesh).collect();
        Ok(gather(meshes, self.common).map_err(RunError::from)?)
    }
}

/// A worker of a round.
type Node<C> = Worker<LocalMesh, RoundPoints, C>;
