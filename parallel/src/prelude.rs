//! The names that most programs need: `use ltbw::prelude::*`.

pub use crate::query::{Cursor, Location, Queries};
pub use crate::threads::{Parallel, Run, RunError};
pub use crate::{Budget, BuildError, Builder, Built, CancelToken, Inserted, Mesh, Outcome};
pub use crate::{Phase, Progress, TetMesh, Vertex};
#[cfg(feature = "domains")]
#[doc(no_inline)]
pub use ltbw_domain::{Domain, Facet, PrepareOptions, Region};
#[doc(no_inline)]
pub use ltbw_exact::{Point, PointError, PointSet};
#[cfg(feature = "io")]
#[doc(no_inline)]
pub use ltbw_formats as io;
#[cfg(feature = "domains")]
#[doc(no_inline)]
pub use ltbw_refine::{MeshError, RefineOutcome, Refined, Refiner};
