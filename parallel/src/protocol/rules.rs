//! The rules of the protocol, one question each: all that the models show to be necessary.
//!
//! [`Correct`] keeps them all and is what ships. A checker implements [`Rules`] for a type that
//! breaks one of them, a known-bad variant, and must find the defect (`verify/models`). The
//! answers of [`Correct`] are known when the code is compiled: the shipped code pays nothing and
//! holds no switch. The numbers of rules stand in `docs/protocol.md`, beside the code that obeys,
//! and on the variant that breaks; `tests/tests/rules.rs` holds these to each other.

/// Declares the rules: each a function that says that it is kept.
macro_rules! rules {
    ($($(#[$doc:meta])* fn $rule:ident;)*) => {
        /// Rules of the protocol. Every default is the correct one.
        pub trait Rules: 'static {
            $($(#[$doc])* #[inline] fn $rule() -> bool { true })*
        }
    };
}

rules! {
    /// R1: the ring of face neighbours is locked, not the cavity alone.
    fn locks_ring;
    /// R2: a setback releases every lock.
    fn releases_all;
    /// R3: a setback wakes all that wait for its locks.
    fn wakes_on_abort;
    /// R4: a released lock makes all that wait for it apply the rule anew, not the oldest alone.
    fn regrant_asks_all;
    /// R5: what an `Expand` adds to a stalled request goes beneath the want it waits for.
    fn keeps_place;
    /// R6: an operation starts again only when all its releases are acknowledged.
    fn awaits_releases;
    /// R7: a wound that arrives after the commit point is ignored.
    fn ignores_late_wound;
    /// R8: a worker that receives a counted message turns black (termination detection).
    fn blackens;
    /// R9: only a worker with work of its own gives blocks away.
    fn only_busy_migrate;
    /// R10: a message for a block that has moved goes on to its new owner, or back with the news.
    fn forwards;
    /// R11: when a block moves, all that wait for its tetrahedra to be installed are told.
    fn moves_waiters;
    /// R12: a commit updates the handles of other workers' ring tetrahedra.
    fn relinks_interface;
    /// R13: no name is given twice. (The submesh obeys.)
    fn fresh_names;
    /// R14: an `Expand` that names a tetrahedron which is not installed yet waits for it.
    fn awaits_installation;
    /// R15: a worker that was told of a cancel drops the points of a block that moves to it.
    fn stays_cancelled;
    /// R16: a worker that gives a block away asks from then on whose the tetrahedra beside it are
    /// that it makes. (The submesh obeys.)
    fn leaves_blocks;
    /// R17: a worker tests its inbox and goes to sleep in one critical section. (The mailbox
    /// obeys.)
    fn tests_before_sleep;
    /// R18: a point whose item is gone is let go, never inserted elsewhere.
    fn lets_go;
    /// R19: a round is over when two waves in a row count the same messages about operations, and
    /// all that were sent are taken.
    fn awaits_second_wave;
    /// R20: keys that are told in a later exchange wait for it.
    fn numbers_exchanges;
    /// R21: nobody decides before all cavities are reserved.
    fn awaits_reservations;
    /// R22: a candidate's rank comes from the coordinates of its corners, from no name or number.
    fn ranks_by_place;
    /// R23: a candidate at the boundary hears of the rivals in all parts of its closure.
    fn hears_of_rivals;
    /// R24: an item that waits takes back what it has reserved, everywhere.
    fn takes_back;
    /// R25: a probe takes in its whole closure, whatever it has found before.
    fn ends_probes;
    /// R26: of two candidates of one size one comes first, by its corners.
    fn breaks_ties;
    /// R27: a cavity found ahead is taken only if nothing of its closure was written since.
    fn checks_ahead;
    /// R28: a point that changes a patch brings along the regions that tetrahedra at some walls of
    /// its cavity get in place of those that they would inherit.
    fn labels_walls;
    /// R29: before the next round all know which boundary items were refused in this one.
    fn tells_refusals;
    /// R30: of the foremost tetrahedra with nearly equal circumspheres one is probed, whosever they
    /// are.
    fn shares_leaders;
    /// R31: those beyond an interface face hear that a tetrahedron was refused and has no rank.
    fn withdraws_ranks;
    /// R32: all workers keep a block that one has found, before the choice of its round ends.
    fn shares_blocks;
    /// R33: before the next round all know beside which blocks tetrahedra are gone.
    fn forgets_blocks;
    /// R34: a worker lends all of its tetrahedra at each vertex asked for, around circles.
    fn lends_stars;
    /// R35: tetrahedra that circles make get the regions that the conductor tells.
    fn labels_circles;
    /// R36: at patches the turn of an item's last attempt, which may have no point, keeps the
    /// carrier of the one before.
    fn keeps_carrier;
}

/// The protocol as it ships.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Correct;

impl Rules for Correct {}
