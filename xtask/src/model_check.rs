//! `model-check`: the models of `verify/models`, with `--cfg loom` and a target folder of their
//! own, because the flag would rebuild everything else.

use crate::shell::{self, cargo, target};

/// Runs the models; `args` go to the test runner.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    let flags = std::env::var("RUSTFLAGS").unwrap_or_default();
    shell::run(
        cargo()
            .env("RUSTFLAGS", format!("{flags} --cfg loom").trim_start())
            .env("CARGO_TARGET_DIR", target().join("loom"))
            .args(["test", "--release", "-p", "ltbw-models", "--tests", "--", "--nocapture"])
            .args(args),
    )
}
