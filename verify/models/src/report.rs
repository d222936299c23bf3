//! The output of the models: one line each, that `cargo xtask model-check` collects in a table.

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

/// Runs a known-bad model, which must panic; returns what it said.
///
/// # Panics
/// If the model does not.
pub fn caught(model: impl FnOnce() + std::panic::UnwindSafe) -> String {
    let panic = std::panic::catch_unwind(model).expect_err("a known-bad model was not caught");
    let text = panic.downcast_ref::<String>().cloned();
    let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_string()));
    text.unwrap_or_default()
}
