//! The meaning of each kind of finding for a finite element mesh.

use crate::defect::{Kind, Level};

/// The meaning of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// The mesh is wrong.
    Defect,
    /// People may want to know it.
    Information,
    /// Another finding says it: an overlap, an inverted tetrahedron.
    Implied,
}

/// The meaning of a finding of this kind, if the mesh is asked to be Delaunay and convex, or not.
pub(crate) fn verdict(kind: Kind, delaunay: bool) -> Verdict {
    match kind {
        Kind::SameSide | Kind::FoldedFace => Verdict::Implied,
        _ if kind.level() == Level::Canonical => Verdict::Information,
        _ if !delaunay && (kind == Kind::NotDelaunay || Kind::SHAPE.contains(&kind)) => {
            Verdict::Information
        }
        _ => Verdict::Defect,
    }
}
