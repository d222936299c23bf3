//! A worker in each process of a team: all begin from the same start, each with its own part, and
//! each keeps its part in the end.

use super::worker_loop::{Broken, Ended, Loop};
use super::{Node, Parallel, RunError, WorkerStats};
use crate::WorkerError;
use crate::balance::Workload;
use crate::distributed::Part;
use crate::mesh::{Layout, LocalMesh, Ownership, Place, Prepared, SharedInput, Wanted, given};
use crate::metrics::SubmeshSize;
use crate::payload::Payload;
use crate::protocol::{Source, Worker};
use crate::team::{Letters, Post, Team, TeamError};
use crate::transport::Mail;
use crate::wire::Wire;
use ltbw_core::topology::{INFINITE, VertexId};
use ltbw_core::{BuildError, CancelToken, Duplicate, Outcome, Phase, PredicateStats, Vertex};
use ltbw_exact::PointSet;
use std::time::Instant;

/// One member's part of a mesh, and how the whole came about.
#[derive(Debug)]
#[non_exhaustive]
pub struct BuiltPart {
    /// The part.
    pub part: Part,
    /// The outcome, of the whole mesh.
    pub outcome: Outcome,
    /// Duplicates met by all, by input indices, ascending.
    pub duplicates: Vec<Duplicate>,
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
    /// Pairs of places: that of the point, and that of the vertex there.
    duplicates: Vec<[Place; 2]>,
    tets: u64,
    hull_faces: u64,
}

impl Parallel<'_> {
    /// Builds the mesh as one member of a team, all of whose members are given the same points:
    /// each gets its own part.
    ///
    /// # Errors
    /// [`RunError`] says why there is no mesh: the same at all members, but for the one that has
    /// failed.
    pub fn build_on<P: Post>(
        &self,
        team: &mut Team<P>,
        set: &PointSet,
    ) -> Result<BuiltPart, RunError> {
        let clock = Instant::now();
        let points = self.only.map_or(set.len(), <[_]>::len);
        let total = points as u64;
        let layout = self.plan_for(points);
        if self.is_balanced || layout.ownership == Ownership::Block {
            return Err(RunError::Settings(UNBALANCED.to_owned()));
        }
        self.listener.tell(Phase::Order, 0, total);
        let layout = Layout { reserve: true, ..layout };
        let wanted = Wanted { of: Some(team.me()), ..self.wanted() };
        let prepared = layout.prepare(set, &wanted);
        // Each of them has its own token.
        let is_cancelled = self.cancel.is_some_and(CancelToken::is_cancelled);
        if team.is_any(is_cancelled)? {
            return Err(BuildError::Cancelled.into());
        }
        let Prepared { workers, mut common, started } = prepared?;
        // The worker has those of its own stretch, and those that it has met.
        common.points = Vec::new();
        let config = self.config();
        let Some((directory, mesh, field)) = workers.into_iter().next() else {
            return Err(RunError::Settings("a team has a worker".to_owned()));
        };
        self.listener.tell(Phase::Insert, started as u64, total);
        let start_seconds = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let node: Node = Worker::new(config, directory, mesh, field);
        let (node, stats) = self.run_on(team, node)?;
        let seconds = [start_seconds, clock.elapsed().as_secs_f64()];
        let is_cut_short = node.has_dropped_points();
        let mesh = node.into_parts().0;
        let mut predicates = mesh.tets().predicates();
        if team.is_first() {
            predicates += common.predicates;
        }
        let made = Made {
            stats,
            predicates,
            is_cut_short,
            duplicates: mesh.given_duplicates().collect(),
            tets: mesh.given_tets().count() as u64,
            hull_faces: mesh.given_ghosts().count() as u64,
        };
        let all: Vec<Made> = team.gather_all(&made)?;
        let duplicates = numbered(&mut common, all.iter().flat_map(|made| &made.duplicates));
        let mut whole = BuiltPart {
            part: part_of(&mesh, &common, set),
            outcome: Outcome::Complete,
            duplicates,
            seconds,
            tets: 0,
            hull_faces: 0,
            predicates: PredicateStats::default(),
            workers: Vec::new(),
        };
        for made in all {
            whole.tets += made.tets;
            whole.hull_faces += made.hull_faces;
            whole.predicates += made.predicates;
            whole.workers.push(made.stats);
            if made.is_cut_short {
                whole.outcome = Outcome::Cancelled;
            }
        }
        Ok(whole)
    }

    /// Runs one worker, whose others are the members of the team.
    pub(crate) fn run_on<P, S, Q>(
        &self,
        team: &mut Team<P>,
        node: Node<S, Q>,
    ) -> Result<(Node<S, Q>, WorkerStats), RunError>
    where
        P: Post,
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

/// The duplicates by the input's numbers. The smallest number of equal points is the vertex,
/// whichever was inserted first.
fn numbered<'m>(
    common: &mut SharedInput,
    met: impl Iterator<Item = &'m [Place; 2]>,
) -> Vec<Duplicate> {
    let of_sample = common.duplicates.iter().map(|&(point, v)| [point, v].map(|v| v.number()));
    // A number that is no place of the input is no duplicate.
    let count = common.numbers.len();
    let is_known =
        |pair: &[Place; 2]| pair.iter().all(|&place| (1..=count).contains(&(place as usize)));
    let mut pairs: Vec<[usize; 2]> = of_sample
        .chain(met.copied())
        .filter(is_known)
        .map(|pair| pair.map(|place| place as usize - 1))
        .collect();
    pairs.sort_unstable();
    let mut duplicates = Vec::with_capacity(pairs.len());
    for &[point, v] in &pairs {
        let (number, kept) = (common.numbers[point], common.numbers[v]);
        common.numbers[v] = number.min(kept);
        duplicates.push((number.max(kept), v));
    }
    let kept = |(number, v): (Vertex, usize)| Duplicate { number, kept: common.numbers[v] };
    let mut duplicates: Vec<Duplicate> = duplicates.into_iter().map(kept).collect();
    duplicates.sort_unstable();
    duplicates
}

/// A submesh by the numbers and the coordinates of the input.
fn part_of(mesh: &LocalMesh, common: &SharedInput, set: &PointSet) -> Part {
    let finite = || mesh.tets().tets().map(|(_, v)| v).filter(|v| v[3] != INFINITE);
    // By vertex of the submesh: first whether it is used, then its place in the part.
    let mut of_vertex = vec![0_u32; mesh.num_vertices() + 1];
    finite().flatten().for_each(|v| of_vertex[v.index()] = 1);
    let number = |place: Place| common.numbers[place as usize - 1];
    let vertices = (1..of_vertex.len()).map(VertexId::at).filter(|v| of_vertex[v.index()] > 0);
    let mut used: Vec<(Vertex, VertexId)> =
        vertices.filter_map(|v| Some((number(given(mesh.name(v))?), v))).collect();
    used.sort_unstable();
    used.iter().zip(0..).for_each(|(&(_, v), place)| of_vertex[v.index()] = place);
    Part {
        numbers: used.iter().map(|&(number, _)| number).collect(),
        points: used.iter().map(|&(number, _)| set.points()[number as usize]).collect(),
        tets: finite().map(|v| v.map(|v| of_vertex[v.index()])).collect(),
        hull: mesh.given_ghosts().map(|v| v.map(number)).collect(),
    }
}
