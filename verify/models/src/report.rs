//! What the models print: one line each, that `cargo xtask model-check` collects in a table.

use std::io::Write;

/// Prints `row: MODEL | BOUNDS | EXPLORED | OUTCOME`. Not with `println!`, which the test runner
/// swallows for tests that pass.
pub fn row(model: &str, bounds: &str, explored: &str, outcome: &str) {
    let line = format!("row: {model} | {bounds} | {explored} | {outcome}\n");
    // A closed stdout is no reason to fail.
    let _ = std::io::stdout().lock().write_all(line.as_bytes());
}

/// Are the larger bounds wanted? `cargo xtask model-check --deep` sets the variable.
pub fn is_deep() -> bool {
    std::env::var_os("LTBW_DEEP").is_some()
}
