//! Termination detection: Safra's token ring (Dijkstra, EWD 998, 1987).
//!
//! A worker is *passive* when it has no operation, no point and nothing to start. Every worker
//! counts basic messages sent less received. The token goes round from worker 0 downwards, through
//! passive workers only, and adds the counts; a worker that received a basic message since the
//! token passed is black and blackens it. A white token with sum zero at a white worker 0 proves
//! that all are passive and no message is under way.

use super::directory::WorkerId;
use super::rules::Rules;

/// The token.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Token {
    /// Messages sent less received, of the workers passed.
    pub count: i64,
    /// Has one of them received a message since the last round?
    pub black: bool,
}

/// The state of one worker.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Safra {
    me: WorkerId,
    workers: u32,
    count: i64,
    black: bool,
    /// The token, while it is here.
    token: Option<Token>,
}

/// The next step of a passive worker with the token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pass {
    Nothing,
    On(WorkerId, Token),
    Terminated,
}

impl Safra {
    pub(crate) fn new(me: WorkerId, workers: u32) -> Self {
        // The first token is black: it proves nothing, but starts a round.
        let token = (me == WorkerId::default()).then_some(Token { count: 0, black: true });
        Self { me, workers, count: 0, black: false, token }
    }

    pub(crate) fn sent(&mut self) {
        self.count += 1;
    }

    pub(crate) fn received<C: Rules>(&mut self) {
        self.count -= 1;
        // R8
        self.black |= C::BLACKENS;
    }

    pub(crate) fn arrived(&mut self, token: Token) {
        self.token = Some(token);
    }

    /// Back to the state at the start, for models without termination detection.
    pub(crate) fn forget(&mut self) {
        self.count = 0;
        self.black = false;
    }

    /// Counted messages sent less received.
    pub(crate) fn count(&self) -> i64 {
        self.count
    }

    pub(crate) fn holds_token(&self) -> bool {
        self.token.is_some()
    }

    /// Called when the worker is passive.
    pub(crate) fn pass(&mut self) -> Pass {
        let Some(token) = self.token.take() else { return Pass::Nothing };
        if self.me == WorkerId::default() {
            if !token.black && !self.black && token.count + self.count == 0 || self.workers == 1 {
                return Pass::Terminated;
            }
            self.black = false;
            return Pass::On(WorkerId::new(self.workers - 1), Token { count: 0, black: false });
        }
        let on = Token { count: token.count + self.count, black: token.black || self.black };
        self.black = false;
        Pass::On(WorkerId::new(self.me.number() - 1), on)
    }
}
