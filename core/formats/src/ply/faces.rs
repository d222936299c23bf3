//! The faces of a `.ply` file: a surface.

use super::super::surface::{Corners, Surface};
use super::super::text::{capacity, push_integer, push_point, write_rows};
use super::super::{DomainFile, Encoding, Point};
use super::{
    Body, Element, Header, ParseError, Place, Reason, Role, Tokens, body_error, header, skip_rows,
    vertices,
};
use crate::scalar::exact_integer;
use std::io::Write;

/// Reads a `.ply` file as a surface.
pub fn read_domain(bytes: &[u8]) -> Result<DomainFile, ParseError> {
    let Header { ascii, elements, body } = header(bytes)?;
    let mut body = if ascii {
        Body::Text(Tokens::starting_at(bytes, body))
    } else {
        Body::Binary { bytes, next: body }
    };
    let (mut file, mut polygons, mut markers) = (None, Vec::new(), Vec::new());
    let (mut others, mut seen) = (false, false);
    for element in &elements {
        if element.vertex && file.is_none() {
            file = Some(vertices(&mut body, element)?);
        } else if element.face && !seen {
            (polygons, markers) = faces(&mut body, element)?;
            seen = true;
        } else {
            skip_rows(&mut body, element)?;
            others = true;
        }
    }
    body.finish()?;
    let missing = |text: &str| ParseError::new(Place::Header, Reason::Syntax(text.to_owned()));
    let file = file.ok_or_else(|| missing("there is no element `vertex`"))?;
    let mut surface = Surface::new(file.points);
    surface.reserve(polygons.len());
    let (first, last) = (0, surface.points() as i64 - 1);
    for (f, corners) in polygons.into_iter().enumerate() {
        let at = |reason| ParseError::new(Place::Face(f as u64), reason);
        let number = f as u64;
        if let Some(&index) = corners.iter().find(|&&v| v < first || v > last) {
            return Err(at(Reason::Index { what: "face", number, index, first, last }));
        }
        let corners: Vec<u32> = corners.into_iter().map(|v| v as u32).collect();
        let marker = markers.get(f).copied().unwrap_or(0);
        surface.marked_face(Corners::from(&corners[..]), marker).map_err(at)?;
    }
    let mut notes = file.notes;
    if others {
        notes.push("elements other than `vertex` and `face` are not read".to_owned());
    }
    Ok(surface.finish(notes))
}

/// The corners of all faces as the file has them, and their markers if it has any.
type Faces = (Vec<Vec<i64>>, Vec<i32>);

/// Reads the element `face`.
fn faces(body: &mut Body<'_>, element: &Element) -> Result<Faces, ParseError> {
    if !element.properties.iter().any(|p| p.role == Role::Corners) {
        let text = "faces need the list `vertex_indices`";
        return Err(ParseError::new(Place::Header, Reason::Syntax(text.into())));
    }
    let reserve = capacity(element.rows, body.remaining(), 7);
    let (mut polygons, mut markers) = (Vec::with_capacity(reserve), Vec::new());
    for found in 0..element.rows {
        let announced = element.rows;
        let early = Reason::Truncated { what: "faces", announced, found };
        let (corners, marker) =
            face(body, element).map_err(|r| body.error(body_error(r, &early)))?;
        polygons.push(corners);
        markers.extend(marker);
    }
    Ok((polygons, markers))
}

/// One face; its errors are `None` where the file ends.
fn face(body: &mut Body<'_>, element: &Element) -> Result<(Vec<i64>, Option<i32>), Option<Reason>> {
    let (mut corners, mut marker) = (Vec::new(), None);
    let whole = |value: f64| {
        exact_integer(value).ok_or_else(|| Some(Reason::NotAnInteger(format!("{value:?}"))))
    };
    for property in &element.properties {
        match property.role {
            Role::Corners => {
                let count = body.length(property)?;
                corners.reserve(capacity(count, body.remaining(), 1).min(16));
                for _ in 0..count {
                    corners.push(whole(body.float(property.scalar)?)?);
                }
            }
            Role::Marker => {
                let value = whole(body.float(property.scalar)?)?;
                let fits = i32::try_from(value);
                marker = Some(fits.map_err(|_| Some(Reason::NotAnInteger(value.to_string())))?);
            }
            _ => body.skip(property)?,
        }
    }
    Ok((corners, marker))
}

/// Writes a surface with the markers of its faces; binary is little endian.
pub(crate) fn write_surface(
    out: &mut dyn Write,
    points: &[Point],
    faces: &[(&[u32], i32)],
    encoding: Encoding,
) -> std::io::Result<()> {
    super::write_start(out, points.len(), encoding)?;
    writeln!(out, "element face {}\nproperty list uint uint vertex_indices", faces.len())?;
    let marked = faces.iter().any(|&(_, marker)| marker != 0);
    if marked {
        writeln!(out, "property int marker")?;
    }
    out.write_all(b"end_header\n")?;
    write_rows(out, points.len(), |i, row| match encoding {
        Encoding::Ascii => {
            push_point(row, &points[i], b' ');
            row.push(b'\n');
        }
        Encoding::Binary => points[i].iter().for_each(|c| row.extend(c.to_le_bytes())),
    })?;
    write_rows(out, faces.len(), |i, row| {
        let (corners, marker) = faces[i];
        match encoding {
            Encoding::Ascii => {
                push_integer(row, corners.len() as i64);
                for &v in corners {
                    row.push(b' ');
                    push_integer(row, i64::from(v));
                }
                if marked {
                    row.push(b' ');
                    push_integer(row, i64::from(marker));
                }
                row.push(b'\n');
            }
            Encoding::Binary => {
                row.extend((corners.len() as u32).to_le_bytes());
                corners.iter().for_each(|v| row.extend(v.to_le_bytes()));
                if marked {
                    row.extend(marker.to_le_bytes());
                }
            }
        }
    })
}
