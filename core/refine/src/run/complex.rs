//! A run's boundary and bounds as values.

use super::Run;
use crate::mesh::bounds::Bounds;
use crate::rules::complex::{Complex, ComplexError};

impl<'a> Run<'a> {
    /// The boundary and the bounds as values.
    ///
    /// # Errors
    /// [`ComplexError`] if some of the boundary is missing.
    pub(super) fn complex(&self) -> Result<Complex<'a>, ComplexError> {
        let own = &self.refinement;
        let mut complex = Complex::of(&own.state, self.fit()?.clone(), own.floor, own.joint_most);
        complex.strategy = self.refiner.strategy;
        Ok(complex)
    }

    /// The bounds of a run that others can go on with.
    ///
    /// # Errors
    /// [`ComplexError`] if some of the boundary is missing.
    pub(super) fn fit(&self) -> Result<&Bounds<'a>, ComplexError> {
        let missing = "some of the boundary could not be recovered";
        self.refinement.bounds.as_ref().ok_or(ComplexError::Unsupported(missing))
    }
}
