//! Pictures of meshes, as SVG without anything from outside them.

pub(crate) mod angles;
pub(crate) mod axes;
pub(crate) mod curve;
pub(crate) mod histograms;
