//! The end of `mesh` where one process has the mesh: hash, check, write, report.

use crate::args::Depth;
use crate::conform::{certificate, check_own, print, same_volume, summary, tells_all_slivers};
use crate::console;
use crate::domain_job::Job;
use crate::domain_report::Told;
use crate::excused::{self, SliversLeft};
use crate::explained::{excused, is_explained, reasons};
use crate::json::write_text;
use crate::outcome::{Exit, Failure};
use crate::page::Scene;
use crate::pieces::parts_of;
use crate::progress::Stage;
use crate::report::{Measured, Report, Seconds, measured_json};
use crate::rounds;
use crate::surface::print_patches;
use crate::task::{Beside, Judged};
use crate::unrecovered;
use crate::workers::{Made, print_workers};
use ltbw::domain::Prepared;
use ltbw::quality::{self, Measures};
use ltbw::refine::{RefineOutcome, Refined, Verdict};
use ltbw::{TetMesh, canonical_hash};
use serde_json::Value;
use std::time::Instant;

/// A domain that was refined, and who did that.
pub(crate) struct Meshed {
    pub(crate) refined: Refined,
    pub(crate) made: Made,
    pub(crate) seconds: Seconds,
    /// The work of one process in the end, for the report.
    pub(crate) late: Option<Value>,
}

/// Checks a mesh that one process has, writes and reports.
pub(crate) fn finish(
    ready: &Prepared,
    job: &Job<'_>,
    Meshed { refined, made, mut seconds, late }: Meshed,
) -> Result<Exit, Failure> {
    let task = &job.task;
    let refined = job.boundary.mark(refined);
    let clock = Instant::now();
    let stage = Stage::begin("hash");
    let unrecovered = refined.outcome == RefineOutcome::Unrecovered;
    // Without the boundary nobody knows what is inside: the whole mesh, and no regions.
    let inside = match unrecovered {
        true => TetMesh {
            tet_tags: None,
            tet_attributes: None,
            faces: Vec::new(),
            ..refined.with_exterior()
        },
        false => refined.inside(),
    };
    let hash = canonical_hash(&inside.points, &inside.tets)
        .map_err(|e| Failure::Other(e.to_string()))?
        .to_string();
    seconds.hash = clock.elapsed().as_secs_f64();
    let slivers = SliversLeft::of(&refined);
    let told = Told::of(&refined, &slivers, made.splits.is_some());
    let mut report = told.report(job, ready);
    if let (Some(refinement), Some(late)) = (&mut report.refinement, late) {
        refinement["late"] = late;
    }
    report.mesh.hash = Some(hash);
    report.seconds = seconds;
    let with_arrays = !(unrecovered || task.outputs.whole.is_empty() || job.keep_exterior);
    let measures = Measures::of(&inside.points, &inside.tets, with_arrays);
    let (measured, arrays) = measures.map(|own| (own.quality, own.arrays)).unzip();
    let mut judged = Judged::unseen(told.measured(measured));
    drop(stage);
    told.print(judged.measured.as_ref());
    print_workers(&made);
    report.workers.clone_from(&made.workers);
    (report.redeals, report.share) = (made.redeals, made.share);
    print_patches(job.flat_tolerance, &refined.stats);
    report.quality = judged.measured.as_ref().map(measured_json);
    if refined.outcome != RefineOutcome::Cancelled {
        task.stop.inserted();
    }
    if unrecovered {
        return finish_unrecovered(job, &refined, &inside, report);
    }
    if task.check != Depth::Off && refined.outcome != RefineOutcome::Cancelled {
        match check(job, &refined, ready, &inside, &mut report) {
            Some(verdict) => judged.verdict = verdict,
            None => return Ok(task.refuse(&mut report)),
        }
    }
    let whole = job.keep_exterior.then(|| refined.with_exterior());
    let mesh = whole.as_ref().unwrap_or(&inside);
    let parts = || {
        let owners = made.owners.of(&refined, job.keep_exterior);
        parts_of(mesh, &owners, job.parts())
    };
    let values = || match &whole {
        Some(whole) => quality::arrays(&whole.points, &whole.tets),
        None => arrays.unwrap_or_else(|| quality::arrays(&inside.points, &inside.tets)),
    };
    task.write(mesh, Beside { values, names: &job.boundary.names }, parts, &mut report)?;
    rounds::write_trace(job.trace, &refined.rounds)?;
    if task.page.is_some() {
        let workers = job.crew.map(|_| made.owners.of(&refined, false)).unwrap_or_default();
        let excused = reasons(&refined);
        let (names, workers) = (&job.boundary.names, &workers);
        let scene = Scene { mesh: &inside, hull: &[], workers, names, excused: &excused };
        task.write_page(&scene, &report, &judged, None)?;
    }
    if let (Some(path), Some(Measured { quality, slivers })) = (job.histogram, &judged.measured) {
        write_text(path, &crate::picture::histograms::svg(quality, slivers))?;
    }
    task.finish(&mut report)?;
    Ok(ending(job, &refined, ready, &slivers))
}

/// Checks a mesh against its domain and keeps the certificate; the verdict for people, or none if
/// it has a defect that no excuse explains.
fn check(
    job: &Job<'_>,
    refined: &Refined,
    ready: &Prepared,
    inside: &TetMesh,
    report: &mut Report,
) -> Option<String> {
    let clock = Instant::now();
    let stage = Stage::begin("check");
    let excused = excused(refined);
    let mut found = check_own(inside, ready, job.asked, refined, excused.len());
    drop(stage);
    let same = same_volume(ready, &found);
    let all_told = tells_all_slivers(refined.slivers.len(), &found);
    let explained = is_explained(&found, inside, &excused) && same && all_told;
    let share = refined.excused_share();
    let word =
        Verdict::of(found.passed() && same && all_told, explained, &share, job.excused_share);
    let mut own = certificate(&found, same, word);
    job.task.binding.bind(&mut own, report.mesh.hash.as_deref().unwrap_or_default());
    report.certificate = Some(own);
    report.seconds.check = clock.elapsed().as_secs_f64();
    if !explained {
        print(&mut found);
        return None;
    }
    let verdict = match found.passed() {
        true => summary(&found),
        false => "sound; over its bounds only where it was excused".to_owned(),
    };
    console::people(&format!("checked   {verdict}"));
    Some(verdict)
}

/// Ends the work on a domain whose boundary could not be recovered.
fn finish_unrecovered(
    job: &Job<'_>,
    refined: &Refined,
    mesh: &TetMesh,
    mut report: Report,
) -> Result<Exit, Failure> {
    unrecovered::tell(refined);
    if job.write_unrecovered {
        let Some(written) = unrecovered::write(&job.task, mesh)? else {
            return Ok(Exit::OwnDefect);
        };
        report.outputs = written;
    }
    job.task.finish(&mut report)?;
    unrecovered::end(refined, !report.outputs.is_empty());
    Ok(Exit::Defect)
}

/// Tells in a last line what is over a bound, if anything is.
fn ending(job: &Job<'_>, refined: &Refined, ready: &Prepared, slivers: &SliversLeft) -> Exit {
    let share = refined.excused_share();
    let is_little = share.is_within(job.excused_share);
    let is_met = refined.outcome == RefineOutcome::Met;
    slivers.print(ready, share.flat > 0 && is_met);
    let (exit, word) = match refined.outcome {
        RefineOutcome::Met if share.flat > 0 => return Exit::Defect,
        RefineOutcome::Met => return Exit::Done,
        RefineOutcome::Excused if is_little => (Exit::Done, "excused, and little enough"),
        RefineOutcome::Excused | RefineOutcome::Unrecovered => (Exit::Defect, "excused"),
        RefineOutcome::Budget => (Exit::Stopped, "budget used up"),
        RefineOutcome::Cancelled => {
            console::people("ltbw: cancelled: the mesh is Delaunay, but need not meet the bounds");
            return Exit::Stopped;
        }
    };
    let text = excused::text(refined, ready, job.asked.radius_edge, job.excused_share);
    console::people(&format!("ltbw: {word}: {text}"));
    exit
}
