//! `bench` and `bars`: the program `measure` of the tests package, built with the release profile.

use crate::shell::{self, cargo};

/// Builds and runs `measure` with `mode` and `args`.
pub(crate) fn run(mode: &str, args: &[String]) -> Result<(), String> {
    shell::run(
        cargo()
            .args([
                "run",
                "--quiet",
                "--release",
                "-p",
                "ltbw-tests",
                "--bin",
                "measure",
                "--",
                mode,
            ])
            .args(args),
    )
}
