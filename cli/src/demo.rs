//! `demo`: a mesh worth looking at, in seconds.

use crate::args::{Demo, Depth};
use crate::console::{self, Stop};
use crate::outcome::{Exit, Failure, show};
use crate::run::{Job, ParallelJob, check_outputs, mesh_points};
use ltbw::generate::{PointKind, generate};
use ltbw::io::PointFile;
use std::path::Path;
use std::time::Instant;

/// Points of the thin shell, and of the clusters inside it.
const SHELL: usize = 60_000;
const CLUSTERS: usize = 40_000;

/// `ltbw demo`.
pub(crate) fn demo(args: &Demo) -> Result<Exit, Failure> {
    let start = Instant::now();
    check_outputs(std::slice::from_ref(&args.out))?;
    let stop = Stop::on_signal()?;
    let job = Job {
        command: "demo",
        name: Path::new("a thin shell with clusters inside"),
        outputs: std::slice::from_ref(&args.out),
        json: None,
        check: Depth::Full,
        stop: &stop,
        start,
        read_seconds: 0.0,
        workers: 1,
        parallel: ParallelJob::default(),
    };
    let exit = mesh_points(points(), &job)?;
    if exit == Exit::Done {
        let out = show(&args.out);
        console::people(&format!(
            "\nNext:\n  \
             open {out} in ParaView: clip it, show edges, colour by `tag`\n  \
             ltbw check {out}\n  \
             ltbw generate uniform 1000000 -o points.npy\n  \
             ltbw delaunay points.npy -o mesh.vtu"
        ));
    }
    Ok(exit)
}

/// A thin shell of radius 1 (tag 1) around ten clusters of size 0.8 down to 8e-10 (tag 2).
fn points() -> PointFile {
    let mut points = generate(PointKind::Shell, SHELL, 1);
    let clusters = generate(PointKind::Clusters, CLUSTERS, 1);
    points.extend(clusters.iter().map(|p| p.map(|c| (c - 0.5) * 0.8)));
    let tags = (0..SHELL + CLUSTERS).map(|i| if i < SHELL { 1 } else { 2 }).collect();
    PointFile { points, point_tags: Some(tags), notes: Vec::new() }
}
