//! P12: news by kind, counted by those that carry them.

use super::Inspect;
use crate::protocol::{Message, Source, Submesh};

/// The numbers of news under way, by kind.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NewsNumbers(Vec<(&'static str, i64)>);

impl NewsNumbers {
    /// Adds to the number of a kind.
    fn add(&mut self, kind: &'static str, many: i64) {
        match self.0.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, number)) => *number += many,
            None => self.0.push((kind, many)),
        }
    }

    /// The number of a kind.
    pub fn of(&self, kind: &str) -> i64 {
        self.0.iter().find(|(known, _)| *known == kind).map_or(0, |&(_, number)| number)
    }
    /// A kind that may not be under way while a source is as it is, and its number.
    pub(super) fn late<S: Submesh, Q: Source<S>>(&self, source: &Q) -> Option<(&'static str, i64)> {
        let all = source.excluded().iter().map(|&kind| (kind, self.of(kind)));
        all.into_iter().find(|&(_, number)| number != 0)
    }
}

/// Adds `many` to the numbers of the news that a message brings.
pub fn count_news<S: Inspect>(message: &Message<S>, numbers: &mut NewsNumbers, many: i64) {
    if let Message::News(news) = message {
        S::kinds(news).into_iter().for_each(|kind| numbers.add(kind, many));
    }
}
