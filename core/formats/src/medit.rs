//! `.mesh`: the ASCII format of Medit (INRIA).
//!
//! Sections start with a keyword and a count. `Vertices` (x, y, z, reference) and `Tetrahedra`
//! (four corners numbered from 1, reference) are read; a reference is a tag. References that
//! are all 0 mean no tags, unless the comment `# references are tags` stands before the section,
//! which we write where it is needed. Triangles that are faces of
//! tetrahedra are boundary triangles, their references the markers. Of `TetrahedraP2`,
//! `TrianglesP2` and those of higher order the corners are read, which come first, with a note.
//! Sections of edges, corners and the like are not read; a note says which. Other volume cells
//! are refused. A file ends with `End`; without it, which other programs allow, there must be
//! tetrahedra, and a note says that sections may be missing.
//! Source: P. Frey, "MEDIT: an interactive mesh visualization software", INRIA RT-0253, 2001.

use super::MeshFile;
use super::curved::Curved;
use super::error::{ParseError, Reason, excerpt};
use super::faces::{Marked, owned};
use super::text::{Tokens, capacity, count, float, integer, push_integer, push_point, write_rows};
use ltbw_core::TetMesh;
use ltbw_exact::Point;
use std::io::Write;

/// The comment before a section whose references are tags although all are 0.
const MARK: &[u8] = b"# references are tags";

/// The sections of a file that are read.
#[derive(Default)]
struct Sections<'a> {
    /// Keywords of those that are there.
    seen: Vec<&'a [u8]>,
    vertices: Option<(Vec<Point>, Vec<i64>)>,
    tets: Vec<Section<4>>,
    triangles: Vec<Section<3>>,
    /// Tags although all are 0, of vertices and of tetrahedra.
    marked: [bool; 2],
    curved: Curved,
    notes: Vec<String>,
}

/// A section of tetrahedra or triangles: where it starts, and their corners and references.
struct Section<const N: usize> {
    at: usize,
    corners: Vec<[i64; N]>,
    references: Vec<i64>,
}

/// Reads a `.mesh` file.
pub fn read(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let mut tokens = Tokens::new(bytes);
    let mut sections = Sections::default();
    // Every turn consumes at least a keyword.
    loop {
        let before = tokens.position();
        let Some(keyword) = tokens.next() else {
            // The counts of the sections hold; which others there were nobody knows.
            if sections.tets.is_empty() {
                return Err(tokens.error(Reason::Syntax("the file ends without `End`".into())));
            }
            sections.notes.push("there is no `End`: sections may be missing".to_owned());
            break;
        };
        if keyword == b"End" {
            if tokens.next().is_some() {
                return Err(tokens.error(Reason::Surplus("section")));
            }
            break;
        }
        let between = &bytes[before..tokens.position() - keyword.len()];
        let mark = between.split(|&b| b == b'\n').any(|line| line.trim_ascii() == MARK);
        sections.read(keyword, mark, &mut tokens)?;
    }
    let at_end = tokens.position();
    sections.mesh().map_err(|(at, reason)| {
        ParseError::at(bytes, at.unwrap_or(at_end.saturating_sub(1)), reason)
    })
}

/// The dimension and the number of nodes of the simplices in a section, by its keyword.
fn simplices(keyword: &[u8]) -> Option<(u8, usize)> {
    Some(match keyword {
        b"Triangles" => (2, 3),
        b"TrianglesP2" => (2, 6),
        b"TrianglesP3" => (2, 10),
        b"TrianglesP4" => (2, 15),
        b"Tetrahedra" => (3, 4),
        b"TetrahedraP2" => (3, 10),
        b"TetrahedraP3" => (3, 20),
        b"TetrahedraP4" => (3, 35),
        _ => return None,
    })
}

/// Does a section hold volume cells of another kind, of any order?
fn is_other_volume(keyword: &[u8]) -> bool {
    [&b"Hexahedra"[..], b"Prisms", b"Pyramids"].iter().any(|word| {
        // `HexahedraQ2` is cells, `HexahedraQ2Ordering` is not.
        keyword.strip_prefix(*word).is_some_and(|order| matches!(order, [] | [b'P' | b'Q', _]))
    })
}

impl<'a> Sections<'a> {
    /// Reads the section behind a keyword.
    fn read(
        &mut self,
        keyword: &'a [u8],
        mark: bool,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), ParseError> {
        let kind = simplices(keyword);
        if self.seen.contains(&keyword) || is_other_volume(keyword) {
            let text = format!("this section `{}`", excerpt(keyword));
            return Err(tokens.error(Reason::Unsupported(text)));
        }
        if kind.is_some() || keyword == b"Vertices" {
            self.seen.push(keyword);
        }
        match (keyword, kind) {
            (b"MeshVersionFormatted", _) => drop(number(tokens, keyword, count)?),
            (b"Dimension", _) => {
                let dimension = number(tokens, keyword, count)?;
                if dimension != 3 {
                    let text = format!("points in {dimension} dimensions");
                    return Err(tokens.error(Reason::Unsupported(text)));
                }
            }
            (b"Vertices", _) => {
                self.marked[0] = mark;
                self.vertices = Some(read_vertices(tokens)?);
            }
            (_, Some((3, nodes))) => {
                self.marked[1] |= mark;
                let section = read_simplices(tokens, keyword, nodes)?;
                self.curved.tets += if nodes > 4 { section.corners.len() } else { 0 };
                self.tets.push(section);
            }
            (_, Some((_, nodes))) => {
                let section = read_simplices(tokens, keyword, nodes)?;
                self.curved.triangles += if nodes > 3 { section.corners.len() } else { 0 };
                self.triangles.push(section);
            }
            _ if keyword[0].is_ascii_alphabetic() => {
                self.notes.push(format!("section {} is not read", excerpt(keyword)));
                skip_numbers(tokens);
            }
            _ => {
                let text = format!("`{}` where a keyword was expected", excerpt(keyword));
                return Err(tokens.error(Reason::Syntax(text)));
            }
        }
        Ok(())
    }

    /// The mesh that the sections make; errors have the place of theirs.
    fn mesh(self) -> Result<MeshFile, (Option<usize>, Reason)> {
        let Self { vertices, tets, triangles, marked, curved, mut notes, .. } = self;
        let missing = || (None, Reason::Syntax("there is no section `Vertices`".into()));
        let (points, point_tags) = vertices.ok_or_else(missing)?;
        notes.dedup();
        notes.extend(curved.note());
        let (tets, tet_tags) = number_from_0(tets, points.len())?;
        let (corners, markers) = number_from_0(triangles, points.len())?;
        let triangle = |(corners, marker)| Marked { corners, marker };
        let triangles: Vec<Marked> = corners.into_iter().zip(markers).map(triangle).collect();
        let tags = |t: Vec<i64>, mark: bool| (mark || t.iter().any(|&r| r != 0)).then_some(t);
        let (point_tags, tet_tags) = (tags(point_tags, marked[0]), tags(tet_tags, marked[1]));
        let mut mesh = TetMesh { points, tets, point_tags, tet_tags, ..TetMesh::default() };
        let note;
        (mesh.faces, note) = owned(&mesh, &triangles);
        notes.extend(note);
        Ok(MeshFile { mesh, notes, names: Vec::new() })
    }
}

/// The number that must follow inside the section `keyword`.
fn number<T>(
    tokens: &mut Tokens<'_>,
    keyword: &[u8],
    parse: fn(&[u8]) -> Result<T, Reason>,
) -> Result<T, ParseError> {
    match tokens.next() {
        Some(token) => parse(token).map_err(|r| tokens.error(r)),
        None => {
            let text = format!("the file ends inside `{}`", excerpt(keyword));
            Err(tokens.error(Reason::Syntax(text)))
        }
    }
}

fn skip_numbers(tokens: &mut Tokens<'_>) {
    while tokens.peek().is_some_and(|t| !t[0].is_ascii_alphabetic()) {
        tokens.next();
    }
}

/// Tells a section that ends early from one with a bad value.
fn truncated(
    tokens: &mut Tokens<'_>,
    what: &'static str,
    announced: u64,
    found: u64,
) -> Result<(), ParseError> {
    match tokens.peek() {
        None => Err(tokens.error(Reason::Truncated { what, announced, found })),
        Some(_) => Ok(()),
    }
}

fn read_vertices(tokens: &mut Tokens<'_>) -> Result<(Vec<Point>, Vec<i64>), ParseError> {
    let announced = number(tokens, b"Vertices", count)?;
    let reserve = capacity(announced, tokens.remaining(), 8);
    let (mut points, mut tags) = (Vec::with_capacity(reserve), Vec::with_capacity(reserve));
    for found in 0..announced {
        truncated(tokens, "vertices", announced, found)?;
        let mut p = [0.0; 3];
        for c in &mut p {
            *c = number(tokens, b"Vertices", float)?;
        }
        points.push(p);
        tags.push(number(tokens, b"Vertices", integer)?);
    }
    Ok((points, tags))
}

/// Reads a section of simplices of `nodes` nodes each, of which the first are the corners.
fn read_simplices<const N: usize>(
    tokens: &mut Tokens<'_>,
    keyword: &[u8],
    nodes: usize,
) -> Result<Section<N>, ParseError> {
    let at = Tokens::position(tokens);
    let announced = number(tokens, keyword, count)?;
    let what = if N == 4 { "tetrahedra" } else { "triangles" };
    let reserve = capacity(announced, tokens.remaining(), 2 * nodes + 2);
    let (mut all, mut references) = (Vec::with_capacity(reserve), Vec::with_capacity(reserve));
    for found in 0..announced {
        truncated(tokens, what, announced, found)?;
        let mut corners = [0; N];
        for node in 0..nodes {
            let index = number(tokens, keyword, integer)?;
            if let Some(corner) = corners.get_mut(node) {
                *corner = index;
            }
        }
        all.push(corners);
        references.push(number(tokens, keyword, integer)?);
    }
    Ok(Section { at, corners: all, references })
}

/// The simplices of sections: corners numbered from 1 as indices from 0, all below `points`, and
/// references. An error has the place of its section.
#[expect(clippy::type_complexity, reason = "two lists, or a place and a reason")]
fn number_from_0<const N: usize>(
    sections: Vec<Section<N>>,
    points: usize,
) -> Result<(Vec<[u32; N]>, Vec<i64>), (Option<usize>, Reason)> {
    let last = u32::try_from(points).map_err(|_| (None, Reason::TooManyPoints(points as u64)))?;
    let (mut simplices, mut references) = (Vec::new(), Vec::new());
    for section in sections {
        simplices.reserve_exact(section.corners.len());
        for (row, corners) in section.corners.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&v| v < 1 || v > i64::from(last)) {
                let (number, last) = (row as u64 + 1, i64::from(last));
                let what = if N == 4 { "tetrahedron" } else { "triangle" };
                let reason = Reason::Index { what, number, index, first: 1, last };
                return Err((Some(section.at), reason));
            }
            simplices.push(corners.map(|v| (v - 1) as u32));
        }
        references.extend(section.references);
    }
    Ok((simplices, references))
}

/// Writes a `.mesh` file; the references of triangles are the markers of their facets.
pub fn write(out: &mut dyn Write, mesh: &TetMesh) -> std::io::Result<()> {
    let faces = &mesh.faces;
    let tag = |tags: &Option<Vec<i64>>, i: usize| {
        tags.as_ref().and_then(|t| t.get(i)).copied().unwrap_or(0)
    };
    let mark = |out: &mut dyn Write, tags: &Option<Vec<i64>>| match tags {
        Some(tags) if tags.iter().all(|&t| t == 0) => out.write_all(&[MARK, b"\n"].concat()),
        _ => Ok(()),
    };
    // Version 2: coordinates are double precision.
    out.write_all(b"MeshVersionFormatted 2\nDimension 3\n")?;
    mark(out, &mesh.point_tags)?;
    writeln!(out, "Vertices\n{}", mesh.points.len())?;
    write_rows(out, mesh.points.len(), |i, row| {
        push_point(row, &mesh.points[i], b' ');
        row.push(b' ');
        push_integer(row, tag(&mesh.point_tags, i));
        row.push(b'\n');
    })?;
    mark(out, &mesh.tet_tags)?;
    writeln!(out, "Tetrahedra\n{}", mesh.tets.len())?;
    write_rows(out, mesh.tets.len(), |i, row| {
        for &v in &mesh.tets[i] {
            push_integer(row, i64::from(v) + 1);
            row.push(b' ');
        }
        push_integer(row, tag(&mesh.tet_tags, i));
        row.push(b'\n');
    })?;
    if !faces.is_empty() {
        writeln!(out, "Triangles\n{}", faces.len())?;
        write_rows(out, faces.len(), |i, row| {
            for v in faces[i].corners {
                push_integer(row, i64::from(v) + 1);
                row.push(b' ');
            }
            push_integer(row, faces[i].marker);
            row.push(b'\n');
        })?;
    }
    out.write_all(b"End\n")
}
