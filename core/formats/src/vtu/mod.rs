//! `.vtu`: VTK's XML format of unstructured grids, which ParaView opens.
//!
//! Written: one piece, `Float64` points, `Int64` arrays named `tag` (points) and `region` (cells)
//! where there are tags, and `attribute` where regions have attributes; boundary triangles behind
//! the tetrahedra, with the array `marker` of cells; figures of tetrahedra on request; arrays are
//! appended raw, or text; the hash of the mesh in a comment, where it is given. Read: any number
//! of pieces; arrays as text, inline in base64, or appended raw or in base64; uncompressed or
//! compressed by zlib, LZ4 or LZMA; either byte order. Tetrahedra (VTK type 10) become the mesh;
//! triangles (type 5) that are faces of tetrahedra are boundary triangles, with their `marker`;
//! of those of higher order the corners are read; other cells of dimension 0 to 2 and other arrays
//! are not read, and a note says so; other cells are refused. Names of groups are field data.
//! Source: the VTK file formats page of the VTK documentation.

mod array;
mod blocks;
mod cells;
mod field;
mod names;
mod write;

use super::error::{ParseError, Reason, excerpt};
use super::scalar::Scalar;
use super::text::{Tokens, count, float, integer};
use super::xml::{attribute, each_event, expect_kind, malformed};
use super::{GroupName, MeshFile, PointField};
use array::{Layout, Stream};
pub(crate) use cells::{Grid, append};
use field::Asked;
use names::Named;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
pub(crate) use write::{Beside, write_beside, write_part};
pub use write::{write, write_with};

/// VTK's number for a tetrahedron.
const TETRAHEDRON: i64 = 10;

/// And for a triangle.
const TRIANGLE: i64 = 5;

/// The ratio by which data may be larger than the file it is compressed in: as large as Deflate can
/// make it, or, in a small file, this many bytes. LZMA could do seven times as much.
const LARGEST_RATIO: u64 = 1032;
const SMALL: u64 = 64 << 20;

/// The note on arrays that are not read.
pub(crate) const OTHER_ARRAYS: &str =
    "arrays other than `tag` of points, `region`, `attribute` and `marker` of cells are not read";

/// The arrays of a piece that are read.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Wanted {
    Points,
    Connectivity,
    Offsets,
    Types,
    Tags,
    Regions,
    Markers,
    Attributes,
    Field,
}

/// A piece of a grid as the file tells it, before it is checked.
#[derive(Default)]
pub(crate) struct Piece {
    /// The offset of its start in the file.
    pub(crate) offset: usize,
    pub(crate) points: u64,
    pub(crate) cells: u64,
    pub(crate) coordinates: Vec<f64>,
    pub(crate) connectivity: Vec<i64>,
    pub(crate) offsets: Vec<i64>,
    pub(crate) types: Vec<i64>,
    pub(crate) tags: Option<Vec<i64>>,
    pub(crate) regions: Option<Vec<i64>>,
    pub(crate) markers: Option<Vec<i64>>,
    pub(crate) attributes: Option<Vec<f64>>,
    pub(crate) field: Option<Vec<f64>>,
}

/// The values of an array of a piece.
enum List<'a> {
    Floats(&'a mut Vec<f64>),
    Integers(&'a mut Vec<i64>),
}

impl Piece {
    fn list(&mut self, wanted: Wanted) -> List<'_> {
        List::Integers(match wanted {
            Wanted::Points => return List::Floats(&mut self.coordinates),
            Wanted::Attributes => return List::Floats(self.attributes.get_or_insert_default()),
            Wanted::Field => return List::Floats(self.field.get_or_insert_default()),
            Wanted::Connectivity => &mut self.connectivity,
            Wanted::Offsets => &mut self.offsets,
            Wanted::Types => &mut self.types,
            Wanted::Tags => self.tags.get_or_insert_default(),
            Wanted::Regions => self.regions.get_or_insert_default(),
            Wanted::Markers => self.markers.get_or_insert_default(),
        })
    }
}

/// The storage of the array that is being read.
#[derive(Debug, Clone, Copy)]
enum Storage {
    Text,
    /// In base64, between the tags; `true` once it was read.
    Inline(Scalar, bool),
    /// Read already.
    Appended,
}

/// The arrays behind the XML, all in one.
struct Appended<'a> {
    base64: bool,
    data: &'a [u8],
    /// Bytes of `data` that arrays took: together no more than there are, or a small file could
    /// name one large array many times.
    taken: usize,
}

/// All that has been read so far.
struct State<'a> {
    bytes: &'a [u8],
    layout: Option<Layout>,
    appended: Option<Appended<'a>>,
    /// Names of the open elements, outermost first.
    open: Vec<String>,
    piece: Option<Piece>,
    /// The array that is being read, if it is one that is wanted.
    wanted: Option<(Wanted, Storage)>,
    /// The array of field data that is being read, and the names that were.
    named: Option<Named>,
    names: Vec<GroupName>,
    grid: Grid,
    /// The field of points that is asked for.
    field: Option<Asked>,
    other_arrays: bool,
    /// Bytes that compressed data may still become.
    room: u64,
}

/// Reads a `.vtu` file.
pub fn read(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let state = parsed(bytes, None)?;
    let mut notes = Vec::new();
    if state.other_arrays {
        notes.push(OTHER_ARRAYS.into());
    }
    let (mesh, more) = state.grid.finish();
    notes.extend(more);
    Ok(MeshFile { mesh, notes, names: state.names })
}

/// Reads a `.vtu` file with an array of its points, one number each, by its name; without a name
/// the only such array of floats.
///
/// # Errors
/// As [`read`]; no such array, or without a name several.
pub fn read_field(bytes: &[u8], name: Option<&str>) -> Result<PointField, ParseError> {
    let mut state = parsed(bytes, Some(Asked::new(name)))?;
    let values = state.grid.field.take();
    let values = values.ok_or_else(|| ParseError::at(bytes, 0, field::missing(name)))?;
    Ok(PointField { mesh: state.grid.finish().0, values })
}

/// All that is read of a `.vtu` file.
fn parsed(bytes: &[u8], field: Option<Asked>) -> Result<State<'_>, ParseError> {
    // Appended data need not be text, and what is in it is no XML.
    let head = find(bytes, b"<AppendedData").unwrap_or(bytes.len());
    let appended = match head {
        h if h == bytes.len() => None,
        h => Some(appended(&bytes[h..]).map_err(|r| ParseError::at(bytes, h, r))?),
    };
    let mut state = State {
        bytes,
        layout: None,
        appended,
        open: Vec::new(),
        piece: None,
        wanted: None,
        named: None,
        names: Vec::new(),
        grid: Grid::default(),
        field,
        other_arrays: false,
        room: (bytes.len() as u64).saturating_mul(LARGEST_RATIO).saturating_add(SMALL),
    };
    let mut finished = false;
    each_event(bytes, head, |event, offset| {
        let at = |reason| ParseError::at(bytes, offset, reason);
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
            _ => {}
        }
        Ok(())
    })?;
    // Behind the data only the ends of two elements may follow.
    finished |= state.appended.is_some()
        && state.open.len() == 1
        && bytes.trim_ascii_end().ends_with(b"</VTKFile>");
    if !finished {
        let text = "the file ends before the end of a VTKFile element";
        return Err(ParseError::at(bytes, bytes.len(), Reason::Syntax(text.into())));
    }
    Ok(state)
}

/// The offset of the first `word`, which starts with `<`, in `bytes`.
fn find(bytes: &[u8], word: &[u8]) -> Option<usize> {
    let mut from = 0;
    // Every turn moves `from` forward.
    while let Some(at) = bytes.get(from..)?.iter().position(|&b| b == b'<') {
        if bytes[from + at..].starts_with(word) {
            return Some(from + at);
        }
        from += at + 1;
    }
    None
}

/// The appended data whose element starts at the front of `bytes`.
fn appended(bytes: &[u8]) -> Result<Appended<'_>, Reason> {
    let wrong = || Reason::Syntax("`AppendedData` without its `_`".into());
    let end = bytes.iter().position(|&b| b == b'>').ok_or_else(wrong)? + 1;
    let tag = std::str::from_utf8(&bytes[..end]).map_err(|_| wrong())?;
    let encoding = match Reader::from_str(tag).read_event() {
        Ok(Event::Start(element)) => attribute(&element, "encoding")?.unwrap_or_default(),
        Ok(_) => return Err(wrong()),
        Err(e) => return Err(malformed(&e)),
    };
    let base64 = match encoding.as_str() {
        "raw" => false,
        "base64" => true,
        other => {
            let text = format!("the encoding `{}` of appended data", excerpt(other.as_bytes()));
            return Err(Reason::Unsupported(text));
        }
    };
    let data = bytes[end..].trim_ascii_start().strip_prefix(b"_").ok_or_else(wrong)?;
    Ok(Appended { base64, data, taken: 0 })
}

/// Does an array hold integers?
fn is_whole(element: &BytesStart<'_>) -> Result<bool, Reason> {
    let kind = attribute(element, "type")?.unwrap_or_default();
    Ok(kind.starts_with("Int") || kind.starts_with("UInt"))
}

/// Does an array hold a number for each point or cell?
fn is_single(element: &BytesStart<'_>) -> Result<bool, Reason> {
    let components = attribute(element, "NumberOfComponents")?;
    let kind = attribute(element, "type")?.unwrap_or_default();
    Ok(components.is_none_or(|number| number == "1") && kind.starts_with("Float"))
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
            (None, _) => {
                expect_kind(element, "UnstructuredGrid")?;
                let value = |name| attribute(element, name).map(Option::unwrap_or_default);
                let (order, header) = (value("byte_order")?, value("header_type")?);
                self.layout = Some(Layout::new(&order, &header, &value("compressor")?)?);
            }
            (Some("UnstructuredGrid"), "Piece") => {
                self.piece = Some(Piece {
                    offset,
                    points: count_attribute(element, "NumberOfPoints")?,
                    cells: count_attribute(element, "NumberOfCells")?,
                    ..Piece::default()
                });
            }
            (Some("FieldData"), "DataArray" | "Array") => {
                self.named = Named::of(element)?;
                self.other_arrays |= self.named.is_none();
            }
            (Some(section), "DataArray" | "Array") => {
                self.wanted = None;
                let array = attribute(element, "Name")?.unwrap_or_default();
                let wanted = match (section, array.as_str()) {
                    ("PointData", own) if Asked::is(&mut self.field, own, element)? => {
                        Wanted::Field
                    }
                    ("Points", _) => Wanted::Points,
                    ("Cells", "connectivity") => Wanted::Connectivity,
                    ("Cells", "offsets") => Wanted::Offsets,
                    ("Cells", "types") => Wanted::Types,
                    ("PointData", "tag") => Wanted::Tags,
                    ("CellData", "region") => Wanted::Regions,
                    ("CellData", "marker") if is_whole(element)? => Wanted::Markers,
                    ("CellData", "attribute") if is_single(element)? => Wanted::Attributes,
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
            Wanted::Markers => piece.markers.replace(Vec::new()).is_none(),
            Wanted::Attributes => piece.attributes.replace(Vec::new()).is_none(),
            Wanted::Field => piece.field.replace(Vec::new()).is_none(),
        };
        if !fresh {
            return Err(Reason::Syntax("the same array twice in a piece".into()));
        }
        let storage = self.storage(element, wanted)?;
        self.wanted = Some((wanted, storage));
        Ok(())
    }

    /// The storage of the values of `element`; those of an appended array are read at once.
    fn storage(&mut self, element: &BytesStart<'_>, wanted: Wanted) -> Result<Storage, Reason> {
        let format = attribute(element, "format")?.unwrap_or_default();
        if format == "ascii" {
            return Ok(Storage::Text);
        }
        let kind = attribute(element, "type")?.unwrap_or_default();
        let outermost = || Reason::Syntax("an array outside a VTKFile element".into());
        let layout = self.layout.ok_or_else(outermost)?;
        let scalar = layout.scalar(&kind)?;
        match format.as_str() {
            "binary" => Ok(Storage::Inline(scalar, false)),
            "appended" => {
                let offset = attribute(element, "offset")?.unwrap_or_default();
                let offset = count(offset.as_bytes())?;
                self.fill_appended(wanted, scalar, offset)?;
                Ok(Storage::Appended)
            }
            other => {
                let text = format!("an array in format `{}`", excerpt(other.as_bytes()));
                Err(Reason::Unsupported(text))
            }
        }
    }

    /// Reads the values of a wanted array that starts at `offset` of the appended data.
    fn fill_appended(&mut self, wanted: Wanted, scalar: Scalar, offset: u64) -> Result<(), Reason> {
        let Some(Appended { base64, data, .. }) = self.appended else {
            return Err(Reason::Syntax("there is no appended data".into()));
        };
        let Some(front) = usize::try_from(offset).ok().and_then(|o| data.get(o..)) else {
            let (what, found) = ("bytes of appended data", data.len() as u64);
            return Err(Reason::Truncated { what, announced: offset, found });
        };
        let mut stream = if base64 { Stream::base64(front) } else { Stream::Raw(front) };
        self.fill(wanted, scalar, &mut stream)?;
        if let Some(appended) = &mut self.appended {
            appended.taken += front.len() - stream.remaining();
            if appended.taken > data.len() {
                return Err(Reason::Syntax("appended arrays overlap".into()));
            }
        }
        Ok(())
    }

    /// Reads the values of a wanted array from binary data.
    fn fill(
        &mut self,
        wanted: Wanted,
        scalar: Scalar,
        from: &mut Stream<'_>,
    ) -> Result<(), Reason> {
        let (Some(layout), Some(piece)) = (self.layout, &mut self.piece) else { return Ok(()) };
        let data = layout.decode(from, &mut self.room)?;
        let values = data.chunks_exact(scalar.bytes);
        if !values.remainder().is_empty() {
            return Err(Reason::Syntax(format!("an array of {} bytes", data.len())));
        }
        match piece.list(wanted) {
            List::Floats(list) => {
                list.reserve_exact(values.len());
                values.map(|v| scalar.float(v)).try_for_each(|v| v.map(|v| list.push(v)))
            }
            List::Integers(list) => {
                list.reserve_exact(values.len());
                values.map(|v| scalar.integer(v)).try_for_each(|v| v.map(|v| list.push(v)))
            }
        }
    }

    /// Reads the values of a wanted array; other text does not matter, nor does text in elements
    /// inside the array (VTK writes its `InformationKey` there).
    fn text(&mut self, text: &str, offset: usize) -> Result<(), ParseError> {
        self.named.iter_mut().for_each(|named| named.text(text));
        let (Some((wanted, storage)), Some(piece)) = (self.wanted, &mut self.piece) else {
            return Ok(());
        };
        if !self.open.last().is_some_and(|name| name == "DataArray" || name == "Array") {
            return Ok(());
        }
        match storage {
            Storage::Text => match piece.list(wanted) {
                List::Floats(list) => values(self.bytes, text, offset, float, list),
                List::Integers(list) => values(self.bytes, text, offset, integer, list),
            },
            Storage::Inline(..) | Storage::Appended if text.trim_ascii().is_empty() => Ok(()),
            Storage::Inline(scalar, false) => {
                self.wanted = Some((wanted, Storage::Inline(scalar, true)));
                self.fill(wanted, scalar, &mut Stream::base64(text.as_bytes()))
                    .map_err(|r| ParseError::at(self.bytes, offset, r))
            }
            Storage::Inline(_, true) | Storage::Appended => {
                let reason = Reason::Syntax("more text in a binary array".into());
                Err(ParseError::at(self.bytes, offset, reason))
            }
        }
    }

    /// Closes an element; true when it was the outermost.
    fn end(&mut self) -> Result<bool, ParseError> {
        match self.open.pop().as_deref() {
            Some("DataArray" | "Array") => {
                self.wanted = None;
                if let Some(named) = self.named.take() {
                    let name = named.finish();
                    self.other_arrays |= name.is_none();
                    self.names.extend(name);
                }
            }
            Some("Piece") => {
                if let Some(piece) = self.piece.take() {
                    let offset = piece.offset;
                    self.grid.add(piece).map_err(|r| ParseError::at(self.bytes, offset, r))?;
                }
            }
            _ => {}
        }
        Ok(self.open.is_empty())
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
