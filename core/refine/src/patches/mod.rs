//! Patches in a mesh: how a point changes them.
//!
//! | module | what it holds |
//! |---|---|
//! | `layer` | the holes of a patch |
//! | `surface` | the labels around a new point |
//! | `dust` | flat tetrahedra go to the outer side |

pub(crate) mod dust;
pub(crate) mod layer;
pub(crate) mod surface;
