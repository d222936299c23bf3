//! `.obj`: Wavefront's object files, read as points or as a surface.
//!
//! Read: the coordinates of every statement `v`; for a domain also every statement `f`, a face of
//! any number of corners `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1, or from the last
//! vertex if negative. Several groups (`g`, `o`) or materials (`usemtl`) with faces are groups of
//! these. Weights and colours of vertices, and all other statements, are not read; a note says so.
//! A line that ends in a backslash goes on in the next.
//! Source: Wavefront, "Advanced Visualizer Manual", appendix B1.

use super::error::{ParseError, Reason, excerpt};
use super::groups::{Groups, name};
use super::surface::{Corners, Surface};
use super::text::{Line, Lines, point, push_integer, push_point, write_rows};
use super::{DomainFile, Point, PointFile};
use std::io::Write;

/// The statements of the format, other than `v`, sorted.
const OTHER: &[&[u8]] = &[
    b"bevel",
    b"bmat",
    b"bsp",
    b"bzp",
    b"c_interp",
    b"call",
    b"cdc",
    b"cdp",
    b"con",
    b"csh",
    b"cstype",
    b"ctech",
    b"curv",
    b"curv2",
    b"d_interp",
    b"deg",
    b"end",
    b"f",
    b"fo",
    b"g",
    b"hole",
    b"l",
    b"lod",
    b"maplib",
    b"mg",
    b"mtllib",
    b"o",
    b"p",
    b"parm",
    b"res",
    b"s",
    b"scrv",
    b"shadow_obj",
    b"sp",
    b"stech",
    b"step",
    b"surf",
    b"trace_obj",
    b"trim",
    b"usemap",
    b"usemtl",
    b"vn",
    b"vp",
    b"vt",
];

/// Reads the vertices of an `.obj` file.
pub fn read(bytes: &[u8]) -> Result<PointFile, ParseError> {
    let mut file = PointFile::default();
    let (mut more, mut others) = (false, false);
    // A line that ends in a backslash goes on in the next; coordinates are never split so.
    let mut continued = false;
    for line in Lines::new(bytes) {
        let at = |reason| ParseError::at(bytes, line.offset, reason);
        let mut fields = line.fields();
        let word = fields.next().unwrap_or_default();
        if !continued && word == b"v" {
            file.points.push(point(&mut fields, 0).map_err(at)?);
            more |= fields.next().is_some();
        } else if continued || OTHER.binary_search(&word).is_ok() {
            others = true;
            continued = line.text.ends_with(b"\\");
        } else {
            let text = format!("`{}` is no statement of an OBJ file", excerpt(word));
            return Err(at(Reason::Syntax(text)));
        }
    }
    if more {
        file.notes.push("values after the third of a vertex are not read".to_owned());
    }
    if others {
        file.notes.push("statements other than `v` are not read".to_owned());
    }
    Ok(file)
}

/// Reads an `.obj` file as a surface.
pub fn read_domain(bytes: &[u8]) -> Result<DomainFile, ParseError> {
    // Faces may come before the vertices that they name, but count backwards from their own place.
    let mut surface = Surface::new(read(bytes)?.points);
    let (mut above, mut number, mut others, mut more) = (0_usize, 0_u64, false, false);
    let (mut groups, mut materials) = (Groups::default(), Groups::default());
    let mut lines = Lines::new(bytes);
    // Every turn takes a line.
    while let Some(line) = lines.next() {
        let at = |reason| ParseError::at(bytes, line.offset, reason);
        match line.fields().next().unwrap_or_default() {
            word @ (b"g" | b"o" | b"usemtl") if !goes_on(&line) => {
                let into = if word == b"usemtl" { &mut materials } else { &mut groups };
                into.take(surface.faces());
                into.begin(&name(
                    line.text.trim_ascii_start().get(word.len()..).unwrap_or_default(),
                ));
            }
            b"v" => {
                above += 1;
                more |= line.fields().count() > 4;
            }
            b"f" => {
                let mut corners = Corners::new(4);
                let mut part = Some(line);
                // Every turn takes a line.
                while let Some(line) = part {
                    corner_tokens(&line).try_for_each(|token| {
                        let at = |reason| ParseError::at(bytes, line.offset, reason);
                        corner(token, above, &mut corners, surface.points(), number).map_err(at)
                    })?;
                    part = if goes_on(&line) { lines.next() } else { None };
                }
                surface.face(corners).map_err(at)?;
                number += 1;
            }
            _ => {
                others = true;
                let mut part = Some(line);
                // Every turn takes a line.
                while part.is_some_and(|line| goes_on(&line)) {
                    part = lines.next();
                }
            }
        }
    }
    let mut notes = Vec::new();
    if more {
        notes.push("values after the third of a vertex are not read".to_owned());
    }
    if others {
        notes.push("statements other than `v`, `f`, `g`, `o` and `usemtl` are not read".to_owned());
    }
    [&mut groups, &mut materials].into_iter().for_each(|own| own.take(surface.faces()));
    Ok(surface.grouped(groups.divided(materials)).finish(notes))
}

fn goes_on(line: &Line<'_>) -> bool {
    line.text.ends_with(b"\\")
}

/// The corners in a line of a face: its values, without the statement and the sign that it goes on.
fn corner_tokens<'a>(line: &Line<'a>) -> impl Iterator<Item = &'a [u8]> {
    let text = line.text.strip_suffix(b"\\").unwrap_or(line.text);
    let tokens = text.split(u8::is_ascii_whitespace).filter(|t| !t.is_empty());
    tokens.filter(|&t| t != b"f")
}

/// Adds a corner; `above` vertices stand above it in the file.
fn corner(
    token: &[u8],
    above: usize,
    corners: &mut Corners,
    points: usize,
    face: u64,
) -> Result<(), Reason> {
    let vertex = token.split(|&b| b == b'/').next().unwrap_or_default();
    let back = vertex.strip_prefix(b"-");
    match back {
        None => corners.push(vertex, 1, points, face),
        Some(back) => {
            let back = super::text::count(back)?;
            let index = usize::try_from(back).ok().and_then(|b| above.checked_sub(b));
            let outside = Reason::Index {
                what: "face",
                number: face,
                index: i64::try_from(back).map_or(i64::MIN, |b| -b),
                first: -(above as i64),
                last: -1,
            };
            corners.add(index.filter(|_| back > 0).ok_or(outside)?);
            Ok(())
        }
    }
}

/// Writes a surface.
pub(super) fn write_surface(
    out: &mut dyn Write,
    points: &[Point],
    faces: &[&[u32]],
) -> std::io::Result<()> {
    write_rows(out, points.len(), |i, row| {
        row.extend_from_slice(b"v ");
        push_point(row, &points[i], b' ');
        row.push(b'\n');
    })?;
    write_rows(out, faces.len(), |i, row| {
        row.push(b'f');
        for &v in faces[i] {
            row.push(b' ');
            push_integer(row, i64::from(v) + 1);
        }
        row.push(b'\n');
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_of_statements_is_sorted() {
        assert!(OTHER.is_sorted());
    }

    #[test]
    fn vertices_among_other_statements() {
        let text = b"# c\nmtllib a.mtl\no x\nv 1 2 3 1.0\nvn 0 0 1\nv -1e-3 0 5\nf 1 2 \\\n 1\n";
        let file = read(text).unwrap();
        assert_eq!(file.points, [[1.0, 2.0, 3.0], [-1e-3, 0.0, 5.0]]);
        assert_eq!(file.notes.len(), 2);
        let says = |text: &str| read(text.as_bytes()).expect_err(text).to_string();
        assert_eq!(says("v 1 2\n"), "line 1: expected 3 values, found 2");
        assert_eq!(says("v 1 2 inf\n"), "line 1: `inf` is not a finite number");
        assert_eq!(says("v 0 0 0\nhello\n"), "line 2: `hello` is no statement of an OBJ file");
    }
}
