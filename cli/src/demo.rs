//! `demo`: the paper's model problem, meshed and checked in seconds, and a page to look at.

use crate::args::{Demo, Depth};
use crate::binding::{Binding, Chosen};
use crate::bounds::Asked;
use crate::console::{self, Stop};
use crate::domain_job::Job;
use crate::json::{distinct, is_stdout};
use crate::mesh::mesh_domain;
use crate::outcome::{Exit, Failure, show};
use crate::parts::Boundary;
use crate::streams::Formats;
use crate::task::{Outputs, Task};
use ltbw::domain::PrepareOptions;
use ltbw::io;
use ltbw::refine::ExcusedShare;
use ltbw_generate::{DomainKind, Shape, generate_domain};
use std::path::Path;
use std::time::Instant;

/// The paper's bound, for some 105,000 tetrahedra.
const MAX_VOLUME: f64 = 1.73783e-5;
const RADIUS_EDGE: f64 = 2.0;
const MIN_DIHEDRAL: f64 = 8.0;

/// `ltbw demo`.
pub(crate) fn demo(args: &Demo) -> Result<Exit, Failure> {
    let start = Instant::now();
    if is_stdout(&args.out) {
        let text = "--out: stdout has no place for the page, which goes beside the mesh";
        return Err(Failure::Usage(text.to_owned()));
    }
    let page = args.out.with_extension("html");
    Formats::default().meshes_writable(std::slice::from_ref(&args.out))?;
    io::check_bytes_writable(&page).map_err(Failure::Write)?;
    distinct(&[args.out.clone(), page.clone()])?;
    let stop = Stop::on_signal()?;
    let name = Path::new("a cube with a suspended octahedral hole");
    let domain = generate_domain(DomainKind::CubeOctahedron, &Shape::default())
        .map_err(|e| Failure::Other(e.to_string()))?;
    let failed = |error| Failure::Domain { path: name.to_owned(), error };
    let ready = domain.prepare(&PrepareOptions::default()).map_err(failed)?;
    let options = Chosen::default()
        .with("domain", Some(DomainKind::CubeOctahedron.name()))
        .number("radius_edge", Some(RADIUS_EDGE))
        .number("min_dihedral", Some(MIN_DIHEDRAL))
        .number("max_volume", Some(MAX_VOLUME));
    let outputs = Outputs { whole: vec![args.out.clone()], ..Outputs::default() };
    let task = Task {
        command: "demo",
        name,
        outputs: &outputs,
        json: None,
        page: Some(&page),
        check: Depth::Full,
        binding: Binding { inputs: Vec::new(), options },
        stop: &stop,
        start,
    };
    let job = Job {
        task,
        asked: Asked {
            radius_edge: Some(RADIUS_EDGE),
            min_dihedral: MIN_DIHEDRAL,
            max_volume: Some(MAX_VOLUME),
            max_edge: None,
            smooth: 0,
        },
        field: None,
        crew: None,
        max_points: None,
        flat_tolerance: 0.0,
        boundary: Boundary::default(),
        keep_exterior: false,
        write_unrecovered: false,
        histogram: None,
        trace: None,
        excused_share: ExcusedShare::USUAL,
    };
    let exit = mesh_domain(&ready, &job)?;
    if exit == Exit::Done {
        let (out, page) = (show(&args.out), show(&page));
        console::people(&format!(
            "\nNext:\n  \
             open {page} in a browser\n  \
             open {out} in ParaView: clip it, show edges, colour by `dihedral_min`\n  \
             ltbw generate cube-octahedron -o model.poly\n  \
             ltbw check {out} --plc model.poly --max-volume {MAX_VOLUME:e}\n  \
             ltbw generate uniform 1000000 -o points.npy\n  \
             ltbw delaunay points.npy -o mesh.vtu"
        ));
    }
    Ok(exit)
}
