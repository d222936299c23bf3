//! `cargo xtask`: one command for each of the deeper suites. Standard library only, so that it
//! builds in a moment; the measuring itself is the program `measure` of the tests package.

mod c;
mod coverage;
mod dist;
mod fuzz;
mod generate;
mod lines;
mod measure;
mod model_check;
mod mpi;
mod mutants;
mod paper;
mod parts;
mod pictures;
mod predicates;
mod prove;
mod python;
mod rounds;
mod shell;
mod slips;
mod stacks;
mod terminal;
mod tsan;

// The rule about missing tools is the tests' own, not a copy of it.
#[path = "../../tests/src/require.rs"]
#[expect(unreachable_pub, reason = "it is public in the library that owns it")]
mod require;
// Tidiness decides what a line of code is.
#[path = "../../tests/tests/tidy/source.rs"]
#[expect(dead_code, reason = "tidiness uses all of it")]
mod source;
mod vectors;

use std::process::ExitCode;

const HELP: &str = "\
cargo xtask COMMAND

  bench [SET]...        our order + insert against CGAL's, interleaved pairs, median of 7
  bench removal         removing uniform points beside putting them back, and beside CGAL's
  bench threads [N [ROUNDS]]
                        one and two threads against the sequential kernel and CGAL on TBB, N points
  bench python [N [ROUNDS]]
                        ltbw.delaunay of the Python package beside the program, N points
  bench refine          refinement, beside one item after the other, beside the commit before
                        (LTBW_BEFORE names its measure_refine), against TetGen's (the Python
                        package tetgen), and over 500 random domains
  bench quality [KIND MAX_VOLUME]...
                        dihedral angles beside those of TetGen and Gmsh with their optimisers (their
                        Python packages), and the faces that are not Delaunay
  bench instructions    instructions of a build and of `ltbw mesh` by callgrind; fails where `mesh`
                        takes 2 % more than the program LTBW_BEFORE_PROGRAM, of the commit before
  parts [DIR] [--twins] [--only TEXT]
                        surfaces of a folder (by default a set by formula) through `ltbw mesh`
                        beside TetGen (the Python package tetgen), and their twins: turned, scaled,
                        shifted; fails if a run breaks a bar that none may break, or leaves more
                        over a bound than the angles of the domain excuse
  paper [TABLE|FIGURE]... [--full|--small] [--write]
                        the paper's tables and figures, run and simulated beside the paper's own:
                        table-1 to table-6, figure-5 to figure-7, and a study of setbacks;
                        target/paper/paper.html has them as pictures. 15 minutes; --full has the
                        paper's sizes and takes hours, --small seconds; --write brings
                        docs/paper-tables.md up to date
  rounds [DIR]          refinement in rounds: 500 random domains in five orders, named ones and the
                        parts of a folder in 22, tiny ones in all
  stacks [COUNT | FIRST..END]
                        random stacks of thin layers (1,000): bounds met, one mesh for 1, 2 and 5
                        threads and for 1 and 3 workers
  bars                  the full-size bars: hashes equal to CGAL's, times within their limits
  generate              write what is generated from the descriptions of the predicates
  lines [COMMIT]        lines of code by folder, without blanks, comments and tests; and how many
                        more or fewer than at a commit
  fuzz [--seconds N] [TARGET]...
                        the canary, then every fuzz target for N seconds each (default 60), through
                        cargo-fuzz
  vectors               writes the conformance kit verify/vectors
  c                     lints, builds and tests the C interface: header, examples under valgrind
  python                lints, builds and tests the Python package: wheel, doctests, tutorial
  mpi [--ranks 1,2,3,4] [--readers]
                        builds and runs the program of parallel/mpi by mpirun: the hashes of ltbw,
                        over shared memory and TCP, in time and late; refusals and faults; what it
                        writes in parts, read by Gmsh, VTK, MFEM (with --readers)
  dist [crates|program|c|python]...
                        what is published, in target/dist: crates packaged without a warning, the
                        archives of program and C interface, the wheel
  terminal [N]          on a terminal, no second without output after the first: 3 million points
  pictures              takes the README's pictures of our own pages, with Chromium
  prove                 the proofs of the filters: coqc and gappa
  model-check [--deep] [--rest]
                        the models of verify/models: all states (or what `cargo test` leaves out),
                        known-bad variants, loom, shuttle
  tsan                  the thread runtime under ThreadSanitizer, and its canary
  coverage              the lines of core and verify that their tests run: at least 95 %
  mutants [predicates|filters|kernel|checker]... [--shard K/N] [-- ARG...]
                        does a test fail for every change that cargo-mutants makes? (predicates
                        if no group is named; ARGs go to cargo-mutants)
  slips [N]...          plants slips behind a switch, in a copy of the tree, and shows which
                        assertion sees each: minutes

A missing tool is said aloud; with LTBW_REQUIRE=all (or the tool's name) it is a failure.";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let (command, rest) = args.split_first().map_or(("help", &args[..]), |(c, r)| (c.as_str(), r));
    let done = match command {
        "bench" | "bars" => measure::run(command, rest),
        "paper" => paper::run(rest),
        "parts" => parts::run(rest),
        "rounds" => rounds::run(rest),
        "stacks" => stacks::run(rest),
        "fuzz" => fuzz::run(rest),
        "generate" => generate::run(),
        "lines" => lines::run(rest),
        "vectors" => vectors::run(),
        "pictures" => pictures::run(),
        "prove" => prove::run(),
        "python" => python::run(),
        "dist" => dist::run(rest),
        "terminal" => terminal::run(rest),
        "model-check" => model_check::run(rest),
        "tsan" => tsan::run(),
        "c" => c::run(),
        "mpi" => mpi::run(rest),
        "coverage" => coverage::run(rest),
        "mutants" => mutants::run(rest),
        "slips" => slips::run(rest),
        "help" | "--help" | "-h" => {
            println!("{HELP}");
            Ok(())
        }
        other => Err(format!("no such command: {other}\n\n{HELP}")),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}
