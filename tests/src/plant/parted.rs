//! Defects planted into meshes that are checked in parts.

use super::{Plant, Subject, TIES};
use crate::families::Rng;
use crate::teams::on_team;
use ltbw_cli::ranks::Judge;
use ltbw_verify::{Depth, Options, Part, Report, check_parted};

/// A way to deal tetrahedra out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deal {
    /// At random: nearly every face is between two parts.
    Random(u64),
    /// In stretches of the list.
    Stretches,
}

/// The team of a check.
#[derive(Clone, Copy, Debug)]
pub struct Among {
    /// Number of members.
    pub members: u32,
    /// The way in which the mesh is dealt out among them.
    pub deal: Deal,
}

/// A member's part.
#[derive(Default)]
struct OwnPart {
    numbers: Vec<u32>,
    tets: Vec<[u32; 4]>,
}

impl Subject {
    /// The report of a team, among whose members the tetrahedra are dealt out.
    ///
    /// # Panics
    /// If members have different reports, or none.
    #[must_use]
    pub fn report_in_parts(&self, depth: Depth, members: u32, deal: Deal) -> Report {
        let options = Options { depth, all_points: true, ..Options::default() };
        let parts = self.dealt(members as usize, deal);
        let mut all = on_team(members, |team| {
            let me = team.me().index();
            let OwnPart { numbers, tets } = &parts[me];
            let points: Vec<_> = numbers.iter().map(|&v| self.points[v as usize]).collect();
            let stretch = |k: usize| k * self.points.len() / members as usize;
            let given = &self.points[stretch(me)..stretch(me + 1)];
            let part = Part { points: &points, numbers, tets, given };
            check_parted(&mut Judge(team), &part, &options).expect("a report")
        });
        let first = all.swap_remove(0);
        // Coordinates may be NaN, which no value is equal to.
        let text = |report: &Report| format!("{report:?}");
        assert!(all.iter().all(|other| text(other) == text(&first)), "different reports");
        first
    }

    /// Deals the tetrahedra out.
    fn dealt(&self, members: usize, deal: Deal) -> Vec<OwnPart> {
        let mut parts: Vec<OwnPart> = (0..members).map(|_| OwnPart::default()).collect();
        let mut rng = match deal {
            Deal::Random(seed) => Rng::new(seed),
            Deal::Stretches => Rng::new(0),
        };
        for (t, tet) in self.tets.iter().enumerate() {
            let owner = match deal {
                Deal::Random(_) => rng.below(members as u64) as usize,
                Deal::Stretches => t * members / self.tets.len(),
            };
            parts[owner].tets.push(*tet);
        }
        for part in &mut parts {
            let known = |v: &u32| (*v as usize) < self.points.len();
            part.numbers = part.tets.iter().flatten().copied().filter(known).collect();
            part.numbers.sort_unstable();
            part.numbers.dedup();
            // A number that no point has stays one.
            let place = |v: u32| part.numbers.binary_search(&v).map_or(u32::MAX, |k| k as u32);
            part.tets.iter_mut().for_each(|tet| *tet = tet.map(place));
        }
        parts
    }
}

/// Plants a defect and asks the checker of meshes in parts, at both depths: whether it calls it by
/// its name. `Ok(None)` where the plant does not grow, or spoils only what a part does not claim.
///
/// # Errors
/// Which defect was overlooked, or which sound mesh accused.
pub fn try_plant_in_parts(
    mesh: &Subject,
    plant: Plant,
    choice: usize,
    Among { members, deal }: Among,
) -> Result<Option<bool>, String> {
    let mut spoilt = mesh.clone();
    let Some(expected) = (plant.spoil)(&mut spoilt, choice) else {
        return Ok(None);
    };
    let mut is_named = None;
    for depth in [Depth::Full, Depth::Fast] {
        let report = spoilt.report_in_parts(depth, members, deal);
        let counts = &report.defect_counts;
        let ask = || format!("{} {choice}, {members} {deal:?}, {depth:?}: {counts:?}", plant.name);
        let ties = expected.kinds == TIES && depth == Depth::Fast;
        if expected.in_claims || ties {
            if !report.passed() {
                return Err(format!("accused in vain: {}", ask()));
            }
            continue;
        }
        if report.passed() {
            return Err(format!("overlooked: {}", ask()));
        }
        is_named = Some(is_named.unwrap_or(true) && expected.is_named_in(&report));
    }
    Ok(is_named)
}
