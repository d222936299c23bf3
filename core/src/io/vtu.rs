//! `.vtu`: VTK's XML format of unstructured grids, which ParaView opens.
//!
//! Written: one piece, ASCII arrays, `Float64` points, `Int64` arrays named `tag` (points) and
//! `region` (cells) where there are tags. Read: ASCII arrays in any number of pieces; tetrahedra
//! (VTK type 10) become the mesh; cells of dimension 0 to 2 and other arrays are not read, and a
//! note says so; other cells are refused.
//! Source: the VTK file formats page of the VTK documentation.

use super::MeshFile;
use super::error::{ParseError, Reason, excerpt, one_line};
use super::text::{Tokens, count, float, integer, push_integer, push_point, write_rows};
use crate::{Point, TetMesh};
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use std::io::Write;

/// VTK's number for a tetrahedron.
const TETRAHEDRON: i64 = 10;

/// The arrays of a piece that are read.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Wanted {
    Points,
    Connectivity,
    Offsets,
    Types,
    Tags,
    Regions,
}

/// A piece of a grid as the file tells it, before it is checked.
#[derive(Default)]
struct Piece {
    /// Where it starts in the file.
    offset: usize,
    points: u64,
    cells: u64,
    coordinates: Vec<f64>,
    connectivity: Vec<i64>,
    offsets: Vec<i64>,
    types: Vec<i64>,
    tags: Option<Vec<i64>>,
    regions: Option<Vec<i64>>,
}

/// What has been read so far.
struct State<'a> {
    bytes: &'a [u8],
    /// Names of the open elements, outermost first.
    open: Vec<String>,
    piece: Option<Piece>,
    /// The array that is being read, if it is one that is wanted.
    wanted: Option<Wanted>,
    pieces: usize,
    mesh: TetMesh,
    other_arrays: bool,
    other_cells: bool,
}

/// Reads a `.vtu` file.
pub fn read(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let valid = e.valid_up_to();
        let appended = bytes[..valid].windows(13).any(|w| w == b"<AppendedData");
        let reason = if appended {
            Reason::Unsupported("appended binary data; save the file in ASCII mode".into())
        } else {
            Reason::Syntax("not UTF-8 text".into())
        };
        ParseError::at(bytes, valid, reason)
    })?;
    let mut reader = Reader::from_str(text);
    let mut state = State {
        bytes,
        open: Vec::new(),
        piece: None,
        wanted: None,
        pieces: 0,
        mesh: TetMesh::default(),
        other_arrays: false,
        other_cells: false,
    };
    let mut finished = false;
    // Every event but the last consumes at least a byte.
    loop {
        let offset = reader.buffer_position() as usize;
        let at = |reason| ParseError::at(bytes, offset, reason);
        let event = reader
            .read_event()
            .map_err(|e| ParseError::at(bytes, reader.error_position() as usize, malformed(&e)))?;
        match event {
            Event::Start(element) => state.start(&element, offset).map_err(at)?,
            Event::Empty(element) => {
                state.start(&element, offset).map_err(at)?;
                finished |= state.end()?;
            }
            Event::End(_) => finished |= state.end()?,
            Event::Text(text) => state.text(&text, offset)?,
            Event::CData(_) | Event::GeneralRef(_) if state.wanted.is_some() => {
                return Err(at(Reason::Unsupported("CDATA or entities in an array".into())));
            }
            Event::Eof => break,
            _ => {}
        }
    }
    if !finished {
        let text = "the file ends before the end of a VTKFile element";
        return Err(ParseError::at(bytes, bytes.len(), Reason::Syntax(text.into())));
    }
    let mut notes = Vec::new();
    if state.other_arrays {
        notes.push("arrays other than `tag` of points and `region` of cells are not read".into());
    }
    if state.other_cells {
        notes.push("cells that are not tetrahedra are not read".into());
    }
    Ok(MeshFile { mesh: state.mesh, notes })
}

/// What the XML parser complains about, cut to a line.
fn malformed(error: &dyn std::error::Error) -> Reason {
    Reason::Syntax(format!("not well-formed XML: {}", one_line(&error.to_string(), 120)))
}

/// The value of an attribute, if the element has it.
fn attribute(element: &BytesStart<'_>, name: &str) -> Result<Option<String>, Reason> {
    match element.try_get_attribute(name) {
        Ok(Some(a)) => Ok(Some(a.value.trim().to_owned())),
        Ok(None) => Ok(None),
        Err(e) => Err(malformed(&e)),
    }
}

fn count_attribute(element: &BytesStart<'_>, name: &str) -> Result<u64, Reason> {
    match attribute(element, name)? {
        Some(value) => count(value.as_bytes()),
        None => Err(Reason::Syntax(format!("a piece without the attribute `{name}`"))),
    }
}

impl State<'_> {
    fn start(&mut self, element: &BytesStart<'_>, offset: usize) -> Result<(), Reason> {
        let name = element.name().into_inner();
        match (self.open.last().map(String::as_str), name) {
            (None, "VTKFile") => {
                let kind = attribute(element, "type")?.unwrap_or_default();
                if kind != "UnstructuredGrid" {
                    let text = format!("a VTK file of type `{}`", excerpt(kind.as_bytes()));
                    return Err(Reason::Unsupported(text));
                }
            }
            (None, _) => return Err(Reason::Syntax("not a VTK file".into())),
            (Some("UnstructuredGrid"), "Piece") => {
                self.piece = Some(Piece {
                    offset,
                    points: count_attribute(element, "NumberOfPoints")?,
                    cells: count_attribute(element, "NumberOfCells")?,
                    ..Piece::default()
                });
            }
            (Some(section), "DataArray" | "Array") => {
                self.wanted = None;
                let array = attribute(element, "Name")?.unwrap_or_default();
                let wanted = match (section, array.as_str()) {
                    ("Points", _) => Wanted::Points,
                    ("Cells", "connectivity") => Wanted::Connectivity,
                    ("Cells", "offsets") => Wanted::Offsets,
                    ("Cells", "types") => Wanted::Types,
                    ("PointData", "tag") => Wanted::Tags,
                    ("CellData", "region") => Wanted::Regions,
                    _ => {
                        self.other_arrays = true;
                        self.open.push(name.to_owned());
                        return Ok(());
                    }
                };
                self.start_array(element, wanted)?;
            }
            _ => {}
        }
        self.open.push(name.to_owned());
        Ok(())
    }

    fn start_array(&mut self, element: &BytesStart<'_>, wanted: Wanted) -> Result<(), Reason> {
        let format = attribute(element, "format")?.unwrap_or_default();
        if format != "ascii" {
            let text = format!(
                "an array in format `{}`; save the file in ASCII mode",
                excerpt(format.as_bytes())
            );
            return Err(Reason::Unsupported(text));
        }
        let components = attribute(element, "NumberOfComponents")?.unwrap_or_default();
        if wanted == Wanted::Points && components != "3" {
            return Err(Reason::Syntax("points need NumberOfComponents=\"3\"".into()));
        }
        let Some(piece) = &mut self.piece else {
            return Err(Reason::Syntax("an array outside a piece".into()));
        };
        let fresh = match wanted {
            Wanted::Points => piece.coordinates.is_empty(),
            Wanted::Connectivity => piece.connectivity.is_empty(),
            Wanted::Offsets => piece.offsets.is_empty(),
            Wanted::Types => piece.types.is_empty(),
            Wanted::Tags => piece.tags.replace(Vec::new()).is_none(),
            Wanted::Regions => piece.regions.replace(Vec::new()).is_none(),
        };
        if !fresh {
            return Err(Reason::Syntax("the same array twice in a piece".into()));
        }
        self.wanted = Some(wanted);
        Ok(())
    }

    /// Reads the values of a wanted array; other text does not matter, nor does text in elements
    /// inside the array (VTK writes its `InformationKey` there).
    fn text(&mut self, text: &str, offset: usize) -> Result<(), ParseError> {
        let (Some(wanted), Some(piece)) = (self.wanted, &mut self.piece) else {
            return Ok(());
        };
        if !self.open.last().is_some_and(|name| name == "DataArray" || name == "Array") {
            return Ok(());
        }
        let list = match wanted {
            Wanted::Points => {
                return values(self.bytes, text, offset, float, &mut piece.coordinates);
            }
            Wanted::Connectivity => &mut piece.connectivity,
            Wanted::Offsets => &mut piece.offsets,
            Wanted::Types => &mut piece.types,
            Wanted::Tags => piece.tags.get_or_insert_default(),
            Wanted::Regions => piece.regions.get_or_insert_default(),
        };
        values(self.bytes, text, offset, integer, list)
    }

    /// Closes an element; true when it was the outermost.
    fn end(&mut self) -> Result<bool, ParseError> {
        match self.open.pop().as_deref() {
            Some("DataArray" | "Array") => self.wanted = None,
            Some("Piece") => {
                if let Some(piece) = self.piece.take() {
                    let offset = piece.offset;
                    self.add(piece).map_err(|r| ParseError::at(self.bytes, offset, r))?;
                }
            }
            _ => {}
        }
        Ok(self.open.is_empty())
    }

    /// Checks a piece and appends it to the mesh.
    fn add(&mut self, piece: Piece) -> Result<(), Reason> {
        let (points, cells) = (piece.points, piece.cells);
        let (coordinates, rest) = piece.coordinates.as_chunks::<3>();
        same("points", points, coordinates.len() + usize::from(!rest.is_empty()))?;
        same("values in `offsets`", cells, piece.offsets.len())?;
        same("values in `types`", cells, piece.types.len())?;
        if let Some(tags) = &piece.tags {
            same("values in `tag`", points, tags.len())?;
        }
        if let Some(regions) = &piece.regions {
            same("values in `region`", cells, regions.len())?;
        }
        let base = self.mesh.points.len();
        let total = (base + coordinates.len()) as u64;
        let base = u32::try_from(base).map_err(|_| Reason::TooManyPoints(total))?;
        u32::try_from(total).map_err(|_| Reason::TooManyPoints(total))?;
        if !rest.is_empty() {
            return Err(Reason::TooFewValues { expected: 3, found: rest.len() });
        }
        let kept = self.add_cells(&piece, base)?;
        self.mesh.points.extend_from_slice(coordinates);
        let regions = piece.regions.map(|r| kept.iter().map(|&cell| r[cell]).collect());
        let first = self.pieces == 0;
        append(&mut self.mesh.point_tags, piece.tags, first)?;
        append(&mut self.mesh.tet_tags, regions, first)?;
        self.pieces += 1;
        Ok(())
    }

    /// Appends the tetrahedra of a piece whose points start at `base`; returns which cells they
    /// are.
    fn add_cells(&mut self, piece: &Piece, base: u32) -> Result<Vec<usize>, Reason> {
        let mut kept = Vec::with_capacity(piece.types.len());
        let mut start = 0;
        for (cell, (&kind, &end)) in piece.types.iter().zip(&piece.offsets).enumerate() {
            let end = usize::try_from(end).unwrap_or(0);
            let corners = piece.connectivity.get(start..end).ok_or_else(|| {
                let (offsets, length) = ((start, end), piece.connectivity.len());
                Reason::Syntax(format!(
                    "cell {cell} has the offsets {offsets:?} in a connectivity of {length} values"
                ))
            })?;
            start = end;
            match kind {
                TETRAHEDRON => {
                    self.mesh.tets.push(tetrahedron(cell, corners, piece.points, base)?);
                    kept.push(cell);
                }
                // Vertices, lines, polygons, and their quadratic kinds.
                0..=9 | 21..=23 => self.other_cells = true,
                _ => return Err(Reason::Unsupported(format!("cell {cell} of VTK type {kind}"))),
            }
        }
        if start < piece.connectivity.len() {
            return Err(Reason::Surplus("cell in `connectivity`"));
        }
        Ok(kept)
    }
}

/// Appends the values in `text`, which stands at `offset` in the file, to `list`.
fn values<T>(
    bytes: &[u8],
    text: &str,
    offset: usize,
    parse: fn(&[u8]) -> Result<T, Reason>,
    list: &mut Vec<T>,
) -> Result<(), ParseError> {
    let mut tokens = Tokens::new(text.as_bytes());
    while let Some(token) = tokens.next() {
        let at = |reason| ParseError::at(bytes, offset + tokens.position() - 1, reason);
        list.push(parse(token).map_err(at)?);
    }
    Ok(())
}

/// The corners of a cell of `points` points, shifted by `base`.
fn tetrahedron(cell: usize, corners: &[i64], points: u64, base: u32) -> Result<[u32; 4], Reason> {
    let corners: &[i64; 4] = corners
        .try_into()
        .map_err(|_| Reason::Syntax(format!("tetrahedron {cell} has {} corners", corners.len())))?;
    let last = points as i64 - 1;
    match corners.iter().find(|&&v| v < 0 || v > last) {
        Some(&index) => {
            Err(Reason::Index { what: "cell", number: cell as u64, index, first: 0, last })
        }
        None => Ok(corners.map(|v| base + v as u32)),
    }
}

fn same(what: &'static str, announced: u64, found: usize) -> Result<(), Reason> {
    let found = found as u64;
    if found == announced {
        Ok(())
    } else if found < announced {
        Err(Reason::Truncated { what, announced, found })
    } else {
        Err(Reason::Syntax(format!("{found} {what}, where {announced} are announced")))
    }
}

/// Appends the tags of a piece; either all pieces have them or none.
fn append(all: &mut Option<Vec<i64>>, piece: Option<Vec<i64>>, first: bool) -> Result<(), Reason> {
    match (all.as_mut(), piece) {
        (Some(all), Some(piece)) => all.extend(piece),
        (None, piece) if first => *all = piece,
        (None, None) => {}
        _ => return Err(Reason::Syntax("only some pieces have tags".into())),
    }
    Ok(())
}

/// Writes a `.vtu` file.
pub fn write(out: &mut dyn Write, mesh: &TetMesh) -> std::io::Result<()> {
    let (points, tets): (&[Point], _) = (&mesh.points, &mesh.tets);
    write!(
        out,
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n\
         <UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>\n",
        points.len(),
        tets.len()
    )?;
    array(out, "Float64", "Points", " NumberOfComponents=\"3\"", points.len(), |i, row| {
        push_point(row, &points[i], b' ');
    })?;
    out.write_all(b"</Points>\n<Cells>\n")?;
    array(out, "Int64", "connectivity", "", tets.len(), |i, row| {
        for (k, &v) in tets[i].iter().enumerate() {
            if k > 0 {
                row.push(b' ');
            }
            push_integer(row, i64::from(v));
        }
    })?;
    array(out, "Int64", "offsets", "", tets.len(), |i, row| push_integer(row, 4 * (i as i64 + 1)))?;
    array(out, "UInt8", "types", "", tets.len(), |_, row| push_integer(row, TETRAHEDRON))?;
    out.write_all(b"</Cells>\n")?;
    tag_array(out, "PointData", "tag", mesh.point_tags.as_deref())?;
    tag_array(out, "CellData", "region", mesh.tet_tags.as_deref())?;
    out.write_all(b"</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")
}

fn tag_array(
    out: &mut dyn Write,
    section: &str,
    name: &str,
    tags: Option<&[i64]>,
) -> std::io::Result<()> {
    let Some(tags) = tags else { return Ok(()) };
    writeln!(out, "<{section} Scalars=\"{name}\">")?;
    array(out, "Int64", name, "", tags.len(), |i, row| push_integer(row, tags[i]))?;
    writeln!(out, "</{section}>")
}

fn array(
    out: &mut dyn Write,
    kind: &str,
    name: &str,
    more: &str,
    rows: usize,
    row: impl Fn(usize, &mut Vec<u8>) + Sync,
) -> std::io::Result<()> {
    writeln!(out, "<DataArray type=\"{kind}\" Name=\"{name}\"{more} format=\"ascii\">")?;
    write_rows(out, rows, |i, line| {
        row(i, line);
        line.push(b'\n');
    })?;
    out.write_all(b"</DataArray>\n")
}
