//! Demands on the mesh of a domain.

use ltbw::Point;
use ltbw::domain::{Frame, Holes, Region};

/// Short edges near a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// The place, in the coordinates of the input.
    pub at: Point,
    /// The length.
    pub length: f64,
    /// The radius.
    pub radius: f64,
}

/// Short edges at a part of the boundary.
#[derive(Clone, Debug, PartialEq)]
pub struct SizeAt {
    /// The marker, or the name.
    pub part: String,
    /// The length.
    pub length: f64,
}

/// Bounds and options.
#[derive(Clone, Debug, Default)]
pub struct Wishes {
    /// The largest volume of a tetrahedron.
    pub max_volume: Option<f64>,
    /// The longest edge.
    pub max_edge: Option<f64>,
    /// Edges of a length within a radius of a place, each.
    pub near: Vec<Near>,
    /// Edges of a length at a part of the boundary, by its marker or name, each.
    pub size_at: Vec<SizeAt>,
    /// Edges in a full turn of a curved surface.
    pub curvature: Option<f64>,
    /// The factor by which edges grow from there; `None`: the usual one.
    pub growth: Option<f64>,
    /// The largest circumradius to shortest edge.
    pub radius_edge: Option<f64>,
    /// The degrees below which a dihedral angle is split, at most 12; 0: none is. `None`: what is
    /// usual, as the program does.
    pub min_dihedral: Option<f64>,
    /// The sweeps in which vertices inside are moved in the end, at most 16.
    pub smooth: u32,
    /// Count tetrahedra by their smallest dihedral angle before slivers are split, too:
    /// [`Meshed::before_slivers`](crate::Meshed::before_slivers).
    pub count_angles: bool,
    /// The most points to insert.
    pub max_points: Option<u64>,
    /// The rule that says what is void.
    pub holes: Holes,
    /// Regions with properties of their own.
    pub regions: Vec<Region>,
    /// The distance within which vertices are welded and seams closed.
    pub repair: f64,
    /// The distance within which the surface is simplified, at most 5 % of the diagonal; 0: not.
    pub simplify: f64,
    /// The most edges of a hole that is closed, at most 256; 0: none is.
    pub fill: u32,
    /// Facets that are coplanar within this distance are taken for one; 0: exactly coplanar ones.
    /// `None`: for a surface what is usual, as the program does, otherwise 0.
    pub flat_tolerance: Option<f64>,
    /// The feature angle, in degrees, at most 90: a surface without markers has a part, with a
    /// marker, where triangles meet at less. 0: none; `None`: for a surface what is usual, as the
    /// program does, otherwise 0.
    pub feature_angle: Option<f64>,
    /// The coordinates of the mesh.
    pub frame: Frame,
    /// Refuse a domain that is not on its lattice.
    pub exact_input: bool,
    /// Points that are vertices of the mesh, too: within three steps of the lattice of the boundary
    /// they are put on it; those outside are left out, with a note.
    pub points: Vec<Point>,
    /// Refuse input that would be repaired, of which something would be left out or guessed.
    pub strict: bool,
    /// Leave the mesh unchecked.
    pub unchecked: bool,
    /// The share of tetrahedra, and of volume, that may be excused in a mesh that serves, at most
    /// 0.05. `None`: what is usual, as the program does.
    pub excused_share: Option<f64>,
}
