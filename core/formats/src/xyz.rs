//! `.xyz`: one point on a line, coordinates separated by blanks.
//!
//! Blank lines and comments (from `#` to the end of the line) are skipped. Values after the third
//! (colours, normals) are not read; a note says so.

use super::error::{ParseError, Reason};
use super::text::{Line, Lines, point, push_point, write_rows};
use super::{Point, PointFile};
use std::io::Write;

/// Reads an `.xyz` file.
pub fn read(bytes: &[u8]) -> Result<PointFile, ParseError> {
    read_lines(bytes, Lines::new(bytes), parse)
}

/// The point of a line.
pub(super) fn parse(line: Line<'_>) -> Result<FirstPoint, Reason> {
    first_point(&mut line.fields())
}

/// The point at the start of a line.
pub(super) struct FirstPoint {
    pub(super) p: Point,
    /// Do more values follow?
    pub(super) has_more: bool,
}

/// The point at the start of a line of these fields.
pub(super) fn first_point<'a>(
    fields: &mut impl Iterator<Item = &'a [u8]>,
) -> Result<FirstPoint, Reason> {
    Ok(FirstPoint { p: point(fields, 0)?, has_more: fields.next().is_some() })
}

/// Reads lines of `bytes` with one point each, which `parse` takes as [`first_point`] does.
pub(super) fn read_lines(
    bytes: &[u8],
    lines: Lines<'_>,
    parse: impl Fn(Line<'_>) -> Result<FirstPoint, Reason>,
) -> Result<PointFile, ParseError> {
    let mut file = PointFile::default();
    let mut more = false;
    for line in lines {
        let parsed = parse(line).map_err(|r| ParseError::at(bytes, line.offset, r));
        let FirstPoint { p, has_more } = parsed?;
        more |= has_more;
        file.points.push(p);
    }
    if more {
        file.notes.push("values after the third on a line are not read".to_owned());
    }
    Ok(file)
}

/// Writes an `.xyz` file. The format has no place for tags.
pub fn write(out: &mut dyn Write, points: &[Point], _tags: Option<&[i64]>) -> std::io::Result<()> {
    write_rows(out, points.len(), |i, row| {
        push_point(row, &points[i], b' ');
        row.push(b'\n');
    })
}
