//! Every command of `cargo xtask`: what it does, how long it takes, what it needs. The help is made
//! of this table, and what a command takes is decided here.

use crate::{
    c, coverage, dist, figures, fuzz, generate, lines, measure, model_check, mpi, mutants,
};
use crate::{
    paper, parts, pictures, prove, python, rounds, slips, stacks, terminal, tsan, vectors,
};

/// A command. Times are of two quiet cores with the workspace built for tests, but nothing else.
pub(crate) struct Command {
    pub(crate) name: &'static str,
    /// The arguments that may follow the name; none does where this is empty.
    pub(crate) takes: &'static str,
    pub(crate) what: &'static str,
    pub(crate) time: &'static str,
    /// The tools beside cargo; a missing one is said aloud.
    pub(crate) tools: &'static str,
    /// The text or files that come of it.
    pub(crate) output: &'static str,
    run: fn(&[String]) -> Result<(), String>,
}

/// All of them, by subject: measuring, the models and proofs, what is published.
pub(crate) const COMMANDS: &[Command] = &[
    Command {
        name: "bench",
        takes: "[SET]... | refine | instructions | removal | threads [N [ROUNDS]] | \
                python [N [ROUNDS]] | quality [KIND MAX_VOLUME]... | iterations",
        what: "\
Our order + insert against CGAL's: interleaved pairs, median of 7, of the sets of points named.
refine        refinement, beside one item after the other, beside the commit before (LTBW_BEFORE
              names its measure_refine), against TetGen's (the Python package tetgen), and over
              500 random domains
instructions  instructions of a build and of `ltbw mesh` by callgrind; fails where `mesh` takes 2 %
              more than the program LTBW_BEFORE_PROGRAM, of the commit before
removal       removing uniform points beside putting them back, and beside CGAL's
threads       one and two threads against the sequential kernel and CGAL on TBB, N points
python        ltbw.delaunay of the Python package beside the program, N points
quality       dihedral angles beside those of TetGen, Gmsh and CGAL with their optimisers, and the
              faces that are not Delaunay
iterations    conjugate gradients on the model problem, by bound of angles and sweeps of smoothing",
        time: "5 to 30 minutes",
        tools: "CGAL and TBB; valgrind for instructions; pip for quality, iterations and refine",
        output: "a table",
        run: |rest| measure::run("bench", rest),
    },
    Command {
        name: "figures",
        takes: "[NAME]... | --list",
        what: "\
All tables and figures that pages quote, or those named, by the commands that the pages name; --list
tells names, sections and commands. LTBW_PARTS names a folder of surfaces for those of parts.",
        time: "hours; each what its commands take",
        tools: "those of its commands",
        output: "what the commands print; fails where one fails",
        run: figures::run,
    },
    Command {
        name: "bars",
        takes: "",
        what: "The full-size bars: hashes equal to CGAL's, times within their limits.",
        time: "20 minutes",
        tools: "CGAL",
        output: "a table; fails where a bar is not met",
        run: |rest| measure::run("bars", rest),
    },
    Command {
        name: "parts",
        takes: "[DIR] [--twins] [--only TEXT]",
        what: "\
Surfaces of a folder (by default a set by formula) through `ltbw mesh` beside TetGen, and their
twins: turned, scaled, shifted. Fails if a run breaks a bar that none may break, or leaves more over
a bound than the angles of the domain excuse.",
        time: "10 minutes",
        tools: "pip (the package tetgen)",
        output: "a table",
        run: parts::run,
    },
    Command {
        name: "paper",
        takes: "[TABLE|FIGURE]... [--full|--small] [--write]",
        what: "\
The paper's tables and figures, run and simulated beside the paper's own: table-1 to table-6,
figure-5 to figure-7, and a study of setbacks. --full has the paper's sizes, --small shows that all
works; --write brings docs/paper-tables.md up to date.",
        time: "15 minutes; --full an hour, 6 GB; --small one minute",
        tools: "a C compiler for METIS; mpirun, mpicc, clang",
        output: "tables; target/paper/paper.html has them as pictures",
        run: paper::run,
    },
    Command {
        name: "rounds",
        takes: "[DIR]",
        what: "\
Refinement in rounds: 500 random domains in five orders, named ones and the parts of a folder in 22,
tiny ones in all.",
        time: "30 minutes",
        tools: "CGAL",
        output: "what the tests print",
        run: rounds::run,
    },
    Command {
        name: "stacks",
        takes: "[COUNT | FIRST..END]",
        what: "\
Random stacks of thin layers (1,000): bounds met, one mesh for 1, 2 and 5 threads and for 1 and 3
workers.",
        time: "40 minutes",
        tools: "none",
        output: "what the tests print",
        run: stacks::run,
    },
    Command {
        name: "generate",
        takes: "",
        what: "Writes what is generated from the descriptions of the predicates.",
        time: "seconds",
        tools: "rustfmt",
        output: "the files that have changed",
        run: |_| generate::run(),
    },
    Command {
        name: "lines",
        takes: "[COMMIT]",
        what: "\
Lines of code by folder, without blanks, comments and tests; and how many more or fewer than at a
commit.",
        time: "seconds",
        tools: "git",
        output: "a table",
        run: lines::run,
    },
    Command {
        name: "fuzz",
        takes: "[--seconds N] [--renew] [TARGET]...",
        what: "\
The canary, then every fuzz target for N seconds each (60); --renew packs what was found into the
corpora.",
        time: "10 minutes to build, then N seconds a target",
        tools: "cargo-fuzz",
        output: "a row a target; findings under target/fuzz",
        run: fuzz::run,
    },
    Command {
        name: "vectors",
        takes: "",
        what: "Writes the conformance kit verify/vectors, and the copy in the program.",
        time: "2 minutes",
        tools: "none",
        output: "the files",
        run: |_| vectors::run(),
    },
    Command {
        name: "c",
        takes: "",
        what: "\
Lints, builds and tests the C interface: header, examples under valgrind, by pkg-config and CMake.",
        time: "5 minutes",
        tools: "cc, c++, valgrind, pkg-config, cmake",
        output: "what the tools print; target/c/dist",
        run: |_| c::run(),
    },
    Command {
        name: "python",
        takes: "",
        what: "Lints, builds and tests the Python package: wheel, doctests, tutorials.",
        time: "6 minutes",
        tools: "python3 with venv and pip",
        output: "what pytest prints",
        run: |_| python::run(),
    },
    Command {
        name: "mpi",
        takes: "[--only openmpi|mpich] [--ranks 1,2,3,4] [--readers] [--validate] [--speed] \
                [--seeds N] [--faults N] [--seed N]",
        what: "\
Builds and runs the program of parallel/mpi by Open MPI and, on fewer numbers of processes, by
MPICH: the hashes of ltbw, over shared memory and TCP, in time and late, some on 16 processes;
refusals, faults and checkpoints; what it writes in parts, with --readers read by Gmsh, VTK,
MFEM and DOLFINx. With --validate: two processes with late mails beside the simulator. With --speed:
two processes beside two threads. With --seeds: N small inputs, of which --seed draws kind, size,
processes, network and delay. With --faults: N small jobs, in each of which one process panics, is
killed or is stopped at a moment that --seed draws; else 12 beside the rest.",
        time: "10 minutes; 100 --seeds 7, 1,000 --faults 90",
        tools: "mpirun, mpicc of each MPI, clang; for --readers pip, python3-dolfinx, python3-gmsh",
        output: "one line for all hashes, one for the faults",
        run: mpi::run,
    },
    Command {
        name: "dist",
        takes: "[crates|program|c|python]...",
        what: "\
What is published: crates packaged without a warning, the archives of program and C interface, the
wheel.",
        time: "15 minutes",
        tools: "python3 with venv and pip",
        output: "target/dist",
        run: dist::run,
    },
    Command {
        name: "terminal",
        takes: "[N]",
        what: "On a terminal, no second without output after the first: N points (3 million).",
        time: "5 minutes",
        tools: "python3",
        output: "the longest silence of each run",
        run: terminal::run,
    },
    Command {
        name: "pictures",
        takes: "",
        what: "Takes the README's pictures of our own pages.",
        time: "2 minutes",
        tools: "chromium",
        output: "docs/*.png",
        run: |_| pictures::run(),
    },
    Command {
        name: "prove",
        takes: "",
        what: "The proofs of the filters; wrong constants must be refused.",
        time: "2 minutes",
        tools: "coqc with flocq and gappa's library, gappa",
        output: "a line a file",
        run: |_| prove::run(),
    },
    Command {
        name: "model-check",
        takes: "[--deep] [--rest] [TEST]...",
        what: "\
The models of verify/models: all states (--rest: what `cargo test` leaves out), known-bad variants,
loom, shuttle; --deep has larger bounds.",
        time: "8 minutes; --deep hours",
        tools: "none",
        output: "a table of models",
        run: model_check::run,
    },
    Command {
        name: "tsan",
        takes: "",
        what: "The thread runtime under ThreadSanitizer, and its canary.",
        time: "4 minutes",
        tools: "x86-64 Linux",
        output: "two lines",
        run: |_| tsan::run(),
    },
    Command {
        name: "coverage",
        takes: "",
        what: "The lines of core and verify that their tests run: at least 95 %.",
        time: "30 minutes",
        tools: "cargo-llvm-cov, llvm",
        output: "a table; target/coverage.lcov",
        run: coverage::run,
    },
    Command {
        name: "mutants",
        takes: "[predicates|filters|kernel|checker]... [--shard K/N] [-- ARG...]",
        what: "\
Does a test fail for every change that cargo-mutants makes? (predicates if no group is named; ARGs
go to cargo-mutants)",
        time: "hours",
        tools: "cargo-mutants",
        output: "a line for each that differs from xtask/mutants.txt",
        run: mutants::run,
    },
    Command {
        name: "slips",
        takes: "[N]...",
        what: "\
Plants slips behind a switch, in a copy of the tree, and shows which assertion sees each.",
        time: "20 minutes",
        tools: "none",
        output: "a line a slip",
        run: slips::run,
    },
];

impl Command {
    /// The command of that name.
    pub(crate) fn named(name: &str) -> Option<&'static Self> {
        COMMANDS.iter().find(|command| command.name == name)
    }

    /// Carries it out; an argument where it takes none is refused, and `--help` tells of it alone.
    pub(crate) fn execute(&self, rest: &[String]) -> Result<(), String> {
        let own = rest.iter().take_while(|argument| *argument != "--");
        if own.clone().any(|argument| argument == "--help" || argument == "-h") {
            println!("{}", self.help());
            return Ok(());
        }
        if let ("", [unknown, ..]) = (self.takes, rest) {
            return Err(format!("{unknown}: {} takes no argument\n\n{}", self.name, self.help()));
        }
        (self.run)(rest)
    }

    /// All that is known of it.
    pub(crate) fn help(&self) -> String {
        let Self { name, takes, what, time, tools, output, .. } = self;
        let usage = format!("cargo xtask {name} {takes}");
        format!("{}\n\n{what}\n\ntakes {time}; needs {tools}; gives {output}", usage.trim_end())
    }
}

/// The lines of a text up to the first that ends a sentence.
fn first_sentence(text: &str) -> impl Iterator<Item = &str> {
    let mut is_over = false;
    text.lines().take_while(move |line| !std::mem::replace(&mut is_over, line.ends_with('.')))
}

/// The list of all commands: what each does, in short.
pub(crate) fn list() -> String {
    let mut list = "cargo xtask COMMAND [--help]\n".to_owned();
    for command in COMMANDS {
        let usage = format!("{} {}", command.name, command.takes);
        list += &format!("\n  {} ({})\n", usage.trim_end(), command.time);
        for line in first_sentence(command.what) {
            list += &format!("      {line}\n");
        }
    }
    list + "\nTimes are of two quiet cores. A missing tool is said aloud; with LTBW_REQUIRE=all \
            (or the tool's name) it is a failure."
}

#[cfg(test)]
mod tests {
    use super::{COMMANDS, Command, list};

    #[test]
    fn every_command_is_listed_once_with_time_and_tools() {
        let list = list();
        for command in COMMANDS {
            let same = COMMANDS.iter().filter(|other| other.name == command.name).count();
            assert_eq!(same, 1, "{}", command.name);
            assert!(list.contains(&format!("\n  {}", command.name)), "{}", command.name);
            assert!(![command.what, command.time, command.tools, command.output].contains(&""));
        }
    }

    #[test]
    fn what_takes_nothing_refuses_an_argument_and_runs_nothing_for_help() {
        for name in ["prove", "vectors", "generate", "c", "python", "tsan", "pictures"] {
            let command = Command::named(name).expect("a command");
            let refusal = command.execute(&["--halp".to_owned()]).unwrap_err();
            assert!(refusal.starts_with("--halp: "), "{refusal}");
            // It would take minutes, or fail, if it ran.
            command.execute(&["--help".to_owned()]).expect("help");
        }
    }
}
