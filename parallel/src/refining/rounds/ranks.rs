//! Rounds by a worker in each process of a team: all begin from the same start, and the first one
//! puts together what they leave, as it does with threads.

use super::{
    Ending, Left, Resumed, RoundNode, Then, ThreadedRounds, begin, finish, go_on, join, left_by,
    told_of,
};
use crate::mesh::share::{Share, put_back, share_of};
use crate::mesh::{SharedInput, VertexName};
use crate::protocol::Correct;
use crate::refining::RefineError;
use crate::refining::whole::{Owners, Part};
use crate::team::{Post, Team, TeamError};
use crate::threads::{Parallel, RunError, WorkerStats};
use ltbw_core::CancelToken;
use ltbw_core::topology::TetId;
use ltbw_domain::{Domain, Lattice};
use ltbw_exact::Mode;
use ltbw_refine::{Carrier, Complex, ComplexError, Delegated, Refiner, Start};

/// A worker's part and the work that it leaves, as they travel.
#[derive(serde::Serialize, serde::Deserialize)]
struct Parcel {
    share: Share,
    made: Vec<(VertexName, Carrier)>,
    /// By tetrahedron of the share.
    regions: Vec<u32>,
    /// Tetrahedra have their numbers in the share.
    left: Left,
    stats: WorkerStats,
}

impl Parcel {
    fn of((part, mut left): (Part, Left), stats: WorkerStats) -> Self {
        let (share, slots) = share_of(&part.mesh);
        let region = |t: &TetId| part.regions.get(t.index()).copied().unwrap_or_default();
        let regions = slots.iter().map(region).collect();
        let number = |t: TetId| slots.binary_search(&t).ok().map(TetId::at);
        left.thin = left.thin.into_iter().filter_map(number).collect();
        let slivers = left.slivers.map(|own| own.into_iter().filter_map(number).collect());
        left.slivers = slivers;
        let tets = left.refused_tets.into_iter();
        left.refused_tets = tets.filter_map(|(t, why)| Some((number(t)?, why))).collect();
        Self { share, made: part.made, regions, left, stats }
    }
}

/// An error of a team, among those of a refinement.
fn of_team(error: impl Into<TeamError>) -> RefineError {
    RunError::from(error.into()).into()
}

/// The state in which workers go on after circles were split, with the mesh as it is then.
type Again = Option<(Start, Resumed)>;

/// Refines a domain in rounds as one member of a team, all of whose members are given the same
/// domain and bounds. The first one gets the mesh, the others nothing.
///
/// # Errors
/// [`RefineError`] if the domain has no mesh, or if a member has failed.
pub fn rounds_on_team<P: Post>(
    refiner: &Refiner<'_>,
    (domain, lattice): (&Domain, &Lattice),
    (parallel, cancel): (&Parallel<'_>, &CancelToken),
    team: &mut Team<P>,
) -> Result<Option<ThreadedRounds>, RefineError> {
    let delegated = refiner.delegate(domain, lattice);
    // A token is one process's own; whoever was stopped has another start.
    let is_stopped = team.is_any(cancel.is_cancelled()).map_err(of_team)?;
    if is_stopped {
        cancel.cancel();
    }
    let stats = WorkerStats::default();
    let is_first = team.is_first();
    let member = Member { parallel, team, stats };
    match delegated {
        own if is_first => member.lead(own?, is_stopped).map(Some),
        _ if is_stopped => Ok(None),
        own => member.follow(&own?).map(|()| None),
    }
}

/// One member's part in a refinement.
struct Member<'m, 'p, P> {
    parallel: &'m Parallel<'p>,
    team: &'m mut Team<P>,
    stats: WorkerStats,
}

/// The parts of all members, each with the work that it leaves, and the figures of all.
struct Collected {
    parts: Vec<(Part, Left)>,
    stats: Vec<WorkerStats>,
}

impl<P: Post> Member<'_, '_, P> {
    /// Carries out its part of rounds, from a start on to where one takes over.
    fn refine<'c>(
        &mut self,
        complex: Complex<'c>,
        start: &Start,
        resumed: &Resumed,
    ) -> Result<((Part, Left), SharedInput), RefineError> {
        let layout = (self.parallel.plan_for(start.points.len()), self.parallel.config());
        let (nodes, common) = begin::<Correct>(complex, start, layout, resumed)?;
        let me = self.team.me();
        let node: RoundNode<'c, Correct> =
            nodes.into_iter().nth(me.index()).ok_or_else(|| of_team(TeamError::Failed(me)))?;
        let (node, stats) = self.parallel.run_on(self.team, node)?;
        self.stats.add(&stats);
        Ok((left_by(node), common))
    }

    /// The first one's: puts together what all leave, and takes over.
    fn lead(
        mut self,
        mut delegated: Delegated<'_>,
        is_stopped: bool,
    ) -> Result<ThreadedRounds, RefineError> {
        let (mut resumed, mut firsts, mut workers) = (Resumed::default(), Vec::new(), Vec::new());
        let mut ended = Ending::Done;
        // Ends as with threads: each time at least one item of a circle is split, or refused.
        let (refined, ending) = loop {
            let (complex, start) = match delegated.complex() {
                Ok(whole) if !is_stopped => whole,
                Ok(_) => {
                    let why = "a run that has stopped before the rounds";
                    break (delegated.go_on()?, Err(ComplexError::Unsupported(why)));
                }
                Err(unfit) => break (delegated.go_on()?, Err(unfit)),
            };
            let (left, common) = self.refine(complex, &start, &resumed)?;
            let Collected { parts: all, stats } = self.collect(left, &common)?;
            workers = stats;
            let before = (&start, delegated.stats());
            let (handed, ending, slots) = join(all, common, before, &mut resumed.figures)?;
            firsts = slots;
            resumed.figures.ended += 1;
            ended = told_of(ended, ending);
            match go_on(&mut delegated, handed, (ending, resumed.figures))? {
                Then::One(left) => {
                    self.team.tell_value(Some(None::<(Start, Resumed)>)).map_err(of_team)?;
                    break (finish(delegated, left)?, Ok(ended));
                }
                Then::Workers(left) => {
                    let again: Again = Some((delegated.complex()?.1, *left));
                    let told = self.team.tell_value(Some(again)).map_err(of_team)?;
                    resumed = told.map(|(_, resumed)| resumed).unwrap_or_default();
                }
            }
        };
        let (owners, figures) = (Owners(firsts), resumed.figures);
        Ok(ThreadedRounds { refined, workers, owners, ending, figures })
    }

    /// The others': each sends what it leaves, and goes on where the first one says.
    fn follow(mut self, delegated: &Delegated<'_>) -> Result<(), RefineError> {
        let Ok((complex, start)) = delegated.complex() else {
            // The first one refines it alone.
            return Ok(());
        };
        let (mut complex, mut again) = (complex, (start, Resumed::default()));
        // Ends with the first one's loop.
        loop {
            let (left, _) = self.refine(complex, &again.0, &again.1)?;
            self.team.send_parcel(&Parcel::of(left, self.stats)).map_err(of_team)?;
            match self.team.tell_value(None::<Again>).map_err(of_team)? {
                None => return Ok(()),
                Some(told) => again = told,
            }
            // The boundary and the bounds are those at the start.
            complex = delegated.complex()?.0;
        }
    }

    /// The parts of all members, the work that they leave, and their figures.
    fn collect(
        &mut self,
        own: (Part, Left),
        common: &SharedInput,
    ) -> Result<Collected, RefineError> {
        let (mut stats, mut shares, mut rest) = (vec![self.stats], Vec::new(), Vec::new());
        for (from, parcel) in self.team.parcels::<Parcel>().map_err(of_team)? {
            parcel.share.is_of(from).map_err(RunError::from)?;
            stats.push(parcel.stats);
            shares.push(parcel.share);
            rest.push((parcel.made, parcel.regions, parcel.left));
        }
        // The coordinates at the start are those that the kernel computes with.
        let meshes = put_back(shares, &own.0.mesh, common, Mode::Normal).map_err(RunError::from)?;
        let mut all = vec![own];
        for (mesh, (made, mut regions, left)) in meshes.into_iter().zip(rest) {
            regions.resize(mesh.tets().topology().slots(), 0);
            all.push((Part { mesh, made, regions }, left));
        }
        Ok(Collected { parts: all, stats })
    }
}
