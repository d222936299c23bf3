//! A mesh of points as people and reports hear of it, wherever its parts are.

use crate::check::Checked;
use crate::console;
use crate::outcome::{Exit, Failure};
use crate::report::{Input, MeshPart, Report};
use crate::task::Task;
use ltbw::domain::Thickness;
use ltbw::threads::RunError;
use ltbw::{BuildError, Outcome};

/// The result of a build; none if it was stopped before the first tetrahedron.
pub(crate) fn unless_stopped<B>(
    built: Result<B, RunError>,
    task: &Task<'_>,
) -> Result<Option<B>, Failure> {
    match built {
        Ok(built) => Ok(Some(built)),
        Err(RunError::Build(BuildError::Cancelled)) => Ok(None),
        Err(RunError::Build(error)) => Err(Failure::Build { path: task.name.to_owned(), error }),
        Err(error @ RunError::Threads { .. }) => Err(Failure::Machine(error.to_string())),
        Err(error) => Err(Failure::Other(error.to_string())),
    }
}

/// The end of a run that was stopped before the first tetrahedron.
pub(crate) fn finish_unbegun(
    task: &Task<'_>,
    points: usize,
    read_seconds: f64,
) -> Result<Exit, Failure> {
    let mut report = task.report(Input { points, ..Input::default() }, "cancelled");
    report.seconds.read = read_seconds;
    task.finish(&mut report)?;
    console::people("ltbw: stopped before the first tetrahedron; no mesh was written");
    Ok(Exit::Stopped)
}

/// Keeps what a check has found; the verdict for people, or none if there is a defect.
pub(crate) fn keep_check(checked: Checked, report: &mut Report, task: &Task<'_>) -> Option<String> {
    let hash = report.mesh.hash.clone().unwrap_or_default();
    report.certificate = checked.certificate.map(|mut own| {
        task.binding.bind(&mut own, &hash);
        own
    });
    if !checked.passed {
        return None;
    }
    console::people(&format!("checked   {}", checked.summary));
    Some(checked.summary)
}

/// Tells that points are nearly in one plane: their tetrahedra are as flat.
pub(crate) fn print_thickness(thickness: Option<Thickness>) {
    if let Some(thickness) = thickness {
        console::people(&format!("note: {thickness}"));
    }
}

/// Tells how many points, vertices and tetrahedra there are.
pub(crate) fn print_mesh(name: &str, report: &Report) {
    let Input { points, duplicates, .. } = &report.input;
    let doubles = match duplicates {
        0 => String::new(),
        n => format!(", {n} of them duplicates of others"),
    };
    console::people(&format!("points    {points} in {name}{doubles}"));
    let MeshPart { vertices, tets, hull_faces, .. } = &report.mesh;
    console::people(&format!(
        "mesh      {vertices} vertices, {tets} tetrahedra, {hull_faces} hull faces"
    ));
}

/// The word of a report for an outcome.
pub(crate) fn word_of(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Complete => "complete",
        Outcome::Cancelled => "cancelled",
        Outcome::Budget | Outcome::TooManyTets => "budget",
    }
}

/// Tells of a mesh that is not one of all points; the exit code.
pub(crate) fn ending(outcome: Outcome, report: &Report) -> Exit {
    if outcome == Outcome::Complete {
        return Exit::Done;
    }
    console::people(&format!(
        "ltbw: {}: {} of {} points meshed; the mesh is valid but was not checked",
        report.outcome, report.mesh.vertices, report.input.points
    ));
    Exit::Stopped
}
