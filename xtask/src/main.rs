//! `cargo xtask`: one command for each of the deeper suites. Standard library only, so that it
//! builds in a moment; the measuring itself is the program `measure` of the tests package.

mod c;
mod commands;
mod coverage;
mod dist;
mod figures;
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

use commands::Command;
use std::process::ExitCode;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let (command, rest) = args.split_first().map_or(("help", &args[..]), |(c, r)| (c.as_str(), r));
    let done = match (command, Command::named(command)) {
        (_, Some(command)) => command.execute(rest),
        ("help" | "--help" | "-h", None) => {
            println!("{}", commands::list());
            Ok(())
        }
        (other, None) => Err(format!("no such command: {other}\n\n{}", commands::list())),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}
