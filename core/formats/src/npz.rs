//! `.npz`: NumPy arrays in a ZIP archive, as `numpy.savez` and `numpy.savez_compressed` write them.
//!
//! The points are the array named `points`, or else the only one of shape (n, 3). Other arrays are
//! not read; a note says so. What an entry announces is compared with what Deflate can make of its
//! bytes before it is inflated.

use super::PointFile;
use super::error::{ParseError, Place, Reason, excerpt, one_line};
use super::npy;
use std::io::{Cursor, Read};
use zip::ZipArchive;

/// The most arrays among which the points are looked for.
const MOST_ARRAYS: usize = 1000;

/// The most bytes that Deflate makes of one.
const LARGEST_RATIO: u64 = 1032;

/// An archive in memory.
type Archive<'a> = ZipArchive<Cursor<&'a [u8]>>;

/// Reads an `.npz` file.
pub fn read(bytes: &[u8]) -> Result<PointFile, ParseError> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| header(broken(&e)))?;
    let index = points(&mut archive).map_err(header)?;
    let array = inflate(&mut archive, index).map_err(header)?;
    let mut file = npy::read(&array)?;
    if archive.len() > 1 {
        file.notes.push(format!("of {} arrays one is read, the points", archive.len()));
    }
    Ok(file)
}

fn header(reason: Reason) -> ParseError {
    ParseError::new(Place::Header, reason)
}

fn broken(error: &dyn std::error::Error) -> Reason {
    Reason::Syntax(format!("not a NumPy archive: {}", one_line(&error.to_string(), 120)))
}

/// The place of the points in the archive.
fn points(archive: &mut Archive<'_>) -> Result<usize, Reason> {
    if let Some(index) = archive.index_for_name("points.npy") {
        return Ok(index);
    }
    let count = archive.len();
    if count > MOST_ARRAYS {
        let text = format!("none of {count} arrays is named `points`");
        return Err(Reason::Unsupported(text));
    }
    let mut found = Vec::new();
    for index in 0..count {
        let mut start = Vec::new();
        let entry = archive.by_index(index).map_err(|e| broken(&e))?;
        let name = entry.name().map_err(|e| broken(&e))?.into_owned();
        entry.take(npy::LONGEST_HEADER).read_to_end(&mut start).map_err(|e| broken(&e))?;
        if npy::starts_points(&start) {
            found.push((index, name));
        }
    }
    match found.as_slice() {
        [(index, _)] => Ok(*index),
        [] => {
            let text = "no array is named `points`, and none is of numbers in the shape (n, 3)";
            Err(Reason::Syntax(text.into()))
        }
        [(_, first), (_, second), ..] => {
            let [first, second] = [first, second].map(|name| excerpt(name.as_bytes()));
            let text = format!(
                "several arrays of shape (n, 3), `{first}` and `{second}`, and none named `points`"
            );
            Err(Reason::Unsupported(text))
        }
    }
}

/// The bytes of an entry.
fn inflate(archive: &mut Archive<'_>, index: usize) -> Result<Vec<u8>, Reason> {
    let entry = archive.by_index(index).map_err(|e| broken(&e))?;
    let (announced, packed) = (entry.size(), entry.compressed_size());
    if announced > packed.saturating_mul(LARGEST_RATIO).saturating_add(64) {
        let text = format!("an array of {announced} bytes in {packed} compressed ones");
        return Err(Reason::Syntax(text));
    }
    let mut bytes = Vec::new();
    // The memory grows with what is really there; one byte more would be too many.
    entry.take(announced.saturating_add(1)).read_to_end(&mut bytes).map_err(|e| broken(&e))?;
    if bytes.len() as u64 != announced {
        let found = bytes.len() as u64;
        return Err(Reason::Truncated { what: "bytes of an array", announced, found });
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use zip::CompressionMethod::{Deflated, Stored};
    use zip::write::{SimpleFileOptions, ZipWriter};

    fn array(points: &[[f64; 3]]) -> Vec<u8> {
        let mut bytes = Vec::new();
        npy::write(&mut bytes, points, None).expect("memory");
        bytes
    }

    fn archive(method: zip::CompressionMethod, entries: &[(&str, &[u8])]) -> Vec<u8> {
        let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default().compression_method(method);
        for (name, bytes) in entries {
            writer.start_file(*name, options).expect("an entry");
            writer.write_all(bytes).expect("memory");
        }
        writer.finish().expect("memory").into_inner()
    }

    #[test]
    fn the_points_are_found_by_name_or_shape() {
        let (a, b) = (array(&[[1.0, 2.0, -0.0]]), array(&[[4.0; 3], [5.0; 3]]));
        let flat = String::from_utf8(a.clone()).map_or(a.clone(), String::into_bytes);
        let other: Vec<u8> = {
            // The shape (1, 4), of as many characters.
            let mut bytes = flat;
            let at = bytes.windows(6).position(|w| w == b"(1, 3)").expect("a shape");
            bytes[at + 4] = b'4';
            bytes
        };
        for method in [Stored, Deflated] {
            let named = archive(method, &[("x.npy", &a), ("points.npy", &b)]);
            let file = read(&named).expect("points");
            assert_eq!(file.points, [[4.0; 3], [5.0; 3]]);
            assert_eq!(file.notes.len(), 1);
            let shaped = read(&archive(method, &[("w.npy", &other), ("v.npy", &a)]));
            let shaped = shaped.expect("points").points;
            assert_eq!(shaped[0].map(f64::to_bits), [1.0, 2.0, -0.0_f64].map(f64::to_bits));
            assert!(read(&archive(method, &[("v.npy", &a)])).expect("points").notes.is_empty());
            let says = |entries: &[(&str, &[u8])]| {
                read(&archive(method, entries)).expect_err("no points").to_string()
            };
            assert!(says(&[("w.npy", &other)]).contains("no array is named `points`"));
            assert!(says(&[]).contains("no array is named `points`"));
            let two = says(&[("a.npy", &a), ("b.npy", &b)]);
            assert!(two.contains("`a.npy` and `b.npy`"), "{two}");
            assert!(says(&[("points.npy", &other)]).contains("the shape is (1, 4)"));
            assert!(says(&[("points.npy", b"12")]).contains("not a NumPy file"));
        }
        assert!(read(b"PK").expect_err("no archive").to_string().contains("not a NumPy archive"));
    }

    /// A small archive must not announce a large array: neither size of the entry is believed.
    #[test]
    fn announced_sizes_are_claims() {
        let bytes = archive(Deflated, &[("points.npy", &array(&[[1.0; 3]; 50]))]);
        let size = u32::try_from(array(&[[1.0; 3]; 50]).len()).expect("small").to_le_bytes();
        for claimed in [u32::MAX - 1, 10_000, 100] {
            let mut forged = bytes.clone();
            for at in 0..bytes.len() - 4 {
                if bytes[at..at + 4] == size {
                    forged[at..at + 4].copy_from_slice(&claimed.to_le_bytes());
                }
            }
            assert_ne!(forged, bytes, "the size stands somewhere");
            assert!(read(&forged).is_err(), "{claimed}");
        }
        for cut in 0..bytes.len() {
            assert!(read(&bytes[..cut]).is_err(), "{cut}");
        }
    }
}
