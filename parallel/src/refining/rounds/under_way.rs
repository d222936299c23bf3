//! Messages that a barrier waits for, and P12: of which kinds none is under way in which stage.
//!
//! | sent in | kinds | taken before |
//! |---|---|---|
//! | `Looking`, `Exchanging` | `Keys` | `Counting` ends |
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
    /// New tetrahedra are to be looked at.
    Looking,
    /// The workers beside have to tell their keys, for the first or second time.
    Exchanging(u32),
    /// Waiting at the barrier at which all is counted.
    Counting,
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
const KINDS: [&str; NEXT_PROBES + DECISIONS - PROBES] = {
    let mut all = [""; NEXT_PROBES + DECISIONS - PROBES];
    let mut k = 0;
    while k < all.len() {
        all[k] = NEWS_KINDS[k % NEXT_KEYS];
        k += 1;
    }
    all
};
// The places of the first of each row.
const PROBES: usize = 1;
const DECISIONS: usize = 16;
const RELEASES: usize = 20;
const NEXT_KEYS: usize = 23;
const NEXT_PROBES: usize = 24;

impl Stage {
    /// The kinds of which none may be under way while a worker is in this stage. One that has not
    /// said its word yet at the barrier there `keeps` all others from what follows.
    pub(super) fn excludes(self, keeps: bool) -> &'static [&'static str] {
        match self {
            Self::Looking | Self::Exchanging(_) => &KINDS[PROBES..RELEASES],
            Self::Counting if keeps => &KINDS[PROBES..RELEASES],
            Self::Counting => &KINDS[DECISIONS..RELEASES],
            Self::Choosing if keeps => &KINDS[DECISIONS..NEXT_PROBES],
            Self::Choosing | Self::Parting => &KINDS[RELEASES..NEXT_PROBES],
            Self::Deciding => &KINDS[RELEASES..],
            Self::Inserting if keeps => &KINDS[RELEASES..],
            Self::Inserting => &KINDS[NEXT_PROBES..],
            Self::Over => &KINDS[..NEXT_KEYS],
        }
    }
}
