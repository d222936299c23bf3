//! A domain in, a mesh out, in one call.

use crate::{RefineError, Refined, Refiner};
use ltbw_domain::{Given, PrepareError, PrepareOptions};

/// Why there is no mesh of a domain as it was given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The domain cannot be meshed.
    #[error(transparent)]
    Prepare(#[from] PrepareError),
    /// Its refinement failed.
    #[error(transparent)]
    Refine(#[from] RefineError),
}

impl Refiner<'_> {
    /// Prepares a domain with the usual options and meshes it, within the usual tolerance if none
    /// was asked for: [`ltbw_domain::Domain::prepare`], [`Given::flat_tolerance`], then
    /// [`Refiner::refine`]. These calls by themselves also say what was moved and repaired. A file
    /// is given whole, for it tells whether it holds an oriented surface: the mesh is then the
    /// program's. The markers of a surface without any are its smooth parts:
    /// [`Given::smooth_parts`].
    ///
    /// # Errors
    /// [`MeshError`]: the domain is defective, a bound is no bound, or there is no memory.
    pub fn mesh(&self, given: &impl Given) -> Result<Refined, MeshError> {
        let options = PrepareOptions { oriented: given.is_surface(), ..PrepareOptions::default() };
        let ready = given.domain().prepare(&options)?;
        let usual = given.flat_tolerance(&ready, &options);
        let refined = self.or_flat_tolerance(usual).refine(&ready.domain, &ready.lattice)?;
        Ok(match given.smooth_parts(&ready, None, usual) {
            Some(parts) => refined.with_markers(parts.markers),
            None => refined,
        })
    }
}
