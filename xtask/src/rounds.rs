//! `rounds`: refinement in rounds at full size. 500 random domains in five orders are judged, and
//! compared with splitting one item after the other; named domains and the parts of a folder in
//! 22 orders; tiny domains in every permutation; files, golden hashes; 200 random domains and the
//! parts by workers that share no mesh; named domains and 100 random ones against CGAL.

use crate::shell::{self, cargo};

/// The orders of insertion that named domains and parts are refined in.
const ORDERS: &str = "22";

/// Runs the tests of rounds with all their cases, and with the parts of a folder if one is given.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    let parts = match args {
        [] => None,
        [folder] => Some(std::path::absolute(folder).map_err(|e| format!("{folder}: {e}"))?),
        _ => return Err("usage: rounds [DIR]".to_owned()),
    };
    for (test, cases) in
        [("refine_rounds::", "500"), ("refine_workers::", "200"), ("refine_cgal::", "100")]
    {
        let mut command = cargo();
        command.args([
            "test",
            "--release",
            "-p",
            "ltbw-tests",
            "--test",
            "workspace",
            test,
            "--",
            "--nocapture",
        ]);
        command.env("LTBW_CASES", cases).env("LTBW_ORDERS", ORDERS);
        parts.iter().for_each(|folder| _ = command.env("LTBW_PARTS", folder));
        shell::run(&mut command)?;
    }
    Ok(())
}
