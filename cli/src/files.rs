//! `convert` and `generate`: files in and out, without a mesh being built.

use crate::args::{Convert, Generate};
use crate::console;
use crate::outcome::{Exit, Failure, show};
use ltbw::io::{self, Encoding, Format, MshVersion, PointFile, WriteOptions};
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
    if from.holds_points() && to.holds_points() {
        let file = io::read_points(input).map_err(Failure::Read)?;
        notes(input, &file.notes);
        write_points(output, to, &file, options)
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
            io::write_mesh_with(output, &mesh, options).map_err(Failure::Write)?;
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
    io::check_points_writable(&args.output).map_err(Failure::Write)?;
    let format = Format::from_path(&args.output).map_err(Failure::Write)?;
    let points = ltbw::generate::generate(args.kind, args.count as usize, args.seed);
    let file = PointFile { points, ..PointFile::default() };
    write_points(&args.output, format, &file, WriteOptions::default())
}
