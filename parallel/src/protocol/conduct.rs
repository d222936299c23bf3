//! The protocol's conduct: one constant for each rule that the models show to be necessary.
//!
//! [`Sound`] keeps them all and is what ships. A checker implements [`Conduct`] for a type that
//! breaks one rule, and must find the defect: `verify/models` has the museum. The constants are
//! known when the code is compiled, so that sound code pays nothing and holds no switch.

/// Rules of the protocol. Every default is the sound one.
pub trait Conduct: 'static {
    /// The ring of face neighbours is locked, not the cavity alone.
    const LOCKS_RING: bool = true;
    /// A setback releases every lock.
    const RELEASES_ALL: bool = true;
    /// A setback wakes those who wait for its locks.
    const WAKES_ON_ABORT: bool = true;
    /// A released lock makes all who wait for it apply the rule anew, not the oldest alone.
    const REGRANT_ASKS_ALL: bool = true;
    /// What an `Expand` adds to a stalled request goes beneath the want that the request waits for.
    const KEEPS_PLACE: bool = true;
    /// An operation starts again only when all its releases are acknowledged.
    const AWAITS_RELEASES: bool = true;
    /// A wound that arrives after the commit point is ignored.
    const IGNORES_LATE_WOUND: bool = true;
    /// A worker that receives a message turns black (termination detection).
    const BLACKENS: bool = true;
    /// Only a worker with work of its own gives blocks away.
    const ONLY_BUSY_MIGRATE: bool = true;
    /// A message for a block that has moved goes on to its new owner.
    const FORWARDS: bool = true;
    /// When a block moves, requests that wait for its tetrahedra to be installed are told.
    const MOVES_WAITERS: bool = true;
    /// A commit updates the handles of other workers' ring tetrahedra.
    const RELINKS_INTERFACE: bool = true;
    /// No name is given twice. (The submesh obeys this one.)
    const FRESH_NAMES: bool = true;
    /// An `Expand` that names a tetrahedron which is not installed yet waits for it.
    const AWAITS_INSTALLATION: bool = true;
    /// A worker that was told of a cancel drops the points of a block that moves to it.
    const STAYS_CANCELLED: bool = true;
    /// A worker that gives a block away asks from then on whose the tetrahedra beside it are that
    /// it makes. (The submesh obeys this one.)
    const LEAVES_BLOCKS: bool = true;
    /// A worker tests its inbox and goes to sleep in one critical section. (The mailbox obeys.)
    const TESTS_BEFORE_SLEEP: bool = true;
}

/// The protocol as it ships.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sound;

impl Conduct for Sound {}
