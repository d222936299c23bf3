//! A simple load balancer: a worker that runs out of points says so to a few others; one that has
//! more gives it blocks.
//!
//! The load of a worker is the number of its points that are still to be inserted. Every message
//! carries the sender's load, so that workers know of each other; a worker with nearly none left
//! asks those that it believes to have most. The donor decides: blocks that even out the two loads,
//! as far as they are not locked at that moment.

use crate::mesh::PointQueue;
use crate::metrics::Nanos;
use crate::protocol::{BlockId, Rules, Source, Submesh, Worker, WorkerId};

/// The balancer's settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Balance {
    /// A worker with fewer points left asks for more.
    pub low: u64,
    /// The number of others that it asks.
    pub ask: usize,
    /// The time before it asks again; each time twice as long, up to 65536 times.
    pub again: Nanos,
}

impl Default for Balance {
    fn default() -> Self {
        Self { low: 64, ask: 2, again: 200_000 }
    }
}

/// A supply of points, as a balancer must know it.
pub trait Workload {
    /// Points left.
    fn left(&self) -> u64;

    /// Points left in `block`.
    fn in_block(&self, block: BlockId) -> u64;

    /// Points given so far; 0 if nobody counts them, and then blocks move to the very end.
    fn given(&self) -> u64 {
        0
    }

    /// Do others wait for what this worker says? It looks for messages after each point then.
    fn is_waited_for(&self) -> bool {
        false
    }

    /// Is it worth while to move `block`, which has `points` left? Its mesh moves along: a block
    /// that is nearly done costs more on its way than its points do where it is.
    fn is_worth_moving(&self, block: BlockId, points: u64) -> bool {
        let _ = block;
        points > 0
    }
}

impl Workload for PointQueue {
    fn left(&self) -> u64 {
        PointQueue::left(self) as u64
    }

    fn in_block(&self, block: BlockId) -> u64 {
        PointQueue::in_block(self, block) as u64
    }

    fn given(&self) -> u64 {
        PointQueue::given(self) as u64
    }

    fn is_worth_moving(&self, block: BlockId, points: u64) -> bool {
        points > 0 && 2 * points >= self.size_of(block) as u64
    }
}

/// One worker's view of the others' loads, and its decisions.
#[derive(Clone, Debug)]
pub struct Balancer {
    settings: Balance,
    me: WorkerId,
    loads: Vec<u64>,
    /// The number of times that it has asked since it had more than few points.
    asked: u32,
}

/// A worker gives nothing away if it has inserted more than this many points for each one left ...
const SHORT: u64 = 2;

/// ... and has fewer than these left: the cost was measured with such numbers. The cost grows with
/// the surface of a block, the saving with its volume.
const FEW: u64 = 1 << 15;

/// The supposed load of a worker before the first message from it, in units of a low load.
const UNKNOWN: u64 = 4096;

impl Balancer {
    /// The balancer of worker `me`, which knows nothing of the others.
    pub fn new(settings: Balance, me: WorkerId, workers: usize) -> Self {
        let loads = vec![settings.low.saturating_mul(UNKNOWN); workers];
        Self { settings, me, loads, asked: 0 }
    }

    /// Is `load` little? If not, the next time that it is this worker asks at once.
    pub fn is_low(&mut self, load: u64) -> bool {
        let low = load < self.settings.low;
        if !low {
            self.asked = 0;
        }
        low
    }

    /// The time to wait before asking, now that the load is low: not at all the first time, then
    /// each time twice as long.
    pub fn pause(&mut self) -> Nanos {
        let pause = match self.asked {
            0 => 0,
            times => self.settings.again.saturating_mul(1 << (times - 1).min(16)),
        };
        self.asked += 1;
        pause
    }

    /// Worker `from` has `load` points left.
    pub fn heard(&mut self, from: WorkerId, load: u64) {
        if let Some(entry) = self.loads.get_mut(from.index()) {
            *entry = load;
        }
    }

    /// The workers to ask for more, if `load` is all that is left here. A worker that is asked
    /// counts with half its load until a message comes from it, so that others get their turn.
    pub fn ask(&mut self, load: u64) -> Vec<WorkerId> {
        if load >= self.settings.low {
            return Vec::new();
        }
        let me = self.me.index();
        let workers = self.loads.len();
        // From the next worker on, so that not all ask the same ones.
        let mut others: Vec<usize> = (1..workers).map(|k| (me + k) % workers).collect();
        others.retain(|&w| self.loads[w] > 2 * self.settings.low);
        others.sort_by_key(|&w| std::cmp::Reverse(self.loads[w]));
        others.truncate(self.settings.ask);
        others.iter().for_each(|&w| self.loads[w] /= 2);
        others.into_iter().map(WorkerId::at).collect()
    }

    /// The blocks that `worker` should give to `to`, which has asked for some.
    pub fn give<S: Submesh, Q: Source<S> + Workload, C: Rules>(
        &mut self,
        worker: &Worker<S, Q, C>,
        to: WorkerId,
    ) -> Vec<BlockId> {
        let mine = worker.source().left();
        let theirs = self.loads.get(to.index()).copied().unwrap_or(mine);
        let mut spare = mine.saturating_sub(theirs) / 2;
        if mine <= 2 * self.settings.low || spare < self.settings.low / 2 {
            return Vec::new();
        }
        // The asking worker was busy with its own points for as long as this one was with those it
        // has inserted so far. If the points left take much less time, a block saves less than
        // its new interfaces cost.
        if mine < FEW && mine.saturating_mul(SHORT) < worker.source().given() {
            return Vec::new();
        }
        let directory = worker.directory();
        let mut given = Vec::new();
        // From one end of the curve on: the blocks that go are connected, and so are those that
        // stay.
        for block in directory.blocks().rev().filter(|&b| directory.is_mine(b)) {
            let points = worker.source().in_block(block);
            let is_due = points <= spare && worker.source().is_worth_moving(block, points);
            if is_due && worker.can_migrate(block) {
                spare -= points;
                self.loads[to.index()] += points;
                given.push(block);
            }
        }
        given
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Layout;
    use crate::protocol::Config;
    use ltbw_exact::PointSet;
    use ltbw_generate::{PointKind, generate};

    #[test]
    fn who_has_nearly_done_gives_nothing() {
        let set = PointSet::new(generate(PointKind::Uniform, 6000, 1)).expect("finite points");
        let layout = Layout { sample: 60, ..Layout::new(6000, 2) };
        let gives = |done: u64| {
            let prepared = layout.distribute(&set).expect("a start");
            let (directory, mesh, mut field) = prepared.workers.into_iter().next().expect("one");
            for _ in 0..done {
                let vertex = field.next(&mesh).expect("a point");
                field.inserted(&mesh, &vertex);
            }
            let all = field.left() as u64 + done;
            let worker: Worker<_, _> = Worker::new(Config::new(2), directory, mesh, field);
            let mut balancer = Balancer::new(Balance::default(), WorkerId::default(), 2);
            balancer.heard(WorkerId::new(1), 0);
            (all, !balancer.give(&worker, WorkerId::new(1)).is_empty())
        };
        let (all, at_once) = gives(0);
        // Twice what is left is the last time.
        let (_, late) = gives(2 * all / 3);
        let (_, too_late) = gives(2 * all / 3 + 2);
        assert_eq!((at_once, late, too_late), (true, true, false));
    }

    #[test]
    fn asks_those_with_most() {
        let mut balancer =
            Balancer::new(Balance { low: 10, ask: 2, again: 1 }, WorkerId::new(1), 5);
        let ids = |numbers: [u32; 2]| numbers.map(WorkerId::new);
        assert_eq!(balancer.ask(50), []);
        assert_eq!(balancer.ask(9), ids([2, 3]), "the next ones, if nothing is known");
        assert_eq!(balancer.ask(9), ids([4, 0]), "then others");
        (0..)
            .zip([700, 0, 20, 200, 30])
            .for_each(|(w, load)| balancer.heard(WorkerId::new(w), load));
        assert_eq!(balancer.ask(0), ids([0, 3]));
        (0..5).for_each(|w| balancer.heard(WorkerId::new(w), 20));
        assert_eq!(balancer.ask(0), [], "nobody has any to spare");
    }
}
