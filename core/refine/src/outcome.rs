//! The outcome of a refinement.

use ltbw_core::topology::TetId;
use ltbw_domain::quality::LeastAngles;
use ltbw_exact::Point;
use ltbw_exact::points::{ascending, of_ascending};

/// A place, in the coordinates of the mesh, where something that the refinement has made could not
/// be split. Places are in the order of x, y, z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Spot([u64; 3]);

impl Spot {
    /// The spot at a point.
    pub fn new(p: Point) -> Self {
        Self(ascending(&p))
    }

    /// The point.
    pub fn point(self) -> Point {
        of_ascending(self.0)
    }
}

impl std::fmt::Display for Spot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.point();
        write!(f, "({x}, {y}, {z})")
    }
}

/// Why something could not be split. Ids are those of the domain's complex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    /// Two segments so near to each other that tetrahedra between them would be flat or too many.
    NearSegments {
        /// The corners of the one.
        first: [u32; 2],
        /// The corners of the other.
        second: [u32; 2],
    },
    /// The point of the boundary item here would take another one out of the mesh, and the other's
    /// point this one, or so on in a circle; and they could not be split together.
    Interlocked {
        /// The middle of the item.
        at: Spot,
    },
    /// No point of the lattice near the ideal one splits the boundary item here.
    Unserved {
        /// The middle of the item.
        at: Spot,
    },
    /// Splitting it would make an edge shorter than the floor.
    Floor,
    /// The budget was exhausted first.
    Budget,
    /// The work was cancelled first.
    Cancelled,
    /// No point of the lattice near the ideal one splits the tetrahedron itself. It is never the
    /// reason of what waits for something that was refused: that has the same reason as this.
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

    /// The place of the boundary item that it is about, if it is about one that was made: in the
    /// coordinates of the mesh.
    pub fn at(&self) -> Option<Point> {
        match self {
            Self::Interlocked { at } | Self::Unserved { at } => Some(at.point()),
            _ => None,
        }
    }

    /// Is it only that no point was found?
    pub(crate) fn is_vague(&self) -> bool {
        matches!(self, Self::Rounding | Self::Unserved { .. })
    }

    /// The reason of what follows from a refusal for the reason `root`, if nothing else says more
    /// than this one.
    pub(crate) fn after(self, root: Self) -> Self {
        if root.is_vague() && self != Self::Rounding { self } else { root }
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
            Self::Interlocked { at } => {
                write!(f, "boundary items that displace each other at {at}")
            }
            Self::Unserved { at } => write!(f, "no point for the boundary item at {at}"),
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
    /// The tetrahedron, by its id in [`crate::Refined::mesh`].
    pub tet: TetId,
    /// Why it was not split.
    pub reason: Reason,
}

/// A tetrahedron of the domain with a dihedral angle below the bound that no point divides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sliver {
    /// The tetrahedron, by its id in [`crate::Refined::mesh`].
    pub tet: TetId,
    /// Its smallest dihedral angle in degrees, rounded.
    pub angle: f64,
    /// A small angle of the domain at one of its corners, which asks for such.
    pub near: Option<Reason>,
}

impl Sliver {
    /// Degrees below which a dihedral angle makes a mesh useless, whatever is excused.
    pub const FLAT: f64 = 0.1;
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
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    /// Cavities found to choose the points of the rounds.
    pub searches: u64,
    /// Points on the boundary that waited as another one of their round was in their way.
    pub barred: u64,
    /// Points of the widest round.
    pub widest: u64,
    /// Points inserted by rounds.
    pub round_points: u64,
    /// Moves of vertices inside, by smoothing.
    pub moved: u64,
    /// Threads that chose the points of the rounds; 0 without rounds.
    pub round_threads: usize,
    /// Phases in which items that wait for each other in a circle were split jointly.
    pub joint_phases: u64,
    /// The degrees below which dihedral angles make slivers; 0 if none do.
    pub min_dihedral: f64,
    /// The tetrahedra of the domain by their smallest dihedral angle when all other bounds were met
    /// and slivers were looked for first, if [`count_angles`](crate::Refiner::count_angles) asked
    /// for it. In the end they are those of [`ltbw_domain::quality::Quality::least_angles`].
    pub before_slivers: Option<LeastAngles>,
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

#[cfg(test)]
mod tests {
    use super::{Reason, Spot};

    #[test]
    fn spots_are_in_the_order_of_their_points() {
        let all = [f64::NEG_INFINITY, -3.0, -5e-324, 0.0, 1e-300, 0.5, 1.0, f64::MAX];
        for (k, &x) in all.iter().enumerate() {
            assert_eq!(Spot::new([x, -x, 1.0]).point(), [x, 0.0 - x, 1.0]);
            for &y in &all[k + 1..] {
                assert!(Spot::new([x; 3]) < Spot::new([y, x, x]), "{x} {y}");
                assert!(Spot::new([1.0, 2.0, x]) < Spot::new([1.0, 2.0, y]), "{x} {y}");
            }
        }
        assert_eq!(Spot::new([-0.0; 3]), Spot::new([0.0; 3]));
    }

    #[test]
    fn what_follows_from_a_refusal_has_its_reason() {
        let at = |x: f64| Spot::new([x, 0.25, -1.0]);
        let (unserved, locked) =
            (Reason::Unserved { at: at(1.0) }, Reason::Interlocked { at: at(2.0) });
        let named = Reason::SmallFaceAngle { corner: 3 };
        assert_eq!(Reason::Rounding.after(unserved), unserved);
        assert_eq!(Reason::Rounding.after(locked), locked);
        assert_eq!(named.after(unserved), named);
        assert_eq!(named.after(locked), locked);
        assert_eq!(unserved.after(Reason::Unserved { at: at(7.0) }), unserved);
        assert_eq!(locked.at(), Some([2.0, 0.25, -1.0]));
        let text = "boundary items that displace each other at (2, 0.25, -1)";
        assert_eq!(locked.to_string(), text);
    }
}
