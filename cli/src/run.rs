//! `delaunay`: read, order, insert, hash, check, write, report.

#[cfg(feature = "wire")]
use crate::apart;
use crate::args::{Delaunay, Depth};
use crate::binding::{Binding, Chosen, Read, Role};
use crate::check::check_own;
use crate::console::{self, Stop};
use crate::figures::{Doing, Figures, Run, SPANS, tables, write_trace};
use crate::lists::{Lists, lists};
use crate::others::Others;
use crate::outcome::{Exit, Failure, show};
use crate::page::{self, Scene};
use crate::pieces::part_of;
use crate::points::{
    ending, finish_unbegun, keep_check, print_mesh, print_thickness, unless_stopped, word_of,
};
use crate::progress::{self, Progress, Stage};
use crate::report::{Input, Measured, MeshPart, Predicates, Report};
use crate::task::{ALONE, Files, Judged, Task};
use crate::without::{Given, Without};
use ltbw::balance::Balance;
use ltbw::domain::Thickness;
use ltbw::io::PointFile;
use ltbw::quality::Quality;
use ltbw::{Builder, Built, Outcome, PointSet, TetMesh};
use ltbw_verify as verify;
use std::path::Path;
use std::time::Instant;

/// The task with a point set.
struct Job<'a> {
    task: Task<'a>,
    /// Seconds it took to read the points.
    read_seconds: f64,
    /// Workers that insert the points.
    workers: u32,
    /// Other demands on them.
    parallel: ParallelJob<'a>,
    /// Points to be removed.
    without: Option<Without>,
}

/// The demands on the parallel kernel.
struct ParallelJob<'a> {
    /// Blocks go to workers that run out of points.
    balance: bool,
    /// The figures are printed.
    tables: bool,
    /// The file of the timeline.
    trace: Option<&'a Path>,
}

/// `ltbw delaunay`.
pub(crate) fn delaunay(args: &Delaunay, others: Others<'_>) -> Result<Exit, Failure> {
    let start = Instant::now();
    let workers = others.map_or(args.threads.map_or(1, u32::from), |others| others.size());
    let files = Files {
        input: &args.points,
        inputs: [&args.points].into_iter().chain(&args.without).cloned().collect(),
        outputs: &args.output,
        streams: &args.streams,
        others: [&args.json, &args.trace, &args.page].into_iter().flatten().cloned().collect(),
        parts: workers as usize,
    };
    let outputs = files.look()?;
    if others.is_none() && workers < 2 && (args.trace.is_some() || args.tables || args.balance) {
        let text = "--trace, --tables and --balance are about several workers: --threads 2 or more";
        return Err(Failure::Usage(text.to_owned()));
    }
    if args.without.is_some() && !outputs.in_parts.is_empty() {
        let text = "--without: a mesh of which points were removed is not left distributed";
        return Err(Failure::Usage(text.to_owned()));
    }
    let source = outputs.formats.input(&args.points)?;
    let stop = Stop::on_signal()?;
    let task = Task {
        command: "delaunay",
        name: &source.name,
        outputs: &outputs,
        json: args.json.as_deref(),
        page: args.page.as_deref(),
        check: args.check,
        binding: Binding::default(),
        stop: &stop,
        start,
    };
    #[cfg(feature = "wire")]
    if let Some(others) = others {
        return apart::delaunay(others, &source, task);
    }
    progress::plan(&["read", "order", "insert", "hash", "check", "write"]);
    let stage = Stage::begin("read");
    let file = source.points()?;
    let mut reads = source.reads().list();
    let mut without = None;
    if let Some(path) = &args.without {
        let source = outputs.formats.input(path)?;
        without = Some(Without { points: source.points()?.points, name: source.name.clone() });
        let all = source.reads().list();
        reads.extend(all.into_iter().map(|read| Read { role: Role::Without, ..read }));
    }
    drop(stage);
    let parallel =
        ParallelJob { balance: args.balance, tables: args.tables, trace: args.trace.as_deref() };
    let binding = Binding { inputs: reads, options: Chosen::default() };
    let task = Task { binding, ..task };
    let read_seconds = start.elapsed().as_secs_f64();
    mesh_points(file, &Job { task, read_seconds, workers, parallel, without })
}

/// Meshes points: builds, hashes, checks, writes and reports.
fn mesh_points(file: PointFile, job: &Job<'_>) -> Result<Exit, Failure> {
    let task = &job.task;
    let name = show(task.name);
    file.notes.iter().for_each(|n| console::people(&format!("note: {name}: {n}")));
    let tags = file.point_tags;
    let count = file.points.len();
    let set = PointSet::new(file.points)
        .map_err(|error| Failure::Points { path: task.name.to_owned(), error })?;
    let Some(mut built) = build(&set, job)? else {
        return finish_unbegun(task, count, job.read_seconds);
    };
    let mut given = Given { set, tags };
    if let Some(without) = job.without.as_ref().filter(|_| built.outcome == Outcome::Complete) {
        given = without.remove(&mut built, given)?;
    }
    let Given { set, tags: point_tags } = given;
    let count = set.len();
    let mut report = report_of(&built, count, job);
    let Built { mesh, outcome, workers, parts, summary, trace, .. } = built;
    report.workers = workers;
    report.parallel = summary.as_ref().map(Figures::of);
    if outcome == Outcome::Complete {
        task.stop.inserted();
    }
    print_mesh(&name, &report);
    print_thickness(Thickness::of_flat(set.points()));
    if let Some(summary) = summary.filter(|_| job.parallel.tables) {
        let clock = Some((report.seconds.insert * 1e9) as u64);
        let run = Run { doing: Doing::Insertion, alone: None, whole: None, clock };
        console::people(tables(&summary, &run).trim_end());
    }
    let timeline = match (task.page, &trace, &report.parallel) {
        (Some(_), Some(trace), Some(figures)) => {
            Some(page::timeline(trace, job.workers as usize, figures.makespan()))
        }
        _ => None,
    };
    if let Some(path) = job.parallel.trace {
        let _stage = Stage::begin("trace");
        write_trace(path, trace)?;
    }
    let clock = Instant::now();
    let stage = Stage::begin("hash");
    report.mesh.hash = Some(mesh.hash().map_err(|e| Failure::Other(e.to_string()))?.to_string());
    drop(stage);
    report.seconds.hash = clock.elapsed().as_secs_f64();
    let to_check = outcome == Outcome::Complete && task.check != Depth::Off;
    // The input's own coordinates, under the input's numbers.
    let clock = Instant::now();
    let Lists { tets, neighbours } = match to_check {
        true => lists(&mesh),
        false => Lists { tets: mesh.tets().collect(), neighbours: Vec::new() },
    };
    let hull: Vec<[u32; 3]> = mesh.hull_facets().collect();
    drop(mesh);
    let mut judged = Judged::unseen(None);
    if to_check {
        let own = verify::Mesh::new(set.points(), &tets).with_hull(&hull);
        let verdict = check(&own.with_neighbours(&neighbours), &mut report, task);
        report.seconds.check = clock.elapsed().as_secs_f64();
        match verdict {
            Some(verdict) => judged.verdict = verdict,
            None => return Ok(task.refuse(&mut report)),
        }
    }
    report.outcome = word_of(outcome);
    let points = set.points().to_vec();
    let mesh = TetMesh { points, tets, point_tags, ..TetMesh::default() };
    let part = |tets: &Vec<[u32; 4]>| part_of(&mesh, tets.clone(), Vec::new());
    task.write(&mesh, ALONE, || parts.iter().map(part).collect(), &mut report)?;
    if task.page.is_some() {
        judged.measured = Quality::of(&mesh.points, &mesh.tets).map(Measured::plain);
        let workers = owners(&mesh, &parts);
        let scene = Scene { mesh: &mesh, hull: &hull, workers: &workers, names: &[], excused: &[] };
        task.write_page(&scene, &report, &judged, timeline.as_deref())?;
    }
    task.finish(&mut report)?;
    Ok(ending(outcome, &report))
}

/// Checks a mesh and keeps its certificate; the verdict for people, or none if it has a defect.
fn check(own: &verify::Mesh<'_>, report: &mut Report, task: &Task<'_>) -> Option<String> {
    let _stage = Stage::begin("check");
    let hash = report.mesh.hash.clone().unwrap_or_default();
    match check_own(own, &hash, task.check) {
        Some(checked) => keep_check(checked, report, task),
        None => Some(Judged::unseen(None).verdict),
    }
}

/// Builds the mesh, on as many threads as the job has workers; none if it was stopped too early.
fn build(set: &PointSet, job: &Job<'_>) -> Result<Option<Built>, Failure> {
    let task = &job.task;
    let progress = Progress::begin("order", task.stop.begun());
    let mut builder = Builder::new().threads(job.workers);
    builder = builder.observer(&progress).cancel(task.stop.token());
    if job.parallel.balance {
        builder = builder.balance(Balance::default());
    }
    // Taking the time takes some.
    let is_traced = task.page.is_some() || job.parallel.trace.is_some();
    if task.json.is_some() || job.parallel.tables || is_traced {
        builder = builder.measure(if is_traced { SPANS } else { 0 });
    }
    if !task.outputs.in_parts.is_empty() || (task.page.is_some() && job.workers > 1) {
        builder = builder.parts();
    }
    unless_stopped(builder.build(set), task)
}

/// The report of a build, without what comes after it.
fn report_of(built: &Built, points: usize, job: &Job<'_>) -> Report {
    let Built { mesh, stats, duplicates, .. } = built;
    let input = Input {
        points,
        distinct: mesh.num_vertices(),
        duplicates: duplicates.len(),
        duplicate_of: duplicates.iter().map(|&duplicate| duplicate.into()).collect(),
    };
    let mut report = job.task.report(input, "complete");
    report.seconds.read = job.read_seconds;
    report.seconds.order = stats.order_seconds;
    report.seconds.insert = stats.insert_seconds;
    report.predicates = Predicates::from(&stats.predicates);
    report.mesh = MeshPart {
        vertices: mesh.num_vertices(),
        tets: mesh.num_tets(),
        hull_faces: mesh.num_hull_faces(),
        hash: None,
    };
    report
}

/// The worker of each tetrahedron; none if there was one alone.
fn owners(mesh: &TetMesh, parts: &[Vec<[u32; 4]>]) -> Vec<u32> {
    if parts.len() < 2 {
        return Vec::new();
    }
    let sorted = |tet: &[u32; 4]| {
        let mut corners = *tet;
        corners.sort_unstable();
        corners
    };
    let of_part = |(worker, tets): (u32, &Vec<[u32; 4]>)| {
        tets.iter().map(|tet| (sorted(tet), worker)).collect::<Vec<_>>()
    };
    let mut owners: Vec<([u32; 4], u32)> = (0..).zip(parts).flat_map(of_part).collect();
    owners.sort_unstable();
    let owner = |tet: &[u32; 4]| {
        let found = owners.binary_search_by_key(&sorted(tet), |&(corners, _)| corners);
        found.map_or(0, |place| owners[place].1)
    };
    mesh.tets.iter().map(owner).collect()
}
