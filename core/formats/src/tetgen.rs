//! `.node`, `.ele` and `.face`: TetGen's points, tetrahedra and boundary triangles.
//!
//! A `.node` file has a header `points 3 attributes markers` and then for each point its number,
//! three coordinates, the attributes and, if `markers` is 1, a boundary marker (read as the
//! point's tag). Points are numbered from 0 or from 1. An `.ele` file has a header `tetrahedra
//! corners attributes` and for each tetrahedron its number, 4 corners (or 10, of which the first
//! four are read) and the attributes. The last is that of the region: read as the tag if it is an
//! integer everywhere, else as an attribute. From `#` to the end of a line is a comment. We write
//! numbers from 0, and attributes where the mesh has them, else tags.
//! Source: the TetGen manual, "File formats".

use super::curved::Curved;
use super::error::{ParseError, Reason};
use super::faces::{Marked, owned};
use super::text::{
    Line, Lines, capacity, count, float, integer, point, push_float, push_integer, push_point,
    write_rows,
};
use super::{MeshFile, Point, PointFile};
use ltbw_core::{BoundaryFace, TetMesh};
use std::io::Write;

/// A parsed `.node` file, and the number of its first point.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NodeFile {
    /// The points.
    pub file: PointFile,
    /// 0 or 1: the number of the first point.
    pub first: u8,
}

/// Reads a `.node` file.
pub fn read_node(bytes: &[u8]) -> Result<PointFile, ParseError> {
    parse_node(bytes).map(|n| n.file)
}

/// Reads a mesh from the contents of an `.ele` file and the `.node` file beside it.
pub fn read_pair(node: &[u8], ele: &[u8]) -> Result<MeshFile, ParseError> {
    parse_ele(ele, parse_node(node)?)
}

/// The counts in a header line: at most four, the missing ones 0.
fn header(bytes: &[u8], lines: &mut Lines<'_>) -> Result<[u64; 4], ParseError> {
    let line = lines
        .next()
        .ok_or_else(|| ParseError::at(bytes, bytes.len(), Reason::Syntax("no header".into())))?;
    let mut counts = [0; 4];
    for (k, field) in line.fields().enumerate() {
        let value = count(field).map_err(|r| ParseError::at(bytes, line.offset, r))?;
        match counts.get_mut(k) {
            Some(c) => *c = value,
            None => {
                let reason = Reason::TooManyValues { expected: counts.len() };
                return Err(ParseError::at(bytes, line.offset, reason));
            }
        }
    }
    Ok(counts)
}

/// A number in a header that is out of its range.
fn bad_header(bytes: &[u8], lines: &Lines<'_>, text: String) -> ParseError {
    ParseError::at(bytes, lines.position().saturating_sub(1), Reason::Unsupported(text))
}

/// Checks that a row carries the number that its place asks for; the first may be 0 or 1.
fn number(token: &[u8], what: &'static str, first: &mut i64, row: u64) -> Result<(), Reason> {
    let found = integer(token)?;
    if row == 0 && (found == 0 || found == 1) {
        *first = found;
    }
    let expected = *first as u64 + row;
    if u64::try_from(found) == Ok(expected) {
        Ok(())
    } else {
        Err(Reason::Numbering { what, expected, found })
    }
}

/// Parses a `.node` file.
pub fn parse_node(bytes: &[u8]) -> Result<NodeFile, ParseError> {
    let mut lines = Lines::new(bytes);
    let node = node_section(bytes, &mut lines)?;
    NodeHead::is_end(bytes, &mut lines)?;
    Ok(node)
}

/// The header of points, and the number of the first one.
#[derive(Debug, Clone)]
pub(super) struct NodeHead {
    announced: u64,
    attributes: u64,
    has_markers: bool,
    /// The number of the first point: that of the first line, if it is 0.
    first: i64,
}

/// The header of points, and the number of the first one; lines behind it stay.
pub(super) fn node_head(bytes: &[u8], lines: &mut Lines<'_>) -> Result<NodeHead, ParseError> {
    let [announced, dimension, attributes, markers] = header(bytes, lines)?;
    if dimension != 3 {
        return Err(bad_header(bytes, lines, format!("points in {dimension} dimensions")));
    }
    if markers > 1 || attributes > 1 << 16 {
        let text = format!("{attributes} attributes and {markers} markers for each point");
        return Err(bad_header(bytes, lines, text));
    }
    let row = Lines::from(bytes, (*lines).position()).next().filter(|_| announced > 0);
    let number = row.and_then(|line| integer(line.fields().next()?).ok());
    let first = if number == Some(0) { 0 } else { 1 };
    Ok(NodeHead { announced, attributes, has_markers: markers == 1, first })
}

impl NodeHead {
    /// The points of lines of `bytes`, the first of which is point number `row`, from 0, and as
    /// many as are announced at most.
    pub(super) fn points(
        &self,
        bytes: &[u8],
        lines: &mut Lines<'_>,
        row: u64,
    ) -> Result<PointFile, ParseError> {
        let mut file = PointFile::default();
        let reserve = capacity(self.announced.saturating_sub(row), lines.remaining(), 8);
        file.points.reserve(reserve);
        let mut tags = Vec::with_capacity(if self.has_markers { reserve } else { 0 });
        for row in row..self.announced {
            let Some(line) = lines.next() else { break };
            let (p, tag) =
                self.row(line, row).map_err(|r| ParseError::at(bytes, line.offset, r))?;
            file.points.push(p);
            tags.extend(tag);
        }
        file.point_tags = self.has_markers.then_some(tags);
        if self.attributes > 0 {
            file.notes.push("attributes of points are not read".to_owned());
        }
        Ok(file)
    }

    /// Makes sure that `found` lines of points, up to the end of `bytes`, are all.
    pub(super) fn is_whole(&self, bytes: &[u8], found: u64) -> Result<(), ParseError> {
        if found >= self.announced {
            return Ok(());
        }
        let reason = Reason::Truncated { what: "points", announced: self.announced, found };
        Err(ParseError::at(bytes, bytes.len(), reason))
    }

    /// Makes sure that no line is left.
    pub(super) fn is_end(bytes: &[u8], lines: &mut Lines<'_>) -> Result<(), ParseError> {
        match lines.next() {
            Some(line) => Err(ParseError::at(bytes, line.offset, Reason::Surplus("point"))),
            None => Ok(()),
        }
    }

    /// A line with the point of this number, from 0.
    fn row(&self, line: Line<'_>, row: u64) -> Result<(Point, Option<i64>), Reason> {
        let width = 4 + self.attributes as usize + usize::from(self.has_markers);
        let mut fields = line.fields();
        let (token, mut first) = (fields.next().unwrap_or_default(), self.first);
        number(token, "point", &mut first, row)?;
        let p = point(&mut fields, 1)?;
        let (mut tag, mut found) = (None, 4);
        for field in fields {
            found += 1;
            if found > width {
                return Err(Reason::TooManyValues { expected: width });
            } else if found == width && self.has_markers {
                tag = Some(integer(field)?);
            } else {
                float(field)?;
            }
        }
        match found < width {
            true => Err(Reason::TooFewValues { expected: width, found }),
            false => Ok((p, tag)),
        }
    }
}

/// Parses the points of a `.node` file, or those that a `.poly` or `.smesh` file starts with.
pub(super) fn node_section(bytes: &[u8], lines: &mut Lines<'_>) -> Result<NodeFile, ParseError> {
    let head = node_head(bytes, lines)?;
    let file = head.points(bytes, lines, 0)?;
    head.is_whole(bytes, file.points.len() as u64)?;
    Ok(NodeFile { file, first: head.first as u8 })
}

/// Parses an `.ele` file whose corners are the points of `node`.
pub fn parse_ele(bytes: &[u8], node: NodeFile) -> Result<MeshFile, ParseError> {
    let mut lines = Lines::new(bytes);
    let [announced, corners, attributes, more] = header(bytes, &mut lines)?;
    if !matches!(corners, 4 | 10) || attributes > 1 << 16 || more > 0 {
        let text = format!("{corners} corners and {attributes} attributes for each tetrahedron");
        return Err(bad_header(bytes, &lines, text));
    }
    let NodeFile { file: PointFile { points, point_tags, mut notes }, first } = node;
    let first = i64::from(first);
    let last = first + points.len() as i64 - 1;
    if u32::try_from(points.len()).is_err() {
        return Err(ParseError::at(bytes, 0, Reason::TooManyPoints(points.len() as u64)));
    }
    let reserve = capacity(announced, lines.remaining(), 10);
    let mut tets = Vec::with_capacity(reserve);
    let mut tags = Vec::with_capacity(if attributes > 0 { reserve } else { 0 });
    let mut values = Vec::with_capacity(if attributes > 0 { reserve } else { 0 });
    let (mut first_row, mut whole) = (first, true);
    let width = 1 + corners as usize + attributes as usize;
    for row in 0..announced {
        let Some(line) = lines.next() else {
            let reason = Reason::Truncated { what: "tetrahedra", announced, found: row };
            return Err(ParseError::at(bytes, bytes.len(), reason));
        };
        let at = |r| ParseError::at(bytes, line.offset, r);
        let mut found = 0;
        let mut tet = [0_u32; 4];
        for field in line.fields() {
            found += 1;
            match found {
                1 => number(field, "tetrahedron", &mut first_row, row).map_err(at)?,
                n if n > width => return Err(at(Reason::TooManyValues { expected: width })),
                n if n <= 1 + corners as usize => {
                    let index = integer(field).map_err(at)?;
                    if index < first || index > last {
                        let (what, number) = ("tetrahedron", first_row as u64 + row);
                        return Err(at(Reason::Index { what, number, index, first, last }));
                    }
                    if let Some(corner) = tet.get_mut(n - 2) {
                        *corner = (index - first) as u32;
                    }
                }
                n if n == width => {
                    let (value, region) = region(field).map_err(at)?;
                    whole &= region.is_some();
                    tags.push(region.unwrap_or(0));
                    values.push(value);
                }
                _ => drop(float(field).map_err(at)?),
            }
        }
        if found < width {
            return Err(at(Reason::TooFewValues { expected: width, found }));
        }
        tets.push(tet);
    }
    if let Some(line) = lines.next() {
        return Err(ParseError::at(bytes, line.offset, Reason::Surplus("tetrahedron")));
    }
    let tet_tags = (attributes > 0 && whole).then_some(tags);
    let tet_attributes = (attributes > 0 && !whole).then_some(values);
    if attributes > 1 {
        notes.push("attributes of tetrahedra before the last are not read".into());
    }
    let curved = Curved { tets: if corners == 10 { tets.len() } else { 0 }, triangles: 0 };
    notes.extend(curved.note());
    let mesh = TetMesh { points, tets, point_tags, tet_tags, tet_attributes, ..TetMesh::default() };
    Ok(MeshFile { mesh, notes, names: Vec::new() })
}

/// Parses a `.face` file beside the mesh of `file`, whose points are numbered from `first` (0 or
/// 1), and gives the mesh its boundary triangles.
pub fn parse_face(bytes: &[u8], mut file: MeshFile, first: u8) -> Result<MeshFile, ParseError> {
    let mut lines = Lines::new(bytes);
    let [announced, markers, more @ ..] = header(bytes, &mut lines)?;
    if markers > 1 {
        let text = format!("{markers} markers for each triangle");
        return Err(bad_header(bytes, &lines, text));
    }
    if more != [0; 2] {
        let text = "a header of more than two values".to_owned();
        return Err(bad_header(bytes, &lines, text));
    }
    let first = i64::from(first);
    let last = first + file.mesh.points.len() as i64 - 1;
    let mut triangles = Vec::with_capacity(capacity(announced, lines.remaining(), 8));
    let mut first_row = first;
    // The header does not tell the corners of a row and its tetrahedra: the first row does.
    let (mut corners, mut tets) = (3, 0);
    for row in 0..announced {
        let Some(line) = lines.next() else {
            let reason = Reason::Truncated { what: "triangles", announced, found: row };
            return Err(ParseError::at(bytes, bytes.len(), reason));
        };
        let at = |r| ParseError::at(bytes, line.offset, r);
        if row == 0 {
            let beyond = line.fields().count().saturating_sub(4 + markers as usize);
            (corners, tets) = match beyond {
                2 => (3, 2),
                3 => (6, 0),
                5 => (6, 2),
                _ => (3, 0),
            };
        }
        let width = 1 + corners + markers as usize + tets;
        let (mut triangle, mut marker, mut found) = ([0_u32; 3], 0, 0);
        for field in line.fields() {
            found += 1;
            let value = integer(field).map_err(at)?;
            match found {
                1 => number(field, "triangle", &mut first_row, row).map_err(at)?,
                n if n > width => return Err(at(Reason::TooManyValues { expected: width })),
                n if n <= 1 + corners => {
                    if value < first || value > last {
                        let (what, number) = ("triangle", first_row as u64 + row);
                        return Err(at(Reason::Index { what, number, index: value, first, last }));
                    }
                    if let Some(corner) = triangle.get_mut(n - 2) {
                        *corner = (value - first) as u32;
                    }
                }
                n if markers == 1 && n == 2 + corners => marker = value,
                _ => {}
            }
        }
        if found < width {
            return Err(at(Reason::TooFewValues { expected: width, found }));
        }
        triangles.push(Marked { corners: triangle, marker });
    }
    if let Some(line) = lines.next() {
        return Err(ParseError::at(bytes, line.offset, Reason::Surplus("triangle")));
    }
    let curved = Curved { tets: 0, triangles: if corners == 6 { triangles.len() } else { 0 } };
    file.notes.extend(curved.note());
    if tets > 0 {
        file.notes.push("tetrahedra of triangles are not read".to_owned());
    }
    let (faces, note) = owned(&file.mesh, &triangles);
    file.mesh.faces = faces;
    file.notes.extend(note);
    Ok(file)
}

/// An attribute of a region, and the integer that it is, also when written as a float.
fn region(token: &[u8]) -> Result<(f64, Option<i64>), Reason> {
    if let Ok(value) = integer(token) {
        return Ok((value as f64, Some(value)));
    }
    let value = float(token)?;
    let exact = value.fract() == 0.0 && value.abs() <= 9_007_199_254_740_992.0;
    Ok((value, exact.then_some(value as i64)))
}

/// Writes a `.node` file, numbered from 0.
pub fn write_node(
    out: &mut dyn Write,
    points: &[Point],
    tags: Option<&[i64]>,
) -> std::io::Result<()> {
    writeln!(out, "{} 3 0 {}", points.len(), u8::from(tags.is_some()))?;
    write_rows(out, points.len(), |i, row| {
        push_integer(row, i as i64);
        row.push(b' ');
        push_point(row, &points[i], b' ');
        if let Some(&tag) = tags.and_then(|t| t.get(i)) {
            row.push(b' ');
            push_integer(row, tag);
        }
        row.push(b'\n');
    })
}

/// Reads an `.mtr` file, TetGen's edge lengths at points: a header `points 1`, then for each point
/// a number.
pub fn read_mtr(bytes: &[u8]) -> Result<Vec<f64>, ParseError> {
    let mut lines = Lines::new(bytes);
    let [announced, metrics, ..] = header(bytes, &mut lines)?;
    if metrics != 1 {
        let text = format!("{metrics} values for a point; only one is understood");
        return Err(bad_header(bytes, &lines, text));
    }
    let mut sizes = Vec::with_capacity(capacity(announced, bytes.len(), 2));
    for line in lines {
        let at = |reason| ParseError::at(bytes, line.offset, reason);
        if sizes.len() as u64 == announced {
            return Err(at(Reason::Surplus("size")));
        }
        let mut fields = line.fields();
        let field = fields.next().ok_or(Reason::TooFewValues { expected: 1, found: 0 });
        sizes.push(field.and_then(float).map_err(at)?);
        if fields.next().is_some() {
            return Err(at(Reason::TooManyValues { expected: 1 }));
        }
    }
    let found = sizes.len() as u64;
    if found < announced {
        let reason = Reason::Truncated { what: "sizes", announced, found };
        return Err(ParseError::at(bytes, bytes.len(), reason));
    }
    Ok(sizes)
}

/// Writes an `.ele` file, numbered from 0: with attributes, or else with tags.
pub fn write_ele(out: &mut dyn Write, mesh: &TetMesh) -> std::io::Result<()> {
    let (tags, attributes) = (mesh.tet_tags.as_deref(), mesh.tet_attributes.as_deref());
    let columns = u8::from(tags.is_some() || attributes.is_some());
    writeln!(out, "{} 4 {columns}", mesh.tets.len())?;
    write_rows(out, mesh.tets.len(), |i, row| {
        push_integer(row, i as i64);
        for &v in &mesh.tets[i] {
            row.push(b' ');
            push_integer(row, i64::from(v));
        }
        if let Some(&value) = attributes.and_then(|a| a.get(i)) {
            row.push(b' ');
            push_float(row, value);
        } else if let Some(&tag) = tags.and_then(|t| t.get(i)) {
            row.push(b' ');
            push_integer(row, tag);
        }
        row.push(b'\n');
    })
}

/// Writes a `.face` file: boundary triangles with their markers, numbered from 0.
pub fn write_face(out: &mut dyn Write, faces: &[BoundaryFace]) -> std::io::Result<()> {
    writeln!(out, "{} 1", faces.len())?;
    write_rows(out, faces.len(), |i, row| {
        push_integer(row, i as i64);
        for value in faces[i].corners.map(i64::from).into_iter().chain([faces[i].marker]) {
            row.push(b' ');
            push_integer(row, value);
        }
        row.push(b'\n');
    })
}
