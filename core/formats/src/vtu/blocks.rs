//! Compressed blocks of arrays: zlib, LZ4 and LZMA, as VTK's compressors write them.
//!
//! A block must give the number of bytes that the array's header announces. Memory grows with what
//! is really there, by no more than the factor that the compression can have.
//! Source: RFC 1950; "LZ4 Block Format Description"; "The .xz File Format".

use flate2::read::ZlibDecoder;
use lzma_rust2::XzReader;
use std::io::Read;

/// The most bytes that LZ4 makes of one: a length grows by 255 with each byte.
const LZ4_RATIO: u64 = 255;

/// The most memory for a dictionary of LZMA, in units of 1024 bytes: the largest preset has 65,536.
const LZMA_MEMORY: u32 = 80 << 10;

/// VTK's compressors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compressor {
    /// RFC 1950.
    Zlib,
    /// Blocks of LZ4, without its frame.
    Lz4,
    /// A stream of `.xz` for each block.
    Lzma,
}

impl Compressor {
    /// The compressor that the attribute `compressor` names.
    pub(super) fn named(name: &str) -> Option<Self> {
        match name {
            "vtkZLibDataCompressor" => Some(Compressor::Zlib),
            "vtkLZ4DataCompressor" => Some(Compressor::Lz4),
            "vtkLZMADataCompressor" => Some(Compressor::Lzma),
            _ => None,
        }
    }

    /// Appends the bytes of a block, which must be `size`, to `out`; or complains.
    pub(super) fn unpack(self, packed: &[u8], size: u64, out: &mut Vec<u8>) -> Result<(), String> {
        let before = out.len();
        // One byte more would be too many.
        let most = size.saturating_add(1);
        let (name, complete) = match self {
            Compressor::Zlib => {
                ("zlib", ZlibDecoder::new(packed).take(most).read_to_end(out).is_ok())
            }
            Compressor::Lzma => {
                let reader = XzReader::new_mem_limit(packed, false, LZMA_MEMORY);
                ("LZMA", reader.take(most).read_to_end(out).is_ok())
            }
            Compressor::Lz4 => ("LZ4", lz4(packed, size, out)),
        };
        if !complete {
            return Err(format!("is no {name} data"));
        }
        if (out.len() - before) as u64 != size {
            return Err(format!("inflates to other than {size} bytes"));
        }
        Ok(())
    }
}

/// Appends an LZ4 block; false if it is none, or larger than `size`.
fn lz4(packed: &[u8], size: u64, out: &mut Vec<u8>) -> bool {
    let before = out.len();
    let possible = (packed.len() as u64).saturating_mul(LZ4_RATIO);
    let Some(end) = usize::try_from(size.min(possible)).ok().and_then(|s| before.checked_add(s))
    else {
        return false;
    };
    out.resize(end, 0);
    let Some(room) = out.get_mut(before..) else { return false };
    match lz4_flex::block::decompress_into(packed, room) {
        Ok(length) => {
            out.truncate(before + length);
            true
        }
        Err(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::Compressor::{Lz4, Lzma, Zlib};
    use super::*;

    const TEXT: &[u8] = b"abcdefghabcdefghabcdefghabcdefgh!";

    /// `TEXT` by the library of `xz`, with its least preset.
    const XZ: &[u8] = &[
        0xfd, 0x37, 0x7a, 0x58, 0x5a, 0x00, 0x00, 0x04, 0xe6, 0xd6, 0xb4, 0x46, 0x02, 0x00, 0x21,
        0x01, 0x0c, 0x00, 0x00, 0x00, 0x8f, 0x98, 0x41, 0x9c, 0xe0, 0x00, 0x20, 0x00, 0x10, 0x5d,
        0x00, 0x30, 0x98, 0x88, 0x98, 0x3e, 0xcb, 0xe2, 0x6f, 0x3a, 0x96, 0x3f, 0x11, 0x67, 0x7c,
        0x00, 0x00, 0x00, 0xb7, 0xf5, 0xe6, 0xd4, 0x0f, 0x2d, 0xf2, 0x60, 0x00, 0x01, 0x2c, 0x21,
        0xdb, 0xce, 0xde, 0x55, 0x1f, 0xb6, 0xf3, 0x7d, 0x01, 0x00, 0x00, 0x00, 0x00, 0x04, 0x59,
        0x5a,
    ];

    /// Eight literals, a match of 19 bytes at a distance of 8, six literals.
    const LZ4: &[u8] = b"\x8fabcdefgh\x08\x00\x00\x60defgh!";

    fn unpack(compressor: Compressor, packed: &[u8], size: u64) -> Result<Vec<u8>, String> {
        let mut out = b"before ".to_vec();
        compressor.unpack(packed, size, &mut out)?;
        Ok(out)
    }

    #[test]
    fn blocks_of_other_programs_are_unpacked() {
        let whole = [b"before ", TEXT].concat();
        let size = TEXT.len() as u64;
        for (compressor, packed) in [(Lz4, LZ4), (Lzma, XZ)] {
            assert_eq!(unpack(compressor, packed, size), Ok(whole.clone()), "{compressor:?}");
            for wrong in [0, size - 1, size + 1, u64::MAX] {
                assert!(unpack(compressor, packed, wrong).is_err(), "{compressor:?} {wrong}");
            }
            for cut in 0..packed.len() {
                assert!(unpack(compressor, &packed[..cut], size).is_err(), "{compressor:?} {cut}");
            }
            for other in [Zlib, Lz4, Lzma].into_iter().filter(|other| *other != compressor) {
                assert!(unpack(other, packed, size).is_err(), "{compressor:?} as {other:?}");
            }
        }
    }

    #[test]
    fn a_flipped_byte_of_xz_is_noticed() {
        for at in 0..XZ.len() {
            let mut packed = XZ.to_vec();
            packed[at] ^= 0x40;
            assert!(unpack(Lzma, &packed, TEXT.len() as u64).is_err(), "{at}");
        }
    }
}
