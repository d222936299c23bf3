//! Refinement of domains on many processors: in rounds, which give the sequential mesh (`rounds`),
//! and without, in the paper's mode (`freely`, over `domain`). `whole` puts their parts together.

mod domain;
mod flags;
mod freely;
mod news;
#[cfg(feature = "wire")]
mod parcel;
mod rounds;
mod whole;

pub use domain::{
    BadItems, DomainCargo, DomainMesh, DomainNode, DomainPatch, DomainPiece, DomainPoint, Plan,
    Splits,
};
#[cfg(feature = "wire")]
pub use freely::domain_on_team;
pub use freely::{
    START_EACH, SimulatedDomain, ThreadedDomain, domain_on_threads, simulate_domain,
    simulate_domain_as,
};
pub use news::{
    Ball, DomainNews, Entrant, Fate, KeysTold, Owned, PartEnd, ProbeId, Proposal, Report, Reported,
    Sums, WireAsked, WireClosure, WireCorner, WireItem, WireLent, WirePart, WireParted, WirePoint,
};
#[cfg(feature = "wire")]
pub use rounds::{
    Checkpoints, LateSteps, PartMesh, Pieces, RefinedPart, RefinedWhole, SliverThere, TeamEnd,
    TeamRounds, Wishes, rounds_on_team,
};
pub use rounds::{
    Ending, InnerCandidate, Late, RoundFigures, RoundNode, Rounds, SENT, SimulatedRounds, Step,
    TAKEN, ThreadedRounds, Tree, is_quiet, rounds_by, rounds_on_threads, simulate_rounds,
    simulate_rounds_as, unkilled,
};
pub use whole::Owners;

use crate::simulate::MeshError;
use crate::threads::RunError;
use ltbw_core::BuildError;

/// Why a domain cannot be refined by many workers.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RefineError {
    /// Coordinates are too large or too small to make new points as they are.
    #[error("the coordinates are out of the range in which new points are made")]
    Range,
    /// The points have no mesh.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The domain has no mesh.
    #[error(transparent)]
    Domain(#[from] ltbw_refine::RefineError),
    /// The domain has no mesh that several processors could start with.
    #[error(transparent)]
    Complex(#[from] ltbw_refine::ComplexError),
    /// The threads have not ended properly.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The simulated processors have not ended properly.
    #[error(transparent)]
    Simulation(#[from] MeshError),
}
