//! `.msh`: Gmsh's meshes, versions 4.1 and 2.2, text and binary.
//!
//! Read: `Nodes` and `Elements`; in version 4.1 also `Entities`. Nodes keep the order of the
//! file; tetrahedra come in the order of their numbers. Regions are the physical groups of the
//! volumes (0: in none), or the geometrical entities where there is no group and more than one
//! entity. A view `tag` at the nodes and a view `region` in the elements are tags, too, if they
//! are integers everywhere; the view comes before the groups. Triangles
//! that are faces of tetrahedra are boundary triangles, with their physical group as marker. Of
//! tetrahedra and triangles of higher order the corners are read, and a note says so. Other
//! elements of dimension 0 to 2, names of groups of points and curves, other views and other
//! sections are not read, and a note says so; other volume elements are refused. Names of groups of
//! surfaces and volumes are kept for a file of the same format, also of groups in which nothing is.
//!
//! Written: version 4.1, or 2.2. Point tags are a view `tag`, with values of type double. Regions
//! are physical groups, each with an entity of its own, if all are positive and below 2^31 (what
//! Gmsh allows), else a view `region`. Boundary triangles come last, each different marker as a
//! surface and a physical group; a marker that can be no group (0, say) has a free one, named
//! `marker 0`. The hash of the mesh, where it is given, is a section `$Comments`.
//!
//! In parts, `m_1.msh`, `m_2.msh` and so on: what Gmsh itself writes with the options
//! `Mesh.PartitionSplitMeshFiles` and `Mesh.PartitionCreateGhostCells`, without entities between
//! partitions. Each has a volume of
//! its own partition for each region, a surface for each marker, and a ghost volume: the tetrahedra
//! of other parts that have a vertex of its own, with the partition that owns them. Nodes and
//! elements have the numbers of the whole, those that part 1 owns first. Tags of points are not
//! kept. Read under the name `m_%.msh`: copies are left out, nodes are put together by number.
//! Source: the Gmsh reference manual, "MSH file format" and "Legacy formats".

mod parted;
mod parts;
mod sink;
mod source;
mod v2;
mod v4;
mod write;

pub use super::MshVersion;

use super::error::{ParseError, Place, Reason, excerpt};
use super::parted::part_file;
use super::pvtu::Join;
use super::text::{capacity, count};
use super::{GroupName, IoError, Load, MeshFile, parse_error};
pub(crate) use parted::{check as check_part, write as write_part};
use parts::{Datum, Parts};
use source::{Form, Source};
use std::path::Path;
pub(super) use write::{check, write_hashed};
pub use write::{write, write_named};

/// Reads a `.msh` file. Of one that has the mesh of a partition, copies of elements of others are
/// left out.
pub fn read(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    read_part(bytes).map(|part| part.0)
}

/// Reads the parts `m_1.msh`, `m_2.msh` and so on of the mesh `m_%.msh`, with bytes that `load`
/// gives, and puts them together as those of a `.pvtu`.
pub(crate) fn read_parts(path: &Path, load: &mut Load<'_>) -> Result<MeshFile, IoError> {
    let mut whole = Join::default();
    let mut count = 1;
    let mut part = 0;
    // Each file says how many there are, and there is one for each.
    while part < count {
        let name = part_file(path, part);
        let read = read_part(&load(&name)?).and_then(|(file, partitions)| {
            count = usize::try_from(partitions).unwrap_or(usize::MAX);
            whole.add(file)
        });
        read.map_err(|error| parse_error(&name, error))?;
        part += 1;
    }
    Ok(whole.finish())
}

/// A file, and the number of partitions that it tells of.
fn read_part(bytes: &[u8]) -> Result<(MeshFile, u64), ParseError> {
    let mut source = Source::new(bytes);
    let version = mesh_format(&mut source)?;
    let mut parts = Parts::default();
    let mut volumes = v4::Volumes::default();
    // Every turn consumes a line.
    while let Some(line) = source.line() {
        let name = section_name(&source, line)?;
        let twice = match name {
            b"Nodes" => parts.nodes.is_some(),
            b"Elements" => parts.tets.is_some(),
            _ => false,
        };
        if twice {
            let text = format!("a second section `${}`", excerpt(name));
            return Err(source.error(Reason::Unsupported(text)));
        }
        match (name, version) {
            (b"Nodes", MshVersion::V4_1) => v4::nodes(&mut source, &mut parts)?,
            (b"Nodes", MshVersion::V2_2) => v2::nodes(&mut source, &mut parts)?,
            (b"Elements", _) if parts.nodes.is_none() => {
                let text = "`$Elements` before `$Nodes`";
                return Err(source.error(Reason::Unsupported(text.into())));
            }
            (b"Elements", MshVersion::V4_1) => v4::elements(&mut source, &mut parts, &volumes)?,
            (b"Elements", MshVersion::V2_2) => v2::elements(&mut source, &mut parts)?,
            (b"Entities", MshVersion::V4_1) => v4::entities(&mut source, &mut volumes)?,
            (b"PartitionedEntities", MshVersion::V4_1) => {
                v4::partitioned(&mut source, &mut volumes)?;
            }
            (b"GhostElements", MshVersion::V4_1) => v4::ghosts(&mut source, &mut parts)?,
            (b"PhysicalNames", _) => names(&mut source, &mut parts)?,
            (b"NodeData", _) => data(&mut source, &mut parts, "NodeData")?,
            (b"ElementData", _) => data(&mut source, &mut parts, "ElementData")?,
            // Words for people, and the hash of the mesh (`carried`).
            (b"Comments", _) => source.skip_section(name)?,
            (other, _) => {
                source.skip_section(other)?;
                parts.notes.push(format!("section ${} is not read", excerpt(other)));
            }
        }
    }
    parts.notes.dedup();
    let mesh = parts.mesh().map_err(|reason| ParseError::new(Place::End, reason))?;
    Ok((mesh, volumes.partitions))
}

/// The name in a line that opens a section, without its `$`.
fn section_name<'a>(source: &Source<'_>, line: &'a [u8]) -> Result<&'a [u8], ParseError> {
    match line.strip_prefix(b"$") {
        Some(name) if !name.is_empty() && !name.starts_with(b"End") => Ok(name),
        _ => {
            let text = format!("`{}` where a section was expected", excerpt(line));
            Err(source.error(Reason::Syntax(text)))
        }
    }
}

/// Reads the first section, which says how the others are stored.
fn mesh_format(source: &mut Source<'_>) -> Result<MshVersion, ParseError> {
    if source.line() != Some(b"$MeshFormat") {
        return Err(source.error(Reason::Syntax("not a Gmsh mesh".into())));
    }
    let line = source.expect_line()?;
    let fields: Vec<&[u8]> =
        line.split(u8::is_ascii_whitespace).filter(|f| !f.is_empty()).collect();
    let [version, binary, size] = fields.as_slice() else {
        let reason = Reason::Syntax("expected version, file type and data size".into());
        return Err(source.error(reason));
    };
    let version = match *version {
        b"4.1" => MshVersion::V4_1,
        b"2.2" | b"2" | b"2.0" | b"2.1" => MshVersion::V2_2,
        other => {
            let text = format!("version {}; 4.1 and 2.2 are read", excerpt(other));
            return Err(source.error(Reason::Unsupported(text)));
        }
    };
    if *binary == b"1" {
        let size = match (version, *size) {
            (MshVersion::V4_1, b"4") => 4,
            (_, b"8") => 8,
            (_, other) => {
                let text = format!("a data size of {}", excerpt(other));
                return Err(source.error(Reason::Unsupported(text)));
            }
        };
        // The number 1 tells the byte order.
        source.set_form(Form::Binary { big_endian: false, size });
        match source.int()? {
            1 => {}
            0x0100_0000 => source.set_form(Form::Binary { big_endian: true, size }),
            _ => {
                let text = "the number that tells the byte order is not 1";
                return Err(source.error(Reason::Syntax(text.into())));
            }
        }
    } else if *binary != b"0" {
        let text = format!("file type {}", excerpt(binary));
        return Err(source.error(Reason::Unsupported(text)));
    }
    source.end("MeshFormat")?;
    Ok(version)
}

/// Reads `$PhysicalNames`, lines of text also in binary files: names of surfaces and volumes, and
/// markers that names of surfaces tell.
fn names(source: &mut Source<'_>, parts: &mut Parts) -> Result<(), ParseError> {
    let mut others = false;
    for line in tags(source)? {
        let line = String::from_utf8_lossy(line);
        let mut fields = line.trim().splitn(3, ' ');
        let (dimension, group) = (fields.next(), fields.next().and_then(|g| g.parse().ok()));
        let name = fields.next().map(|name| name.trim().trim_matches('"'));
        let marker = name.and_then(|name| name.strip_prefix(write::NAME)?.parse().ok());
        match (dimension, group, marker) {
            (Some("2"), Some(group), Some(marker)) => drop(parts.markers.insert(group, marker)),
            // The name of a volume without one.
            (Some("3"), Some(group), None) if is_own_volume(name, group) => {}
            (Some(dimension @ ("2" | "3")), Some(group), None) => {
                let dimension = if dimension == "2" { 2 } else { 3 };
                let name = name.unwrap_or_default().to_owned();
                parts.names.push(GroupName { dimension, group, name });
            }
            _ => others = true,
        }
    }
    if others {
        parts.notes.push("names of physical groups of points and curves are not read".to_owned());
    }
    source.end("PhysicalNames")
}

/// Is it the name that a volume without another one has?
fn is_own_volume(name: Option<&str>, group: i64) -> bool {
    let number = name.and_then(|name| name.strip_prefix(write::VOLUME)?.parse().ok());
    number == Some(group)
}

/// Reads a view: its header is lines of text, also in binary files.
fn data(source: &mut Source<'_>, parts: &mut Parts, section: &str) -> Result<(), ParseError> {
    let texts = tags(source)?;
    drop(tags(source)?);
    let numbers = tags(source)?;
    let name = texts.first().map_or(&b""[..], |t| t.trim_ascii_start());
    let name = name.strip_prefix(b"\"").and_then(|n| n.strip_suffix(b"\"")).unwrap_or(name);
    let wanted = match section {
        "NodeData" => name == b"tag" && parts.tags.is_none(),
        _ => name == b"region" && parts.regions.is_none(),
    };
    // Time step, number of components, number of values.
    let (Some(components), Some(announced)) = (numbers.get(1), numbers.get(2)) else {
        let reason = Reason::Syntax("a view without its number of values".into());
        return Err(source.error(reason));
    };
    if !wanted || *components != b"1" {
        parts.notes.push(format!("data `{}` is not read", excerpt(name)));
        return source.skip_section(section.as_bytes());
    }
    let announced = count(announced).map_err(|r| source.error(r))?;
    let each = if source.is_text() { 4 } else { 12 };
    let mut values = Vec::with_capacity(capacity(announced, source.remaining(), each));
    for _ in 0..announced {
        values.push(Datum { number: source.small_size()?, value: source.double()? });
    }
    source.end(section)?;
    if section == "NodeData" {
        parts.tags = Some(values);
    } else {
        parts.regions = Some(values);
    }
    Ok(())
}

/// A count and as many lines.
fn tags<'a>(source: &mut Source<'a>) -> Result<Vec<&'a [u8]>, ParseError> {
    let line = source.expect_line()?;
    let announced = count(line).map_err(|r| source.error(r))?;
    // At most as many turns as there are lines.
    (0..announced).map(|_| source.expect_line()).collect()
}
