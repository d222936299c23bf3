//! The programs that make the figures: each run is a process of its own, whose report is JSON.

use crate::Failure;
use ltbw_tests::require::skip;
use serde_json::Value;
use std::path::PathBuf;
use std::process::Command;

/// A domain with the bound on volumes that gives a mesh of some size.
#[derive(Clone, Copy)]
pub(crate) struct Problem {
    pub(crate) kind: &'static str,
    /// About the tetrahedra in words, as the paper has them.
    pub(crate) size: &'static str,
    pub(crate) volume: &'static str,
}

const fn problem(kind: &'static str, size: &'static str, volume: &'static str) -> Problem {
    Problem { kind, size, volume }
}

impl Problem {
    /// Its tetrahedra, in millions.
    pub(crate) fn millions(self) -> f64 {
        let unit = if self.size.ends_with('k') { 1e-3 } else { 1.0 };
        unit * self.size.trim_end_matches(['k', 'M']).parse().unwrap_or(1.0)
    }
}

/// The sizes of a plan: with `--full` the paper's own, with `--small` what takes seconds, and shows
/// that all works; else what takes minutes.
pub(crate) struct Plan {
    /// The cube with an octahedral hole: Tables I to III.
    pub(crate) model: &'static [Problem],
    /// Cube-in-cube on 32 workstations: Tables IV to VI.
    pub(crate) cubes: &'static [Problem],
    /// One of a size that ranks of one machine run.
    pub(crate) ranked: Problem,
    /// Figure 5.
    pub(crate) scaling: &'static [Problem],
    /// The gear of Figure 6.
    pub(crate) gear: Problem,
    /// The tee of Figure 7.
    pub(crate) tee: &'static [Problem],
    /// The cube-in-cube of the study of setbacks.
    pub(crate) study: Problem,
}

impl Plan {
    /// The plan of an option.
    pub(crate) fn of(option: Option<&str>) -> Result<Self, Failure> {
        match option {
            None => Ok(USUAL),
            Some("--full") => Ok(FULL),
            Some("--small") => Ok(SMALL),
            Some(other) => Err(format!("no such option: {other}").into()),
        }
    }
}

/// The paper's own sizes.
const FULL: Plan = Plan {
    model: &[
        problem("cube-octahedron", "1M", "1.73783e-6"),
        problem("cube-octahedron", "2M", "8.68915e-7"),
    ],
    cubes: &[problem("cube-in-cube", "8M", "2.2e-7"), problem("cube-in-cube", "16M", "1.1e-7")],
    ranked: problem("cube-in-cube", "1M", "1.78e-6"),
    scaling: &[
        problem("cube-octahedron", "0.5M", "3.47566e-6"),
        problem("cube-octahedron", "1M", "1.73783e-6"),
        problem("cube-octahedron", "2M", "8.68915e-7"),
    ],
    gear: problem("gear", "0.5M", "2.6e-6"),
    tee: &[problem("tee", "1M", "5.5e-6"), problem("tee", "2M", "2.75e-6")],
    study: problem("cube-in-cube", "1M", "1.78e-6"),
};

/// The sizes that take seconds.
const SMALL: Plan = Plan {
    model: &[problem("cube-octahedron", "20k", "1e-4")],
    cubes: &[problem("cube-in-cube", "60k", "3e-5")],
    ranked: problem("cube-in-cube", "60k", "3e-5"),
    scaling: &[problem("cube-octahedron", "20k", "1e-4")],
    gear: problem("gear", "13k", "1e-4"),
    tee: &[problem("tee", "55k", "1e-4")],
    study: problem("cube-in-cube", "18k", "1e-4"),
};

/// The sizes that take minutes.
const USUAL: Plan = Plan {
    model: &[problem("cube-octahedron", "1M", "1.73783e-6")],
    cubes: &[problem("cube-in-cube", "1M", "1.78e-6")],
    ranked: problem("cube-in-cube", "1M", "1.78e-6"),
    scaling: &[problem("cube-octahedron", "0.25M", "6.9513e-6")],
    gear: problem("gear", "0.5M", "2.6e-6"),
    tee: &[problem("tee", "0.25M", "2.2e-5")],
    study: problem("cube-in-cube", "0.1M", "1.78e-5"),
};

/// The programs, and where they may write.
pub(crate) struct Programs {
    pub(crate) ltbw: PathBuf,
    pub(crate) traditional: Option<PathBuf>,
    pub(crate) ranks: Option<PathBuf>,
    pub(crate) folder: PathBuf,
    pub(crate) plan: Plan,
}

impl Programs {
    /// The report of `ltbw simulate` on a domain without rounds, as the paper's runs are.
    pub(crate) fn simulated(&self, problem: Problem, options: &[&str]) -> Result<Value, Failure> {
        let domain = ["simulate", "--domain", problem.kind, "--max-volume", problem.volume];
        let words = [&domain[..], &["--mode", "async", "--json", "-"], options].concat();
        self.report(&words)
    }

    /// The report of `ltbw mesh` on a domain.
    pub(crate) fn meshed(&self, problem: Problem, options: &[&str]) -> Result<Value, Failure> {
        let file = self.generated(problem)?;
        let mesh = ["mesh", &file, "--max-volume", problem.volume, "--quiet", "--json", "-"];
        self.report(&[&mesh[..], options].concat())
    }

    /// The report of `ltbw-mpi mesh` on a domain; `None` where there is no MPI, which is said.
    pub(crate) fn on_ranks(
        &self,
        problem: Problem,
        ranks: u32,
        options: &[&str],
    ) -> Result<Option<Value>, Failure> {
        let Some(program) = &self.ranks else {
            skip("meshing on ranks", "mpi", "its program was not built")?;
            return Ok(None);
        };
        let (file, ranks) = (self.generated(problem)?, ranks.to_string());
        let mesh = ["mesh", &file, "--max-volume", problem.volume, "--quiet", "--json", "-"];
        let words = [&mesh[..], options].concat();
        eprintln!("{ranks} ranks: ltbw-mpi {}", words.join(" "));
        let text = said(Command::new(program).arg(&ranks).args(words))?;
        Ok(Some(serde_json::from_str(&text)?))
    }

    /// The file of a domain.
    fn generated(&self, problem: Problem) -> Result<String, Failure> {
        let file = self.folder.join(format!("{}.poly", problem.kind));
        let file = file.to_str().ok_or("a folder whose name is no text")?.to_owned();
        let generate = ["generate", problem.kind, "-o", &file, "--quiet"];
        said(Command::new(&self.ltbw).args(generate))?;
        Ok(file)
    }

    /// The report of the traditional way on some ranks, with that many parts; `None` where there
    /// is no program for it, which is said.
    pub(crate) fn traditional(
        &self,
        problem: Problem,
        ranks: u32,
        parts: u32,
    ) -> Result<Option<Value>, Failure> {
        let folder = self.folder.to_str().ok_or("a folder whose name is no text")?;
        self.by_tradition(ranks, &[problem.kind, problem.volume, &parts.to_string(), folder])
    }

    /// METIS's parts of a mesh that workers have made without rounds, each by its blocks.
    pub(crate) fn parted_anew(
        &self,
        problem: Problem,
        parts: u32,
    ) -> Result<Option<Value>, Failure> {
        let file = self.folder.join(format!("{}.vtu", problem.kind));
        let file = file.to_str().ok_or("a folder whose name is no text")?;
        let parts = parts.to_string();
        self.meshed(problem, &["--mode", "async", "--workers", &parts, "-o", file])?;
        let report = self.by_tradition(1, &["--mesh", file, &parts]);
        std::fs::remove_file(file)?;
        report
    }

    fn by_tradition(&self, ranks: u32, words: &[&str]) -> Result<Option<Value>, Failure> {
        let Some(program) = &self.traditional else {
            skip("the traditional way", "traditional", "its program was not built")?;
            return Ok(None);
        };
        let ranks = ranks.to_string();
        eprintln!("{ranks} ranks: ltbw-traditional {}", words.join(" "));
        let text = said(Command::new(program).arg(&ranks).args(words))?;
        Ok(Some(serde_json::from_str(text.lines().last().unwrap_or_default())?))
    }

    fn report(&self, words: &[&str]) -> Result<Value, Failure> {
        eprintln!("ltbw {}", words.join(" "));
        let text = said(Command::new(&self.ltbw).args(words))?;
        Ok(serde_json::from_str(&text)?)
    }
}

/// The output of a command that has to succeed.
fn said(command: &mut Command) -> Result<String, Failure> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    if !output.status.success() {
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(format!("{command:?}: {}\n{told}", output.status).into());
    }
    Ok(String::from_utf8(output.stdout)?)
}

/// A number of a report, by the names on the way to it.
pub(crate) fn number(report: &Value, way: &[&str]) -> Result<f64, Failure> {
    let at = way.iter().try_fold(report, |value, name| value.get(name));
    at.and_then(Value::as_f64).ok_or_else(|| format!("a report has no {}", way.join(".")).into())
}

/// The workers of a simulated run.
pub(crate) fn workers(report: &Value) -> Result<&[Value], Failure> {
    let all = report.get("simulation").and_then(|own| own.get("workers"));
    Ok(all.and_then(Value::as_array).ok_or("a report has no workers")?)
}
