//! The points of an input in slices: each process reads its own, by the formats that can be cut; of
//! others the first process reads the whole, and deals it.
//!
//! One file is read by all: each tells the hashes of its bytes, and the first process, which goes
//! through the whole file for the hash of the certificate, a block at a time, compares.

use crate::binding::{Read, Role, digits};
use crate::others::{Apart, Ranks};
use crate::outcome::{Exit, Failure};
use crate::streams::Source;
use ltbw::Point;
use ltbw::distributed::Points;
use ltbw::io::slices::{Size, Slice, Slices};
use ltbw::io::{IoError, PartOf};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::Path;

/// Bytes of the file that the first process holds at a time.
const BLOCK: usize = 1 << 20;

/// The part of an input that a process has.
pub(crate) struct Sliced {
    pub(crate) points: Vec<Point>,
    pub(crate) tags: Option<Vec<i64>>,
    /// The parts of the file that were not read, in words for people.
    pub(crate) notes: Vec<String>,
    /// The files of which all have read, at the first process.
    pub(crate) reads: Vec<Read>,
}

/// Reads the own slice of an input.
pub(crate) fn read(others: &dyn Ranks, source: &Source) -> Result<Sliced, Failure> {
    let apart = others.apart();
    let Some(slices) = Slices::open(&source.name, source.format).map_err(Failure::Read)? else {
        let whole = if apart.is_first() { Some(source.points()?) } else { None };
        others.agree(String::new())?;
        let notes = whole.as_ref().map(|file| file.notes.clone()).unwrap_or_default();
        let whole = whole.map(|file| Points { at: file.points, tags: file.point_tags });
        let Points { at: points, tags } = apart.deal(whole)?;
        return Ok(Sliced { points, tags, notes, reads: source.reads().list() });
    };
    let head = slices.head().to_vec();
    let length = slices.length();
    let place = PartOf { part: apart.me() as usize, of: apart.size() as usize };
    let slice = slices.slice(place).map_err(Failure::Read)?;
    others.agree(format!("{length} {}", digits(&Sha256::digest(&head))))?;
    let all: Vec<[u64; 2]> = apart.all(&[slice.size().lines, slice.size().points])?;
    let before = all[..place.part].iter().fold(Size::default(), |sum, [lines, points]| Size {
        lines: sum.lines.saturating_add(*lines),
        points: sum.points.saturating_add(*points),
    });
    let sha256 = compare(apart, &source.name, &slice)?;
    let reads = sha256.map(|own| Read::new(Role::Input, &source.name, length as usize, own));
    let file = apart.together(slice.parse(&head, before).map_err(Failure::Read))?;
    let mut notes = Vec::new();
    for note in apart.all(&file.notes)?.into_iter().flatten() {
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    let (points, tags) = (file.points, file.point_tags);
    Ok(Sliced { points, tags, notes, reads: reads.into_iter().collect() })
}

/// A range of the file as a process has read it, and the hash of its bytes.
type Seen = (u64, u64, Vec<u8>);

/// Makes sure that the slices of all are of one file; its hash, at the first process.
fn compare(apart: &dyn Apart, path: &Path, slice: &Slice) -> Result<Option<String>, Failure> {
    let mut bytes = slice.bytes();
    let mut seen: Vec<Seen> = Vec::new();
    // The first one is compared with.
    for Range { start, end } in slice.ranges().iter().filter(|_| !apart.is_first()) {
        let (own, rest) = bytes.split_at((end - start) as usize);
        seen.push((*start, *end, Sha256::digest(own).to_vec()));
        bytes = rest;
    }
    let all: Vec<Vec<Seen>> = apart.all(&seen)?;
    let found = if apart.is_first() { look(path, &all).map(Some) } else { Ok(None) };
    apart.together(found)
}

/// The hash of a file, if all have seen bytes of it.
fn look(path: &Path, all: &[Vec<Seen>]) -> Result<String, Failure> {
    let failed = |source| Failure::Read(IoError::Read { path: path.to_owned(), source });
    let mut file = File::open(path).map_err(failed)?;
    let mut whole = Sha256::new();
    let ranges =
        all.iter().enumerate().flat_map(|(rank, seen)| seen.iter().map(move |s| (rank, s)));
    let mut ranges: Vec<_> = ranges.map(|(rank, seen)| (rank, seen, Sha256::new())).collect();
    let (mut block, mut at) = (vec![0; BLOCK], 0);
    // Ends: the file does.
    loop {
        let read = match io::Read::read(&mut file, &mut block) {
            Ok(0) => break,
            Ok(read) => read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(failed(error)),
        };
        let block = &block[..read];
        whole.update(block);
        for (_, (start, end, _), hash) in &mut ranges {
            let inside = |place: &u64| place.saturating_sub(at).min(read as u64) as usize;
            hash.update(&block[inside(start)..inside(end).max(inside(start))]);
        }
        at += read as u64;
    }
    for (rank, (.., told), hash) in ranges {
        if hash.finalize()[..] != told[..] {
            let why = format!("rank {rank} has read another input than rank 0");
            return Err(Failure::Agreed { code: Exit::Input as u8, why });
        }
    }
    Ok(digits(&whole.finalize()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::binding::sha256;

    #[test]
    fn a_slice_of_another_file_is_named_by_its_rank() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("points.xyz");
        let bytes: Vec<u8> = (0..3 * BLOCK as u32 / 2).map(|k| (k % 251) as u8).collect();
        std::fs::write(&path, &bytes).expect("a file");
        let seen = |start: usize, end: usize, bytes: &[u8]| {
            (start as u64, end as u64, Sha256::digest(&bytes[start..end]).to_vec())
        };
        let (n, mut other) = (bytes.len(), bytes.clone());
        other[BLOCK + 7] += 1;
        // In three stretches, as of an array in Fortran order, one of them empty.
        let sound = vec![
            Vec::new(),
            vec![seen(9, 9, &bytes), seen(10, 999, &bytes), seen(BLOCK - 3, BLOCK + 9, &bytes)],
            vec![seen(BLOCK + 9, n, &bytes)],
        ];
        assert_eq!(look(&path, &sound).expect("one file"), sha256(&bytes));
        let mut odd = sound.clone();
        odd[1][2] = seen(BLOCK - 3, BLOCK + 9, &other);
        let error = look(&path, &odd).expect_err("two files").to_string();
        assert_eq!(error, "rank 1 has read another input than rank 0");
        // Bytes of another one beyond the end are not here.
        other.extend([1, 2]);
        odd = sound;
        odd[2][0] = seen(BLOCK + 9, n + 2, &other);
        let error = look(&path, &odd).expect_err("two files").to_string();
        assert!(error.starts_with("rank 2 has read another input"), "{error}");
        assert!(look(&folder.path().join("none"), &[]).is_err());
    }
}
