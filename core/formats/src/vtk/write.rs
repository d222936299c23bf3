//! Writing `.vtk` files of version 5.1: text or big-endian binary.

use crate::Encoding;
use crate::surface::Face;
use crate::text::{push_float, push_integer, push_point, write_rows};
use ltbw_core::TetMesh;
use ltbw_domain::quality::Array;
use ltbw_exact::Point;
use std::io::{Result, Write};

/// The destination of a file.
struct Sink<'a> {
    out: &'a mut dyn Write,
    ascii: bool,
}

impl Sink<'_> {
    fn header(&mut self, dataset: &str, points: &[Point]) -> Result<()> {
        let form = if self.ascii { "ASCII" } else { "BINARY" };
        let count = points.len();
        write!(
            self.out,
            "# vtk DataFile Version 5.1\nltbw\n{form}\nDATASET {dataset}\nPOINTS {count} double\n"
        )?;
        let ascii = self.ascii;
        write_rows(self.out, count, |i, row| {
            if ascii {
                push_point(row, &points[i], b' ');
                row.push(b'\n');
            } else {
                points[i].iter().for_each(|c| row.extend(c.to_be_bytes()));
            }
        })?;
        self.out.write_all(b"\n")
    }

    /// Lists of corners: `ends` tells where the list of a cell ends.
    fn cells(
        &mut self,
        keyword: &str,
        cells: usize,
        corners: usize,
        end: impl Fn(usize) -> usize + Sync,
        list: impl Fn(usize, &mut dyn FnMut(u32)) + Sync,
    ) -> Result<()> {
        writeln!(self.out, "{keyword} {} {corners}\nOFFSETS vtktypeint64", cells + 1)?;
        let offset = |i: usize| i.checked_sub(1).map_or(0, &end) as i64;
        self.integers(cells + 1, offset)?;
        self.out.write_all(b"CONNECTIVITY vtktypeint64\n")?;
        let ascii = self.ascii;
        write_rows(self.out, cells, |i, row| {
            list(i, &mut |corner| {
                if ascii {
                    push_integer(row, i64::from(corner));
                    row.push(b' ');
                } else {
                    row.extend(i64::from(corner).to_be_bytes());
                }
            });
            if let (true, Some(last)) = (ascii, row.last_mut()) {
                *last = b'\n';
            }
        })?;
        self.out.write_all(b"\n")
    }

    /// Integers of 64 bits.
    fn integers(&mut self, rows: usize, value: impl Fn(usize) -> i64 + Sync) -> Result<()> {
        let ascii = self.ascii;
        write_rows(self.out, rows, |i, row| {
            if ascii {
                push_integer(row, value(i));
                row.push(b'\n');
            } else {
                row.extend(value(i).to_be_bytes());
            }
        })?;
        self.out.write_all(b"\n")
    }

    /// Doubles.
    fn floats(&mut self, rows: usize, value: impl Fn(usize) -> f64 + Sync) -> Result<()> {
        let ascii = self.ascii;
        write_rows(self.out, rows, |i, row| {
            if ascii {
                push_float(row, value(i));
                row.push(b'\n');
            } else {
                row.extend(value(i).to_be_bytes());
            }
        })?;
        self.out.write_all(b"\n")
    }
}

/// Writes a mesh: tags as the array `tag` of points, regions as `region`, their attributes as
/// `attribute`, boundary triangles as
/// cells behind the tetrahedra with the array `marker`, and figures of the tetrahedra, all as in
/// `.vtu`.
///
/// # Errors
/// Those of `out`.
pub fn write_with(
    out: &mut dyn Write,
    mesh: &TetMesh,
    values: &[Array],
    encoding: Encoding,
) -> Result<()> {
    let mut sink = Sink { out, ascii: encoding == Encoding::Ascii };
    let (tets, faces) = (&mesh.tets, &mesh.faces);
    let cells = tets.len() + faces.len();
    sink.header("UNSTRUCTURED_GRID", &mesh.points)?;
    let end = |i: usize| {
        let more = (i + 1).saturating_sub(tets.len());
        4 * (i + 1 - more) + 3 * more
    };
    let list = |i: usize, push: &mut dyn FnMut(u32)| match tets.get(i) {
        Some(tet) => tet.iter().for_each(|&v| push(v)),
        None => faces[i - tets.len()].corners.iter().for_each(|&v| push(v)),
    };
    sink.cells("CELLS", cells, 4 * tets.len() + 3 * faces.len(), end, list)?;
    writeln!(sink.out, "CELL_TYPES {cells}")?;
    let ascii = sink.ascii;
    write_rows(sink.out, cells, |i, row| {
        let kind = if i < tets.len() { 10_i32 } else { 5 };
        if ascii {
            push_integer(row, i64::from(kind));
            row.push(b'\n');
        } else {
            row.extend(kind.to_be_bytes());
        }
    })?;
    sink.out.write_all(b"\n")?;
    if let Some(tags) = &mesh.point_tags {
        let rows = tags.len();
        writeln!(sink.out, "POINT_DATA {rows}\nFIELD FieldData 1\ntag 1 {rows} vtktypeint64")?;
        sink.integers(rows, |i| tags[i])?;
    }
    // A triangle has the values of its tetrahedron.
    let owner = |i: usize| if i < tets.len() { i } else { faces[i - tets.len()].tet };
    let attributes = mesh.tet_attributes.iter().map(|values| ("attribute", values));
    let floats: Vec<(&str, &Vec<f64>)> =
        attributes.chain(values.iter().map(|array| (array.name, &array.values))).collect();
    let arrays =
        usize::from(mesh.tet_tags.is_some()) + usize::from(!faces.is_empty()) + floats.len();
    if arrays == 0 {
        return Ok(());
    }
    writeln!(sink.out, "CELL_DATA {cells}\nFIELD FieldData {arrays}")?;
    if let Some(tags) = &mesh.tet_tags {
        writeln!(sink.out, "region 1 {cells} vtktypeint64")?;
        sink.integers(cells, |i| tags[owner(i)])?;
    }
    if !faces.is_empty() {
        writeln!(sink.out, "marker 1 {cells} vtktypeint64")?;
        let marker = |i: usize| i.checked_sub(tets.len()).map_or(0, |f| faces[f].marker);
        sink.integers(cells, marker)?;
    }
    for (name, values) in floats {
        writeln!(sink.out, "{name} 1 {cells} double")?;
        sink.floats(cells, |i| values[owner(i)])?;
    }
    Ok(())
}

/// Writes a surface: polygons, and their markers if some are not 0.
pub(crate) fn write_surface(
    out: &mut dyn Write,
    points: &[Point],
    faces: &[Face<'_>],
    encoding: Encoding,
) -> Result<()> {
    let mut sink = Sink { out, ascii: encoding == Encoding::Ascii };
    sink.header("POLYDATA", points)?;
    let ends: Vec<usize> = faces
        .iter()
        .scan(0, |end, face| {
            *end += face.corners.len();
            Some(*end)
        })
        .collect();
    let corners = ends.last().copied().unwrap_or(0);
    let list = |i: usize, push: &mut dyn FnMut(u32)| faces[i].corners.iter().for_each(|&v| push(v));
    sink.cells("POLYGONS", faces.len(), corners, |i| ends[i], list)?;
    if faces.iter().all(|face| face.marker == 0) {
        return Ok(());
    }
    let rows = faces.len();
    writeln!(sink.out, "CELL_DATA {rows}\nFIELD FieldData 1\nmarker 1 {rows} vtktypeint64")?;
    sink.integers(rows, |i| i64::from(faces[i].marker))
}
