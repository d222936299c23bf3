//! Writing `.vtu` files: appended raw arrays, or text.
//!
//! Boundary triangles follow the tetrahedra as cells. Arrays of cells have a value for every cell,
//! so a triangle has those of its tetrahedron, and looks like it; tetrahedra have the marker 0.

use super::{TETRAHEDRON, TRIANGLE, names};
use crate::parted::{Border, Piece};
use crate::text::{push_float, push_integer, push_point, write_rows};
use crate::{Encoding, GroupName, carried};
use ltbw_core::TetMesh;
use ltbw_domain::quality::Array;
use std::io::Write;

/// The sections of points' data: with tags, with numbers, with both.
const TAGS: &str = "PointData Scalars=\"tag\"";
const NUMBERS: &str = "PointData GlobalIds=\"GlobalPointIds\"";
const TAGS_AND_NUMBERS: &str = "PointData Scalars=\"tag\" GlobalIds=\"GlobalPointIds\"";

/// The section of cells' data, where there are regions and where not.
const REGIONS: &str = "CellData Scalars=\"region\"";
const CELLS: &str = "CellData";

/// Writes the row of a number as text or as bytes.
type Row<'a> = Box<dyn Fn(usize, &mut Vec<u8>) + Sync + 'a>;

/// An array of a grid.
struct Column<'a> {
    /// The element that it stands in, with its attributes.
    section: &'static str,
    name: &'a str,
    /// The type, and what else is told of it.
    kind: &'static str,
    rows: usize,
    /// Bytes of all rows in binary.
    bytes: usize,
    row: Row<'a>,
}

/// Writes a `.vtu` file, the boundary as triangles with an array `marker`.
///
/// Binary: integers of the connectivity take 4 bytes where they fit, else 8.
///
/// # Errors
/// Those of `out`.
pub fn write(out: &mut dyn Write, mesh: &TetMesh, encoding: Encoding) -> std::io::Result<()> {
    write_with(out, mesh, &[], encoding)
}

/// Writes the part of a mesh that a worker has, with the worker's number at each tetrahedron, and
/// with those of its points in the whole and of their owners.
pub(crate) fn write_part(
    out: &mut dyn Write,
    piece: &Piece,
    border: &Border,
    worker: u32,
) -> std::io::Result<()> {
    let Piece { mesh, numbers } = piece;
    let owners = border.owners(worker, mesh.points.len());
    let cells = mesh.tets.len() + mesh.faces.len();
    let mut arrays = geometry(mesh, Encoding::Binary);
    let points = arrays.len();
    arrays.extend(data(mesh, &[], Encoding::Binary));
    let section = match arrays.get_mut(points).filter(|array| array.section == TAGS) {
        Some(tags) => {
            tags.section = TAGS_AND_NUMBERS;
            TAGS_AND_NUMBERS
        }
        None => NUMBERS,
    };
    let ids = Column {
        section,
        name: "GlobalPointIds",
        kind: "Int64\" IdType=\"1",
        rows: numbers.len(),
        bytes: 8 * numbers.len(),
        row: Box::new(move |k, row| row.extend(i64::from(numbers[k]).to_le_bytes())),
    };
    let after = if section == NUMBERS { points } else { points + 1 };
    let owners = Column {
        section,
        name: "owner",
        kind: "Int32",
        rows: owners.len(),
        bytes: 4 * owners.len(),
        row: Box::new(move |k, row| row.extend(owners[k].to_le_bytes())),
    };
    arrays.splice(after..after, [ids, owners]);
    arrays.push(Column {
        section: if mesh.tet_tags.is_some() { REGIONS } else { CELLS },
        name: "worker",
        kind: "Int32",
        rows: cells,
        bytes: 4 * cells,
        row: Box::new(move |_, row| row.extend(worker.to_le_bytes())),
    });
    let sizes = Sizes { points: mesh.points.len(), cells };
    write_arrays(out, sizes, &arrays, Encoding::Binary, Beside::default())
}

/// Writes a `.vtu` file as [`write()`] does, with figures of the tetrahedra.
///
/// # Errors
/// Those of `out`.
pub fn write_with(
    out: &mut dyn Write,
    mesh: &TetMesh,
    values: &[Array],
    encoding: Encoding,
) -> std::io::Result<()> {
    write_beside(out, mesh, values, Beside::default(), encoding)
}

/// The things that a file has beside its arrays.
#[derive(Default)]
pub(crate) struct Beside<'a> {
    /// The hash of the mesh, in a comment.
    pub(crate) hash: Option<&'a str>,
    /// Names of groups, in field data.
    pub(crate) names: &'a [GroupName],
}

/// Writes arrays and what is beside them.
pub(crate) fn write_beside(
    out: &mut dyn Write,
    mesh: &TetMesh,
    values: &[Array],
    beside: Beside<'_>,
    encoding: Encoding,
) -> std::io::Result<()> {
    let mut arrays = geometry(mesh, encoding);
    arrays.extend(data(mesh, values, encoding));
    let sizes = Sizes { points: mesh.points.len(), cells: mesh.tets.len() + mesh.faces.len() };
    write_arrays(out, sizes, &arrays, encoding, beside)
}

/// The size of a grid.
struct Sizes {
    points: usize,
    cells: usize,
}

/// Writes a grid of one piece.
fn write_arrays(
    out: &mut dyn Write,
    Sizes { points, cells }: Sizes,
    arrays: &[Column<'_>],
    encoding: Encoding,
    beside: Beside<'_>,
) -> std::io::Result<()> {
    let comment = beside.hash.map(|hash| format!("<!-- {} -->\n", carried::line(hash)));
    let header = match encoding {
        Encoding::Binary => " header_type=\"UInt64\"",
        Encoding::Ascii => "",
    };
    write!(
        out,
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
         byte_order=\"LittleEndian\"{header}>\n{}<UnstructuredGrid>\n",
        comment.unwrap_or_default()
    )?;
    names::write(out, beside.names)?;
    writeln!(out, "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">")?;
    let mut offset = 0;
    for (k, array) in arrays.iter().enumerate() {
        let Column { section, name, kind, rows, bytes, row } = array;
        // Several arrays may stand in one section.
        if k == 0 || arrays[k - 1].section != *section {
            writeln!(out, "<{section}>")?;
        }
        let components = if k == 0 { " NumberOfComponents=\"3\"" } else { "" };
        write!(out, "<DataArray type=\"{kind}\" Name=\"{name}\"{components} format=")?;
        match encoding {
            Encoding::Binary => writeln!(out, "\"appended\" offset=\"{offset}\"/>")?,
            Encoding::Ascii => {
                out.write_all(b"\"ascii\">\n")?;
                write_rows(out, *rows, row)?;
                out.write_all(b"</DataArray>\n")?;
            }
        }
        offset += 8 + bytes;
        if arrays.get(k + 1).is_none_or(|next| next.section != *section) {
            let element = section.split(' ').next().unwrap_or_default();
            writeln!(out, "</{element}>")?;
        }
    }
    out.write_all(b"</Piece>\n</UnstructuredGrid>\n")?;
    if encoding == Encoding::Binary {
        out.write_all(b"<AppendedData encoding=\"raw\">\n_")?;
        for Column { rows, bytes, row, .. } in arrays {
            out.write_all(&(*bytes as u64).to_le_bytes())?;
            write_rows(out, *rows, row)?;
        }
        out.write_all(b"\n</AppendedData>\n")?;
    }
    out.write_all(b"</VTKFile>\n")
}

/// The arrays of points and cells: the points first.
fn geometry(mesh: &TetMesh, encoding: Encoding) -> Vec<Column<'_>> {
    let (points, tets, faces) = (&mesh.points, &mesh.tets, &mesh.faces);
    let (cells, corner_count) = (tets.len() + faces.len(), 4 * tets.len() + 3 * faces.len());
    let ascii = encoding == Encoding::Ascii;
    let wide = ascii || i32::try_from(points.len().max(corner_count)).is_err();
    let index = move |value: usize, row: &mut Vec<u8>| {
        if ascii {
            push_integer(row, value as i64);
            row.push(b'\n');
        } else if wide {
            row.extend((value as i64).to_le_bytes());
        } else {
            row.extend((value as i32).to_le_bytes());
        }
    };
    let (int, width) = if wide { ("Int64", 8) } else { ("Int32", 4) };
    let coordinates: Row<'_> = Box::new(move |i, row| {
        if ascii {
            push_point(row, &points[i], b' ');
            row.push(b'\n');
        } else {
            points[i].iter().for_each(|c| row.extend(c.to_le_bytes()));
        }
    });
    let corners: Row<'_> = Box::new(move |i, row| {
        let corners: &[u32] = match tets.get(i) {
            Some(tet) => tet,
            None => &faces[i - tets.len()].corners,
        };
        for (k, &v) in corners.iter().enumerate() {
            index(v as usize, row);
            // The corners of a cell stand on one line.
            if let (true, true, Some(end)) = (ascii, k + 1 < corners.len(), row.last_mut()) {
                *end = b' ';
            }
        }
    });
    let types: Row<'_> = Box::new(move |i, row| {
        let kind = if i < tets.len() { TETRAHEDRON } else { TRIANGLE };
        if ascii {
            push_integer(row, kind);
            row.push(b'\n');
        } else {
            row.push(kind as u8);
        }
    });
    let offsets: Row<'_> = Box::new(move |i, row| {
        let more = (i + 1).saturating_sub(tets.len());
        index(4 * (i + 1 - more) + 3 * more, row);
    });
    let array =
        |section, name, kind, rows, bytes, row| Column { section, name, kind, rows, bytes, row };
    vec![
        array("Points", "Points", "Float64", points.len(), 24 * points.len(), coordinates),
        array("Cells", "connectivity", int, cells, width * corner_count, corners),
        array("Cells", "offsets", int, cells, width * cells, offsets),
        array("Cells", "types", "UInt8", cells, cells, types),
    ]
}

/// The arrays of tags, markers and figures.
fn data<'a>(mesh: &'a TetMesh, values: &'a [Array], encoding: Encoding) -> Vec<Column<'a>> {
    let (tets, faces) = (mesh.tets.len(), &mesh.faces);
    let ascii = encoding == Encoding::Ascii;
    let integers =
        move |section, name, rows: usize, value: Box<dyn Fn(usize) -> i64 + Sync + 'a>| {
            let row: Row<'a> = Box::new(move |i, row| {
                if ascii {
                    push_integer(row, value(i));
                    row.push(b'\n');
                } else {
                    row.extend(value(i).to_le_bytes());
                }
            });
            Column { section, name, kind: "Int64", rows, bytes: 8 * rows, row }
        };
    let cells = tets + faces.len();
    // The tetrahedron that a cell is or belongs to.
    let owner = move |i: usize| if i < tets { i } else { faces[i - tets].tet };
    let mut arrays = Vec::new();
    if let Some(tags) = &mesh.point_tags {
        arrays.push(integers(TAGS, "tag", tags.len(), Box::new(move |i| tags[i])));
    }
    let section = match mesh.tet_tags {
        Some(_) => REGIONS,
        None => CELLS,
    };
    if let Some(tags) = &mesh.tet_tags {
        arrays.push(integers(section, "region", cells, Box::new(move |i| tags[owner(i)])));
    }
    if !faces.is_empty() {
        let marker = move |i: usize| if i < tets { 0 } else { faces[i - tets].marker };
        arrays.push(integers(section, "marker", cells, Box::new(marker)));
    }
    let attributes = mesh.tet_attributes.iter().map(|values| ("attribute", values));
    for (name, values) in attributes.chain(values.iter().map(|array| (array.name, &array.values))) {
        let row: Row<'a> = Box::new(move |i, row| {
            let value = values[owner(i)];
            if ascii {
                push_float(row, value);
                row.push(b'\n');
            } else {
                row.extend(value.to_le_bytes());
            }
        });
        let (kind, bytes) = ("Float64", 8 * cells);
        arrays.push(Column { section, name, kind, rows: cells, bytes, row });
    }
    arrays
}
