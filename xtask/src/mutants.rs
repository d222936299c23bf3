//! `mutants`: does a test fail for every change that cargo-mutants makes to the predicates?

use crate::require;
use crate::shell::{self, cargo};

/// Runs cargo-mutants on the predicates; `args` go to it.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    if !shell::works(cargo().args(["mutants", "--version"])) {
        let reason = "cargo-mutants is not installed (cargo install cargo-mutants)";
        return require::skip("mutants", "mutants", reason);
    }
    shell::run(
        cargo()
            .args(["mutants", "--package", "ltbw-core", "--file", "core/src/predicates/**/*.rs"])
            .args(args),
    )
}
