//! The binary arrays of VTK's XML files: raw or base64, whole or in compressed blocks.
//!
//! An array is a header and data. Without compression the header is the number of bytes; with it,
//! the number of blocks, the size of a block, the size of the last one if it is smaller (else 0)
//! and the compressed size of each block. In base64, header and data may be padded each for
//! itself; here padding may stand behind any group, which covers all writers.
//! Source: the VTK file formats page of the VTK documentation; RFC 4648; RFC 1950.

use super::blocks::Compressor;
use crate::error::{Reason, excerpt};
use crate::scalar::{Kind, Scalar};
use std::borrow::Cow;

/// The encoding of all binary arrays of a file, from its outermost element.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// Numbers of array headers.
    header: Scalar,
    compressor: Option<Compressor>,
}

impl Layout {
    /// From the attributes `byte_order`, `header_type` and `compressor`; empty where missing.
    pub(super) fn new(order: &str, header: &str, compressor: &str) -> Result<Self, Reason> {
        let unsupported = |what: &str, name: &str| {
            Reason::Unsupported(format!("{what} `{}`", excerpt(name.as_bytes())))
        };
        let big_endian = match order {
            "" | "LittleEndian" => false,
            "BigEndian" => true,
            other => return Err(unsupported("the byte order", other)),
        };
        let bytes = match header {
            "" | "UInt32" => 4,
            "UInt64" => 8,
            other => return Err(unsupported("the header type", other)),
        };
        let compressor = match (compressor, Compressor::named(compressor)) {
            ("", _) => None,
            (other, None) => return Err(unsupported("the compressor", other)),
            (_, known) => known,
        };
        let header = Scalar { kind: Kind::Unsigned, bytes, big_endian };
        Ok(Self { header, compressor })
    }

    /// The number type that the attribute `type` of an array names.
    pub(super) fn scalar(self, name: &str) -> Result<Scalar, Reason> {
        let (kind, bytes) = match name {
            "Int8" => (Kind::Signed, 1),
            "UInt8" => (Kind::Unsigned, 1),
            "Int16" => (Kind::Signed, 2),
            "UInt16" => (Kind::Unsigned, 2),
            "Int32" => (Kind::Signed, 4),
            "UInt32" => (Kind::Unsigned, 4),
            "Int64" => (Kind::Signed, 8),
            "UInt64" => (Kind::Unsigned, 8),
            "Float32" => (Kind::Float, 4),
            "Float64" => (Kind::Float, 8),
            other => {
                let text = format!("`{}` is no type of an array", excerpt(other.as_bytes()));
                return Err(Reason::Syntax(text));
            }
        };
        Ok(Scalar { kind, bytes, big_endian: self.header.big_endian })
    }

    /// The data of the array that starts at the front of `stream`.
    ///
    /// `room` is the number of bytes that compressed data of the file may still become.
    pub(super) fn decode<'a>(
        self,
        stream: &mut Stream<'a>,
        room: &mut u64,
    ) -> Result<Cow<'a, [u8]>, Reason> {
        if let Some(compressor) = self.compressor {
            return self.unpack(compressor, stream, room).map(Cow::Owned);
        }
        let [length] = self.numbers(stream)?;
        stream.take(length)
    }

    /// The next `N` numbers of an array header.
    fn numbers<const N: usize>(self, stream: &mut Stream<'_>) -> Result<[u64; N], Reason> {
        let mut numbers = [0; N];
        for number in &mut numbers {
            *number = self.header.word(&stream.take(self.header.bytes as u64)?);
        }
        Ok(numbers)
    }

    fn unpack(
        self,
        from: Compressor,
        stream: &mut Stream<'_>,
        room: &mut u64,
    ) -> Result<Vec<u8>, Reason> {
        let [blocks] = self.numbers(stream)?;
        if blocks == 0 {
            return Ok(Vec::new());
        }
        let [size, last] = self.numbers(stream)?;
        let width = self.header.bytes;
        let sizes = stream.take(blocks.saturating_mul(width as u64))?;
        let mut out = Vec::new();
        // The sizes were there, so there are no more blocks than bytes in the file.
        for (k, raw) in sizes.chunks_exact(width).enumerate() {
            let packed = stream.take(self.header.word(raw))?;
            let is_last = k as u64 + 1 == blocks;
            let size = if is_last && last > 0 { last } else { size };
            *room = room.checked_sub(size).ok_or_else(|| {
                let text = format!("block {k} of an array announces {size} bytes, far too many");
                Reason::Syntax(text)
            })?;
            from.unpack(&packed, size, &mut out).map_err(|complaint| {
                Reason::Syntax(format!("block {k} of an array {complaint}"))
            })?;
        }
        Ok(out)
    }
}

/// Bytes of a file, as they are or behind base64.
pub(super) enum Stream<'a> {
    /// As they are.
    Raw(&'a [u8]),
    /// Base64 text, and the bytes of its last group that were not asked for yet.
    Base64 {
        /// Text that is not decoded yet.
        text: &'a [u8],
        /// Decoded bytes of the last group; the first `used` of them were taken.
        group: [u8; 3],
        /// The number of bytes of the last group.
        length: usize,
        /// The number of bytes taken from it.
        used: usize,
    },
}

impl<'a> Stream<'a> {
    /// A stream over base64 text, in which blanks mean nothing.
    pub(super) fn base64(text: &'a [u8]) -> Self {
        Stream::Base64 { text, group: [0; 3], length: 0, used: 0 }
    }

    /// Bytes of the file that were not looked at yet.
    pub(super) fn remaining(&self) -> usize {
        match self {
            Stream::Raw(rest) | Stream::Base64 { text: rest, .. } => rest.len(),
        }
    }

    /// The next `count` bytes.
    fn take(&mut self, count: u64) -> Result<Cow<'a, [u8]>, Reason> {
        let truncated = |found: usize| Reason::Truncated {
            what: "bytes of an array",
            announced: count,
            found: found as u64,
        };
        let wanted = usize::try_from(count).unwrap_or(usize::MAX);
        match self {
            Stream::Raw(bytes) => {
                let (front, rest) =
                    bytes.split_at_checked(wanted).ok_or_else(|| truncated(bytes.len()))?;
                *bytes = rest;
                Ok(Cow::Borrowed(front))
            }
            Stream::Base64 { text, group, length, used } => {
                let mut out = Vec::with_capacity(wanted.min(text.len() / 4 * 3 + 3));
                // Every turn takes bytes of a group or decodes the next.
                while out.len() < wanted {
                    if used == length {
                        (*group, *length) =
                            next_group(text)?.ok_or_else(|| truncated(out.len()))?;
                        *used = 0;
                    }
                    let end = (*length).min(*used + wanted - out.len());
                    out.extend_from_slice(&group[*used..end]);
                    *used = end;
                }
                Ok(Cow::Owned(out))
            }
        }
    }
}

/// Decodes the next four digits of base64, the last one or two of which may be padding.
fn next_group(text: &mut &[u8]) -> Result<Option<([u8; 3], usize)>, Reason> {
    let (mut word, mut digits, mut padding) = (0_u32, 0, 0);
    // Every turn takes a character.
    while digits < 4 {
        let Some((&c, rest)) = text.split_first() else { break };
        *text = rest;
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b'=' if digits >= 2 => 0,
            c if c.is_ascii_whitespace() => continue,
            _ => return Err(Reason::Syntax(format!("`{}` in base64 data", excerpt(&[c])))),
        };
        padding += usize::from(c == b'=');
        if padding > 0 && c != b'=' {
            return Err(Reason::Syntax("padding inside a group of base64 data".into()));
        }
        word = word << 6 | u32::from(value);
        digits += 1;
    }
    match digits {
        4 => {
            let [_, a, b, c] = word.to_be_bytes();
            Ok(Some(([a, b, c], 3 - padding)))
        }
        0 => Ok(None),
        _ => Err(Reason::Syntax("base64 data ends inside a group".into())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(header: &str) -> Layout {
        Layout::new("", header, "").expect("known names")
    }

    #[test]
    fn base64_of_rfc_4648_with_padding_anywhere() {
        let mut stream = Stream::base64(b"Zg==\n Zm8=Zm9vYmFy");
        assert_eq!(&*stream.take(1).unwrap(), b"f");
        assert_eq!(&*stream.take(3).unwrap(), b"fof");
        assert_eq!(&*stream.take(5).unwrap(), b"oobar");
        let early = Reason::Truncated { what: "bytes of an array", announced: 1, found: 0 };
        assert_eq!(stream.take(1), Err(early));
        for bad in [&b"Zg=a"[..], b"Z===", b"Zg", b"Zg-_", b"\xff"] {
            assert!(Stream::base64(bad).take(1).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn counts_are_claims() {
        let huge = [&[0xff; 8][..], &[1, 2, 3]].concat();
        fn decode(layout: Layout, bytes: &[u8]) -> Result<(), Reason> {
            let mut room = u64::MAX;
            layout.decode(&mut Stream::Raw(bytes), &mut room).map(|_| ())
        }
        let reason = decode(plain("UInt64"), &huge).unwrap_err();
        assert_eq!(
            reason,
            Reason::Truncated { what: "bytes of an array", announced: u64::MAX, found: 3 }
        );
        let packed = Layout::new("", "UInt32", "vtkZLibDataCompressor").expect("known names");
        let mut bytes = [0xff; 12].to_vec();
        assert!(matches!(decode(packed, &bytes), Err(Reason::Truncated { found: 0, .. })));
        // One block of 2^32 - 1 bytes, compressed to 4, that is no zlib data.
        bytes[..4].copy_from_slice(&1_u32.to_le_bytes());
        bytes.extend(4_u32.to_le_bytes());
        bytes.extend([1, 2, 3, 4]);
        let text = "block 0 of an array is no zlib data";
        assert_eq!(decode(packed, &bytes), Err(Reason::Syntax(text.into())));
        assert_eq!(decode(packed, &[0; 4]), Ok(()));
    }

    #[test]
    fn blocks_have_the_announced_sizes() {
        use flate2::{Compression, write::ZlibEncoder};
        use std::io::Write;
        let pack = |data: &[u8]| {
            let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
            encoder.write_all(data).unwrap();
            encoder.finish().unwrap()
        };
        let blocks = [pack(b"abcd"), pack(b"efgh"), pack(b"i")];
        let array = |size: u32, last: u32| {
            let sizes = blocks.iter().map(|b| b.len() as u32);
            let header = [3, size, last].into_iter().chain(sizes);
            let header: Vec<u8> = header.flat_map(u32::to_be_bytes).collect();
            [header, blocks.concat()].concat()
        };
        let layout = Layout::new("BigEndian", "", "vtkZLibDataCompressor").expect("known names");
        let within = |bytes: &[u8], mut room: u64| {
            layout.decode(&mut Stream::Raw(bytes), &mut room).map(Cow::into_owned)
        };
        let decode = |bytes: &[u8]| within(bytes, u64::MAX);
        assert_eq!(decode(&array(4, 1)), Ok(b"abcdefghi".to_vec()));
        for (size, last) in [(4, 0), (4, 2), (3, 1), (5, 1)] {
            assert!(decode(&array(size, last)).is_err(), "{size} {last}");
        }
        // All blocks of a file share what they may become.
        assert!(within(&array(4, 1), 9).is_ok());
        let text = "block 2 of an array announces 1 bytes, far too many";
        assert_eq!(within(&array(4, 1), 8), Err(Reason::Syntax(text.into())));
    }

    #[test]
    fn unknown_layouts_are_named() {
        let says = |o, h, c| Layout::new(o, h, c).expect_err("unknown").to_string();
        assert_eq!(says("Middle", "", ""), "not supported: the byte order `Middle`");
        assert_eq!(says("", "UInt8", ""), "not supported: the header type `UInt8`");
        assert_eq!(
            says("", "", "vtkBrotliDataCompressor"),
            "not supported: the compressor `vtkBrotliDataCompressor`"
        );
        assert!(plain("").scalar("String").is_err());
    }
}
