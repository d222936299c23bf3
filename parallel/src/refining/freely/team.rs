//! Refinement without rounds by a worker in each process of a team: all begin from the same start.
//! In the end each keeps its part; where something is left that takes the whole mesh the first one
//! puts the parts together and goes on, as it does with threads.

use super::{START_EACH, ThreadedDomain, begin, end};
use crate::protocol::Correct;
use crate::refining::RefineError;
use crate::refining::domain::{DomainNode, Splits};
use crate::refining::parcel::{Collected, Parcel, of_team};
use crate::refining::rounds::{
    Ended, Ends, Late, LateSteps, Left, Own, Stays, TeamEnd, Wishes, look,
};
use crate::refining::whole::{Owners, Part};
use crate::team::{Team, TeamError};
use crate::threads::{Parallel, WorkerStats};
use ltbw_core::CancelToken;
use ltbw_core::topology::INFINITE;
use ltbw_domain::{Domain, Lattice};
use ltbw_refine::{ComplexError, Delegated, Refiner};
use std::time::Instant;

/// Refines a domain without rounds as one member of a team, all of whose members are given the same
/// domain and bounds. The mesh depends on the timing. Of the wishes it has no checkpoints.
///
/// # Errors
/// [`RefineError`] if the domain has no mesh, or if a member has failed.
pub fn domain_on_team(
    refiner: &Refiner<'_>,
    (domain, lattice): (&Domain, &Lattice),
    (parallel, cancel): (&Parallel<'_>, &CancelToken),
    team: &mut Team,
    wishes: Wishes<'_>,
) -> Result<TeamEnd<ThreadedDomain>, RefineError> {
    let delegated = refiner.delegate_to(domain, lattice, team.size() as usize * START_EACH);
    // A token is one process's own; whoever was stopped has another start.
    let is_stopped = team.is_any(cancel.is_cancelled()).map_err(of_team)?;
    if is_stopped {
        cancel.cancel();
        // Nobody waits for the first one.
        if !team.is_first() {
            return Ok(TeamEnd::Elsewhere);
        }
        let why = "a run that has stopped before its workers have begun";
        return alone(delegated?, ComplexError::Unsupported(why));
    }
    let Wishes { in_parts, with_exterior, markers, .. } = wishes;
    let ends = Ends { in_parts, with_exterior, markers, fine_step: lattice.fine_step() };
    let ended = by_all(delegated?, parallel, cancel, team, ends);
    if ended.is_err() {
        // Others may wait for this one.
        team.fail();
    }
    ended?
}

/// The refinement by all members, and its end.
///
/// # Errors
/// An error that others may not have heard of; within, one that the first member alone has, in the
/// end.
fn by_all(
    delegated: Delegated<'_>,
    parallel: &Parallel<'_>,
    cancel: &CancelToken,
    team: &mut Team,
    ends: Ends<'_>,
) -> Result<Result<TeamEnd<ThreadedDomain>, RefineError>, RefineError> {
    let (complex, start) = match delegated.complex() {
        Ok(whole) => whole,
        Err(_) if !team.is_first() => return elsewhere(team, cancel).map(Ok),
        Err(why) => return team.work_alone(cancel, || alone(delegated, why)).map_err(of_team),
    };
    let layout = parallel.plan_for(start.points.len());
    let (nodes, common) = begin::<Correct>(complex, &start, layout, parallel.config())?;
    let me = team.me();
    let node: DomainNode<'_, Correct> =
        nodes.into_iter().nth(me.index()).ok_or_else(|| of_team(TeamError::Failed(me)))?;
    let (node, stats) = parallel.run_on(team, node)?;
    let since = Instant::now();
    // A member that was stopped may have ended before the others heard of it.
    let is_cut = node.has_dropped_points() || cancel.is_cancelled();
    let is_cut = team.is_any(is_cut).map_err(of_team)?;
    if is_cut {
        cancel.cancel();
    }
    let (mesh, source, _) = node.into_parts();
    let (splits, left) = (source.splits, Left::nothing(me));
    let ended = Ended { mesh: &mesh, left: &left, start: &start };
    let own = Own::new(stats, ends).without_rounds(splits);
    let look = || match () {
        () if is_cut => Err(Late::Stopped),
        () if splits.refused != [0; 2] => Err(Late::Refused),
        () => look(&mesh, &left, &delegated),
    };
    let why = match ended.stay(team, &delegated, own, look).map_err(of_team)? {
        Stays::Part(part) => return Ok(Ok(TeamEnd::Part(part))),
        Stays::Not(why) => why,
    };
    let part = Part::of(mesh);
    if !team.is_first() {
        let parcel = Parcel::of(part, stats, |_| splits);
        team.send_parcel(&parcel).map_err(of_team)?;
        return elsewhere(team, cancel).map(Ok);
    }
    let Collected { parts, stats: workers } =
        Collected::at_first(team, part, splits, stats, &common)?;
    let mut splits = Splits::default();
    let add = |(part, own): (Part, Splits)| {
        splits.add(&own);
        part
    };
    let parts: Vec<Part> = parts.into_iter().map(add).collect();
    let finite = |part: &Part| part.mesh.tets().tets().filter(|(_, v)| v[3] != INFINITE).count();
    let tets = parts.iter().map(|part| finite(part) as u64).sum();
    let on_alone = || end(delegated, parts, common, &start);
    let ended = team.work_alone(cancel, on_alone).map_err(of_team)?;
    let late = LateSteps { why, tets, seconds: since.elapsed().as_secs_f64() };
    Ok(ended.map(|(refined, owners)| {
        let whole = ThreadedDomain { refined, workers, owners, splits: Ok(splits) };
        TeamEnd::Whole(Box::new(whole), late)
    }))
}

/// The end of another one, when the first one has gone on alone.
fn elsewhere(
    team: &mut Team,
    cancel: &CancelToken,
) -> Result<TeamEnd<ThreadedDomain>, RefineError> {
    team.wait_for_first(cancel).map_err(of_team)?;
    Ok(TeamEnd::Elsewhere)
}

/// The end of a domain that the first one refines alone.
fn alone(
    delegated: Delegated<'_>,
    why: ComplexError,
) -> Result<TeamEnd<ThreadedDomain>, RefineError> {
    let since = Instant::now();
    let refined = delegated.go_on()?;
    let tets = refined.mesh().num_tets() as u64;
    let late = LateSteps { why: Late::Alone, tets, seconds: since.elapsed().as_secs_f64() };
    let (workers, owners) = (Vec::<WorkerStats>::new(), Owners::default());
    let whole = ThreadedDomain { refined, workers, owners, splits: Err(why) };
    Ok(TeamEnd::Whole(Box::new(whole), late))
}
