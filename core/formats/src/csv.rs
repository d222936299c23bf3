//! `.csv`: columns separated by commas, semicolons or tabs, with or without a header line.
//!
//! With a header that names `x`, `y` and `z` (in any order and case) those columns are read, else
//! the first three. A column named `tag` holds integer tags. Other columns are not read; a note
//! says so. Fields may stand in double quotes. Lines starting with `#` and blank lines are
//! skipped. Numbers have a decimal point.

use super::error::{ParseError, Reason};
use super::text::{Line, Lines, float, integer, push_integer, push_point, write_rows};
use super::{Point, PointFile};
use std::io::Write;

/// The columns of the wanted values in a line.
#[derive(Debug, Clone)]
struct Columns {
    separator: u8,
    xyz: [usize; 3],
    tag: Option<usize>,
    /// The least number of fields of a line.
    width: usize,
}

impl Columns {
    /// The columns of a file without header.
    fn plain(separator: u8) -> Self {
        Self { separator, xyz: [0, 1, 2], tag: None, width: 3 }
    }

    /// The columns that a header line names.
    fn named(separator: u8, header: Line<'_>) -> Self {
        let names: Vec<&[u8]> = fields(header.text, separator).collect();
        let find = |name: &str| names.iter().position(|n| n.eq_ignore_ascii_case(name.as_bytes()));
        let tag = find("tag");
        let xyz = match (find("x"), find("y"), find("z")) {
            (Some(x), Some(y), Some(z)) => [x, y, z],
            _ => [0, 1, 2],
        };
        let last = xyz.into_iter().chain(tag).fold(0, usize::max);
        Self { separator, xyz, tag: tag.filter(|t| !xyz.contains(t)), width: last + 1 }
    }
}

fn fields(text: &[u8], separator: u8) -> impl Iterator<Item = &[u8]> {
    text.split(move |&b| b == separator).map(|f| {
        let f = f.trim_ascii();
        match f {
            [b'"', inner @ .., b'"'] => inner.trim_ascii(),
            _ => f,
        }
    })
}

/// The separator of a file is the first of semicolon, comma and tab that its first line has.
fn separator(text: &[u8]) -> u8 {
    *[b';', b',', b'\t'].iter().find(|s| text.contains(s)).unwrap_or(&b',')
}

/// The columns of a file, by its first line.
#[derive(Debug, Clone)]
pub(super) struct Table {
    columns: Columns,
    /// There are columns that are not read.
    has_more: bool,
    /// The first byte behind the header, if there is one.
    pub(super) rows: usize,
}

impl Table {
    /// The table that begins with these bytes; none if they have no line.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        let mut lines = Lines::new(bytes);
        let first = lines.next()?;
        let separator = separator(first.text);
        let width = fields(first.text, separator).count();
        let is_header = width >= 3
            && fields(first.text, separator)
                .any(|f| matches!(float(f), Err(Reason::NotANumber(_))));
        let columns = match is_header {
            true => Columns::named(separator, first),
            false => Columns::plain(separator),
        };
        let has_more = width > 3 + usize::from(columns.tag.is_some());
        Some(Self { columns, has_more, rows: if is_header { lines.position() } else { 0 } })
    }

    /// The points of lines of `bytes`.
    pub(super) fn points(&self, bytes: &[u8], lines: Lines<'_>) -> Result<PointFile, ParseError> {
        let mut file = PointFile::default();
        let mut tags = Vec::new();
        for line in lines {
            let at = |r| ParseError::at(bytes, line.offset, r);
            let (p, tag) = row(line.text, &self.columns).map_err(at)?;
            file.points.push(p);
            tags.extend(tag);
        }
        file.point_tags = self.columns.tag.map(|_| tags);
        if self.has_more {
            file.notes.push("columns other than x, y, z and tag are not read".to_owned());
        }
        Ok(file)
    }
}

/// Reads a `.csv` file.
pub fn read(bytes: &[u8]) -> Result<PointFile, ParseError> {
    match Table::of(bytes) {
        Some(table) => table.points(bytes, Lines::from(bytes, table.rows)),
        None => Ok(PointFile::default()),
    }
}

fn row(text: &[u8], columns: &Columns) -> Result<(Point, Option<i64>), Reason> {
    let (mut p, mut tag, mut found) = ([0.0; 3], None, 0);
    for (k, field) in fields(text, columns.separator).enumerate().take(columns.width) {
        found = k + 1;
        if let Some(axis) = columns.xyz.iter().position(|&c| c == k) {
            p[axis] = float(field)?;
        } else if columns.tag == Some(k) {
            tag = Some(integer(field)?);
        }
    }
    if found < columns.width {
        return Err(Reason::TooFewValues { expected: columns.width, found });
    }
    Ok((p, tag))
}

/// Writes a `.csv` file with a header, and a column `tag` where there are tags.
pub fn write(out: &mut dyn Write, points: &[Point], tags: Option<&[i64]>) -> std::io::Result<()> {
    out.write_all(if tags.is_some() { b"x,y,z,tag\n" } else { b"x,y,z\n" })?;
    write_rows(out, points.len(), |i, row| {
        push_point(row, &points[i], b',');
        if let Some(&tag) = tags.and_then(|t| t.get(i)) {
            row.push(b',');
            push_integer(row, tag);
        }
        row.push(b'\n');
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_separators_quotes_and_other_columns() {
        let plain = read(b"1,2,3\n4, 5 ,6\n").unwrap();
        assert_eq!(plain.points, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        let named = read(b"id;Z;Y;X;tag\n7;3;2;\"1\";-4\n").unwrap();
        assert_eq!(named.points, [[1.0, 2.0, 3.0]]);
        assert_eq!(named.point_tags, Some(vec![-4]));
        assert_eq!(named.notes.len(), 1);
        let unnamed = read(b"\"a\"\t\"b\"\t\"c\"\n1\t2\t3\n").unwrap();
        assert_eq!(unnamed.points, [[1.0, 2.0, 3.0]]);
        assert_eq!(read(b"").unwrap(), PointFile::default());
    }

    #[test]
    fn a_first_line_that_is_not_a_number_but_a_nan_is_no_header() {
        let e = read(b"1,nan,3\n1,2,3\n").unwrap_err();
        assert_eq!(e.to_string(), "line 1: `nan` is not a finite number");
    }
}
