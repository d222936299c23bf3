//! The end of a domain on a team: what each member has.

use super::{Late, RefinedPart};

/// A domain that a team has refined, as one member has it.
#[derive(Debug)]
pub enum TeamEnd<W> {
    /// Its part.
    Part(Box<RefinedPart>),
    /// The whole, at the first member: why, and since when.
    Whole(Box<W>, LateSteps),
    /// Nothing, as the first member has the whole.
    Elsewhere,
}

impl<W> TeamEnd<W> {
    /// The whole mesh, if this member has it.
    pub fn into_whole(self) -> Option<W> {
        match self {
            Self::Whole(whole, _) => Some(*whole),
            Self::Part(_) | Self::Elsewhere => None,
        }
    }

    /// This end, with another word for the whole mesh.
    pub fn map<V>(self, of: impl FnOnce(W) -> V) -> TeamEnd<V> {
        match self {
            Self::Part(part) => TeamEnd::Part(part),
            Self::Whole(whole, late) => TeamEnd::Whole(Box::new(of(*whole)), late),
            Self::Elsewhere => TeamEnd::Elsewhere,
        }
    }
}

/// The work of one member on a whole mesh, in the end.
#[derive(Clone, Copy, Debug)]
pub struct LateSteps {
    /// Why.
    pub why: Late,
    /// Tetrahedra that it was given by the others, its own among them.
    pub tets: u64,
    /// The time from where the others had ended.
    pub seconds: f64,
}
