//! Known-bad variants: the protocol with one rule of `docs/protocol.md` broken, as [`Rules`] of its
//! own. Each must be caught by a checker; `tests/variants.rs` says by which, and after how much
//! work.

use ltbw::protocol::{Correct, Rules};
use std::fmt::Debug;
use std::hash::Hash;

/// Rules that models can explore.
pub trait Variant: Rules + Clone + Debug + PartialEq + Eq + Hash + Send + Sync {
    /// The number of the rule that is broken; empty if none is.
    const RULE: &'static str;
    /// The defect.
    const TITLE: &'static str;
}

impl Variant for Correct {
    const RULE: &'static str = "";
    const TITLE: &'static str = "correct";
}

/// Declares variants: the number of the broken rule and its constant, a type and a title.
macro_rules! variants {
    ($($(#[$doc:meta])* $number:ident $rule:ident: $variant:ident, $title:literal;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, Eq, Hash)]
        pub struct $variant;

        impl Rules for $variant {
            const $rule: bool = false;
        }

        impl Variant for $variant {
            const RULE: &'static str = stringify!($number);
            const TITLE: &'static str = $title;
        }
    )*};
}

variants! {
    /// Two cavities that share no cell can share a ring cell, and leave a hull that is not convex.
    R1 LOCKS_RING: BareCavity, "closure ring not locked";
    /// A lock stays behind with a holder that no longer exists.
    R2 RELEASES_ALL: LeakyRollback, "rollback leaks a lock";
    /// Requests that waited for the locks that a setback gave back sleep for ever.
    R3 WAKES_ON_ABORT: ForgetfulRollback, "rollback forgets the queue";
    /// The others keep waiting for a holder that they were never compared with, or for nobody.
    R4 REGRANT_ASKS_ALL: NaiveRegrant, "only the oldest is woken";
    /// A request that is asked again while it waits for a lock turns to the new wants when the lock
    /// is released, and a younger operation takes the lock: it can be wounded for it again and
    /// again.
    R5 KEEPS_PLACE: LostPlace, "new wants above the one waited for";
    /// The next attempt meets its own last one.
    R6 AWAITS_RELEASES: HastyRestart, "restart before the releases are acknowledged";
    /// A committed operation is set back, of which nothing is left at its home. (A home that kept
    /// it would do no harm: with channels in order its `Abort` finds nothing to release, and its
    /// second walk finds the point as a vertex.)
    R7 IGNORES_LATE_WOUND: LateWound, "wound after commit obeyed";
    /// A wave misses a message that was taken behind its back.
    R8 BLACKENS: WhiteSafra, "Safra without blackening";
    /// A passive worker sends a message: what termination detection rests on is gone.
    R9 ONLY_BUSY_MIGRATE: IdleMigration, "migration by an idle worker";
    /// Messages to a block that has moved are dropped.
    R10 FORWARDS: NoForwarding, "missing forward pointer";
    /// Requests wait for an installation that takes place elsewhere.
    R11 MOVES_WAITERS: LeftWaiters, "waiters not moved";
    /// Ring cells keep links to deleted cells.
    R12 RELINKS_INTERFACE: StaleInterface, "stale interface handle";
    /// A slot's number, without a generation, names two cells.
    R13 FRESH_NAMES: ReusedName, "reused slot without generation";
    /// A seed that is not installed yet is taken for nothing.
    R14 AWAITS_INSTALLATION: ImpatientExpand, "Expand before installation not held";
    /// A cancelled worker goes on with the points of a block that moves to it.
    R15 STAYS_CANCELLED: RestlessCancel, "cancelled worker takes in moved points";
    /// Beside a block that has left, tetrahedra are made that belong to it and stay behind.
    R16 LEAVES_BLOCKS: KeptHome, "block that left taken for one's own";
    /// A worker tests its inbox in one critical section and goes to sleep in another.
    R17 TESTS_BEFORE_SLEEP: LostWakeUp, "lost wake-up";
    /// The circumcentre of a tetrahedron that is gone may lie next to a vertex.
    R18 LETS_GO: Obstinate, "point inserted though its item is gone";
    /// The sums fit by chance while a commit is under way.
    R19 AWAITS_SECOND_WAVE: OneWave, "one wave ends a round";
    /// Keys of a second exchange are taken in the first, and awaited for ever in the second.
    R20 NUMBERS_EXCHANGES: NamelessKeys, "exchanges without a number";
    /// A home decides while another one still reserves.
    R21 AWAITS_RESERVATIONS: NoBarrier, "decided before all is reserved";
    /// The foremost candidate depends on how a submesh numbers its vertices.
    R22 RANKS_BY_PLACE: KeyByName, "ranks from numbers of vertices";
    /// Two points are inserted beside one another, each in its own facet.
    R23 HEARS_OF_RIVALS: DeafHome, "rivals elsewhere not heard of";
    /// Nobody gets the cavity of an item that waits.
    R24 TAKES_BACK: StaleReservation, "reservations of items that wait stay";
    /// The item that a tetrahedron asks for depends on whose parts it has seen.
    R25 ENDS_PROBES: HastyProbe, "probe stopped at its first veto";
    /// Two neighbours of about one size, each the one to be split.
    R26 BREAKS_TIES: EqualKeys, "of equal keys both chosen";
    /// Another worker's point, inserted meanwhile, has changed the cavity.
    R27 CHECKS_AHEAD: RashChoice, "cavity found ahead taken as it was";
    /// The boundary at a patch is where regions change: it is torn, or elsewhere.
    R28 LABELS_WALLS: Unlabelled, "regions inherited at a patch that changes";
}
