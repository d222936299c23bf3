//! The news of sources with rounds.

use ltbw::refining::Sums;

/// The news of a source with rounds.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Told {
    /// A question.
    Ask,
    /// Its answer.
    Answer,
    /// Sums of the sender and those below it.
    Up(Sums),
    /// The sums of all.
    Down(Sums),
}

impl Told {
    /// The name of those that the barriers wait for.
    pub fn kind(&self) -> Option<&'static str> {
        match self {
            Self::Ask => Some("Ask"),
            Self::Answer => Some("Answer"),
            Self::Up(_) | Self::Down(_) => None,
        }
    }
}
