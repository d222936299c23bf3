//! `.npy`: a NumPy array of shape (n, 3), format versions 1 to 3.
//!
//! Read: floats of 4 and 8 bytes and integers of 1, 2, 4 and 8 bytes, of either byte order, in C
//! or Fortran order. Every value must be exactly a 64-bit float: an 8-byte integer above 2^53 may
//! not be, and is then rejected. Written: version 1.0, `<f8`, C order.
//! Source: NumPy Enhancement Proposal 1 and `numpy.lib.format`.

use super::error::{ParseError, Place, Reason, excerpt};
use super::scalar::{Kind, Scalar};
use super::{Point, PointFile};
use std::cmp::Ordering;
use std::io::Write;
use std::iter;
use std::ops::Range;

const MAGIC: &[u8] = b"\x93NUMPY";

/// The header of an array of points.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    scalar: Scalar,
    fortran: bool,
    points: u64,
}

/// Reads an `.npy` file.
pub fn read(bytes: &[u8]) -> Result<PointFile, ParseError> {
    let (header, body) =
        split(bytes).and_then(|(h, body)| Ok((parse_header(h)?, body))).map_err(header_error)?;
    header.announces(body.len() as u64)?;
    header.points(body, 0)
}

/// The header of an array of which these are the first bytes, and the number of its bytes.
pub(super) fn header(bytes: &[u8]) -> Result<(Header, u64), ParseError> {
    let (header, body) = split(bytes).map_err(header_error)?;
    let header = parse_header(header).map_err(header_error)?;
    Ok((header, (bytes.len() - body.len()) as u64))
}

impl Header {
    /// Makes sure that `body` bytes behind it are its points.
    pub(super) fn announces(&self, body: u64) -> Result<(), ParseError> {
        let bytes = 3 * self.scalar.bytes;
        let wanted = u128::from(self.points) * bytes as u128;
        let reason = match u128::from(body).cmp(&wanted) {
            Ordering::Equal => return Ok(()),
            Ordering::Greater => Reason::Surplus("point"),
            Ordering::Less => {
                let found = body / bytes as u64;
                Reason::Truncated { what: "points", announced: self.points, found }
            }
        };
        Err(ParseError::new(Place::End, reason))
    }

    /// The bytes, behind the header, of the points `range`: all announced ones are there.
    pub(super) fn bytes_of(&self, range: &Range<u64>) -> Vec<Range<u64>> {
        let bytes = self.scalar.bytes as u64;
        match self.fortran {
            false => iter::once(3 * bytes * range.start..3 * bytes * range.end).collect(),
            true => {
                let column = |k| k * self.points + range.start..k * self.points + range.end;
                let columns = [0, 1, 2].map(column).into_iter();
                columns.map(|column| bytes * column.start..bytes * column.end).collect()
            }
        }
    }

    /// The number of points announced.
    pub(super) fn count(&self) -> u64 {
        self.points
    }

    /// The points of these bytes, the first of which is number `first` in the file.
    pub(super) fn points(&self, body: &[u8], first: u64) -> Result<PointFile, ParseError> {
        let bytes = self.scalar.bytes;
        let n = body.len() / (3 * bytes);
        let mut points = Vec::with_capacity(n);
        for i in 0..n {
            let mut p = [0.0; 3];
            for (k, c) in p.iter_mut().enumerate() {
                let at = if self.fortran { k * n + i } else { 3 * i + k };
                let place = Place::Point(first + i as u64);
                let value = self.scalar.float(&body[at * bytes..(at + 1) * bytes]);
                *c = value.map_err(|reason| ParseError::new(place, reason))?;
            }
            points.push(p);
        }
        Ok(PointFile { points, ..PointFile::default() })
    }
}

/// Do these bytes start an array that [`read`] would take for points?
pub(super) fn starts_points(bytes: &[u8]) -> bool {
    split(bytes).and_then(|(header, _)| parse_header(header)).is_ok()
}

/// The most bytes of a header of format version 1, with all before it.
pub(super) const LONGEST_HEADER: u64 = 10 + u16::MAX as u64;

fn header_error(reason: Reason) -> ParseError {
    ParseError::new(Place::Header, reason)
}

fn syntax(text: &str) -> Reason {
    Reason::Syntax(text.to_owned())
}

/// The text of the header and the bytes after it.
fn split(bytes: &[u8]) -> Result<(&[u8], &[u8]), Reason> {
    let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| syntax("not a NumPy file"))?;
    let (length, rest) = match rest {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        [version, ..] if !(1..=3).contains(version) => {
            return Err(Reason::Unsupported(format!("NumPy format version {version}")));
        }
        _ => return Err(syntax("the file ends inside the header")),
    };
    rest.split_at_checked(length).ok_or_else(|| syntax("the file ends inside the header"))
}

/// Parses the header: a Python dictionary with the keys `descr`, `fortran_order` and `shape`.
fn parse_header(header: &[u8]) -> Result<Header, Reason> {
    let text = std::str::from_utf8(header).map_err(|_| syntax("not text"))?.trim();
    let mut rest = text.strip_prefix('{').ok_or_else(|| syntax("not a dictionary"))?;
    let (mut kind, mut fortran, mut points) = (None, None, None);
    // Every turn consumes at least a key.
    loop {
        rest = rest.trim_start_matches(|c: char| c.is_whitespace() || c == ',');
        if rest.starts_with('}') || rest.is_empty() {
            break;
        }
        let (key, after) = quoted(rest)?;
        let after = after.trim_start();
        rest = after.strip_prefix(':').ok_or_else(|| syntax("a key without value"))?.trim_start();
        match key {
            "descr" => {
                let (descr, after) = quoted(rest)?;
                kind = Some(parse_descr(descr)?);
                rest = after;
            }
            "fortran_order" => {
                let (value, length) = match rest {
                    r if r.starts_with("True") => (true, 4),
                    r if r.starts_with("False") => (false, 5),
                    _ => return Err(syntax("`fortran_order` is neither True nor False")),
                };
                fortran = Some(value);
                rest = &rest[length..];
            }
            "shape" => {
                let inner = rest.strip_prefix('(').and_then(|r| r.split_once(')'));
                let (dims, after) = inner.ok_or_else(|| syntax("`shape` is not a tuple"))?;
                points = Some(parse_shape(dims)?);
                rest = after;
            }
            other => return Err(Reason::Syntax(format!("unknown key `{}`", short(other)))),
        }
    }
    match (kind, fortran, points) {
        (Some(scalar), Some(fortran), Some(points)) => Ok(Header { scalar, fortran, points }),
        _ => Err(syntax("`descr`, `fortran_order` or `shape` is missing")),
    }
}

fn short(text: &str) -> String {
    excerpt(text.as_bytes())
}

/// A quoted string at the start of `text`, and what follows it.
fn quoted(text: &str) -> Result<(&str, &str), Reason> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'));
    quote
        .and_then(|q| text[1..].split_once(q))
        .ok_or_else(|| Reason::Syntax(format!("expected a quoted string at `{}`", short(text))))
}

fn parse_descr(descr: &str) -> Result<Scalar, Reason> {
    let unsupported = || {
        Reason::Unsupported(format!(
            "values of type `{}` (f4, f8, i1 to i8 and u1 to u8 are read)",
            short(descr)
        ))
    };
    let (big_endian, code) = match descr.as_bytes() {
        [b'>', code @ ..] => (true, code),
        [b'<', code @ ..] => (false, code),
        [b'|' | b'=', code @ ..] => (cfg!(target_endian = "big"), code),
        code => (cfg!(target_endian = "big"), code),
    };
    let kind = match code {
        b"f4" | b"f8" => Kind::Float,
        b"i1" | b"i2" | b"i4" | b"i8" => Kind::Signed,
        b"u1" | b"u2" | b"u4" | b"u8" => Kind::Unsigned,
        _ => return Err(unsupported()),
    };
    Ok(Scalar { kind, bytes: usize::from(code[1] - b'0'), big_endian })
}

fn parse_shape(dims: &str) -> Result<u64, Reason> {
    let parts: Vec<&str> = dims.split(',').map(str::trim).filter(|d| !d.is_empty()).collect();
    // NumPy on Python 2 wrote long integers with a trailing L.
    let numbers: Option<Vec<u64>> =
        parts.iter().map(|d| d.strip_suffix('L').unwrap_or(d).parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[n, 3]) => Ok(n),
        _ => Err(Reason::Syntax(format!("the shape is ({}), not (n, 3)", short(dims)))),
    }
}

/// Writes an `.npy` file. The format has no place for tags.
pub fn write(out: &mut dyn Write, points: &[Point], _tags: Option<&[i64]>) -> std::io::Result<()> {
    // Magic, version and length take 10 bytes; NumPy aligns the data to 64.
    let mut header =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, 3), }}", points.len());
    let padded = (10 + header.len() + 1).next_multiple_of(64) - 10;
    header.extend(iter::repeat_n(' ', padded - header.len() - 1));
    header.push('\n');
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&(header.len() as u16).to_le_bytes())?;
    out.write_all(header.as_bytes())?;
    let mut block = Vec::with_capacity(24 << 10);
    for chunk in points.chunks(1 << 10) {
        block.clear();
        block.extend(chunk.iter().flatten().flat_map(|c| c.to_le_bytes()));
        out.write_all(&block)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(descr: &str, order: &str, shape: &str, body: &[u8]) -> Vec<u8> {
        let header =
            format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
        let mut out = b"\x93NUMPY\x01\x00".to_vec();
        out.extend((header.len() as u16).to_le_bytes());
        out.extend(header.as_bytes());
        out.extend(body);
        out
    }

    #[test]
    fn types_byte_orders_and_memory_orders() {
        let want = [[1.0, -2.0, 3.0], [4.0, 5.0, -6.0]];
        let c = [1_i8, -2, 3, 4, 5, -6];
        let f = [1_i8, 4, -2, 5, 3, -6];
        let bytes = |v: [i8; 6], g: &dyn Fn(i8) -> Vec<u8>| v.into_iter().flat_map(g).collect();
        let cases: [(&str, Vec<u8>, Vec<u8>); 7] = [
            ("<f8", bytes(c, &|v| f64::from(v).to_le_bytes().to_vec()), vec![]),
            (">f8", bytes(f, &|v| f64::from(v).to_be_bytes().to_vec()), vec![1]),
            ("<f4", bytes(f, &|v| f32::from(v).to_le_bytes().to_vec()), vec![1]),
            (">f4", bytes(c, &|v| f32::from(v).to_be_bytes().to_vec()), vec![]),
            ("|i1", bytes(c, &|v| v.to_le_bytes().to_vec()), vec![]),
            (">i2", bytes(c, &|v| i16::from(v).to_be_bytes().to_vec()), vec![]),
            ("<i8", bytes(f, &|v| i64::from(v).to_le_bytes().to_vec()), vec![1]),
        ];
        for (descr, body, fortran) in cases {
            let order = if fortran.is_empty() { "False" } else { "True" };
            let file = read(&array(descr, order, "(2, 3)", &body)).unwrap();
            assert_eq!(file.points, want, "{descr} {order}");
        }
        let unsigned = read(&array("|u1", "False", "(1L, 3L)", &[255, 0, 7])).unwrap();
        assert_eq!(unsigned.points, [[255.0, 0.0, 7.0]]);
    }

    #[test]
    fn long_headers_of_versions_2_and_3() {
        for version in [2, 3] {
            let header = b"{\"shape\": (1, 3), \"fortran_order\": False, \"descr\": \"|u1\"}";
            let mut bytes = b"\x93NUMPY".to_vec();
            bytes.extend([version, 0]);
            bytes.extend((header.len() as u32).to_le_bytes());
            bytes.extend(header);
            bytes.extend([1, 2, 3]);
            assert_eq!(read(&bytes).unwrap().points, [[1.0, 2.0, 3.0]]);
        }
    }

    #[test]
    fn integers_that_are_no_doubles_are_rejected() {
        let body: Vec<u8> =
            [0, 0, (1_u64 << 53) + 1].iter().flat_map(|v| v.to_le_bytes()).collect();
        let e = read(&array("<u8", "False", "(1, 3)", &body)).unwrap_err();
        assert_eq!(
            e.to_string(),
            "point 0: the integer 9007199254740993 is not exactly a 64-bit float"
        );
    }

    #[test]
    fn the_data_starts_on_a_multiple_of_64() {
        let mut out = Vec::new();
        write(&mut out, &[[1.0, 2.0, 3.0]], None).unwrap();
        assert_eq!(out.len() - 24, 128);
    }
}
