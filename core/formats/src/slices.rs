//! Point files in slices: several readers read one each, and all together the whole.
//!
//! An array is cut between its records, a text at line ends: a line belongs to the slice in which
//! its first byte lies. What the first lines tell of all others, each reader reads. The number of a
//! line, and that of a point, is known when all have counted theirs.
//!
//! | format | what all read | what is cut |
//! |---|---|---|
//! | `.npy` | the header | records; three stretches of each in Fortran order |
//! | `.xyz`, `.txt` | nothing | lines |
//! | `.csv` | the first line | lines, without the header |
//! | `.node` | the header, and the line of the first point | lines behind the header |

use super::csv::Table;
use super::error::{ParseError, Place, Reason};
use super::tetgen::{NodeHead, node_head};
use super::text::Lines;
use super::{Format, IoError, PartOf, PointFile, npy, parse_error, txt, xyz};
use std::fs::File;
use std::io::{Error, ErrorKind, Read, Seek, SeekFrom};
use std::iter;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Bytes that are read at a time where it is not known how many are needed.
const BLOCK: u64 = 1 << 16;

/// A point file of which a slice is to be read.
#[derive(Debug)]
pub struct Slices {
    path: PathBuf,
    file: File,
    length: u64,
    head: Vec<u8>,
    kind: Kind,
}

/// The words of a file on all its points.
#[derive(Debug, Clone)]
enum Kind {
    Npy {
        header: npy::Header,
        body: u64,
    },
    Xyz,
    Txt,
    /// None: there is no line.
    Csv(Option<Table>),
    Node {
        head: NodeHead,
        rows: u64,
    },
}

/// A slice of a point file, of which nothing is understood yet.
#[derive(Debug)]
pub struct Slice {
    path: PathBuf,
    kind: Kind,
    place: PartOf,
    ranges: Vec<Range<u64>>,
    bytes: Vec<u8>,
    size: Size,
}

/// The size of a stretch of a text, or of an array, which has no lines.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Size {
    /// Line ends.
    pub lines: u64,
    /// Points.
    pub points: u64,
}

impl Slices {
    /// Opens a file and reads what it says of all its points; `None` if files of this format are
    /// read as a whole.
    ///
    /// # Errors
    /// [`IoError`] if it cannot be read, or if its first lines break the rules of its format.
    pub fn open(path: impl AsRef<Path>, format: Format) -> Result<Option<Self>, IoError> {
        let path = path.as_ref();
        if !matches!(format, Format::Npy | Format::Xyz | Format::Txt | Format::Csv | Format::Node) {
            return Ok(None);
        }
        let failed = |source| IoError::Read { path: path.to_owned(), source };
        // A device may never end; a folder is no file.
        let found = std::fs::metadata(path).map_err(failed)?;
        if !found.is_file() {
            return Err(failed(Error::new(ErrorKind::InvalidInput, "not a regular file")));
        }
        let mut file = File::open(path).map_err(failed)?;
        let length = found.len();
        let wanted = match format {
            Format::Npy => npy::LONGEST_HEADER,
            _ => 0,
        };
        let mut head = Vec::new();
        // Ends: the file does.
        loop {
            let block =
                Read::by_ref(&mut file).take(BLOCK).read_to_end(&mut head).map_err(failed)?;
            if block == 0 || has_head(format, &head, wanted) {
                break;
            }
        }
        let kind = kind_of(format, &head, length).map_err(|error| parse_error(path, error))?;
        head.truncate(usize::try_from(kind.body()).unwrap_or(usize::MAX));
        Ok(Some(Self { path: path.to_owned(), file, length, head, kind }))
    }

    /// The bytes before those that are cut: the same for all readers of one file.
    pub fn head(&self) -> &[u8] {
        &self.head
    }

    /// Bytes of the file.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Reads the slice of one of several readers.
    ///
    /// # Errors
    /// [`IoError::Read`] if the file cannot be read.
    pub fn slice(mut self, place: PartOf) -> Result<Slice, IoError> {
        let read = self.read(place);
        let Self { path, kind, .. } = self;
        let (ranges, bytes) = match read {
            Ok(read) => read,
            Err(source) => return Err(IoError::Read { path, source }),
        };
        let size = match &kind {
            Kind::Npy { header, .. } => {
                let range = cut(0..header.count(), place);
                Size { lines: 0, points: range.end - range.start }
            }
            _ => {
                Size { lines: line_ends(&bytes), points: lines_of(&bytes, &ranges).count() as u64 }
            }
        };
        Ok(Slice { path, kind, place, ranges, bytes, size })
    }

    /// The ranges of a slice, and its bytes.
    fn read(&mut self, place: PartOf) -> Result<(Vec<Range<u64>>, Vec<u8>), Error> {
        let body = self.kind.body();
        let ranges: Vec<Range<u64>> = match &self.kind {
            Kind::Npy { header, .. } => {
                let ranges = header.bytes_of(&cut(0..header.count(), place)).into_iter();
                ranges.map(|range| body + range.start..body + range.end).collect()
            }
            _ => {
                let Range { start, end } = cut(body..self.length, place);
                let lines = self.line_at(start)?..self.line_at(end)?;
                iter::once(lines).collect()
            }
        };
        let mut bytes = Vec::new();
        for Range { start, end } in &ranges {
            self.file.seek(SeekFrom::Start(*start))?;
            let read = Read::by_ref(&mut self.file).take(end - start).read_to_end(&mut bytes)?;
            if read as u64 != end - start {
                return Err(Error::new(ErrorKind::UnexpectedEof, "it has become shorter"));
            }
        }
        Ok((ranges, bytes))
    }

    /// The first byte at or behind `at` with which a line begins, or the end.
    fn line_at(&mut self, at: u64) -> Result<u64, Error> {
        if at <= self.kind.body() {
            return Ok(self.kind.body());
        }
        let mut next = at - 1;
        self.file.seek(SeekFrom::Start(next))?;
        let mut block = Vec::new();
        // Ends: the file does.
        loop {
            block.clear();
            let read = Read::by_ref(&mut self.file).take(BLOCK).read_to_end(&mut block)?;
            if let Some(end) = block.iter().position(|&b| b == b'\n') {
                return Ok((next + end as u64 + 1).min(self.length));
            }
            if read == 0 {
                return Ok(self.length);
            }
            next += read as u64;
        }
    }
}

impl Kind {
    /// The first byte that is cut.
    fn body(&self) -> u64 {
        match self {
            Self::Npy { body, .. } => *body,
            Self::Csv(Some(table)) => table.rows as u64,
            Self::Node { rows, .. } => *rows,
            Self::Xyz | Self::Txt | Self::Csv(None) => 0,
        }
    }
}

/// Are these first bytes of a file enough to say what it says of all its points?
fn has_head(format: Format, head: &[u8], wanted: u64) -> bool {
    // The last line may not be whole.
    let whole = head.iter().rposition(|&b| b == b'\n').map_or(0, |end| end + 1);
    match format {
        // Of later versions the header may be longer than of the first.
        Format::Npy => {
            let is_long = matches!(head.get(6), Some(2 | 3));
            head.len() as u64 >= wanted && (!is_long || npy::header(head).is_ok())
        }
        Format::Csv => Lines::new(&head[..whole]).next().is_some(),
        Format::Node => Lines::new(&head[..whole]).nth(1).is_some(),
        _ => true,
    }
}

/// The words of the first bytes of a file on its points.
fn kind_of(format: Format, head: &[u8], length: u64) -> Result<Kind, ParseError> {
    Ok(match format {
        Format::Npy => {
            let (header, body) = npy::header(head)?;
            header.announces(length - body.min(length))?;
            Kind::Npy { header, body }
        }
        Format::Csv => Kind::Csv(Table::of(head)),
        Format::Node => {
            let mut lines = Lines::new(head);
            let node = node_head(head, &mut lines)?;
            Kind::Node { head: node, rows: Lines::position(&lines) as u64 }
        }
        Format::Txt => Kind::Txt,
        _ => Kind::Xyz,
    })
}

/// The share of a range that is one of several's.
fn cut(range: Range<u64>, place: PartOf) -> Range<u64> {
    let length = u128::from(range.end.saturating_sub(range.start));
    let of = place.of.max(1) as u128;
    let at = |part: usize| range.start + (part as u128 * length / of) as u64;
    at(place.part)..at(place.part + 1)
}

fn line_ends(bytes: &[u8]) -> u64 {
    bytes.iter().filter(|&&b| b == b'\n').count() as u64
}

/// The lines of a slice.
fn lines_of<'a>(bytes: &'a [u8], ranges: &[Range<u64>]) -> Lines<'a> {
    match ranges.first() {
        Some(Range { start: 0, .. }) => Lines::new(bytes),
        _ => Lines::inside(bytes),
    }
}

impl Slice {
    /// Its size: a slice comes after the sum of those before it.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Where its bytes stand in the file.
    pub fn ranges(&self) -> &[Range<u64>] {
        &self.ranges
    }

    /// Its bytes, one range after the other.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The points of this slice; `before` is what lies before it behind the head.
    ///
    /// # Errors
    /// [`IoError::Parse`], with the place in the whole file. Of several slices that are refused the
    /// first one has the error of the whole file.
    pub fn parse(self, head: &[u8], before: Size) -> Result<PointFile, IoError> {
        let parsed = self.points(before).map_err(|mut error| {
            match &mut error.place {
                Place::Line(line) if error.reason != Reason::Utf16 => {
                    *line += line_ends(head) + before.lines;
                }
                _ => {}
            }
            error
        });
        parsed.map_err(|error| parse_error(&self.path, error))
    }

    fn points(&self, before: Size) -> Result<PointFile, ParseError> {
        let Self { kind, place, bytes, .. } = self;
        let mut lines = lines_of(bytes, &self.ranges);
        match kind {
            Kind::Npy { header, .. } => header.points(bytes, cut(0..header.count(), *place).start),
            Kind::Xyz => xyz::read_lines(bytes, lines, xyz::parse),
            Kind::Txt => xyz::read_lines(bytes, lines, txt::parse),
            Kind::Csv(None) => Ok(PointFile::default()),
            Kind::Csv(Some(table)) => table.points(bytes, lines),
            Kind::Node { head, .. } => {
                let file = head.points(bytes, &mut lines, before.points)?;
                NodeHead::is_end(bytes, &mut lines)?;
                if place.part + 1 == place.of {
                    head.is_whole(bytes, before.points + file.points.len() as u64)?;
                }
                Ok(file)
            }
        }
    }
}
