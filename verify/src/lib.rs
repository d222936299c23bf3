//! Independent exact checker.
#![forbid(unsafe_code)]

mod check;
mod defect;
mod exact;
mod faces;
mod geometry;
mod hash;
mod hull;
mod mesh;
mod perturb;
mod predicates;
mod report;
mod structure;
mod sweep;
mod topology;

pub use check::check;
pub use defect::{Defect, Kind, Level};
pub use hash::{HashError, canonical_hash};
pub use mesh::{Depth, Mesh, NO_NEIGHBOUR, Options, Point, VertexOrder};
pub use report::{Certificate, Counts, Hash, LevelReport, Outcome, Report};
