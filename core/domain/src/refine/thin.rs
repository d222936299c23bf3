//! Tetrahedra that may have tiny dihedral angles, listed as they are made, so that no look at the
//! whole mesh is needed in the end.

use super::state::State;
use ltbw_core::topology::{TetId, VertexId};

/// A tetrahedron that may have a tiny dihedral angle.
pub(crate) type Thin = (TetId, [VertexId; 4]);

/// The number of tetrahedra that may be gone before it is worth a look.
const FEW: usize = if cfg!(test) { 4 } else { 1 << 12 };

/// A list in which tetrahedra are entered as they are made, when they are in the cache.
#[derive(Debug, Default)]
pub(crate) struct ThinTets {
    pub(crate) tets: Vec<Thin>,
    /// The number of those that were left when it was looked at last.
    left: usize,
}

impl ThinTets {
    /// Forgets those that are gone if most may be.
    pub(crate) fn forget_old(&mut self, state: &State) {
        if self.tets.len() > 2 * self.left + FEW {
            self.tets.retain(|&(t, v)| state.is_live(t, v));
            self.left = self.tets.len();
        }
    }
}
