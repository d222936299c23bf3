//! A window: the mesh of a part of the vertices, of whose tetrahedra some are those of the whole
//! mesh. The others fill the room between these, and nobody may look at them.
//!
//! A tetrahedron of the whole mesh with all its corners among the vertices is in the window, too,
//! for no vertex is in conflict with it. If nothing of a point's closure in the window is filling,
//! that is its closure in the whole mesh: what is in conflict is connected.

use ltbw_core::topology::TetId;
use ltbw_exact::Point;

/// The knowledge that a state has of itself if it is a window.
#[derive(Debug, Default)]
pub(crate) struct Window {
    /// By slot at the beginning: is what it has filling?
    pub(crate) is_filling: Vec<bool>,
    /// The number of vertices of the whole mesh that it has not.
    pub(crate) elsewhere: usize,
    /// Vertices of a closure that has filling.
    pub(crate) missed: Vec<Point>,
}

impl Window {
    /// Is a tetrahedron filling? None that is made in the window is.
    pub(crate) fn has_filling(&self, t: TetId) -> bool {
        self.is_filling.get(t.index()).is_some_and(|is| *is)
    }
}
