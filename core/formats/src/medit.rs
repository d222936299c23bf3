//! `.mesh`: the ASCII format of Medit (INRIA).
//!
//! Sections start with a keyword and a count. `Vertices` (x, y, z, reference) and `Tetrahedra`
//! (four corners numbered from 1, reference) are read; a reference is a tag. References that
//! are all 0 mean no tags, unless the comment `# references are tags` stands before the section,
//! which we write where it is needed. Triangles that are faces of
//! tetrahedra are boundary triangles, their references the markers. Sections of edges, corners and
//! the like are not read; a note says which. Other volume cells are refused. A file ends with
//! `End`.
//! Source: P. Frey, "MEDIT: an interactive mesh visualization software", INRIA RT-0253, 2001.

use super::MeshFile;
use super::error::{ParseError, Reason, excerpt};
use super::faces::owned;
use super::text::{Tokens, capacity, count, float, integer, push_integer, push_point, write_rows};
use ltbw_core::TetMesh;
use ltbw_exact::Point;
use std::io::Write;

/// The comment before a section whose references are tags although all are 0.
const MARK: &[u8] = b"# references are tags";

/// Reads a `.mesh` file.
pub fn read(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let mut tokens = Tokens::new(bytes);
    let mut vertices: Option<(Vec<Point>, Vec<i64>)> = None;
    let mut tetrahedra: Option<(Vec<[i64; 4]>, Vec<i64>)> = None;
    let mut triangles: Option<(Vec<[i64; 3]>, Vec<i64>, usize)> = None;
    let mut section = 0;
    let mut marked = [false; 2];
    let mut notes = Vec::new();
    // Every turn consumes at least a keyword.
    loop {
        let before = tokens.position();
        let Some(keyword) = tokens.next() else {
            return Err(tokens.error(Reason::Syntax("the file ends without `End`".into())));
        };
        let between = &bytes[before..tokens.position() - keyword.len()];
        let mark = between.split(|&b| b == b'\n').any(|line| line.trim_ascii() == MARK);
        match keyword {
            b"MeshVersionFormatted" => drop(number(&mut tokens, keyword, count)?),
            b"Dimension" => {
                let dimension = number(&mut tokens, keyword, count)?;
                if dimension != 3 {
                    let text = format!("points in {dimension} dimensions");
                    return Err(tokens.error(Reason::Unsupported(text)));
                }
            }
            b"Vertices" if vertices.is_none() => {
                marked[0] = mark;
                vertices = Some(read_vertices(&mut tokens)?);
            }
            b"Tetrahedra" if tetrahedra.is_none() => {
                section = tokens.position();
                marked[1] = mark;
                tetrahedra = Some(read_simplices(&mut tokens, keyword, "tetrahedra")?);
            }
            b"Triangles" if triangles.is_none() => {
                let at = tokens.position();
                let (corners, markers) = read_simplices(&mut tokens, keyword, "triangles")?;
                triangles = Some((corners, markers, at));
            }
            b"Hexahedra" | b"Prisms" | b"Pyramids" | b"Vertices" | b"Tetrahedra" | b"Triangles" => {
                let text = format!("this section `{}`", excerpt(keyword));
                return Err(tokens.error(Reason::Unsupported(text)));
            }
            b"End" => break,
            _ if keyword[0].is_ascii_alphabetic() => {
                notes.push(format!("section {} is not read", excerpt(keyword)));
                skip_numbers(&mut tokens);
            }
            _ => {
                let text = format!("`{}` where a keyword was expected", excerpt(keyword));
                return Err(tokens.error(Reason::Syntax(text)));
            }
        }
    }
    if tokens.next().is_some() {
        return Err(tokens.error(Reason::Surplus("section")));
    }
    notes.dedup();
    let Some((points, point_tags)) = vertices else {
        return Err(tokens.error(Reason::Syntax("there is no section `Vertices`".into())));
    };
    let (corners, tet_tags) = tetrahedra.unwrap_or_default();
    let tets =
        number_from_0(&corners, points.len()).map_err(|r| ParseError::at(bytes, section, r))?;
    let (corners, markers, section) = triangles.unwrap_or_default();
    let triangles =
        number_from_0(&corners, points.len()).map_err(|r| ParseError::at(bytes, section, r))?;
    let triangles: Vec<([u32; 3], i64)> = triangles.into_iter().zip(markers).collect();
    let tags = |t: Vec<i64>, mark: bool| (mark || t.iter().any(|&r| r != 0)).then_some(t);
    let (point_tags, tet_tags) = (tags(point_tags, marked[0]), tags(tet_tags, marked[1]));
    let mut mesh = TetMesh { points, tets, point_tags, tet_tags, ..TetMesh::default() };
    let note;
    (mesh.faces, note) = owned(&mesh, &triangles);
    notes.extend(note);
    Ok(MeshFile { mesh, notes, names: Vec::new() })
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

/// Corners and references of tetrahedra or triangles.
type Simplices<const N: usize> = (Vec<[i64; N]>, Vec<i64>);

fn read_simplices<const N: usize>(
    tokens: &mut Tokens<'_>,
    keyword: &[u8],
    what: &'static str,
) -> Result<Simplices<N>, ParseError> {
    let announced = number(tokens, keyword, count)?;
    let reserve = capacity(announced, tokens.remaining(), 10);
    let (mut tets, mut tags) = (Vec::with_capacity(reserve), Vec::with_capacity(reserve));
    for found in 0..announced {
        truncated(tokens, what, announced, found)?;
        let mut tet = [0; N];
        for corner in &mut tet {
            *corner = number(tokens, keyword, integer)?;
        }
        tets.push(tet);
        tags.push(number(tokens, keyword, integer)?);
    }
    Ok((tets, tags))
}

/// Corners numbered from 1 as indices from 0, all below `points`.
fn number_from_0<const N: usize>(
    corners: &[[i64; N]],
    points: usize,
) -> Result<Vec<[u32; N]>, Reason> {
    let last = u32::try_from(points).map_err(|_| Reason::TooManyPoints(points as u64))?;
    let mut tets = Vec::with_capacity(corners.len());
    for (row, tet) in corners.iter().enumerate() {
        if let Some(&index) = tet.iter().find(|&&v| v < 1 || v > i64::from(last)) {
            let (number, last) = (row as u64 + 1, i64::from(last));
            let what = if N == 4 { "tetrahedron" } else { "triangle" };
            return Err(Reason::Index { what, number, index, first: 1, last });
        }
        tets.push(tet.map(|v| (v - 1) as u32));
    }
    Ok(tets)
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
