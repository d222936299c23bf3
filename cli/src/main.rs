//! The program `ltbw`: points in, exactly Delaunay, checked mesh out.
//!
//! | module | what it holds |
//! |---|---|
//! | [`args`] | the command line and its help |
//! | [`run`] | `delaunay`: read, build, check, hash, write, report |
//! | [`check`] | `check`, and the check of our own output |
//! | [`domain`] | `check` of a domain |
//! | [`lists`] | a mesh as the lists that the checker takes |
//! | [`files`] | `convert` and `generate` |
//! | [`demo`] | `demo` |
//! | [`report`] | the JSON report `ltbw.report/1` |
//! | [`outcome`] | exit codes, and errors as one line |
//! | [`console`] | what goes to stdout and to stderr, progress, Ctrl-C |
//!
//! stdout carries data (a hash, JSON), stderr what is meant for people.
#![forbid(unsafe_code)]

mod args;
mod check;
mod console;
mod demo;
mod domain;
mod files;
mod lists;
mod outcome;
mod report;
mod run;

use args::{Args, Command};
use clap::Parser;
use outcome::{Exit, Failure};
use std::process::ExitCode;

fn main() -> ExitCode {
    let result = match Args::try_parse() {
        Ok(args) => dispatch(args),
        Err(error) => args::explain(&error),
    };
    let exit = result.unwrap_or_else(|failure| {
        console::people(&format!("ltbw: {failure}"));
        failure.exit()
    });
    ExitCode::from(exit as u8)
}

fn dispatch(args: Args) -> Result<Exit, Failure> {
    match args.command {
        Command::Delaunay(delaunay) => run::delaunay(&delaunay),
        Command::Check(args) => check::check(&args),
        Command::Convert(convert) => files::convert(&convert),
        Command::Generate(generate) => files::generate(&generate),
        Command::Demo(demo) => demo::demo(&demo),
    }
}
