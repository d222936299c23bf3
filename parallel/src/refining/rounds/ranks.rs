//! Rounds by a worker in each process of a team: all begin from the same start. In the end each
//! keeps its part; where something is left that takes the whole mesh the first one puts together
//! what they leave, as it does with threads.

use super::checkpoint::{self, Head, Kept};
use super::deal::{self, Common, Exchange, To, Value, past_border, redeal};
use super::ends::{LateSteps, TeamEnd};
use super::figures::RoundFigures;
use super::late::{self, Late};
use super::parts::{Ended, Ends, Own, Stays};
use super::{
    Ending, Left, Resumed, RoundNode, Then, ThreadedRounds, begin, ended_by, finish, go_on, join,
    told_of,
};
use crate::mesh::SharedInput;
use crate::protocol::{Config, Correct, WorkerId};
use crate::refining::RefineError;
use crate::refining::domain::DomainMesh;
use crate::refining::parcel::{Collected, Parcel, of_team};
use crate::refining::whole::{Owners, Part};
use crate::team::{Team, TeamError};
use crate::threads::{Parallel, WorkerStats};
use crate::wire::{bytes_of, value_of};
use ltbw_core::CancelToken;
use ltbw_domain::{Domain, Lattice};
use ltbw_refine::{Complex, ComplexError, Delegated, RefineStats, Refiner, Start};
use std::time::Instant;

/// The state in which workers go on after another one has taken over, with the mesh as it is then.
type Again = Option<(Start, Resumed)>;

/// The pieces of a checkpoint as they arrive, up to the last one or to an error.
pub type Pieces<'p> = dyn Iterator<Item = Result<Vec<u8>, TeamError>> + 'p;

/// A function that takes the number of rounds so far, and a checkpoint.
type Keep<'k> = &'k dyn Fn(u64, &mut Pieces<'_>);

/// The checkpoints of a refinement in rounds: those of the first member count.
#[derive(Clone, Copy, Default)]
pub struct Checkpoints<'k> {
    /// Rounds from one to the next. There are none if it is 0.
    pub every: u64,
    /// The one to go on from: of this domain and these bounds, and of this build.
    pub from: Option<&'k [Vec<u8>]>,
    /// Takes each, with the number of rounds before it.
    pub keep: Option<Keep<'k>>,
}

impl std::fmt::Debug for Checkpoints<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Checkpoints").field("every", &self.every).finish_non_exhaustive()
    }
}

/// The things that are asked for beside a mesh: the same at all members, but for checkpoints.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wishes<'k> {
    /// Checkpoints on the way.
    pub checkpoints: Checkpoints<'k>,
    /// Each member keeps its part, where nothing is left that takes the whole mesh.
    pub in_parts: bool,
    /// Such a part is wanted with the exterior, too.
    pub with_exterior: bool,
    /// Markers of the domain's facets in place of their own.
    pub markers: Option<&'k [i32]>,
}

/// A domain that a team has refined in rounds, as one member has it.
pub type TeamRounds = TeamEnd<ThreadedRounds>;

/// Refines a domain in rounds as one member of a team, all of whose members are given the same
/// domain and bounds.
///
/// # Errors
/// [`RefineError`] if the domain has no mesh, if a member has failed, or if a checkpoint makes no
/// sense.
pub fn rounds_on_team(
    refiner: &Refiner<'_>,
    (domain, lattice): (&Domain, &Lattice),
    (parallel, cancel): (&Parallel<'_>, &CancelToken),
    team: &mut Team,
    Wishes { checkpoints, in_parts, with_exterior, markers }: Wishes<'_>,
) -> Result<TeamRounds, RefineError> {
    let delegated = refiner.delegate(domain, lattice);
    // A token is one process's own; whoever was stopped has another start.
    let is_stopped = team.is_any(cancel.is_cancelled()).map_err(of_team)?;
    if is_stopped {
        cancel.cancel();
    }
    let stats = WorkerStats::default();
    let is_first = team.is_first();
    let kept = match (&delegated, checkpoints.from) {
        (Ok(own), Some(pieces)) if is_first && !is_stopped => kept(own, pieces),
        _ => Ok(None),
    };
    if kept.is_err() {
        // The others wait to be told of it.
        team.fail();
    }
    let (stats_then, from) = match kept? {
        Some(Kept { start, resumed, stats }) => (Some(stats), Some((start, resumed))),
        None => (None, None),
    };
    let told: Option<(u64, Again)> = is_first.then_some((checkpoints.every, from));
    let (every, from) = team.tell_value(told).map_err(of_team)?;
    let ends = Ends { in_parts, with_exterior, markers, fine_step: lattice.fine_step() };
    let (keep, before) = (checkpoints.keep, RefineStats::default());
    let mut member = Member { parallel, cancel, team, stats, every, keep, before, ends };
    match delegated {
        own if is_first => {
            let mut own = own?;
            if let Some(stats) = stats_then {
                own.go_on_from(stats);
            }
            let ended = member.lead(own, is_stopped, from);
            if ended.is_err() {
                // The others may wait for this one.
                member.team.fail();
            }
            ended?
        }
        _ if is_stopped => Ok(TeamRounds::Elsewhere),
        own => member.follow(&own?, from),
    }
}

/// The state that a checkpoint of this refinement is of; none if others have nothing to do in it.
fn kept(delegated: &Delegated<'_>, pieces: &[Vec<u8>]) -> Result<Option<Kept>, RefineError> {
    match delegated.complex() {
        Ok((_, start)) => checkpoint::read(pieces, start).map(Some),
        Err(_) => Ok(None),
    }
}

/// One member's part in a refinement.
struct Member<'m, 'p> {
    parallel: &'m Parallel<'p>,
    cancel: &'m CancelToken,
    team: &'m mut Team,
    stats: WorkerStats,
    /// Rounds from one checkpoint to the next, if there are any.
    every: u64,
    /// The first one's: the taker of checkpoints.
    keep: Option<Keep<'m>>,
    /// The figures of the refinement when these rounds began, at the first one.
    before: RefineStats,
    ends: Ends<'p>,
}

/// A member's mesh at the end of its rounds, the work that it leaves, and what all begin with.
struct Rest<'c> {
    mesh: DomainMesh<'c>,
    left: Left,
    common: SharedInput,
}

/// The way of values between the members of a team.
struct OnTeam<'t>(&'t mut Team);

impl Exchange for OnTeam<'_> {
    fn to_all<T: Value>(&mut self, own: Vec<T>) -> Result<Vec<T>, RefineError> {
        let Some(own) = own.into_iter().next() else { return Ok(Vec::new()) };
        self.0.gather_all(&own).map_err(of_team)
    }

    fn to_some<T: Value>(&mut self, own: Vec<To<T>>) -> Result<Vec<To<T>>, RefineError> {
        let mut parts = vec![Vec::new(); self.0.size() as usize];
        for (to, value) in own.into_iter().flatten() {
            if let Some(part) = parts.get_mut(to.index()) {
                *part = bytes_of(&value, self.0.me()).map_err(of_team)?;
            }
        }
        let all = self.0.exchange(parts).map_err(of_team)?;
        let sent = WorkerId::below(all.len() as u32).zip(&all).filter(|(_, own)| !own.is_empty());
        let values = sent.map(|(from, bytes)| Ok((from, value_of(from, bytes).map_err(of_team)?)));
        Ok(vec![values.collect::<Result<To<T>, RefineError>>()?])
    }
}

impl Member<'_, '_> {
    /// Carries out its part of rounds, from a start on to where one takes over.
    fn refine<'c>(
        &mut self,
        complex: Complex<'c>,
        start: &Start,
        resumed: &mut Resumed,
    ) -> Result<Rest<'c>, RefineError> {
        let before = resumed.figures.rounds[0];
        resumed.border = (self.every > 0).then(|| before.saturating_add(self.every));
        let (layout, config) = (self.parallel.plan_for(start.points.len()), self.parallel.config());
        let (nodes, common) = begin::<Correct>(complex, start, (layout, config), resumed)?;
        let me = self.team.me();
        let none = || of_team(TeamError::Failed(me));
        let mut node: RoundNode<'c, Correct> =
            nodes.into_iter().nth(me.index()).ok_or_else(none)?;
        // Ends: a round is between two redeals.
        let node = loop {
            let (ended, stats) = self.parallel.run_on(self.team, node)?;
            self.stats.add(&stats);
            if ended.source().ending == Some(Ending::Border) {
                let next = ended.source().figures.rounds[0].saturating_add(self.every);
                let kept = self.keep_part(&ended, resumed.figures);
                if kept.is_err() {
                    // Others may wait for this one.
                    self.team.fail();
                }
                kept?;
                node = past_border(ended, Config { workers: layout.workers, ..config }, next);
                continue;
            }
            if !deal::is_due(std::slice::from_ref(&ended)) {
                break ended;
            }
            let own = Common { points: &common.points, layout, config };
            let dealt = redeal(vec![ended], own, &mut OnTeam(self.team));
            if dealt.is_err() {
                // Others may wait for this one.
                self.team.fail();
            }
            node = dealt?.0.pop().ok_or_else(none)?;
        };
        let (mesh, left) = ended_by(node);
        Ok(Rest { mesh, left, common })
    }

    /// Writes this member's part at a border: the first one asks for those of all in turn, so that
    /// it has one at a time.
    fn keep_part(
        &mut self,
        node: &RoundNode<'_, Correct>,
        begin: RoundFigures,
    ) -> Result<(), RefineError> {
        // Nobody goes on before all have stopped: a letter of the next rounds would be lost.
        let told = self.team.gather_all(&node.source().figures).map_err(of_team)?;
        let own = checkpoint::slice_of(node)?;
        let first = WorkerId::default();
        if !self.team.is_first() {
            self.team.receive(first).map_err(of_team)?;
            self.team.send(first, &own);
            return Ok(());
        }
        let head = Head::of(node, &told, begin, self.before).into_bytes()?;
        let others = WorkerId::below(self.team.size()).skip(1);
        let mut failed = None;
        let mut theirs = others.map_while(|from| {
            if failed.is_some() {
                return None;
            }
            self.team.send(from, &[]);
            let piece = self.team.receive(from);
            failed = piece.as_ref().err().cloned();
            Some(piece)
        });
        let mut pieces = [head, own].into_iter().map(Ok).chain(theirs.by_ref());
        if let Some(keep) = self.keep {
            keep(node.source().figures.rounds[0], &mut pieces);
        }
        // A checkpoint that cannot be written has its letters, too.
        while let Some(Ok(_)) = pieces.next() {}
        drop(pieces);
        drop(theirs);
        failed.map_or(Ok(()), |error| Err(of_team(error)))
    }

    /// Work of the first one that the others wait for.
    fn alone<T: Send>(&mut self, work: impl FnOnce() -> T + Send) -> Result<T, RefineError> {
        self.team.work_alone(self.cancel, work).map_err(of_team)
    }

    /// The end of another one, when the first one has gone on alone.
    fn elsewhere(&mut self) -> Result<TeamRounds, RefineError> {
        self.team.wait_for_first(self.cancel).map_err(of_team)?;
        Ok(TeamRounds::Elsewhere)
    }

    /// Lets all members keep their parts, if each may.
    fn stay(
        &mut self,
        rest: &Rest<'_>,
        delegated: &Delegated<'_>,
        (start, resumed): (&Start, &Resumed),
    ) -> Result<Stays, RefineError> {
        let Rest { mesh, left, .. } = rest;
        let ended = Ended { mesh, left, start };
        let own = Own::new(self.stats, self.ends).after(resumed.figures);
        ended.stay(self.team, delegated, own, || late::look(mesh, left, delegated)).map_err(of_team)
    }

    /// The first one's: puts together what all leave, and takes over.
    ///
    /// # Errors
    /// An error that the others may not have heard of; within, one of what it does alone in the
    /// end, when they have left.
    fn lead(
        &mut self,
        mut delegated: Delegated<'_>,
        is_stopped: bool,
        mut from: Again,
    ) -> Result<Result<TeamRounds, RefineError>, RefineError> {
        let (mut resumed, mut firsts, mut workers) = (Resumed::default(), Vec::new(), Vec::new());
        let mut ended = Ending::Done;
        let (mut late, mut since) = (Late::Alone, Instant::now());
        let mut tets = None;
        // Ends as with threads: slivers are left once.
        let (refined, ending) = loop {
            let whole = match is_stopped {
                true => Err(ComplexError::Unsupported("a run that has stopped before the rounds")),
                false => delegated.complex(),
            };
            let (complex, mut start) = match whole {
                Ok(whole) => whole,
                // The others do not wait.
                Err(unfit) if is_stopped => {
                    break (delegated.go_on().map_err(RefineError::from), Err(unfit));
                }
                Err(unfit) => {
                    let refined = self.alone(|| delegated.go_on().map_err(RefineError::from))?;
                    break (refined, Err(unfit));
                }
            };
            if let Some(kept) = from.take() {
                (start, resumed) = kept;
            }
            self.before = delegated.stats();
            let rest = self.refine(complex, &start, &mut resumed)?;
            since = Instant::now();
            match self.stay(&rest, &delegated, (&start, &resumed))? {
                Stays::Part(part) => return Ok(Ok(TeamRounds::Part(part))),
                Stays::Not(why) => late = why,
            }
            let Rest { mesh, left, common } = rest;
            let part = Part::of(mesh);
            let Collected { parts: all, stats } =
                Collected::at_first(self.team, part, left, self.stats, &common)?;
            workers = stats;
            let before = (&start, delegated.stats());
            let (handed, ending, slots) = join(all, common, before, &mut resumed.figures)?;
            firsts = slots;
            tets = Some(handed.mesh.num_tets() as u64);
            resumed.figures.ended += 1;
            ended = told_of(ended, ending);
            let figures = resumed.figures;
            match self.alone(|| go_on(&mut delegated, handed, (ending, figures)))?? {
                Then::One(left) => {
                    self.team.tell_value(Some(None::<(Start, Resumed)>)).map_err(of_team)?;
                    break (self.alone(|| finish(delegated, left))?, Ok(ended));
                }
                Then::Workers(left) => {
                    let again: Again = Some((delegated.complex()?.1, *left));
                    let told = self.team.tell_value(Some(again)).map_err(of_team)?;
                    resumed = told.map(|(_, resumed)| resumed).unwrap_or_default();
                }
            }
        };
        let refined = match refined {
            Ok(refined) => refined,
            Err(error) => return Ok(Err(error)),
        };
        let (owners, figures) = (Owners(firsts), resumed.figures);
        let tets = tets.unwrap_or_else(|| refined.mesh().num_tets() as u64);
        let late = LateSteps { why: late, tets, seconds: since.elapsed().as_secs_f64() };
        let whole = ThreadedRounds { refined, workers, owners, ending, figures };
        Ok(Ok(TeamRounds::Whole(Box::new(whole), late)))
    }

    /// The others': each keeps its part, or sends it with what it leaves, and goes on where the
    /// first one says.
    fn follow(
        &mut self,
        delegated: &Delegated<'_>,
        from: Again,
    ) -> Result<TeamRounds, RefineError> {
        let Ok((complex, start)) = delegated.complex() else {
            // The first one refines it alone.
            return self.elsewhere();
        };
        let begin = from.unwrap_or_else(|| (start, Resumed::default()));
        let (mut complex, mut again) = (complex, begin);
        // Ends with the first one's loop.
        loop {
            let rest = self.refine(complex, &again.0, &mut again.1)?;
            if let Stays::Part(part) = self.stay(&rest, delegated, (&again.0, &again.1))? {
                return Ok(TeamRounds::Part(part));
            }
            let parcel = Parcel::of(Part::of(rest.mesh), self.stats, |number| rest.left.by(number));
            self.team.send_parcel(&parcel).map_err(of_team)?;
            self.team.wait_for_first(self.cancel).map_err(of_team)?;
            match self.team.tell_value(None::<Again>).map_err(of_team)? {
                None => return self.elsewhere(),
                Some(told) => again = told,
            }
            // The boundary and the bounds are those at the start.
            complex = delegated.complex()?.0;
        }
    }
}
