//! `terminal`: the program on a terminal, for a person who waits. After its first second none
//! passes without a sign of life.

use crate::require;
use crate::shell::{self, command, target};
use std::path::Path;

/// The longest silence, in seconds.
const SILENCE: &str = "1.0";
/// Points, and the volume at which the model problem has about as many vertices.
const FULL: (&str, &str) = ("3000000", "1.2e-7");

/// Runs the commands that take long on `points` points, 3 million if none are named.
pub(crate) fn run(rest: &[String]) -> Result<(), String> {
    if !shell::works(command("python3").args(["-c", "import pty"])) {
        return require::skip("the terminal", "python3", "python3 has no module pty");
    }
    let (points, volume) = match rest {
        [] => (FULL.0.to_owned(), FULL.1.to_owned()),
        [points] => {
            let count: f64 = points.parse().map_err(|error| format!("{points}: {error}"))?;
            (points.clone(), format!("{:e}", 0.37 / count))
        }
        _ => return Err("terminal takes one number of points".to_owned()),
    };
    let program = shell::program()?;
    let folder = target().join("terminal");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let make = |words: &[&str]| {
        let mut make = command(&program.to_string_lossy());
        shell::run(make.current_dir(&folder).arg("--quiet").args(words))
    };
    make(&["generate", "uniform", &points, "-o", "points.npy"])?;
    make(&["generate", "cube-octahedron", "-o", "domain.poly"])?;
    let runs: [&[&str]; 4] = [
        &["delaunay", "points.npy", "--threads", "2", "-o", "points.vtu"],
        &["delaunay", "points.npy"],
        &["check", "points.vtu"],
        &["mesh", "domain.poly", "--max-volume", &volume, "-o", "domain.vtu"],
    ];
    let failures: Vec<String> =
        runs.iter().filter_map(|words| silence(&program, &folder, words).err()).collect();
    let done = std::fs::remove_dir_all(&folder);
    if !failures.is_empty() {
        return Err(failures.join("\n"));
    }
    done.map_err(|error| format!("{}: {error}", folder.display()))
}

fn silence(program: &Path, folder: &Path, words: &[&str]) -> Result<(), String> {
    let script = shell::root().join("tests/terminal.py");
    let mut python = command("python3");
    python.current_dir(folder).arg(script).arg(SILENCE).arg(program).args(words);
    shell::run(&mut python)
}
