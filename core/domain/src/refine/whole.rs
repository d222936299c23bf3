//! A domain in, a mesh out, in one call.

use super::{RefineError, Refined, Refiner};
use crate::{Domain, PrepareError, PrepareOptions};

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
    /// Prepares a domain with the usual options and meshes it: [`Domain::prepare`], then
    /// [`Refiner::refine`]. The two calls by themselves also say what was moved and repaired.
    ///
    /// # Errors
    /// [`MeshError`]: the domain is defective, a bound is no bound, or there is no memory.
    pub fn mesh(&self, domain: &Domain) -> Result<Refined, MeshError> {
        let ready = domain.prepare(&PrepareOptions::default())?;
        Ok(self.refine(&ready.domain, &ready.lattice)?)
    }
}
