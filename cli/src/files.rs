//! `convert` and `generate`: files in and out, without a mesh being built.

use crate::args::{Convert, Generate};
use crate::console;
use crate::json::file_writable;
use crate::kinds::Kind;
use crate::orient::orientation;
use crate::outcome::{Exit, Failure, show};
use crate::progress::Stage;
use crate::streams::{Formats, attributes_note, name_of};
use ltbw::domain::{CheckOptions, Domain, DomainError};
use ltbw::io::{self, DomainFile, Encoding, Format, MshVersion, PointFile, WriteOptions};
use ltbw_generate::{Shape, generate_domain};
use std::path::{Path, PathBuf};

/// A file to write, or stdout.
struct Output<'a> {
    path: &'a Path,
    /// Its name in messages.
    name: PathBuf,
    format: Format,
    formats: Formats,
}

/// `ltbw convert`.
///
/// A `.node` file is points, unless the other file can only be a mesh.
pub(crate) fn convert(args: &Convert) -> Result<Exit, Failure> {
    console::end_on_signal()?;
    let output = &args.output;
    let formats = args.streams.resolve(&[&args.input], std::slice::from_ref(output))?;
    let to = formats.of_output(output)?;
    file_writable(output)?;
    let source = formats.input(&args.input)?;
    let from = source.format;
    let output = &Output { path: output, name: name_of(output), format: to, formats };
    let input = &source.name;
    let options = options(args);
    let _stage = Stage::begin("convert");
    let from_domain = source.is_domain()?;
    // A `.vtk` file holds the one or the other.
    let from_mesh = from.holds_mesh() && !(from == Format::Vtk && from_domain);
    orientable(args, from_mesh && to.holds_mesh())?;
    if from_domain && to.holds_domain() && (from, to) != (Format::Ply, Format::Ply) {
        let file = source.domain()?;
        // A surface file without faces is a point cloud.
        if !(file.domain.facets.is_empty() && from.holds_points()) {
            return convert_domain(input, output, &file, options);
        }
    }
    if from.holds_points() && to.holds_points() {
        let file = source.points()?;
        notes(input, &file.notes);
        write_points(output, &file, options)
    } else if from_domain && !from.holds_points() {
        let text = format!("{}: a domain is neither points nor a mesh", show(input));
        Err(Failure::Usage(text))
    } else if !from_mesh && to.holds_domain() && !to.holds_mesh() {
        Err(Failure::Usage(format!("{}: points are no domain", show(input))))
    } else if to.holds_domain() && !to.holds_mesh() && to != Format::Ply {
        // A .ply file may hold the points alone.
        Err(Failure::Usage(format!("{}: a mesh is no domain", show(input))))
    } else if !from_mesh {
        let text = format!(
            "{}: points are no mesh; `ltbw delaunay {} -o {}` makes one of them",
            show(input),
            show(input),
            show(&output.name)
        );
        Err(Failure::Usage(text))
    } else {
        let mut file = source.mesh()?;
        notes(input, &file.notes);
        notes(input, &orientation(&mut file.mesh, args.orient));
        if !file.names.is_empty() && !to.holds_names() {
            let text = "names of groups are not kept: this format has no place for them";
            notes(&output.name, &[text.to_owned()]);
        }
        if to.holds_mesh() {
            let note = attributes_note(&file.mesh, to).map(str::to_owned);
            notes(&output.name, &Vec::from_iter(note));
            let (writer, carried) = (file.writer().options(options), source.carried_hash()?);
            let writer = carried.as_deref().map_or(writer, |hash| writer.hash(hash));
            formats.write_mesh(output.path, writer)?;
            let (points, tets) = (file.mesh.points.len(), file.mesh.tets.len());
            console::people(&format!(
                "wrote     {}: {points} points, {tets} tetrahedra",
                show(&output.name)
            ));
            return Ok(Exit::Done);
        }
        let mesh = file.mesh;
        let lost = [(mesh.tets.len(), "tetrahedra"), (mesh.faces.len(), "boundary triangles")];
        for (count, name) in lost.into_iter().filter(|&(count, _)| count > 0) {
            let text = format!("{count} {name} are not kept: this format holds points");
            notes(&output.name, &[text]);
        }
        let point_tags = mesh.point_tags;
        let file = PointFile { points: mesh.points, point_tags, notes: Vec::new() };
        write_points(output, &file, options)
    }
}

/// Refuses `--orient` where there are no tetrahedra.
fn orientable(args: &Convert, is_mesh: bool) -> Result<(), Failure> {
    let text = "--orient is about tetrahedra: it takes a mesh to a mesh";
    (is_mesh || !args.orient).then_some(()).ok_or_else(|| Failure::Usage(text.to_owned()))
}

/// A domain from one format into another.
fn convert_domain(
    input: &Path,
    output: &Output<'_>,
    file: &DomainFile,
    options: WriteOptions,
) -> Result<Exit, Failure> {
    notes(input, &file.notes);
    let failed = |e: DomainError| Failure::Domain { path: input.to_owned(), error: e.into() };
    file.domain.check_structure().map_err(failed)?;
    if !file.oriented || output.format.holds_surface() {
        return write_domain(output, &file.domain, options);
    }
    // Orientation means nothing in the other format: hole points say what is not inside.
    let asked = CheckOptions { oriented: true, ..CheckOptions::default() };
    let found = file.domain.check(&asked).ok().filter(|report| report.cells.is_some());
    if found.is_none() {
        let text = "the surface has defects: no hole points are added; all it encloses is inside";
        notes(&output.name, &[text.to_owned()]);
    }
    let voids = found.map(|report| report.voids).unwrap_or_default();
    let mut domain = file.domain.clone();
    if !voids.is_empty() {
        let text = format!("a hole point is added in each of {} voids", voids.len());
        notes(&output.name, &[text]);
    }
    domain.holes.extend(voids);
    write_domain(output, &domain, options)
}

fn write_domain(
    output: &Output<'_>,
    domain: &Domain,
    options: WriteOptions,
) -> Result<Exit, Failure> {
    let path = &output.name;
    output.formats.write_domain(output.path, domain, options)?;
    notes(path, &io::not_kept(domain, output.format));
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
    output: &Output<'_>,
    file: &PointFile,
    options: WriteOptions,
) -> Result<Exit, Failure> {
    let path = &output.name;
    if file.point_tags.is_some() && !output.format.holds_point_tags() {
        notes(path, &["tags are not kept: this format has no place for them".to_owned()]);
    }
    output.formats.write_points(output.path, file, options)?;
    console::people(&format!("wrote     {}: {} points", show(path), file.points.len()));
    Ok(Exit::Done)
}

fn notes(path: &Path, notes: &[String]) {
    notes.iter().for_each(|n| console::people(&format!("note: {}: {n}", show(path))));
}

/// `ltbw generate`.
pub(crate) fn generate(args: &Generate) -> Result<Exit, Failure> {
    console::end_on_signal()?;
    let path = &args.output;
    let formats = args.streams.resolve(&[], std::slice::from_ref(path))?;
    let output = || {
        let format = formats.of_output(path)?;
        Ok(Output { path, name: name_of(path), format, formats })
    };
    let kind = match args.kind {
        Kind::Points(kind) => kind,
        Kind::Domain(kind) => {
            formats.domain_writable(path)?;
            let shape = Shape { count: args.count, angle: args.angle, seed: args.seed };
            let domain =
                generate_domain(kind, &shape).map_err(|e| Failure::Usage(e.to_string()))?;
            return write_domain(&output()?, &domain, WriteOptions::default());
        }
    };
    formats.points_writable(path)?;
    let count = args.count.unwrap_or(1000) as usize;
    let points = ltbw_generate::generate(kind, count, args.seed);
    let file = PointFile { points, ..PointFile::default() };
    write_points(&output()?, &file, WriteOptions::default())
}
