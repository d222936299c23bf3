//! `simulate --domain`: a domain refined in rounds by simulated processors.

use super::report::{Made, Report};
use super::{Run, Simulate, end, layout, options, options_alone};
use crate::figures::{cost_model, tables};
use crate::outcome::{Exit, Failure, show};
use crate::progress::Stage;
use crate::rounds::START;
use crate::streams::Formats;
use crate::surface::Preparation;
use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Closure, Config, Correct};
use ltbw::refine::{RefineOutcome, Refiner};
use ltbw::refining::{Ending, SimulatedRounds, simulate_rounds};
use ltbw::simulate::Options;
use ltbw::{Point, canonical_hash};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use std::path::Path;

/// The bounds that the arguments ask for.
pub(super) fn refiner(args: &Simulate) -> Refiner<'static> {
    let refiner = Refiner::new().radius_edge(args.radius_edge.unwrap_or(2.0));
    args.max_volume.map_or(refiner, |bound| refiner.max_volume(bound))
}

/// The workers of a run: all points are in the mesh that is distributed.
pub(super) fn planned(args: &Simulate, points: usize, processors: u32) -> (Layout, Config) {
    let (layout, config) = layout(args, points, processors);
    (Layout { sample: points, max_in_flight: 0, ..layout }, config)
}

/// The same, but a run on one processor has settings of its own: it is what others are compared
/// with.
pub(super) fn planned_run(args: &Simulate, points: usize, processors: u32) -> (Layout, Config) {
    let (layout, config) = planned(args, points, processors);
    if processors > 1 {
        return (layout, config);
    }
    let layout = Layout { ownership: Ownership::default(), ..layout };
    (layout, Config { closure: Closure::default(), ..config })
}

/// The hash that `mesh` prints: of the domain, without the exterior.
pub(super) fn hash_of(points: &[Point], tets: &[[u32; 4]]) -> Result<String, Failure> {
    let hash = canonical_hash(points, tets);
    Ok(hash.map_err(|error| Failure::Other(error.to_string()))?.to_string())
}

/// `ltbw simulate --domain`.
pub(super) fn simulate(args: &Simulate, path: &Path) -> Result<Exit, Failure> {
    if args.storm.is_some() {
        return Err(Failure::Usage("--storm moves blocks, which no domain does".to_owned()));
    }
    let ready = ready(path)?;
    let refiner = refiner(args).start(args.start.unwrap_or(START));
    let options = options(args);
    let run = |processors: u32, options: &Options| {
        let planned = |points| planned_run(args, points, processors);
        let _stage = Stage::begin("simulate");
        simulate_rounds::<Correct>(&refiner, (&ready.domain, &ready.lattice), planned, options)
            .map_err(|error| Failure::Other(format!("{}: {error}", show(path))))
    };
    let stage = Stage::begin("refine");
    let failed = |error| Failure::Refine { path: path.to_owned(), error };
    let engine = refiner.refine(&ready.domain, &ready.lattice).map_err(failed)?;
    drop(stage);
    if engine.outcome == RefineOutcome::Unrecovered || engine.stats.round_points == 0 {
        let text = "no round was needed: a smaller --max-volume or --start makes some";
        return Err(Failure::Usage(format!("{}: {text}", show(path))));
    }
    let of = |mesh: &ltbw::Mesh| match mesh.hash() {
        Ok(hash) => Ok(hash.to_string()),
        Err(error) => Err(Failure::Other(error.to_string())),
    };
    let expected = of(engine.mesh())?;
    drop(engine);

    let SimulatedRounds { refined, summary, events, ending, figures } =
        run(args.processors, &options)?;
    let whole = of(refined.mesh())?;
    // The comparison is of the whole mesh.
    let inside = refined.inside();
    let hash = hash_of(&inside.points, &inside.tets)?;
    let summary = match (summary, &ending) {
        (Some(summary), Ok(_)) => summary,
        (_, Err(why)) => {
            return Err(Failure::Usage(format!("{}: one processor refines {why}", show(path))));
        }
        (None, Ok(_)) => return Err(Failure::Other("a run without rounds".to_owned())),
    };
    let alone = match args.processors {
        1 => summary.makespan,
        _ => run(1, &options_alone(&options))?.summary.map_or(0, |summary| summary.makespan),
    };
    let vertices = refined.mesh().num_vertices();
    let by_all = figures.points as usize;
    let [rounds, segments, facets, inside] = figures.rounds;
    let after = vertices - refined.stats.round_points as usize;
    let (layout, config) = planned(args, after, args.processors);
    let text = format!(
        "{}: {by_all} points in {rounds} rounds ({segments} on segments, {facets} on facets, \
         {inside} inside; the widest of {} points, {:.2} searches a point, {:.0} % of them made \
         while others were waited for), on {} processors ({}), rule {}, latency {} ns ({}), seed \
         {}\n{}{} barriers; {}\n{}\n{}\n\
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
            format!("{} times one processor split what waits in circles. ", figures.ended - 1)
        } else {
            String::new()
        },
        figures.barriers,
        match &ending {
            Ok(Ending::Done) | Err(_) => {
                "one processor put the mesh together, and split the last slivers".to_owned()
            }
            Ok(other) => format!("one processor did what was left ({other:?})").to_lowercase(),
        },
        tables(&summary, Some(alone)),
        cost_model(&options.costs),
    );
    let settings = Run { args, layout: &layout, config: &config, options: &options };
    let made = Made { mesh: refined.mesh(), duplicates: 0, summary: &summary, events };
    let report = Report::new(settings, &made, alone, &hash, vertices).in_rounds(rounds as usize);
    let json = report.to_json().map_err(|e| Failure::Other(e.to_string()))?;
    end(args, (&json, &text), (&whole, &expected))
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
