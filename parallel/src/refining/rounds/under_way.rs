//! Messages that a barrier waits for, and P12: of which kinds none is under way in which stage.
//!
//! | sent in | kinds | taken before |
//! |---|---|---|
//! | `Looking`, `Exchanging` | `Keys` | `Choosing` ends |
//! | `Choosing` | `Way`, `Seek`, `Search`, `Beyond`, `Part`, `Blocks` | `Choosing` ends |
//! | `Choosing` | `Void`, `WantRivals` | `Choosing` ends |
//! | `Choosing`, in turns | `Entrants`, `Launch`, `Report`, `Fates` | `Choosing` ends |
//! | `Parting` | `Waiting`, `Lend`, `Lent` | `Parting` ends |
//! | `Parting` | `Parted` | `Inserting` ends |
//! | `Deciding` | `Rivals`, `Ask`, `Gone` | `Inserting` ends |
//! | the end of `Inserting` | `Release`, `Refused`, `Unblocked` | the next `Counting` ends |
//!
//! Some are counted, so that the barrier is repeated; the others are awaited by workers that do not
//! speak before. Checkers ask both of every state: a kind that nobody counts or awaits would be
//! late on few networks, and seen on fewer.

use crate::refining::news::NEWS_KINDS;

/// The stages of a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// Waiting at the barrier at which all is counted.
    Counting,
    /// New tetrahedra are to be looked at.
    Looking,
    /// The workers beside have to tell their keys, for the first or second time.
    Exchanging(u32),
    /// Probing.
    Choosing,
    /// Circles are split.
    Parting,
    /// Waiting for rivals.
    Deciding,
    /// Inserting.
    Inserting,
    /// No round follows.
    Over,
}

/// Messages that barriers count, sent less taken.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    pub(super) notes: i64,
    pub(super) asks: i64,
    pub(super) releases: i64,
}

/// The kinds in the order of the table, and from the start again: a round follows a round.
const KINDS: [&str; NEXT_KEYS + RELEASES] = {
    let mut all = [""; NEXT_KEYS + RELEASES];
    let mut k = 0;
    while k < all.len() {
        all[k] = NEWS_KINDS[k % NEXT_KEYS];
        k += 1;
    }
    all
};
// The places of the first kinds that are sent after a barrier.
const DECISIONS: usize = 16;
const RELEASES: usize = 20;
const NEXT_KEYS: usize = 23;
const NEXT_DECISIONS: usize = NEXT_KEYS + DECISIONS;

impl Stage {
    /// The kinds of which none may be under way while a worker is in this stage. One that has not
    /// said its word yet at the barrier there `keeps` all others from what follows.
    pub(super) fn excludes(self, keeps: bool) -> &'static [&'static str] {
        match self {
            Self::Counting if keeps => &KINDS[NEXT_KEYS..],
            Self::Counting => &KINDS[DECISIONS..RELEASES],
            Self::Looking | Self::Exchanging(_) => &KINDS[DECISIONS..NEXT_KEYS],
            Self::Choosing if keeps => &KINDS[DECISIONS..NEXT_KEYS],
            Self::Choosing | Self::Parting => &KINDS[RELEASES..NEXT_KEYS],
            Self::Deciding => &KINDS[RELEASES..NEXT_DECISIONS],
            Self::Inserting if keeps => &KINDS[RELEASES..NEXT_DECISIONS],
            Self::Inserting => &KINDS[NEXT_KEYS..NEXT_DECISIONS],
            Self::Over => &KINDS[..NEXT_KEYS],
        }
    }
}
