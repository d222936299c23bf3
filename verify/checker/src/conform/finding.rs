//! The bounds that a mesh of a domain is held to, and the findings: breaches with their places.

use super::Fraction;
use crate::Defect;
use crate::angles::SmallAngles;
use serde::Serialize;
use std::collections::BTreeMap;

/// The bounds that every tetrahedron has to meet.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Limits {
    /// The largest circumradius to shortest edge.
    pub radius_edge: Option<f64>,
    /// The largest volume.
    pub max_volume: Option<f64>,
    /// The largest length of an edge.
    pub max_edge: Option<f64>,
    /// The largest volume in each region of the domain, by the tag that its seed is found with.
    pub region_volumes: Vec<Option<f64>>,
    /// The least dihedral angle in degrees, above 0 and at most 90. Tetrahedra with a smaller one
    /// are counted ([`Conformity::below_dihedral`]), and are no breach.
    pub min_dihedral: Option<f64>,
}

/// The kinds of breaches. Ids are those of the domain or of the mesh, as each kind says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ConformityDefect {
    /// Coordinates of mesh and domain have no common unit of 60 bits: nothing was tested.
    TooFine,
    /// A vertex of the domain is not in the mesh. `ids`: the vertex of the domain.
    VertexMissing,
    /// An edge of a facet, or a segment, is no chain of edges of the mesh. `ids`: its two vertices
    /// of the domain.
    SegmentBroken,
    /// A facet's corners are collinear. `ids`: the facet.
    FacetDegenerate,
    /// The faces of the mesh do not tile the facets of one plane. `ids`: the first of these.
    FacetNotTiled,
    /// A face on a patch turns over in the projection, against most of the others. `ids`: a
    /// tetrahedron, and the face's vertices.
    PatchFolded,
    /// A face of one tetrahedron is on no facet. `ids`: the tetrahedron, and the face's vertices.
    HullFaceOffFacet,
    /// Two tetrahedra that no facet separates have different tags. `ids`: both.
    TagsDiffer,
    /// The tag of a tetrahedron is not the number that the seeds of the regions give it, though
    /// they are to give it one. `ids`: the tetrahedron.
    TagNotOfSeed,
    /// A tetrahedron holds the point of a hole. `ids`: the hole, the tetrahedron.
    HoleMeshed,
    /// No tetrahedron holds the seed of a region. `ids`: the region.
    RegionNotMeshed,
    /// Circumradius to shortest edge exceeds its bound. `ids`: the tetrahedron.
    RatioExceeded,
    /// The volume exceeds its bound. `ids`: the tetrahedron.
    VolumeExceeded,
    /// An edge exceeds its bound. `ids`: the tetrahedron.
    EdgeExceeded,
}

impl ConformityDefect {
    /// All of them, in order.
    pub(crate) const EVERY: [Self; 14] = [
        Self::TooFine,
        Self::VertexMissing,
        Self::SegmentBroken,
        Self::FacetDegenerate,
        Self::FacetNotTiled,
        Self::PatchFolded,
        Self::HullFaceOffFacet,
        Self::TagsDiffer,
        Self::TagNotOfSeed,
        Self::HoleMeshed,
        Self::RegionNotMeshed,
        Self::RatioExceeded,
        Self::VolumeExceeded,
        Self::EdgeExceeded,
    ];

    /// The breach in words, for people.
    pub fn text(self) -> &'static str {
        match self {
            Self::TooFine => "the coordinates have no common unit of 60 bits",
            Self::VertexMissing => "this vertex of the domain is not in the mesh",
            Self::SegmentBroken => "this edge of the domain is no chain of edges of the mesh",
            Self::FacetDegenerate => "the corners of this facet are collinear",
            Self::FacetNotTiled => "the faces of the mesh do not tile this facet",
            Self::PatchFolded => "this face turns over in the projection of its patch",
            Self::HullFaceOffFacet => "this face of one tetrahedron is on no facet",
            Self::TagsDiffer => "no facet separates them, but their tags differ",
            Self::TagNotOfSeed => "the tag is not the number of the region whose seed is there",
            Self::HoleMeshed => "this hole's point is in this tetrahedron",
            Self::RegionNotMeshed => "no tetrahedron holds the seed of this region",
            Self::RatioExceeded => "circumradius to shortest edge is above the bound",
            Self::VolumeExceeded => "the volume is above the bound",
            Self::EdgeExceeded => "an edge is longer than the bound",
        }
    }
}

/// One breach.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// The kind of breach.
    pub breach: ConformityDefect,
    /// The place: see [`ConformityDefect`].
    pub ids: Vec<u32>,
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}: {} (ids {:?})", self.breach, self.breach.text(), self.ids)
    }
}

/// The findings of [`super::conforms`].
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Conformity {
    /// Defects of the mesh itself: structure, orientation, Delaunay.
    pub mesh_defects: Vec<Defect>,
    /// Breaches, at most `max_defects` of each kind.
    pub findings: Vec<Finding>,
    /// All of them, listed or not.
    pub counts: BTreeMap<ConformityDefect, u64>,
    /// Number of defects of the mesh, listed or not.
    pub mesh_defect_count: u64,
    /// Faces of the mesh that lie on facets.
    pub subfaces: u64,
    /// Tetrahedra tested against the bounds.
    pub tets: u64,
    /// Components of the mesh between the facets.
    pub cells: u64,
    /// In-sphere and orientation tests that a filter decided, and those that were exact.
    pub tests: (u64, u64),
    /// Sets of facets that are coplanar within the tolerance, but not exactly.
    pub patches: u64,
    /// Number of parts in which the mesh was checked, if it was so.
    pub parts: Option<u64>,
    /// The volume is that of the domain within this much, by its patches.
    pub volume_within: f64,
    /// Steps of the searches on facets and edges: a measure of their cost that does not
    /// depend on the machine.
    #[doc(hidden)]
    pub steps: u64,
    /// The tetrahedra below the least dihedral angle, if there is such a limit; those between
    /// the triangles of one patch, too, which are in no other bound.
    pub below_dihedral: Option<SmallAngles>,
    /// The exact volume; `None` if coordinates are too fine.
    pub volume: Option<Fraction>,
}

impl Conformity {
    /// Is nothing wrong?
    pub fn passed(&self) -> bool {
        self.mesh_defect_count == 0 && self.counts.is_empty()
    }

    /// Number of breaches of a kind.
    pub fn count(&self, breach: ConformityDefect) -> u64 {
        self.counts.get(&breach).copied().unwrap_or(0)
    }
}
