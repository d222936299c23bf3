//! Which of the tetrahedra over their bounds come before all around them: the same for an engine
//! with one mesh and for workers with parts of one.
//!
//! Most are beaten round after round by the same one. It is remembered as a *witness*, and as long
//! as nothing on the way there has changed nothing is looked at.

use ltbw_core::topology::TetId;

/// A tetrahedron over its bounds, or one that was.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Bad {
    /// Its slot.
    pub t: TetId,
    /// A tetrahedron that came before it at that look, after the neighbour on the way there, or `t`
    /// itself; `t` twice if none was found.
    pub witness: [TetId; 2],
    /// The look at new tetrahedra up to which all this is so.
    look: u32,
}

impl Bad {
    /// One that is new.
    pub fn new(t: TetId, look: u32) -> Self {
        Self { t, witness: [t; 2], look }
    }
}

/// A mesh whose tetrahedra over their bounds are sifted.
#[doc(hidden)]
pub trait Ranked {
    /// The look at which a slot was written last.
    fn stamp(&self, t: TetId) -> u32;
    /// The slots around one.
    fn neighbours(&self, t: TetId) -> [TetId; 4];
    /// Asks the processor to fetch a tetrahedron, and what it is ranked by.
    fn prefetch(&self, t: TetId);
    /// A witness for a tetrahedron, if one is found.
    fn one_before(&self, t: TetId) -> Option<[TetId; 2]>;
}

/// Tetrahedra over their bounds whose entries are looked at together, before what they point at.
const BLOCK: usize = 32;

/// Moves those of some tetrahedra that are still there at this look to the front, and tells those
/// for which there is no witness. Returns the number of those that are there.
#[doc(hidden)]
#[inline]
pub fn sift(
    bad: &mut [Bad],
    look: u32,
    mesh: &impl Ranked,
    mut foremost: impl FnMut(TetId),
) -> usize {
    let mut kept = 0;
    let changed = |own: &Bad, t: TetId| u32::from(mesh.stamp(t) > own.look);
    for first in (0..bad.len()).step_by(BLOCK) {
        let block = first..bad.len().min(first + BLOCK);
        // No branch waits for an entry: they are fetched side by side. 0: what came before it is
        // where it was; 1: it has to be looked for; 2 or 3: the tetrahedron is gone.
        let mut news = [0u32; BLOCK];
        for (own, new) in bad[block.clone()].iter().zip(&mut news) {
            let [way, other] = own.witness;
            let is_alone = u32::from(other == own.t);
            *new = changed(own, own.t) << 1 | changed(own, way) | changed(own, other) | is_alone;
        }
        let of = |new: u32| block.clone().zip(news).filter(move |own| own.1 == new);
        of(1).for_each(|(k, _)| mesh.prefetch(bad[k].t));
        for (k, _) in of(1) {
            mesh.neighbours(bad[k].t).into_iter().for_each(|t| mesh.prefetch(t));
        }
        for (k, new) in block.zip(news).filter(|own| own.1 <= 1) {
            let mut own = bad[k];
            if new == 1 {
                match mesh.one_before(own.t) {
                    Some(witness) => own = Bad { witness, look, ..own },
                    None => foremost(own.t),
                }
            }
            bad[kept] = own;
            kept += 1;
        }
    }
    kept
}

/// The neighbour of `t` on the way, or `t`, and a tetrahedron that comes before `t`: one of its
/// neighbours, else one around one of these.
#[doc(hidden)]
#[inline(always)]
pub fn witness(
    t: TetId,
    neighbours: [TetId; 4],
    around: impl Fn(TetId) -> Option<[TetId; 4]>,
    is_before: impl Fn(&TetId) -> bool,
) -> Option<[TetId; 2]> {
    let beside = neighbours.into_iter().find(&is_before).map(|other| [t, other]);
    let beyond = |way: TetId| around(way)?.into_iter().find(&is_before).map(|other| [way, other]);
    beside.or_else(|| neighbours.into_iter().find_map(beyond))
}
