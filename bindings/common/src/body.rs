//! A mesh of points or of a domain, and the tetrahedra of it that the caller sees.

use ltbw::refine::Refined;
use ltbw::topology::TetId;
use ltbw::{Mesh, PointSet};

/// The place of a tetrahedron that is not there: -1, read as an i32.
pub const NOWHERE: u32 = u32::MAX;

/// A mesh of a point set or of a domain.
pub(crate) enum Body {
    Points { mesh: Box<Mesh>, set: PointSet },
    Domain(Box<Refined>),
}

impl Body {
    pub(crate) fn mesh(&self) -> &Mesh {
        match self {
            Self::Points { mesh, .. } => mesh,
            Self::Domain(refined) => refined.mesh(),
        }
    }

    /// The tetrahedra that the caller sees, in its order.
    pub(crate) fn ids(&self) -> Vec<TetId> {
        match self {
            Self::Points { mesh, .. } => mesh.tet_ids().collect(),
            Self::Domain(refined) => refined.tets().collect(),
        }
    }

    /// Places of tetrahedra in that order.
    pub(crate) fn places(&self) -> Vec<u32> {
        let mut place = vec![NOWHERE; self.mesh().topology().slots()];
        for (k, &t) in (0..).zip(&self.ids()) {
            place[t.index()] = k;
        }
        place
    }
}
