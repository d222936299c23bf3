//! A domain in, a mesh out, in one call.

use super::{RefineError, Refined, Refiner, usual_tolerance};
use crate::{Domain, PrepareError, PrepareOptions, Prepared};

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

/// A domain as it is given: a [`Domain`], or the file that it was read from.
pub trait Given {
    /// The domain itself.
    fn domain(&self) -> &Domain;

    /// Are its facets an oriented surface, which says itself what is inside? So they are in formats
    /// without hole points.
    fn is_surface(&self) -> bool;

    /// The distance within which neighbouring facets are taken for coplanar where nobody asks for
    /// one, in the library as in the program and the bindings: [`usual_tolerance`] of a surface, 0
    /// of another domain, and of exact input.
    fn flat_tolerance(&self, ready: &Prepared, options: &PrepareOptions) -> f64 {
        match self.is_surface() && !options.exact_input {
            true => usual_tolerance(self.domain(), &ready.domain),
            false => 0.0,
        }
    }
}

/// A domain that is no file: its facets need not be oriented.
impl Given for Domain {
    fn domain(&self) -> &Domain {
        self
    }

    fn is_surface(&self) -> bool {
        false
    }
}

impl Refiner<'_> {
    /// Prepares a domain with the usual options and meshes it, within the usual tolerance if none
    /// was asked for: [`Domain::prepare`], [`Given::flat_tolerance`], then [`Refiner::refine`].
    /// These calls by themselves also say what was moved and repaired. A file is given whole, for
    /// it tells whether it holds an oriented surface: the mesh is then the program's.
    ///
    /// # Errors
    /// [`MeshError`]: the domain is defective, a bound is no bound, or there is no memory.
    pub fn mesh(&self, given: &impl Given) -> Result<Refined, MeshError> {
        let options = PrepareOptions { oriented: given.is_surface(), ..PrepareOptions::default() };
        let ready = given.domain().prepare(&options)?;
        let usual = given.flat_tolerance(&ready, &options);
        Ok(self.or_flat_tolerance(usual).refine(&ready.domain, &ready.lattice)?)
    }
}
