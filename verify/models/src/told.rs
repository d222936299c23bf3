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
