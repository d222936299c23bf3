//! Pictures of meshes, as SVG without anything from outside them.

pub(crate) mod curve;
pub(crate) mod histograms;
