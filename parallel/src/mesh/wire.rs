//! The values that submeshes send each other, with coordinates as bits.

use super::VertexName;
use crate::protocol::{BlockId, Handle, Name};
use ltbw_core::topology::TetId;
use ltbw_exact::Point;

/// A vertex with its coordinates, as bits: the protocol never sees a float.
///
/// Vertex 0 is the vertex at infinity; its coordinates mean nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WireVertex {
    /// Its name.
    pub name: VertexName,
    /// The bits of its kernel coordinates.
    #[cfg_attr(feature = "wire", serde(with = "crate::wire::bits"))]
    pub bits: [u64; 3],
}

impl WireVertex {
    /// Vertex `name` at `p`.
    pub fn new(name: impl Into<VertexName>, p: Point) -> Self {
        Self { name: name.into(), bits: p.map(f64::to_bits) }
    }

    /// Its kernel coordinates.
    #[inline]
    pub fn point(&self) -> Point {
        self.bits.map(f64::from_bits)
    }
}

/// The other side of a face of a part of a cavity, as its owner describes it to the home.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Link {
    /// A tetrahedron of the same owner, not in conflict.
    Near {
        /// Its local handle.
        tet: TetId,
        /// The slot there of the vertex opposite the common face.
        slot: u8,
        /// The block of the vertex there; `None` if that is at infinity, or if blocks do not tell
        /// the owners of tetrahedra.
        apex: Option<BlockId>,
        /// Its name, if it has one.
        name: Option<Name>,
    },
    /// A tetrahedron of another worker, in conflict or not.
    Far(Handle),
}

/// A face of a part of a cavity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Side {
    /// Its vertices, by their places among the piece's: with the point before them they are a
    /// positively oriented tetrahedron.
    pub v: [u32; 3],
    /// The other side.
    pub link: Link,
}

/// One owner's tetrahedra in conflict, as it describes them to the home.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Piece {
    /// Their local handles.
    pub tets: Vec<TetId>,
    /// The names of those that have one.
    pub names: Vec<Name>,
    /// Their vertices, each once.
    pub vertices: Vec<WireVertex>,
    /// Their faces, but those between two of them.
    pub sides: Vec<Side>,
}

impl AsRef<Self> for Piece {
    fn as_ref(&self) -> &Self {
        self
    }
}

/// The other side of a face of a new tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum To {
    /// To another new tetrahedron of the same patch: index and slot.
    New(u32, u8),
    /// To a tetrahedron that the owner has locked: local handle and slot.
    Old(TetId, u8),
    /// To a tetrahedron of another worker.
    Far(Handle),
}

/// A tetrahedron to be made.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NewTet {
    /// Its name, if another worker knows it.
    pub name: Option<Name>,
    /// Its vertices, positively oriented: by their places among the patch's.
    pub v: [u32; 4],
    /// Its block.
    pub block: BlockId,
    /// Its neighbours.
    pub n: [To; 4],
}

/// A tetrahedron of the ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum At {
    /// By its local handle.
    Tet(TetId),
    /// By its name.
    Named(Name),
}

/// A face of a ring tetrahedron that leads to another worker's new tetrahedron now.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Relink {
    /// The ring tetrahedron.
    pub at: At,
    /// The slot of the vertex opposite the face.
    pub slot: u8,
    /// The name that it has from now on, if it has none.
    pub name: Option<Name>,
    /// The new tetrahedron.
    pub to: Handle,
}

/// The changes that a filled cavity brings to one worker's submesh.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Patch {
    /// Tetrahedra of the cavity.
    pub remove: Vec<TetId>,
    /// The vertices of the new tetrahedra, each once: the inserted point first.
    pub vertices: Vec<WireVertex>,
    /// New tetrahedra; the inserted point is the first vertex of each.
    pub create: Vec<NewTet>,
    /// Faces of the ring.
    pub relink: Vec<Relink>,
}

/// The other side of a face of a tetrahedron that moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Lead {
    /// To another one that moves: index and slot.
    In(u32, u8),
    /// To one that does not.
    Far(Handle),
}

/// A tetrahedron that changes its owner.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Moving {
    /// Its name.
    pub name: Name,
    /// Its vertices, positively oriented.
    pub v: [WireVertex; 4],
    /// Its neighbours.
    pub n: [Lead; 4],
}
