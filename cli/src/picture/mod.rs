//! Pictures of meshes, as SVG without anything from outside them.

pub(crate) mod cut;
pub(crate) mod histograms;
