//! Rounds of a domain's refinement on many workers: one mesh, whatever their number and the timing.
//!
//! The sequential engine brings the boundary into the mesh and refines to where rounds begin; then
//! workers own parts of it. In each round they choose points together, by the rules of the engine
//! with one mesh (`docs/rounds.md`), and then insert them by the protocol, in any order. What a
//! worker needs of others' parts it asks for by *probes*, which read and lock nothing; the cavity
//! of a candidate is *reserved* where it lies; and each worker decides for its own candidates,
//! from what is reserved in their closures. The mesh is the engine's, to the last tetrahedron.
//!
//! Boundary items that are to be split are kept by the worker whose block their first corner is in,
//! so that each is known to one, whoever asks for it.
//!
//! Work on the whole mesh is left to the engine, which takes over when nothing else is left: late
//! steps where something cannot be split.
//!
//! | module | what it holds |
//! |---|---|
//! | `source` | what a worker knows and is told |
//! | `stages` | the stages of a round |
//! | `figures` | the figures of rounds, and how they end |
//! | `mail` | news on their way out |
//! | `tree` | barriers with sums |
//! | `under_way` | which messages a barrier waits for |
//! | `keys`, `ranked` | which tetrahedra come before all around them |
//! | `candidate` | probes and candidates as values |
//! | `probe` | the home's side of the choice: probes and what comes of them |
//! | `circles`, `borrowed` | boundary items that wait for each other |
//! | `barriers`, `blocks` | subfaces that bar many tetrahedra |
//! | `beyond` | which sides of a tetrahedron are subfaces, where others know the regions beyond |
//! | `leaders` | which of several with nearly equal spheres is probed |
//! | `ahead`, `found` | cavities found while others are waited for |
//! | `here` | closures that are all one worker's |
//! | `decide` | who is chosen |
//! | `ruled` | the verdict on a probe's point |
//! | `contest`, `conduct`, `turns` | turns at patches: by the conductor, and at home |
//! | `slivers`, `tried` | when all bounds are met: slivers, and the points tried for them |
//! | `demands` | boundary items to be split, and who waits for whom |
//! | `refused` | what cannot be split, and who knows |
//! | `left` | what workers are given, and leave |
//! | `pace`, `redeal`, `deal` | when cuts move, and to where; what goes along; all workers' part |
//! | `serve` | the owner's side |
//! | `reserved` | who has reserved what |
//! | `way` | straight ways to proposed points |
//! | `checkpoint` | parts between two rounds as bytes, and what they make again |
//! | `ranks`, `simulated` | a worker in each process of a team; on simulated processors |
//! | `late`, `parts` | what takes the whole mesh in the end; processes that keep their parts |
//! | `ends` | what each member of a team has in the end |

mod ahead;
mod barriers;
mod beyond;
mod blocks;
mod borrowed;
mod candidate;
#[cfg(feature = "wire")]
mod checkpoint;
mod circles;
mod conduct;
mod contest;
mod deal;
mod decide;
mod demands;
#[cfg(feature = "wire")]
mod ends;
mod figures;
mod found;
mod here;
mod keys;
mod late;
mod leaders;
mod left;
mod mail;
mod pace;
#[cfg(feature = "wire")]
mod parts;
mod probe;
mod ranked;
#[cfg(feature = "wire")]
mod ranks;
mod redeal;
mod refused;
mod reserved;
mod ruled;
mod serve;
mod simulated;
mod slivers;
mod source;
mod stages;
mod tree;
mod tried;
mod turns;
mod under_way;
mod way;

#[cfg(feature = "wire")]
pub use ends::{LateSteps, TeamEnd};
pub use figures::{Ending, RoundFigures};
pub use late::Late;
pub(super) use late::look;
#[cfg(feature = "wire")]
pub(super) use parts::{Ended, Ends, Own, Stays};
#[cfg(feature = "wire")]
pub use parts::{PartMesh, RefinedPart, RefinedWhole, SliverThere};
#[cfg(feature = "wire")]
pub use ranks::{Checkpoints, Pieces, TeamRounds, Wishes, rounds_on_team};
pub use reserved::{InnerCandidate, unkilled};
pub use simulated::{SimulatedRounds, simulate_rounds, simulate_rounds_as};
pub use source::Rounds;
pub use tree::{SENT, Step, TAKEN, Tree, is_quiet};

use self::deal::{Common, Here, redeal};
use self::pace::Pace;
use super::RefineError;
use super::domain::{DomainMesh, prepare};
use super::whole::{Owners, Part, Whole, put_together};
use crate::balance::Workload;
use crate::mesh::redeal::Moved;
use crate::mesh::{Layout, SharedInput};
use crate::protocol::{BlockId, Config, Correct, Rules, Worker, WorkerId};
use crate::threads::{Parallel, WorkerStats};
use ltbw_core::topology::TetId;
use ltbw_domain::quality::LeastAngles;
use ltbw_domain::{Domain, Lattice};
use ltbw_refine::{
    Asked, Block, Complex, ComplexError, Delegated, Handed, ItemPlace, RefineStats, Refined,
    Refiner, Refusal, Remaining, Start,
};

/// A worker that refines a domain in rounds.
pub type RoundNode<'c, C> = Worker<DomainMesh<'c>, Rounds<C>, C>;

/// A domain that threads have refined in rounds.
#[derive(Debug)]
pub struct ThreadedRounds {
    /// The refined domain.
    pub refined: Refined,
    /// The figures of each worker; of none if one thread has refined all.
    pub workers: Vec<WorkerStats>,
    /// The workers that have its tetrahedra.
    pub owners: Owners,
    /// The end of the workers' rounds, or why they carried out none.
    pub ending: Result<Ending, ComplexError>,
    /// The figures of their rounds.
    pub figures: RoundFigures,
}

/// The work that workers leave to one, how they have ended, and the first slot of each.
type All = (Handed, Ending, Vec<usize>);

/// A refinement at its end.
struct AllRounds {
    refined: Refined,
    /// The end of the workers' rounds, or why there were none.
    ending: Result<Ending, ComplexError>,
    figures: RoundFigures,
    /// The first slot of each worker.
    firsts: Vec<usize>,
    /// Why workers could not have kept their parts, if that was asked.
    late: Option<Late>,
}

/// The state from which workers go on in rounds.
#[derive(Default)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
struct Resumed {
    left: Remaining,
    figures: RoundFigures,
    /// The rounds after which they stop.
    border: Option<u64>,
}

/// The next thing when workers have ended.
enum Then {
    /// They go on.
    Workers(Box<Resumed>),
    /// Something is left to one processor, or nothing.
    One(Option<Box<Handed>>),
}

/// All workers.
type Nodes<'c, C> = Vec<RoundNode<'c, C>>;

/// Workers, and what they have in common.
type Begun<'c, C> = (Vec<RoundNode<'c, C>>, SharedInput);

/// The work that one worker leaves, beside its part of the mesh.
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Left {
    worker: WorkerId,
    asked: Vec<Asked>,
    /// All boundary items that were refused.
    refused: Vec<(ItemPlace, Refusal)>,
    /// Its tetrahedra that were refused.
    refused_tets: Vec<(TetId, Refusal)>,
    /// Candidates among the tetrahedra when last counted.
    candidates: usize,
    /// The transactions of joint steps in rounds so far.
    spent: usize,
    /// Its tetrahedra that may have tiny dihedral angles.
    thin: Vec<TetId>,
    /// If rounds of slivers have begun, those of its tetrahedra that are still to be looked at.
    slivers: Option<Vec<TetId>>,
    /// If so and asked, its tetrahedra before by their smallest dihedral angle.
    before_slivers: Option<LeastAngles>,
    /// The blocks, which all keep.
    blocks: Vec<Block>,
    ending: Option<Ending>,
    figures: RoundFigures,
}

/// A refinement in rounds by workers, whichever way they run: `run` is given them, with what a
/// redeal before has taken, and gives them back. If `looks`, it is told why they could not have
/// kept their parts.
///
/// # Errors
/// Those of `run`; [`RefineError`] if the domain has no mesh.
fn refine<'a, C: Rules>(
    refiner: &Refiner<'a>,
    (domain, lattice): (&Domain, &Lattice),
    layout: impl Fn(usize) -> (Layout, Config),
    mut run: impl FnMut(Nodes<'a, C>, &[Moved]) -> Result<Nodes<'a, C>, RefineError>,
    looks: bool,
) -> Result<AllRounds, RefineError> {
    let mut delegated = refiner.delegate(domain, lattice)?;
    let mut resumed = Resumed::default();
    let (mut firsts, mut told, mut late) = (Vec::new(), Ending::Done, None);
    // Ends: slivers are left once.
    loop {
        let (complex, start) = match delegated.complex() {
            Ok(whole) => whole,
            Err(unfit) => {
                let (refined, figures) = (delegated.go_on()?, resumed.figures);
                return Ok(AllRounds { refined, ending: Err(unfit), figures, firsts, late });
            }
        };
        let (layout, config) = layout(start.points.len());
        let (workers, common) = begin(complex, &start, (layout, config), &resumed)?;
        let mut workers = run(workers, &[])?;
        // Ends: a round is between two redeals.
        while deal::is_due(&workers) {
            let own = Common { points: &common.points, layout, config };
            let (next, moved) = redeal(workers, own, &mut Here)?;
            workers = run(next, &moved)?;
        }
        late = None;
        let left = workers.into_iter().map(|worker| {
            let (mesh, left) = ended_by(worker);
            let why = looks.then(|| look(&mesh, &left, &delegated).err()).flatten();
            late = late.into_iter().chain(why).min();
            (Part::of(mesh), left)
        });
        let left = left.collect();
        let mut figures = resumed.figures;
        let (handed, ending, slots) =
            join(left, common, (&start, delegated.stats()), &mut figures)?;
        firsts = slots;
        figures.ended += 1;
        let then = go_on(&mut delegated, handed, (ending, figures))?;
        told = told_of(told, ending);
        match then {
            Then::Workers(left) => resumed = *left,
            Then::One(left) => {
                let refined = finish(delegated, left)?;
                return Ok(AllRounds { refined, ending: Ok(told), figures, firsts, late });
            }
        }
    }
}

/// One processor takes over when workers have ended, and may leave slivers to them, once.
fn go_on(
    delegated: &mut Delegated<'_>,
    handed: Handed,
    (ending, figures): (Ending, RoundFigures),
) -> Result<Then, RefineError> {
    let left = match ending {
        Ending::Cancelled => return Ok(Then::One(Some(Box::new(handed)))),
        _ if handed.slivers.is_some() => return Ok(Then::One(Some(Box::new(handed)))),
        _ => delegated.go_to_slivers(handed)?,
    };
    let resumed = |left| Then::Workers(Box::new(Resumed { left, figures, border: None }));
    Ok(left.map_or(Then::One(None), resumed))
}

/// The ending that is told of, after one before: the first that left something undone.
fn told_of(before: Ending, next: Ending) -> Ending {
    match before {
        Ending::Done => next,
        before => before,
    }
}

/// The refinement at its end, with what is left to one processor.
fn finish(delegated: Delegated<'_>, left: Option<Box<Handed>>) -> Result<Refined, RefineError> {
    Ok(match left {
        Some(handed) => delegated.finish(*handed)?,
        None => delegated.ended()?,
    })
}

/// Refines a domain in rounds by workers that `run` brings to their end, one event at a time: for
/// checkers, who choose what happens when. It may be called more than once.
///
/// # Errors
/// Those of `run`; [`RefineError`] if the domain has no mesh.
#[doc(hidden)]
pub fn rounds_by<'a, C: Rules>(
    refiner: &Refiner<'a>,
    whole: (&Domain, &Lattice),
    layout: impl Fn(usize) -> (Layout, Config),
    mut run: impl FnMut(Vec<RoundNode<'a, C>>) -> Result<Vec<RoundNode<'a, C>>, RefineError>,
) -> Result<(Refined, Result<Ending, ComplexError>), RefineError> {
    let run = |workers, _: &[Moved]| run(workers);
    let AllRounds { refined, ending, .. } = refine::<C>(refiner, whole, layout, run, false)?;
    Ok((refined, ending))
}

/// Refines a domain in rounds on the threads of `parallel`, which share no mesh.
///
/// # Errors
/// [`RefineError`] if the domain has no mesh, or if a worker has failed.
pub fn rounds_on_threads(
    refiner: &Refiner<'_>,
    whole: (&Domain, &Lattice),
    parallel: &Parallel<'_>,
) -> Result<ThreadedRounds, RefineError> {
    let mut workers: Vec<WorkerStats> = Vec::new();
    let layout = |points| (parallel.plan_for(points), parallel.config());
    let run = |nodes, _: &[Moved]| {
        let ended = parallel.run_workers(nodes)?;
        workers.resize(ended.len(), WorkerStats::default());
        let add = |((node, stats), sum): ((_, WorkerStats), &mut WorkerStats)| {
            sum.add(&stats);
            node
        };
        Ok(ended.into_iter().zip(&mut workers).map(add).collect())
    };
    let all = refine::<Correct>(refiner, whole, layout, run, false)?;
    let AllRounds { refined, ending, figures, firsts, .. } = all;
    Ok(ThreadedRounds { refined, workers, owners: Owners(firsts), ending, figures })
}

/// Workers at the begin of their rounds, each with its part of the start.
fn begin<'c, C: Rules>(
    complex: Complex<'c>,
    start: &Start,
    (layout, config): (Layout, Config),
    resumed: &Resumed,
) -> Result<Begun<'c, C>, RefineError> {
    let before = start.made();
    // Of a start that does not fit, which `prepare` refuses, there may be fewer.
    let others = (start.points.len() as u64).saturating_sub(before);
    let source = |me, mesh: &mut DomainMesh<'_>| {
        let (workers, blocks_each) = (layout.workers, layout.blocks_per_worker);
        let among = source::Among { me, workers, blocks_each };
        let mut source = Rounds::new(among, [before, start.most, others], mesh);
        source.expect_tets(start.expected_of(layout.workers));
        source.resume(mesh, &resumed.left, resumed.figures);
        if source.figures.started == 0 {
            source.figures.started = start.points.len() as u64;
        }
        source.border = resumed.border;
        source.pace = Pace::new(layout.redeal, layout.workers);
        source
    };
    prepare(complex, start, &layout, config, source)
}

/// The mesh of a worker at the end of its rounds, and the work that it leaves.
fn ended_by<C: Rules>(worker: RoundNode<'_, C>) -> (DomainMesh<'_>, Left) {
    let (mesh, source, _) = worker.into_parts();
    let left = source.into_left(&mesh);
    (mesh, left)
}

/// The tetrahedra of all workers by their smallest dihedral angle, if they have begun with slivers
/// and were asked.
fn counted(mut all: impl Iterator<Item = Option<LeastAngles>>) -> Option<LeastAngles> {
    all.try_fold(LeastAngles::default(), |sum, own| Some(sum.merged(own?)))
}

/// Puts together what workers leave; `before` are the figures when they began, `figures` all.
fn join(
    all: Vec<(Part, Left)>,
    common: SharedInput,
    (start, before): (&Start, RefineStats),
    figures: &mut RoundFigures,
) -> Result<All, RefineError> {
    let (mut parts, mut asked, mut all_thin) = (Vec::new(), Vec::new(), Vec::new());
    let (mut refused, mut all_tets, mut all_slivers) = (Vec::new(), Vec::new(), Some(Vec::new()));
    let (mut ending, mut candidates, mut spent, mut blocks) = (Ending::Done, 0, 0, Vec::new());
    let (begin, mut told) = (*figures, Vec::new());
    let before_slivers = counted(all.iter().map(|(_, left)| left.before_slivers));
    for (part, left) in all {
        all_thin.push(left.thin);
        // All have begun with slivers, or none.
        all_slivers = all_slivers.zip(left.slivers).map(|(mut all, own): (Vec<_>, _)| {
            all.push(own);
            all
        });
        all_tets.push(left.refused_tets);
        asked.extend(left.asked);
        match left.worker == WorkerId::default() {
            true => told.insert(0, left.figures),
            false => told.push(left.figures),
        }
        if left.worker == WorkerId::default() {
            ending = left.ending.unwrap_or(Ending::Irregular);
            (candidates, refused) = (left.candidates, left.refused);
            (blocks, spent) = (left.blocks, left.spent);
        }
        parts.push(part);
    }
    *figures = RoundFigures::summed(&told, begin);
    let Whole { mesh, carriers, regions, firsts } = put_together(parts, common, start)?;
    let before_slivers = before.before_slivers.or(before_slivers);
    let stats = RefineStats { before_slivers, ..figures.after(&begin, before) };
    let tets = firsts.iter().zip(all_tets).flat_map(|(first, own)| {
        own.into_iter().map(move |(t, why)| (TetId::at(first + t.index()), why))
    });
    let refused_tets = tets.collect();
    let in_whole = |all: Vec<Vec<TetId>>| -> Vec<TetId> {
        let all = firsts.iter().zip(all);
        all.flat_map(|(first, own)| own.into_iter().map(move |t| TetId::at(first + t.index())))
            .collect()
    };
    let slivers = all_slivers.map(in_whole);
    // Workers look at all that they make, and have ended as none was over its bounds.
    let thin = (ending == Ending::Done).then(|| in_whole(all_thin));
    let handed = Handed {
        mesh,
        carriers,
        regions,
        asked,
        refused,
        refused_tets,
        candidates,
        spent,
        thin,
        slivers,
        blocks,
        stats,
    };
    Ok((handed, ending, firsts))
}

impl<C> Workload for Rounds<C> {
    fn left(&self) -> u64 {
        self.points.chosen.len() as u64
    }

    fn in_block(&self, _: BlockId) -> u64 {
        0
    }

    /// A round is as long as its slowest worker.
    fn is_waited_for(&self) -> bool {
        true
    }
}
