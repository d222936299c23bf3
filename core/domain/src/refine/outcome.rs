//! The outcome of a refinement.

use ltbw_core::topology::TetId;

/// Why something could not be split. Ids are those of the domain's complex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Reason {
    /// Two facets meet along this segment at a dihedral angle below the theory's limit.
    SmallDihedral {
        /// The corners of the segment: indices of input vertices.
        segment: [u32; 2],
    },
    /// Two segments, or a segment and a facet, meet at this corner at a small angle.
    SmallFaceAngle {
        /// Index of the input vertex.
        corner: u32,
    },
    /// This corner is so near to a facet that it is not on that tetrahedra between them would be
    /// flat or too many.
    NearFacet {
        /// Index of the input vertex.
        corner: u32,
    },
    /// The same of two segments.
    NearSegments {
        /// The corners of the one.
        first: [u32; 2],
        /// The corners of the other.
        second: [u32; 2],
    },
    /// Its point would take another item of the boundary out of the mesh, and the other's point
    /// this one, or so on in a circle.
    Interlocked,
    /// Splitting it would make an edge shorter than the floor.
    Floor,
    /// The budget was exhausted first.
    Budget,
    /// The work was cancelled first.
    Cancelled,
    /// No point of the lattice near the ideal one does what it has to.
    Rounding,
}

impl Reason {
    /// Is it a corner of the input: a small angle there, or a facet too near?
    pub fn is_corner(&self) -> bool {
        matches!(self, Self::SmallFaceAngle { .. } | Self::NearFacet { .. })
    }

    /// Is it a segment of the input: a small dihedral angle there, or another segment too near?
    pub fn is_segment(&self) -> bool {
        matches!(self, Self::SmallDihedral { .. } | Self::NearSegments { .. })
    }
}

impl std::fmt::Display for Reason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::SmallDihedral { segment: [a, b] } => write!(f, "small dihedral angle at {a}-{b}"),
            Self::SmallFaceAngle { corner } => write!(f, "small angle at vertex {corner}"),
            Self::NearFacet { corner } => write!(f, "vertex {corner} too near to a facet"),
            Self::NearSegments { first: [a, b], second: [c, d] } => {
                write!(f, "segments {a}-{b} and {c}-{d} too near to each other")
            }
            Self::Interlocked => write!(f, "boundary items that displace each other"),
            Self::Floor => write!(f, "floor of edge lengths"),
            Self::Budget => write!(f, "budget"),
            Self::Cancelled => write!(f, "cancelled"),
            Self::Rounding => write!(f, "rounding"),
        }
    }
}

/// A tetrahedron of the domain that is over a bound, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Excuse {
    /// The tetrahedron, by its id in [`super::Refined::mesh`].
    pub tet: TetId,
    /// Why it was not split.
    pub reason: Reason,
}

/// The outcome of a refinement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RefineOutcome {
    /// Every bound is met, exactly; the mesh conforms to the domain.
    Met,
    /// Some tetrahedra are over a bound, or some of the boundary is not in the mesh: each is listed
    /// with its reason.
    Excused,
    /// Some of the boundary could not be brought into the mesh of the domain's vertices: what is
    /// missing is listed with its reason. The mesh is Delaunay; no tetrahedron was split, there are
    /// no regions, and which tetrahedra are inside is not known.
    Unrecovered,
    /// The budget of points was used up first; the mesh is valid and Delaunay, but need not meet
    /// the bounds.
    Budget,
    /// The cancel token was set; the mesh is valid and Delaunay, but need not meet the bounds.
    Cancelled,
}

/// Figures of a refinement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RefineStats {
    /// Points inserted on segments.
    pub segment_points: u64,
    /// Points inserted on facets.
    pub facet_points: u64,
    /// Points inserted inside.
    pub free_points: u64,
    /// Proposed points that were given up for a boundary item.
    pub deferred: u64,
    /// Items refused.
    pub refused: u64,
    /// Rounds that inserted points; 0 without rounds.
    pub rounds: u64,
    /// Rounds that inserted points on segments, on facets, and inside: some did several of these.
    pub rounds_with: [u64; 3],
    /// Cavities opened whole to choose the points of the rounds.
    pub searches: u64,
    /// Cavities given up on the way, at the cavity of another point.
    pub barred: u64,
    /// Points of the widest round.
    pub widest: u64,
    /// Points inserted by rounds.
    pub round_points: u64,
    /// Threads that chose the points of the rounds; 0 without rounds.
    pub round_threads: usize,
    /// Phases in which items that wait for each other in a circle were split jointly.
    pub joint_phases: u64,
    /// The distance within which facets were taken for coplanar: as asked for, or 0.
    pub flat_tolerance: f64,
    /// Sets of facets that are coplanar within it, but not exactly.
    pub patches: usize,
    /// Places where such a set ends although facets beyond are coplanar with it, since it would
    /// fold over itself in its projection.
    pub patches_folded: usize,
    /// Such sets that could not be brought into the mesh, so that all facets are what they are.
    pub patches_given_up: usize,
    /// Seconds for the first mesh and the recovery of the boundary.
    pub recover_seconds: f64,
    /// Seconds before the first round, one item after the other.
    pub start_seconds: f64,
    /// Seconds for the splitting of tetrahedra.
    pub refine_seconds: f64,
}
