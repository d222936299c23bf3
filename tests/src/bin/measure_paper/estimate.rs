//! The time and memory of a run, told before it begins: as measured on two cores, in proportion to
//! the tetrahedra.

use crate::programs::Plan;
use std::fmt;
use std::ops::Add;

/// Seconds that a million tetrahedra take.
const SIMULATED: f64 = 20.5;
const MESHED: f64 = 6.0;
const TRADITIONAL: f64 = 4.0;
/// Gigabytes that a million tetrahedra take in the simulator.
const MEMORY: f64 = 0.4;

/// Millions of tetrahedra.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Work {
    pub(crate) simulated: f64,
    pub(crate) meshed: f64,
    pub(crate) traditional: f64,
    /// The most of one simulated run.
    pub(crate) most: f64,
}

impl Work {
    /// Simulated runs of one problem, each of that many million tetrahedra.
    pub(crate) fn simulated(runs: usize, millions: f64) -> Self {
        Self { simulated: runs as f64 * millions, most: millions, ..Self::default() }
    }

    /// The seconds that it takes.
    pub(crate) fn seconds(self) -> f64 {
        let Self { simulated, meshed, traditional, .. } = self;
        SIMULATED * simulated + MESHED * meshed + TRADITIONAL * traditional
    }
}

impl Add for Work {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            simulated: self.simulated + other.simulated,
            meshed: self.meshed + other.meshed,
            traditional: self.traditional + other.traditional,
            most: self.most.max(other.most),
        }
    }
}

impl fmt::Display for Work {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { simulated, meshed, traditional, most } = self;
        let seconds = self.seconds();
        let time = match seconds {
            s if s < 90.0 => format!("{s:.0} s"),
            s if s < 5400.0 => format!("{:.0} min", s / 60.0),
            s => format!("{:.1} h", s / 3600.0),
        };
        write!(
            f,
            "about {time}, {:.1} GB: {simulated:.1} million tetrahedra simulated, ",
            MEMORY * most
        )?;
        write!(f, "{meshed:.1} meshed, {traditional:.1} in the traditional way")
    }
}

/// The work of some parts, of which those of the same runs count once.
pub(crate) fn sum(plan: &Plan, works: impl Iterator<Item = fn(&Plan) -> Work>) -> Work {
    works.map(|work| work(plan)).fold(Work::default(), Work::add)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_adds_what_is_to_be_done_and_keeps_the_most_of_one_run() {
        let both = Work::simulated(2, 8.0) + Work::simulated(2, 16.0);
        assert_eq!((both.simulated, both.most), (48.0, 16.0));
        assert_eq!(both.seconds(), 48.0 * SIMULATED);
        let plain = Work { meshed: 1.0, ..Work::default() };
        assert!(plain.to_string().starts_with("about 6 s, 0.0 GB: 0.0 million"), "{plain}");
    }
}
