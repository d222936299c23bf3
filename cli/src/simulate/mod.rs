//! `simulate`: the parallel kernel on simulated processors, and the paper's tables.

mod args;
mod domain;
mod freely;
mod page;
mod report;

pub(crate) use args::Simulate;

use crate::console;
use crate::figures::{self, Doing, SPANS, cost_model, tables, write_trace};
use crate::json::{distinct, file_writable, keep_input, write_json};
use crate::outcome::{Exit, Failure, show};
use crate::progress::Stage;
use crate::streams::on_stdout;
use crate::workers::Mode;
use ltbw::PointSet;
use ltbw::balance::Balance;
use ltbw::build::Builder;
use ltbw::io;
use ltbw::mesh::{Layout, Ownership};
use ltbw::metrics::Summary;
use ltbw::protocol::{Closure, Config, WorkerId};
use ltbw::refining::RefineError;
use ltbw::simulate::{
    Around, MeshError, Meshed, Network, Options, RandomMigrations, Whole, simulate_mesh,
};
use ltbw::threads::{BURST, Parallel};
use ltbw_generate::generate;
use report::{Compared, Made, Report, Run};
use std::path::{Path, PathBuf};

/// `ltbw simulate`.
pub(crate) fn simulate(args: &Simulate) -> Result<Exit, Failure> {
    console::end_on_signal()?;
    if (args.storm.is_some() || args.balance)
        && (args.as_processes || args.ownership != Ownership::Block)
    {
        let text = "--storm and --balance move blocks, which only --ownership block allows";
        return Err(Failure::Usage(text.to_owned()));
    }
    args.json.as_deref().map_or(Ok(()), file_writable)?;
    let pages = [&args.trace, &args.page].into_iter().flatten();
    pages.clone().try_for_each(|path| file_writable(path))?;
    let written: Vec<PathBuf> = args.json.iter().chain(pages).cloned().collect();
    distinct(&written)?;
    if let Some(path) = &args.domain {
        for input in io::domain_files(path) {
            written.iter().try_for_each(|output| keep_input(&input, output))?;
        }
        return match args.mode {
            Mode::Rounds => domain::simulate(args, path),
            Mode::Async => freely::simulate(args, path),
        };
    }
    let name = PathBuf::from(format!("{} {} points", args.points, args.kind.name()));
    let points = generate(args.kind, args.points as usize, args.seed);
    let set =
        PointSet::new(points).map_err(|error| Failure::Points { path: name.clone(), error })?;
    let built =
        Builder::new().build(&set).map_err(|error| Failure::Build { path: name.clone(), error })?;
    let expected = built.mesh.hash().map_err(|e| Failure::Other(e.to_string()))?.to_string();
    drop(built);

    let (layout, config) = layout(args, set.len(), args.processors);
    let options = options(args);
    let mut meshed = mesh(&set, &layout, config, &options, &name)?;
    let hash = meshed.gathered.mesh.hash().map_err(|e| Failure::Other(e.to_string()))?.to_string();
    if meshed.summary.operations() == 0 {
        return Err(nothing_to_do(
            "all points are in the mesh at the start: more --points make work",
        ));
    }
    let alone = match layout.workers {
        1 => meshed.summary.clone(),
        _ => alone(&set, &layout, config, &options, &name)?,
    };
    let started = layout.sample.min(set.len()) as u64;
    let vertices = meshed.gathered.mesh.num_vertices() as u64;
    // Each keeps its part of a mesh of points, as processes do.
    let around = Around { points: started, started, vertices, times: 1, ..Around::default() };
    let whole = Whole::of(&meshed.summary, &alone, &around, &options);
    let alone = alone.makespan;
    let run = Run { args, layout: &layout, config: &config, options: &options };
    let report = Report::new(
        run,
        &Made::of(&meshed),
        Compared { one_processor: alone, whole },
        &hash,
        set.len(),
    );
    let json = report.to_json().map_err(|e| Failure::Other(e.to_string()))?;
    let trace = meshed.trace.take();
    let text = format!(
        "{} points on {} processors ({}), rule {}, latency {} ns ({}), seed {}\n{}\n{}\n\
         ltbw.mesh/1 {hash}\n",
        set.len(),
        layout.workers,
        args.machine.name(),
        config.rule,
        options.network.latency,
        options.network.distribution.name(),
        args.seed,
        tables(&meshed.summary, &told(Doing::Insertion, alone, whole)),
        cost_model(&options.costs),
    );
    if let (Some(path), Some(trace)) = (&args.page, &trace) {
        let run = page::Run {
            args,
            set: &set,
            name: &name,
            options: &options,
            summary: &meshed.summary,
            trace,
            alone,
            text: &text,
            report: &json,
        };
        run.write(path)?;
    }
    if let Some(path) = &args.trace {
        write_trace(path, trace)?;
    }
    end(args, Told { json, text, found: hash, expected })
}

/// The report and the tables of a run, and the hashes of its mesh and of the engine's.
struct Told {
    json: String,
    text: String,
    found: String,
    expected: String,
}

/// Writes the report and the tables, and compares the hash with that of the sequential kernel.
fn end(args: &Simulate, told: Told) -> Result<Exit, Failure> {
    let Told { json, text, found, expected } = told;
    if let Some(path) = &args.json {
        write_json(path, &json)?;
    }
    let pages = [&args.json, &args.trace, &args.page];
    if on_stdout(&pages.into_iter().flatten().cloned().collect::<Vec<_>>()) {
        console::people(text.trim_end());
    } else {
        console::data(&text)?;
    }
    if found == expected {
        return Ok(Exit::Done);
    }
    console::people(&format!("defect    the sequential kernel's mesh is {expected}"));
    Ok(Exit::OwnDefect)
}

/// Why a run that inserts nothing is refused: figures of nothing would claim all.
fn nothing_to_do(what_to_change: &str) -> Failure {
    Failure::Usage(format!("the processors have nothing to insert: {what_to_change}"))
}

/// A failure of a simulated refinement; what the options cannot be is one of usage.
fn failure_of(path: &Path, error: RefineError) -> Failure {
    match error {
        RefineError::Domain(error) => Failure::Refine { path: path.to_owned(), error },
        RefineError::Complex(error) => Failure::Usage(format!("{}: {error}", show(path))),
        error => Failure::Other(format!("{}: {error}", show(path))),
    }
}

/// Other knowledge of a simulated run than its figures.
fn told(doing: Doing, alone: u64, whole: Option<Whole>) -> figures::Run {
    figures::Run { doing, alone: Some(alone), whole, clock: None }
}

/// The options of a run of one processor.
fn options_alone(options: &Options) -> Options {
    Options { slow: Vec::new(), storm: None, spans: 0, costs: options.costs, ..Options::default() }
}

/// The layout of the points, and the configuration of the workers.
fn layout(args: &Simulate, points: usize, processors: u32) -> (Layout, Config) {
    let process = Parallel::new(processors).among_processes();
    let mut layout = match args.as_processes {
        true => process.default_layout(points),
        false => {
            Layout { ownership: args.ownership, ..Layout::for_high_latency(points, processors) }
        }
    };
    // A domain's mesh is there already.
    layout.own_curves = (args.as_processes || args.own_curves) && args.domain.is_none();
    // Few points are not all for the start.
    if layout.sample >= points {
        layout.sample = points / domain::SHARE;
    }
    let config = if args.as_processes { process.config() } else { Config::new(processors) };
    let mut config = Config { rule: args.rule, closure: args.closure, ..config };
    if let Some(window) = args.window {
        config.window = window as usize;
    }
    if let Some(cursors) = args.cursors {
        layout.cursors = cursors as usize;
    }
    if let Some(abreast) = args.abreast {
        layout.max_in_flight = abreast as usize;
    }
    if let Some(blocks) = args.blocks {
        layout.blocks_per_worker = blocks;
    }
    if let Some(sample) = args.sample {
        layout.sample = sample as usize;
    }
    (layout, config)
}

fn options(args: &Simulate) -> Options {
    let default = Options::default();
    let machine = args.machine.network();
    Options {
        seed: args.seed,
        costs: args.costs(),
        network: Network {
            latency: args.latency.unwrap_or(machine.latency),
            distribution: args.distribution,
            byte: args.bandwidth.map_or(machine.byte, |gbits| 8.0 / gbits),
            bursts: None,
        },
        poll_every: match args.as_processes {
            // Others wait for a processor in rounds.
            _ if args.domain.is_some() && args.mode == Mode::Rounds => 1,
            true => BURST,
            false => args.poll_every,
        },
        letters: args.letters || args.as_processes,
        slow: args.slow.map(|factor| (WorkerId::default(), factor)).into_iter().collect(),
        balance: args.balance.then(Balance::default),
        storm: args.storm.map(|every| RandomMigrations { every }),
        spans: if args.trace.is_some() || args.page.is_some() { SPANS } else { 0 },
        ..default
    }
}

fn mesh(
    set: &PointSet,
    layout: &Layout,
    config: Config,
    options: &Options,
    name: &Path,
) -> Result<Meshed, Failure> {
    let _stage = Stage::begin("simulate");
    simulate_mesh(set, layout, config, options).map_err(|error| match error {
        MeshError::Build(error) => Failure::Build { path: name.to_owned(), error },
        other => Failure::Other(format!("{}: {other}", show(name))),
    })
}

/// The figures of one processor that does the same work.
fn alone(
    set: &PointSet,
    layout: &Layout,
    config: Config,
    options: &Options,
    name: &Path,
) -> Result<Summary, Failure> {
    // One alone has nothing to lock, and nobody to own anything else.
    let one = Layout { workers: 1, ownership: Ownership::default(), ..*layout };
    let config = Config { workers: 1, closure: Closure::default(), ..config };
    Ok(mesh(set, &one, config, &options_alone(options), name)?.summary)
}
