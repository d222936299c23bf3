//! `.xyz`: one point on a line, coordinates separated by blanks.
//!
//! Blank lines and comments (from `#` to the end of the line) are skipped. Values after the third
//! (colours, normals) are not read; a note says so.

use super::error::ParseError;
use super::text::{Lines, point, push_point, write_rows};
use super::{Point, PointFile};
use std::io::Write;

/// Reads an `.xyz` file.
pub fn read(bytes: &[u8]) -> Result<PointFile, ParseError> {
    let mut file = PointFile::default();
    let mut more = false;
    for line in Lines::new(bytes) {
        let mut fields = line.fields();
        let p = point(&mut fields, 0).map_err(|r| ParseError::at(bytes, line.offset, r))?;
        more |= fields.next().is_some();
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
