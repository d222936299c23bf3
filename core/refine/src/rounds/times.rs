//! The time that each round takes: a timeline shows how a refinement went.

use std::time::Instant;

/// A round on the clock, in seconds since the first one began. Relief and joint steps, which are
/// no rounds, are between these.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundTimes {
    /// The items that it splits: `boundary`, `tetrahedra` or `slivers`; `all` are of the boundary
    /// and inside. A round of `smoothing` moves vertices.
    pub class: &'static str,
    /// Items are looked for from here on.
    pub begin: f64,
    /// The points are chosen.
    pub chosen: f64,
    /// They are inserted, and new tetrahedra looked at.
    pub end: f64,
    /// The points proposed.
    pub candidates: usize,
    /// The points inserted.
    pub points: usize,
}

/// The clock of the rounds.
#[derive(Debug)]
pub(super) struct Clock {
    start: Instant,
    begin: f64,
    chosen: f64,
    pub(super) rounds: Vec<RoundTimes>,
}

impl Clock {
    pub(super) fn start() -> Self {
        Self { start: Instant::now(), begin: 0.0, chosen: 0.0, rounds: Vec::new() }
    }

    pub(super) fn now(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// A round begins.
    pub(super) fn begin(&mut self) {
        self.begin = self.now();
    }

    /// Its points are chosen.
    pub(super) fn choose(&mut self) {
        self.chosen = self.now();
    }

    /// It has ended.
    pub(super) fn end(&mut self, class: &'static str, candidates: usize, points: usize) {
        let (begin, chosen, end) = (self.begin, self.chosen, self.now());
        self.rounds.push(RoundTimes { class, begin, chosen, end, candidates, points });
    }
}
