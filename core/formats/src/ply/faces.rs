//! The faces of a `.ply` file: a surface.

use super::super::groups::Groups;
use super::super::surface::{Corners, Face, Surface};
use super::super::text::{capacity, push_integer, push_point, write_rows};
use super::super::{DomainFile, Encoding, Point};
use super::{
    Body, Element, Header, ParseError, Place, Reason, Role, Rows, Tokens, body_error, header,
    skip_rows, vertices,
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
    let (mut file, mut lists) = (None, Vec::new());
    let (mut others, mut seen) = (false, false);
    for element in &elements {
        match element.holds {
            Rows::Vertices if file.is_none() => file = Some(vertices(&mut body, element)?),
            Rows::Faces if !seen => {
                lists.push((Rows::Faces, faces(&mut body, element)?));
                seen = true;
            }
            holds @ (Rows::Strips | Rows::Fans) => {
                lists.push((holds, faces(&mut body, element)?));
            }
            _ => {
                skip_rows(&mut body, element)?;
                others = true;
            }
        }
    }
    body.finish()?;
    let missing = |text: &str| ParseError::new(Place::Header, Reason::Syntax(text.to_owned()));
    let file = file.ok_or_else(|| missing("there is no element `vertex`"))?;
    let mut surface = Surface::new(file.points);
    surface.reserve(lists.iter().map(|(_, faces)| faces.corners.len()).sum());
    let mut groups = Groups::default();
    for (holds, faces) in lists {
        for (row, corners) in faces.corners.iter().enumerate() {
            groups.begin(faces.groups.get(row).map_or("", String::as_str));
            let marker = faces.markers.get(row).copied().unwrap_or(0);
            let added = match holds {
                Rows::Faces => corners_of(corners, surface.points(), "face", row)
                    .and_then(|c| surface.marked_face(Corners::from(&c[..]), marker)),
                _ => corners.split(|&v| v == BREAK).try_for_each(|part| {
                    let what = if holds == Rows::Fans { "fan" } else { "strip" };
                    let part = corners_of(part, surface.points(), what, row)?;
                    match holds {
                        Rows::Fans => surface.fan(&part, marker),
                        _ => surface.strip(&part, marker),
                    }
                    Ok(())
                }),
            };
            added.map_err(|reason| match faces.ends.get(row) {
                Some(&end) => body.error_at(end, reason),
                None => ParseError::new(Place::Face(row as u64), reason),
            })?;
            groups.take(surface.faces());
        }
    }
    let mut notes = file.notes;
    if others {
        notes.push("elements other than vertices and faces are not read".to_owned());
    }
    Ok(surface.grouped(groups).finish(notes))
}

/// The number that stands between the strips or fans of a list.
const BREAK: i64 = -1;

/// Corners as indices of `points` vertices, of the row `number` of an element.
fn corners_of(
    corners: &[i64],
    points: usize,
    what: &'static str,
    number: usize,
) -> Result<Vec<u32>, Reason> {
    let (number, first, last) = (number as u64, 0, points as i64 - 1);
    match corners.iter().find(|&&v| v < first || v > last) {
        Some(&index) => Err(Reason::Index { what, number, index, first, last }),
        None => Ok(corners.iter().map(|&v| v as u32).collect()),
    }
}

/// The rows of an element of faces, as the file has them.
#[derive(Default)]
struct Faces {
    corners: Vec<Vec<i64>>,
    /// Markers, if the element has any.
    markers: Vec<i32>,
    /// Names of groups, if the element has any.
    groups: Vec<String>,
    /// Where each row ends; of faces, which are many, this is not kept.
    ends: Vec<usize>,
}

/// Reads an element of faces, strips or fans.
fn faces(body: &mut Body<'_>, element: &Element) -> Result<Faces, ParseError> {
    if !element.properties.iter().any(|p| p.role == Role::Corners) {
        let text = "faces need the list `vertex_indices`";
        return Err(ParseError::new(Place::Header, Reason::Syntax(text.into())));
    }
    let mut faces = Faces::default();
    faces.corners.reserve_exact(capacity(element.rows, body.remaining(), 7));
    for found in 0..element.rows {
        let announced = element.rows;
        let early = Reason::Truncated { what: "faces", announced, found };
        let own = face(body, element).map_err(|r| body.error(body_error(r, &early)))?;
        faces.corners.push(own.corners);
        faces.markers.extend(own.marker);
        faces.groups.extend(own.group.filter(|_| own.marker.is_none()));
        if element.holds != Rows::Faces {
            faces.ends.push(body.position());
        }
    }
    Ok(faces)
}

/// A row of an element of faces.
#[derive(Default)]
struct Row {
    corners: Vec<i64>,
    marker: Option<i32>,
    group: Option<String>,
}

/// One face; its errors are `None` where the file ends.
fn face(body: &mut Body<'_>, element: &Element) -> Result<Row, Option<Reason>> {
    let (mut row, mut colour) = (Row::default(), [None; 3]);
    let whole = |value: f64| {
        exact_integer(value).ok_or_else(|| Some(Reason::NotAnInteger(format!("{value:?}"))))
    };
    for property in &element.properties {
        match property.role {
            Role::Corners => {
                let count = body.length(property)?;
                row.corners.reserve(capacity(count, body.remaining(), 1).min(16));
                for _ in 0..count {
                    row.corners.push(whole(body.float(property.scalar)?)?);
                }
            }
            Role::Marker => {
                let value = whole(body.float(property.scalar)?)?;
                let fits = i32::try_from(value);
                row.marker = Some(fits.map_err(|_| Some(Reason::NotAnInteger(value.to_string())))?);
            }
            Role::Group(word) if row.group.is_none() => {
                row.group = Some(format!("{word} {}", body.float(property.scalar)?));
            }
            Role::Colour(k) => colour[k] = Some(body.float(property.scalar)?),
            _ => body.skip(property)?,
        }
    }
    if let ([Some(r), Some(g), Some(b)], None) = (colour, &row.group) {
        row.group = Some(format!("colour {r} {g} {b}"));
    }
    Ok(row)
}

/// Writes a surface with the markers of its faces; binary is little endian.
pub(crate) fn write_surface(
    out: &mut dyn Write,
    points: &[Point],
    faces: &[Face<'_>],
    encoding: Encoding,
) -> std::io::Result<()> {
    super::write_start(out, points.len(), encoding)?;
    writeln!(out, "element face {}\nproperty list uint uint vertex_indices", faces.len())?;
    let marked = faces.iter().any(|face| face.marker != 0);
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
        let Face { corners, marker } = faces[i];
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
