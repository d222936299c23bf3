//! `ltbw-traditional KIND VOLUME PARTS FOLDER`, on the processes of an MPI job: the way to a
//! distributed mesh that the paper compares its kernel with (Tables I and II), a step after the
//! other. The first process makes the mesh of a model domain by one thread; it is written to a
//! file, as one program gives it to the next; the next one reads it and makes the graph of its
//! tetrahedra. METIS parts that graph on the first process, PT-Scotch on all; by either partition
//! the tetrahedra are sent to the processes, which number their vertices.
//!
//! `ltbw-traditional --mesh FILE PARTS`: METIS's parts of a mesh that is there.
//!
//! The last line is JSON: seconds of the clock for each step, and figures of the partitions. `cargo
//! xtask paper` prints them.
#![deny(unsafe_code)]

mod deal;
mod graph;
#[allow(unsafe_code)]
mod scotch;

use deal::Whole;
use graph::{Dual, Figures};
use ltbw::TetMesh;
use ltbw::domain::PrepareOptions;
use ltbw::io;
use ltbw::refine::Refiner;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use metis::Idx;
use mpi::environment::{Threading, initialize_with_threading};
use mpi::topology::{Communicator, SimpleCommunicator};
use serde_json::{Value, json};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// Anything that can go wrong: a message says it all.
type Failure = Box<dyn std::error::Error>;

const USAGE: &str = "usage: ltbw-traditional KIND VOLUME PARTS FOLDER | --mesh FILE PARTS";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let outcome = match &args[..] {
        [flag, file, parts] if flag == "--mesh" => of_mesh(Path::new(file), parts),
        [kind, volume, parts, folder] => on_ranks(kind, volume, parts, Path::new(folder)),
        _ => Err(USAGE.into()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("ltbw-traditional: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The number of parts that a word says.
fn count_of(parts: &str) -> Result<usize, Failure> {
    let parts = parts.parse()?;
    if !(2..=1024).contains(&parts) {
        return Err(format!("{parts} parts: 2 to 1024").into());
    }
    Ok(parts)
}

/// Prints METIS's parts of a mesh.
fn of_mesh(path: &Path, parts: &str) -> Result<(), Failure> {
    let parts = count_of(parts)?;
    let mesh = io::read_mesh(path)?;
    let graph = graph::dual(&mesh.tets)?;
    let figures = graph.figures(&graph.metis(parts)?, parts);
    println!("{}", json!({ "tets": mesh.tets.len(), "METIS": told(&figures) }));
    Ok(())
}

/// Goes the whole way on the processes of this job.
fn on_ranks(kind: &str, volume: &str, parts: &str, folder: &Path) -> Result<(), Failure> {
    let (kind, volume): (DomainKind, f64) = (kind.parse()?, volume.parse()?);
    let parts = count_of(parts)?;
    let universe = initialize_with_threading(Threading::Multiple);
    let (universe, _) = universe.ok_or("MPI is initialised already")?;
    let world = universe.world();
    let outcome = match world.rank() {
        0 => first(&world, kind, volume, parts, folder),
        _ => other(&world, parts),
    };
    if let Err(error) = outcome {
        eprintln!("ltbw-traditional: rank {}: {error}", world.rank());
        // The others wait for this process.
        world.abort(1);
    }
    Ok(())
}

/// The seconds that a step takes, and what it makes.
struct Timed<T> {
    seconds: f64,
    made: T,
}

fn timed<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<Timed<T>, Failure> {
    let clock = Instant::now();
    let made = work()?;
    Ok(Timed { seconds: clock.elapsed().as_secs_f64(), made })
}

/// The first process: what is sequential, and its share of the rest.
fn first(
    world: &SimpleCommunicator,
    kind: DomainKind,
    volume: f64,
    parts: usize,
    folder: &Path,
) -> Result<(), Failure> {
    let path = folder.join("traditional.vtu");
    let Timed { seconds: generated, made: mesh } = timed(|| generate(kind, volume))?;
    let Timed { seconds: written, made: () } = timed(|| Ok(io::write_mesh(&path, &mesh)?))?;
    let bytes = std::fs::metadata(&path)?.len();
    let (points, tets) = (mesh.points.len(), mesh.tets.len());
    drop(mesh);
    let Timed { seconds: read, made: mesh } = timed(|| Ok(io::read_mesh(&path)?))?;
    if (mesh.points.len(), mesh.tets.len()) != (points, tets) {
        return Err("another mesh was read than written".into());
    }
    std::fs::remove_file(&path)?;
    let Timed { seconds: linked, made: graph } = timed(|| graph::dual(&mesh.tets))?;
    let mut report = json!({
        "kind": kind.name(), "points": points, "tets": tets, "parts": parts, "file_bytes": bytes,
        "ranks": world.size(), "generate": generated, "write": written, "read": read,
        "graph": linked,
    });
    let metis = timed(|| graph.metis(parts))?;
    report["METIS"] = parted(world, &mesh, &graph, parts, metis)?;
    let scotch = timed(|| scotch::part(world, Some(&graph), parts))?;
    report["PT-Scotch"] = parted(world, &mesh, &graph, parts, scotch)?;
    println!("{report}");
    Ok(())
}

/// Any other process.
fn other(world: &SimpleCommunicator, parts: usize) -> Result<(), Failure> {
    deal::deal(world, None, parts)?;
    scotch::part(world, None, parts)?;
    deal::deal(world, None, parts)?;
    Ok(())
}

/// Deals the parts of a partition; tells its time and figures.
fn parted(
    world: &SimpleCommunicator,
    mesh: &TetMesh,
    graph: &Dual,
    parts: usize,
    found: Timed<Vec<Idx>>,
) -> Result<Value, Failure> {
    let Timed { seconds, made: part } = found;
    let whole = Whole { mesh, part: &part };
    let Timed { seconds: dealing, made: dealt } = timed(|| deal::deal(world, Some(&whole), parts))?;
    if dealt.tets != mesh.tets.len() {
        return Err("tetrahedra were lost on their way".into());
    }
    let mut told = told(&graph.figures(&part, parts));
    told["partition"] = json!(seconds);
    told["deal"] = json!(dealing);
    told["dealt_bytes"] = json!(dealt.bytes);
    told["shared_vertices"] = json!(dealt.copies - mesh.points.len());
    Ok(told)
}

fn told(figures: &Figures) -> Value {
    json!({
        "surface_to_volume": figures.surface_to_volume, "imbalance_tets": figures.imbalance,
        "cut_faces": figures.cut, "most_neighbours": figures.neighbours,
    })
}

/// The refined mesh of a model domain, by one thread.
fn generate(kind: DomainKind, volume: f64) -> Result<TetMesh, Failure> {
    let domain = generate_domain(kind, &Shape::default())?;
    let ready = domain.prepare(&PrepareOptions::default())?;
    let refiner = Refiner::new().radius_edge(2.0).max_volume(volume).one_thread();
    Ok(refiner.refine(&ready.domain, &ready.lattice)?.inside())
}
