//! `mesh`: read a domain, prepare it, refine, hash, check, write, report.

use crate::args::{Depth, MeshArgs};
use crate::binding::Binding;
use crate::bounds::{Asked, Field, asked, binding, field};
use crate::conform::{certificate, check_own, print, same_volume, summary};
use crate::console::{self, Stop};
use crate::excused;
use crate::explained::{excused, is_explained};
use crate::json::{distinct, file_writable, keep_input, without_pairs, write_text};
use crate::outcome::{Exit, Failure, show};
use crate::page::{Page, Scene};
use crate::pieces::parts_of;
use crate::progress::{Progress, Stage};
use crate::report::{
    Input, Insphere, MeshPart, Orient3d, Predicates, Report, Seconds, end, quality_json,
    quality_line,
};
use crate::rounds;
use crate::streams::{Formats, attributes_note, name_of, on_stdout};
use crate::surface::{print_patches, repairs_json};
use crate::unrecovered;
use crate::workers::{Made, print_workers, refine};
use ltbw::domain::Prepared;
use ltbw::domain::exterior::LEFT_OUT;
use ltbw::io::{self, MeshWriter};
use ltbw::quality::{self, Quality};
use ltbw::refine::{RefineOutcome, Refined, Verdict};
use ltbw::{TetMesh, canonical_hash};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Excuses that the report lists.
const LISTED: usize = 100;

/// The task with a domain.
pub(crate) struct Job<'a> {
    /// `mesh` or `demo`.
    pub(crate) command: &'static str,
    /// The name of the domain in messages.
    pub(crate) name: &'a Path,
    /// Bounds.
    pub(crate) asked: Asked,
    /// Wanted edge lengths.
    pub(crate) field: Option<Field>,
    /// Input and options, to which the certificate is bound.
    pub(crate) binding: Binding,
    /// The workers that refine it without a common mesh.
    pub(crate) workers: Option<u32>,
    /// The most points to insert.
    pub(crate) max_points: Option<u64>,
    /// The distance within which facets are taken for coplanar.
    pub(crate) flat_tolerance: f64,
    /// Mesh files to write, in parts and whole, and the formats that names do not tell.
    pub(crate) in_parts: &'a [PathBuf],
    pub(crate) outputs: &'a [PathBuf],
    pub(crate) formats: Formats,
    /// An output goes to stdout, and so nothing else does.
    pub(crate) stdout_taken: bool,
    /// With the exterior.
    pub(crate) keep_exterior: bool,
    /// Write the Delaunay mesh, exterior included, even if the boundary is not in it.
    pub(crate) write_unrecovered: bool,
    /// The files of the report, the histograms, and the page.
    pub(crate) json: Option<&'a Path>,
    pub(crate) histogram: Option<&'a Path>,
    pub(crate) page: Option<&'a Path>,
    /// The file of the rounds' timeline.
    pub(crate) trace: Option<&'a Path>,
    /// Whether to check.
    pub(crate) check: Depth,
    /// The share of tetrahedra, and of volume, that may be excused.
    pub(crate) excused_share: f64,
    /// Cancels the refinement.
    pub(crate) stop: &'a Stop,
    /// When the program started.
    pub(crate) start: Instant,
}

/// `ltbw mesh`.
pub(crate) fn mesh(args: &MeshArgs) -> Result<Exit, Failure> {
    let start = Instant::now();
    let asked = asked(args)?;
    args.preparation.check(&[&args.domain])?;
    let workers = args.workers.map(u32::from);
    let (in_parts, whole): (Vec<PathBuf>, Vec<PathBuf>) =
        without_pairs(&args.output).into_iter().partition(|path| io::is_parts(path));
    let formats = args.streams.resolve(&[&args.domain], &whole)?;
    formats.meshes_writable(&whole)?;
    let parts = workers.unwrap_or(1) as usize;
    if args.write_unrecovered && !in_parts.is_empty() {
        let text = "--write-unrecovered writes the mesh as a whole: no .pvtu";
        return Err(Failure::Usage(text.to_owned()));
    }
    for path in &in_parts {
        io::check_parts_writable(path, parts).map_err(Failure::Write)?;
    }
    args.json.as_deref().map_or(Ok(()), file_writable)?;
    let pages = [&args.histogram, &args.page, &args.trace].into_iter().flatten();
    pages.clone().try_for_each(|path| file_writable(path))?;
    let written = whole.iter().flat_map(io::mesh_files);
    let written = written.chain(in_parts.iter().flat_map(|path| io::part_files(path, parts)));
    let written = written.chain(args.json.clone()).chain(pages.cloned());
    let written: Vec<PathBuf> = written.chain(args.preparation.write_defects.clone()).collect();
    distinct(&written)?;
    // A `.poly` may have its points in a `.node`.
    let mut inputs = io::domain_files(&args.domain);
    inputs.extend(args.sizes.clone());
    inputs.extend(args.background.iter().flat_map(io::mesh_files));
    for input in inputs {
        written.iter().try_for_each(|path| keep_input(&input, path))?;
    }
    let source = formats.input(&args.domain)?;
    let stop = Stop::on_signal()?;
    let stage = Stage::begin("prepare");
    let (ready, flat_tolerance) = args.preparation.prepare(&source)?;
    drop(stage);
    let field = field(args, &ready, source.reads())?;
    let job = Job {
        command: "mesh",
        name: &source.name,
        asked,
        field,
        binding: binding(args, asked, flat_tolerance, source.reads()),
        workers,
        max_points: args.max_points,
        flat_tolerance,
        in_parts: &in_parts,
        outputs: &whole,
        formats,
        stdout_taken: on_stdout(&written),
        keep_exterior: args.keep_exterior,
        write_unrecovered: args.write_unrecovered,
        json: args.json.as_deref(),
        histogram: args.histogram.as_deref(),
        page: args.page.as_deref(),
        trace: args.trace.as_deref(),
        check: args.check,
        excused_share: args.lenience.share(args.preparation.strict),
        stop: &stop,
        start,
    };
    mesh_domain(&ready, &job)
}

/// Refines a prepared domain, checks the mesh, writes and reports.
pub(crate) fn mesh_domain(ready: &Prepared, job: &Job<'_>) -> Result<Exit, Failure> {
    let mut seconds = Seconds { read: job.start.elapsed().as_secs_f64(), ..Seconds::default() };
    print_domain(job, ready);
    let clock = Instant::now();
    let (refined, made) = refined(job, ready)?;
    seconds.refine = clock.elapsed().as_secs_f64();
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
    let mut report = report_of(job, &refined, ready, hash, seconds);
    let quality = Quality::of(&inside.points, &inside.tets);
    drop(stage);
    print_mesh(&refined, &inside, quality.as_ref());
    print_workers(&made);
    report.workers.clone_from(&made.workers);
    print_patches(job.flat_tolerance, &refined.stats);
    report.quality = quality.as_ref().map(quality_json);
    if refined.outcome != RefineOutcome::Cancelled {
        job.stop.inserted();
    }

    if unrecovered {
        return finish_unrecovered(job, &refined, &inside, report);
    }
    let mut verdict = "not checked".to_owned();
    if job.check != Depth::Off && refined.outcome != RefineOutcome::Cancelled {
        let clock = Instant::now();
        let stage = Stage::begin("check");
        let excused = excused(&refined);
        let mut found = check_own(&inside, ready, job.asked, &refined, excused.len());
        drop(stage);
        let same = same_volume(ready, &found);
        let explained = is_explained(&found, &inside, &excused) && same;
        let share = refined.excused_share();
        let word = Verdict::of(found.passed() && same, explained, &share, job.excused_share);
        let mut own = certificate(&found, same, word);
        job.binding.bind(&mut own, report.mesh.hash.as_deref().unwrap_or_default());
        report.certificate = Some(own);
        report.seconds.check = clock.elapsed().as_secs_f64();
        if !explained {
            print(&mut found);
            if let Err(failure) = finish(&mut report, job) {
                console::people(&format!("note: {failure}"));
            }
            console::people("ltbw: defect in our own output; no mesh was written");
            return Ok(Exit::OwnDefect);
        }
        verdict = match found.passed() {
            true => summary(&found),
            false => "sound; over its bounds only where it was excused".to_owned(),
        };
        console::people(&format!("checked   {verdict}"));
    }
    write(job, &refined, (&inside, &made), &mut report)?;
    rounds::write_trace(job.trace, &refined.rounds)?;
    if let (Some(path), Some(quality)) = (job.page, &quality) {
        let _stage = Stage::begin("page");
        let workers = job.workers.map(|_| made.owners.of(&refined, false)).unwrap_or_default();
        let scene = Scene { mesh: &inside, hull: &[], workers: &workers };
        let page = Page::new(&show(job.name)).view(&scene).mesh(&report, &verdict, quality);
        write_text(path, &page.html(&report.to_json().unwrap_or_default()))?;
    }
    if let (Some(path), Some(quality)) = (job.histogram, &quality) {
        write_text(path, &crate::picture::histograms::svg(quality))?;
    }
    finish(&mut report, job)?;
    Ok(ending(job, &refined, ready))
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
        let (outputs, check) = ((job.outputs, job.formats), job.check != Depth::Off);
        let Some(written) = unrecovered::write(outputs, mesh, check)? else {
            return Ok(Exit::OwnDefect);
        };
        report.outputs = written;
    }
    finish(&mut report, job)?;
    unrecovered::end(refined, !report.outputs.is_empty());
    Ok(Exit::Defect)
}

fn refined(job: &Job<'_>, ready: &Prepared) -> Result<(Refined, Made), Failure> {
    let progress = Progress::begin("recover");
    let mut refiner = job.asked.refiner().observer(&progress).cancel(job.stop.token());
    refiner = refiner.flat_tolerance(job.flat_tolerance);
    if let Some(field) = &job.field {
        refiner = refiner.sizing(field);
    }
    if let Some(count) = job.max_points {
        refiner = refiner.max_points(count);
    }
    refine((&refiner, ready), job.workers, (job.stop, job.name))
}

/// Tells in a last line what is over a bound, if anything is.
fn ending(job: &Job<'_>, refined: &Refined, ready: &Prepared) -> Exit {
    let is_little = refined.excused_share().is_within(job.excused_share);
    let (exit, word) = match refined.outcome {
        RefineOutcome::Met => return Exit::Done,
        RefineOutcome::Excused if is_little => (Exit::Done, "excused, and little enough"),
        RefineOutcome::Excused | RefineOutcome::Unrecovered => (Exit::Defect, "excused"),
        RefineOutcome::Budget => (Exit::Stopped, "budget used up"),
        RefineOutcome::Cancelled => {
            console::people("ltbw: cancelled: the mesh is Delaunay, but need not meet the bounds");
            return Exit::Stopped;
        }
    };
    let text = excused::text((refined, ready), job.asked.radius_edge, job.excused_share);
    console::people(&format!("ltbw: {word}: {text}"));
    exit
}

fn print_domain(job: &Job<'_>, ready: &Prepared) {
    let (domain, lattice) = (&ready.domain, &ready.lattice);
    console::people(&format!(
        "domain    {}: {} vertices, {} facets, {} holes, {} regions",
        show(job.name),
        domain.vertices.len(),
        domain.facets.len(),
        domain.holes.len(),
        domain.regions.len()
    ));
    if let Some(m) = &ready.largest {
        console::people(&format!(
            "note: {} vertices moved to the lattice of step 2^{}, \
             the farthest (vertex {}) by {:.3e}, {:.1e} of the diagonal",
            ready.moved,
            lattice.exponent(),
            m.vertex,
            m.distance,
            m.distance / domain.diagonal()
        ));
    }
    // Whatever has a corner at the origin loses one.
    if lattice.lost_bits() > 1 {
        console::people(&format!(
            "note: {} bits are lost to the distance from the origin (--local-frame keeps them)",
            lattice.lost_bits()
        ));
    }
    if lattice.offset() != [0.0; 3] {
        console::people(&format!("note: coordinates are relative to {:?}", lattice.offset()));
    }
}

fn print_mesh(refined: &Refined, inside: &TetMesh, quality: Option<&Quality>) {
    let stats = &refined.stats;
    console::people(&format!(
        "mesh      {} vertices, {} tetrahedra inside, {} regions",
        refined.mesh().num_vertices(),
        inside.tets.len(),
        refined.regions.len().saturating_sub(1)
    ));
    console::people(&format!(
        "points    {} on segments, {} on facets, {} inside",
        stats.segment_points, stats.facet_points, stats.free_points
    ));
    rounds::line(stats).iter().for_each(|line| console::people(line));
    quality.into_iter().for_each(|quality| console::people(&quality_line(quality)));
}

fn report_of(
    job: &Job<'_>,
    refined: &Refined,
    ready: &Prepared,
    hash: String,
    seconds: Seconds,
) -> Report {
    let points = ready.vertex_map.len();
    let distinct = ready.domain.vertices.len();
    let left_out = ready.vertex_map.iter().filter(|&&v| v == LEFT_OUT).count();
    let p = refined.mesh().predicate_stats();
    Report {
        schema: Report::SCHEMA,
        command: job.command,
        input: Input {
            points,
            distinct,
            duplicates: points - distinct - left_out,
            duplicate_of: Vec::new(),
        },
        mesh: MeshPart {
            vertices: refined.mesh().num_vertices(),
            tets: refined.num_tets(),
            hull_faces: refined.mesh().num_hull_faces(),
            hash: Some(hash),
        },
        predicates: Predicates {
            orient3d: Orient3d { calls: p.orient3d_calls, exact: p.orient3d_exact },
            insphere: Insphere {
                calls: p.insphere_calls,
                exact: p.insphere_exact,
                perturbed: p.insphere_perturbed,
            },
        },
        seconds,
        threads: rayon::current_num_threads(),
        peak_rss_bytes: None,
        outcome: match refined.outcome {
            RefineOutcome::Met => "met",
            RefineOutcome::Excused => "excused",
            RefineOutcome::Unrecovered => "unrecovered",
            RefineOutcome::Budget => "budget",
            RefineOutcome::Cancelled => "cancelled",
        },
        refinement: Some(refinement_json(refined, ready)),
        quality: None,
        certificate: None,
        outputs: Vec::new(),
        workers: Vec::new(),
        parallel: None,
    }
}

fn refinement_json(refined: &Refined, ready: &Prepared) -> Value {
    let stats = &refined.stats;
    let excuse = |e: &ltbw::refine::Excuse| {
        json!({
            "vertices": refined.tet(e.tet),
            "reason": e.reason.to_string(),
            "reason_at": e.reason.at(),
        })
    };
    let region = |r: &ltbw::refine::RegionInfo| {
        json!({
            "seed": r.seed,
            "attribute": r.attribute,
            "max_volume": r.max_volume,
        })
    };
    json!({
        "segment_points": stats.segment_points,
        "facet_points": stats.facet_points,
        "free_points": stats.free_points,
        "rounds": rounds::json(stats),
        "excused": refined.excuses.len(),
        "excused_at": excused::json(refined),
        "excuses": refined.excuses.iter().take(LISTED).map(excuse).collect::<Vec<_>>(),
        "boundary_lost": refined.lost.len(),
        "regions": refined.regions.iter().skip(1).map(region).collect::<Vec<_>>(),
        "lattice": {
            "step": ready.lattice.step(),
            "fine_step": ready.lattice.fine_step(),
            "offset": ready.lattice.offset(),
            "lost_bits": ready.lattice.lost_bits(),
            "moved": ready.moved,
            "largest_move": ready.largest.map(|m| m.distance),
            "largest_move_of_diagonal": ready.largest.map(|m| m.distance / ready.domain.diagonal()),
        },
        "repairs": repairs_json(ready),
        "flat_tolerance": stats.flat_tolerance,
        "patches_folded": stats.patches_folded,
        "patches_given_up": stats.patches_given_up,
        "patches": stats.patches,
        "recover_seconds": stats.recover_seconds,
        "refine_seconds": stats.refine_seconds,
    })
}

fn write(
    job: &Job<'_>,
    refined: &Refined,
    (inside, made): (&TetMesh, &Made),
    report: &mut Report,
) -> Result<(), Failure> {
    let clock = Instant::now();
    let is_written = !(job.outputs.is_empty() && job.in_parts.is_empty());
    let _stage = is_written.then(|| Stage::begin("write"));
    let whole = job.keep_exterior.then(|| refined.with_exterior());
    let mesh = whole.as_ref().unwrap_or(inside);
    let mut tell = |path: &Path| {
        report.outputs.push(path.to_string_lossy().into_owned());
        console::people(&format!("wrote     {}", show(path)));
    };
    if !job.outputs.is_empty() {
        let values = quality::arrays(&mesh.points, &mesh.tets);
        let writer = MeshWriter::new(mesh).values(&values);
        let writer = report.mesh.hash.as_deref().map_or(writer, |hash| writer.hash(hash));
        for path in job.outputs {
            job.formats.write_mesh(path, writer)?;
            let note = attributes_note(mesh, job.formats.of_output(path)?);
            let path = &name_of(path);
            note.iter().for_each(|n| console::people(&format!("note: {}: {n}", show(path))));
            tell(path);
        }
    }
    if !job.in_parts.is_empty() {
        let owners = made.owners.of(refined, job.keep_exterior);
        let parts = parts_of(mesh, &owners, job.workers.unwrap_or(1) as usize);
        for path in job.in_parts {
            io::write_parts(path, &parts).map_err(Failure::Write)?;
            io::part_files(path, parts.len()).iter().for_each(|path| tell(path));
        }
    }
    report.seconds.write = clock.elapsed().as_secs_f64();
    Ok(())
}

/// Tells how long it took, writes the report and prints the hash.
fn finish(report: &mut Report, job: &Job<'_>) -> Result<(), Failure> {
    report.peak_rss_bytes = crate::report::peak_rss_bytes();
    report.seconds.total = job.start.elapsed().as_secs_f64();
    let s = &report.seconds;
    let stages = [
        ("read", s.read),
        ("refine", s.refine),
        ("hash", s.hash),
        ("check", s.check),
        ("write", s.write),
    ];
    let hash = report.mesh.hash.as_ref().filter(|_| !job.stdout_taken);
    end((s.total, &stages), job.json.map(|path| (path, report.to_json())), hash)
}
