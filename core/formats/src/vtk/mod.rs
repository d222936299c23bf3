//! `.vtk`: VTK's legacy format, versions 1 to 5, text and binary.
//!
//! Read: an `UNSTRUCTURED_GRID` as a mesh, by the rules of `.vtu`: tetrahedra, triangles that are
//! their faces, integer arrays `tag` of points, `region` and `marker` of cells, and `attribute`;
//! and `POLYDATA` as a surface, the polygons and triangle strips with an integer array `marker`. An
//! integer array `cell_scalars`, as TetGen writes it, is the regions if there is no `region`. Other
//! datasets are refused; other cells and arrays are not read, and a note says so. Written: version
//! 5.1.
//! Source: "VTK File Formats", the chapter on simple legacy formats.

mod source;
mod write;

use super::error::{ParseError, Place, Reason, excerpt};
use super::surface::{Corners, Surface};
use super::text::count;
use super::vtu::{Grid, OTHER_ARRAYS, Piece};
use super::{DomainFile, MeshFile, Point};
use source::{Source, Type};
pub(crate) use write::write_surface;
pub use write::write_with;

/// Reads a `.vtk` file with a mesh.
pub fn read(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let parts = parts(bytes)?;
    if parts.is_surface {
        let text = "POLYDATA is a surface, where a mesh is wanted";
        return Err(ParseError::new(Place::Header, Reason::Unsupported(text.into())));
    }
    let mut notes = Vec::new();
    let other_arrays = parts.other_arrays || parts.regions.is_some() && parts.scalars.is_some();
    let mut grid = Grid::default();
    let cells = parts.cells.unwrap_or_default();
    let piece = Piece {
        points: parts.points.len() as u64,
        cells: cells.offsets.len() as u64,
        coordinates: parts.points.into_flattened(),
        connectivity: cells.connectivity,
        offsets: cells.offsets,
        types: parts.types,
        tags: parts.tags,
        regions: parts.regions.or(parts.scalars),
        markers: parts.markers,
        attributes: parts.attributes,
        ..Piece::default()
    };
    grid.add(piece).map_err(|r| ParseError::new(Place::End, r))?;
    if other_arrays {
        notes.push(OTHER_ARRAYS.to_owned());
    }
    let (mesh, more) = grid.finish();
    notes.extend(more);
    Ok(MeshFile { mesh, notes, names: Vec::new() })
}

/// Reads a `.vtk` file with a surface.
pub fn read_domain(bytes: &[u8]) -> Result<DomainFile, ParseError> {
    let parts = parts(bytes)?;
    let at_end = |reason| ParseError::new(Place::End, reason);
    if !parts.is_surface {
        let text = "an UNSTRUCTURED_GRID is a mesh, where a surface is wanted";
        return Err(ParseError::new(Place::Header, Reason::Unsupported(text.into())));
    }
    let points = parts.points.len();
    u32::try_from(points).map_err(|_| at_end(Reason::TooManyPoints(points as u64)))?;
    let (polygons, strips) = (parts.cells.unwrap_or_default(), parts.strips.unwrap_or_default());
    let faces = polygons.offsets.len() + strips.offsets.len();
    let mut surface = Surface::new(parts.points);
    surface.reserve(faces);
    // Data of cells begin with those of vertices and lines.
    let markers = parts.markers.as_ref().and_then(|m| m.get(parts.before..));
    let markers = markers.filter(|m| m.len() >= faces);
    if parts.markers.is_some() && markers.is_none() {
        return Err(at_end(Reason::Syntax("not every polygon has a `marker`".into())));
    }
    let lists = polygons.lists("polygon", points).chain(strips.lists("strip", points));
    for (face, corners) in lists.enumerate() {
        let corners = corners.map_err(at_end)?;
        let marker = markers.map_or(0, |m| m[face]);
        let marker =
            i32::try_from(marker).map_err(|_| at_end(Reason::NotAnInteger(marker.to_string())))?;
        if face < polygons.offsets.len() {
            surface.marked_face(Corners::from(&corners[..]), marker).map_err(at_end)?;
        } else {
            surface.strip(&corners, marker);
        }
    }
    polygons.finished("polygon").and_then(|()| strips.finished("strip")).map_err(at_end)?;
    let mut notes = Vec::new();
    if parts.before > 0 {
        notes.push("vertices and lines are not read".to_owned());
    }
    let tagged = parts.tags.is_some() || parts.regions.is_some() || parts.attributes.is_some();
    if parts.other_arrays || tagged {
        notes.push("arrays other than `marker` of polygons are not read".to_owned());
    }
    Ok(surface.finish(notes))
}

/// Does the header of these bytes announce a surface?
pub fn is_surface(bytes: &[u8]) -> bool {
    let mut source = Source::new(bytes);
    // The version, a title, and the form.
    if (0..3).any(|_| source.raw_line().is_none()) {
        return false;
    }
    source.words().is_some_and(|words| words == [&b"DATASET"[..], b"POLYDATA"])
}

/// Cells as lists of corners: where each ends, and all corners.
#[derive(Default)]
struct Cells {
    offsets: Vec<i64>,
    connectivity: Vec<i64>,
}

impl Cells {
    /// The corners of each cell, which are some of `points` points; cells are called `what`.
    fn lists(
        &self,
        what: &'static str,
        points: usize,
    ) -> impl Iterator<Item = Result<Vec<u32>, Reason>> {
        let mut start = 0;
        self.offsets.iter().enumerate().map(move |(cell, &end)| {
            let end = usize::try_from(end).unwrap_or(0);
            let wrong = || Reason::Syntax(format!("{what} {cell} has offsets out of order"));
            let list = self.connectivity.get(start..end).ok_or_else(wrong)?;
            start = end;
            let last = points as i64 - 1;
            let number = cell as u64;
            let index = |&index: &i64| match index {
                index if index < 0 || index > last => {
                    Err(Reason::Index { what, number, index, first: 0, last })
                }
                index => Ok(index as u32),
            };
            list.iter().map(index).collect()
        })
    }

    /// Checks that no corners are left behind those of the last cell.
    fn finished(&self, what: &'static str) -> Result<(), Reason> {
        let end = self.offsets.last().map_or(0, |&end| usize::try_from(end).unwrap_or(0));
        if end < self.connectivity.len() { Err(Reason::Surplus(what)) } else { Ok(()) }
    }
}

/// Everything that is read from a file.
#[derive(Default)]
struct Parts {
    is_surface: bool,
    points: Vec<Point>,
    /// The cells of a grid, or the polygons of a surface.
    cells: Option<Cells>,
    types: Vec<i64>,
    /// The triangle strips of a surface, which come behind its polygons.
    strips: Option<Cells>,
    /// Cells of a surface that come before its polygons.
    before: usize,
    tags: Option<Vec<i64>>,
    regions: Option<Vec<i64>>,
    markers: Option<Vec<i64>>,
    attributes: Option<Vec<f64>>,
    /// TetGen's array of regions.
    scalars: Option<Vec<i64>>,
    other_arrays: bool,
}

/// The things that data are about.
#[derive(Clone, Copy, PartialEq)]
enum About {
    Points,
    Cells,
    Other,
}

fn parts(bytes: &[u8]) -> Result<Parts, ParseError> {
    let mut source = Source::new(bytes);
    let version = header(&mut source)?;
    let mut parts = Parts::default();
    let dataset = source.words().unwrap_or_default();
    parts.is_surface = match dataset.as_slice() {
        [b"DATASET", b"UNSTRUCTURED_GRID"] => false,
        [b"DATASET", b"POLYDATA"] => true,
        [b"DATASET", other] => {
            let text = format!("a dataset `{}`", excerpt(other));
            return Err(source.error(Reason::Unsupported(text)));
        }
        _ => return Err(source.syntax("no DATASET behind the header")),
    };
    let (mut about, mut rows, mut seen) = (About::Other, 0, false);
    // Every turn consumes a line.
    while let Some(words) = source.words() {
        let number = |at: usize| {
            let word = words.get(at).copied().unwrap_or_default();
            count(word).map_err(|r| source.error(r))
        };
        let keyword = words[0].to_ascii_uppercase();
        match (keyword.as_slice(), parts.is_surface) {
            (b"POINTS", _) if !seen => {
                seen = true;
                let announced = number(1)?.saturating_mul(3);
                let kind = source.kind(words.get(2).copied().unwrap_or_default())?;
                let values = source.floats(kind, announced)?;
                parts.points = values.as_chunks::<3>().0.to_vec();
            }
            (b"CELLS", false) | (b"POLYGONS", true) if parts.cells.is_none() => {
                let sizes = [number(1)?, number(2)?];
                parts.cells = Some(cells(&mut source, version, sizes)?);
            }
            (b"VERTICES" | b"LINES", true) => {
                let sizes = [number(1)?, number(2)?];
                parts.before += cells(&mut source, version, sizes)?.offsets.len();
            }
            (b"TRIANGLE_STRIPS", true) if parts.strips.is_none() => {
                let sizes = [number(1)?, number(2)?];
                parts.strips = Some(cells(&mut source, version, sizes)?);
            }
            (b"CELL_TYPES", false) if parts.types.is_empty() => {
                parts.types = source.integers(Type::INT, number(1)?)?;
            }
            (b"POINT_DATA", _) => (about, rows) = (About::Points, number(1)?),
            (b"CELL_DATA", _) => (about, rows) = (About::Cells, number(1)?),
            (b"METADATA", _) => {
                // It ends with an empty line; every turn consumes one.
                while source.raw_line().is_some_and(|line| !line.is_empty()) {}
            }
            _ => attribute(&mut source, &mut parts, &words, about, rows)?,
        }
    }
    if !seen {
        return Err(source.syntax("the file ends without POINTS"));
    }
    Ok(parts)
}

/// Reads the first three lines; the major version.
fn header(source: &mut Source<'_>) -> Result<u64, ParseError> {
    let first = source.raw_line().unwrap_or_default();
    let version = first.strip_prefix(b"# vtk DataFile Version ");
    let major = version.and_then(|v| v.split(|&b| b == b'.').next()).and_then(|m| count(m).ok());
    let Some(major @ 1..=5) = major else {
        return Err(source.syntax("not a legacy VTK file of version 1 to 5"));
    };
    // A title, which means nothing.
    source.raw_line();
    source.binary = match source.raw_line().unwrap_or_default() {
        b"ASCII" => false,
        b"BINARY" => true,
        _ => return Err(source.syntax("neither ASCII nor BINARY")),
    };
    Ok(major)
}

/// Reads lists of corners, in the form of the version.
fn cells(source: &mut Source<'_>, version: u64, sizes: [u64; 2]) -> Result<Cells, ParseError> {
    let [first, second] = sizes;
    if version < 5 {
        let list = source.integers(Type::INT, second)?;
        let mut cells = Cells::default();
        let mut rest = list.as_slice();
        for _ in 0..first {
            let cell = rest.split_first().and_then(|(&length, behind)| {
                behind.split_at_checked(usize::try_from(length).ok()?)
            });
            let Some((corners, behind)) = cell else {
                return Err(source.syntax("a list of cells that is too short for its cells"));
            };
            cells.connectivity.extend_from_slice(corners);
            cells.offsets.push(cells.connectivity.len() as i64);
            rest = behind;
        }
        if !rest.is_empty() {
            return Err(source.error(Reason::Surplus("cell")));
        }
        return Ok(cells);
    }
    let mut array = |name: &[u8], size: u64| {
        let words = source.words().unwrap_or_default();
        match words.as_slice() {
            [word, kind] if word.eq_ignore_ascii_case(name) => {
                let kind = source.kind(kind)?;
                source.integers(kind, size)
            }
            _ => Err(source.syntax(format!("no {}", String::from_utf8_lossy(name)))),
        }
    };
    let mut offsets = array(b"OFFSETS", first)?;
    let connectivity = array(b"CONNECTIVITY", second)?;
    // The first one is the start of the first cell.
    if offsets.first().is_some_and(|&start| start != 0) {
        return Err(source.syntax("the first offset is not 0"));
    }
    if !offsets.is_empty() {
        offsets.remove(0);
    }
    Ok(Cells { offsets, connectivity })
}

/// Reads or passes over an attribute of `rows` points or cells, or a field of arrays.
fn attribute(
    source: &mut Source<'_>,
    parts: &mut Parts,
    words: &[&[u8]],
    about: About,
    rows: u64,
) -> Result<(), ParseError> {
    let word = |at: usize| words.get(at).copied().unwrap_or_default();
    let number = |source: &Source<'_>, word| count(word).map_err(|r| source.error(r));
    let name = word(1);
    match word(0).to_ascii_uppercase().as_slice() {
        b"SCALARS" => {
            let kind = source.kind(word(2))?;
            let width = if words.len() > 3 { number(source, word(3))? } else { 1 };
            let table = source.peek().and_then(|line| line.first().copied());
            if table.is_some_and(|w| w.eq_ignore_ascii_case(b"LOOKUP_TABLE")) {
                source.words();
            }
            array(source, parts, Announced { about, name, kind, width, rows })
        }
        b"COLOR_SCALARS" => {
            parts.other_arrays = true;
            let width = number(source, word(2))?;
            source.skip(Type::BYTE, width.saturating_mul(rows))
        }
        b"LOOKUP_TABLE" => {
            let size = number(source, word(2))?;
            source.skip(Type::BYTE, size.saturating_mul(4))
        }
        b"VECTORS" | b"NORMALS" => {
            let kind = source.kind(word(2))?;
            array(source, parts, Announced { about, name, kind, width: 3, rows })
        }
        b"TENSORS" | b"TENSORS6" => {
            let kind = source.kind(word(2))?;
            let width = if word(0).ends_with(b"6") { 6 } else { 9 };
            array(source, parts, Announced { about, name, kind, width, rows })
        }
        b"TEXTURE_COORDINATES" => {
            let kind = source.kind(word(3))?;
            let width = number(source, word(2))?;
            array(source, parts, Announced { about, name, kind, width, rows })
        }
        b"GLOBAL_IDS" | b"PEDIGREE_IDS" | b"EDGE_FLAGS" => {
            let kind = source.kind(word(2))?;
            array(source, parts, Announced { about, name, kind, width: 1, rows })
        }
        b"FIELD" => {
            let arrays = number(source, word(2))?;
            // At most as many turns as there are lines.
            for _ in 0..arrays {
                let mut line = source.words().unwrap_or_default();
                if line.first().is_some_and(|w| w.eq_ignore_ascii_case(b"METADATA")) {
                    while source.raw_line().is_some_and(|line| !line.is_empty()) {}
                    line = source.words().unwrap_or_default();
                }
                let [name, width, rows, kind] = line.as_slice() else {
                    return Err(source.syntax("expected name, components, tuples and type"));
                };
                let (width, rows) = (number(source, width)?, number(source, rows)?);
                let kind = source.kind(kind)?;
                array(source, parts, Announced { about, name, kind, width, rows })?;
            }
            Ok(())
        }
        _ => Err(source.syntax(format!("`{}` where a section was expected", excerpt(words[0])))),
    }
}

/// An array of data, as a file announces it.
struct Announced<'a> {
    about: About,
    name: &'a [u8],
    kind: Type,
    width: u64,
    rows: u64,
}

/// Reads an array of data if it is one that is wanted.
fn array(
    source: &mut Source<'_>,
    parts: &mut Parts,
    announced: Announced<'_>,
) -> Result<(), ParseError> {
    let Announced { about, name, kind, width, rows } = announced;
    if (about, name, width) == (About::Cells, b"attribute", 1) && !kind.is_whole() {
        if parts.attributes.is_some() {
            return Err(source.syntax("the same array twice"));
        }
        parts.attributes = Some(source.floats(kind, rows)?);
        return Ok(());
    }
    let list = match (about, name) {
        (About::Points, b"tag") => Some(&mut parts.tags),
        (About::Cells, b"region") => Some(&mut parts.regions),
        (About::Cells, b"marker") => Some(&mut parts.markers),
        (About::Cells, b"cell_scalars") if !parts.is_surface => Some(&mut parts.scalars),
        _ => None,
    };
    match list {
        Some(list) if width == 1 && kind.is_whole() => {
            if list.is_some() {
                return Err(source.syntax("the same array twice"));
            }
            *list = Some(source.integers(kind, rows)?);
            Ok(())
        }
        _ => {
            parts.other_arrays |= about != About::Other;
            source.skip(kind, width.saturating_mul(rows))
        }
    }
}
