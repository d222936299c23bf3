//! The complex: the boundary of a domain, as it is before there is a mesh.
//!
//! | module | what it holds |
//! |---|---|
//! | `plc` | corners, segments, facets as maximal coplanar groups |
//! | `flat`, `patch` | polygons coplanar within a tolerance, and their projection |
//! | `points` | where given points live |
//! | `carrier` | points of segments and facets, with whole parameters |
//! | `dihedral` | bounds on dihedral angles |
//! | `measure` | closed balls and bounds: filters and exact integers |
//! | `angles`, `near` | where the theory gives no guarantee: small angles, narrow gaps |
//! | `parts`, `ring` | the parts of a facet; rings of corners |
//! | `background`, `marked` | sizing by a mesh, at input vertices, in marked tetrahedra |

pub(crate) mod angles;
pub(crate) mod background;
pub(crate) mod carrier;
pub(crate) mod dihedral;
pub(crate) mod edges;
pub(crate) mod flat;
pub(crate) mod marked;
pub(crate) mod measure;
pub(crate) mod near;
pub(crate) mod parts;
pub(crate) mod patch;
pub(crate) mod plc;
mod points;
pub(crate) mod ring;
