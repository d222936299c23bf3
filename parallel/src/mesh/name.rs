//! Names of vertices, the same at every worker.

use crate::protocol::WorkerId;

/// The name of a vertex: in the upper half its maker's number plus 1, or 0 if it was given; in the
/// lower half that one's counter, from 1 up. 0 is the vertex at infinity.
pub type VertexName = u64;

/// The place along the curve of a vertex that was given, from 1: its number in the whole mesh.
pub type Place = u32;

/// The vertex at infinity, among places.
pub(super) const NO_PLACE: Place = 0;

/// The vertex at infinity.
pub(super) const NOWHERE: VertexName = 0;

/// The name of the vertex that worker `by` makes as its `count`-th.
pub fn made(by: WorkerId, count: u32) -> VertexName {
    (u64::from(by.number()) + 1) << 32 | u64::from(count)
}

/// The place along the curve of a vertex that was given.
#[inline]
pub fn given(name: VertexName) -> Option<Place> {
    u32::try_from(name).ok().filter(|&rank| rank != NO_PLACE)
}

/// The counter of a vertex that worker `by` has made.
#[inline]
pub(super) fn made_by(by: WorkerId, name: VertexName) -> Option<u32> {
    u32::try_from(name.wrapping_sub(made(by, 0))).ok()
}

/// The worker that has made a vertex.
pub(super) fn maker_of(name: VertexName) -> Option<WorkerId> {
    let by = (name >> 32).checked_sub(1)?;
    u32::try_from(by).ok().map(WorkerId::new)
}

/// The lower half of a name: the counter.
pub(super) fn count_of(name: VertexName) -> u32 {
    name as u32
}
