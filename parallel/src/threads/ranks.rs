//! A worker in each process of a team: all begin from the same start, each with its own part, and
//! the first one puts together what all have.

use super::worker_loop::{Broken, Ended, Loop};
use super::{Distributed, Node, Parallel, RunError, WorkerStats};
use crate::WorkerError;
use crate::balance::Workload;
use crate::mesh::share::{Share, put_back, share_of};
use crate::mesh::{Layout, Ownership, Prepared, Wanted};
use crate::metrics::SubmeshSize;
use crate::payload::Payload;
use crate::protocol::{Source, Worker};
use crate::team::{Letters, Post, Team, TeamError};
use crate::transport::Mail;
use crate::wire::Wire;
use ltbw_core::{BuildError, CancelToken, Outcome, Phase};
use ltbw_exact::PointSet;
use std::time::Instant;

/// A worker's part, for the first one.
#[derive(serde::Serialize, serde::Deserialize)]
struct Made {
    share: Share,
    stats: WorkerStats,
    /// Points were dropped.
    is_cut_short: bool,
}

impl Parallel<'_> {
    /// Builds the mesh as one member of a team, all of whose members are given the same points, and
    /// leaves it with the first one, part by part; the others get nothing.
    ///
    /// # Errors
    /// [`RunError`] says why there is no mesh: the same at all members, but for the one that has
    /// failed.
    pub fn build_on<P: Post>(
        &self,
        team: &mut Team<P>,
        set: &PointSet,
    ) -> Result<Option<Distributed>, RunError> {
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
        let Prepared { workers, common, started } = prepared?;
        let config = self.config();
        let Some((directory, mesh, field)) = workers.into_iter().next() else {
            return Err(RunError::Settings("a team has a worker".to_owned()));
        };
        self.listener.tell(Phase::Insert, started as u64, total);
        let start_seconds = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let node: Node = Worker::new(config, directory, mesh, field);
        let (node, stats) = self.run_on(team, node)?;
        let insert_seconds = clock.elapsed().as_secs_f64();
        let is_cut_short = node.has_dropped_points();
        let mesh = node.into_parts().0;
        if !team.is_first() {
            let made = Made { share: share_of(&mesh).0, stats, is_cut_short };
            drop(mesh);
            team.send_parcel(&made)?;
            return Ok(None);
        }
        let (mut workers, mut shares, mut is_cut_short) = (vec![stats], Vec::new(), is_cut_short);
        for (from, made) in team.parcels::<Made>()? {
            workers.push(made.stats);
            is_cut_short |= made.is_cut_short;
            made.share.is_of(from)?;
            shares.push(made.share);
        }
        let others = put_back(shares, &mesh, &common, common.mode)?;
        let meshes = [mesh].into_iter().chain(others).collect();
        let outcome = match is_cut_short {
            true => Outcome::Cancelled,
            false => Outcome::Complete,
        };
        let seconds = [start_seconds, insert_seconds];
        let (summary, trace) = (None, None);
        Ok(Some(Distributed { meshes, common, outcome, seconds, workers, summary, trace }))
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
