//! `.stl`: triangles for stereolithography, text or binary, read as points or as a surface.
//!
//! The corners of the triangles are the points. The format repeats a point in each of its
//! triangles; points that are equal (`-0.0` and `0.0` are) are read once, in the order of their
//! first appearance. Normals are not read: the order of the corners says as much. As points, the
//! triangles are not read either; a note says so. A file is binary if its length is the one that
//! the count in its header asks for, or if it does not start with `solid`. In text, keywords are of
//! either case, and those of two words may stand apart (`end solid`) or together (`outerloop`).
//! Several solids with triangles are groups of these, by their names; one is the volume's name.
//! Written: text, in which coordinates keep their 64 bits (the binary form has 32).
//! Source: 3D Systems, "StereoLithography Interface Specification", 1988.

use super::error::{ParseError, Place, Reason, excerpt, is_utf16};
use super::groups::{self, Groups};
use super::surface::{Corners, Surface};
use super::text::{Line, Lines, capacity, point, push_point, write_rows};
use super::{DomainFile, Point, PointFile};
use std::collections::HashMap;
use std::io::Write;

/// Bytes before the triangles: a comment of 80 bytes and their count.
const HEADER: usize = 84;
/// The name of what we write, which tells nothing.
const OWN: &str = "ltbw";
/// Bytes of a triangle: its normal, three corners of three `f32` each, and two bytes more.
const TRIANGLE: usize = 50;

/// Reads the corners of an `.stl` file, each once.
pub fn read(bytes: &[u8]) -> Result<PointFile, ParseError> {
    let distinct = triangles(bytes)?;
    let notes = vec!["triangles are not read; each point is read once".to_owned()];
    Ok(PointFile { points: distinct.points, point_tags: None, notes })
}

/// Reads an `.stl` file as a surface; corners of equal coordinates are one vertex.
pub fn read_domain(bytes: &[u8]) -> Result<DomainFile, ParseError> {
    let Distinct { points, corners, mut groups, .. } = triangles(bytes)?;
    let mut surface = Surface::new(points);
    let (triangles, _) = corners.as_chunks::<3>();
    surface.reserve(triangles.len());
    for triangle in triangles {
        let face = Corners::from(&triangle[..]);
        surface.face(face).map_err(|r| ParseError::new(Place::End, r))?;
    }
    groups.take(triangles.len());
    Ok(surface.grouped(groups).finish(Vec::new()))
}

/// The triangles of either form.
fn triangles(bytes: &[u8]) -> Result<Distinct, ParseError> {
    let count = bytes.get(80..HEADER).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]));
    let length = count.map(|c| HEADER as u64 + TRIANGLE as u64 * u64::from(c));
    let front = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
    let text = front.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    match (count, length) {
        (Some(count), Some(length))
            if length == bytes.len() as u64 || !(text || is_utf16(bytes)) =>
        {
            read_binary(&bytes[HEADER..], count)
        }
        _ if text => read_text(bytes),
        _ => {
            let reason = Reason::Syntax("neither a text nor a binary STL file".into());
            Err(ParseError::at(bytes, 0, reason))
        }
    }
}

/// Points without those that are equal to an earlier one, and where each corner went.
struct Distinct {
    points: Vec<Point>,
    seen: HashMap<[u64; 3], u32>,
    corners: Vec<u32>,
    /// The solids of a text.
    groups: Groups,
}

impl Distinct {
    /// `reserve`: about how many triangles there are.
    fn new(reserve: usize) -> Self {
        // A closed surface has half as many points as triangles.
        Self {
            points: Vec::with_capacity(reserve / 2),
            seen: HashMap::with_capacity(reserve / 2),
            corners: Vec::with_capacity(3 * reserve),
            groups: Groups::of_bodies(),
        }
    }

    /// Begins a solid of a text, the one of this number. What we write has no name of its own.
    fn begin(&mut self, line: &Line<'_>, number: usize) {
        self.groups.take(self.corners.len() / 3);
        let words = line.text.trim_ascii_start().get(5..).unwrap_or_default();
        match groups::name(words) {
            name if name.is_empty() || name == OWN => self.groups.begin(&format!("solid {number}")),
            name => self.groups.begin(&name),
        }
    }

    fn add(&mut self, point: Point) -> Result<(), Reason> {
        let next = u32::try_from(self.points.len())
            .map_err(|_| Reason::TooManyPoints(self.points.len() as u64))?;
        // In rounding to nearest, -0.0 + 0.0 is 0.0; nothing else changes.
        let index = *self.seen.entry(point.map(|c| (c + 0.0).to_bits())).or_insert(next);
        if index == next {
            self.points.push(point);
        }
        self.corners.push(index);
        Ok(())
    }
}

fn read_binary(body: &[u8], count: u32) -> Result<Distinct, ParseError> {
    let (triangles, rest) = body.as_chunks::<TRIANGLE>();
    let (announced, found) = (u64::from(count), triangles.len() as u64);
    if found < announced {
        let reason = Reason::Truncated { what: "triangles", announced, found };
        return Err(ParseError::new(Place::End, reason));
    }
    if found > announced || !rest.is_empty() {
        return Err(ParseError::new(Place::End, Reason::Surplus("triangle")));
    }
    let mut distinct = Distinct::new(triangles.len());
    for (t, triangle) in triangles.iter().enumerate() {
        // Behind the normal.
        let (numbers, _) = triangle[12..48].as_chunks::<4>();
        let (corners, _) = numbers.as_chunks::<3>();
        for corner in corners {
            let p = corner.map(|c| f64::from(f32::from_le_bytes(c)));
            let at = |reason| ParseError::new(Place::Byte((HEADER + t * TRIANGLE) as u64), reason);
            if let Some(c) = p.iter().find(|c| !c.is_finite()) {
                return Err(at(Reason::NotFinite(c.to_string())));
            }
            distinct.add(p).map_err(at)?;
        }
    }
    Ok(distinct)
}

fn read_text(bytes: &[u8]) -> Result<Distinct, ParseError> {
    // A triangle takes some 250 bytes.
    let mut distinct = Distinct::new(capacity(u64::MAX, bytes.len(), 250));
    let (mut inside, mut corners, mut solids) = (false, 0, 0);
    for line in Lines::new(bytes) {
        let at = |reason| ParseError::at(bytes, line.offset, reason);
        let mut fields = line.fields();
        let word = keyword(&mut fields);
        match word.as_slice() {
            b"solid" if !inside => {
                inside = true;
                solids += 1;
                distinct.begin(&line, solids);
            }
            b"endsolid" if inside => inside = false,
            b"vertex" if inside => {
                point(&mut fields, 1).and_then(|p| distinct.add(p)).map_err(at)?;
                if fields.next().is_some() {
                    return Err(at(Reason::TooManyValues { expected: 4 }));
                }
                corners += 1;
            }
            b"facet" | b"outer" | b"outerloop" | b"endloop" if inside => {}
            b"endfacet" if inside && corners == 3 => corners = 0,
            b"endfacet" if inside => {
                return Err(at(Reason::Syntax(format!("a facet of {corners} vertices"))));
            }
            _ => {
                let text = format!("unexpected `{}`", excerpt(line.text));
                return Err(at(Reason::Syntax(text)));
            }
        }
    }
    if inside {
        let reason = Reason::Syntax("the file ends without `endsolid`".into());
        return Err(ParseError::at(bytes, bytes.len(), reason));
    }
    if corners > 0 {
        let reason = Reason::Syntax("the file ends inside a facet".into());
        return Err(ParseError::at(bytes, bytes.len(), reason));
    }
    Ok(distinct)
}

/// The first word of a line in lower case; `end` with the word behind it.
fn keyword<'a>(fields: &mut (impl Iterator<Item = &'a [u8]> + Clone)) -> Vec<u8> {
    let mut word = fields.next().unwrap_or_default().to_ascii_lowercase();
    if word == b"end" {
        word.extend(fields.next().unwrap_or_default().to_ascii_lowercase());
    }
    word
}

/// Writes a surface of triangles as text.
pub(super) fn write_surface(
    out: &mut dyn Write,
    points: &[Point],
    triangles: &[[u32; 3]],
) -> std::io::Result<()> {
    out.write_all(b"solid ltbw\n")?;
    write_rows(out, triangles.len(), |i, row| {
        let corners = triangles[i].map(|v| points[v as usize]);
        row.extend_from_slice(b"facet normal ");
        push_point(row, &normal(&corners), b' ');
        row.extend_from_slice(b"\nouter loop\n");
        for corner in &corners {
            row.extend_from_slice(b"vertex ");
            push_point(row, corner, b' ');
            row.push(b'\n');
        }
        row.extend_from_slice(b"endloop\nendfacet\n");
    })?;
    out.write_all(b"endsolid ltbw\n")
}

/// The unit normal, rounded; zero where it has no direction in floating point.
fn normal([a, b, c]: &[Point; 3]) -> Point {
    let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
    let n = [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        u[i] * v[j] - u[j] * v[i]
    });
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    if length.is_normal() { n.map(|c| c / length + 0.0) } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binary(head: &[u8], count: u32, triangles: &[[f32; 9]]) -> Vec<u8> {
        let mut out = head.to_vec();
        out.resize(80, 0);
        out.extend(count.to_le_bytes());
        for t in triangles {
            out.extend(f32::NAN.to_le_bytes().repeat(3));
            out.extend(t.iter().flat_map(|c| c.to_le_bytes()));
            out.extend([0; 2]);
        }
        out
    }

    #[test]
    fn equal_corners_are_one_point() {
        let triangles = [
            [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            [-0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.1, 0.0, 1.0],
        ];
        let want =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f64::from(0.1_f32), 0.0, 1.0]];
        assert_eq!(read(&binary(b"solid but binary", 2, &triangles)).unwrap().points, want);
        let text = "solid a b\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
             VERTEX -0 0 0\nendloop\nendfacet\nendsolid a b\n";
        assert_eq!(read(text.as_bytes()).unwrap().points, want[..2]);
    }

    #[test]
    fn keywords_may_be_written_in_other_ways() {
        let facet =
            "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet";
        for (open, text) in [
            ("solid", facet.replace("endfacet", "end facet") + "\nend solid"),
            ("SOLID x", facet.to_uppercase().replace("ENDLOOP", "END LOOP") + "\nEND SOLID x"),
            ("\u{feff}solid", facet.replace("outer loop", "outerloop") + "\nendsolid"),
            ("solid a", format!("{facet}\nendsolid a\nsolid b\nend solid b\n")),
        ] {
            let found = read_domain(format!("{open}\n{text}").as_bytes()).expect(open).domain;
            assert_eq!(found.vertices.len(), 3, "{open}");
            assert_eq!(found.facets[0].polygons, [[0, 1, 2]], "{open}");
        }
        let error = read(b"solid\nend\n").expect_err("no keyword").to_string();
        assert_eq!(error, "line 2: unexpected `end`");
    }

    #[test]
    fn malformed() {
        let says = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
        let one = [[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, f32::INFINITY]];
        assert_eq!(says(b""), "line 1: neither a text nor a binary STL file");
        assert_eq!(
            says(&binary(b"x", u32::MAX, &one)),
            "end of file: the file announces 4294967295 triangles, but ends after 1"
        );
        assert_eq!(
            says(&binary(b"x", 0, &one)),
            "end of file: unexpected data after the last triangle"
        );
        assert_eq!(says(&binary(b"x", 1, &one)), "byte 84: `inf` is not a finite number");
        assert_eq!(says(b"solid\nvertex 1 2\n"), "line 2: expected 4 values, found 3");
        assert_eq!(says(b"solid\nvertex 1 2 3\nendfacet"), "line 3: a facet of 1 vertices");
        assert_eq!(says(b"solid\n\n"), "line 3: the file ends without `endsolid`");
        assert_eq!(says(b"solid\nhello you\n"), "line 2: unexpected `hello you`");
    }
}
