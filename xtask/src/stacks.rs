//! `stacks`: random stacks of thin layers, whose angles excuse nothing: bounds met, and one mesh
//! for 1, 2 and 5 threads and for 1 and 3 workers that share none.

use crate::shell::{self, cargo};

/// The stacks of a run without a number.
const STACKS: &str = "1000";

/// Runs the tests of stacks with as many stacks as are asked for.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    let count = match args {
        [] => STACKS,
        [count] if is_asked(count) => count,
        _ => return Err("usage: stacks [COUNT | FIRST..END]".to_owned()),
    };
    let mut command = cargo();
    command.args(["test", "--release", "-p", "ltbw-tests", "--test", "workspace"]);
    shell::run(command.args(["stacks::", "--", "--nocapture"]).env("LTBW_CASES", count))
}

/// Is this a number of stacks, or a range of their seeds?
fn is_asked(text: &str) -> bool {
    let (first, end) = text.split_once("..").unwrap_or(("0", text));
    let number = |text: &str| text.parse::<u64>().ok();
    number(first).zip(number(end)).is_some_and(|(first, end)| first < end)
}
