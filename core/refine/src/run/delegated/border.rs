//! Rounds that others leave between two of them, and go on with: here, or in another process.

use super::{Delegated, Handed, Remaining};
use crate::RefineError;
use crate::outcome::RefineStats;
use crate::rules::choice::TetPlace;

impl Delegated<'_> {
    /// Takes over between two rounds. Others go on then with what they have left.
    ///
    /// # Errors
    /// Those of [`Delegated::finish`].
    pub fn stop_between(&mut self, handed: Handed) -> Result<Remaining, RefineError> {
        let (asked, refused) = (handed.asked.clone(), handed.refused.clone());
        let (candidates, blocks) = (handed.candidates, handed.blocks.clone());
        let tets = handed.refused_tets.clone();
        let spent = handed.spent;
        self.take(handed)?;
        let state = &self.run.refinement.state;
        let place = |t| TetPlace::of(state.vertices(t).map(|v| state.at(v)));
        let refused_tets = tets.into_iter().map(|(t, why)| (place(t), why)).collect();
        Ok(Remaining { asked, refused, refused_tets, candidates, spent, slivers: None, blocks })
    }

    /// Goes on from where another process has taken over between two rounds, with these figures.
    pub fn go_on_from(&mut self, stats: RefineStats) {
        self.run.stats = stats;
    }
}
