//! Certificates bound to the mesh by its hash, to the input by that of the bytes read, and to the
//! options by their texts.

use crate::outcome::Failure;
use ltbw::io::{self, IoError};
use serde::Serialize;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// The version of the list of options, at the front of what is hashed.
const OPTIONS: &str = "ltbw.options/1\n";

/// SHA-256, in lower-case hexadecimal digits.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    digits(&Sha256::digest(bytes))
}

/// Lower-case hexadecimal digits.
pub(crate) fn digits(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string does not fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// The part that a file has in the input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Role {
    /// The points or the domain.
    Input,
    /// A file that belongs to it: the `.node` of a `.poly`.
    Companion,
    /// Points that were removed.
    Without,
    /// Points that are to be vertices of a domain's mesh.
    Points,
    /// The domain of a mesh that is gone on with.
    Domain,
    /// Numbers of tetrahedra that are to be split.
    Mark,
    /// Edge lengths.
    Sizes,
    /// The mesh that they are about, and what belongs to it.
    Background,
}

/// A file as it was read.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Read {
    pub(crate) role: Role,
    pub(crate) name: String,
    pub(crate) bytes: usize,
    pub(crate) sha256: String,
}

impl Read {
    /// A file of this length and hash.
    pub(crate) fn new(role: Role, path: &Path, bytes: usize, sha256: String) -> Self {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Self { role, name, bytes, sha256 }
    }
}

/// The hash of files that were read.
pub(crate) fn fingerprint(inputs: &[Read]) -> String {
    let texts: Vec<&str> = inputs.iter().map(|read| read.sha256.as_str()).collect();
    sha256(texts.join("\n").as_bytes())
}

/// The files read so far.
#[derive(Debug, Default)]
pub(crate) struct Reads(RefCell<Vec<Read>>);

impl Reads {
    /// Notes bytes that were read.
    pub(crate) fn add(&self, role: Role, path: &Path, bytes: &[u8]) {
        self.0.borrow_mut().push(Read::new(role, path, bytes.len(), sha256(bytes)));
    }

    /// Adds a file that was read elsewhere, in another part.
    pub(crate) fn take(&self, role: Role, read: Read) {
        self.0.borrow_mut().push(Read { role, ..read });
    }

    /// The bytes of a file, which are noted.
    pub(crate) fn load(&self, role: Role, path: &Path) -> Result<Vec<u8>, IoError> {
        io::read_bytes(path).inspect(|bytes| self.add(role, path, bytes))
    }

    /// The files of an input, of which the first is the input itself.
    pub(crate) fn load_first(&self, path: &Path) -> Result<Vec<u8>, IoError> {
        let role = if self.0.borrow().is_empty() { Role::Input } else { Role::Companion };
        self.load(role, path)
    }

    /// All of them, in the order in which they were read.
    pub(crate) fn list(&self) -> Vec<Read> {
        self.0.borrow().clone()
    }
}

/// The options that a mesh and its judgement depend on, as texts; what was not asked for is left
/// out. The number of threads or workers is not among them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Chosen(BTreeMap<&'static str, String>);

impl Chosen {
    /// Adds an option that has a value.
    pub(crate) fn with(mut self, name: &'static str, value: Option<impl ToString>) -> Self {
        self.0.extend(value.map(|value| (name, value.to_string())));
        self
    }

    /// Adds a number as it is read back to the bit.
    pub(crate) fn number(self, name: &'static str, value: Option<f64>) -> Self {
        self.with(name, value.map(|value| format!("{value:?}")))
    }

    /// Adds a choice that was made.
    pub(crate) fn flag(self, name: &'static str, is_set: bool) -> Self {
        self.with(name, is_set.then_some("true"))
    }
}

/// An option that was chosen, and its value as text.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Setting<'a> {
    pub(crate) name: &'a str,
    pub(crate) value: &'a str,
}

/// The hash of a list of options: by name, each on a line.
pub(crate) fn options_hash<'a>(options: impl Iterator<Item = Setting<'a>>) -> String {
    let mut all: Vec<Setting<'_>> = options.collect();
    all.sort_unstable();
    let lines = all.iter().fold(OPTIONS.to_owned(), |mut text, Setting { name, value }| {
        let _ = writeln!(text, "{name} {value}");
        text
    });
    sha256(lines.as_bytes())
}

/// Input and options of a run.
#[derive(Debug, Clone, Default)]
pub(crate) struct Binding {
    pub(crate) inputs: Vec<Read>,
    pub(crate) options: Chosen,
}

impl Binding {
    /// Binds a certificate to the mesh of this hash, to the input and to the options.
    pub(crate) fn bind(&self, certificate: &mut Value, hash: &str) {
        let options = &self.options.0;
        certificate["binding"] = json!({
            "mesh": hash,
            "inputs": self.inputs,
            "options": options,
            "options_sha256": options_hash(
                options.iter().map(|(name, value)| Setting { name, value })
            ),
        });
    }
}

/// Reads a file of sizes, or of a mesh, that belongs to the input.
pub(crate) fn read_beside<T>(
    reads: &Reads,
    role: Role,
    path: &Path,
    read: impl FnOnce(&Path, &mut io::Load<'_>) -> Result<T, IoError>,
) -> Result<T, Failure> {
    read(path, &mut |path| reads.load(role, path)).map_err(Failure::Read)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_the_standard_and_of_a_written_list() {
        let empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
        assert_eq!(sha256(b""), empty);
        let options = Chosen::default().number("b", Some(1e-5)).flag("a", true).flag("c", false);
        let mut certificate = json!({});
        Binding { inputs: Vec::new(), options }.bind(&mut certificate, "hash");
        let binding = &certificate["binding"];
        assert_eq!(binding["options"], json!({ "a": "true", "b": "1e-5" }));
        assert_eq!(binding["options_sha256"], sha256(b"ltbw.options/1\na true\nb 1e-5\n"));
    }
}
