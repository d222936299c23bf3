//! A worker in each process of a team: each begins with its stretch of the points, which nobody has
//! all of, and keeps its part of the mesh in the end.

use super::worker_loop::{Broken, Ended, Loop};
use super::{Node, Parallel, RunError, WorkerStats};
use crate::WorkerError;
use crate::balance::Workload;
use crate::distributed::{Ordered, Part, Slice, ask, bytes_of, order, values_of};
use crate::mesh::{Layout, LocalMesh, Ownership, Place, Sample, Sampled, Stretch, given};
use crate::metrics::SubmeshSize;
use crate::payload::Payload;
use crate::protocol::{Source, Worker, WorkerId};
use crate::team::{Letters, Team, TeamError};
use crate::transport::Mail;
use crate::wire::{Wire, WireError};
use ltbw_core::build::flat;
use ltbw_core::submesh::MeshParams;
use ltbw_core::topology::{INFINITE, VertexId};
use ltbw_core::{BuildError, CancelToken, Duplicate, Outcome, Phase, PredicateStats, Vertex};
use ltbw_exact::Mode;
use rayon::prelude::*;
use std::time::Instant;

/// One member's part of a mesh, and how the whole came about.
#[derive(Debug)]
#[non_exhaustive]
pub struct BuiltPart {
    /// The part.
    pub part: Part,
    /// The outcome, of the whole mesh.
    pub outcome: Outcome,
    /// Points that equal another one, by input indices, ascending: at the first member.
    pub duplicates: Vec<Duplicate>,
    /// Their number.
    pub num_duplicates: u64,
    /// Seconds of the start and of the workers.
    pub seconds: [f64; 2],
    /// Tetrahedra of the whole mesh.
    pub tets: u64,
    /// Facets of its hull.
    pub hull_faces: u64,
    /// Predicate calls of all members.
    pub predicates: PredicateStats,
    /// By worker.
    pub workers: Vec<WorkerStats>,
}

/// The words of a member on its part.
#[derive(serde::Serialize, serde::Deserialize)]
struct Made {
    stats: WorkerStats,
    predicates: PredicateStats,
    /// Points were dropped.
    is_cut_short: bool,
    /// Points of its stretch that equal another one.
    duplicates: u64,
    tets: u64,
    hull_faces: u64,
}

/// A member about to insert.
struct Begun {
    node: Node,
    /// Predicate calls of the coarse mesh, at the first member.
    predicates: PredicateStats,
    /// Points of the coarse mesh.
    started: u64,
}

impl Parallel<'_> {
    /// Builds the mesh of the points of all slices as one member of a team: each gets its own part.
    ///
    /// # Errors
    /// [`RunError`] says why there is no mesh: the same at all members, but for the one that has
    /// failed.
    pub fn build_on(&self, team: &mut Team, slice: &Slice) -> Result<BuiltPart, RunError> {
        let clock = Instant::now();
        let total = u64::from(slice.total());
        let layout = self.plan_for(total as usize);
        if self.is_balanced || layout.ownership == Ownership::Block {
            return Err(RunError::Settings(UNBALANCED.to_owned()));
        }
        self.listener.tell(Phase::Order, 0, total);
        let mut ordered = order(team, slice)?;
        // Each of them has its own token.
        let is_cancelled = self.cancel.is_some_and(CancelToken::is_cancelled);
        if team.is_any(is_cancelled)? {
            return Err(BuildError::Cancelled.into());
        }
        let layout = Layout { reserve: true, ..layout };
        let Begun { node, predicates: mut own, started } =
            self.begin_on(team, layout, &mut ordered, slice.mode())?;
        self.listener.tell(Phase::Insert, started, total);
        let start_seconds = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let (node, stats) = self.run_on(team, node)?;
        let seconds = [start_seconds, clock.elapsed().as_secs_f64()];
        let is_cut_short = node.has_dropped_points();
        let mesh = node.into_parts().0;
        own += mesh.tets().predicates();
        let made = Made {
            stats,
            predicates: own,
            is_cut_short,
            duplicates: ordered.duplicates.len() as u64,
            tets: mesh.given_tets().count() as u64,
            hull_faces: mesh.given_ghosts().count() as u64,
        };
        let all: Vec<Made> = team.gather_all(&made)?;
        let duplicates = duplicates_of(team, &ordered.duplicates, slice)?;
        let mut whole = BuiltPart {
            part: part_of(team, &mesh, &ordered, slice)?,
            outcome: Outcome::Complete,
            duplicates,
            num_duplicates: 0,
            seconds,
            tets: 0,
            hull_faces: 0,
            predicates: PredicateStats::default(),
            workers: Vec::new(),
        };
        for made in all {
            whole.tets += made.tets;
            whole.hull_faces += made.hull_faces;
            whole.num_duplicates += made.duplicates;
            whole.predicates += made.predicates;
            whole.workers.push(made.stats);
            if made.is_cut_short {
                whole.outcome = Outcome::Cancelled;
            }
        }
        Ok(whole)
    }

    /// Makes the own part of a start: the coarse mesh, which all make, and the own stretch.
    fn begin_on(
        &self,
        team: &mut Team,
        layout: Layout,
        ordered: &mut Ordered,
        mode: Mode,
    ) -> Result<Begun, RunError> {
        let (me, vertices) = (team.me(), ordered.vertices());
        let mut placed = ordered.independent(team)?;
        if placed.len() < 4 {
            return Err(flat(placed.len(), vertices as usize).into());
        }
        placed.extend(ordered.of_all(team, layout.evenly(vertices))?);
        let sampled = placed.into_iter().map(|(k, at)| Sampled { place: k + 1, at });
        let sample = Sample::of(sampled.collect());
        let started = sample.len() as u64;
        // The submesh has them from here on.
        let points = std::mem::take(&mut ordered.points);
        let params = MeshParams::within(ordered.extent, mode);
        let stretch = Stretch { me, points: &points, vertices, params, sample };
        let prepared = layout.prepare_one(stretch);
        drop(points);
        // One alone may lack the memory.
        let failed: Vec<bool> = team.gather_all(&prepared.is_err())?;
        let (workers, predicates) = prepared?;
        if let Some(member) = WorkerId::below(team.size()).find(|own| failed[own.index()]) {
            return Err(TeamError::Failed(member).into());
        }
        let Some((directory, mesh, field)) = workers.into_iter().next() else {
            return Err(RunError::Settings("a team has a worker".to_owned()));
        };
        // All have made the coarse mesh: it counts once.
        let predicates = if team.is_first() { predicates } else { PredicateStats::default() };
        let node = Worker::new(self.config(), directory, mesh, field);
        Ok(Begun { node, predicates, started })
    }

    /// Runs one worker, whose others are the members of the team.
    pub(crate) fn run_on<S, Q>(
        &self,
        team: &mut Team,
        node: Node<S, Q>,
    ) -> Result<(Node<S, Q>, WorkerStats), RunError>
    where
        S: Payload + SubmeshSize,
        Mail<S>: Wire,
        Q: Source<S> + Workload,
    {
        let (me, size) = (team.me(), team.size());
        let way = Letters::new(team, self.cancel);
        let hooks = self.hooks(me, Instant::now());
        match Loop::new(node, size, way, hooks, None).run() {
            Ok(Ended { node, hooks, .. }) => {
                let (stats, _) = hooks.finish(node.mesh());
                Ok((node, stats))
            }
            Err(Broken::Here(error)) => Err(WorkerError::Submesh { worker: me, error }.into()),
            Err(Broken::Elsewhere(worker)) => {
                let error = team.error().unwrap_or(TeamError::Failed(worker));
                // Others may wait for this one.
                team.fail();
                Err(error.into())
            }
        }
    }
}

/// The settings that a team does not have.
const UNBALANCED: &str = "blocks do not move between processes";

/// The duplicates that all members have found, at the first one, ascending.
fn duplicates_of(
    team: &mut Team,
    own: &[Duplicate],
    slice: &Slice,
) -> Result<Vec<Duplicate>, TeamError> {
    let own = own.iter().map(|&Duplicate { number, kept }| [number, kept]);
    let all = team.gather(bytes_of(own))?.unwrap_or_default();
    let mut duplicates = Vec::new();
    for (from, bytes) in WorkerId::below(team.size()).zip(&all) {
        for (k, [number, kept]) in values_of::<[Vertex; 2]>(from, bytes)?.enumerate() {
            known(from, [number, kept], [8 * k, bytes.len()], slice)?;
            duplicates.push(Duplicate { number, kept });
        }
    }
    duplicates.sort_unstable();
    Ok(duplicates)
}

/// Makes sure that `from` has sent numbers of points, at this place of its bytes.
fn known<const N: usize>(
    from: WorkerId,
    numbers: [Vertex; N],
    [at, length]: [usize; 2],
    slice: &Slice,
) -> Result<(), TeamError> {
    if numbers.iter().all(|&number| number < slice.total()) {
        return Ok(());
    }
    let reason = "a number of no point".to_owned();
    Err(WireError { from, at, length, reason }.into())
}

/// A submesh by the numbers and the coordinates of the input. The numbers of vertices of other
/// stretches are asked for.
fn part_of(
    team: &mut Team,
    mesh: &LocalMesh,
    ordered: &Ordered,
    slice: &Slice,
) -> Result<Part, TeamError> {
    let finite = || mesh.tets().tets().map(|(_, v)| v).filter(|v| v[3] != INFINITE);
    // By vertex of the submesh: first whether it is used, then its place in the part.
    let mut of_vertex = vec![0_u32; mesh.num_vertices() + 1];
    finite().flatten().for_each(|v| of_vertex[v.index()] = 1);
    let vertices = (1..of_vertex.len()).map(VertexId::at).filter(|v| of_vertex[v.index()] > 0);
    let used: Vec<(Place, VertexId)> =
        vertices.filter_map(|v| Some((given(mesh.name(v))?, v))).collect();
    let mut asked: Vec<Place> = used.iter().map(|&(place, _)| place - 1).collect();
    asked.extend(mesh.given_ghosts().flatten().map(|place| place - 1));
    asked.par_sort_unstable();
    asked.dedup();
    let before = ordered.before(team.me());
    let told = ask(team, &asked, &ordered.firsts, |place| {
        ordered.numbers.get(place.checked_sub(before)? as usize).copied()
    })?;
    for (&place, &number) in asked.iter().zip(&told) {
        let teller = ordered.firsts.partition_point(|&first| first <= place.into());
        known(WorkerId::new(teller as u32 - 1), [number], [0, 0], slice)?;
    }
    // Whatever is asked for is there.
    let number = |place: Place| told[asked.partition_point(|&other| other < place - 1)];
    let mut used: Vec<(Vertex, VertexId)> =
        used.into_par_iter().map(|(place, v)| (number(place), v)).collect();
    used.par_sort_unstable();
    used.iter().zip(0..).for_each(|(&(_, v), place)| of_vertex[v.index()] = place);
    let point = |v: VertexId| slice.mode().from_kernel(mesh.tets().point(v));
    Ok(Part {
        numbers: used.iter().map(|&(number, _)| number).collect(),
        points: used.iter().map(|&(_, v)| point(v)).collect(),
        tets: finite().map(|v| v.map(|v| of_vertex[v.index()])).collect(),
        hull: mesh.given_ghosts().map(|v| v.map(number)).collect(),
    })
}
