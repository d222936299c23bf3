//! The commands `mesh` and `refine` by several processes. Where nothing is left in the end that
//! takes the whole mesh, each keeps, hashes, checks and writes its part with the others, and the
//! first one reports; for a file that holds the whole, and for a page, it is told plain arrays.
//! Else the first one puts the mesh together, and goes on alone.

use crate::apart::write_pieces;
use crate::args::Depth;
use crate::conform::{certificate, own_limits, print, same_volume, summary, tells_all_slivers};
use crate::console;
use crate::domain_job::Job;
use crate::domain_report::Told;
use crate::domain_whole::{Meshed, finish};
use crate::excused::{SliverLeft, SliversLeft};
use crate::json::write_text;
use crate::others::{Apart, Work};
use crate::outcome::{Exit, Failure};
use crate::page::Scene;
use crate::picture::histograms;
use crate::plc::plc_of;
use crate::processes;
use crate::progress::{Progress, Stage};
use crate::quality_apart;
use crate::report::{Seconds, measured_json};
use crate::surface::print_patches;
use crate::task::{Beside, Judged};
use crate::workers::{Made, Redeals, Setting, Share, print_workers};
use ltbw::TetMesh;
use ltbw::distributed::{Joined, Part};
use ltbw::domain::Prepared;
use ltbw::io::{Arrays, Piece};
use ltbw::quality;
use ltbw::refine::{ExcusedShare, RefineOutcome, Sliver, Verdict, attributes_of};
use ltbw::refining::{LateSteps, PartMesh, RefinedPart, RefinedWhole, TeamEnd, Wishes};
use ltbw::threads::Parallel;
use ltbw_verify as verify;
use serde_json::{Value, json};
use std::time::Instant;

/// Refines a prepared domain with the others, checks the mesh, writes and reports.
pub(crate) fn mesh(
    others: &dyn Apart,
    ready: &Prepared,
    job: &Job<'_>,
    mut seconds: Seconds,
) -> Result<Exit, Failure> {
    let task = &job.task;
    let clock = Instant::now();
    let end = {
        let progress = Progress::begin("recover", task.stop.begun());
        let parallel = Parallel::new(others.size()).among_processes();
        let (mode, redeal) = job.crew.map(|crew| (crew.mode, crew.redeal)).unwrap_or_default();
        let parallel = parallel.redeal(redeal).cancel(task.stop.token());
        let work = Work { parallel: &parallel, token: task.stop.token(), mode };
        let markers = job.boundary.markers();
        let with_exterior = job.keep_exterior && task.outputs.has_meshes();
        let wishes = Wishes { in_parts: true, with_exterior, markers, ..Wishes::default() };
        let end = others.refine(&job.refiner(&progress), ready, work, wishes);
        end.map_err(|error| Setting { name: task.name, stop: task.stop }.failed(error))?
    };
    seconds.refine = clock.elapsed().as_secs_f64();
    match end {
        TeamEnd::Part(part) => finish_part(others, ready, job, Own { part: *part, seconds }),
        TeamEnd::Whole(run, late) => {
            let (refined, made) = *run;
            let LateSteps { why, tets, seconds: spent } = late;
            let late = json!({ "why": why.to_string(), "gathered": tets, "seconds": spent });
            finish(ready, job, Meshed { refined, made, seconds, late: Some(late) })
        }
        // The first process has the mesh.
        TeamEnd::Elsewhere => Ok(Exit::Done),
    }
}

/// A process's part, and the time so far.
struct Own {
    part: RefinedPart,
    seconds: Seconds,
}

/// Hashes, checks, writes and reports a mesh in parts.
fn finish_part(
    others: &dyn Apart,
    ready: &Prepared,
    job: &Job<'_>,
    Own { part: own, mut seconds }: Own,
) -> Result<Exit, Failure> {
    let RefinedPart { inside, outside, with_exterior, whole, .. } = own;
    let task = &job.task;
    let clock = Instant::now();
    let stage = Stage::begin("hash");
    let hashed = others.hash(&inside.part)?;
    job.boundary.tell();
    let quality = quality_apart::quality(others, &inside.part)?;
    drop(stage);
    seconds.hash = clock.elapsed().as_secs_f64();
    let slivers: Vec<SliverLeft> = whole
        .slivers
        .iter()
        .map(|own| SliverLeft { angle: own.angle, at: own.at, near: own.near })
        .collect();
    let is_flat = slivers.iter().any(|own| own.angle < Sliver::FLAT);
    let slivers = SliversLeft::new(whole.stats.min_dihedral, slivers);
    let told = Told {
        outcome: RefineOutcome::Met,
        mesh: [whole.vertices, whole.tets, whole.hull_faces].map(|count| count as usize),
        predicates: whole.predicates,
        stats: &whole.stats,
        regions: &whole.regions,
        slivers: &slivers,
        refined: None,
        is_timed: whole.splits.is_some(),
    };
    let mut report = told.report(job, ready);
    if let Some(refinement) = &mut report.refinement {
        refinement["late"] = Value::Null;
    }
    report.mesh.hash = Some(hashed.hash.to_string());
    report.seconds = seconds;
    let measured = told.measured(quality);
    told.print(measured.as_ref());
    let redeals = Redeals::of(&whole.figures);
    let (workers, splits) = (whole.workers.clone(), whole.splits);
    let share = Share::of(&whole.figures, &workers, whole.vertices);
    let made = Made { workers, redeals, splits, share, ..Made::default() };
    print_workers(&made);
    (report.workers, report.redeals, report.share) = (made.workers, redeals, share);
    print_patches(job.flat_tolerance, &whole.stats);
    report.quality = measured.as_ref().map(measured_json);
    task.stop.inserted();
    let attributes = attributes_of(&whole.regions);
    let named = |mesh| with_attributes(mesh, attributes.as_deref());
    let piece_of = |own: PartMesh| {
        let Piece { mesh, numbers } = own.into_piece();
        Piece { mesh: named(mesh), numbers }
    };
    let (piece, with_exterior) = (piece_of(inside), with_exterior.map(piece_of));
    let checked = match task.check {
        Depth::Off => None,
        _ => Some(check(others, ready, job, &whole, &piece)?),
    };
    let is_refused = checked.as_ref().is_some_and(|checked| !checked.has_passed);
    let mut judged = Judged::unseen(measured);
    if let Some(Checked { mut certificate, seconds, verdict, .. }) = checked {
        judged.verdict = verdict;
        let hash = report.mesh.hash.as_deref().unwrap_or_default();
        task.binding.bind(&mut certificate, hash);
        report.certificate = Some(certificate);
        report.seconds.check = seconds;
    }
    if is_refused {
        // All have the same findings.
        return match others.is_first() {
            true => Ok(task.refuse(&mut report)),
            false => Ok(Exit::OwnDefect),
        };
    }
    let clock = Instant::now();
    let arrays =
        Arrays { tags: false, regions: true, markers: true, attributes: attributes.is_some() };
    // A page shows the domain alone.
    let has_page = task.page.is_some();
    let ((written, beside), shown) = match with_exterior {
        Some(all) => ((all, Part::default()), has_page.then_some((piece, outside))),
        None => ((piece, outside), None),
    };
    write_pieces(others, &written, arrays, task, &mut report)?;
    report.seconds.write = clock.elapsed().as_secs_f64();
    processes::tell(others, &mut report)?;
    let join = |piece, beside| -> Result<Option<Joined>, Failure> {
        let joined = others.join(piece, beside, whole.vertices)?;
        Ok(joined.map(|own| Joined { mesh: named(own.mesh), ..own }))
    };
    let names = &job.boundary.names;
    let has_files = !task.outputs.whole.is_empty();
    let mut joined = None;
    if has_files || (has_page && shown.is_none()) {
        let _stage = Stage::begin(if has_files { "write" } else { "page" });
        joined = join(written, beside)?;
        if let Some(Joined { mesh, .. }) = joined.as_ref().filter(|_| has_files) {
            let values = || quality::arrays(&mesh.points, &mesh.tets);
            task.write_whole(mesh, Beside { values, names }, &mut report)?;
        }
    }
    report.seconds.write = clock.elapsed().as_secs_f64();
    if let Some((piece, outside)) = shown {
        drop(joined);
        joined = join(piece, outside)?;
    }
    if let Some(Joined { mesh, owners }) = joined {
        // Nothing is excused where all keep their parts.
        let scene = Scene { mesh: &mesh, hull: &[], workers: &owners, names, excused: &[] };
        task.write_page(&scene, &report, &judged, None)?;
    }
    if others.is_first() {
        if let (Some(path), Some(measured)) = (job.histogram, &judged.measured) {
            write_text(path, &histograms::svg(&measured.quality, &measured.slivers))?;
        }
        task.finish(&mut report)?;
    }
    slivers.print(ready, is_flat);
    Ok(if is_flat { Exit::Defect } else { Exit::Done })
}

/// A mesh with the attributes of its regions, if they have some.
fn with_attributes(mesh: TetMesh, of: Option<&[f64]>) -> TetMesh {
    let value = |&region: &i64| usize::try_from(region).ok().and_then(|k| of?.get(k).copied());
    let tet_attributes = mesh.tet_tags.iter().flatten().map(value).collect();
    TetMesh { tet_attributes: of.and(tet_attributes), ..mesh }
}

/// The verdict on a mesh in parts.
struct Checked {
    /// For people.
    verdict: String,
    has_passed: bool,
    certificate: Value,
    seconds: f64,
}

/// Checks the mesh against its domain, with the others.
fn check(
    others: &dyn Apart,
    ready: &Prepared,
    job: &Job<'_>,
    whole: &RefinedWhole,
    piece: &Piece,
) -> Result<Checked, Failure> {
    let clock = Instant::now();
    let stage = Stage::begin("check");
    let degrees = whole.stats.min_dihedral;
    let limits = own_limits(ready, job.asked, (degrees > 0.0).then_some(degrees));
    let plc = plc_of(ready.judged(), whole.stats.flat_tolerance);
    let Piece { mesh, numbers } = piece;
    let TetMesh { points, tets, tet_tags, .. } = mesh;
    let own = verify::DomainPart { points, numbers, tets, tags: tet_tags.as_deref() };
    let options = verify::Options { numbered_regions: true, ..verify::Options::default() };
    let mut found = others.conforms(&own, &plc, &limits, &options)?;
    drop(stage);
    let same = same_volume(ready, &found);
    let all_told = tells_all_slivers(whole.slivers.len(), &found);
    let has_passed = found.passed() && same && all_told;
    let flat = whole.slivers.iter().filter(|own| own.angle < Sliver::FLAT).count();
    let share = ExcusedShare { flat, ..ExcusedShare::default() };
    let word = Verdict::of(has_passed, has_passed, &share, job.excused_share);
    let certificate = certificate(&found, same, word);
    let seconds = clock.elapsed().as_secs_f64();
    let verdict = summary(&found);
    match has_passed {
        true => console::people(&format!("checked   {verdict}")),
        false => print(&mut found),
    }
    Ok(Checked { verdict, has_passed, certificate, seconds })
}
