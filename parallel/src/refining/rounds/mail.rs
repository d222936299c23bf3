//! News of rounds on their way out.

use super::keys::keep;
use crate::protocol::WorkerId;
use crate::refining::news::DomainNews;
use std::collections::VecDeque;

/// News to be told.
#[derive(Debug, Default)]
pub(super) struct Mail {
    out: VecDeque<(WorkerId, DomainNews)>,
    /// The memory of news that others have told together: about as much is told them.
    spare: Vec<Vec<DomainNews>>,
}

impl Mail {
    pub(super) fn send(&mut self, to: WorkerId, news: DomainNews) {
        self.out.push_back((to, news));
    }

    /// Keeps the memory of news that were heard together.
    pub(super) fn keep(&mut self, all: Vec<DomainNews>) {
        keep(&mut self.spare, all);
    }

    /// The next news: all that is to be told one worker goes together.
    pub(super) fn tell(&mut self, me: WorkerId) -> Option<(WorkerId, DomainNews)> {
        let (to, first) = self.out.pop_front()?;
        if to == me || self.out.iter().all(|(other, _)| *other != to) {
            return Some((to, first));
        }
        let mut all = self.spare.pop().unwrap_or_default();
        all.push(first);
        // News for others go around, and are in their order again.
        for _ in 0..self.out.len() {
            match self.out.pop_front() {
                Some((other, news)) if other == to => all.push(news),
                other => self.out.extend(other),
            }
        }
        Some((to, DomainNews::Several(all)))
    }
}
