//! When the cuts between the workers' parts move, and to where: functions of what all know, so that
//! all decide alike.

use crate::mesh::{Blocks, Mark, Redeal};
use ltbw_exact::Point;

/// Places at which a worker says how much work lies before them along the curve.
const SAMPLES: usize = 32;

/// The weights of a tetrahedron of the domain, of one that is over its bounds, and of a boundary
/// item that is to be split: where little is left to do, tetrahedra are dealt out evenly.
pub(super) const TET: u64 = 1;
pub(super) const OVER: u64 = 16;
const ITEM: u64 = 64;

/// The work of one worker along the curve.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Part {
    /// Keys, ascending, each with the work since the one before.
    samples: Vec<Mark>,
}

impl Part {
    /// The work on tetrahedra, by keys and weights, and on boundary items.
    pub(super) fn of(tets: impl Iterator<Item = Mark>, items: impl Iterator<Item = u64>) -> Self {
        let mut all: Vec<Mark> = tets.collect();
        all.extend(items.map(|key| Mark { key, weight: ITEM }));
        all.sort_unstable();
        let sum: u64 = all.iter().map(|own| own.weight).sum();
        let (mut samples, mut told, mut before) = (Vec::new(), 0, 0);
        for (k, &Mark { key, weight }) in all.iter().enumerate() {
            before += weight;
            let is_last = k + 1 == all.len();
            let due = (samples.len() as u64 + 1) * sum / SAMPLES as u64;
            if is_last || before >= due {
                samples.push(Mark { key, weight: before - told });
                told = before;
            }
        }
        Self { samples }
    }

    fn sum(&self) -> u64 {
        self.samples.iter().map(|own| own.weight).sum()
    }

    /// About its bytes.
    pub(super) fn bytes(&self) -> u64 {
        12 * self.samples.len() as u64
    }
}

/// Other cuts, by the work of all; `None` if they would not help.
pub(super) fn cuts(
    parts: &[Part],
    blocks: &Blocks,
    points: &[Point],
    is_forced: bool,
) -> Option<Blocks> {
    let all: u64 = parts.iter().map(Part::sum).sum();
    let most = parts.iter().map(Part::sum).max().unwrap_or_default();
    let is_uneven = most as f64 * parts.len() as f64 > LEAST * all as f64;
    if all == 0 || !(is_forced || is_uneven) {
        return None;
    }
    let mut keyed: Vec<Mark> = parts.iter().flat_map(|own| &own.samples).copied().collect();
    keyed.sort_unstable();
    blocks.recut(points, &keyed)
}

/// The work of the busiest worker over the mean from which on cuts move.
const LEAST: f64 = 1.15;

/// The times at which the cuts are looked at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    mode: Redeal,
    workers: u32,
    /// With [`Redeal::Every`]: the rounds after which it is time.
    next: u64,
    /// The rounds after which the cuts were looked at last.
    last: u64,
    /// Since then: the points of the busiest worker, summed over rounds, and the mean.
    most: f64,
    mean: f64,
    /// The points that the busiest may have had more than the mean, over those of a worker.
    patience: f64,
}

impl Pace {
    /// The pace of `workers` workers.
    pub(super) fn new(mode: Redeal, workers: u32) -> Self {
        let next = match mode {
            Redeal::Every(rounds) => rounds.max(1),
            Redeal::Never | Redeal::AsNeeded => u64::MAX,
        };
        Self { mode, workers, next, last: 0, most: 0.0, mean: 0.0, patience: PATIENCE }
    }

    /// A round is over that has inserted `all` points, the busiest worker `most`.
    pub(super) fn count(&mut self, most: u64, all: u64) {
        self.most += most as f64;
        self.mean += all as f64 / f64::from(self.workers);
    }

    /// Is it time, with this mesh?
    pub(super) fn is_due(&self, rounds: u64, vertices: u64) -> bool {
        match self.mode {
            // Cuts that are not mended are looked at again when a round is over.
            _ if self.workers == 1 || rounds <= self.last => false,
            Redeal::Never => false,
            Redeal::Every(_) => rounds >= self.next,
            Redeal::AsNeeded => {
                let own = vertices as f64 / f64::from(self.workers);
                let more = self.most - self.mean;
                more > self.patience * own + SHORT && self.most > WORST * self.mean
            }
        }
    }

    /// The cuts were looked at, and have moved or not.
    pub(super) fn looked(&mut self, rounds: u64, have_moved: bool) {
        self.last = rounds;
        if let Redeal::Every(each) = self.mode {
            self.next = rounds + each.max(1);
        }
        if !have_moved {
            self.patience *= 2.0;
        }
        (self.most, self.mean) = (0.0, 0.0);
    }
}

/// The points that the busiest may have had more than the mean, over the vertices of a worker.
const PATIENCE: f64 = 0.25;
/// The points that take as long as workers take to stop, and to begin again.
const SHORT: f64 = 64.0;
/// The points of the busiest worker over the mean that nobody minds.
const WORST: f64 = 1.2;
