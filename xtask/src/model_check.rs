//! `model-check`: the models of `verify/models`, three times: as they are (all states of small
//! worlds, known-bad variants, random runs), under loom, and under shuttle. The flags `--cfg loom`
//! and `--cfg shuttle` rebuild everything, so that each has a target folder of its own, and is
//! built fast rather than well.
//!
//! Every model prints lines `row: MODEL | BOUNDS | EXPLORED | OUTCOME`; they are put together in a
//! table at the end.

use crate::shell::{cargo, target};
use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::time::Instant;

/// The parts: the flag that each is built with, if any.
const PARTS: [Option<&str>; 3] = [None, Some("loom"), Some("shuttle")];

/// Runs the models. `--deep` asks for larger bounds; `--rest` leaves out what `cargo test` has run;
/// other `args` go to the test runner.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    let has = |flag: &str| args.iter().any(|arg| arg == flag);
    let wishes = Wishes { deep: has("--deep"), rest: has("--rest") };
    let is_other = |arg: &&String| !["--deep", "--rest"].contains(&arg.as_str());
    let rest: Vec<&String> = args.iter().filter(is_other).collect();
    if let Some(unknown) = rest.iter().find(|arg| arg.starts_with('-')) {
        return Err(format!("model-check takes --deep, --rest and names of tests, not {unknown}"));
    }
    let start = Instant::now();
    let (mut rows, mut times, mut failed) = (Vec::new(), Vec::new(), Vec::new());
    for part in PARTS {
        let clock = Instant::now();
        let name = part.unwrap_or("states");
        if let Err(what) = run_part(part, wishes, &rest, &mut rows) {
            failed.push(format!("{name}: {what}"));
        }
        times.push(format!("{name} {} s", clock.elapsed().as_secs()));
    }
    print_table(&rows);
    let total = start.elapsed().as_secs();
    println!("{} models; with building: {}, all {total} s", rows.len(), times.join(", "));
    if failed.is_empty() { Ok(()) } else { Err(failed.join("; ")) }
}

/// The wishes of the arguments.
#[derive(Clone, Copy)]
struct Wishes {
    deep: bool,
    rest: bool,
}

fn run_part(
    part: Option<&str>,
    wishes: Wishes,
    args: &[&String],
    rows: &mut Vec<String>,
) -> Result<(), String> {
    let mut command = cargo();
    command.args(["test", "--no-fail-fast"]).stdout(Stdio::piped());
    if part.is_none() {
        // With the features of the whole workspace: what its tests have built is not built again.
        command.args(["--workspace", "--test", "models"]);
    } else {
        command.args(["-p", "ltbw-models", "--test", "models"]);
        command.args(["--config", "profile.dev.package.'*'.opt-level=1"]);
    }
    let is_rest = wishes.rest && part.is_none();
    command.args(["--", if is_rest { "--ignored" } else { "--include-ignored" }]).args(args);
    if let Some(flag) = part {
        let flags = std::env::var("RUSTFLAGS").unwrap_or_default();
        command
            .env("RUSTFLAGS", format!("{flags} --cfg {flag}").trim_start())
            .env("CARGO_TARGET_DIR", target().join(flag))
            .env("CARGO_PROFILE_DEV_DEBUG", "0")
            .env("CARGO_PROFILE_DEV_OPT_LEVEL", "1");
    }
    if wishes.deep {
        command.env("LTBW_DEEP", "1");
    }
    let mut child = command.spawn().map_err(|error| format!("{command:?}: {error}"))?;
    for line in child.stdout.take().into_iter().flat_map(|out| BufReader::new(out).lines()) {
        let line = line.map_err(|error| error.to_string())?;
        println!("{line}");
        // The test runner may have begun a line of its own: `test NAME ... `.
        if let Some((_, row)) = line.split_once("row: ") {
            rows.push(row.to_string());
        }
    }
    let status = child.wait().map_err(|error| error.to_string())?;
    if status.success() { Ok(()) } else { Err(status.to_string()) }
}

/// Prints the rows in columns, those of a kind together.
fn print_table(rows: &[String]) {
    let mut cells: Vec<Vec<&str>> = rows.iter().map(|row| row.split(" | ").collect()).collect();
    cells.sort();
    cells.insert(0, vec!["model", "bounds", "explored", "outcome"]);
    let width = |column: usize| {
        cells.iter().filter_map(|row| row.get(column)).map(|cell| cell.len()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..4).map(width).collect();
    println!();
    for row in &cells {
        let padded = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:width$}"));
        println!("{}", padded.collect::<Vec<_>>().join(" | ").trim_end());
    }
    println!();
}
