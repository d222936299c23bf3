//! `simulate --domain --mode async`: bad tetrahedra and the boundary, split by simulated processors
//! as they come.

use super::domain::{MORE, SHARE, hash_of, planned, planned_run, ready, refiner};
use super::report::{Made, Report};
use super::{Run, Simulate, end, failure_of, nothing_to_do, options, options_alone, told};
use crate::console;
use crate::figures::{Doing, cost_model, tables};
use crate::outcome::{Exit, Failure, show};
use crate::plc::plc_of;
use crate::progress::Stage;
use crate::rounds::START;
use ltbw::domain::Prepared;
use ltbw::protocol::Correct;
use ltbw::refining::{RefinedDomain, SimulatedDomain, simulate_domain};
use ltbw::simulate::{Around, Meshed, Options, Whole};
use ltbw_verify as verify;
use std::path::Path;

/// Vertices of each processor at the start: with fewer, most cavities reach an interface.
const START_EACH: usize = 2048;
/// Tetrahedra of a mesh for each of the largest volume that its domain holds, about.
const TETS_PER_VOLUME: f64 = 1.9;
/// And for each vertex.
const TETS_PER_VERTEX: f64 = 5.5;

/// Vertices at which the processors begin, at least: a share of what the bound on volumes predicts,
/// and as many as they can use.
fn start(args: &Simulate, ready: &Prepared) -> usize {
    let most = (START_EACH * args.processors as usize).max(START);
    let volume = ready.report.volume().map_or(0.0, |volume| volume.to_f64());
    let tets = args.max_volume.map(|bound| TETS_PER_VOLUME * volume / bound);
    // A conversion of floats saturates.
    let vertices = tets.map_or(usize::MAX, |tets| (tets / TETS_PER_VERTEX) as usize);
    args.start.unwrap_or(most.min(vertices / SHARE))
}

/// `ltbw simulate --domain --mode async`.
pub(super) fn simulate(args: &Simulate, path: &Path) -> Result<Exit, Failure> {
    if args.storm.is_some() {
        return Err(Failure::Usage("--storm moves blocks, which --mode async does not".to_owned()));
    }
    let ready = ready(path)?;
    let options = options(args);
    let run = |processors: u32, options: &Options| {
        let planned = |points| planned_run(args, points, processors);
        let _stage = Stage::begin("simulate");
        let domain = (&ready.domain, &ready.lattice);
        simulate_domain::<Correct>(&refiner(args), domain, start(args, &ready), planned, options)
            .map_err(|error| failure_of(path, error))
    };
    let SimulatedDomain { refined, summary, events } = run(args.processors, &options)?;
    if summary.operations() == 0 {
        return Err(nothing_to_do(MORE));
    }
    let alone = match args.processors {
        1 => summary.clone(),
        _ => run(1, &options_alone(&options))?.summary,
    };
    let stage = Stage::begin("check");
    let defects = defects(args, &ready, &refined);
    drop(stage);
    let inside: Vec<[u32; 4]> = refined.tets.iter().map(|&(v, _)| v).collect();
    let hash = hash_of(&refined.points, &inside)?;
    let (layout, config) = planned(args, refined.started, args.processors);
    let vertices = refined.gathered.mesh.num_vertices();
    let started = refined.started as u64;
    let around = Around { points: started, started, vertices: vertices as u64, times: 1 };
    let whole = Whole::of(&summary, &alone, &around, &options);
    let alone = alone.makespan;
    let [segments, facets, inside] = refined.splits.inserted;
    let (deferred, over, refused) = (refined.splits.deferred, refined.over, refined.refused);
    let text = format!(
        "{}: {} tetrahedra of the domain, {} points after {} vertices ({segments} on segments, \
         {facets} on facets, {inside} inside), {deferred} gave way to the boundary, on {} \
         processors ({}), rule {}, latency {} ns ({}), seed {}\nWhich points are made depends on \
         the timing. A point that gives way counts as a cavity.\nOver their bounds: {over} \
         tetrahedra; boundary items not split: {refused}\n{}\n{}\nltbw.mesh/1 {hash}\n",
        show(path),
        refined.tets.len(),
        vertices - refined.started,
        refined.started,
        layout.workers,
        args.machine.name(),
        config.rule,
        options.network.latency,
        options.network.distribution.name(),
        args.seed,
        tables(&summary, &told(Doing::Async, alone, whole)),
        cost_model(&options.costs),
    );
    let meshed = Meshed { gathered: refined.gathered, summary, events, trace: None };
    let settings = Run { args, layout: &layout, config: &config, options: &options };
    let report = Report::new(settings, &Made::of(&meshed), (alone, whole), &hash, vertices);
    let report = report.from(started as usize);
    let json = report.to_json().map_err(|e| Failure::Other(e.to_string()))?;
    let exit = end(args, (&json, &text), (&hash, &hash))?;
    if let Some(first) = defects.first() {
        console::people(&format!("defect    {first}"));
        return Ok(Exit::OwnDefect);
    }
    Ok(if over + refused > 0 { Exit::Defect } else { exit })
}

/// Whatever the independent checker finds, but bounds that the run knows not to be met.
fn defects(args: &Simulate, ready: &Prepared, refined: &RefinedDomain) -> Vec<String> {
    let (tets, tags): (Vec<[u32; 4]>, Vec<i64>) =
        refined.tets.iter().map(|&(v, region)| (v, i64::from(region))).unzip();
    let limits = match refined.over {
        0 => verify::Limits {
            radius_edge: Some(args.radius_edge.unwrap_or(2.0)),
            max_volume: args.max_volume,
            ..verify::Limits::default()
        },
        _ => verify::Limits::default(),
    };
    let mesh = verify::Mesh::new(&refined.points, &tets);
    let plc = plc_of(ready.judged(), 0.0);
    let options = verify::Options { numbered_regions: true, ..verify::Options::default() };
    let found = verify::conforms(&mesh, &plc, Some(&tags), &limits, &options);
    let mesh = found.mesh_defects.iter().map(|defect| format!("{defect:?}"));
    mesh.chain(found.counts.iter().map(|count| format!("{count:?}"))).collect()
}
