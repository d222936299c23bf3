//! `delaunay`: read, order, insert, hash, check, write, report.

use crate::args::{Delaunay, Depth};
use crate::binding::{Binding, Chosen};
use crate::check::check_own;
use crate::console::{self, Stop};
use crate::figures::{Doing, Figures, Run, SPANS, tables, write_trace};
use crate::json::{distinct, file_writable, keep_input, without_pairs, write_text};
use crate::lists::lists;
use crate::outcome::{Exit, Failure, show};
use crate::page::{self, Page, Scene};
use crate::pieces::part_of;
use crate::progress::{Progress, Stage};
use crate::report::{Input, Insphere, MeshPart, Orient3d, Predicates, Report, Seconds, end};
use crate::streams::{Formats, name_of, on_stdout};
use ltbw::balance::Balance;
use ltbw::domain::Thickness;
use ltbw::io::{self, MeshWriter, PointFile};
use ltbw::quality::Quality;
use ltbw::threads::RunError;
use ltbw::{BuildError, Builder, Built, Outcome, Point, PointSet, TetMesh};
use ltbw_verify as verify;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The task with a point set.
pub(crate) struct Job<'a> {
    /// `delaunay` or `demo`.
    pub(crate) command: &'static str,
    /// The name of the points in messages.
    pub(crate) name: &'a Path,
    /// Mesh files to write, and the formats that their names do not tell.
    pub(crate) outputs: &'a [PathBuf],
    pub(crate) formats: Formats,
    /// The file of the report.
    pub(crate) json: Option<&'a Path>,
    /// The depth of the check.
    pub(crate) check: Depth,
    /// Cancels the insertion.
    pub(crate) stop: &'a Stop,
    /// The start of the program.
    pub(crate) start: Instant,
    /// Seconds it took to read the points.
    pub(crate) read_seconds: f64,
    /// Workers that insert the points.
    pub(crate) workers: u32,
    /// An output goes to stdout, and so nothing else does.
    pub(crate) stdout_taken: bool,
    /// The file of the page.
    pub(crate) page: Option<&'a Path>,
    /// Other demands on them.
    pub(crate) parallel: ParallelJob<'a>,
    /// Input and options, to which the certificate is bound.
    pub(crate) binding: Binding,
}

/// The demands on the parallel kernel.
#[derive(Clone, Copy, Default)]
pub(crate) struct ParallelJob<'a> {
    /// Blocks go to workers that run out of points.
    pub(crate) balance: bool,
    /// The figures are printed.
    pub(crate) tables: bool,
    /// The file of the timeline.
    pub(crate) trace: Option<&'a Path>,
}

/// `ltbw delaunay`.
pub(crate) fn delaunay(args: &Delaunay) -> Result<Exit, Failure> {
    let start = Instant::now();
    let workers = args.threads.map_or(1, u32::from);
    let outputs = without_pairs(&args.output);
    let (parts, whole): (Vec<_>, Vec<_>) =
        outputs.iter().cloned().partition(|path| io::is_parts(path));
    let formats = args.streams.resolve(&[&args.points], &outputs)?;
    formats.meshes_writable(&whole)?;
    for path in &parts {
        io::check_parts_writable(path, workers as usize).map_err(Failure::Write)?;
    }
    args.json.as_deref().map_or(Ok(()), file_writable)?;
    let pages = [&args.trace, &args.page].into_iter().flatten();
    pages.clone().try_for_each(|path| file_writable(path))?;
    if workers < 2 && (args.trace.is_some() || args.tables || args.balance) {
        let text = "--trace, --tables and --balance are about several workers: --threads 2 or more";
        return Err(Failure::Usage(text.to_owned()));
    }
    let written = whole.iter().flat_map(io::mesh_files);
    let written = written.chain(parts.iter().flat_map(|p| io::part_files(p, workers as usize)));
    let written = written.chain(args.json.clone()).chain(pages.cloned());
    let written: Vec<PathBuf> = written.collect();
    distinct(&written)?;
    written.iter().try_for_each(|path| keep_input(&args.points, path))?;
    let source = formats.input(&args.points)?;
    let stop = Stop::on_signal()?;
    let stage = Stage::begin("read");
    let file = source.points()?;
    drop(stage);
    let job = Job {
        command: "delaunay",
        name: &source.name,
        outputs: &outputs,
        formats,
        json: args.json.as_deref(),
        check: args.check,
        stop: &stop,
        start,
        read_seconds: start.elapsed().as_secs_f64(),
        workers,
        stdout_taken: on_stdout(&written),
        page: args.page.as_deref(),
        parallel: ParallelJob {
            balance: args.balance,
            tables: args.tables,
            trace: args.trace.as_deref(),
        },
        binding: Binding { inputs: source.reads().list(), options: Chosen::default() },
    };
    mesh_points(file, &job)
}

/// Meshes points: builds, hashes, checks, writes and reports.
pub(crate) fn mesh_points(file: PointFile, job: &Job<'_>) -> Result<Exit, Failure> {
    let name = show(job.name);
    file.notes.iter().for_each(|n| console::people(&format!("note: {name}: {n}")));
    let point_tags = file.point_tags;
    let count = file.points.len();
    let set = PointSet::new(file.points)
        .map_err(|error| Failure::Points { path: job.name.to_owned(), error })?;
    let built = match build(&set, job) {
        Ok(built) => built,
        Err(RunError::Build(BuildError::Cancelled)) => {
            let input = Input { points: count, ..Input::default() };
            let mut report = empty_report(job, input, "cancelled");
            finish(&mut report, job)?;
            console::people("ltbw: stopped before the first tetrahedron; no mesh was written");
            return Ok(Exit::Stopped);
        }
        Err(RunError::Build(error)) => {
            return Err(Failure::Build { path: job.name.to_owned(), error });
        }
        Err(error @ RunError::Threads { .. }) => return Err(Failure::Machine(error.to_string())),
        Err(error) => return Err(Failure::Other(error.to_string())),
    };
    let mut report = report_of(&built, count, job);
    let Built { mesh, outcome, workers, parts, summary, trace, .. } = built;
    report.workers = workers;
    report.parallel = summary.as_ref().map(Figures::of);
    if outcome == Outcome::Complete {
        job.stop.inserted();
    }
    print_mesh(&name, &report);
    print_thickness(set.points());
    if let Some(summary) = summary.filter(|_| job.parallel.tables) {
        let clock = Some((report.seconds.insert * 1e9) as u64);
        let run = Run { doing: Doing::Insertion, alone: None, whole: None, clock };
        console::people(tables(&summary, &run).trim_end());
    }
    let timeline = match (job.page, &trace, &report.parallel) {
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
    let hash = mesh.hash().map_err(|e| Failure::Other(e.to_string()))?.to_string();
    drop(stage);
    report.seconds.hash = clock.elapsed().as_secs_f64();
    report.mesh.hash = Some(hash.clone());
    // The input's own coordinates, under the input's numbers.
    let clock = Instant::now();
    let mut verdict = "not checked".to_owned();
    let to_check = outcome == Outcome::Complete && job.check != Depth::Off;
    let stage = to_check.then(|| Stage::begin("check"));
    let (tets, neighbours) =
        if to_check { lists(&mesh) } else { (mesh.tets().collect(), Vec::new()) };
    let hull: Vec<[u32; 3]> = mesh.hull_facets().collect();
    drop(mesh);

    if to_check {
        let own = verify::Mesh::new(set.points(), &tets).with_hull(&hull);
        let checked = check_own(&own.with_neighbours(&neighbours), &hash, job.check);
        drop(stage);
        report.seconds.check = clock.elapsed().as_secs_f64();
        if let Some(checked) = checked {
            report.certificate = checked.certificate.map(|mut own| {
                job.binding.bind(&mut own, &hash);
                own
            });
            if !checked.passed {
                // A defect of ours is graver than a report that could not be written.
                if let Err(failure) = finish(&mut report, job) {
                    console::people(&format!("note: {failure}"));
                }
                console::people("ltbw: defect in our own output; no mesh was written");
                return Ok(Exit::OwnDefect);
            }
            console::people(&format!("checked   {}", checked.summary));
            verdict = checked.summary;
        }
    }
    report.outcome = match outcome {
        Outcome::Complete => "complete",
        Outcome::Cancelled => "cancelled",
        Outcome::Budget | Outcome::TooManyTets => "budget",
    };
    let points = set.points().to_vec();
    let mesh = TetMesh { points, tets, point_tags, ..TetMesh::default() };
    write_outputs(&mesh, &parts, &mut report, job)?;
    if let Some(path) = job.page {
        let _stage = Stage::begin("page");
        let workers = owners(&mesh, &parts);
        let scene = Scene { mesh: &mesh, hull: &hull, workers: &workers };
        let mut page = Page::new(&name).view(&scene);
        if let Some(quality) = Quality::of(&mesh.points, &mesh.tets) {
            page = page.mesh(&report, &verdict, &quality);
        }
        if let Some(timeline) = timeline {
            page = page.section("Time of the workers", &timeline);
        }
        write_text(path, &page.html(&report.to_json().unwrap_or_default()))?;
    }
    finish(&mut report, job)?;
    if outcome == Outcome::Complete {
        return Ok(Exit::Done);
    }
    console::people(&format!(
        "ltbw: {}: {} of {count} points meshed; the mesh is valid but was not checked",
        report.outcome, report.mesh.vertices
    ));
    Ok(Exit::Stopped)
}

/// Tells that points are nearly in one plane: their tetrahedra are as flat.
fn print_thickness(points: &[Point]) {
    if let Some(thickness) = Thickness::of_flat(points) {
        console::people(&format!("note: {thickness}"));
    }
}

/// Builds the mesh, on as many threads as the job has workers.
fn build(set: &PointSet, job: &Job<'_>) -> Result<Built, RunError> {
    let progress = Progress::begin("order", job.stop.begun());
    let mut builder = Builder::new().threads(job.workers);
    builder = builder.observer(&progress).cancel(job.stop.token());
    if job.parallel.balance {
        builder = builder.balance(Balance::default());
    }
    // Taking the time takes some.
    let is_traced = job.page.is_some() || job.parallel.trace.is_some();
    if job.json.is_some() || job.parallel.tables || is_traced {
        builder = builder.measure(if is_traced { SPANS } else { 0 });
    }
    let in_parts = job.outputs.iter().any(io::is_parts);
    if in_parts || (job.page.is_some() && job.workers > 1) {
        builder = builder.parts();
    }
    builder.build(set)
}

/// The report of a build, without what comes after it.
fn report_of(built: &Built, points: usize, job: &Job<'_>) -> Report {
    let Built { mesh, stats, duplicates, .. } = built;
    let input = Input {
        points,
        distinct: mesh.num_vertices(),
        duplicates: duplicates.len(),
        duplicate_of: duplicates.clone(),
    };
    let mut report = empty_report(job, input, "complete");
    report.seconds.order = stats.order_seconds;
    report.seconds.insert = stats.insert_seconds;
    let p = &stats.predicates;
    report.predicates = Predicates {
        orient3d: Orient3d { calls: p.orient3d_calls, exact: p.orient3d_exact },
        insphere: Insphere {
            calls: p.insphere_calls,
            exact: p.insphere_exact,
            perturbed: p.insphere_perturbed,
        },
    };
    report.mesh = MeshPart {
        vertices: mesh.num_vertices(),
        tets: mesh.num_tets(),
        hull_faces: mesh.num_hull_faces(),
        hash: None,
    };
    report
}

fn print_mesh(name: &str, report: &Report) {
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

fn write_outputs(
    mesh: &TetMesh,
    parts: &[Vec<[u32; 4]>],
    report: &mut Report,
    job: &Job<'_>,
) -> Result<(), Failure> {
    let clock = Instant::now();
    let _stage = (!job.outputs.is_empty()).then(|| Stage::begin("write"));
    for path in job.outputs {
        let files = if io::is_parts(path) {
            let part = |tets: &Vec<[u32; 4]>| part_of(mesh, tets.clone(), Vec::new());
            let parts: Vec<TetMesh> = parts.iter().map(part).collect();
            console::writing(|token| io::write_parts_until(path, &parts, token))?;
            io::part_files(path, parts.len())
        } else {
            let writer = MeshWriter::new(mesh);
            let writer = report.mesh.hash.as_deref().map_or(writer, |hash| writer.hash(hash));
            job.formats.write_mesh(path, writer)?;
            vec![name_of(path)]
        };
        for path in files {
            report.outputs.push(path.to_string_lossy().into_owned());
            console::people(&format!("wrote     {}", show(&path)));
        }
    }
    report.seconds.write = clock.elapsed().as_secs_f64();
    Ok(())
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

fn empty_report(job: &Job<'_>, input: Input, outcome: &'static str) -> Report {
    Report {
        schema: Report::SCHEMA,
        command: job.command,
        input,
        mesh: MeshPart::default(),
        predicates: Predicates::default(),
        seconds: Seconds { read: job.read_seconds, ..Seconds::default() },
        threads: rayon::current_num_threads(),
        peak_rss_bytes: None,
        outcome,
        refinement: None,
        quality: None,
        certificate: None,
        outputs: Vec::new(),
        workers: Vec::new(),
        parallel: None,
    }
}

/// Tells how long it took, writes the report and prints the hash.
fn finish(report: &mut Report, job: &Job<'_>) -> Result<(), Failure> {
    report.peak_rss_bytes = crate::report::peak_rss_bytes();
    report.seconds.total = job.start.elapsed().as_secs_f64();
    let s = &report.seconds;
    let stages = [
        ("read", s.read),
        ("order", s.order),
        ("insert", s.insert),
        ("hash", s.hash),
        ("check", s.check),
        ("write", s.write),
    ];
    let hash = report.mesh.hash.as_ref().filter(|_| !job.stdout_taken);
    end((s.total, &stages), job.json.map(|path| (path, report.to_json())), hash)
}
