//! The rules of the protocol, one constant each: all that the models show to be necessary.
//!
//! [`Correct`] keeps them all and is what ships. A checker implements [`Rules`] for a type that
//! breaks one of them, a known-bad variant, and must find the defect (`verify/models`). The
//! constants are known when the code is compiled: the shipped code pays nothing and holds no
//! switch. Their numbers stand in `docs/protocol.md`, beside the code that obeys, and on the
//! variant that breaks; `tests/tests/rules.rs` holds these to each other.

/// Rules of the protocol. Every default is the correct one.
pub trait Rules: 'static {
    /// R1: the ring of face neighbours is locked, not the cavity alone.
    const LOCKS_RING: bool = true;
    /// R2: a setback releases every lock.
    const RELEASES_ALL: bool = true;
    /// R3: a setback wakes all that wait for its locks.
    const WAKES_ON_ABORT: bool = true;
    /// R4: a released lock makes all that wait for it apply the rule anew, not the oldest alone.
    const REGRANT_ASKS_ALL: bool = true;
    /// R5: what an `Expand` adds to a stalled request goes beneath the want it waits for.
    const KEEPS_PLACE: bool = true;
    /// R6: an operation starts again only when all its releases are acknowledged.
    const AWAITS_RELEASES: bool = true;
    /// R7: a wound that arrives after the commit point is ignored.
    const IGNORES_LATE_WOUND: bool = true;
    /// R8: a worker that receives a counted message turns black (termination detection).
    const BLACKENS: bool = true;
    /// R9: only a worker with work of its own gives blocks away.
    const ONLY_BUSY_MIGRATE: bool = true;
    /// R10: a message for a block that has moved goes on to its new owner, or back with the news.
    const FORWARDS: bool = true;
    /// R11: when a block moves, all that wait for its tetrahedra to be installed are told.
    const MOVES_WAITERS: bool = true;
    /// R12: a commit updates the handles of other workers' ring tetrahedra.
    const RELINKS_INTERFACE: bool = true;
    /// R13: no name is given twice. (The submesh obeys.)
    const FRESH_NAMES: bool = true;
    /// R14: an `Expand` that names a tetrahedron which is not installed yet waits for it.
    const AWAITS_INSTALLATION: bool = true;
    /// R15: a worker that was told of a cancel drops the points of a block that moves to it.
    const STAYS_CANCELLED: bool = true;
    /// R16: a worker that gives a block away asks from then on whose the tetrahedra beside it are
    /// that it makes. (The submesh obeys.)
    const LEAVES_BLOCKS: bool = true;
    /// R17: a worker tests its inbox and goes to sleep in one critical section. (The mailbox
    /// obeys.)
    const TESTS_BEFORE_SLEEP: bool = true;
    /// R18: a point whose item is gone is let go, never inserted elsewhere.
    const LETS_GO: bool = true;
    /// R19: insertion ends when two waves in a row have the same sums, and all that was sent is
    /// taken.
    const AWAITS_SECOND_WAVE: bool = true;
    /// R20: keys that are told in a later exchange wait for it.
    const NUMBERS_EXCHANGES: bool = true;
    /// R21: nobody decides before all cavities are reserved.
    const AWAITS_RESERVATIONS: bool = true;
    /// R22: a candidate's rank comes from the coordinates of its corners, from no name or number.
    const RANKS_BY_PLACE: bool = true;
    /// R23: a candidate at the boundary hears of the rivals in all parts of its closure.
    const HEARS_OF_RIVALS: bool = true;
    /// R24: an item that waits takes back what it has reserved, everywhere.
    const TAKES_BACK: bool = true;
    /// R25: a probe takes in its whole closure, whatever it has found before.
    const ENDS_PROBES: bool = true;
    /// R26: of two candidates of one size one comes first, by its corners.
    const BREAKS_TIES: bool = true;
    /// R27: a cavity found ahead is taken only if nothing of its closure was written since.
    const CHECKS_AHEAD: bool = true;
    /// R28: a point that changes a patch brings along the regions that tetrahedra at some walls of
    /// its cavity get in place of those that they would inherit.
    const LABELS_WALLS: bool = true;
}

/// The protocol as it ships.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Correct;

impl Rules for Correct {}
