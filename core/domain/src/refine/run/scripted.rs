//! Refinement that writes a script.

use super::Refiner;
use crate::refine::script::Script;
use crate::refine::{RefineError, Refined};
use crate::{Domain, Lattice};
use ltbw_exact::Mode;

impl Refiner<'_> {
    /// As [`Refiner::refine`], with the script. It is empty where there are no rounds.
    ///
    /// # Errors
    /// [`RefineError`] says why there is no mesh of the domain.
    #[doc(hidden)]
    pub fn refine_with_script(
        &self,
        domain: &Domain,
        lattice: &Lattice,
    ) -> Result<(Refined, Script), RefineError> {
        let script = Script { mode: Mode::Normal, start: Vec::new(), rounds: Vec::new() };
        let (refined, script) = self.refined(domain, lattice, Some(script))?;
        script.map(|script| (refined, script)).ok_or(RefineError::Invariant { what: "a script" })
    }
}
