//! Room for what is to come.

use super::Mesh;

/// A mesh has this many tetrahedra for each vertex, at least.
const TETS_PER_VERTEX: usize = 5;

impl Mesh {
    /// Takes memory for about this many tetrahedra, on huge pages where there are any: it is not
    /// written to before they come, and arrays do not move as they grow. A hint.
    #[doc(hidden)]
    pub fn expect_tets(&mut self, tets: usize) {
        self.topology.expect(tets);
        self.geometry.expect(tets / TETS_PER_VERTEX, tets);
    }
}
