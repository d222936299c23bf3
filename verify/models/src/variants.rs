//! Known-bad variants: the protocol with one rule of `docs/protocol.md` broken. Each must be caught
//! by a checker; `tests/variants.rs` says by which, and after how much work.
//!
//! One type, [`KnownBad`], has all of them, and is told when it runs which one it is: a type each
//! would have the compiler make the workers and all models once for every defect.

use ltbw::protocol::Rules;
use std::cell::Cell;
use std::fmt::Debug;
use std::hash::Hash;

/// Rules that models can explore.
pub trait Variant: Rules + Clone + Debug + PartialEq + Eq + Hash + Send + Sync {}

impl<C: Rules + Clone + Debug + PartialEq + Eq + Hash + Send + Sync> Variant for C {}

/// All rules but one, that of the [`Defect`] which is planted.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct KnownBad;

thread_local! {
    static PLANTED: Cell<Option<Defect>> = const { Cell::new(None) };
}

impl Defect {
    /// Runs something with this defect in [`KnownBad`]: on this thread, and so on the threads of
    /// loom and shuttle, which run on the one that began.
    pub fn planted<T>(self, run: impl FnOnce() -> T) -> T {
        struct Back(Option<Defect>);
        impl Drop for Back {
            fn drop(&mut self) {
                PLANTED.set(self.0);
            }
        }
        let _back = Back(PLANTED.replace(Some(self)));
        run()
    }
}

/// Declares variants: the number of the broken rule and its name, a defect and a title.
macro_rules! variants {
    ($($(#[$doc:meta])* $number:ident $rule:ident: $variant:ident, $title:literal;)*) => {
        /// The defect of a known-bad variant.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Defect {
            $($(#[$doc])* $variant,)*
        }

        impl Defect {
            /// The number of the rule that is broken.
            pub const fn rule(self) -> &'static str {
                match self {
                    $(Self::$variant => stringify!($number),)*
                }
            }

            /// A few words for the defect.
            pub const fn title(self) -> &'static str {
                match self {
                    $(Self::$variant => $title,)*
                }
            }
        }

        impl Rules for KnownBad {
            $(fn $rule() -> bool {
                PLANTED.get() != Some(Defect::$variant)
            })*
        }
    };
}

variants! {
    /// Two cavities that share no cell can share a ring cell, and leave a hull that is not convex.
    R1 locks_ring: BareCavity, "closure ring not locked";
    /// A lock stays behind with a holder that no longer exists.
    R2 releases_all: LeakyRollback, "rollback leaks a lock";
    /// Requests that waited for the locks that a setback gave back sleep for ever.
    R3 wakes_on_abort: ForgetfulRollback, "rollback forgets the queue";
    /// The others keep waiting for a holder that they were never compared with, or for nobody.
    R4 regrant_asks_all: NaiveRegrant, "only the oldest is woken";
    /// A request that is asked again while it waits for a lock turns to the new wants when the lock
    /// is released, and a younger operation takes the lock: it can be wounded for it again and
    /// again.
    R5 keeps_place: LostPlace, "new wants above the one waited for";
    /// The next attempt meets its own last one.
    R6 awaits_releases: HastyRestart, "restart before the releases are acknowledged";
    /// A committed operation is set back, of which nothing is left at its home. (A home that kept
    /// it would do no harm: with channels in order its `Abort` finds nothing to release, and its
    /// second walk finds the point as a vertex.)
    R7 ignores_late_wound: LateWound, "wound after commit obeyed";
    /// A wave misses a message that was taken behind its back.
    R8 blackens: WhiteSafra, "Safra without blackening";
    /// A passive worker sends a message: what termination detection rests on is gone.
    R9 only_busy_migrate: IdleMigration, "migration by an idle worker";
    /// Messages to a block that has moved are dropped.
    R10 forwards: NoForwarding, "missing forward pointer";
    /// Requests wait for an installation that takes place elsewhere.
    R11 moves_waiters: LeftWaiters, "waiters not moved";
    /// Ring cells keep links to deleted cells.
    R12 relinks_interface: StaleInterface, "stale interface handle";
    /// A slot's number, without a generation, names two cells.
    R13 fresh_names: ReusedName, "reused slot without generation";
    /// A seed that is not installed yet is taken for nothing.
    R14 awaits_installation: ImpatientExpand, "Expand before installation not held";
    /// A cancelled worker goes on with the points of a block that moves to it.
    R15 stays_cancelled: RestlessCancel, "cancelled worker takes in moved points";
    /// Beside a block that has left, tetrahedra are made that belong to it and stay behind.
    R16 leaves_blocks: KeptHome, "block that left taken for one's own";
    /// A worker tests its inbox in one critical section and goes to sleep in another.
    R17 tests_before_sleep: LostWakeUp, "lost wake-up";
    /// The circumcentre of a tetrahedron that is gone may lie next to a vertex.
    R18 lets_go: Obstinate, "point inserted though its item is gone";
    /// The sums fit by chance while a commit is under way.
    R19 awaits_second_wave: OneWave, "one wave ends a round";
    /// Keys of a second exchange are taken in the first, and awaited for ever in the second.
    R20 numbers_exchanges: NamelessKeys, "exchanges without a number";
    /// A home decides while another one still reserves.
    R21 awaits_reservations: NoBarrier, "decided before all is reserved";
    /// The foremost candidate depends on how a submesh numbers its vertices.
    R22 ranks_by_place: KeyByName, "ranks from numbers of vertices";
    /// Two points are inserted beside one another, each in its own facet.
    R23 hears_of_rivals: DeafHome, "rivals elsewhere not heard of";
    /// Nobody gets the cavity of an item that waits.
    R24 takes_back: StaleReservation, "reservations of items that wait stay";
    /// The item that a tetrahedron asks for depends on whose parts it has seen.
    R25 ends_probes: HastyProbe, "probe stopped at its first veto";
    /// Two neighbours of about one size, each the one to be split.
    R26 breaks_ties: EqualKeys, "of equal keys both chosen";
    /// Another worker's point, inserted meanwhile, has changed the cavity.
    R27 checks_ahead: RashChoice, "cavity found ahead taken as it was";
    /// The boundary at a patch is where regions change: it is torn, or elsewhere.
    R28 labels_walls: Unlabelled, "regions inherited at a patch that changes";
    /// A tetrahedron asks in vain for an item that cannot be split.
    R29 tells_refusals: SilentKeeper, "refusals not told";
    /// Two workers probe tetrahedra of which one would do.
    R30 shares_leaders: OwnLeader, "each worker has a leader of its own";
    /// A tetrahedron beside one that was refused waits for it.
    R31 withdraws_ranks: LastingRank, "ranks of what was refused stay";
    /// A tetrahedron is probed that others have reason to refuse.
    R32 shares_blocks: OwnBlocks, "blocks not told";
    /// Tetrahedra are refused for a subface that bars them no more.
    R33 forgets_blocks: LastingBlock, "blocks that are gone stay";
    /// A vertex has tetrahedra that the conductor does not know of.
    R34 lends_stars: StingyLender, "lent what lies in the balls alone";
    /// Regions have leaked where the boundary was not complete in between.
    R35 labels_circles: LeakyCircle, "regions inherited in circles";
    /// An item for which no point does waits for those of its own facet that come before it.
    R36 keeps_carrier: Nowhere, "last attempt told without its carrier";
}
