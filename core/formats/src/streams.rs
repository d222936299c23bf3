//! Bytes instead of files: a format that the caller names, and data that come from anywhere.
//!
//! `name` stands in messages only. Formats of several files are refused: one stream is one file.

use super::surface::Faces;
use super::{DomainFile, Encoding, Format, IoError, MeshFile, PointFile, WriteOptions};
use super::{check_float_tags, check_points, data_error, parse_error, write_error};
use super::{
    csv, medit, msh, npy, npz, obj, off, ply, poly, stl, tetgen, txt, vtk, vtu, wrong_kind, xyz,
};
use ltbw_domain::Domain;
use std::io::Write;
use std::path::Path;

/// Points from the bytes of a file of any format that [`super::read_points`] reads.
///
/// # Errors
/// [`IoError`] with `name`: a format without points, or bytes that break its rules.
pub fn parse_points(
    name: impl AsRef<Path>,
    format: Format,
    bytes: &[u8],
) -> Result<PointFile, IoError> {
    let name = name.as_ref();
    let parse = match format {
        Format::Npy => npy::read,
        Format::Npz => npz::read,
        Format::Xyz => xyz::read,
        Format::Txt => txt::read,
        Format::Csv => csv::read,
        Format::Node => tetgen::read_node,
        Format::Ply => ply::read,
        Format::Off => off::read,
        Format::Obj => obj::read,
        Format::Stl => stl::read,
        format => return Err(wrong_kind(name, format, "points are")),
    };
    parse(bytes).map_err(|error| parse_error(name, error))
}

/// A mesh from the bytes of a file: `.vtu`, `.vtk`, `.msh` or `.mesh`.
///
/// # Errors
/// [`IoError`] with `name`: a format without a mesh or of two files, or bytes that break its rules.
pub fn parse_mesh(
    name: impl AsRef<Path>,
    format: Format,
    bytes: &[u8],
) -> Result<MeshFile, IoError> {
    let name = name.as_ref();
    let parse = match format {
        Format::Vtu => vtu::read,
        Format::Vtk => vtk::read,
        Format::Msh => msh::read,
        Format::Medit => medit::read,
        Format::Node | Format::Ele | Format::Pvtu => return Err(several(name, format)),
        format => return Err(wrong_kind(name, format, "a mesh is")),
    };
    parse(bytes).map_err(|error| parse_error(name, error))
}

/// A domain from the bytes of a file of any format that [`super::read_domain`] reads.
///
/// # Errors
/// [`IoError`] with `name`: a format without a domain, bytes that break its rules, or a `.poly` or
/// `.smesh` file whose points are in another file.
pub fn parse_domain(
    name: impl AsRef<Path>,
    format: Format,
    bytes: &[u8],
) -> Result<DomainFile, IoError> {
    let name = name.as_ref();
    let parse = match format {
        Format::Off => off::read_domain,
        Format::Obj => obj::read_domain,
        Format::Stl => stl::read_domain,
        Format::Ply => ply::read_domain,
        Format::Vtk => vtk::read_domain,
        Format::Poly | Format::Smesh if poly::needs_node(bytes) => {
            return Err(several(name, format));
        }
        Format::Poly => poly::read_poly,
        Format::Smesh => poly::read_smesh,
        _ => return Err(wrong_kind(name, format, "a domain is")),
    };
    parse(bytes).map_err(|error| parse_error(name, error))
}

/// Writes points to a stream, as [`super::write_points_with`] does to a file.
///
/// # Errors
/// [`IoError`] with `name`: data that the format cannot hold, or what `out` says.
pub fn write_points_to(
    out: &mut dyn Write,
    name: impl AsRef<Path>,
    format: Format,
    file: &PointFile,
    options: WriteOptions,
) -> Result<(), IoError> {
    let name = name.as_ref();
    points_ready(name, format, file)?;
    put_points(out, format, file, options).map_err(|source| write_error(name, source))
}

/// Writes a domain to a stream, as [`super::write_domain_with`] does to a file.
///
/// # Errors
/// [`IoError`] with `name`: data that the format cannot hold, or what `out` says.
pub fn write_domain_to(
    out: &mut dyn Write,
    name: impl AsRef<Path>,
    format: Format,
    domain: &Domain,
    options: WriteOptions,
) -> Result<(), IoError> {
    let name = name.as_ref();
    let faces = domain_ready(name, format, domain)?;
    put_domain(out, format, domain, faces.as_ref(), options)
        .map_err(|source| write_error(name, source))
}

/// Tells whether [`write_points_to`] takes this format at all.
///
/// # Errors
/// [`IoError`] with `name`, if it does not.
pub fn check_points_stream(name: impl AsRef<Path>, format: Format) -> Result<(), IoError> {
    let name = name.as_ref();
    if !format.holds_points() {
        return Err(wrong_kind(name, format, "points are"));
    }
    if format.is_read_only() {
        return Err(IoError::ReadOnly { path: name.to_owned() });
    }
    Ok(())
}

/// Tells whether [`super::MeshWriter::write_to`] takes this format at all.
///
/// # Errors
/// [`IoError`] with `name`, if it does not.
pub fn check_mesh_stream(name: impl AsRef<Path>, format: Format) -> Result<(), IoError> {
    let name = name.as_ref();
    match format {
        Format::Node | Format::Ele | Format::Pvtu => Err(several(name, format)),
        _ if !format.holds_mesh() => Err(wrong_kind(name, format, "a mesh is")),
        _ => Ok(()),
    }
}

/// Tells whether [`write_domain_to`] takes this format at all.
///
/// # Errors
/// [`IoError`] with `name`, if it does not.
pub fn check_domain_stream(name: impl AsRef<Path>, format: Format) -> Result<(), IoError> {
    match format.holds_domain() {
        true => Ok(()),
        false => Err(wrong_kind(name.as_ref(), format, "a domain is")),
    }
}

fn several(name: &Path, format: Format) -> IoError {
    IoError::SeveralFiles { path: name.to_owned(), extension: format.extension() }
}

/// Checks that points can be written in a format.
pub(super) fn points_ready(name: &Path, format: Format, file: &PointFile) -> Result<(), IoError> {
    check_points_stream(name, format)?;
    let tags = file.point_tags.as_deref();
    check_points(&file.points, tags).map_err(|r| data_error(name, r))?;
    match format {
        Format::Ply => check_float_tags("point", tags).map_err(|r| data_error(name, r)),
        _ => Ok(()),
    }
}

/// Writes points for which [`points_ready`] had no complaint.
pub(super) fn put_points(
    out: &mut dyn Write,
    format: Format,
    file: &PointFile,
    options: WriteOptions,
) -> std::io::Result<()> {
    let (points, tags) = (&file.points, file.point_tags.as_deref());
    match format {
        Format::Npy => npy::write(out, points, tags),
        Format::Txt => txt::write(out, points, tags),
        Format::Csv => csv::write(out, points, tags),
        Format::Node => tetgen::write_node(out, points, tags),
        Format::Ply => ply::write(out, points, tags, options.encoding),
        _ => xyz::write(out, points, tags),
    }
}

/// Checks that a domain can be written in a format; its faces, if the format is one of surfaces.
pub(super) fn domain_ready<'a>(
    name: &Path,
    format: Format,
    domain: &'a Domain,
) -> Result<Option<Faces<'a>>, IoError> {
    check_domain_stream(name, format)?;
    domain.check_structure().map_err(|e| data_error(name, e.into()))?;
    match format {
        Format::Poly => Ok(None),
        Format::Smesh => poly::check_smesh(domain).map(|()| None).map_err(|e| data_error(name, e)),
        _ => {
            let faces = Faces::of(domain, format == Format::Stl);
            faces.map(Some).map_err(|e| data_error(name, e))
        }
    }
}

/// Writes a domain for which [`domain_ready`] had no complaint.
pub(super) fn put_domain(
    out: &mut dyn Write,
    format: Format,
    domain: &Domain,
    faces: Option<&Faces<'_>>,
    options: WriteOptions,
) -> std::io::Result<()> {
    match (format, faces) {
        (_, Some(faces)) => write_faces(out, faces, format, options.encoding),
        (Format::Smesh, None) => poly::write_smesh(out, domain),
        _ => poly::write_poly(out, domain),
    }
}

/// Writes the faces of a surface as `.off`, `.obj`, `.stl` or `.ply`.
fn write_faces(
    out: &mut dyn Write,
    faces: &Faces<'_>,
    format: Format,
    encoding: Encoding,
) -> std::io::Result<()> {
    let points = faces.points();
    let corners = || faces.iter().map(|face| face.corners);
    match format {
        Format::Ply => ply::write_surface(out, points, &faces.iter().collect::<Vec<_>>(), encoding),
        Format::Vtk => vtk::write_surface(out, points, &faces.iter().collect::<Vec<_>>(), encoding),
        Format::Stl => {
            let triangles = corners().filter_map(|c| c.try_into().ok());
            stl::write_surface(out, points, &triangles.collect::<Vec<[u32; 3]>>())
        }
        Format::Obj => obj::write_surface(out, points, &corners().collect::<Vec<_>>()),
        _ => off::write_surface(out, points, &corners().collect::<Vec<_>>()),
    }
}
