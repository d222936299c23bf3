//! `simulate --domain --mode async`: bad tetrahedra and the boundary, split by simulated processors
//! as they come.

use super::domain::{MORE, hash_of, planned, planned_run, ready, refiner};
use super::report::{Compared, Made, Report};
use super::{Run, Simulate, Told, end, failure_of, nothing_to_do, options, options_alone, told};
use crate::console;
use crate::figures::{Doing, cost_model, tables};
use crate::outcome::{Exit, Failure, show};
use crate::plc::plc_of;
use crate::progress::Stage;
use crate::rounds::START;
use ltbw::TetMesh;
use ltbw::domain::Prepared;
use ltbw::refine::{RefineOutcome, Refined, Strategy};
use ltbw::refining::{Plan, START_EACH, SimulatedDomain, simulate_domain};
use ltbw::simulate::{Around, Options, Whole};
use ltbw_verify as verify;
use std::path::Path;

/// Tetrahedra of a mesh for each of the largest volume that its domain holds, about.
const TETS_PER_VOLUME: f64 = 1.9;
/// And for each vertex.
const TETS_PER_VERTEX: f64 = 5.5;

/// Vertices at which the processors begin: a twentieth of what a bound on volumes predicts, since
/// all others wait for the one that makes them; in a small mesh a quarter, and never more than they
/// can use.
fn start_of(workers: u32, ready: &Prepared, max_volume: Option<f64>) -> usize {
    let most = (START_EACH * workers as usize).max(START);
    let volume = ready.report.volume().map_or(0.0, |volume| volume.to_f64());
    let tets = max_volume.map(|bound| TETS_PER_VOLUME * volume / bound);
    // A conversion of floats saturates.
    let vertices = tets.map_or(usize::MAX, |tets| (tets / TETS_PER_VERTEX) as usize);
    most.min((vertices / 20).max(START_EACH.min(vertices / 4)))
}

/// `ltbw simulate --domain --mode async`.
pub(super) fn simulate(args: &Simulate, path: &Path) -> Result<Exit, Failure> {
    let ready = ready(path)?;
    let options = options(args);
    let start = args.start.unwrap_or_else(|| start_of(args.processors, &ready, args.max_volume));
    let strategy = Strategy { order: args.order, towards: args.towards };
    let refiner = refiner(args).start(start).strategy(strategy);
    let run = |processors: u32, options: &Options| {
        let planned = |points| planned_run(args, points, processors);
        let _stage = Stage::begin("simulate");
        simulate_domain(&refiner, &ready.domain, &ready.lattice, &planned, options)
            .map_err(|error| failure_of(path, error))
    };
    let done = run(args.processors, &options)?;
    let SimulatedDomain { refined, splits, started, summary, events } = done;
    if summary.operations() == 0 {
        return Err(nothing_to_do(MORE));
    }
    let alone = match args.processors {
        1 => summary.clone(),
        _ => run(1, &options_alone(&options))?.summary,
    };
    let stage = Stage::begin("check");
    let inside = refined.inside();
    let defects = defects(args, &ready, &refined, &inside);
    drop(stage);
    let hash = hash_of(&inside.points, &inside.tets)?;
    let Plan { layout, config } = planned(args, started, args.processors);
    let vertices = refined.mesh().num_vertices();
    let [segments, facets, inner] = splits.inserted;
    let by_all = (segments + facets + inner) as usize;
    let around = Around {
        points: (vertices - by_all) as u64,
        started: started as u64,
        vertices: vertices as u64,
        times: 1,
        gathered: 1,
        looks: false,
    };
    let whole = Whole::of(&summary, &alone, &around, &options);
    let alone = alone.makespan;
    let (deferred, [items, tets]) = (splits.deferred, splits.refused);
    let text = format!(
        "{}: {} tetrahedra of the domain, {by_all} points after {started} vertices ({segments} on \
         segments, {facets} on facets, {inner} inside), {deferred} gave way to the boundary, on {} \
         processors ({}), rule {}, latency {} ns ({}), seed {}\nWhich points are made depends on \
         the timing. A point that gives way counts as a cavity.\nLeft to one processor: {tets} \
         tetrahedra, {items} boundary items, and the last slivers: {} points\n{}\n{}\n\
         ltbw.mesh/1 {hash}\n",
        show(path),
        inside.tets.len(),
        layout.workers,
        args.machine.name(),
        config.rule,
        options.network.latency,
        options.network.distribution.name(),
        args.seed,
        vertices - started - by_all,
        tables(&summary, &told(Doing::Async, alone, whole)),
        cost_model(&options.costs),
    );
    let made = Made { mesh: refined.mesh(), duplicates: 0, summary: &summary, events };
    let settings = Run { args, layout: &layout, config: &config, options: &options };
    let report =
        Report::new(settings, &made, Compared { one_processor: alone, whole }, &hash, vertices)
            .from(started);
    let json = report.to_json().map_err(|e| Failure::Other(e.to_string()))?;
    let exit = end(args, Told { json, text, found: hash.clone(), expected: hash })?;
    if let Some(first) = defects.first() {
        console::people(&format!("defect    {first}"));
        return Ok(Exit::OwnDefect);
    }
    Ok(if refined.outcome == RefineOutcome::Met { exit } else { Exit::Defect })
}

/// Whatever the independent checker finds, but bounds that the run knows not to be met.
fn defects(args: &Simulate, ready: &Prepared, refined: &Refined, inside: &TetMesh) -> Vec<String> {
    let limits = match refined.outcome {
        RefineOutcome::Met => verify::Limits {
            radius_edge: Some(args.radius_edge.unwrap_or(2.0)),
            max_volume: args.max_volume,
            ..verify::Limits::default()
        },
        _ => verify::Limits::default(),
    };
    let mesh = verify::Mesh::new(&inside.points, &inside.tets);
    let plc = plc_of(ready.judged(), 0.0);
    let options = verify::Options { numbered_regions: true, ..verify::Options::default() };
    let found = verify::conforms(&mesh, &plc, inside.tet_tags.as_deref(), &limits, &options);
    let mesh = found.mesh_defects.iter().map(|defect| format!("{defect:?}"));
    mesh.chain(found.counts.iter().map(|count| format!("{count:?}"))).collect()
}
