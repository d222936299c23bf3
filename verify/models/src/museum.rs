//! The museum: the protocol with one defect each, as a [`Conduct`] of its own. Every piece must be
//! caught by a checker; `tests/museum.rs` says by which, and after how much work.

use ltbw::protocol::{Conduct, Sound};
use std::fmt::Debug;
use std::hash::Hash;

/// A conduct that models can explore.
pub trait Exhibit: Conduct + Clone + Debug + PartialEq + Eq + Hash + Send + Sync {
    /// What is wrong.
    const TITLE: &'static str;
}

impl Exhibit for Sound {
    const TITLE: &'static str = "sound";
}

/// Declares museum pieces: a type, its title, and the one rule that it breaks.
macro_rules! pieces {
    ($($(#[$doc:meta])* $piece:ident: $title:literal, $rule:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, Eq, Hash)]
        pub struct $piece;

        impl Conduct for $piece {
            const $rule: bool = false;
        }

        impl Exhibit for $piece {
            const TITLE: &'static str = $title;
        }
    )*};
}

pieces! {
    /// Two cavities that share no cell can share a ring cell, and leave a hull that is not convex.
    BareCavity: "closure ring not locked", LOCKS_RING;
    /// A lock stays behind with a holder that no longer exists.
    LeakyRollback: "rollback leaks a lock", RELEASES_ALL;
    /// Those who waited for the locks that a setback gave back sleep for ever.
    ForgetfulRollback: "rollback forgets the queue", WAKES_ON_ABORT;
    /// The others keep waiting for a holder that they were never compared with.
    NaiveRegrant: "naive wait-die re-grant", REGRANT_ASKS_ALL;
    /// A request that is asked again while it waits for a lock turns to the new wants when the lock is
    /// released, and a younger operation takes the lock: it can be wounded for it again and again.
    LostPlace: "new wants above the one waited for", KEEPS_PLACE;
    /// The next attempt meets its own last one.
    HastyRestart: "restart before the releases are acknowledged", AWAITS_RELEASES;
    /// A committed operation is set back. With channels in order its `Abort` finds nothing to release
    /// and its second walk finds the point as a vertex: the result is right all the same, so that
    /// no checker can catch it but by this rule itself.
    LateWound: "wound after commit obeyed", IGNORES_LATE_WOUND;
    /// The token misses a message that was taken behind its back.
    WhiteSafra: "Safra without blackening", BLACKENS;
    /// A passive worker sends a message: what termination detection rests on is gone.
    IdleMigration: "migration by an idle worker", ONLY_BUSY_MIGRATE;
    /// What is addressed to a block that has moved is dropped.
    NoForwarding: "missing forward pointer", FORWARDS;
    /// Requests wait for an installation that takes place elsewhere.
    LeftWaiters: "waiters not moved", MOVES_WAITERS;
    /// Ring cells keep links to deleted cells.
    StaleInterface: "stale interface handle", RELINKS_INTERFACE;
    /// A slot's number, without a generation, names two cells.
    ReusedName: "reused slot without generation", FRESH_NAMES;
    /// A seed that is not installed yet is taken for nothing.
    ImpatientExpand: "Expand before installation not held", AWAITS_INSTALLATION;
    /// A cancelled worker goes on with the points of a block that moves to it.
    RestlessCancel: "cancelled worker takes in moved points", STAYS_CANCELLED;
    /// Beside a block that has left, tetrahedra are made that belong to it and stay behind.
    KeptHome: "block that left taken for one's own", LEAVES_BLOCKS;
    /// A worker tests its inbox in one critical section and goes to sleep in another.
    LostWakeUp: "lost wake-up", TESTS_BEFORE_SLEEP;
}
