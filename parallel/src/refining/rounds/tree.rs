//! A barrier that adds up: what each worker has to say goes up a tree, the sums come down. Of one
//! number it is the largest that comes.
//!
//! Nobody is a barrier ahead of another: a worker hears from those below it only about the barrier
//! that it is at, since the end of that one goes to them through it.

use crate::protocol::{Rules, WorkerId};
use crate::refining::news::Sums;

/// The next thing to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Tell the worker above.
    Up(WorkerId, Sums),
    /// These are the sums of all: tell those below.
    Done(Sums),
}

/// The place of messages about operations that were sent.
pub const SENT: usize = 0;
/// The place of those that were taken.
pub const TAKEN: usize = 1;

/// The place of the number of which the largest one counts; none is below 0.
pub(super) const MOST: usize = 3;

/// Adds what another worker says.
fn add(all: &mut Sums, own: &Sums) {
    for (place, (all, own)) in all.iter_mut().zip(own).enumerate() {
        *all = if place == MOST { *own.max(all) } else { *all + own };
    }
}

/// Has every operation of a round ended, by what a wave and the one before count of messages about
/// operations? One alone may add up by chance, as workers speak at different times (R19).
pub fn is_quiet<C: Rules>(before: Option<Sums>, sums: &Sums) -> bool {
    let is_second = before == Some(*sums) || !C::awaits_second_wave();
    sums[SENT] == sums[TAKEN] && is_second
}

/// One worker's place in the tree.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Tree {
    me: WorkerId,
    workers: u32,
    own: Option<Sums>,
    /// The number of workers below that have spoken, and what they add.
    below: (u32, Sums),
    /// It has said what it has to say, and waits for the sums.
    waits: bool,
}

impl Tree {
    /// The place of worker `me` of `workers`.
    pub fn new(me: WorkerId, workers: u32) -> Self {
        Self { me, workers, own: None, below: Default::default(), waits: false }
    }

    /// The workers below this one.
    pub fn below(&self) -> impl Iterator<Item = WorkerId> + use<> {
        self.me.children(self.workers)
    }

    /// Has this worker said what it has to say?
    pub fn has_put(&self) -> bool {
        self.waits
    }

    /// The barrier is over.
    pub fn release(&mut self) {
        self.waits = false;
    }

    /// Says what this worker has to add.
    pub fn put(&mut self, sums: Sums) -> Option<Step> {
        (self.own, self.waits) = (Some(sums), true);
        self.step()
    }

    /// Takes what a worker below has to add.
    pub fn hear(&mut self, sums: Sums) -> Option<Step> {
        self.below.0 += 1;
        add(&mut self.below.1, &sums);
        self.step()
    }

    fn step(&mut self) -> Option<Step> {
        let own = self.own.filter(|_| self.below.0 as usize == self.below().count())?;
        let (_, mut all) = std::mem::take(&mut self.below);
        add(&mut all, &own);
        self.own = None;
        Some(self.me.parent().map_or(Step::Done(all), |above| Step::Up(above, all)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refining::news::SUMS;

    #[test]
    fn the_root_has_the_sums_of_all() {
        for workers in [1, 2, 3, 16, 17, 18, 100, 300] {
            let mut all: Vec<Tree> =
                (0..workers).map(|me| Tree::new(WorkerId::new(me), workers)).collect();
            let mut own = [0; SUMS];
            let mut done = None;
            // The last ones first, so that all wait for the root; then the other way round.
            for round in 0..2 {
                done = None;
                for k in 0..workers {
                    let me = if round == 0 { workers - 1 - k } else { k };
                    (own[0], own[MOST]) = (i64::from(me + 1), i64::from((me * 7) % workers));
                    let mut step = all[me as usize].put(own);
                    while let Some(Step::Up(to, sums)) = step {
                        step = all[to.index()].hear(sums);
                    }
                    if let Some(Step::Done(sums)) = step {
                        assert!(done.is_none());
                        done = Some([sums[0], sums[MOST]]);
                    }
                }
                let most = (0..workers).map(|me| (me * 7) % workers).max().map(i64::from);
                let sums = Some(i64::from(workers * (workers + 1) / 2)).zip(most);
                assert_eq!(done, sums.map(<[i64; 2]>::from));
            }
            assert!(done.is_some());
        }
    }
}
