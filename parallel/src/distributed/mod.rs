//! A mesh that is nowhere in one place: each member of a team has a part of it, and what
//! is asked of the whole is found by all together.
//!
//! | module | what it holds |
//! |---|---|
//! | `slice` | the points that are given: each member has a slice of them |
//! | `order` | these points along a curve: each member gets a stretch of it |
//! | `records` | values of one size, many at a time, as bytes |
//! | `sort` | what all members have, sorted: each gets a stretch of it |
//! | `ask` | questions to the member that has the answer; tags of points |
//! | `number` | numbers of vertices that nobody has given one |
//! | `share` | which of two parts has the triangle between them, and what is beyond |
//! | `hash` | the hash `ltbw.mesh/1`, byte for byte |
//! | `stream` | the bytes of that hash on their way |
//! | `border` | what parts have in common, for files that solvers read |
//! | `gather` | tetrahedra and points at one place, for files that hold all; points dealt |
//! | `join` | the mesh of a domain at one place, for files that hold all of it |
//! | `thickness` | whether the points are nearly in one plane |
//!
//! No member holds more than a few times its share: vertices and tetrahedra are sorted into
//! stretches of about equal length, and the bytes of the hash go through where they are.

mod ask;
mod border;
mod gather;
mod hash;
mod join;
mod number;
mod order;
mod records;
mod share;
mod slice;
mod sort;
mod stream;
mod thickness;

pub(crate) use ask::ask;
pub use ask::tags;
pub use border::border;
pub use gather::{Gathered, Points, deal, gather, gather_points};
pub use hash::{Hashed, hash};
pub use join::{Joined, join};
pub(crate) use number::{Unnumbered, number};
pub use order::{Ordered, Placed, order};
pub(crate) use records::{bytes_of, values_of};
pub(crate) use share::{Shared, Side, first_of_two};
pub use slice::{Slice, SliceError};
pub use thickness::thickness;

use ltbw_core::Vertex;
use ltbw_exact::Point;

/// One member's tetrahedra with their vertices. Each tetrahedron is in one part, a vertex in as
/// many as have a tetrahedron at it; a part may be empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// The numbers of the vertices in the input, ascending.
    pub numbers: Vec<Vertex>,
    /// Their coordinates in the input.
    pub points: Vec<Point>,
    /// The tetrahedra, positively oriented, by places in these lists.
    pub tets: Vec<[u32; 4]>,
    /// Facets of the hull, by numbers in the input. Each facet of the mesh is in one part, not
    /// always in that of its tetrahedron.
    pub hull: Vec<[Vertex; 3]>,
}

impl Part {
    /// The tetrahedra by numbers in the input.
    pub fn numbered(&self) -> impl ExactSizeIterator<Item = [Vertex; 4]> + '_ {
        self.tets.iter().map(|tet| tet.map(|v| self.numbers[v as usize]))
    }
}
