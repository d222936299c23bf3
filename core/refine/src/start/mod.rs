//! The start: from the mesh of the corners to one that has the boundary.
//!
//! | module | what it holds |
//! |---|---|
//! | `crowd` | where segments are cut before there is a mesh |
//! | `recover`, `mend` | what is missing is found, and split |
//! | `arc` | a place on an arc around a corner |
//! | `seed` | the first points where empty balls are large |

pub(crate) mod arc;
pub(crate) mod crowd;
pub(crate) mod mend;
pub(crate) mod recover;
pub(crate) mod seed;
