//! Two rounds of points in a world: the barriers of `ltbw::refining`, without a choice. Each round
//! a worker asks every other one something, as probes do, and inserts its points only when all
//! answers are there, at every worker.

use crate::hull::Vertex;
use crate::told::Told;
use ltbw::protocol::{Rules, Standing, WorkerId};
use ltbw::refining::{SENT, Step, Sums, TAKEN, Tree, is_quiet};
use std::collections::VecDeque;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Stage {
    Choosing,
    Inserting,
}

/// One worker's part.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Rounds {
    me: WorkerId,
    workers: u32,
    tree: Tree,
    stage: Stage,
    /// Answers to come, once it has asked.
    open: Option<u32>,
    /// The points of the second round, while it is to come.
    second: Option<Vec<Vertex>>,
    is_over: bool,
    before: Option<Sums>,
    out: VecDeque<(WorkerId, Told)>,
}

impl Rounds {
    pub(crate) fn new(me: WorkerId, workers: u32, second: Vec<Vertex>) -> Self {
        Self {
            me,
            workers,
            tree: Tree::new(me, workers),
            stage: Stage::Choosing,
            open: None,
            second: Some(second),
            is_over: false,
            before: None,
            out: VecDeque::new(),
        }
    }

    /// Are the points of its round to be given?
    pub(crate) fn inserts(&self) -> bool {
        self.stage == Stage::Inserting
    }

    pub(crate) fn is_over(&self) -> bool {
        self.is_over
    }

    /// Is it choosing, with something to be read of some mesh?
    pub(crate) fn is_choosing(&self) -> bool {
        !self.is_over && self.stage == Stage::Choosing && !self.tree.has_put()
    }

    /// P12: questions and answers belong to the choice. (A worker that has said at the end of its
    /// insertion that it is ready may be left behind by those that choose again.)
    pub(crate) fn excluded(&self) -> &'static [&'static str] {
        match self.is_over || self.inserts() && !self.tree.has_put() {
            true => &["Ask", "Answer"],
            false => &[],
        }
    }

    /// The sums that it adds at a barrier, if it is at one; `points` are left to it.
    fn sums(&self, standing: Standing, points: usize) -> Option<Sums> {
        let mut sums = Sums::default();
        match self.stage {
            Stage::Choosing if self.open != Some(0) => return None,
            Stage::Choosing => {}
            Stage::Inserting if points > 0 || !standing.is_passive => return None,
            Stage::Inserting => {
                sums[SENT] = standing.sent as i64;
                sums[TAKEN] = standing.received as i64;
            }
        }
        Some(sums)
    }

    pub(crate) fn has_thoughts(&self, standing: Standing, points: usize) -> bool {
        let asks = self.stage == Stage::Choosing && self.open.is_none();
        let speaks = !self.tree.has_put() && self.sums(standing, points).is_some();
        !self.is_over && (asks || speaks)
    }

    pub(crate) fn think<C: Rules>(&mut self, standing: Standing, points: &mut Vec<Vertex>) {
        if self.stage == Stage::Choosing && self.open.is_none() {
            self.open = Some(self.workers - 1);
            let others = WorkerId::below(self.workers).filter(|&w| w != self.me);
            self.out.extend(others.map(|w| (w, Told::Ask)));
        } else if self.stage == Stage::Choosing && !C::awaits_reservations() {
            self.stage = Stage::Inserting;
        } else if let Some(sums) = self.sums(standing, points.len()) {
            let step = self.tree.put(sums);
            self.take::<C>(step, points);
        }
    }

    pub(crate) fn hear<C: Rules>(&mut self, from: WorkerId, told: Told, points: &mut Vec<Vertex>) {
        match told {
            Told::Ask => self.out.push_back((from, Told::Answer)),
            Told::Answer => self.open = self.open.map(|open| open - 1),
            Told::Up(sums) => {
                let step = self.tree.hear(sums);
                self.take::<C>(step, points);
            }
            Told::Down(sums) => self.pass_on::<C>(sums, points),
        }
    }

    pub(crate) fn tell(&mut self) -> Option<(WorkerId, Told)> {
        self.out.pop_front()
    }

    fn take<C: Rules>(&mut self, step: Option<Step>, points: &mut Vec<Vertex>) {
        match step {
            None => {}
            Some(Step::Up(to, sums)) => self.out.push_back((to, Told::Up(sums))),
            Some(Step::Done(sums)) => self.pass_on::<C>(sums, points),
        }
    }

    /// A barrier is over.
    fn pass_on<C: Rules>(&mut self, sums: Sums, points: &mut Vec<Vertex>) {
        self.tree.release();
        self.out.extend(self.tree.below().map(|w| (w, Told::Down(sums))));
        let before = self.before.replace(sums);
        match self.stage {
            Stage::Choosing => (self.stage, self.before) = (Stage::Inserting, None),
            Stage::Inserting if is_quiet::<C>(before, &sums) => {
                (self.stage, self.open, self.before) = (Stage::Choosing, None, None);
                match self.second.take() {
                    Some(second) => *points = second,
                    None => self.is_over = true,
                }
            }
            Stage::Inserting => {}
        }
    }
}
