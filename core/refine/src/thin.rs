//! Tetrahedra that may have tiny dihedral angles, listed as they are made, so that no look at the
//! whole mesh is needed in the end.

use ltbw_core::topology::{TetId, VertexId};

/// A tetrahedron that may have a tiny dihedral angle.
#[doc(hidden)]
pub type Thin = (TetId, [VertexId; 4]);

/// The number of tetrahedra that may be gone before it is worth a look.
const FEW: usize = if cfg!(test) { 4 } else { 1 << 12 };

/// A list in which tetrahedra are entered as they are made, when they are in the cache.
#[doc(hidden)]
#[derive(Debug, Default)]
pub struct ThinTets {
    /// All that are left, and others that are gone.
    pub tets: Vec<Thin>,
    /// The number of those that were left when it was looked at last.
    left: usize,
}

impl ThinTets {
    /// Forgets those that are gone if most may be; `is_left` says which are not.
    pub fn forget_old(&mut self, is_left: impl Fn(Thin) -> bool) {
        if self.tets.len() > 2 * self.left + FEW {
            self.tets.retain(|&own| is_left(own));
            self.left = self.tets.len();
        }
    }
}
