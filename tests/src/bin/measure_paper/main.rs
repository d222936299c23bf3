//! `measure_paper`: every table and figure of Chrisochoides and Nave (2003) that a run can answer,
//! like for like, as Markdown and as a page with pictures. `cargo xtask paper` builds the programs
//! and runs this.
//!
//! Each row says how it came about: *run* on this machine, *run on ranks* of an MPI here,
//! *simulated* on processors that it has not, or *the paper's*. Whole times have the start and the
//! end in them.

mod chart;
mod dihedral;
mod estimate;
mod machine;
mod programs;
mod shares;
mod study;
mod table;
mod tolerance;
mod traditional;

use estimate::Work;
use programs::{Plan, Programs};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;
use table::{Block, markdown, page};

/// Anything that can go wrong: a message says it all.
type Failure = Box<dyn std::error::Error>;

const USAGE: &str = "\
usage: measure_paper PROGRAM TRADITIONAL|- RANKS|- FOLDER [--full|--small] [TABLE|FIGURE]...

PROGRAM is ltbw, TRADITIONAL the program of xtask/traditional, RANKS one that runs ltbw-mpi on as
many processes as its first argument says, or - without it; FOLDER takes paper.md and paper.html.
Of names there are: table-1 to table-6, figure-5 to figure-7,
and study, of setbacks.";

/// A table or figure of the paper, and what makes it.
struct Part {
    name: &'static str,
    make: fn(&Programs) -> Result<Vec<Block>, Failure>,
    /// The work of that.
    work: fn(&Plan) -> Work,
}

/// Tables I and II are of the same runs, and so are IV to VI.
const PARTS: [Part; 10] = [
    Part { name: "table-1", make: traditional::tables, work: traditional::work },
    Part { name: "table-2", make: traditional::tables, work: traditional::work },
    Part { name: "table-3", make: machine::partitions, work: machine::work },
    Part { name: "table-4", make: tolerance::tables, work: tolerance::work },
    Part { name: "table-5", make: tolerance::tables, work: tolerance::work },
    Part { name: "table-6", make: tolerance::tables, work: tolerance::work },
    Part { name: "figure-5", make: shares::over_processors, work: shares::work_over_processors },
    Part { name: "figure-6", make: dihedral::figure, work: dihedral::work },
    Part { name: "figure-7", make: shares::of_cavities, work: shares::work_of_cavities },
    Part { name: "study", make: study::tables, work: study::work },
];

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("measure_paper: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &[String]) -> Result<(), Failure> {
    let (flags, words): (Vec<&String>, Vec<&String>) =
        args.iter().partition(|arg| arg.starts_with("--"));
    let [program, traditional, ranks, folder, names @ ..] = &words[..] else {
        return Err(USAGE.into());
    };
    let ([] | [_]) = flags[..] else { return Err(USAGE.into()) };
    let plan = Plan::of(flags.first().map(|flag| flag.as_str()))
        .map_err(|error| format!("{error}\n{USAGE}"))?;
    let known = |name: &str| PARTS.iter().any(|part| part.name == name);
    if let Some(unknown) = names.iter().find(|name| !known(name)) {
        return Err(format!("no such table or figure: {unknown}\n{USAGE}").into());
    }
    let folder = PathBuf::from(folder);
    std::fs::create_dir_all(&folder)?;
    let programs = Programs {
        ltbw: PathBuf::from(program),
        traditional: (*traditional != "-").then(|| PathBuf::from(traditional)),
        ranks: (*ranks != "-").then(|| PathBuf::from(ranks)),
        folder: folder.clone(),
        plan,
    };
    // Parts of the same runs come together.
    let mut parts: Vec<&Part> = Vec::new();
    for part in &PARTS {
        let is_wanted = names.is_empty() || names.iter().any(|name| *name == part.name);
        if is_wanted && parts.iter().all(|other| other.make as usize != part.make as usize) {
            parts.push(part);
        }
    }
    let works = parts.iter().map(|part| part.work);
    eprintln!("all: {}", estimate::sum(&programs.plan, works));
    let mut blocks = Vec::new();
    for part in parts {
        let estimate = (part.work)(&programs.plan);
        eprintln!("{}: {estimate}", part.name);
        let clock = Instant::now();
        let new = (part.make)(&programs)?;
        let [took, said] = [clock.elapsed().as_secs_f64(), estimate.seconds()];
        eprintln!("{}: {took:.0} s, estimated {said:.0} s", part.name);
        println!("{}", markdown(&new));
        blocks.extend(new);
    }
    std::fs::write(folder.join("paper.md"), markdown(&blocks))?;
    std::fs::write(folder.join("paper.html"), page(&blocks))?;
    println!("wrote {}, and paper.md beside it", folder.join("paper.html").display());
    Ok(())
}
