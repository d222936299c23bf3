//! A mesh that is gone on with.

use crate::{RefineError, Refined, Refiner};
use ltbw_core::TetMesh;
use ltbw_domain::{PrepareOptions, PreparedSkin, Skin, SkinError};

/// Why a mesh is not gone on with.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResumeError {
    /// It is no mesh, not Delaunay, or its boundary no domain.
    #[error(transparent)]
    Mesh(#[from] SkinError),
    /// Its refinement failed.
    #[error(transparent)]
    Refine(#[from] RefineError),
}

impl Refiner<'_> {
    /// Goes on with a conforming Delaunay mesh: its vertices are vertices of the new one, its
    /// boundary, with the walls between tags and the listed faces, is the domain, markers and tags
    /// are kept. Where all bounds are met, and nothing was excused, it comes back as it is.
    ///
    /// [`Skin`] does this step by step, also for meshes that are not Delaunay, and with the domain
    /// that a mesh is of.
    ///
    /// # Errors
    /// [`ResumeError`]: it is not Delaunay, among others.
    ///
    /// ```
    /// use ltbw_domain::Domain;
    /// use ltbw_refine::Refiner;
    /// let cube = Domain::cuboid([0.0; 3], [1.0; 3]);
    /// let coarse = Refiner::new().max_volume(0.05).mesh(&cube)?.inside();
    /// let fine = Refiner::new().max_volume(0.01).resume(&coarse)?.inside();
    /// assert!(coarse.points.iter().all(|p| fine.points.contains(p)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn resume(&self, mesh: &TetMesh) -> Result<Refined, ResumeError> {
        let skin = Skin::of(mesh)?;
        skin.check_delaunay()?;
        let PreparedSkin { ready, flat_tolerance } = skin.prepare(&PrepareOptions::default())?;
        Ok(self.or_flat_tolerance(flat_tolerance).refine(&ready.domain, &ready.lattice)?)
    }
}
