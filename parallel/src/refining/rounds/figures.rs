//! The figures of rounds, and how they end.

use ltbw_refine::RefineStats;

/// Why no round follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Ending {
    /// No tetrahedron is left that may be split.
    Done,
    /// Something cannot be split.
    Irregular,
    /// The budget may be used up in this round.
    Budget,
    /// The run was cancelled.
    Cancelled,
    /// As many rounds were carried out as were asked for at once.
    Border,
    /// The cuts between the workers' parts are to move; they go on then.
    Redeal,
}

/// The figures of the rounds, of one worker or of all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct RoundFigures {
    /// Vertices of the mesh with which the workers began.
    pub started: u64,
    /// Rounds that inserted points: all, and with points on segments, on facets, inside.
    pub rounds: [u64; 4],
    /// Points of the widest round.
    pub widest: u64,
    /// Points inserted by rounds.
    pub points: u64,
    /// Times that circles were split.
    pub parted: u64,
    /// Points inserted for that, beside those of rounds.
    pub parted_points: u64,
    /// Closures searched by this worker's probes.
    pub searches: u64,
    /// The number of these that were found ahead, while others were waited for. It depends on the
    /// timing.
    pub ahead: u64,
    /// Barriers, waves that had to be repeated included.
    pub barriers: u64,
    /// Times that all workers had ended, and one took over.
    pub ended: u64,
    /// Times that the cuts between the workers' parts have moved.
    pub redeals: u64,
    /// Tetrahedra that have changed their worker by that.
    pub moved: u64,
}

impl RoundFigures {
    /// The figures of all workers, the first one's first, which began with `begin`.
    pub(super) fn summed(all: &[Self], begin: Self) -> Self {
        let sum = |of: fn(&Self) -> u64| {
            let before = of(&begin);
            all.iter().fold(before, |sum, own| sum + of(own).saturating_sub(before))
        };
        let (searches, ahead) = (sum(|own| own.searches), sum(|own| own.ahead));
        let moved = sum(|own| own.moved);
        Self { searches, ahead, moved, ..all.first().copied().unwrap_or(begin) }
    }

    /// The figures of a refinement that had others before the rounds since `begin`.
    pub(super) fn after(&self, begin: &Self, before: RefineStats) -> RefineStats {
        // The engine may have carried out rounds, too.
        let rounds = [0, 1, 2, 3].map(|k| self.rounds[k] - begin.rounds[k]);
        RefineStats {
            rounds: before.rounds + rounds[0],
            rounds_with: [0, 1, 2].map(|k| before.rounds_with[k] + rounds[k + 1]),
            searches: before.searches + self.searches - begin.searches,
            widest: before.widest.max(self.widest),
            joint_phases: before.joint_phases + self.parted - begin.parted,
            round_points: before.round_points + self.points - begin.points,
            ..before
        }
    }
}
