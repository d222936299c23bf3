//! A mesh to be stored and restored.
//!
//! The Delaunay mesh is one function of its points ([`ltbw_exact::predicates::perturb`]), so a
//! snapshot holds the points and the mesh's hash, and restoring one builds the mesh anew and
//! compares: a snapshot that was corrupted, or made by a kernel that computes another mesh, is
//! refused, and a restored mesh is as correct as any other. Coordinates are stored as the bits of
//! their `f64`, so that they survive every format.
//!
//! A count is a claim: a snapshot of few vertices whose `next` is huge would make arrays that are
//! indexed by number ([`Mesh::to_tet_mesh`]) huge. So [`Snapshot::restore`], and with it `serde`,
//! takes numbers up to 2^20 or 64 times those of vertices and duplicates, whichever is more.
//! Only a build that was cut short leaves more; [`Snapshot::restore_within`] restores it.
//!
//! Kept are vertices, numbers, duplicates, the number that the next inserted point gets; not kept
//! are [`crate::topology::TetId`]s, counters, the [`ltbw_exact::Mode`] (it is the best one
//! for the points).

use crate::build::{BuildError, Builder};
use crate::hash::{HashError, MeshHash};
use crate::mesh::{Duplicate, Mesh, Vertex};
use ltbw_exact::Point;
use ltbw_exact::points::{MAX_POINTS, PointError, PointSet};

/// The format that this version reads and writes.
pub const SCHEMA: &str = "ltbw.snapshot/1";

/// Numbers that every snapshot may have...
const NUMBERS: usize = 1 << 20;

/// ... and those that it may have for each vertex and duplicate.
const NUMBERS_PER_POINT: usize = 64;

/// A vertex of a snapshot: its number and the bits of its coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StoredVertex {
    /// Its public number.
    pub number: Vertex,
    /// [`f64::to_bits`] of x, y and z.
    pub bits: [u64; 3],
}

/// A mesh to be stored ([module](self)).
///
/// ```
/// # use ltbw_core::Builder;
/// # use ltbw_exact::PointSet;
/// # let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
/// # let mesh = Builder::new().build(&PointSet::new(cube)?)?.mesh;
/// let mut snapshot = mesh.snapshot()?;
/// assert_eq!(snapshot.restore()?.hash()?, mesh.hash()?);
/// snapshot.vertices[3].bits[0] ^= 1;
/// assert!(snapshot.restore().is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Snapshot {
    /// [`SCHEMA`].
    pub schema: String,
    /// The vertices, by number ascending.
    pub vertices: Vec<StoredVertex>,
    /// The duplicates, ascending.
    pub duplicates: Vec<Duplicate>,
    /// The number that the next inserted point gets.
    pub next: Vertex,
    /// The canonical hash of the mesh.
    pub hash: MeshHash,
}

/// Why a snapshot is no mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// It is of another format.
    #[error("the schema is `{found}`, not `{SCHEMA}`")]
    Schema {
        /// The schema found.
        found: String,
    },
    /// A coordinate is not finite; the index is that of the stored vertex.
    #[error(transparent)]
    Point(#[from] PointError),
    /// The numbers of the vertices do not ascend, or reach the next number.
    #[error("stored vertex {index} has the number {number}, out of order or not below {next}")]
    Number {
        /// Place of the vertex in the list.
        index: usize,
        /// Its number.
        number: Vertex,
        /// The number that the next inserted point gets.
        next: Vertex,
    },
    /// The next number is above the limit.
    #[error("the next number {next} exceeds the limit of {limit}")]
    Next {
        /// The number that the next inserted point gets.
        next: Vertex,
        /// The limit.
        limit: usize,
    },
    /// A duplicate is out of order, or a vertex too, or does not follow a vertex.
    #[error("entry {index}: {duplicate} is not a duplicate of the vertex {kept}")]
    Duplicate {
        /// Place in the list of duplicates.
        index: usize,
        /// Number of the duplicate.
        duplicate: Vertex,
        /// Number of the vertex at its place.
        kept: Vertex,
    },
    /// Two vertices have equal coordinates.
    #[error("the vertices {first} and {second} lie at the same place")]
    SamePlace {
        /// The smaller number.
        first: Vertex,
        /// The larger number.
        second: Vertex,
    },
    /// The vertices have no mesh.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The mesh has no hash.
    #[error(transparent)]
    Hash(#[from] HashError),
    /// The mesh of the stored vertices is not the one that was stored.
    #[error("the mesh of the stored vertices has the hash {found}, not {stored}")]
    OtherMesh {
        /// The hash stored.
        stored: MeshHash,
        /// The hash of the mesh built.
        found: MeshHash,
    },
}

impl Mesh {
    /// The mesh as it can be stored ([`crate::snapshot`]).
    ///
    /// Cost: that of the hash; 32 bytes per vertex.
    ///
    /// # Errors
    /// None for a mesh that the kernel built: the hash's are passed on.
    pub fn snapshot(&self) -> Result<Snapshot, HashError> {
        let store =
            |(number, p): (Vertex, Point)| StoredVertex { number, bits: p.map(f64::to_bits) };
        let mut vertices: Vec<StoredVertex> = self.vertices().map(store).collect();
        vertices.sort_unstable_by_key(|v| v.number);
        Ok(Snapshot {
            schema: SCHEMA.to_owned(),
            vertices,
            duplicates: self.duplicates.clone(),
            next: self.next_number,
            hash: self.hash()?,
        })
    }
}

impl Snapshot {
    /// The mesh, built anew and compared with the stored hash.
    ///
    /// Cost: that of building the mesh.
    ///
    /// # Errors
    /// [`SnapshotError`] says what is wrong with a snapshot that no mesh has, or that has a
    /// [`next`](Self::next) out of proportion ([module](self)).
    pub fn restore(&self) -> Result<Mesh, SnapshotError> {
        let used = self.vertices.len() + self.duplicates.len();
        self.restore_within(used.saturating_mul(NUMBERS_PER_POINT).max(NUMBERS))
    }

    /// As [`Snapshot::restore`], for a [`next`](Self::next) of up to `limit` (and 2^28): for the
    /// mesh of a build that was cut short early, from a source that is trusted.
    ///
    /// Cost: as that of [`Snapshot::restore`]; later, [`Mesh::to_tet_mesh`] needs 24 bytes for
    /// each number.
    ///
    /// # Errors
    /// As those of [`Snapshot::restore`].
    pub fn restore_within(&self, limit: usize) -> Result<Mesh, SnapshotError> {
        if self.schema != SCHEMA {
            return Err(SnapshotError::Schema { found: self.schema.clone() });
        }
        self.check_numbers(limit.min(MAX_POINTS))?;
        let points = self.vertices.iter().map(|v| v.bits.map(f64::from_bits)).collect();
        let built = Builder::new().build(&PointSet::new(points)?)?;
        let number = |index: Vertex| self.vertices[index as usize].number;
        if let Some(duplicate) = built.duplicates.first() {
            let (first, second) = (number(duplicate.kept), number(duplicate.number));
            return Err(SnapshotError::SamePlace { first, second });
        }
        let mut mesh = built.mesh;
        for v in mesh.numbers.iter_mut().skip(1) {
            *v = number(*v);
        }
        mesh.duplicates.clone_from(&self.duplicates);
        mesh.next_number = self.next;
        mesh.renumbered();
        let found = mesh.hash()?;
        if found != self.hash {
            return Err(SnapshotError::OtherMesh { stored: self.hash, found });
        }
        Ok(mesh)
    }

    fn check_numbers(&self, limit: usize) -> Result<(), SnapshotError> {
        let next = self.next;
        if next as usize > limit {
            return Err(SnapshotError::Next { next, limit });
        }
        let mut least = 0;
        for (index, v) in self.vertices.iter().enumerate() {
            let number = v.number;
            if number < least || number >= next {
                return Err(SnapshotError::Number { index, number, next });
            }
            least = number + 1;
        }
        let is_vertex = |n: Vertex| self.vertices.binary_search_by_key(&n, |v| v.number).is_ok();
        let mut least = 0;
        for (index, &Duplicate { number: duplicate, kept }) in self.duplicates.iter().enumerate() {
            let ordered = duplicate >= least && duplicate < next && kept < duplicate;
            if !ordered || is_vertex(duplicate) || !is_vertex(kept) {
                return Err(SnapshotError::Duplicate { index, duplicate, kept });
            }
            least = duplicate + 1;
        }
        Ok(())
    }
}
