//! The program `ltbw`: points in, exactly Delaunay, checked mesh out.
//!
//! | module | what it holds |
//! |---|---|
//! | `args` | the command line and its help |
//! | `kinds` | what `generate` makes |
//! | `numbers` | whole numbers on the command line |
//! | `refusal` | what is said of a command line that is no command |
//! | `task` | the pipeline that points and domains go through: files, report, page, end |
//! | `run` | `delaunay`: read, build, check, hash, write, report |
//! | `mesh` | `mesh`: read, prepare, refine, check, write, report |
//! | `refine` | `refine`: a mesh is gone on with |
//! | `check` | `check`, and the check of our own output |
//! | `elements` | what `check` tells of a mesh beside its defects |
//! | `orient` | the orientation of tetrahedra in `convert` |
//! | `bounds` | what a mesh of a domain is asked for: bounds and sizes |
//! | `sizes`, `solution` | wanted edge lengths: of options, of the file that `--sizes` names |
//! | `page` | a page of HTML about a mesh |
//! | `conform` | `check --plc` |
//! | `surface` | how a domain is prepared: repairs, and the surface of what is wrong |
//! | `domain` | `check` of a domain |
//! | `machine` | what the machine lacks: memory, threads |
//! | `lists` | a mesh as the lists that the checker takes |
//! | `files` | `convert` and `generate` |
//! | `streams` | stdin and stdout in place of files |
//! | `simulate` | `simulate`: the parallel kernel on simulated processors |
//! | `demo` | `demo` |
//! | `points` | what is told of a mesh of points, wherever its parts are |
//! | `apart`, `apart_domain` | `delaunay` and `mesh` by processes none of which has the mesh |
//! | `quality_apart` | the quality of such a mesh |
//! | `domain_job` | a domain that is to be meshed, with what is asked for |
//! | `domain_whole` | the end of `mesh` where one process has the mesh |
//! | `domain_report` | what is told of a refined domain, wherever its parts are |
//! | `slices` | the points of such a run, of which no process has all |
//! | `others`, `ranks` | the other processes of a job; those of `ltbw-mpi` |
//! | `vectors`, `kit` | `vectors`: a foreign program and the conformance kit |
//! | `report` | the JSON report `ltbw.report/1` |
//! | `outcome` | exit codes, and errors as one line |
//! | `console`, `progress` | what goes to stdout and to stderr, Ctrl-C |
//! | `help` | the long help, and the exit codes of each command |
//! | `install` | `completions` and `man` |
//!
//! stdout carries data (a hash, JSON), stderr what is meant for people.
//!
//! A library for its own program and for tests: [`main`] is the program, [`parse`] its
//! understanding of a command line.
#![forbid(unsafe_code)]

mod angles;
#[cfg(feature = "wire")]
mod apart;
#[cfg(feature = "wire")]
mod apart_domain;
mod args;
mod binding;
mod bounds;
mod certificate;
mod check;
mod conform;
mod console;
mod demo;
mod domain;
mod domain_job;
mod domain_report;
mod domain_whole;
mod elements;
mod excused;
mod explained;
mod figures;
mod files;
mod help;
mod install;
mod json;
mod kinds;
mod kit;
mod lenience;
mod lists;
mod machine;
mod mesh;
mod needles;
mod numbers;
mod orient;
mod others;
mod outcome;
mod page;
mod parts;
mod picture;
mod pieces;
mod plc;
mod points;
#[cfg(feature = "wire")]
mod processes;
mod progress;
#[cfg(feature = "wire")]
mod quality_apart;
#[cfg(feature = "wire")]
#[doc(hidden)]
pub mod ranks;
mod refine;
mod refusal;
mod remedy;
mod report;
mod rounds;
mod run;
mod simulate;
mod sizes;
#[cfg(feature = "wire")]
mod slices;
mod solution;
mod streams;
mod surface;
mod sync;
mod synonyms;
mod task;
mod unrecovered;
mod vectors;
mod without;
mod workers;

use args::{Args, Command, Delaunay, MeshArgs, Refine, Vectors};
use clap::Parser;
use others::Others;
use outcome::{Exit, Failure};
use std::ffi::OsString;
use std::process::ExitCode;

#[doc(hidden)]
pub use plc::plc_of;
pub use refusal::Refusal;

/// Understands a command line, the program's name first, and runs nothing.
///
/// # Errors
/// Why it is no command: a mistake, or a question for help.
pub fn parse(words: &[OsString]) -> Result<(), Refusal> {
    Args::try_parse_from(words).map(|_| ()).map_err(|error| Refusal::of(&error, words))
}

/// Runs the program on the command line of this process. `backtraces` is what `RUST_BACKTRACE` was,
/// if set: it is for programs that are run.
pub fn main(backtraces: Option<OsString>) -> ExitCode {
    let words: Vec<OsString> = std::env::args_os().collect();
    let result = machine::watch().and_then(|()| match Args::try_parse_from(&words) {
        Ok(args) => dispatch(args, backtraces, None),
        Err(error) => refusal::explain(&error, &words),
    });
    let code = result.map(|exit| exit as u8).unwrap_or_else(|failure| {
        let code = failure.code();
        let is_early = code == Exit::Machine as u8 && !matches!(failure, Failure::Write(_));
        let end = if is_early { "; nothing was written" } else { "" };
        console::people(&format!("ltbw: {failure}{end}"));
        code
    });
    ExitCode::from(code)
}

/// Runs a command, as one of several processes if there are others.
fn dispatch(args: Args, backtraces: Option<OsString>, others: Others<'_>) -> Result<Exit, Failure> {
    progress::show(match args.progress {
        // Lines of JSON are for a program, not for people.
        progress::Show::Bar if args.quiet => progress::Show::None,
        asked => asked,
    });
    if args.quiet {
        console::be_quiet();
    }
    match &args.command {
        Command::Delaunay(Delaunay { threads, .. })
        | Command::Mesh(MeshArgs { threads, .. })
        | Command::Refine(Refine { mesh: MeshArgs { threads, .. }, .. }) => {
            let share = others.map(|others| machine::share(others.size()));
            machine::start_threads(threads.or(share))?;
        }
        Command::Completions { .. } | Command::Man { .. } | Command::Vectors(_) => {}
        _ => machine::start_threads(None)?,
    }
    match args.command {
        Command::Delaunay(delaunay) => run::delaunay(&delaunay, others),
        Command::Mesh(args) => mesh::mesh_from(&args, others, None),
        Command::Refine(args) => refine::refine(&args, others),
        Command::Check(args) => check::check(&args),
        Command::Convert(convert) => files::convert(&convert),
        Command::Generate(generate) => files::generate(&generate),
        Command::Simulate(args) => simulate::simulate(&args),
        Command::Demo(demo) => demo::demo(&demo),
        Command::Completions { shell } => install::completions(shell),
        Command::Man { folder } => install::manual(&folder),
        Command::Vectors(Vectors::Run(args)) => vectors::run(&args, backtraces.as_deref()),
        Command::Vectors(Vectors::Unpack { folder }) => vectors::unpack(&folder),
    }
}
