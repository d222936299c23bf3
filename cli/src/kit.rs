//! The conformance kit inside the program, so that whoever has the program has the kit.
//!
//! A package can hold no file from outside its own folder, so a copy of `verify/vectors` is packed
//! beside this crate's sources: one JSON object of paths and texts, deflated. `cargo xtask vectors`
//! writes it anew (`examples/pack_kit.rs`), and `tests/vectors.rs` holds it to the folder.

use crate::outcome::Failure;
use flate2::read::GzDecoder;
use ltbw::io;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const PACKED: &[u8] = include_bytes!("../kit/vectors.json.gz");

/// Texts by their paths inside the kit.
pub(crate) fn files() -> Result<BTreeMap<String, String>, Failure> {
    serde_json::from_reader(GzDecoder::new(PACKED))
        .map_err(|error| Failure::Other(format!("the kit inside the program: {error}")))
}

/// The places of files that were written into a folder, which is made where it is missing.
pub(crate) fn unpack(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut written = Vec::new();
    for (name, text) in files()? {
        let path = folder.join(name);
        let parent = path.parent().unwrap_or(folder);
        std::fs::create_dir_all(parent).map_err(|source| {
            Failure::Write(io::IoError::Write { path: parent.to_owned(), source })
        })?;
        io::write_bytes(&path, text.as_bytes()).map_err(Failure::Write)?;
        if text.starts_with("#!") {
            make_executable(&path).map_err(|source| {
                Failure::Write(io::IoError::Write { path: path.clone(), source })
            })?;
        }
        written.push(path);
    }
    Ok(written)
}

#[cfg(unix)]
fn make_executable(path: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    let mut permissions = std::fs::metadata(path)?.permissions();
    // Readers may run it, too.
    permissions.set_mode(permissions.mode() | (permissions.mode() & 0o444) >> 2);
    std::fs::set_permissions(path, permissions)
}

#[cfg(not(unix))]
fn make_executable(_: &Path) -> std::io::Result<()> {
    Ok(())
}
