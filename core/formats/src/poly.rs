//! `.poly` and `.smesh`: TetGen's domains.
//!
//! Four parts, each with its count first:
//!
//! 1. points, as in a `.node` file; a count of 0 means the `.node` file beside this one;
//! 2. facets: `facets markers`. In a `.poly` file for each facet `polygons holes marker`, then its
//!    polygons `corners v1 v2 …` (which may go on in the next lines), then its hole points
//!    `number x y z`. In an `.smesh` file a facet is one polygon: `corners v1 v2 … marker`;
//! 3. holes: `number x y z`;
//! 4. regions: `number x y z attribute volume`; may be missing. A volume that is missing or not
//!    positive is no bound.
//!
//! Points are numbered from 0 or from 1. A facet that is a single polygon of two vertices is a
//! free-standing segment. From `#` to the end of a line is a comment. We write numbers from 0.
//! Source: the TetGen manual, "File formats".

use super::DomainFile;
use super::error::{DataError, ParseError, Reason};
use super::tetgen::{NodeFile, node_section};
use super::text::{
    Line, Lines, capacity, count, float, integer, point, push_float, push_integer, push_point,
    write_rows,
};
use ltbw_domain::{Domain, Facet, Region};
use std::io::Write;

/// The layout of a facet, which tells the two formats apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layout {
    Poly,
    Smesh,
}

/// Reads a `.poly` file that holds its points.
pub fn read_poly(bytes: &[u8]) -> Result<DomainFile, ParseError> {
    read(bytes, Layout::Poly, None)
}

/// Reads an `.smesh` file that holds its points.
pub fn read_smesh(bytes: &[u8]) -> Result<DomainFile, ParseError> {
    read(bytes, Layout::Smesh, None)
}

/// Reads a `.poly` file whose points are in a `.node` file.
pub fn read_poly_with(bytes: &[u8], node: NodeFile) -> Result<DomainFile, ParseError> {
    read(bytes, Layout::Poly, Some(node))
}

/// Reads an `.smesh` file whose points are in a `.node` file.
pub fn read_smesh_with(bytes: &[u8], node: NodeFile) -> Result<DomainFile, ParseError> {
    read(bytes, Layout::Smesh, Some(node))
}

/// Whether the points are in a `.node` file beside this one: it announces no points.
pub fn needs_node(bytes: &[u8]) -> bool {
    let first = Lines::new(bytes).next();
    first.and_then(|l| l.fields().next()).is_some_and(|t| count(t) == Ok(0))
}

/// A file on the way from its text to a domain.
struct Reader<'a> {
    bytes: &'a [u8],
    lines: Lines<'a>,
    /// The number of the first point.
    first: i64,
    points: usize,
}

fn read(bytes: &[u8], layout: Layout, node: Option<NodeFile>) -> Result<DomainFile, ParseError> {
    let mut lines = Lines::new(bytes);
    let outside = match node {
        Some(node) => {
            lines.next();
            node
        }
        None => node_section(bytes, &mut lines)?,
    };
    let points = outside.file.points.len();
    let mut reader = Reader { bytes, lines, first: i64::from(outside.first), points };
    let mut domain = Domain { vertices: outside.file.points, ..Domain::default() };
    reader.facets(layout, &mut domain)?;
    domain.holes = reader.rows("holes", |_, fields| point(fields, 1))?;
    domain.regions = reader.rows("regions", region)?;
    if let Some(line) = reader.lines.next() {
        return Err(ParseError::at(bytes, line.offset, Reason::Surplus("region")));
    }
    let mut notes = outside.file.notes;
    if outside.file.point_tags.is_some() {
        notes.push("markers of points are not read".to_owned());
    }
    Ok(DomainFile { domain, oriented: false, notes, ..DomainFile::default() })
}

/// The values of a row behind its number.
type Values<'a> = std::vec::IntoIter<&'a [u8]>;

fn region(found: usize, fields: &mut Values<'_>) -> Result<Region, Reason> {
    let seed = point(fields, 1)?;
    let attribute = fields.next().ok_or(Reason::TooFewValues { expected: 5, found })?;
    let volume = fields.next().map(float).transpose()?;
    Ok(Region { seed, attribute: float(attribute)?, max_volume: volume.filter(|&v| v > 0.0) })
}

impl<'a> Reader<'a> {
    fn next(
        &mut self,
        what: &'static str,
        announced: u64,
        found: u64,
    ) -> Result<Line<'a>, ParseError> {
        let reason = Reason::Truncated { what, announced, found };
        self.lines.next().ok_or_else(|| ParseError::at(self.bytes, self.bytes.len(), reason))
    }

    fn facets(&mut self, layout: Layout, domain: &mut Domain) -> Result<(), ParseError> {
        let no_facets = || Reason::Syntax("the file ends before its facets".into());
        let head = self
            .lines
            .next()
            .ok_or_else(|| ParseError::at(self.bytes, self.bytes.len(), no_facets()))?;
        let at = |r| ParseError::at(self.bytes, head.offset, r);
        let mut fields = head.fields();
        let announced = count(fields.next().unwrap_or_default()).map_err(at)?;
        let marked = fields.next().map(integer).transpose().map_err(at)?.unwrap_or(0) != 0;
        if fields.next().is_some() {
            return Err(at(Reason::TooManyValues { expected: 2 }));
        }
        domain.facets.reserve(capacity(announced, self.lines.remaining(), 6));
        for found in 0..announced {
            let facet = match layout {
                Layout::Poly => self.poly_facet(announced, found)?,
                Layout::Smesh => self.smesh_facet(announced, found, marked)?,
            };
            match facet.polygons.as_slice() {
                [ends] if ends.len() == 2 && facet.holes.is_empty() => {
                    domain.segments.push(([ends[0], ends[1]], facet.marker));
                }
                _ => domain.facets.push(facet),
            }
        }
        Ok(())
    }

    /// `polygons [holes] [marker]`, then polygons and holes.
    fn poly_facet(&mut self, announced: u64, found: u64) -> Result<Facet, ParseError> {
        let line = self.next("facets", announced, found)?;
        let at = |r| ParseError::at(self.bytes, line.offset, r);
        let mut fields = line.fields();
        let polygons = count(fields.next().unwrap_or_default()).map_err(at)?;
        let holes = fields.next().map(count).transpose().map_err(at)?.unwrap_or(0);
        let marker = fields.next().map(marker).transpose().map_err(at)?.unwrap_or(0);
        if fields.next().is_some() {
            return Err(at(Reason::TooManyValues { expected: 3 }));
        }
        let mut facet = Facet { marker, ..Facet::default() };
        for p in 0..polygons {
            let line = self.next("polygons", polygons, p)?;
            let (corners, rest) = self.corners(line, found)?;
            if rest.is_some() {
                let expected = corners.len() + 1;
                let reason = Reason::TooManyValues { expected };
                return Err(ParseError::at(self.bytes, line.offset, reason));
            }
            facet.polygons.push(corners);
        }
        for h in 0..holes {
            let line = self.next("holes of a facet", holes, h)?;
            let at = |r| ParseError::at(self.bytes, line.offset, r);
            let mut fields = line.fields();
            float(fields.next().unwrap_or_default()).map_err(at)?;
            facet.holes.push(point(&mut fields, 1).map_err(at)?);
            if fields.next().is_some() {
                return Err(at(Reason::TooManyValues { expected: 4 }));
            }
        }
        Ok(facet)
    }

    /// `corners v1 v2 … [marker]`.
    fn smesh_facet(
        &mut self,
        announced: u64,
        found: u64,
        marked: bool,
    ) -> Result<Facet, ParseError> {
        let line = self.next("facets", announced, found)?;
        let (corners, rest) = self.corners(line, found)?;
        let mut facet = Facet::polygon(&corners, 0);
        let at = |r| ParseError::at(self.bytes, line.offset, r);
        match rest {
            Some(token) if marked => facet.marker = marker(token).map_err(at)?,
            Some(_) => return Err(at(Reason::TooManyValues { expected: corners.len() + 1 })),
            None => {}
        }
        Ok(facet)
    }

    /// The corners of a polygon whose count starts `line`; they may go on in the next lines. Also
    /// the value behind the last one, if there is one.
    fn corners(
        &mut self,
        line: Line<'a>,
        facet: u64,
    ) -> Result<(Vec<u32>, Option<&'a [u8]>), ParseError> {
        let at = |line: &Line<'_>, r| ParseError::at(self.bytes, line.offset, r);
        let mut fields = line.fields();
        let wanted = count(fields.next().unwrap_or_default()).map_err(|r| at(&line, r))?;
        let mut corners = Vec::with_capacity(capacity(wanted, line.text.len(), 2));
        let (first, last) = (self.first, self.first + self.points as i64 - 1);
        let mut line = line;
        // Every turn takes a field or a line.
        while (corners.len() as u64) < wanted {
            let Some(token) = fields.next() else {
                let found = corners.len() as u64;
                let reason = Reason::Truncated { what: "corners", announced: wanted, found };
                line = self
                    .lines
                    .next()
                    .ok_or_else(|| ParseError::at(self.bytes, self.bytes.len(), reason))?;
                fields = line.fields();
                continue;
            };
            let index = integer(token).map_err(|r| at(&line, r))?;
            if index < first || index > last {
                let reason = Reason::Index { what: "facet", number: facet, index, first, last };
                return Err(at(&line, reason));
            }
            corners.push((index - first) as u32);
        }
        if corners.len() < 2 {
            let text = format!("a polygon of {} corners", corners.len());
            return Err(at(&line, Reason::Syntax(text)));
        }
        Ok((corners, fields.next()))
    }

    /// A part that is a count and as many numbered rows. A part that is missing has none.
    fn rows<T>(
        &mut self,
        what: &'static str,
        row: impl Fn(usize, &mut Values<'a>) -> Result<T, Reason>,
    ) -> Result<Vec<T>, ParseError> {
        let Some(head) = self.lines.next() else { return Ok(Vec::new()) };
        let mut fields = head.fields();
        let announced = count(fields.next().unwrap_or_default())
            .map_err(|r| ParseError::at(self.bytes, head.offset, r))?;
        let mut rows = Vec::with_capacity(capacity(announced, self.lines.remaining(), 8));
        for found in 0..announced {
            let line = self.next(what, announced, found)?;
            let at = |r| ParseError::at(self.bytes, line.offset, r);
            let values = line.fields().count();
            let mut fields = line.fields().collect::<Vec<_>>().into_iter();
            float(fields.next().unwrap_or_default()).map_err(at)?;
            rows.push(row(values, &mut fields).map_err(at)?);
            if fields.next().is_some() {
                return Err(at(Reason::TooManyValues { expected: values - 1 }));
            }
        }
        Ok(rows)
    }
}

/// A boundary marker.
fn marker(token: &[u8]) -> Result<i32, Reason> {
    let value = integer(token)?;
    i32::try_from(value).map_err(|_| Reason::NotAnInteger(value.to_string()))
}

/// Writes a `.poly` file, numbered from 0. It keeps all of a domain.
pub fn write_poly(out: &mut dyn Write, domain: &Domain) -> std::io::Result<()> {
    write_points(out, domain)?;
    let (facets, segments) = (&domain.facets, &domain.segments);
    writeln!(out, "{} 1", facets.len() + segments.len())?;
    write_rows(out, facets.len(), |i, row| {
        let facet = &facets[i];
        push_integer(row, facet.polygons.len() as i64);
        row.push(b' ');
        push_integer(row, facet.holes.len() as i64);
        row.push(b' ');
        push_integer(row, i64::from(facet.marker));
        row.push(b'\n');
        facet.polygons.iter().for_each(|p| push_corners(row, p, None));
        for (h, p) in facet.holes.iter().enumerate() {
            push_integer(row, h as i64);
            row.push(b' ');
            push_point(row, p, b' ');
            row.push(b'\n');
        }
    })?;
    for (ends, marker) in segments {
        writeln!(out, "1 0 {marker}\n2 {} {}", ends[0], ends[1])?;
    }
    write_seeds(out, domain)
}

/// The first facet that an `.smesh` file cannot hold: it is not a single polygon.
pub(super) fn check_smesh(domain: &Domain) -> Result<(), DataError> {
    let parts = |f: &Facet| f.polygons.len() != 1 || !f.holes.is_empty();
    match (0..).zip(&domain.facets).find(|(_, f)| parts(f)) {
        Some((facet, _)) => Err(DataError::FacetParts { facet }),
        None => Ok(()),
    }
}

/// Writes an `.smesh` file, numbered from 0.
///
/// # Errors
/// Those of `out`, and [`std::io::ErrorKind::InvalidInput`] for a facet that is not one polygon.
pub fn write_smesh(out: &mut dyn Write, domain: &Domain) -> std::io::Result<()> {
    let invalid = |e| std::io::Error::new(std::io::ErrorKind::InvalidInput, e);
    check_smesh(domain).map_err(invalid)?;
    let (facets, segments) = (&domain.facets, &domain.segments);
    write_points(out, domain)?;
    writeln!(out, "{} 1", facets.len() + segments.len())?;
    write_rows(out, facets.len(), |i, row| {
        push_corners(row, &facets[i].polygons[0], Some(facets[i].marker));
    })?;
    for (ends, marker) in segments {
        writeln!(out, "2 {} {} {marker}", ends[0], ends[1])?;
    }
    write_seeds(out, domain)
}

fn push_corners(row: &mut Vec<u8>, corners: &[u32], marker: Option<i32>) {
    push_integer(row, corners.len() as i64);
    for &v in corners {
        row.push(b' ');
        push_integer(row, i64::from(v));
    }
    if let Some(marker) = marker {
        row.push(b' ');
        push_integer(row, i64::from(marker));
    }
    row.push(b'\n');
}

fn write_points(out: &mut dyn Write, domain: &Domain) -> std::io::Result<()> {
    let points: Vec<ltbw_core::Point> =
        domain.vertices.iter().chain(&domain.points).copied().collect();
    super::tetgen::write_node(out, &points, None)
}

/// Holes and regions.
fn write_seeds(out: &mut dyn Write, domain: &Domain) -> std::io::Result<()> {
    let mut text = Vec::new();
    push_integer(&mut text, domain.holes.len() as i64);
    text.push(b'\n');
    for (h, p) in domain.holes.iter().enumerate() {
        push_integer(&mut text, h as i64);
        text.push(b' ');
        push_point(&mut text, p, b' ');
        text.push(b'\n');
    }
    push_integer(&mut text, domain.regions.len() as i64);
    text.push(b'\n');
    for (r, region) in domain.regions.iter().enumerate() {
        push_integer(&mut text, r as i64);
        text.push(b' ');
        push_point(&mut text, &region.seed, b' ');
        text.push(b' ');
        push_float(&mut text, region.attribute);
        if let Some(volume) = region.max_volume {
            text.push(b' ');
            push_float(&mut text, volume);
        }
        text.push(b'\n');
    }
    out.write_all(&text)
}
