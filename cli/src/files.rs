//! `convert` and `generate`: files in and out, without a mesh being built.

use crate::args::{Convert, Generate, Kind};
use crate::console;
use crate::outcome::{Exit, Failure, show};
use crate::progress::Stage;
use ltbw::Extras;
use ltbw::domain::{Domain, DomainError};
use ltbw::io::{self, DomainFile, Encoding, Format, MshVersion, PointFile, WriteOptions};
use ltbw_generate::{Shape, generate_domain};
use std::path::Path;

/// `ltbw convert`.
///
/// A `.node` file is points, unless the other file can only be a mesh.
pub(crate) fn convert(args: &Convert) -> Result<Exit, Failure> {
    console::end_on_signal()?;
    let (input, output) = (&args.input, &args.output);
    let from = Format::from_path(input).map_err(Failure::Read)?;
    let to = Format::from_path(output).map_err(Failure::Write)?;
    let options = options(args);
    let _stage = Stage::begin("convert");
    if from.holds_domain() && to.holds_domain() && (from, to) != (Format::Ply, Format::Ply) {
        let file = io::read_domain(input).map_err(Failure::Read)?;
        // A surface file without faces is a point cloud.
        if !(file.domain.facets.is_empty() && from.holds_points()) {
            return convert_domain(input, output, &file, options);
        }
    }
    if from.holds_points() && to.holds_points() {
        let file = io::read_points(input).map_err(Failure::Read)?;
        notes(input, &file.notes);
        write_points(output, to, &file, options)
    } else if from.holds_domain() && !from.holds_points() {
        let text = format!("{}: a domain is neither points nor a mesh", show(input));
        Err(Failure::Usage(text))
    } else if !from.holds_mesh() && to.holds_domain() {
        Err(Failure::Usage(format!("{}: points are no domain", show(input))))
    } else if to.holds_domain() && to != Format::Ply {
        // A .ply file may hold the points alone.
        Err(Failure::Usage(format!("{}: a mesh is no domain", show(input))))
    } else if !from.holds_mesh() {
        let text = format!(
            "{}: points are no mesh; `ltbw delaunay {} -o {}` makes one of them",
            show(input),
            show(input),
            show(output)
        );
        Err(Failure::Usage(text))
    } else {
        let file = io::read_mesh_file(input).map_err(Failure::Read)?;
        notes(input, &file.notes);
        let mesh = file.mesh;
        if to.holds_mesh() {
            let extras = Extras { faces: file.faces, ..Extras::default() };
            io::write_mesh_and(output, &mesh, &extras, options).map_err(Failure::Write)?;
            let (points, tets) = (mesh.points.len(), mesh.tets.len());
            console::people(&format!(
                "wrote     {}: {points} points, {tets} tetrahedra",
                show(output)
            ));
            return Ok(Exit::Done);
        }
        let text = format!("{} tetrahedra are not kept: this format holds points", mesh.tets.len());
        notes(output, &[text]);
        let point_tags = mesh.point_tags;
        let file = PointFile { points: mesh.points, point_tags, notes: Vec::new() };
        write_points(output, to, &file, options)
    }
}

/// A domain from one format into another.
fn convert_domain(
    input: &Path,
    output: &Path,
    file: &DomainFile,
    options: WriteOptions,
) -> Result<Exit, Failure> {
    notes(input, &file.notes);
    let failed = |e: DomainError| Failure::Domain { path: input.to_owned(), error: e.into() };
    file.domain.check_structure().map_err(failed)?;
    write_domain(output, &file.domain, options)
}

fn write_domain(path: &Path, domain: &Domain, options: WriteOptions) -> Result<Exit, Failure> {
    let format = Format::from_path(path).map_err(Failure::Write)?;
    io::write_domain_with(path, domain, options).map_err(Failure::Write)?;
    notes(path, &io::not_kept(domain, format));
    let (vertices, facets) = (domain.vertices.len(), domain.facets.len());
    console::people(&format!("wrote     {}: {vertices} vertices, {facets} facets", show(path)));
    Ok(Exit::Done)
}

/// The choices of the command line.
fn options(args: &Convert) -> WriteOptions {
    WriteOptions {
        encoding: if args.ascii { Encoding::Ascii } else { Encoding::Binary },
        msh_version: if args.msh2 { MshVersion::V2_2 } else { MshVersion::V4_1 },
    }
}

fn write_points(
    path: &Path,
    format: Format,
    file: &PointFile,
    options: WriteOptions,
) -> Result<Exit, Failure> {
    if file.point_tags.is_some() && !format.holds_point_tags() {
        notes(path, &["tags are not kept: this format has no place for them".to_owned()]);
    }
    io::write_points_with(path, file, options).map_err(Failure::Write)?;
    console::people(&format!("wrote     {}: {} points", show(path), file.points.len()));
    Ok(Exit::Done)
}

fn notes(path: &Path, notes: &[String]) {
    notes.iter().for_each(|n| console::people(&format!("note: {}: {n}", show(path))));
}

/// `ltbw generate`.
pub(crate) fn generate(args: &Generate) -> Result<Exit, Failure> {
    console::end_on_signal()?;
    let kind = match args.kind {
        Kind::Points(kind) => kind,
        Kind::Domain(kind) => {
            io::check_domain_writable(&args.output).map_err(Failure::Write)?;
            let shape = Shape { count: args.count, angle: args.angle, seed: args.seed };
            let domain =
                generate_domain(kind, &shape).map_err(|e| Failure::Usage(e.to_string()))?;
            return write_domain(&args.output, &domain, WriteOptions::default());
        }
    };
    io::check_points_writable(&args.output).map_err(Failure::Write)?;
    let format = Format::from_path(&args.output).map_err(Failure::Write)?;
    let count = args.count.unwrap_or(1000) as usize;
    let points = ltbw_generate::generate(kind, count, args.seed);
    let file = PointFile { points, ..PointFile::default() };
    write_points(&args.output, format, &file, WriteOptions::default())
}
