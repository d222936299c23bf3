//! Tetrahedra over their bounds, and the order in which they come, as far as a mesh tells it.
//!
//! Most are beaten round after round by the same one. It is remembered as a *witness*, and as long
//! as nothing on the way there has changed nothing is looked at.

use ltbw_core::topology::TetId;

/// A tetrahedron over its bounds, or one that was.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Bad {
    /// Its slot.
    pub(super) t: TetId,
    /// A tetrahedron that came before it at that look, after the neighbour on the way there, or `t`
    /// itself; `t` twice if none was found.
    pub(super) witness: [TetId; 2],
    /// The look at new tetrahedra up to which all this is so.
    pub(super) look: u32,
}

impl Bad {
    /// One that is new.
    pub(super) fn new(t: TetId, look: u32) -> Self {
        Self { t, witness: [t; 2], look }
    }

    /// Is its tetrahedron there, if its slot was written last at the look `stamp`?
    pub(super) fn is_there(&self, stamp: u32) -> bool {
        stamp <= self.look
    }
}

/// A mesh, or a part of one, whose tetrahedra over their bounds are sifted.
#[doc(hidden)]
pub trait Ranked {
    /// The slots around one.
    fn neighbours(&self, t: TetId) -> [TetId; 4];
    /// The slots around one beside a tetrahedron, which may be none here.
    fn around(&self, way: TetId) -> Option<[TetId; 4]>;
    /// Asks the processor to fetch a tetrahedron. A hint.
    fn prefetch(&self, t: TetId);
    /// Comes one of two tetrahedra with equal keys first?
    fn is_first_by_place(&self, one: TetId, other: TetId) -> bool;
    /// Do ties of the parts that keys hold count? Only a known-bad variant says no.
    #[inline(always)]
    fn breaks_ties(&self) -> bool {
        true
    }
}

/// The neighbour of `t` on the way, or `t`, and a tetrahedron that comes before `t`: one of its
/// neighbours, else one around one of these.
#[inline(always)]
pub(super) fn witness(
    t: TetId,
    neighbours: [TetId; 4],
    around: impl Fn(TetId) -> Option<[TetId; 4]>,
    is_before: impl Fn(&TetId) -> bool,
) -> Option<[TetId; 2]> {
    let beside = neighbours.into_iter().find(&is_before).map(|other| [t, other]);
    let beyond = |way: TetId| around(way)?.into_iter().find(&is_before).map(|other| [way, other]);
    beside.or_else(|| neighbours.into_iter().find_map(beyond))
}
