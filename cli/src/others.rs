//! The other processes of a job, as the pipeline sees them: `ranks` has those of `ltbw-mpi`.

use crate::binding::Read;
use crate::outcome::Failure;
use ltbw::CancelToken;
use ltbw::domain::Prepared;
use ltbw::refine::Refiner;
use ltbw::refining::{RefineError, ThreadedRounds};
use ltbw::threads::Parallel;

/// The processes, as the pipeline sees them.
pub(crate) trait Ranks {
    /// Their number.
    fn size(&self) -> u32;

    /// Makes sure that all have read these files.
    fn agree(&self, inputs: &[Read]) -> Result<(), Failure>;

    /// The processes as those that mesh points, none of which has all of the mesh.
    #[cfg(feature = "wire")]
    fn apart(&self) -> &dyn Apart;

    /// Refines a domain; the first process gets the mesh.
    fn refine(
        &self,
        refiner: &Refiner<'_>,
        ready: &Prepared,
        parallel: &Parallel<'_>,
        token: &CancelToken,
    ) -> Result<Option<ThreadedRounds>, RefineError>;
}

/// The processes of a run, if there are several.
pub(crate) type Others<'r> = Option<&'r dyn Ranks>;

#[cfg(feature = "wire")]
pub(crate) use apart::Apart;

#[cfg(feature = "wire")]
mod apart {
    use crate::outcome::Failure;
    use ltbw::distributed::{Gathered, Hashed, Part};
    use ltbw::threads::{BuiltPart, RunError};
    use ltbw::{Builder, PointSet};
    use ltbw_verify as verify;

    /// Processes each of which has a part of a mesh of points.
    pub(crate) trait Apart {
        /// Their number.
        fn size(&self) -> u32;

        /// The number of this one, from 0.
        fn me(&self) -> u32;

        /// Builds the mesh; each process gets its part.
        fn build(&self, builder: &Builder<'_>, set: &PointSet) -> Result<BuiltPart, RunError>;

        /// The hash of the mesh that the parts of all are.
        fn hash(&self, part: &Part) -> Result<Hashed, Failure>;

        /// Checks the mesh that the parts of all are.
        fn check(
            &self,
            part: &verify::Part<'_>,
            options: &verify::Options,
        ) -> Result<verify::Report, Failure>;

        /// The tetrahedra of all parts, over this number of points, at the first process.
        fn gather(&self, part: &Part, points: usize) -> Result<Option<Gathered>, Failure>;

        /// Tells all what has become of this one's work; the first failure, if there is one.
        fn compare(&self, own: Option<&Failure>) -> Result<(), Failure>;
    }

    impl dyn Apart + '_ {
        /// Is this the one that reports?
        pub(crate) fn is_first(&self) -> bool {
            self.me() == 0
        }

        /// The work of this one, if all others have done theirs, too.
        pub(crate) fn together<T>(&self, own: Result<T, Failure>) -> Result<T, Failure> {
            self.compare(own.as_ref().err())?;
            own
        }
    }
}
