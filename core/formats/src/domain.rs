//! Reading and writing domains, whatever their format.

use super::atomic_file::{self, AtomicFile, Needs};
use super::{DomainFile, Format, IoError, Load, WriteOptions, load, parse_domain, parse_error};
use super::{poly, streams, tetgen, wrong_kind};
use ltbw_core::CancelToken;
use ltbw_domain::Domain;
use std::path::{Path, PathBuf};

/// Reads a domain file: `.poly`, `.smesh` (with its `.node` if it holds no points itself), `.off`,
/// `.obj`, `.stl`, `.ply` or `.vtk`.
pub fn read_domain(path: impl AsRef<Path>) -> Result<DomainFile, IoError> {
    read_domain_by(path, &mut load)
}

/// Reads a domain file as [`read_domain`] does, with bytes that `load` gives.
pub fn read_domain_by(path: impl AsRef<Path>, load: &mut Load<'_>) -> Result<DomainFile, IoError> {
    let path = path.as_ref();
    let format = domain_format(path)?;
    let bytes = load(path)?;
    if matches!(format, Format::Poly | Format::Smesh) && poly::needs_node(&bytes) {
        let beside = path.with_extension("node");
        let node = tetgen::parse_node(&load(&beside)?).map_err(|e| parse_error(&beside, e))?;
        let parse =
            if format == Format::Poly { poly::read_poly_with } else { poly::read_smesh_with };
        return parse(&bytes, node).map_err(|error| parse_error(path, error));
    }
    parse_domain(path, format, &bytes)
}

/// The files that [`read_domain`] reads for `path`: itself, and the `.node` beside it if the points
/// are there.
pub fn domain_files(path: impl AsRef<Path>) -> Vec<PathBuf> {
    let path = path.as_ref();
    let mut files = vec![path.to_owned()];
    // A file that cannot be read names no other.
    if let Ok(Format::Poly | Format::Smesh) = Format::from_path(path)
        && load(path).is_ok_and(|bytes| poly::needs_node(&bytes))
    {
        files.push(path.with_extension("node"));
    }
    files
}

/// Writes a domain with the default [`WriteOptions`]: `.poly`, `.smesh`, `.off`, `.obj`, `.stl`,
/// `.ply` or `.vtk`. The formats of surfaces do not keep all of a domain: see [`not_kept`].
pub fn write_domain(path: impl AsRef<Path>, domain: &Domain) -> Result<(), IoError> {
    let path = path.as_ref();
    write_domain_with(path, domain, WriteOptions::default())
}

/// Writes a domain as [`write_domain`] does, with a choice where the format leaves one.
pub fn write_domain_with(
    path: impl AsRef<Path>,
    domain: &Domain,
    options: WriteOptions,
) -> Result<(), IoError> {
    write_domain_until(path, domain, options, &CancelToken::new())
}

/// Writes a domain as [`write_domain_with`] does, until the token says otherwise: the file does not
/// get its name then.
///
/// # Errors
/// As [`write_domain_with`], and [`IoError::Cancelled`].
pub fn write_domain_until(
    path: impl AsRef<Path>,
    domain: &Domain,
    options: WriteOptions,
    cancel: &CancelToken,
) -> Result<(), IoError> {
    let path = path.as_ref();
    let format = domain_format(path)?;
    let faces = streams::domain_ready(path, format, domain)?;
    // A list of the faces, and of their corners.
    let needs = Needs { cancel: Some(cancel), memory: 64 * domain.facets.len() };
    AtomicFile::write_until(path, needs, |out| {
        streams::put_domain(out, format, domain, faces.as_ref(), options)
    })?
    .publish_unless(cancel)
}

fn domain_format(path: &Path) -> Result<Format, IoError> {
    let format = Format::from_path(path)?;
    if format.holds_domain() { Ok(format) } else { Err(wrong_kind(path, format, "a domain is")) }
}

/// Tells what would certainly keep a domain from being written, as
/// [`super::check_points_writable`] does for points.
pub fn check_domain_writable(path: impl AsRef<Path>) -> Result<(), IoError> {
    let path = path.as_ref();
    domain_format(path)?;
    atomic_file::check(path)
}

/// The parts of a domain that a format has no place for, in words for people.
pub fn not_kept(domain: &Domain, format: Format) -> Vec<String> {
    if !format.holds_surface() {
        return Vec::new();
    }
    let mut lost = Vec::new();
    let mut say = |some: bool, text: &str| {
        if some {
            lost.push(format!("{text} are not kept: this format has no place for them"));
        }
    };
    say(!domain.holes.is_empty(), "holes");
    say(!domain.regions.is_empty(), "regions");
    say(!domain.points.is_empty(), "points that are to be vertices");
    say(!domain.segments.is_empty(), "free-standing segments");
    let marked = domain.facets.iter().any(|f| f.marker != 0);
    say(marked && !matches!(format, Format::Ply | Format::Vtk), "markers of facets");
    let parts = |f: &ltbw_domain::Facet| f.polygons.len() > 1 || !f.holes.is_empty();
    if domain.facets.iter().any(parts) {
        lost.push("facets of several polygons are written as their triangles".to_owned());
    }
    lost
}
