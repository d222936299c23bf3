//! The conductor: where there are patches one worker gives the candidates of a round their turns.
//!
//! Points at patches are alone in their closures, and who of them waits depends on who is taken
//! before: a chain through the whole mesh, which no worker sees. So all homes probe, as elsewhere,
//! and tell the conductor of what they have found, with the tetrahedra of closures by owner and
//! slot: nothing of the mesh changes meanwhile. The conductor says who is probed next, as waves of
//! ranks go, and in the end who stands. The rules are those of the engine (`Contender`, `Held`).

use crate::protocol::WorkerId;
use crate::refining::news::{Entrant, Fate, Owned, Report, Reported};
use ltbw_refine::{Carrier, Contender, Group, Held, Rank, next_wave};
use rustc_hash::FxHashMap;

/// The worker that conducts.
pub(super) const CONDUCTOR: WorkerId = WorkerId::new(0);

/// The knowledge that the conductor has of a round.
#[derive(Debug, Default)]
pub(super) struct Conductor {
    /// By worker: its entrants, if it has told of them.
    pub(super) told: Vec<Option<Vec<Entrant>>>,
    pub(super) contest: Contest,
}

/// A candidate of the round.
#[derive(Debug)]
struct Contestant {
    home: WorkerId,
    number: u32,
    rank: Rank,
    /// The tetrahedron that it splits, if it is none of the boundary.
    tet: Option<Owned>,
    report: Option<Report>,
}

/// The candidates of a round by their ranks, and the tetrahedra in their cavities.
#[derive(Debug, Default)]
pub(super) struct Contest {
    all: Vec<Contestant>,
    /// The ranks of each worker's entrants; none of those that are not probed.
    ranks: Vec<Vec<Option<u32>>>,
    /// The number of boundary items, which have the first ranks.
    of_boundary: usize,
    /// The ranks of the last wave, and those up to its end.
    wave: usize,
    done: usize,
    /// Reports that are still to come.
    pub(super) awaited: usize,
    held: FxHashMap<Owned, u32>,
    has_alone: bool,
}

impl Held for Contest {
    type Tet = Owned;

    fn holder(&self, t: Owned) -> Option<usize> {
        self.held.get(&t).map(|&rank| rank as usize)
    }

    fn is_alone(&self, rank: usize) -> bool {
        self.all[rank].report.as_ref().is_some_and(Report::is_alone)
    }

    fn has_alone(&self) -> bool {
        self.has_alone
    }

    fn of_boundary(&self) -> usize {
        self.of_boundary
    }

    fn carrier(&self, rank: usize) -> Carrier {
        self.all[rank].report.as_ref().map_or(Carrier::Free, |own| own.carrier)
    }
}

impl Contest {
    /// The contest of all workers' entrants. Of tetrahedra whose circumspheres are nearly equal one
    /// is probed: that which comes first.
    pub(super) fn of(told: Vec<Vec<Entrant>>) -> Self {
        let ranks = told.iter().map(|own| vec![None; own.len()]).collect();
        let mut all: Vec<Contestant> = Vec::new();
        let mut groups: FxHashMap<Group, usize> = FxHashMap::default();
        for (home, list) in (0..).map(WorkerId::new).zip(told) {
            for (number, Entrant { rank, tet, group }) in (0..).zip(list) {
                let tet = tet.map(|tet| Owned { owner: home, tet });
                let own = Contestant { home, number, rank, tet, report: None };
                match group.and_then(|group| groups.get(&group)) {
                    Some(&other) if own.rank < all[other].rank => all[other] = own,
                    Some(_) => {}
                    None => {
                        groups.extend(group.map(|group| (group, all.len())));
                        all.push(own);
                    }
                }
            }
        }
        all.sort_unstable_by_key(|own| own.rank);
        let of_boundary = all.iter().filter(|own| own.tet.is_none()).count();
        let mut contest = Self { all, ranks, of_boundary, ..Self::default() };
        for (rank, own) in (0..).zip(&contest.all) {
            contest.ranks[own.home.index()][own.number as usize] = Some(rank);
        }
        contest
    }

    /// Of each worker, the numbers of its entrants that are probed.
    pub(super) fn probed(&self) -> impl Iterator<Item = Vec<u32>> + '_ {
        let is_probed = |(number, rank): (u32, &Option<u32>)| rank.map(|_| number);
        self.ranks.iter().map(move |own| (0..).zip(own).filter_map(is_probed).collect())
    }

    /// The next wave of probes, by homes that are to launch them; none if all are probed. Boundary
    /// items are one wave.
    pub(super) fn next_wave(&mut self) -> Option<FxHashMap<WorkerId, Vec<u32>>> {
        let first = self.done;
        if first == self.all.len() {
            return None;
        }
        self.wave = match self.of_boundary {
            0 => next_wave(self.wave, self.all.len()),
            _ => self.all.len(),
        };
        self.done = (first + self.wave).min(self.all.len());
        let mut launched: FxHashMap<WorkerId, Vec<u32>> = FxHashMap::default();
        for rank in first..self.done {
            let own = &self.all[rank];
            if !self.contender(rank).is_killed(self) {
                launched.entry(own.home).or_default().push(own.number);
                self.awaited += 1;
            }
        }
        Some(launched)
    }

    fn contender(&self, rank: usize) -> Contender<'_, Owned> {
        let own = &self.all[rank];
        let report = own.report.as_ref();
        Contender {
            rank,
            tet: own.tet,
            carrier: self.carrier(rank),
            watch: report.and_then(|report| report.watch.as_ref()),
            is_alone: self.is_alone(rank),
        }
    }

    /// A home's report. Of tetrahedra cavities are reserved at once, whatever becomes of them:
    /// those killed are not probed in later waves.
    pub(super) fn take(&mut self, home: WorkerId, report: Report) {
        let Some(&Some(rank)) =
            self.ranks.get(home.index()).and_then(|own| own.get(report.number as usize))
        else {
            return;
        };
        self.awaited -= 1;
        self.has_alone |= report.is_alone();
        let holds = self.of_boundary == 0 && !report.is_refused();
        self.all[rank as usize].report = Some(report);
        if holds {
            self.reserve(rank);
        }
    }

    /// The candidate of a rank has the tetrahedra of its cavity, where none before it has them.
    fn reserve(&mut self, rank: u32) {
        let Self { all, held, .. } = self;
        for &t in all[rank as usize].report.iter().flat_map(|own| &own.cavity) {
            held.entry(t).and_modify(|other| *other = rank.min(*other)).or_insert(rank);
        }
    }

    /// Is a candidate killed by none before it, and loses no item together with others?
    fn survives(&self, rank: usize, report: &Report) -> bool {
        let own = self.contender(rank);
        let closure = || report.closure();
        !own.is_killed(self) && !own.waits(self, closure) && !own.is_crowded(self, closure)
    }

    /// The fate of the candidate of a rank, when those before it have had their turns.
    fn fate(&self, rank: usize) -> Fate {
        let Some(report) = &self.all[rank].report else { return Fate::Falls };
        let is_boundary = rank < self.of_boundary;
        let is_barred = |t: Owned| self.bars(t, report.carrier);
        let stands = match report.verdict {
            Reported::Nothing => false,
            _ if is_boundary && report.passed.iter().copied().any(is_barred) => {
                return Fate::Barred;
            }
            _ if is_boundary && report.closure().any(is_barred) => return Fate::Barred,
            Reported::Asks | Reported::Refused => !self.contender(rank).is_killed(self),
            Reported::Fits { .. } => self.survives(rank, report),
        };
        if stands { Fate::Stands } else { Fate::Falls }
    }

    /// The fates of all, by worker and number. Where some have to be alone, and of the boundary,
    /// candidates have turns, the foremost first: the tetrahedra are reserved anew, by those alone
    /// that stand. A boundary item that asks for another one is in nobody's way.
    pub(super) fn fates(&mut self) -> Vec<Vec<Fate>> {
        let has_turns = self.has_alone || self.of_boundary > 0;
        if has_turns {
            self.held.clear();
        }
        let mut fates = Vec::with_capacity(self.all.len());
        for rank in 0..self.all.len() {
            let fate = self.fate(rank);
            fates.push(fate);
            let fits = |own: &Report| matches!(own.verdict, Reported::Fits { .. });
            let report = self.all[rank].report.as_ref();
            let holds = match rank < self.of_boundary {
                true => report.is_some_and(fits),
                false => !report.is_some_and(Report::is_refused),
            };
            if has_turns && fate == Fate::Stands && holds {
                self.reserve(rank as u32);
            }
        }
        let fate = |rank: &Option<u32>| rank.map_or(Fate::Follows, |rank| fates[rank as usize]);
        self.ranks.iter().map(|own| own.iter().map(fate).collect()).collect()
    }
}
