//! `.off`: Geomview's object files, read as points.
//!
//! Read: the text form with the headers `OFF`, `COFF`, `NOFF`, `STOFF` and their combinations. The
//! vertices are the points; faces, colours and normals are not read, and a note says so. The
//! binary form and points of four or n dimensions are refused.
//! Source: the Geomview manual, "OFF Files".

use super::PointFile;
use super::error::{ParseError, Reason, excerpt};
use super::text::{Line, Lines, capacity, count, point};

/// Reads an `.off` file.
pub fn read(bytes: &[u8]) -> Result<PointFile, ParseError> {
    let mut lines = Lines::new(bytes);
    let end = || ParseError::at(bytes, bytes.len(), Reason::Syntax("no header".into()));
    let first = lines.next().ok_or_else(end)?;
    let counts = keyword(first).map_err(|r| ParseError::at(bytes, first.offset, r))?;
    // The counts may stand behind the keyword or on the next line.
    let counts = if counts.text.is_empty() { lines.next().ok_or_else(end)? } else { counts };
    let [announced, faces] =
        vertices_and_faces(counts).map_err(|r| ParseError::at(bytes, counts.offset, r))?;
    let mut points = Vec::with_capacity(capacity(announced, lines.remaining(), 6));
    let mut more = false;
    for found in 0..announced {
        let Some(line) = lines.next() else {
            let reason = Reason::Truncated { what: "points", announced, found };
            return Err(ParseError::at(bytes, bytes.len(), reason));
        };
        let mut fields = line.fields();
        points.push(point(&mut fields, 0).map_err(|r| ParseError::at(bytes, line.offset, r))?);
        more |= fields.next().is_some();
    }
    if let (0, Some(line)) = (faces, lines.next()) {
        return Err(ParseError::at(bytes, line.offset, Reason::Surplus("point")));
    }
    let mut file = PointFile { points, ..PointFile::default() };
    if faces > 0 {
        file.notes.push("faces are not read".to_owned());
    }
    if more {
        file.notes.push("values after the third of a vertex are not read".to_owned());
    }
    Ok(file)
}

/// Takes the keyword off the first line; what is left are the counts or nothing.
fn keyword(line: Line<'_>) -> Result<Line<'_>, Reason> {
    let wrong = || Reason::Syntax(format!("`{}` is no header of an OFF file", excerpt(line.text)));
    let mut rest = line.text;
    for prefix in [&b"ST"[..], b"C", b"N"] {
        rest = rest.strip_prefix(prefix).unwrap_or(rest);
    }
    if rest.starts_with(b"4") || rest.starts_with(b"nOFF") {
        return Err(Reason::Unsupported("points in other than 3 dimensions".into()));
    }
    let rest = rest.strip_prefix(b"OFF").ok_or_else(wrong)?.trim_ascii();
    if rest.starts_with(b"BINARY") {
        return Err(Reason::Unsupported("the binary form of OFF".into()));
    }
    Ok(Line { offset: line.offset, text: rest })
}

/// The first two of the counts of vertices, faces and edges.
fn vertices_and_faces(line: Line<'_>) -> Result<[u64; 2], Reason> {
    let mut counts = [0; 2];
    let mut found = 0;
    for field in line.fields() {
        let value = count(field)?;
        if let Some(c) = counts.get_mut(found) {
            *c = value;
        }
        found += 1;
    }
    match found {
        2 | 3 => Ok(counts),
        0 | 1 => Err(Reason::TooFewValues { expected: 3, found }),
        _ => Err(Reason::TooManyValues { expected: 3 }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_and_faces() {
        for head in ["OFF\n2 1 0\n", "OFF 2 1 0\n", "STCNOFF\n# c\n2 1\n", "OFF2 1 0\n"] {
            let text = format!("{head}0 0 0\n1 2 -3 255 0 0\n3 0 1 1\n");
            let file = read(text.as_bytes()).expect(head);
            assert_eq!(file.points, [[0.0, 0.0, 0.0], [1.0, 2.0, -3.0]]);
            assert_eq!(file.notes.len(), 2);
        }
        let says = |text: &str| read(text.as_bytes()).expect_err(text).to_string();
        assert_eq!(says(""), "line 1: no header");
        assert_eq!(says("OFF"), "line 1: no header");
        assert_eq!(says("FOO\n"), "line 1: `FOO` is no header of an OFF file");
        assert_eq!(says("OFF BINARY\n"), "line 1: not supported: the binary form of OFF");
        assert_eq!(says("4OFF\n"), "line 1: not supported: points in other than 3 dimensions");
        assert_eq!(says("OFF\n7\n"), "line 2: expected 3 values, found 1");
        assert_eq!(
            says("OFF\n1000000000000000000 0 0\n1 2 3\n"),
            "line 4: the file announces 1000000000000000000 points, but ends after 1"
        );
        assert_eq!(says("OFF\n1 0 0\n1 2\n"), "line 3: expected 3 values, found 2");
        assert_eq!(says("OFF\n0 0 0\n1 2 3\n"), "line 3: unexpected data after the last point");
    }
}
