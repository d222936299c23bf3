//! `simulate --domain`: the rounds of a domain's refinement, inserted by simulated processors.

use super::{Run, Simulate, end, layout, options, options_alone};
use crate::figures::{cost_model, tables};
use crate::outcome::{Exit, Failure, show};
use crate::progress::Stage;
use crate::streams::Formats;
use crate::surface::Preparation;
use ltbw::domain::{PrepareOptions, Prepared};
use ltbw::mesh::{Layout, Ownership};
use ltbw::protocol::{Closure, Config, Correct};
use ltbw::refine::{RefineOutcome, Refiner, Script};
use ltbw::refining::{Simulated, simulate_rounds};
use ltbw::simulate::{Meshed, Options};
use ltbw_generate::{DomainKind, Shape, generate_domain};
use std::path::Path;

use super::report::Report;

/// `ltbw simulate --domain`.
pub(super) fn simulate(args: &Simulate, path: &Path) -> Result<Exit, Failure> {
    let ready = ready(path)?;
    let stage = Stage::begin("refine");
    let mut refiner = Refiner::new().radius_edge(args.radius_edge.unwrap_or(2.0)).start(args.start);
    if let Some(bound) = args.max_volume {
        refiner = refiner.max_volume(bound);
    }
    let failed = |error| Failure::Refine { path: path.to_owned(), error };
    let found = refiner.refine_with_script(&ready.domain, &ready.lattice);
    let (refined, script) = found.map_err(failed)?;
    drop(stage);
    if refined.outcome == RefineOutcome::Unrecovered || script.rounds.is_empty() {
        let text = "no round was needed: a smaller --max-volume or --start makes some";
        return Err(Failure::Usage(format!("{}: {text}", show(path))));
    }
    let of = |mesh: &ltbw::Mesh| match mesh.hash() {
        Ok(hash) => Ok(hash.to_string()),
        Err(error) => Err(Failure::Other(error.to_string())),
    };
    let expected = of(refined.mesh())?;
    let vertices = refined.mesh().num_vertices();
    drop(refined);

    let (layout, config) = layout(args, script.start.len(), args.processors);
    let layout = Layout { sample: script.start.len(), max_in_flight: 0, ..layout };
    let options = options(args);
    let run = rounds(&script, &layout, config, &options, path)?;
    let hash = of(&run.gathered.mesh)?;
    let Some(summary) = run.summary() else {
        return Err(Failure::Other("a run without rounds".to_owned()));
    };
    let alone = match layout.workers {
        1 => summary.makespan,
        _ => {
            let one = Layout { workers: 1, ownership: Ownership::default(), ..layout };
            let config = Config { workers: 1, closure: Closure::default(), ..config };
            let run = rounds(&script, &one, config, &options_alone(&options), path)?;
            run.summary().map_or(0, |summary| summary.makespan)
        }
    };
    let text = format!(
        "{}: {} points in {} rounds after {} vertices, on {} processors ({}), rule {}, latency \
         {} ns ({}), seed {}\nAll points are chosen beforehand, by one engine: no time of that is \
         in these figures.\n{}\n\
         {}\nltbw.mesh/1 {hash}\n",
        show(path),
        vertices - script.start.len(),
        script.rounds.len(),
        script.start.len(),
        layout.workers,
        args.machine.name(),
        config.rule,
        options.network.latency,
        options.network.distribution.name(),
        args.seed,
        tables(&summary, Some(alone)),
        cost_model(&options.costs),
    );
    let count = run.rounds.len();
    let Simulated { gathered, events, .. } = run;
    let meshed = Meshed { gathered, summary, events, trace: None };
    let settings = Run { args, layout: &layout, config: &config, options: &options };
    let report = Report::new(settings, &meshed, alone, &hash, vertices).in_rounds(count);
    let json = report.to_json().map_err(|e| Failure::Other(e.to_string()))?;
    end(args, (&json, &text), (&hash, &expected))
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

fn rounds(
    script: &Script,
    layout: &Layout,
    config: Config,
    options: &Options,
    path: &Path,
) -> Result<Simulated, Failure> {
    let _stage = Stage::begin("simulate");
    simulate_rounds::<Correct>(script, layout, config, options)
        .map_err(|error| Failure::Other(format!("{}: {error}", show(path))))
}
