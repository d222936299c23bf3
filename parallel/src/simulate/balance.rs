//! A simple load balancer: a worker that runs out of points says so to a few others; one that has
//! more gives it a block.
//!
//! The load of a worker is the number of its points that are still to be inserted. Every message
//! carries the sender's load, so that workers know of each other; a worker with nearly none left
//! asks those that it believes to have most. The donor decides: the block that evens out the two
//! loads best, if it is not locked at that moment.

use crate::metrics::Nanos;
use crate::protocol::{BlockId, Conduct, Source, Submesh, Worker, WorkerId};

/// The balancer's settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Balance {
    /// A worker with fewer points left asks for more.
    pub low: u64,
    /// How many others it asks.
    pub ask: usize,
    /// How long it waits before it asks again.
    pub again: Nanos,
}

impl Default for Balance {
    fn default() -> Self {
        Self { low: 64, ask: 2, again: 1_000_000 }
    }
}

/// What a balancer must know of a supply of points.
pub trait Stock {
    /// Points left.
    fn len(&self) -> u64;

    /// Are there none?
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Points left in `block`.
    fn in_block(&self, block: BlockId) -> u64;
}

/// One worker's view of the others' loads, and its decisions.
#[derive(Clone, Debug)]
pub struct Balancer {
    settings: Balance,
    me: WorkerId,
    loads: Vec<u64>,
}

impl Balancer {
    /// The balancer of worker `me`, which believes that all have as much as itself.
    pub fn new(settings: Balance, me: WorkerId, workers: usize, load: u64) -> Self {
        Self { settings, me, loads: vec![load; workers] }
    }

    /// Worker `from` has `load` points left.
    pub fn heard(&mut self, from: WorkerId, load: u64) {
        if let Some(entry) = self.loads.get_mut(from as usize) {
            *entry = load;
        }
    }

    /// The workers to ask for more, if `load` is all that is left here.
    pub fn ask(&self, load: u64) -> Vec<WorkerId> {
        if load >= self.settings.low {
            return Vec::new();
        }
        let me = self.me as usize;
        let workers = self.loads.len();
        // From the next worker on, so that not all ask the same ones.
        let mut others: Vec<usize> = (1..workers).map(|k| (me + k) % workers).collect();
        others.retain(|&w| self.loads[w] > 2 * self.settings.low);
        others.sort_by_key(|&w| std::cmp::Reverse(self.loads[w]));
        others.truncate(self.settings.ask);
        others.into_iter().map(|w| w as WorkerId).collect()
    }

    /// The block that `worker` should give to `to`, which has asked for it.
    pub fn give<S: Submesh, Q: Source<S> + Stock, C: Conduct>(
        &mut self,
        worker: &Worker<S, Q, C>,
        to: WorkerId,
    ) -> Option<BlockId> {
        let mine = worker.source().len();
        let theirs = *self.loads.get(to as usize)?;
        let spare = mine.saturating_sub(theirs);
        if mine <= 2 * self.settings.low || spare < self.settings.low {
            return None;
        }
        let directory = worker.directory();
        let mut blocks: Vec<(u64, BlockId)> = (0..directory.blocks())
            .filter(|&b| directory.is_mine(b))
            .map(|b| (worker.source().in_block(b), b))
            .filter(|&(points, _)| points > 0 && points < spare)
            .collect();
        blocks.sort_by_key(|&(points, block)| (points.abs_diff(spare / 2), block));
        let block = blocks.into_iter().take(8).find(|&(_, b)| worker.can_migrate(b))?;
        self.loads[to as usize] = theirs + block.0;
        Some(block.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn asks_those_with_most() {
        let mut balancer = Balancer::new(Balance { low: 10, ask: 2, again: 1 }, 1, 5, 100);
        assert_eq!(balancer.ask(50), [] as [WorkerId; 0]);
        assert_eq!(balancer.ask(9), [2, 3], "the next ones, if all have the same");
        balancer.heard(0, 700);
        balancer.heard(2, 20);
        balancer.heard(3, 200);
        assert_eq!(balancer.ask(0), [0, 3]);
        (0..5).for_each(|w| balancer.heard(w, 20));
        assert_eq!(balancer.ask(0), [] as [WorkerId; 0], "nobody has any to spare");
    }
}
