//! The errors of reading and writing files: each prints as one line that names the file, the line
//! or the element, and the reason.

use std::fmt;
use std::path::{Path, PathBuf};

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The extension of the file name is not one that is known.
    #[error(
        "{}: unknown extension; points: .npy .xyz .txt .csv .node .ply (read only: .npz .off .obj \
         .stl); domains: .poly .smesh .off .obj .stl .ply .vtk; \
         meshes: .vtu .vtk .msh .mesh .ele; in parts: .pvtu .vtkhdf .mfem _%.msh",
        show(path)
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The file is of a CAD system: exact surfaces, which are not read.
    #[error(
        "{}: CAD files are not read: mesh the surface first (`gmsh -2 {} -o part.stl`, say), and \
         give that",
        show(path),
        show(path)
    )]
    Cad {
        /// The file.
        path: PathBuf,
    },
    /// The format holds points where a mesh was wanted, or a mesh where points were.
    #[error("{}: this format holds {holds}, but {wanted} wanted", show(path))]
    WrongKind {
        /// The file.
        path: PathBuf,
        /// The content of the format.
        holds: &'static str,
        /// The content that was wanted.
        wanted: &'static str,
    },
    /// Files of this format are read, but not written.
    #[error(
        "{}: this format is only read; points are written as .npy .xyz .txt .csv .node .ply",
        show(path)
    )]
    ReadOnly {
        /// The file.
        path: PathBuf,
    },
    /// One stream was given for a format of several files.
    #[error(
        "{}: .{extension} is a format of several files here, which one stream cannot be",
        show(path)
    )]
    SeveralFiles {
        /// The name of the stream.
        path: PathBuf,
        /// The format's extension.
        extension: &'static str,
    },
    /// The operating system could not read the file.
    #[error("{}: cannot read: {source}", show(path))]
    Read {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// The operating system could not write the file. Nothing half-written is left under its name.
    #[error("{}: cannot write: {source}", show(path))]
    Write {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// The content of the file is not what its format asks for.
    #[error("{}: {error}", show(path))]
    Parse {
        /// The file.
        path: PathBuf,
        /// The place, and the reason.
        #[source]
        error: ParseError,
    },
    /// The data given to a writer cannot be written so that reading gives it back.
    #[error("{}: cannot write: {reason}", show(path))]
    Data {
        /// The file.
        path: PathBuf,
        /// The reason.
        #[source]
        reason: DataError,
    },
    /// The writing was cancelled: nothing has the final name that had not before.
    #[error("{}: cancelled, and not written", show(path))]
    Cancelled {
        /// The file.
        path: PathBuf,
    },
}

impl IoError {
    /// A short code that stays the same between versions, for programs to match on.
    pub fn code(&self) -> &'static str {
        match self {
            IoError::UnknownFormat { .. } => "io.unknown-format",
            IoError::Cad { .. } => "io.cad",
            IoError::WrongKind { .. } => "io.wrong-kind",
            IoError::ReadOnly { .. } => "io.read-only",
            IoError::SeveralFiles { .. } => "io.several-files",
            IoError::Read { .. } => "io.read",
            IoError::Write { .. } => "io.write",
            IoError::Parse { .. } => "io.parse",
            IoError::Data { .. } => "io.data",
            IoError::Cancelled { .. } => "io.cancelled",
        }
    }
}

/// Something that makes no sense in a part, or in the words that a part has sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("part {part}: {what} ({at} of {length})")]
pub struct BorderError {
    /// The number of the part.
    pub part: usize,
    /// The place: of a tetrahedron of the part, or of a word that it has sent.
    pub at: usize,
    /// The number of those.
    pub length: usize,
    /// The fault.
    pub what: &'static str,
}

/// Data that no file of ours may hold.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DataError {
    /// A coordinate is NaN or infinite.
    #[error("point {point} has the coordinates {at:?}, which are not all finite")]
    NotFinite {
        /// Index of the point.
        point: usize,
        /// Its coordinates.
        at: ltbw_exact::Point,
    },
    /// A list of tags is not as long as the list that it describes.
    #[error("{tags} tags for {count} {what}")]
    Tags {
        /// `points` or `tetrahedra`.
        what: &'static str,
        /// Number of tags.
        tags: usize,
        /// Number of points or tetrahedra.
        count: usize,
    },
    /// The format has no number type for this tag.
    #[error("{what} {number} has the tag {tag}, which this format cannot hold exactly")]
    TagRange {
        /// `point` or `tetrahedron`.
        what: &'static str,
        /// Index of the point or tetrahedron.
        number: usize,
        /// Its tag.
        tag: i64,
    },
    /// An attribute is NaN or infinite.
    #[error("tetrahedron {tet} has an attribute that is not finite")]
    Attribute {
        /// The tetrahedron.
        tet: usize,
    },
    /// A region or a marker that the format cannot hold.
    #[error("there is the {what} {value}, which this format has no number for")]
    Attributes {
        /// `region` or `marker`.
        what: &'static str,
        /// Its value.
        value: i64,
    },
    /// Parts that are not those of a mesh.
    #[error(transparent)]
    Border(#[from] BorderError),
    /// A domain that cannot be used.
    #[error(transparent)]
    Domain(#[from] ltbw_domain::DomainError),
    /// A facet that the format cannot hold as it is, and that has no triangles.
    #[error("facet {facet} is not a plane polygon without self-intersections")]
    Facet {
        /// The facet.
        facet: u32,
    },
    /// A facet that is not a single polygon.
    #[error("facet {facet} is not a single polygon, which this format asks for; .poly can hold it")]
    FacetParts {
        /// The facet.
        facet: u32,
    },
    /// A boundary triangle names a point or a tetrahedron that does not exist.
    #[error("boundary triangle {face} names a point or tetrahedron that is not there")]
    Face {
        /// Its place in the list.
        face: usize,
    },
    /// A tetrahedron names a point that does not exist.
    #[error("tetrahedron {tet} names point {point}, but there are {points} points")]
    Index {
        /// The tetrahedron.
        tet: usize,
        /// The index it names.
        point: u32,
        /// Number of points.
        points: usize,
    },
}

/// An error in the content of a file, with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct ParseError {
    /// The place.
    pub place: Place,
    /// The reason.
    pub reason: Reason,
}

impl ParseError {
    pub(super) fn new(place: Place, reason: Reason) -> Self {
        Self { place, reason }
    }

    /// An error in a text file: the line is that of the byte at `offset`. Text in UTF-16 makes no
    /// sense to any reader, and that is the reason then.
    pub(super) fn at(bytes: &[u8], offset: usize, reason: Reason) -> Self {
        if is_utf16(bytes) {
            return Self { place: Place::Line(1), reason: Reason::Utf16 };
        }
        let before = &bytes[..offset.min(bytes.len())];
        let line = before.iter().filter(|&&b| b == b'\n').count() as u64 + 1;
        Self { place: Place::Line(line), reason }
    }
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Place::Line(line) => write!(f, "line {line}: {}", self.reason),
            Place::Point(point) => write!(f, "point {point}: {}", self.reason),
            Place::Face(face) => write!(f, "face {face}: {}", self.reason),
            Place::Byte(byte) => write!(f, "byte {byte}: {}", self.reason),
            Place::Header => write!(f, "header: {}", self.reason),
            Place::End => write!(f, "end of file: {}", self.reason),
        }
    }
}

impl std::error::Error for ParseError {}

/// A place in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// A line of a text file, counted from 1.
    Line(u64),
    /// A point of a binary file, counted from 0.
    Point(u64),
    /// A face of a surface, counted from 0.
    Face(u64),
    /// A byte of a binary file, counted from 0.
    Byte(u64),
    /// The header of a binary file.
    Header,
    /// Its end.
    End,
}

/// The reason why a place of a file is wrong.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Reason {
    /// A line ends too early.
    #[error("expected {expected} values, found {found}")]
    TooFewValues {
        /// Values that the line should hold, at least.
        expected: usize,
        /// Values that it holds.
        found: usize,
    },
    /// A line holds more than it should.
    #[error("expected {expected} values, found more")]
    TooManyValues {
        /// Values that the line should hold.
        expected: usize,
    },
    /// Text where a number should be.
    #[error("`{0}` is not a number")]
    NotANumber(String),
    /// Text where an integer should be.
    #[error("`{0}` is not an integer that fits")]
    NotAnInteger(String),
    /// A coordinate is NaN, infinite, or too large for a double.
    #[error("`{0}` is not a finite number")]
    NotFinite(String),
    /// An integer coordinate that no double equals.
    #[error("the integer {0} is not exactly a 64-bit float")]
    Inexact(i128),
    /// The file ends before everything that it announced.
    #[error("the file announces {announced} {what}, but ends after {found}")]
    Truncated {
        /// The kind of values of which there are too few.
        what: &'static str,
        /// The number that was announced.
        announced: u64,
        /// The number that there are.
        found: u64,
    },
    /// The file goes on after everything that it announced.
    #[error("unexpected data after the last {0}")]
    Surplus(&'static str),
    /// An element is not numbered in turn.
    #[error("{what} number {found}, where {expected} was expected")]
    Numbering {
        /// `point` or `tetrahedron`.
        what: &'static str,
        /// The number it should have.
        expected: u64,
        /// The number it has.
        found: i64,
    },
    /// An element names a point that is not there.
    #[error("{what} {number} names point {index}, but points are numbered {first} to {last}")]
    Index {
        /// `tetrahedron`, `cell` or `element`.
        what: &'static str,
        /// Which one, in the file's own numbering.
        number: u64,
        /// The index it names.
        index: i64,
        /// The first valid index.
        first: i64,
        /// The last valid index; below `first` when there is no point.
        last: i64,
    },
    /// More points than 32-bit indices can name.
    #[error("{0} points are more than 32-bit indices can name")]
    TooManyPoints(u64),
    /// Text of two bytes a character, as some editors and shells save it.
    #[error("the text is UTF-16; save the file as UTF-8")]
    Utf16,
    /// The file breaks the rules of its format.
    #[error("{0}")]
    Syntax(String),
    /// A valid part of the format that this reader does not read.
    #[error("not supported: {0}")]
    Unsupported(String),
}

/// Are these bytes text in UTF-16? It begins with a byte order mark, or with two characters of
/// which one byte each is 0.
pub(super) fn is_utf16(bytes: &[u8]) -> bool {
    match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => true,
        &[a, b, c, d, ..] => {
            let is_text = |c: u8| c.is_ascii_graphic() || c.is_ascii_whitespace();
            (b, d) == (0, 0) && is_text(a) && is_text(c)
                || (a, c) == (0, 0) && is_text(b) && is_text(d)
        }
        _ => false,
    }
}

/// A path as it can stand inside a one-line message.
pub(super) fn show(path: &Path) -> String {
    path.to_string_lossy().chars().map(|c| if c.is_control() { '?' } else { c }).collect()
}

/// At most 40 characters of a token, printable, for a message.
pub(super) fn excerpt(token: &[u8]) -> String {
    one_line(&String::from_utf8_lossy(&token[..token.len().min(200)]), 40)
}

/// At most `longest` characters of `text`, without line ends, for a message.
pub(super) fn one_line(text: &str, longest: usize) -> String {
    let mut out: String =
        text.chars().take(longest).map(|c| if c.is_control() { '?' } else { c }).collect();
    if text.chars().nth(longest).is_some() {
        out.push_str("...");
    }
    out
}
