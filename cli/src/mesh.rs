//! `mesh`: read a domain, prepare it, refine, hash, check, write, report.

use crate::args::{Depth, MeshArgs, Refine};
use crate::bounds::{Asked, asked, binding};
use crate::conform::{certificate, check_own, print, same_volume, summary, tells_all_slivers};
use crate::console::{self, Stop};
use crate::excused;
use crate::explained::{excused, is_explained, reasons};
use crate::json::write_text;
use crate::needles;
use crate::others::Others;
use crate::outcome::{Exit, Failure, show};
use crate::page::Scene;
use crate::parts::{Boundary, Told};
use crate::pieces::parts_of;
use crate::progress::{self, Progress, Stage};
use crate::report::{Input, MeshPart, Predicates, Report, Seconds, quality_json, quality_line};
use crate::rounds;
use crate::sizes::{Field, field};
use crate::streams::Source;
use crate::surface::{given_json, print_patches, repairs_json, simplified_json};
use crate::task::{Beside, Files, Judged, Task};
use crate::unrecovered;
use crate::workers::{Crew, Made, Setting, print_workers, refine};
use ltbw::domain::Prepared;
use ltbw::domain::exterior::LEFT_OUT;
use ltbw::io;
use ltbw::quality::{self, Quality};
use ltbw::refine::{RefineOutcome, Refined, Verdict};
use ltbw::{TetMesh, canonical_hash};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// Excuses that the report lists.
const LISTED: usize = 100;

/// The task with a domain.
pub(crate) struct Job<'a> {
    pub(crate) task: Task<'a>,
    /// Bounds.
    pub(crate) asked: Asked,
    /// Wanted edge lengths.
    pub(crate) field: Option<Field>,
    /// The workers that refine it without a common mesh.
    pub(crate) crew: Option<Crew>,
    /// The most points to insert.
    pub(crate) max_points: Option<u64>,
    /// The distance within which facets are taken for coplanar.
    pub(crate) flat_tolerance: f64,
    /// The parts of the boundary.
    pub(crate) boundary: Boundary,
    /// With the exterior.
    pub(crate) keep_exterior: bool,
    /// Write the Delaunay mesh, exterior included, even if the boundary is not in it.
    pub(crate) write_unrecovered: bool,
    /// The files of the histograms and of the rounds' timeline.
    pub(crate) histogram: Option<&'a Path>,
    pub(crate) trace: Option<&'a Path>,
    /// The share of tetrahedra, and of volume, that may be excused.
    pub(crate) excused_share: f64,
}

/// A domain that can be meshed, and what is asked for.
pub(crate) struct Start {
    pub(crate) ready: Prepared,
    pub(crate) flat_tolerance: f64,
    pub(crate) field: Option<Field>,
    pub(crate) boundary: Boundary,
}

impl Start {
    fn of(args: &MeshArgs, source: &Source) -> Result<Self, Failure> {
        let mut file = args.preparation.read(source)?;
        let told = Told::of(&mut file);
        let (ready, flat_tolerance) = args.preparation.prepare_file(file, source)?;
        let boundary = args.parting.boundary(&ready, flat_tolerance, told, source);
        let field = field(&args.sizing, &ready, &boundary, source.reads(), None)?;
        Ok(Self { ready, flat_tolerance, field, boundary })
    }
}

/// `ltbw mesh`, or `ltbw refine` of a mesh.
pub(crate) fn mesh_from(
    args: &MeshArgs,
    others: Others<'_>,
    going_on: Option<&Refine>,
) -> Result<Exit, Failure> {
    let start = Instant::now();
    let asked = asked(args)?;
    args.preparation.check(&[&args.domain])?;
    let workers = args.workers.map(u32::from).or(others.map(|others| others.size()));
    let crew = workers.map(|workers| Crew { workers, mode: args.mode });
    // A `.poly` may have its points in a `.node`.
    let mut inputs =
        going_on.map_or_else(|| io::domain_files(&args.domain), |refine| refine.inputs());
    inputs.extend(args.sizing.sizes.iter().map(|sizes| sizes.file.clone()));
    inputs.extend(args.preparation.points.clone());
    inputs.extend(args.sizing.background.iter().flat_map(io::mesh_files));
    let beside =
        [&args.json, &args.histogram, &args.page, &args.trace, &args.preparation.write_defects];
    let files = Files {
        input: &args.domain,
        inputs,
        outputs: &args.output,
        streams: &args.streams,
        others: beside.into_iter().flatten().cloned().collect(),
        parts: parts_by(crew),
    };
    let outputs = files.look()?;
    if args.write_unrecovered && !outputs.in_parts.is_empty() {
        let text = "--write-unrecovered writes the mesh as a whole, not in parts";
        return Err(Failure::Usage(text.to_owned()));
    }
    let source = outputs.formats.input(&args.domain)?;
    let stop = Stop::on_signal()?;
    progress::plan(&["prepare", "recover", "refine", "hash", "check", "write"]);
    let stage = Stage::begin("prepare");
    let start_with = |refine: &Refine| refine.start(&source);
    let Start { ready, flat_tolerance, field, boundary } =
        going_on.map_or_else(|| Start::of(args, &source), start_with)?;
    drop(stage);
    if going_on.is_none() && args.preparation.simplify.is_none() && console::is_heard() {
        needles::advice(&ready, flat_tolerance).iter().for_each(|line| console::people(line));
    }
    let job = Job {
        task: Task {
            command: if going_on.is_some() { "refine" } else { "mesh" },
            name: &source.name,
            outputs: &outputs,
            json: args.json.as_deref(),
            page: args.page.as_deref(),
            check: args.check,
            binding: binding(args, asked, flat_tolerance, source.reads()),
            stop: &stop,
            start,
            others,
        },
        asked,
        field,
        crew,
        max_points: args.max_points,
        flat_tolerance,
        boundary,
        keep_exterior: args.keep_exterior,
        write_unrecovered: args.write_unrecovered,
        histogram: args.histogram.as_deref(),
        trace: args.trace.as_deref(),
        excused_share: args.lenience.share(args.preparation.strict),
    };
    if let Some(others) = others {
        others.agree(crate::binding::fingerprint(&job.task.binding.inputs))?;
    }
    mesh_domain(&ready, &job)
}

/// Refines a prepared domain, checks the mesh, writes and reports.
pub(crate) fn mesh_domain(ready: &Prepared, job: &Job<'_>) -> Result<Exit, Failure> {
    let task = &job.task;
    let mut seconds = Seconds { read: task.start.elapsed().as_secs_f64(), ..Seconds::default() };
    print_domain(task.name, ready);
    let clock = Instant::now();
    let Some((refined, made)) = refined(job, ready)? else {
        // The first process has the mesh.
        return Ok(Exit::Done);
    };
    seconds.refine = clock.elapsed().as_secs_f64();
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
    let mut report = report_of(job, &refined, ready);
    report.mesh.hash = Some(hash);
    report.seconds = seconds;
    let mut judged = Judged::unseen(Quality::of(&inside.points, &inside.tets));
    drop(stage);
    print_mesh(&refined, &inside, judged.quality.as_ref());
    print_workers(&made);
    report.workers.clone_from(&made.workers);
    print_patches(job.flat_tolerance, &refined.stats);
    report.quality = judged.quality.as_ref().map(quality_json);
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
        parts_of(mesh, &owners, parts_by(job.crew))
    };
    let values = || quality::arrays(&mesh.points, &mesh.tets);
    task.write(mesh, Beside { values, names: &job.boundary.names }, parts, &mut report)?;
    rounds::write_trace(job.trace, &refined.rounds)?;
    if task.page.is_some() {
        let workers = job.crew.map(|_| made.owners.of(&refined, false)).unwrap_or_default();
        let excused = reasons(&refined);
        let (names, workers) = (&job.boundary.names, &workers);
        let scene = Scene { mesh: &inside, hull: &[], workers, names, excused: &excused };
        task.write_page(&scene, &report, &judged, None)?;
    }
    if let (Some(path), Some(quality)) = (job.histogram, &judged.quality) {
        write_text(path, &crate::picture::histograms::svg(quality))?;
    }
    task.finish(&mut report)?;
    Ok(ending(job, &refined, ready))
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
    let all_told = tells_all_slivers(refined, &found);
    if !all_told {
        console::people("defect    other tetrahedra have small dihedral angles than those told");
    }
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

/// The number of parts that a mesh of a crew has.
fn parts_by(crew: Option<Crew>) -> usize {
    crew.map_or(1, |crew| crew.workers as usize)
}

fn refined(job: &Job<'_>, ready: &Prepared) -> Result<Option<(Refined, Made)>, Failure> {
    let progress = Progress::begin("recover", job.task.stop.begun());
    let mut refiner = job.asked.refiner().observer(&progress).cancel(job.task.stop.token());
    refiner = refiner.flat_tolerance(job.flat_tolerance);
    if let Some(field) = &job.field {
        refiner = refiner.sizing(field);
    }
    if let Some(count) = job.max_points {
        refiner = refiner.max_points(count);
    }
    let Task { name, stop, others, .. } = job.task;
    refine(&refiner, ready, job.crew, Setting { name, stop, others })
}

/// Tells in a last line what is over a bound, if anything is.
fn ending(job: &Job<'_>, refined: &Refined, ready: &Prepared) -> Exit {
    let share = refined.excused_share();
    let is_little = share.is_within(job.excused_share);
    if let Some(text) = excused::slivers_text(refined, ready) {
        let is_alone = share.flat > 0 && refined.outcome == RefineOutcome::Met;
        let word = if is_alone { "ltbw: flat" } else { "note" };
        console::people(&format!("{word}: {text}"));
    }
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

fn print_domain(name: &Path, ready: &Prepared) {
    let (domain, lattice) = (&ready.domain, &ready.lattice);
    console::people(&format!(
        "domain    {}: {} vertices, {} facets, {} holes, {} regions",
        show(name),
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
    if stats.moved > 0 {
        console::people(&format!("smoothed  {} moves of vertices inside", stats.moved));
    }
    rounds::line(stats).iter().for_each(|line| console::people(line));
    quality.into_iter().for_each(|quality| console::people(&quality_line(quality)));
}

fn report_of(job: &Job<'_>, refined: &Refined, ready: &Prepared) -> Report {
    let points = ready.vertex_map.len();
    let distinct = ready.domain.vertices.len();
    let left_out = ready.vertex_map.iter().filter(|&&v| v == LEFT_OUT).count();
    let duplicates = points - distinct - left_out;
    let outcome = match refined.outcome {
        RefineOutcome::Met => "met",
        RefineOutcome::Excused => "excused",
        RefineOutcome::Unrecovered => "unrecovered",
        RefineOutcome::Budget => "budget",
        RefineOutcome::Cancelled => "cancelled",
    };
    let input = Input { points, distinct, duplicates, duplicate_of: Vec::new() };
    let mut report = job.task.report(input, outcome);
    report.mesh = MeshPart {
        vertices: refined.mesh().num_vertices(),
        tets: refined.num_tets(),
        hull_faces: refined.mesh().num_hull_faces(),
        hash: None,
    };
    report.predicates = Predicates::from(&refined.mesh().predicate_stats());
    report.refinement = Some(refinement_json(job, refined, ready));
    report
}

fn refinement_json(job: &Job<'_>, refined: &Refined, ready: &Prepared) -> Value {
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
        "slivers": excused::slivers_json(refined),
        "moved": stats.moved,
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
        "simplified": simplified_json(ready),
        "given_points": given_json(ready),
        "parts": job.boundary.json(),
        "flat_tolerance": stats.flat_tolerance,
        "patches_folded": stats.patches_folded,
        "patches_given_up": stats.patches_given_up,
        "patches": stats.patches,
        "recover_seconds": stats.recover_seconds,
        "refine_seconds": stats.refine_seconds,
    })
}
