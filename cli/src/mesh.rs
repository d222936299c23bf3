//! `mesh`: read a domain, prepare it, refine, hash, check, write, report.

#[cfg(feature = "wire")]
use crate::apart_domain;
use crate::args::{MeshArgs, Refine};
use crate::bounds::{asked, binding};
use crate::console::{self, Stop};
use crate::domain_job::{Job, parts_by};
use crate::domain_whole::{Meshed, finish};
use crate::needles;
use crate::others::Others;
use crate::outcome::{Exit, Failure, show};
use crate::parts::{Boundary, Told};
use crate::progress::{self, Progress, Stage};
use crate::report::Seconds;
use crate::sizes::{Field, field};
use crate::streams::Source;
use crate::task::{Files, Task};
use crate::workers::{Crew, Mode, Setting, refine};
use ltbw::domain::Prepared;
use ltbw::io;
use ltbw::mesh::Redeal;
use std::path::{Path, PathBuf};
use std::time::Instant;

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
    if workers.is_none() && args.mode == Mode::Async {
        return Err(Failure::Usage("--mode async is for --workers N".to_owned()));
    }
    let (mode, redeal) = (args.mode, args.redeal);
    if redeal != Redeal::Never && (workers.is_none() || mode == Mode::Async) {
        return Err(Failure::Usage("--redeal is for rounds by workers".to_owned()));
    }
    let crew = workers.map(|workers| Crew { workers, mode, redeal });
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
    let holds_none = |path: &&PathBuf| args.keep_exterior && !io::parts_hold_exterior(path);
    if let Some(path) = outputs.in_parts.iter().find(holds_none) {
        let (path, others) = (show(path), ".pvtu and .vtkhdf have one");
        let text = format!("--keep-exterior: {path} has no number for region 0; {others}");
        return Err(Failure::Usage(text));
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
        #[cfg(feature = "wire")]
        return apart_domain::mesh(others.apart(), &ready, &job, begin(&ready, &job));
    }
    mesh_domain(&ready, &job)
}

/// Refines a prepared domain, checks the mesh, writes and reports.
pub(crate) fn mesh_domain(ready: &Prepared, job: &Job<'_>) -> Result<Exit, Failure> {
    let task = &job.task;
    let mut seconds = begin(ready, job);
    let clock = Instant::now();
    let progress = Progress::begin("recover", task.stop.begun());
    let setting = Setting { name: task.name, stop: task.stop };
    let (refined, made) = refine(&job.refiner(&progress), ready, job.crew, setting)?;
    drop(progress);
    seconds.refine = clock.elapsed().as_secs_f64();
    finish(ready, job, Meshed { refined, made, seconds, late: None })
}

/// Tells of a prepared domain, and the time that it has taken to read.
fn begin(ready: &Prepared, job: &Job<'_>) -> Seconds {
    let read = job.task.start.elapsed().as_secs_f64();
    print_domain(job.task.name, ready);
    Seconds { read, ..Seconds::default() }
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
