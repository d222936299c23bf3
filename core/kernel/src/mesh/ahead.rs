//! Hints to the processor: what will be looked at soon.

use super::Mesh;
use crate::topology::{TetId, tet_of};

impl Mesh {
    /// Asks the processor to fetch tetrahedron `t` with its sphere. A hint.
    #[doc(hidden)]
    #[inline]
    pub fn prefetch(&self, t: TetId) {
        self.topology.prefetch(t);
        self.geometry.prefetch_sphere(t);
    }

    /// The same for the neighbours of tetrahedron `t`.
    #[doc(hidden)]
    #[inline]
    pub fn prefetch_around(&self, t: TetId) {
        for face in self.topology.at(t).neighbours() {
            self.prefetch(tet_of(face));
        }
    }
}
