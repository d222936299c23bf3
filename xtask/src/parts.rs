//! `parts`: surfaces as users bring them, through `ltbw mesh` beside TetGen. The measuring is the
//! program `measure_parts` of the tests package; here are the builds and the Python.

use crate::shell::{self, cargo, target};
use std::path::PathBuf;

/// The version that the table is compared with.
const TETGEN: &str = "tetgen==0.8.4";

/// Builds the program, sees to a Python with TetGen, and measures.
pub(crate) fn run(args: &[String]) -> Result<(), String> {
    shell::run(cargo().args(["build", "--quiet", "--release", "-p", "ltbw-cli"]))?;
    // The measuring program does no heavy work: it need not wait for a release build of its own.
    let mut measure = shell::of_tests("measure_parts");
    measure.arg(target().join("release/ltbw")).arg(target().join("parts"));
    // Names of folders are meant from where the user is.
    let here = std::env::current_dir().map_err(|e| format!("the current folder: {e}"))?;
    let mut takes_value = false;
    for arg in args {
        let is_folder = !arg.starts_with('-') && !takes_value;
        takes_value = arg == "--only";
        measure.arg(if is_folder { here.join(arg) } else { PathBuf::from(arg) });
    }
    if std::env::var_os("LTBW_TETGEN_PYTHON").is_none() {
        match shell::python("tetgen-python", &[TETGEN], "import tetgen") {
            Ok(python) => {
                measure.env("LTBW_TETGEN_PYTHON", python);
            }
            Err(reason) => eprintln!("note: no Python with {TETGEN} of our own: {reason}"),
        }
    }
    shell::run(&mut measure)
}
