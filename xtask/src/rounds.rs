//! `rounds`: refinement in rounds at full size. 500 random domains in five orders are judged, and
//! compared with the queues; tiny domains in every permutation; files, golden hashes; 100 random
//! domains against CGAL.

use crate::shell::{self, cargo};

/// Runs the tests of rounds with all their cases.
pub(crate) fn run() -> Result<(), String> {
    for (test, cases) in [("refine_rounds", "500"), ("refine_cgal", "100")] {
        let mut command = cargo();
        command.args([
            "test",
            "--release",
            "-p",
            "ltbw-tests",
            "--test",
            test,
            "--",
            "--nocapture",
        ]);
        shell::run(command.env("LTBW_CASES", cases))?;
    }
    Ok(())
}
