//! Writing `.vtu` files: appended raw arrays, or text.

use super::TETRAHEDRON;
use crate::TetMesh;
use crate::io::Encoding;
use crate::io::text::{push_integer, push_point, write_rows};
use std::io::Write;

/// Writes the row of a number as text or as bytes.
type Row<'a> = Box<dyn Fn(usize, &mut Vec<u8>) + Sync + 'a>;

/// An array of a grid.
struct Array<'a> {
    /// The element that it stands in, with its attributes.
    section: &'static str,
    name: &'static str,
    kind: &'static str,
    rows: usize,
    /// Bytes of a row in binary.
    width: usize,
    row: Row<'a>,
}

/// Writes a `.vtu` file.
///
/// Binary: integers of the connectivity take 4 bytes where they fit, else 8.
///
/// # Errors
/// Those of `out`.
pub fn write(out: &mut dyn Write, mesh: &TetMesh, encoding: Encoding) -> std::io::Result<()> {
    let arrays = arrays(mesh, encoding);
    let header = match encoding {
        Encoding::Binary => " header_type=\"UInt64\"",
        Encoding::Ascii => "",
    };
    write!(
        out,
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\"{header}>\n\
         <UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
        mesh.points.len(),
        mesh.tets.len()
    )?;
    let mut offset = 0;
    for (k, array) in arrays.iter().enumerate() {
        let Array { section, name, kind, rows, width, row } = array;
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
        offset += 8 + rows * width;
        if arrays.get(k + 1).is_none_or(|next| next.section != *section) {
            let element = section.split(' ').next().unwrap_or_default();
            writeln!(out, "</{element}>")?;
        }
    }
    out.write_all(b"</Piece>\n</UnstructuredGrid>\n")?;
    if encoding == Encoding::Binary {
        out.write_all(b"<AppendedData encoding=\"raw\">\n_")?;
        for Array { rows, width, row, .. } in &arrays {
            out.write_all(&((rows * width) as u64).to_le_bytes())?;
            write_rows(out, *rows, row)?;
        }
        out.write_all(b"\n</AppendedData>\n")?;
    }
    out.write_all(b"</VTKFile>\n")
}

/// The arrays of a grid: the points first.
fn arrays(mesh: &TetMesh, encoding: Encoding) -> Vec<Array<'_>> {
    let TetMesh { points, tets, point_tags, tet_tags } = mesh;
    let ascii = encoding == Encoding::Ascii;
    let wide = ascii || i32::try_from(points.len().max(4 * tets.len())).is_err();
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
    let (int, bytes) = if wide { ("Int64", 8) } else { ("Int32", 4) };
    let array =
        |section, name, kind, rows, width, row| Array { section, name, kind, rows, width, row };
    let coordinates: Row<'_> = Box::new(move |i, row| {
        if ascii {
            push_point(row, &points[i], b' ');
            row.push(b'\n');
        } else {
            points[i].iter().for_each(|c| row.extend(c.to_le_bytes()));
        }
    });
    let corners: Row<'_> = Box::new(move |i, row| {
        for (k, &v) in tets[i].iter().enumerate() {
            index(v as usize, row);
            // Four on a line.
            if let (true, true, Some(end)) = (ascii, k < 3, row.last_mut()) {
                *end = b' ';
            }
        }
    });
    let types: Row<'_> = Box::new(move |_, row| {
        if ascii {
            push_integer(row, TETRAHEDRON);
            row.push(b'\n');
        } else {
            row.push(TETRAHEDRON as u8);
        }
    });
    let offsets: Row<'_> = Box::new(move |i, row| index(4 * (i + 1), row));
    let mut arrays = vec![
        array("Points", "Points", "Float64", points.len(), 24, coordinates),
        array("Cells", "connectivity", int, tets.len(), 4 * bytes, corners),
        array("Cells", "offsets", int, tets.len(), bytes, offsets),
        array("Cells", "types", "UInt8", tets.len(), 1, types),
    ];
    let tags = [
        ("PointData Scalars=\"tag\"", "tag", point_tags),
        ("CellData Scalars=\"region\"", "region", tet_tags),
    ];
    for (section, name, tags) in tags {
        let Some(tags) = tags else { continue };
        let values: Row<'_> = Box::new(move |i, row| {
            if ascii {
                push_integer(row, tags[i]);
                row.push(b'\n');
            } else {
                row.extend(tags[i].to_le_bytes());
            }
        });
        arrays.push(array(section, name, "Int64", tags.len(), 8, values));
    }
    arrays
}
