//! `paper`: the tables and figures of Chrisochoides and Nave (2003). The measuring is the program
//! `measure_paper` of the tests package; here are the builds, and where the result goes.

use crate::mpi::library::{Found, LIBRARIES};
use crate::shell::{self, program, root, target};
use std::path::{Path, PathBuf};

/// The page that has the tables of the last run with `--write`.
const PAGE: &str = "docs/paper-tables.md";

/// The hint where the traditional way cannot be built.
const PARTITIONER: &str = "it needs PT-Scotch: apt-get install libptscotch-dev";

/// Builds the programs and makes the tables.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    let (write, rest): (Vec<&String>, Vec<&String>) =
        args.iter().partition(|arg| *arg == "--write");
    let folder = target().join("paper");
    let program = program()?;
    let traditional = traditional(&folder);
    if let Err(reason) = &traditional {
        eprintln!("note: no program for the traditional way: {reason}");
    }
    let ranks = ranks(&folder);
    if let Err(reason) = &ranks {
        eprintln!("note: no program for ranks: {reason}");
    }
    let mut measure = shell::of_tests("measure_paper");
    let or_none = |path: Result<PathBuf, String>| path.unwrap_or_else(|_| "-".into());
    measure.arg(program).arg(or_none(traditional)).arg(or_none(ranks)).arg(&folder);
    shell::run(measure.args(&rest))?;
    if write.is_empty() {
        return Ok(());
    }
    let tables = std::fs::read_to_string(folder.join("paper.md")).map_err(|e| e.to_string())?;
    let words: Vec<&str> = rest.iter().map(|word| word.as_str()).collect();
    let command = ["cargo xtask paper", &words.join(" ")].join(" ");
    let head = format!(
        "# The paper's tables and figures\n\nMade by `{} --write`; [what they stand \
         for](paper.md). \
         Each row says whether it is *run* on one machine, *run on ranks* there, *simulated*, \
         or *the paper's*.\n\n",
        command.trim_end()
    );
    let path = root().join(PAGE);
    std::fs::write(&path, head + tables.trim_end() + "\n").map_err(|e| format!("{PAGE}: {e}"))
}

/// A program that runs that of `xtask/traditional` on as many processes as its first argument says.
/// It needs a C compiler for METIS, and PT-Scotch, which the system has for Open MPI.
fn traditional(folder: &Path) -> Result<PathBuf, String> {
    let mpi = LIBRARIES[0].find()?;
    let build = ["build", "--quiet", "--release", "--locked"];
    let built = shell::run(&mut mpi.cargo("xtask/traditional", &build));
    built.map_err(|why| format!("{why} ({PARTITIONER})"))?;
    mpi.script("traditional.sh", &target().join("release/ltbw-traditional"), folder)
}

/// A program that runs `ltbw-mpi` on as many processes as its first argument says, by the first MPI
/// that is here.
fn ranks(folder: &Path) -> Result<PathBuf, String> {
    let found = LIBRARIES.iter().map(|library| library.find());
    let mpi: Found = found.reduce(Result::or).unwrap_or_else(|| Err("no MPI".to_owned()))?;
    mpi.script("ranks.sh", &mpi.build(false)?, folder)
}
