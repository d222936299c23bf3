//! `.ply`: the Stanford polygon format, read and written as points or as a surface.
//!
//! Read: versions `ascii`, `binary_little_endian` and `binary_big_endian` 1.0. The element
//! `vertex` with the properties `x`, `y` and `z` of any number type is the points; a property
//! `tag` whose values are whole numbers is their tags. Other elements and properties are not read;
//! a note says so. For a domain (in `faces.rs`) the element `face` with the list `vertex_indices`
//! or `vertex_index` is read as well, and an integer property `marker`, or else `part`, `group`,
//! `label`, `material_index` or colours, whose values are groups of faces if there are several; and
//! so are the elements `tristrips` and `trifans`, whose lists hold strips or fans of triangles with
//! -1 between them.
//! Written: properties of type
//! `double`; tags as `int` where they fit, else as `double` (the format has no integers of 64
//! bits).
//! Source: G. Turk, "The PLY Polygon File Format", 1994.

use super::error::{ParseError, Place, Reason, excerpt};
use super::scalar::{Kind, Scalar, exact_integer};
use super::text::{Tokens, capacity, count, float, push_integer, push_point, write_rows};
use super::{Encoding, Point, PointFile};
use std::io::Write;

mod faces;
pub use faces::read_domain;
pub(super) use faces::write_surface;

/// The meaning of a property of a vertex or a face.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Role {
    Axis(usize),
    Tag,
    /// A list: the corners of a face.
    Corners,
    Marker,
    /// The group of a face, by this word and a number.
    Group(&'static str),
    /// A part of a colour.
    Colour(usize),
    Other,
}

impl Role {
    /// May an element have only one such property?
    fn is_single(self) -> bool {
        !matches!(self, Self::Other | Self::Group(_) | Self::Colour(_))
    }
}

/// A property of an element.
#[derive(Debug)]
struct Property {
    role: Role,
    /// The type of the length, if the property is a list.
    length: Option<Scalar>,
    scalar: Scalar,
}

/// The things that an element lists.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Rows {
    Vertices,
    Faces,
    /// Strips of triangles.
    Strips,
    /// Fans of triangles.
    Fans,
    Others,
}

/// An element: a table with a row for each of its things.
#[derive(Debug)]
struct Element {
    holds: Rows,
    rows: u64,
    properties: Vec<Property>,
}

/// The header of a file.
#[derive(Debug)]
struct Header {
    ascii: bool,
    elements: Vec<Element>,
    /// The offset of the data.
    body: usize,
}

/// Reads a `.ply` file.
pub fn read(bytes: &[u8]) -> Result<PointFile, ParseError> {
    let header = header(bytes)?;
    let mut body = if header.ascii {
        Body::Text(Tokens::starting_at(bytes, header.body))
    } else {
        Body::Binary { bytes, next: header.body }
    };
    // The vertices are looked for behind what precedes them; what follows them is not read.
    for (k, element) in header.elements.iter().enumerate() {
        if element.holds == Rows::Vertices {
            let mut file = vertices(&mut body, element)?;
            if k + 1 == header.elements.len() {
                body.finish()?;
            }
            if header.elements.len() > 1 {
                file.notes.push("elements other than `vertex` are not read".to_owned());
            }
            return Ok(file);
        }
        skip_rows(&mut body, element)?;
    }
    Err(ParseError::new(Place::Header, Reason::Syntax("there is no element `vertex`".into())))
}

/// Skips an element.
fn skip_rows(body: &mut Body<'_>, element: &Element) -> Result<(), ParseError> {
    let announced = element.rows;
    for found in 0..announced {
        let early = Reason::Truncated { what: "rows", announced, found };
        for property in &element.properties {
            body.skip(property).map_err(|r| body.error(body_error(r, &early)))?;
        }
    }
    Ok(())
}

/// The reason itself, or `early` when it is that the file ended.
fn body_error(reason: Option<Reason>, early: &Reason) -> Reason {
    reason.unwrap_or_else(|| early.clone())
}

/// Reads the header: lines of text, also in binary files.
fn header(bytes: &[u8]) -> Result<Header, ParseError> {
    let (mut ascii, mut big_endian) = (None, false);
    let mut elements: Vec<Element> = Vec::new();
    let mut next = 0;
    // Every turn consumes a line.
    loop {
        let at = |reason| ParseError::at(bytes, next, reason);
        let rest = &bytes[next..];
        let Some(length) = rest.iter().position(|&b| b == b'\n') else {
            return Err(at(Reason::Syntax("the file ends inside the header".into())));
        };
        let words: Vec<&[u8]> =
            rest[..length].split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect();
        match words.as_slice() {
            [b"ply"] if next == 0 => {}
            _ if next == 0 => return Err(at(Reason::Syntax("not a PLY file".into()))),
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", form, b"1.0"] if ascii.is_none() => {
                big_endian = *form == b"binary_big_endian";
                ascii = Some(match *form {
                    b"ascii" => true,
                    b"binary_little_endian" | b"binary_big_endian" => false,
                    other => {
                        let text = format!("format `{}`", excerpt(other));
                        return Err(at(Reason::Unsupported(text)));
                    }
                });
            }
            [b"element", name, rows] => elements.push(Element {
                holds: match *name {
                    b"vertex" => Rows::Vertices,
                    b"face" => Rows::Faces,
                    b"tristrips" => Rows::Strips,
                    b"trifans" => Rows::Fans,
                    _ => Rows::Others,
                },
                rows: count(rows).map_err(at)?,
                properties: Vec::new(),
            }),
            [b"property", words @ ..] => {
                let Some(element) = elements.last_mut() else {
                    return Err(at(Reason::Syntax("a property before the first element".into())));
                };
                let property = property(words, big_endian).map_err(at)?;
                let twice = element.properties.iter().any(|p| p.role == property.role);
                if element.holds == Rows::Vertices && twice && property.role.is_single() {
                    return Err(at(Reason::Syntax("the same property twice".into())));
                }
                element.properties.push(property);
            }
            [b"end_header"] => {
                let body = next + length + 1;
                return finished(Header { ascii: ascii.unwrap_or(true), elements, body }, ascii);
            }
            _ => {
                let text =
                    format!("`{}` is no line of a header", excerpt(rest[..length].trim_ascii()));
                return Err(at(Reason::Syntax(text)));
            }
        }
        next += length + 1;
    }
}

/// Checks a header as a whole.
fn finished(header: Header, ascii: Option<bool>) -> Result<Header, ParseError> {
    let wrong = |text: &str| ParseError::new(Place::Header, Reason::Syntax(text.to_owned()));
    if ascii.is_none() {
        return Err(wrong("there is no line `format`"));
    }
    // A row without properties takes no bytes: any number of them could be announced.
    if header.elements.iter().any(|e| e.properties.is_empty() && e.rows > 0) {
        return Err(wrong("an element has no properties"));
    }
    for vertex in header.elements.iter().filter(|e| e.holds == Rows::Vertices) {
        let has = |role| vertex.properties.iter().any(|p| p.role == role);
        if !(0..3).all(|k| has(Role::Axis(k))) {
            return Err(wrong("vertices need the properties x, y and z"));
        }
    }
    Ok(header)
}

/// A property: `type name`, or `list type type name`.
fn property(words: &[&[u8]], big_endian: bool) -> Result<Property, Reason> {
    let (length, kind, name) = match words {
        [b"list", length, kind, name] => (Some(*length), *kind, *name),
        [kind, name] => (None, *kind, *name),
        _ => {
            return Err(Reason::Syntax(
                "a property is `type name` or `list type type name`".into(),
            ));
        }
    };
    let length = length.map(|l| scalar(l, big_endian)).transpose()?;
    if length.is_some_and(|l| l.kind == Kind::Float) {
        return Err(Reason::Syntax("the length of a list is an integer".into()));
    }
    let role = match name {
        b"vertex_indices" | b"vertex_index" if length.is_some() => Role::Corners,
        _ if length.is_some() => Role::Other,
        b"marker" => Role::Marker,
        b"red" => Role::Colour(0),
        b"green" => Role::Colour(1),
        b"blue" => Role::Colour(2),
        b"part" => Role::Group("part"),
        b"group" => Role::Group("group"),
        b"label" => Role::Group("label"),
        b"material_index" => Role::Group("material"),
        b"x" => Role::Axis(0),
        b"y" => Role::Axis(1),
        b"z" => Role::Axis(2),
        b"tag" => Role::Tag,
        _ => Role::Other,
    };
    Ok(Property { role, length, scalar: scalar(kind, big_endian)? })
}

fn scalar(name: &[u8], big_endian: bool) -> Result<Scalar, Reason> {
    let (kind, bytes) = match name {
        b"char" | b"int8" => (Kind::Signed, 1),
        b"uchar" | b"uint8" => (Kind::Unsigned, 1),
        b"short" | b"int16" => (Kind::Signed, 2),
        b"ushort" | b"uint16" => (Kind::Unsigned, 2),
        b"int" | b"int32" => (Kind::Signed, 4),
        b"uint" | b"uint32" => (Kind::Unsigned, 4),
        // Not in the format's description, but some programs write them.
        b"int64" => (Kind::Signed, 8),
        b"uint64" => (Kind::Unsigned, 8),
        b"float" | b"float32" => (Kind::Float, 4),
        b"double" | b"float64" => (Kind::Float, 8),
        other => return Err(Reason::Syntax(format!("`{}` is no type", excerpt(other)))),
    };
    Ok(Scalar { kind, bytes, big_endian })
}

/// The data behind a header. Its errors are `None` where the file ends.
enum Body<'a> {
    Text(Tokens<'a>),
    Binary { bytes: &'a [u8], next: usize },
}

impl Body<'_> {
    fn remaining(&self) -> usize {
        match self {
            Body::Text(tokens) => tokens.remaining(),
            Body::Binary { bytes, next } => bytes.len() - next,
        }
    }

    /// An error at the number that was read last.
    fn error(&self, reason: Reason) -> ParseError {
        self.error_at(self.position(), reason)
    }

    /// The offset behind the number that was read last.
    fn position(&self) -> usize {
        match self {
            Body::Text(tokens) => tokens.position(),
            Body::Binary { next, .. } => *next,
        }
    }

    /// An error at the number in front of an offset.
    fn error_at(&self, offset: usize, reason: Reason) -> ParseError {
        match self {
            Body::Text(tokens) => ParseError::at(tokens.bytes, offset.saturating_sub(1), reason),
            Body::Binary { .. } => ParseError::new(Place::Byte(offset as u64), reason),
        }
    }

    fn float(&mut self, scalar: Scalar) -> Result<f64, Option<Reason>> {
        match self {
            Body::Text(tokens) => float(tokens.next().ok_or(None)?).map_err(Some),
            Body::Binary { bytes, next } => {
                let end = *next + scalar.bytes;
                let raw = bytes.get(*next..end).ok_or(None)?;
                *next = end;
                scalar.float(raw).map_err(Some)
            }
        }
    }

    /// The number of values of a property: of a list it is read.
    fn length(&mut self, property: &Property) -> Result<u64, Option<Reason>> {
        let Some(length) = property.length else { return Ok(1) };
        let value = self.float(length)?;
        exact_integer(value)
            .and_then(|v| u64::try_from(v).ok())
            .ok_or_else(|| Some(Reason::Syntax(format!("a list of length {value}"))))
    }

    /// Skips a property; text is not looked at.
    fn skip(&mut self, property: &Property) -> Result<(), Option<Reason>> {
        let values = self.length(property)?;
        match self {
            // At most as many turns as there are tokens.
            Body::Text(tokens) => (0..values).try_for_each(|_| tokens.next().map(drop).ok_or(None)),
            Body::Binary { bytes, next } => {
                let length = usize::try_from(values)
                    .ok()
                    .and_then(|v| v.checked_mul(property.scalar.bytes))
                    .filter(|&l| l <= bytes.len() - *next)
                    .ok_or(None)?;
                *next += length;
                Ok(())
            }
        }
    }

    /// Checks that nothing follows.
    fn finish(&mut self) -> Result<(), ParseError> {
        let more = match self {
            Body::Text(tokens) => tokens.next().is_some(),
            Body::Binary { bytes, next } => *next < bytes.len(),
        };
        if more { Err(self.error(Reason::Surplus("element"))) } else { Ok(()) }
    }
}

/// Reads the element `vertex`.
fn vertices(body: &mut Body<'_>, element: &Element) -> Result<PointFile, ParseError> {
    let tagged = element.properties.iter().any(|p| p.role == Role::Tag);
    let reserve = capacity(element.rows, body.remaining(), 3);
    let mut points = Vec::with_capacity(reserve);
    let mut tags = Vec::with_capacity(if tagged { reserve } else { 0 });
    for row in 0..element.rows {
        let (p, tag) = vertex(body, element).map_err(|reason| {
            let announced = element.rows;
            let early = Reason::Truncated { what: "points", announced, found: row };
            match (reason, &*body) {
                (Some(reason), Body::Binary { .. }) => ParseError::new(Place::Point(row), reason),
                (None, Body::Binary { .. }) => ParseError::new(Place::End, early),
                (reason, Body::Text(_)) => body.error(body_error(reason, &early)),
            }
        })?;
        points.push(p);
        tags.extend(tag);
    }
    let mut file = PointFile { points, ..PointFile::default() };
    if element.properties.iter().any(|p| !matches!(p.role, Role::Axis(_) | Role::Tag)) {
        file.notes.push("properties of vertices other than x, y, z and tag are not read".into());
    }
    if tagged {
        let tags: Option<Vec<i64>> = tags.into_iter().map(exact_integer).collect();
        if tags.is_none() {
            file.notes.push("the property `tag` is not read: it is not integers".into());
        }
        file.point_tags = tags;
    }
    Ok(file)
}

fn vertex(body: &mut Body<'_>, element: &Element) -> Result<(Point, Option<f64>), Option<Reason>> {
    let (mut p, mut tag) = ([0.0; 3], None);
    for property in &element.properties {
        match property.role {
            Role::Axis(axis) => p[axis] = body.float(property.scalar)?,
            Role::Tag => tag = Some(body.float(property.scalar)?),
            _ => body.skip(property)?,
        }
    }
    Ok((p, tag))
}

/// The type in which tags are written.
fn tag_type(tags: &[i64]) -> &'static str {
    if tags.iter().all(|&t| i32::try_from(t).is_ok()) { "int" } else { "double" }
}

/// Writes the start of a header: the format, and points with their coordinates.
fn write_start(out: &mut dyn Write, points: usize, encoding: Encoding) -> std::io::Result<()> {
    let form = match encoding {
        Encoding::Ascii => "ascii",
        Encoding::Binary => "binary_little_endian",
    };
    write!(out, "ply\nformat {form} 1.0\nelement vertex {points}\n")?;
    ["x", "y", "z"].iter().try_for_each(|axis| writeln!(out, "property double {axis}"))
}

/// Writes a `.ply` file; binary is little endian.
///
/// # Errors
/// Those of `out`, and [`std::io::ErrorKind::InvalidInput`] for a tag that is neither a 32-bit
/// integer nor exactly a double.
pub fn write(
    out: &mut dyn Write,
    points: &[Point],
    tags: Option<&[i64]>,
    encoding: Encoding,
) -> std::io::Result<()> {
    super::float_tags("point", tags)?;
    write_start(out, points.len(), encoding)?;
    let kind = tags.map(tag_type);
    if let Some(kind) = kind {
        writeln!(out, "property {kind} tag")?;
    }
    out.write_all(b"end_header\n")?;
    write_rows(out, points.len(), |i, row| {
        let tag = tags.and_then(|t| t.get(i)).copied();
        match encoding {
            Encoding::Ascii => {
                push_point(row, &points[i], b' ');
                if let Some(tag) = tag {
                    row.push(b' ');
                    push_integer(row, tag);
                }
                row.push(b'\n');
            }
            Encoding::Binary => {
                points[i].iter().for_each(|c| row.extend(c.to_le_bytes()));
                match (tag, kind) {
                    (Some(tag), Some("int")) => row.extend((tag as i32).to_le_bytes()),
                    (Some(tag), _) => row.extend((tag as f64).to_le_bytes()),
                    (None, _) => {}
                }
            }
        }
    })
}
