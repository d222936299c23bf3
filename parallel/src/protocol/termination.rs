//! Termination detection: Safra's counts and colours (Dijkstra, EWD 998, 1987), in waves over a tree.
//!
//! A worker is *passive* when it has no operation, no point and nothing to start. Every worker
//! counts basic messages sent less received, and turns black when it receives one. In each wave a
//! passive worker that has heard from the workers below it in a binary tree adds its count and
//! colour to theirs, turns white, and tells the worker above. A white wave with sum zero proves that
//! all are passive and no message is under way; after another one worker 0 has the next one start.
//!
//! In a white wave no worker has received anything since it spoke in the wave before, when it was
//! passive: it has sent nothing either, and its count is what it was when the wave before ended. So
//! all were passive then, and the counts are those of one moment. (A ring, as in EWD 998, takes as
//! many messages one after the other as there are workers.)

use super::directory::WorkerId;
use super::rules::Rules;

/// What some workers add to a wave; down the tree, nothing: the next wave starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Token {
    /// Messages sent less received, of these workers.
    pub count: i64,
    /// Has one of them received a message since the last wave?
    pub black: bool,
}

/// The state of one worker.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Safra {
    me: WorkerId,
    workers: u32,
    count: i64,
    black: bool,
    /// It has still to speak in this wave.
    is_due: bool,
    /// The workers below that have still to speak in this wave, and what the others have said.
    awaited: u32,
    below: Token,
}

/// The next step of a passive worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pass {
    Nothing,
    Up(WorkerId, Token),
    /// The next wave starts.
    Again,
    Terminated,
}

impl Safra {
    pub(crate) fn new(me: WorkerId, workers: u32) -> Self {
        // Worker 0 is black: the first wave proves nothing.
        let black = me.parent().is_none();
        let awaited = me.children(workers).count() as u32;
        Self { me, workers, count: 0, black, is_due: true, awaited, below: Token::default() }
    }

    pub(crate) fn sent(&mut self) {
        self.count += 1;
    }

    pub(crate) fn received<C: Rules>(&mut self) {
        self.count -= 1;
        // R8
        self.black |= C::BLACKENS;
    }

    /// Takes a token. Returns whether it came from above: the next wave starts, also below.
    pub(crate) fn arrived(&mut self, from: WorkerId, token: Token) -> bool {
        let is_from_above = self.me.parent() == Some(from);
        if is_from_above {
            self.is_due = true;
        } else {
            self.awaited -= 1;
            self.below.add(token);
        }
        is_from_above
    }

    /// Back to the state at the start, for models without termination detection.
    pub(crate) fn forget(&mut self) {
        *self = Self::new(self.me, self.workers);
    }

    /// Counted messages sent less received.
    pub(crate) fn count(&self) -> i64 {
        self.count
    }

    /// Has it something to say as soon as it is passive?
    pub(crate) fn may_speak(&self) -> bool {
        self.is_due && self.awaited == 0
    }

    /// Called when the worker is passive.
    pub(crate) fn pass(&mut self) -> Pass {
        if !self.may_speak() {
            return Pass::Nothing;
        }
        let mut all = self.below;
        all.add(Token { count: self.count, black: self.black });
        let root = self.me.parent().is_none();
        if root && (all == Token::default() || self.workers == 1) {
            return Pass::Terminated;
        }
        // Worker 0 is to speak in the next wave, the others when they hear of it.
        let waves = Self::new(self.me, self.workers);
        *self = Self { count: self.count, black: false, is_due: root, ..waves };
        self.me.parent().map_or(Pass::Again, |above| Pass::Up(above, all))
    }
}

impl Token {
    fn add(&mut self, other: Self) {
        self.count += other.count;
        self.black |= other.black;
    }
}
