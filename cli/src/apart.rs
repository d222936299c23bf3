//! The command `delaunay` by several processes, none of which has all points or the mesh: each has
//! a slice and a part, hashes, checks and writes with the others. The first one reports; for a file
//! that holds a whole mesh, and for a page, it is told all points and all tetrahedra.

use crate::check::{checked_own, own_options};
use crate::console;
use crate::others::{Apart, Ranks};
use crate::outcome::{Exit, Failure, show};
use crate::page::Scene;
use crate::points::{
    ending, finish_unbegun, keep_check, print_mesh, print_thickness, unless_stopped, word_of,
};
use crate::processes;
use crate::progress::{Progress, Stage};
use crate::report::{Input, Measured, MeshPart, Predicates, Report};
use crate::slices::{Sliced, read};
use crate::streams::Source;
use crate::task::{ALONE, InParts, Judged, Task};
use ltbw::distributed::{self, Gathered, Part, Slice};
use ltbw::io::{self, Arrays, Bordered, PartOf, PartSizes, Piece, Slabs};
use ltbw::quality::Quality;
use ltbw::threads::BuiltPart;
use ltbw::{Builder, Outcome, TetMesh};
use ltbw_verify as verify;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The own slice of the points.
struct Points<'a> {
    slice: &'a Slice,
    tags: Option<Vec<i64>>,
    /// Seconds it took to read them.
    read_seconds: f64,
}

/// `ltbw-mpi delaunay`.
pub(crate) fn delaunay(
    others: &dyn Ranks,
    source: &Source,
    mut task: Task<'_>,
) -> Result<Exit, Failure> {
    let apart = others.apart();
    let stage = Stage::begin("read");
    let Sliced { points, tags, notes, reads } = read(others, source)?;
    drop(stage);
    task.binding.inputs = reads;
    let name = show(task.name);
    notes.iter().for_each(|n| console::people(&format!("note: {name}: {n}")));
    let slice = match apart.slice(points)? {
        Ok(slice) => slice,
        Err(distributed::SliceError::Points(error)) => {
            return Err(Failure::Points { path: task.name.to_owned(), error });
        }
        Err(error) => return Err(Failure::Other(error.to_string())),
    };
    let read_seconds = task.start.elapsed().as_secs_f64();
    mesh_points(apart, Points { slice: &slice, tags, read_seconds }, &task)
}

/// Meshes points with the others.
fn mesh_points(others: &dyn Apart, points: Points<'_>, task: &Task<'_>) -> Result<Exit, Failure> {
    let slice = points.slice;
    let built = {
        let progress = Progress::begin("order", task.stop.begun());
        let builder = Builder::new().observer(&progress).cancel(task.stop.token());
        unless_stopped(others.build(&builder, slice), task)?
    };
    let Some(built) = built else {
        return match others.is_first() {
            true => finish_unbegun(task, slice.total() as usize, points.read_seconds),
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
    print_thickness(others.thickness(slice)?);
    let mut judged = Judged::unseen(None);
    if let (Outcome::Complete, Some(options)) = (outcome, own_options(task.check)) {
        let clock = Instant::now();
        let _stage = Stage::begin("check");
        let own = own_part(&part, slice);
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
    report.seconds.write = clock.elapsed().as_secs_f64();
    processes::tell(others, &mut report)?;
    let is_wanted = !task.outputs.whole.is_empty() || task.page.is_some();
    let tags = points.tags.as_deref();
    let whole = match is_wanted {
        true => {
            others.gather(&part, slice.total() as usize)?.zip(others.gather_points(slice, tags)?)
        }
        false => None,
    };
    drop(part);
    let written = match whole {
        Some((whole, points)) => write_whole(whole, points, &mut judged, task, &mut report),
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
        points: points.slice.total() as usize,
        distinct: 0,
        duplicates: built.num_duplicates as usize,
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

/// The own part as the checker takes it, with this process's slice of the points.
fn own_part<'a>(part: &'a Part, slice: &'a Slice) -> verify::Part<'a> {
    let Part { numbers, points, tets, .. } = part;
    verify::Part { points, numbers, tets, given: slice.points() }
}

/// Writes the own part of each mesh in parts: all or none of the files get their names.
fn write_parts(
    others: &dyn Apart,
    part: &Part,
    points: &Points<'_>,
    task: &Task<'_>,
    report: &mut Report,
) -> Result<(), Failure> {
    if task.outputs.in_parts.is_empty() {
        return Ok(());
    }
    let point_tags = others.tags(points.slice, points.tags.as_deref(), &part.numbers)?;
    let arrays = Arrays { tags: point_tags.is_some(), ..Arrays::default() };
    let mesh = TetMesh {
        points: part.points.clone(),
        tets: part.tets.clone(),
        point_tags,
        ..TetMesh::default()
    };
    let piece = Piece { mesh, numbers: part.numbers.clone() };
    write_pieces(others, &piece, arrays, task, report)
}

/// Writes a piece into each mesh in parts, with the others.
pub(crate) fn write_pieces(
    others: &dyn Apart,
    piece: &Piece,
    arrays: Arrays,
    task: &Task<'_>,
    report: &mut Report,
) -> Result<(), Failure> {
    let in_parts = &task.outputs.in_parts;
    if in_parts.is_empty() {
        return Ok(());
    }
    let _stage = Stage::begin("write");
    let border = others.border(piece)?;
    let own = Bordered { piece, border: &border };
    for path in in_parts {
        match io::has_slabs(path) {
            true => write_slabs(others, path, arrays, own)?,
            false => write_files(others, path, arrays, own)?,
        }
        InParts { parts: others.size() as usize, has_tags: arrays.tags }.wrote(path, report);
    }
    Ok(())
}

/// Writes the file of the own part; the first process writes the list, if there is one.
fn write_files(
    others: &dyn Apart,
    path: &Path,
    arrays: Arrays,
    Bordered { piece, border }: Bordered<'_>,
) -> Result<(), Failure> {
    let place = PartOf { part: others.me() as usize, of: others.size() as usize };
    let own = console::writing(|token| {
        let own = io::write_part(path, place, piece, border, token)?;
        let has_list = others.is_first() && io::has_list(path);
        let list = has_list.then(|| io::write_list(path, place.of, arrays)).transpose()?;
        Ok((own, list))
    });
    // Whatever one cannot write, nobody has written.
    let (own, list) = others.together(own)?;
    others.together(own.publish().map_err(Failure::Write))?;
    others.together(list.map_or(Ok(()), |list| list.publish()).map_err(Failure::Write))
}

/// Writes the own slabs of a file that the first process begins, and gives its name.
fn write_slabs(
    others: &dyn Apart,
    path: &Path,
    arrays: Arrays,
    own: Bordered<'_>,
) -> Result<(), Failure> {
    let PartSizes { points, tets, faces } = PartSizes::of(own.piece);
    let sizes: Vec<[u64; 3]> = others.all(&[points, tets, faces])?;
    let of = |[points, tets, faces]: [u64; 3]| PartSizes { points, tets, faces };
    let slabs = Slabs::new(sizes.into_iter().map(of).collect(), arrays);
    let begun = others.is_first().then(|| io::begin_slabs(path, &slabs)).transpose();
    let begun = others.together(begun.map_err(Failure::Write))?;
    let aside = begun.as_ref().map(|file| file.aside().to_owned());
    let all: Vec<Option<PathBuf>> = others.all(&aside)?;
    let Some(Some(aside)) = all.into_iter().next() else {
        return Err(Failure::Other("the first process has begun no file".to_owned()));
    };
    let part = others.me() as usize;
    let written = io::write_slabs(path, &aside, &slabs, part, own);
    others.together(written.map_err(Failure::Write))?;
    others.together(begun.map_or(Ok(()), |file| file.publish()).map_err(Failure::Write))
}

/// Writes the files that hold the whole mesh, and the page.
fn write_whole(
    whole: Gathered,
    points: distributed::Points,
    judged: &mut Judged,
    task: &Task<'_>,
    report: &mut Report,
) -> Result<(), Failure> {
    let Gathered { tets, hull } = whole;
    let lengths: Vec<usize> = tets.iter().map(Vec::len).collect();
    let mesh = TetMesh {
        points: points.at,
        tets: tets.concat(),
        point_tags: points.tags,
        ..TetMesh::default()
    };
    drop(tets);
    task.write_whole(&mesh, ALONE, report)?;
    if task.page.is_some() {
        judged.measured = Quality::of(&mesh.points, &mesh.tets).map(Measured::plain);
        let workers: Vec<u32> = match lengths.len() {
            1 => Vec::new(),
            _ => (0..).zip(lengths).flat_map(|(k, n)| std::iter::repeat_n(k, n)).collect(),
        };
        let scene = Scene { mesh: &mesh, hull: &hull, workers: &workers, names: &[], excused: &[] };
        task.write_page(&scene, report, judged, None)?;
    }
    Ok(())
}
