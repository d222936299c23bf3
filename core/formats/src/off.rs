//! `.off`: Geomview's object files, read as points or as a surface.
//!
//! Read: the text form with the headers `OFF`, `COFF`, `NOFF`, `STOFF` and their combinations. As
//! points: the vertices; faces, colours and normals are not read, and a note says so. As a
//! domain: vertices and faces of any number of corners, which may go on in the next lines. The
//! binary form and points of four or n dimensions are refused.
//! Source: the Geomview manual, "OFF Files".

use super::error::{ParseError, Reason, excerpt};
use super::groups::{Groups, name};
use super::surface::{Corners, Surface};
use super::text::{Line, Lines, capacity, count, point, push_integer, push_point, write_rows};
use super::{DomainFile, Point, PointFile};
use std::io::Write;

/// Reads the vertices of an `.off` file.
pub fn read(bytes: &[u8]) -> Result<PointFile, ParseError> {
    let (mut file, faces, mut lines) = vertices(bytes)?;
    if let (0, Some(line)) = (faces, lines.next()) {
        return Err(ParseError::at(bytes, line.offset, Reason::Surplus("point")));
    }
    if faces > 0 {
        file.notes.push("faces are not read".to_owned());
    }
    Ok(file)
}

/// Corners of a face for which memory is reserved before they are there.
const CORNERS: u64 = 16;

/// Reads an `.off` file as a surface.
pub fn read_domain(bytes: &[u8]) -> Result<DomainFile, ParseError> {
    let (file, announced, mut lines) = vertices(bytes)?;
    let mut surface = Surface::new(file.points);
    surface.reserve(capacity(announced, lines.remaining(), 8));
    let mut groups = Groups::default();
    for found in 0..announced {
        let Some(line) = lines.next() else {
            let reason = Reason::Truncated { what: "faces", announced, found };
            return Err(ParseError::at(bytes, bytes.len(), reason));
        };
        let at = |r| ParseError::at(bytes, line.offset, r);
        let mut fields = line.fields();
        let wanted = count(fields.next().unwrap_or_default()).map_err(at)?;
        let mut corners = Corners::new(wanted.min(CORNERS) as usize);
        let mut goes_on = false;
        for k in 0..wanted {
            let (expected, k) = (wanted.saturating_add(1), k + 1);
            let short = || Reason::TooFewValues { expected: expected as usize, found: k as usize };
            let mut token = fields.next();
            if token.is_none() {
                fields = lines.next().ok_or_else(short).map_err(at)?.fields();
                (token, goes_on) = (fields.next(), true);
            }
            let token = token.ok_or_else(short).map_err(at)?;
            corners.push(token, 0, surface.points(), found).map_err(at)?;
        }
        let colour = name(&fields.collect::<Vec<&[u8]>>().join(&b' '));
        let rest = !colour.is_empty();
        // The next number would begin a face, to which this one lacks a corner.
        if goes_on && rest {
            return Err(at(Reason::Syntax(format!("face {found} ends in the midst of a line"))));
        }
        surface.face(corners).map_err(at)?;
        groups.begin(&if rest { format!("colour {colour}") } else { colour });
        groups.take(surface.faces());
    }
    if let Some(line) = lines.next() {
        return Err(ParseError::at(bytes, line.offset, Reason::Surplus("face")));
    }
    Ok(surface.grouped(groups).finish(file.notes))
}

/// Reads header and vertices; also the number of faces, and the lines that are left.
fn vertices(bytes: &[u8]) -> Result<(PointFile, u64, Lines<'_>), ParseError> {
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
    let mut file = PointFile { points, ..PointFile::default() };
    if more {
        file.notes.push("values after the third of a vertex are not read".to_owned());
    }
    Ok((file, faces, lines))
}

/// Writes a surface.
pub(super) fn write_surface(
    out: &mut dyn Write,
    points: &[Point],
    faces: &[&[u32]],
) -> std::io::Result<()> {
    writeln!(out, "OFF\n{} {} 0", points.len(), faces.len())?;
    write_rows(out, points.len(), |i, row| {
        push_point(row, &points[i], b' ');
        row.push(b'\n');
    })?;
    write_rows(out, faces.len(), |i, row| {
        push_integer(row, faces[i].len() as i64);
        for &v in faces[i] {
            row.push(b' ');
            push_integer(row, i64::from(v));
        }
        row.push(b'\n');
    })
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
    fn faces_may_go_on_in_the_next_lines() {
        let head = "OFF\n5 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n";
        let domain = |faces: &str| read_domain(format!("{head}{faces}").as_bytes());
        for faces in
            ["4 0 1 2 3\n3 0 1 4", "4\n0 1\n2 3\n3 0 1 # c\n4", "4 0\n\n1 2 3\n3 0 1 4 255 0"]
        {
            let found = domain(faces).expect(faces).domain;
            let polygons: Vec<_> = found.facets.iter().map(|f| f.polygons.concat()).collect();
            assert_eq!(polygons, [vec![0, 1, 2, 3], vec![0, 1, 4]], "{faces}");
        }
        let says = |faces: &str| domain(faces).expect_err(faces).to_string();
        // A corner too few takes what would be the next face.
        assert_eq!(says("4 0 1 2\n3 0 1 4\n"), "line 8: face 0 ends in the midst of a line");
        assert_eq!(says("4 0 1 2 3\n3 0 1"), "line 9: expected 4 values, found 3");
        assert_eq!(says("4 0 1\n"), "line 8: expected 5 values, found 3");
        let far = says("4 0 1\n2 9\n3 0 1 4");
        assert!(far.starts_with("line 8: face 0 names point 9"), "{far}");
    }

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
