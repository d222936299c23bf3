//! `ltbw-traditional KIND VOLUME PARTS FOLDER`: the way to a distributed mesh that the paper
//! compares its kernel with (Tables I and II), a step after the other: one thread makes the mesh of
//! a model domain; it is written to a file, as one program gives it to the next; the next one reads
//! it, makes the graph of its tetrahedra, and lets METIS part it; each part is sent to a thread of
//! its own, which numbers its vertices. The last line is JSON: seconds of the clock and of the
//! processor for each step, and figures of the partition. `cargo xtask paper` prints them.

mod deal;
mod graph;
mod step;

use ltbw::TetMesh;
use ltbw::domain::PrepareOptions;
use ltbw::io;
use ltbw::refine::Refiner;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;
use step::{Step, timed};

/// Anything that can go wrong: a message says it all.
type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("ltbw-traditional: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Failure> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [kind, volume, parts, folder] = &args[..] else {
        return Err("usage: ltbw-traditional KIND VOLUME PARTS FOLDER".into());
    };
    let (kind, volume): (DomainKind, f64) = (kind.parse()?, volume.parse()?);
    let parts: usize = parts.parse()?;
    if !(2..=1024).contains(&parts) {
        return Err(format!("{parts} parts: 2 to 1024").into());
    }
    let path = Path::new(folder).join("traditional.vtu");

    let (made, mesh) = timed(|| generate(kind, volume))?;
    let (written, ()) = timed(|| Ok(io::write_mesh(&path, &mesh)?))?;
    let bytes = std::fs::metadata(&path)?.len();
    let (points, tets) = (mesh.points.len(), mesh.tets.len());
    drop(mesh);
    let (read, mesh) = timed(|| Ok(io::read_mesh(&path)?))?;
    if (mesh.points.len(), mesh.tets.len()) != (points, tets) {
        return Err("another mesh was read than written".into());
    }
    std::fs::remove_file(&path)?;
    let (linked, graph) = timed(|| graph::dual(&mesh.tets))?;
    let (parted, part) = timed(|| graph.part(parts))?;
    let figures = graph.figures(&part, parts);
    let (dealt, deal) = deal::deal(&mesh, &part, parts)?;

    let steps: [(&str, Step); 6] = [
        ("generate", made),
        ("write", written),
        ("read", read),
        ("graph", linked),
        ("partition", parted),
        ("deal", dealt),
    ];
    let steps: Vec<_> = steps.into_iter().map(|(name, step)| step.to_json(name)).collect();
    let report = json!({
        "kind": kind.name(), "points": points, "tets": tets, "parts": parts, "file_bytes": bytes,
        "steps": steps,
        "surface_to_volume": figures.surface_to_volume, "imbalance_tets": figures.imbalance,
        "cut_faces": figures.cut, "most_neighbours": figures.neighbours,
        "dealt_bytes": deal.bytes, "shared_vertices": deal.copies - points,
    });
    println!("{report}");
    Ok(())
}

/// The refined mesh of a model domain, by one thread.
fn generate(kind: DomainKind, volume: f64) -> Result<TetMesh, Failure> {
    let domain = generate_domain(kind, &Shape::default())?;
    let ready = domain.prepare(&PrepareOptions::default())?;
    let refiner = Refiner::new().radius_edge(2.0).max_volume(volume).one_thread();
    Ok(refiner.refine(&ready.domain, &ready.lattice)?.inside())
}
