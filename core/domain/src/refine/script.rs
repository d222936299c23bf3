//! The script of a refinement: the points that its rounds insert, as values, for others to insert.

use ltbw_exact::{Mode, Point};

/// A point that a round inserts, in the coordinates of the script.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chosen {
    /// The point.
    pub point: Point,
    /// The corners of a tetrahedron of the mesh at the start of the round that is in conflict with
    /// it: of the one that it is to split, if it is to split one. Of a point of a joint step none
    /// is known.
    pub near: Option<[Point; 4]>,
}

/// The points that the rounds of a refinement insert.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct Script {
    /// The coordinates of a vertex of the mesh, as [`Mode::from_kernel`] makes them of those here.
    pub mode: Mode,
    /// The vertices at the start of the rounds.
    pub start: Vec<Point>,
    /// The points of each round. They may be inserted in any order, when those of the rounds before
    /// are in.
    pub rounds: Vec<Vec<Chosen>>,
}
