//! Termination detection: Safra's counts and colours (Dijkstra, EWD 998, 1987), over a tree.
//!
//! A worker is *passive* when it has no operation, no point and nothing to start. Every worker
//! counts basic messages sent less received, and turns black when it receives one. In each wave a
//! passive worker that has heard from the workers below it in a tree adds its count and
//! colour to theirs, turns white, and tells the worker above. A white wave with sum 0 proves that
//! all are passive and no message is under way; after another one worker 0 has the next one start.
//!
//! In a white wave no worker has received anything since it spoke in the wave before, when it was
//! passive: it has sent nothing either, and its count is what it was when the wave before ended. So
//! all were passive then, and the counts are those of one moment. (A ring, as in EWD 998, takes as
//! many messages one after the other as there are workers.)

use super::directory::WorkerId;
use super::invariant;
use super::rules::Rules;

/// The sums of some workers in a wave; down the tree, where a wave starts, 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Token {
    /// Messages sent less received, of these workers.
    pub count: i64,
    /// Has one of them received a message since the last wave?
    pub black: bool,
}

/// One worker's part in the waves that find out whether all have ended.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct TerminationWave {
    me: WorkerId,
    workers: u32,
    count: i64,
    black: bool,
    /// The workers below that have still to speak in this wave; none if it has spoken itself.
    awaited: Option<u32>,
    /// The sums of those below that have spoken.
    below: Token,
}

/// The next step of a worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pass {
    Nothing,
    Up(WorkerId, Token),
    /// The next wave starts: those below are to be told.
    Again,
    Terminated,
}

impl TerminationWave {
    pub(crate) fn new(me: WorkerId, workers: u32) -> Self {
        // Worker 0 is black: the first wave proves nothing.
        let black = me.parent().is_none();
        let awaited = Some(me.children(workers).count() as u32);
        Self { me, workers, count: 0, black, awaited, below: Token::default() }
    }

    pub(crate) fn sent(&mut self) {
        self.count += 1;
    }

    pub(crate) fn received<C: Rules>(&mut self) {
        self.count -= 1;
        // R8
        self.black |= C::blackens();
    }

    /// Takes a token: from above, it starts the next wave; from below, it is part of this one.
    pub(crate) fn arrived(&mut self, from: WorkerId, token: Token) -> Pass {
        if self.me.parent() == Some(from) {
            return self.start_wave();
        }
        self.awaited = self.awaited.and_then(|awaited| awaited.checked_sub(1));
        invariant!(P10, self.awaited.is_some(), "worker {from} speaks twice in a wave");
        self.below.count += token.count;
        self.below.black |= token.black;
        Pass::Nothing
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
        self.awaited == Some(0)
    }

    /// Called when the worker is passive.
    pub(crate) fn pass(&mut self) -> Pass {
        if !self.may_speak() {
            return Pass::Nothing;
        }
        let Token { count, black } = std::mem::take(&mut self.below);
        let all = Token { count: count + self.count, black: black || self.black };
        (self.black, self.awaited) = (false, None);
        match self.me.parent() {
            Some(above) => Pass::Up(above, all),
            None if all == Token::default() || self.workers == 1 => Pass::Terminated,
            None => self.start_wave(),
        }
    }

    fn start_wave(&mut self) -> Pass {
        self.awaited = Self::new(self.me, self.workers).awaited;
        Pass::Again
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::Correct;
    use std::collections::VecDeque;

    /// Waves among passive workers until worker 0 knows that all is done; how many there were.
    fn waves(all: &mut [TerminationWave]) -> usize {
        let workers = all.len() as u32;
        let mut mail: VecDeque<(WorkerId, WorkerId, Token)> = VecDeque::new();
        let mut waves = 1;
        loop {
            for me in WorkerId::below(workers) {
                match all[me.index()].pass() {
                    Pass::Nothing => {}
                    Pass::Up(to, token) => mail.push_back((me, to, token)),
                    Pass::Again => {
                        waves += 1;
                        mail.extend(me.children(workers).map(|to| (me, to, Token::default())));
                    }
                    Pass::Terminated => return waves,
                }
            }
            let (from, to, token) = mail.pop_front().expect("somebody speaks");
            if all[to.index()].arrived(from, token) == Pass::Again {
                mail.extend(to.children(workers).map(|below| (to, below, Token::default())));
            }
        }
    }

    #[test]
    fn the_second_wave_proves_that_nothing_is_under_way() {
        for workers in [2, 3, 16, 17, 18, 100, 300] {
            let mut all: Vec<TerminationWave> =
                WorkerId::below(workers).map(|me| TerminationWave::new(me, workers)).collect();
            assert_eq!(waves(&mut all), 2, "{workers}");
            // A message that was taken before the first wave is no matter in the second.
            let mut all: Vec<TerminationWave> =
                WorkerId::below(workers).map(|me| TerminationWave::new(me, workers)).collect();
            all[0].sent();
            all[1].received::<Correct>();
            assert_eq!(waves(&mut all), 2, "{workers}");
        }
        assert_eq!(TerminationWave::new(WorkerId::default(), 1).pass(), Pass::Terminated);
    }
}
