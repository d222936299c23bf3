//! The rules of the protocol, one question each: all that the models show to be necessary.
//!
//! [`Correct`] keeps them all and is what ships. A checker implements [`Rules`] for a type that
//! breaks one of them, a known-bad variant, and must find the defect (`verify/models`). The
//! answers of [`Correct`] are known when the code is compiled: the shipped code pays nothing and
//! holds no switch. Their numbers stand in `docs/protocol.md`, beside the code that obeys, and on the
//! variant that breaks; `tests/tests/rules.rs` holds these to each other.

/// Rules of the protocol. Every default is the correct one.
pub trait Rules: 'static {
    /// R1: the ring of face neighbours is locked, not the cavity alone.
    #[inline]
    fn locks_ring() -> bool {
        true
    }
    /// R2: a setback releases every lock.
    #[inline]
    fn releases_all() -> bool {
        true
    }
    /// R3: a setback wakes all that wait for its locks.
    #[inline]
    fn wakes_on_abort() -> bool {
        true
    }
    /// R4: a released lock makes all that wait for it apply the rule anew, not the oldest alone.
    #[inline]
    fn regrant_asks_all() -> bool {
        true
    }
    /// R5: what an `Expand` adds to a stalled request goes beneath the want it waits for.
    #[inline]
    fn keeps_place() -> bool {
        true
    }
    /// R6: an operation starts again only when all its releases are acknowledged.
    #[inline]
    fn awaits_releases() -> bool {
        true
    }
    /// R7: a wound that arrives after the commit point is ignored.
    #[inline]
    fn ignores_late_wound() -> bool {
        true
    }
    /// R8: a worker that receives a counted message turns black (termination detection).
    #[inline]
    fn blackens() -> bool {
        true
    }
    /// R9: only a worker with work of its own gives blocks away.
    #[inline]
    fn only_busy_migrate() -> bool {
        true
    }
    /// R10: a message for a block that has moved goes on to its new owner, or back with the news.
    #[inline]
    fn forwards() -> bool {
        true
    }
    /// R11: when a block moves, all that wait for its tetrahedra to be installed are told.
    #[inline]
    fn moves_waiters() -> bool {
        true
    }
    /// R12: a commit updates the handles of other workers' ring tetrahedra.
    #[inline]
    fn relinks_interface() -> bool {
        true
    }
    /// R13: no name is given twice. (The submesh obeys.)
    #[inline]
    fn fresh_names() -> bool {
        true
    }
    /// R14: an `Expand` that names a tetrahedron which is not installed yet waits for it.
    #[inline]
    fn awaits_installation() -> bool {
        true
    }
    /// R15: a worker that was told of a cancel drops the points of a block that moves to it.
    #[inline]
    fn stays_cancelled() -> bool {
        true
    }
    /// R16: a worker that gives a block away asks from then on whose the tetrahedra beside it are
    /// that it makes. (The submesh obeys.)
    #[inline]
    fn leaves_blocks() -> bool {
        true
    }
    /// R17: a worker tests its inbox and goes to sleep in one critical section. (The mailbox
    /// obeys.)
    #[inline]
    fn tests_before_sleep() -> bool {
        true
    }
    /// R18: a point whose item is gone is let go, never inserted elsewhere.
    #[inline]
    fn lets_go() -> bool {
        true
    }
    /// R19: insertion ends when two waves in a row have the same sums, and all that was sent is
    /// taken.
    #[inline]
    fn awaits_second_wave() -> bool {
        true
    }
    /// R20: keys that are told in a later exchange wait for it.
    #[inline]
    fn numbers_exchanges() -> bool {
        true
    }
    /// R21: nobody decides before all cavities are reserved.
    #[inline]
    fn awaits_reservations() -> bool {
        true
    }
    /// R22: a candidate's rank comes from the coordinates of its corners, from no name or number.
    #[inline]
    fn ranks_by_place() -> bool {
        true
    }
    /// R23: a candidate at the boundary hears of the rivals in all parts of its closure.
    #[inline]
    fn hears_of_rivals() -> bool {
        true
    }
    /// R24: an item that waits takes back what it has reserved, everywhere.
    #[inline]
    fn takes_back() -> bool {
        true
    }
    /// R25: a probe takes in its whole closure, whatever it has found before.
    #[inline]
    fn ends_probes() -> bool {
        true
    }
    /// R26: of two candidates of one size one comes first, by its corners.
    #[inline]
    fn breaks_ties() -> bool {
        true
    }
    /// R27: a cavity found ahead is taken only if nothing of its closure was written since.
    #[inline]
    fn checks_ahead() -> bool {
        true
    }
    /// R28: a point that changes a patch brings along the regions that tetrahedra at some walls of
    /// its cavity get in place of those that they would inherit.
    #[inline]
    fn labels_walls() -> bool {
        true
    }
    /// R29: a wave of probes begins when those of the waves before it have reserved.
    #[inline]
    fn awaits_waves() -> bool {
        true
    }
}

/// The protocol as it ships.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Correct;

impl Rules for Correct {}
