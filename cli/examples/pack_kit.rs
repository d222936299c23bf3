//! `cargo xtask vectors`: packs the conformance kit for `src/kit.rs`. Arguments: the kit's folder,
//! the file to write.
#![forbid(unsafe_code)]

use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};

type Texts = BTreeMap<String, String>;

/// Texts of the files of a folder and of its folders.
fn texts(root: &Path) -> Result<Texts, Box<dyn Error>> {
    let mut found = Texts::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder)? {
            let path = entry?.path();
            if path.is_dir() {
                // Python's caches are the only folders that are not the kit's.
                if !path.ends_with("__pycache__") {
                    folders.push(path);
                }
                continue;
            }
            let parts = path.strip_prefix(root)?.iter().map(|part| part.to_string_lossy());
            let name = parts.collect::<Vec<_>>().join("/");
            found.insert(name, std::fs::read_to_string(&path)?);
        }
    }
    Ok(found)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1).map(PathBuf::from);
    let (Some(folder), Some(file)) = (words.next(), words.next()) else {
        return Err("name the kit's folder and the file to write".into());
    };
    let texts = texts(&folder)?;
    // Other releases of the compressor make other bytes of the same texts.
    let old = std::fs::File::open(&file).ok();
    let old: Option<Texts> = old.and_then(|old| serde_json::from_reader(GzDecoder::new(old)).ok());
    if old.as_ref() == Some(&texts) {
        return Ok(());
    }
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    serde_json::to_writer(&mut packed, &texts)?;
    let packed = packed.finish()?;
    std::fs::write(&file, &packed)?;
    println!("written: {}, {} bytes", file.display(), packed.len());
    Ok(())
}
