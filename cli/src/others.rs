//! The other processes of a run, as the pipeline sees them.

use crate::binding::Read;
use crate::outcome::Failure;
use ltbw::refine::Refiner;
use ltbw::refining::{RefineError, ThreadedRounds};
use ltbw::threads::{Parallel, RunError};
use ltbw::{Builder, Built, CancelToken, Domain, Lattice, PointSet};

/// The processes, as the pipeline sees them.
pub(crate) trait Ranks {
    /// Their number.
    fn size(&self) -> u32;

    /// Makes sure that all have read these files.
    fn agree(&self, inputs: &[Read]) -> Result<(), Failure>;

    /// Builds a mesh; the first process gets it.
    fn build(&self, builder: &Builder<'_>, set: &PointSet) -> Result<Option<Built>, RunError>;

    /// Refines a domain; the first process gets the mesh.
    fn refine(
        &self,
        refiner: &Refiner<'_>,
        whole: (&Domain, &Lattice),
        of: (&Parallel<'_>, &CancelToken),
    ) -> Result<Option<ThreadedRounds>, RefineError>;
}

/// The processes of a run, if there are several.
pub(crate) type Others<'r> = Option<&'r dyn Ranks>;
