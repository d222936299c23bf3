//! `simulate --domain`: a domain refined in rounds by simulated processors.

use super::report::{Compared, Made, Report};
use super::{
    Run, Simulate, Told, end, failure_of, layout, nothing_to_do, options, options_alone, told,
};
use crate::figures::{Doing, cost_model, tables};
use crate::outcome::{Exit, Failure, show};
use crate::progress::Stage;
use crate::rounds::START;
use crate::streams::Formats;
use crate::surface::Preparation;
use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::mesh::{Layout, Ownership};
use ltbw::metrics::Summary;
use ltbw::protocol::{Closure, Config};
use ltbw::refine::{Order, RefineOutcome, Refiner};
use ltbw::refining::{Ending, Plan, SimulatedRounds, simulate_rounds};
use ltbw::simulate::{Around, Options, Whole};
use ltbw::{Point, canonical_hash};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use std::path::Path;

/// Changes that make more work.
pub(super) const MORE: &str = "a smaller --max-volume or --start makes some";
/// The part of a mesh that is made before many processors go on.
pub(super) const SHARE: usize = 4;
/// Vertices of the smallest mesh of which a part is made by many.
const LEAST: usize = 1024;

/// The bounds that the arguments ask for.
pub(super) fn refiner(args: &Simulate) -> Refiner<'static> {
    let refiner = Refiner::new().radius_edge(args.radius_edge.unwrap_or(2.0));
    args.max_volume.map_or(refiner, |bound| refiner.max_volume(bound))
}

/// The workers of a run: all points are in the mesh that is distributed.
pub(super) fn planned(args: &Simulate, points: usize, processors: u32) -> Plan {
    let (layout, config) = layout(args, points, processors);
    let redeal = args.redeal;
    let layout = Layout { sample: points, max_in_flight: 0, redeal, ..layout };
    Plan { layout, config }
}

/// The workers of a run; one on a single processor has settings of its own: it is what others are
/// compared with.
pub(super) fn planned_run(args: &Simulate, points: usize, processors: u32) -> Plan {
    let Plan { layout, config } = planned(args, points, processors);
    if processors > 1 {
        return Plan { layout, config };
    }
    let layout = Layout { ownership: Ownership::default(), ..layout };
    Plan { layout, config: Config { closure: Closure::default(), ..config } }
}

/// The hash that `mesh` prints: of the domain, without the exterior.
pub(super) fn hash_of(points: &[Point], tets: &[[u32; 4]]) -> Result<String, Failure> {
    let hash = canonical_hash(points, tets);
    Ok(hash.map_err(|error| Failure::Other(error.to_string()))?.to_string())
}

/// `ltbw simulate --domain`.
pub(super) fn simulate(args: &Simulate, path: &Path) -> Result<Exit, Failure> {
    if args.storm.is_some() || args.balance {
        let text = "--storm and --balance move blocks, which rounds do not";
        return Err(Failure::Usage(text.to_owned()));
    }
    if args.order != Order::default() || args.towards != 0.0 {
        let text = "--order and --towards are for --mode async: rounds are of one mesh";
        return Err(Failure::Usage(text.to_owned()));
    }
    let ready = ready(path)?;
    let (told, vertices) = attempt(args, path, &ready, args.start.unwrap_or(START))?;
    // A mesh that is made before rounds begin is begun with a share of it.
    let told = match told {
        None if args.start.is_none() && vertices >= LEAST => {
            attempt(args, path, &ready, vertices / SHARE)?.0
        }
        told => told,
    };
    let told = told.ok_or_else(|| nothing_to_do(MORE))?;
    end(args, told)
}

fn mesh_hash(mesh: &ltbw::Mesh) -> Result<String, Failure> {
    Ok(mesh.hash().map_err(|error| Failure::Other(error.to_string()))?.to_string())
}

/// A run in rounds from as many vertices on, if the processors have anything to insert; and the
/// vertices that there are in the end.
fn attempt(
    args: &Simulate,
    path: &Path,
    ready: &Prepared,
    start: usize,
) -> Result<(Option<Told>, usize), Failure> {
    let refiner = refiner(args).start(start);
    let options = options(args);
    let run = |processors: u32, options: &Options| {
        let planned = |points| planned_run(args, points, processors);
        let _stage = Stage::begin("simulate");
        simulate_rounds(&refiner, &ready.domain, &ready.lattice, &planned, options)
            .map_err(|error| failure_of(path, error))
    };
    let stage = Stage::begin("refine");
    let failed = |error| Failure::Refine { path: path.to_owned(), error };
    let engine = refiner.refine(&ready.domain, &ready.lattice).map_err(failed)?;
    drop(stage);
    let vertices = engine.mesh().num_vertices();
    // Where the start has nearly all, slivers are what is left: no run of interest by itself.
    let least = args.start.map_or(vertices / SHARE, |_| 1).max(1);
    if engine.outcome == RefineOutcome::Unrecovered || engine.stats.round_points < least as u64 {
        return Ok((None, vertices));
    }
    let expected = mesh_hash(engine.mesh())?;
    drop(engine);
    let made = run(args.processors, &options)?;
    let found = mesh_hash(made.refined.mesh())?;
    let summary = match (&made.summary, &made.ending) {
        (_, Err(why)) => {
            return Err(Failure::Usage(format!("{}: one processor refines {why}", show(path))));
        }
        (Some(summary), Ok(_)) if made.figures.points > 0 && summary.operations() > 0 => summary,
        _ => return Ok((None, vertices)),
    };
    let alone = match args.processors {
        1 => summary.clone(),
        _ => {
            let alone = run(1, &options_alone(&options))?.summary;
            alone.ok_or_else(|| Failure::Other("one processor had no rounds".to_owned()))?
        }
    };
    let asked = Asked { args, path, options: &options, start };
    let (json, text) = tell(&asked, &made, summary, &alone)?;
    Ok((Some(Told { json, text, found, expected }), vertices))
}

/// A run that was asked for, of a domain with this many vertices at the start.
struct Asked<'a> {
    args: &'a Simulate,
    path: &'a Path,
    options: &'a Options,
    start: usize,
}

/// The report and the tables of a run.
fn tell(
    asked: &Asked<'_>,
    made: &SimulatedRounds,
    summary: &Summary,
    alone: &Summary,
) -> Result<(String, String), Failure> {
    let Asked { args, path, options, start } = *asked;
    let SimulatedRounds { refined, events, ending, figures, late, .. } = made;
    // The comparison is of the whole mesh.
    let inside = refined.inside();
    let hash = hash_of(&inside.points, &inside.tets)?;
    let vertices = refined.mesh().num_vertices();
    let by_all = (figures.points + figures.parted_points) as usize;
    let [rounds, segments, facets, inside] = figures.rounds;
    let after = vertices - (refined.stats.round_points + figures.parted_points) as usize;
    let Plan { layout, config } = planned(args, after, args.processors);
    let around = Around {
        points: (vertices - by_all) as u64,
        started: after as u64,
        vertices: vertices as u64,
        times: figures.ended,
        gathered: figures.ended - u64::from(late.is_none()),
        looks: true,
    };
    let whole = Whole::of(summary, alone, &around, options);
    let alone = alone.makespan;
    let text = format!(
        "{}: {by_all} points in {rounds} rounds ({segments} on segments, {facets} on facets, \
         {inside} inside; the widest of {} points, {:.2} searches a point, {:.0} % of them made \
         while others were waited for), on {} processors ({}), rule {}, latency {} ns ({}), seed \
         {}\n{}{} barriers, cuts moved {} times with {} tetrahedra; {}\n{}\n{}\n\
         ltbw.mesh/1 {hash}\n",
        show(path),
        figures.widest,
        figures.searches as f64 / figures.points.max(1) as f64,
        100.0 * figures.ahead as f64 / figures.searches.max(1) as f64,
        layout.workers,
        args.machine.name(),
        config.rule,
        options.network.latency,
        options.network.distribution.name(),
        args.seed,
        if figures.ended > 1 {
            format!("{} times one processor did what takes the whole mesh. ", figures.ended - 1)
        } else {
            String::new()
        },
        figures.barriers,
        figures.redeals,
        figures.moved,
        match (ending, late) {
            (Ok(Ending::Done), None) => {
                "each processor keeps its part of the mesh".to_owned()
            }
            (Ok(Ending::Done), Some(why)) => format!("one processor took in all parts: {why}"),
            (Ok(other), _) => format!("one processor did what was left ({other:?})").to_lowercase(),
            (Err(_), _) => "one processor did all".to_owned(),
        },
        tables(summary, &told(Doing::Rounds, alone, whole)),
        cost_model(&options.costs),
    );
    let settings = Run { args, layout: &layout, config: &config, options };
    let made = Made { mesh: refined.mesh(), duplicates: 0, summary, events: *events };
    let report =
        Report::new(settings, &made, Compared { one_processor: alone, whole }, &hash, vertices)
            .from(start);
    let report = report.in_rounds(figures);
    let json = report.to_json().map_err(|e| Failure::Other(e.to_string()))?;
    Ok((json, text))
}

/// The domain of a file; where there is none, that of the kind of this name.
pub(super) fn ready(path: &Path) -> Result<Prepared, Failure> {
    let kind = path.to_str().and_then(|name| name.parse::<DomainKind>().ok());
    let Some(kind) = kind.filter(|_| !path.exists()) else {
        let source = Formats::default().input(path)?;
        return Ok(Preparation::default().prepare(&source)?.0);
    };
    let domain = generate_domain(kind, &Shape::default());
    let domain = domain.map_err(|error| Failure::Usage(error.to_string()))?;
    let failed = |error| Failure::Domain { path: path.to_owned(), error };
    domain.prepare(&PrepareOptions::default()).map_err(failed)
}
