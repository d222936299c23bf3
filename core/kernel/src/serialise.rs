//! Serialisation (feature `serde`) of what cannot be derived: a mesh goes through its
//! [`Snapshot`], a point set is its points, a hash is its hexadecimal digits.

use crate::hash::MeshHash;
use crate::mesh::Mesh;
use crate::snapshot::Snapshot;
use serde::de::Error as _;
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

impl Serialize for Mesh {
    /// Serialises [`Mesh::snapshot`].
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.snapshot().map_err(S::Error::custom)?.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Mesh {
    /// Deserialises a [`Snapshot`] and restores it. The error has only the text of the
    /// [`crate::SnapshotError`]: deserialise a [`Snapshot`] to have the error itself.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Snapshot::deserialize(deserializer)?.restore().map_err(D::Error::custom)
    }
}

impl Serialize for MeshHash {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for MeshHash {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        parse_hash(&text).ok_or_else(|| {
            D::Error::custom(format_args!("`{text}` is not 64 lower-case hexadecimal digits"))
        })
    }
}

fn parse_hash(text: &str) -> Option<MeshHash> {
    let digit = |b: u8| match b {
        b'0'..=b'9' => Some(b - b'0'),
        b'a'..=b'f' => Some(b - b'a' + 10),
        _ => None,
    };
    let mut hash = [0; 32];
    if text.len() != 64 {
        return None;
    }
    for (byte, pair) in hash.iter_mut().zip(text.as_bytes().chunks(2)) {
        *byte = digit(pair[0])? << 4 | digit(*pair.get(1)?)?;
    }
    Some(MeshHash(hash))
}
