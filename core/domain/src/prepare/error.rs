//! Why a domain cannot be meshed.

use crate::display::summary;
use crate::renumber::rename;
use crate::{DomainError, DomainReport};

/// Why a domain cannot be meshed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// It cannot be looked at.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// A tolerance that is no length, or longer than a part of the domain.
    #[error(
        "the tolerance {value:e} is not between 0 and {limit:e}, 2^-10 of the domain's diagonal"
    )]
    Tolerance {
        /// The tolerance.
        value: f64,
        /// The largest one.
        limit: f64,
    },
    /// A tolerance of simplification that is no length, or longer than a part of the domain.
    #[error(
        "the tolerance {value:e} of simplification is not between 0 and {limit:e}, 5 % of the \
         domain's diagonal"
    )]
    Simplify {
        /// The tolerance.
        value: f64,
        /// The largest one.
        limit: f64,
    },
    /// Points are given in a domain whose surface is to be simplified: they might not be on it, or
    /// in it, afterwards.
    #[error("{count} points are given: the surface cannot be simplified around them")]
    SimplifyPoints {
        /// Their number.
        count: usize,
    },
    /// It has defects. Elements are those of the input.
    #[error("{}", summary(.0))]
    Defects(Box<DomainReport>),
    /// It has defects once its vertices are on the lattice: features below the lattice. Elements
    /// are those of the input.
    #[error("on the lattice of step {step:e}: {}", summary(.report))]
    BelowLattice {
        /// The defects.
        report: Box<DomainReport>,
        /// The step of the lattice.
        step: f64,
    },
    /// Something would be repaired, left out or guessed, and that was to be refused.
    #[error("not repaired, as it is to be strict: {}", .notes.join("; "))]
    Strict {
        /// A line for each kind.
        notes: Vec<String>,
    },
    /// It bounds nothing that is not a hole.
    #[error("there is nothing to mesh: all that the facets bound are holes")]
    NothingInside,
    /// The inside was not found, or a void has no point that is a double.
    #[error("the facets are too thin to tell the inside from the outside")]
    Undecided,
}

impl PrepareError {
    /// A short code that stays the same between versions, for programs to match on.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            PrepareError::Domain(error) => error.code(),
            PrepareError::Tolerance { .. } => "domain.tolerance",
            PrepareError::Simplify { .. } => "domain.simplify",
            PrepareError::SimplifyPoints { .. } => "domain.simplify-points",
            PrepareError::Defects(_) => "domain.defects",
            PrepareError::BelowLattice { .. } => "domain.below-lattice",
            PrepareError::Strict { .. } => "domain.strict",
            PrepareError::NothingInside => "domain.nothing-inside",
            PrepareError::Undecided => "domain.undecided",
        }
    }

    /// The findings of the check, if they are the reason.
    #[must_use]
    pub fn report(&self) -> Option<&DomainReport> {
        match self {
            PrepareError::Defects(report) | PrepareError::BelowLattice { report, .. } => {
                Some(report)
            }
            _ => None,
        }
    }
}

impl PrepareError {
    /// Gives vertices, in a domain that is a part of the input, their numbers in the input.
    pub(super) fn renumbered(mut self, numbers: &[u32]) -> Self {
        match &mut self {
            PrepareError::Defects(report) | PrepareError::BelowLattice { report, .. } => {
                let number = |v: u32| numbers.get(v as usize).copied().unwrap_or(v);
                rename(report, &number, &|f| f);
            }
            PrepareError::Domain(DomainError::OffLattice { vertex, .. }) => {
                *vertex = numbers[*vertex as usize];
            }
            _ => {}
        }
        self
    }
}
