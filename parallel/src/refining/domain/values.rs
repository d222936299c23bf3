//! The values that workers send each other about a domain: those of the mesh, and what the boundary
//! adds.

use crate::mesh::{Moving, Patch, Piece, VertexName, WireVertex};
use crate::protocol::WorkerId;
use crate::refining::news::{Bits, bits};
use ltbw_core::topology::TetId;
use ltbw_exact::Point;
use ltbw_refine::{Carrier, Relabelled};
use smallvec::SmallVec;

/// A boundary item by the names of its vertices, ascending, those of a segment after a 0; for a
/// tetrahedron all are 0.
pub(super) type ItemKey = [VertexName; 3];

/// The key of a subsegment.
pub(super) fn segment_key([a, b]: [VertexName; 2]) -> ItemKey {
    if a < b { [0, a, b] } else { [0, b, a] }
}

/// The key of a subface.
pub(super) fn subface_key(mut corners: [VertexName; 3]) -> ItemKey {
    corners.sort_unstable();
    corners
}

/// A point that is to split something.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct DomainPoint {
    pub(super) vertex: WireVertex,
    pub(super) carrier: Carrier,
    /// The boundary item that it is to split.
    pub(super) item: ItemKey,
    /// The tetrahedron at its home where its operation begins.
    pub(super) seed: TetId,
    /// May it be inserted? Else it only finds what is in the way.
    pub(super) may: bool,
    /// The verdict has fallen: it is inserted whatever is in its cavity.
    pub(super) is_chosen: bool,
    /// The walls of its cavity whose tetrahedra do not inherit their region, and the region that
    /// they get: where it changes a patch.
    pub(super) labels: Box<[WallRegion]>,
}

/// A wall of a cavity, by the coordinates of its corners, and the region that its new tetrahedron
/// gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct WallRegion {
    wall: [Bits; 3],
    region: u32,
}

impl WallRegion {
    pub(crate) fn of(own: &Relabelled) -> Self {
        Self { wall: wall_key(&own.corners), region: own.region }
    }
}

/// A face by the coordinates of its corners, in any order.
fn wall_key(corners: &[Point; 3]) -> [Bits; 3] {
    let mut key = corners.map(|p| bits(&p));
    key.sort_unstable();
    key
}

impl DomainPoint {
    /// A point that is to be inserted in any case, from tetrahedron `seed` on if that stands.
    pub(crate) fn chosen(vertex: WireVertex, carrier: Carrier, seed: TetId) -> Self {
        let (item, labels) = ([0; 3], Box::default());
        Self { vertex, carrier, item, seed, may: true, is_chosen: true, labels }
    }

    /// The point, with the regions that tetrahedra at some walls get.
    pub(crate) fn with_labels(self, labels: Box<[WallRegion]>) -> Self {
        Self { labels, ..self }
    }

    /// The region that the new tetrahedron at a wall gets, if it does not inherit it.
    pub(super) fn label(&self, corners: &[Point; 3]) -> Option<u32> {
        let key = wall_key(corners);
        self.labels.iter().find(|own| own.wall == key).map(|own| own.region)
    }

    /// The name of the vertex that it becomes.
    pub(crate) fn name(&self) -> VertexName {
        self.vertex.name
    }
}

/// A vertex on the boundary, and its carrier.
pub(super) type BoundVertex = (VertexName, Carrier);

/// Regions, of which there is nearly always one.
pub(super) type Regions = SmallVec<[u32; 1]>;

/// A tetrahedron in conflict at which something may be boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct NearTet {
    /// Its vertices, positively oriented, by their places among the piece's; the one at infinity is
    /// [`NOWHERE`](ltbw_refine::NOWHERE).
    pub(super) v: [u32; 4],
    /// The tetrahedron, at its owner.
    pub(super) tet: TetId,
}

/// A boundary item that goes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Asked {
    pub(super) key: ItemKey,
    /// Its segment or facet.
    pub(super) of: u32,
    /// A tetrahedron at it, of the worker that is asked.
    pub(super) tet: TetId,
    /// The worker that is to hear of its end.
    pub(super) waiter: Option<WorkerId>,
    /// The boundary item that waits for it, if one does.
    pub(super) by: Option<ItemKey>,
}

/// One owner's tetrahedra in conflict, with the boundary.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct DomainPiece {
    pub(super) piece: Piece,
    /// Its vertices on the boundary.
    pub(super) bound: Vec<BoundVertex>,
    /// The regions of the tetrahedra at its sides; one if all are equal.
    pub(super) regions: Regions,
    /// Its tetrahedra at which something may be boundary.
    pub(super) near: Vec<NearTet>,
    /// The boundary items at these that cannot be split, as this owner knows.
    pub(super) refused: Vec<ItemKey>,
}

impl AsRef<Piece> for DomainPiece {
    fn as_ref(&self) -> &Piece {
        &self.piece
    }
}

/// Tetrahedra of a block that moves.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct DomainCargo {
    pub(super) tets: Vec<Moving>,
    /// Their vertices on the boundary.
    pub(super) bound: Vec<BoundVertex>,
    /// Their regions.
    pub(super) regions: Vec<u32>,
}

/// The end of an operation whose closure was locked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum End {
    /// The point is a vertex.
    Inserted,
    /// The point does not do what it was made for; another one may.
    Useless,
    /// A boundary item goes first. Is it this worker that splits it?
    Behind(ItemKey, bool),
    /// A boundary item is in the way that cannot be split, or is left to the engine.
    Barred,
}

/// The changes of one worker's submesh, or a boundary item of its that goes first.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct DomainPatch {
    pub(super) patch: Patch,
    /// Its vertices on the boundary.
    pub(super) bound: Vec<BoundVertex>,
    /// The regions of its new tetrahedra; one if all are equal.
    pub(super) regions: Regions,
    /// The boundary item of its list that goes first.
    pub(super) first: Option<Asked>,
    /// The end of the operation, for its home.
    pub(super) end: Option<End>,
}

/// Bytes of the carriers of some vertices, of which these are on the boundary: the others tell that
/// they are free.
pub(super) fn carriers_bytes(vertices: usize, bound: &[BoundVertex]) -> u64 {
    let bytes = |own: &BoundVertex| match own.1 {
        Carrier::Free => 0,
        Carrier::Corner(_) | Carrier::Facet(_) => 4,
        Carrier::Segment(..) => 8,
    };
    vertices as u64 + bound.iter().map(bytes).sum::<u64>()
}

/// Bytes of the indices of a boundary item's vertices in a message.
pub(super) const KEY: u64 = 3 * 2;
/// Bytes of a boundary item that goes first: with its segment or facet, tetrahedron, and waiter or
/// item that waits.
pub(super) const ASKED: u64 = KEY + 4 + 4 + KEY;
/// Bytes of a tetrahedron at which something may be boundary: five indices.
pub(super) const NEAR: u64 = 4 * 2 + 2;
