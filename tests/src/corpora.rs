//! The committed corpora of the fuzz targets: an archive a target, `fuzz/corpus/TARGET.zip`.

use std::fs::File;
use std::io::{Error, Read, Result, Write};
use std::path::{Path, PathBuf};
use zip::write::{SimpleFileOptions, ZipWriter};
use zip::{DateTime, ZipArchive};

/// The archive of a target.
#[must_use]
pub fn archive(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(format!("{target}.zip"))
}

/// The inputs of an archive, with their names there.
///
/// # Errors
/// An archive that cannot be read.
pub fn read(archive: &Path) -> Result<Vec<(String, Vec<u8>)>> {
    let mut archive = ZipArchive::new(File::open(archive)?)?;
    let mut inputs = Vec::with_capacity(archive.len());
    for k in 0..archive.len() {
        let mut entry = archive.by_index(k)?;
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes)?;
        let name = entry.name().map_err(Error::from)?.into_owned();
        inputs.push((name, bytes));
    }
    Ok(inputs)
}

/// Writes an archive of inputs, the short ones first, each under its number. The same inputs give
/// the same bytes.
///
/// # Errors
/// An archive that cannot be written.
pub fn write(archive: &Path, mut inputs: Vec<Vec<u8>>) -> Result<()> {
    inputs.sort_by(|a, b| a.len().cmp(&b.len()).then_with(|| a.cmp(b)));
    inputs.dedup();
    let options = SimpleFileOptions::default().last_modified_time(DateTime::default());
    let mut writer = ZipWriter::new(File::create(archive)?);
    for (k, bytes) in inputs.iter().enumerate() {
        writer.start_file(format!("{k:04}"), options).map_err(Error::from)?;
        writer.write_all(bytes)?;
    }
    writer.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{read, write};

    #[test]
    fn inputs_come_back_whatever_their_order() {
        let folder = tempfile::tempdir().expect("a folder");
        let [one, two] = ["one.zip", "two.zip"].map(|name| folder.path().join(name));
        let inputs = [&b"longer"[..], b"", b"b", b"a", b"b"].map(<[u8]>::to_vec);
        write(&one, inputs.to_vec()).expect("an archive");
        write(&two, inputs.iter().rev().cloned().collect()).expect("an archive");
        assert_eq!(std::fs::read(&one).expect("one"), std::fs::read(&two).expect("two"));
        let found: Vec<_> = read(&one).expect("inputs").into_iter().map(|(_, b)| b).collect();
        assert_eq!(found, [&b""[..], b"a", b"b", b"longer"]);
        assert!(read(&folder.path().join("none.zip")).is_err());
    }
}
