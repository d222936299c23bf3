//! `delaunay` by several processes, none of which has the mesh: each has a part, hashes, checks and
//! writes with the others. The first one reports; for a file that holds a whole mesh, and for a
//! page, it is told all tetrahedra, 16 bytes each.

use crate::check::{checked_own, own_options};
use crate::console;
use crate::others::Apart;
use crate::outcome::{Exit, Failure, show};
use crate::page::Scene;
use crate::points::{
    ending, finish_unbegun, keep_check, print_mesh, print_thickness, unless_stopped, word_of,
};
use crate::progress::{Progress, Stage};
use crate::report::{Input, MeshPart, Predicates, Report};
use crate::task::{Judged, Task, wrote_parts};
use ltbw::distributed::{Gathered, Part};
use ltbw::io::{self, Arrays, PartOf, Piece};
use ltbw::quality::Quality;
use ltbw::threads::BuiltPart;
use ltbw::{Builder, Outcome, PointSet, TetMesh};
use ltbw_verify as verify;
use std::time::Instant;

/// The points, which every process has read.
pub(crate) struct Points<'a> {
    pub(crate) set: &'a PointSet,
    pub(crate) tags: Option<Vec<i64>>,
    /// Seconds it took to read them.
    pub(crate) read_seconds: f64,
}

/// Meshes points with the others.
pub(crate) fn mesh_points(
    others: &dyn Apart,
    points: Points<'_>,
    task: &Task<'_>,
) -> Result<Exit, Failure> {
    let set = points.set;
    let built = {
        let progress = Progress::begin("order", task.stop.begun());
        let builder = Builder::new().observer(&progress).cancel(task.stop.token());
        unless_stopped(others.build(&builder, set), task)?
    };
    let Some(built) = built else {
        return match others.is_first() {
            true => finish_unbegun(task, set.len(), points.read_seconds),
            false => Ok(Exit::Stopped),
        };
    };
    let mut report = report_of(&built, &points, task);
    let BuiltPart { part, outcome, .. } = built;
    if outcome == Outcome::Complete {
        task.stop.inserted();
    }
    let clock = Instant::now();
    let stage = Stage::begin("hash");
    let hashed = others.hash(&part)?;
    drop(stage);
    report.seconds.hash = clock.elapsed().as_secs_f64();
    report.mesh.hash = Some(hashed.hash.to_string());
    // Each member is told all of it.
    report.mesh.vertices = hashed.vertices as usize;
    report.input.distinct = report.mesh.vertices;
    print_mesh(&show(task.name), &report);
    print_thickness(set.points());
    let mut judged = Judged::unseen(None);
    if let (Outcome::Complete, Some(options)) = (outcome, own_options(task.check)) {
        let clock = Instant::now();
        let _stage = Stage::begin("check");
        let own = own_part(&part, set, others);
        let found = others.check(&own, &options)?;
        report.seconds.check = clock.elapsed().as_secs_f64();
        let checked = checked_own(&found, &hashed.hash.to_string());
        match keep_check(checked, &mut report, task) {
            Some(verdict) => judged.verdict = verdict,
            // All have the same report.
            None if others.is_first() => return Ok(task.refuse(&mut report)),
            None => return Ok(Exit::OwnDefect),
        }
    }
    report.outcome = word_of(outcome);
    let clock = Instant::now();
    write_parts(others, &part, &points, task, &mut report)?;
    let is_wanted = !task.outputs.whole.is_empty() || task.page.is_some();
    let whole = if is_wanted { others.gather(&part, set.len())? } else { None };
    drop(part);
    let written = match whole {
        Some(whole) => write_whole(whole, points, &mut judged, task, &mut report),
        None => Ok(()),
    };
    report.seconds.write = clock.elapsed().as_secs_f64();
    if others.is_first() {
        written?;
        task.finish(&mut report)?;
    }
    Ok(ending(outcome, &report))
}

/// The report of a build, without what comes after it.
fn report_of(built: &BuiltPart, points: &Points<'_>, task: &Task<'_>) -> Report {
    let input = Input {
        points: points.set.len(),
        distinct: 0,
        duplicates: built.duplicates.len(),
        duplicate_of: built.duplicates.iter().map(|&duplicate| duplicate.into()).collect(),
    };
    let mut report = task.report(input, "complete");
    report.seconds.read = points.read_seconds;
    [report.seconds.order, report.seconds.insert] = built.seconds;
    report.predicates = Predicates::from(&built.predicates);
    report.workers.clone_from(&built.workers);
    report.mesh = MeshPart {
        vertices: 0,
        tets: built.tets as usize,
        hull_faces: built.hull_faces as usize,
        hash: None,
    };
    report
}

/// The own part as the checker takes it, with this process's stretch of the points.
fn own_part<'a>(part: &'a Part, set: &'a PointSet, others: &dyn Apart) -> verify::Part<'a> {
    let [me, size] = [others.me(), others.size()].map(|n| n as usize);
    let stretch = |k: usize| k * set.len() / size;
    let given = &set.points()[stretch(me)..stretch(me + 1)];
    let Part { numbers, points, tets, .. } = part;
    verify::Part { points, numbers, tets, given }
}

/// Writes the own part of each mesh in parts: all or none of the files get their names.
fn write_parts(
    others: &dyn Apart,
    part: &Part,
    points: &Points<'_>,
    task: &Task<'_>,
    report: &mut Report,
) -> Result<(), Failure> {
    let in_parts = &task.outputs.in_parts;
    if in_parts.is_empty() {
        return Ok(());
    }
    let _stage = Stage::begin("write");
    let tags = points.tags.as_ref();
    let mesh = TetMesh {
        points: part.points.clone(),
        tets: part.tets.clone(),
        point_tags: tags.map(|all| part.numbers.iter().map(|&v| all[v as usize]).collect()),
        ..TetMesh::default()
    };
    let piece = Piece { mesh, numbers: part.numbers.clone() };
    let place = PartOf { part: others.me() as usize, of: others.size() as usize };
    for path in in_parts {
        let own = console::writing(|token| {
            let own = io::write_part(path, place, &piece, token)?;
            let arrays = Arrays { tags: tags.is_some(), ..Arrays::default() };
            let is_first = others.is_first();
            let list = is_first.then(|| io::write_list(path, place.of, arrays)).transpose()?;
            Ok((own, list))
        });
        // Whatever one cannot write, nobody has written.
        let (own, list) = others.together(own)?;
        others.together(own.publish().map_err(Failure::Write))?;
        others.together(list.map_or(Ok(()), |list| list.publish()).map_err(Failure::Write))?;
        wrote_parts(path, place.of, report);
    }
    Ok(())
}

/// Writes the files that hold the whole mesh, and the page.
fn write_whole(
    whole: Gathered,
    points: Points<'_>,
    judged: &mut Judged,
    task: &Task<'_>,
    report: &mut Report,
) -> Result<(), Failure> {
    let Gathered { tets, hull } = whole;
    let lengths: Vec<usize> = tets.iter().map(Vec::len).collect();
    let mesh = TetMesh {
        points: points.set.points().to_vec(),
        tets: tets.concat(),
        point_tags: points.tags,
        ..TetMesh::default()
    };
    drop(tets);
    task.write_whole(&mesh, Vec::new, report)?;
    if task.page.is_some() {
        judged.quality = Quality::of(&mesh.points, &mesh.tets);
        let workers: Vec<u32> = match lengths.len() {
            1 => Vec::new(),
            _ => (0..).zip(lengths).flat_map(|(k, n)| std::iter::repeat_n(k, n)).collect(),
        };
        let scene = Scene { mesh: &mesh, hull: &hull, workers: &workers };
        task.write_page(&scene, report, judged, None)?;
    }
    Ok(())
}
