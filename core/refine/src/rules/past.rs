//! What came of earlier proposals, by values: the grounds of verdicts beside the closure, for
//! engines whose mesh is on many processors.

use crate::mesh::limit::Limit;

/// The past of a proposal.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Past {
    /// The vertices of the whole mesh.
    pub num_vertices: usize,
    /// The edges that splitting the item may make.
    pub limit: Option<Limit>,
}
