//! The rules of refinement, as functions of what can be seen of a mesh: whoever runs them, on one
//! mesh or on a part of it, may not show here.

pub(crate) mod aim;
pub(crate) mod way;
