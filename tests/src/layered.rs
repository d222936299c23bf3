//! Random domains of layers: stacks, honeycombs, laminates with holes. Right angles and regular
//! polygons only, so that nothing excuses a mesh that leaves a bound unmet; but layers are thin.

use ltbw::Random;
use ltbw::domain::Domain;
use ltbw_generate::layers::{Drill, honeycomb, laminate, stack};

/// The steps of the lattice of thicknesses in a unit.
const STEPS: u64 = 64;

/// The draws of a stack.
const TRIES: usize = 1000;

/// The bases of stacks and laminates.
const BASES: [[f64; 2]; 4] = [[3.0, 2.0], [1.0, 1.0], [4.0, 1.0], [2.0, 2.0]];

/// A random stack of 2 to 8 layers.
#[derive(Debug, Clone, PartialEq)]
pub struct Stack {
    /// The seed that made it.
    pub seed: u64,
    /// The sides of its base.
    pub base: [f64; 2],
    /// The thickness of each layer, the lowest first.
    pub thicknesses: Vec<f64>,
    /// Has each layer a seed of its own?
    pub regions: bool,
}

impl Stack {
    /// The stack of a seed, with layers of 1/64 to 1, in turn any, most of them thin, all of one
    /// thickness. Cubes as high as its layers would number at most `most`, if that is more than
    /// some hundreds: the tetrahedra of a bound on shapes are some more.
    #[must_use]
    pub fn random(seed: u64, most: f64) -> Self {
        let mut random = Random::new(seed ^ 0x57ac);
        let base = BASES[random.below(4) as usize];
        let regions = random.below(2) == 1;
        let layers = 2 + random.below(7);
        // Each of the draws is likely to do; halves always do.
        let mut draws = (0..TRIES).map(|_| match seed % 3 {
            0 => thicknesses(&mut random, layers, 1),
            1 => (0..layers).map(|_| thin(&mut random)).collect(),
            _ => vec![thin(&mut random); layers as usize],
        });
        let cubes = |all: &Vec<f64>| all.iter().map(|t| base[0] * base[1] / (t * t)).sum::<f64>();
        let found = draws.find(|all| cubes(all) <= most);
        let thicknesses = found.unwrap_or_else(|| vec![0.5; layers as usize]);
        Self { seed, base, thicknesses, regions }
    }

    /// The domain.
    #[must_use]
    pub fn domain(&self) -> Domain {
        stack(self.base, &self.thicknesses, self.regions)
    }

    /// Its volume.
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.base[0] * self.base[1] * self.thicknesses.iter().sum::<f64>()
    }
}

impl std::fmt::Display for Stack {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y] = self.base;
        write!(f, "stack {}: {x}x{y}, layers of", self.seed)?;
        self.thicknesses.iter().try_for_each(|t| write!(f, " {}", t * STEPS as f64))?;
        write!(f, " 64ths, with{} regions", if self.regions { "" } else { "out" })
    }
}

/// A thickness of 1 to 64 steps, every power of two as likely as the next.
fn thin(random: &mut Random) -> f64 {
    let power = 1 << random.below(7);
    (power + random.below(power)).min(STEPS) as f64 / STEPS as f64
}

/// Thicknesses of `least` to 64 steps.
fn thicknesses(random: &mut Random, layers: u64, least: u64) -> Vec<f64> {
    let mut one = || (least + random.below(STEPS + 1 - least)) as f64 / STEPS as f64;
    (0..layers).map(|_| one()).collect()
}

/// A random honeycomb of 1 to 12 cells, some of them empty, in 1 to 3 layers, and its name.
#[must_use]
pub fn random_honeycomb(seed: u64) -> (String, Domain) {
    let mut random = Random::new(seed ^ 0x4ec5);
    let (columns, rows) = (1 + random.below(4), 1 + random.below(3));
    // The first cell stays.
    let empty: Vec<usize> =
        (1..(columns * rows) as usize).filter(|_| random.below(6) == 0).collect();
    let (layers, regions) = (1 + random.below(3), random.below(2) == 1);
    let thick = thicknesses(&mut random, layers, 8);
    let domain = honeycomb(columns as u32, rows as u32, &empty, &thick, regions);
    (format!("honeycomb {seed}: {columns}x{rows} without {empty:?}, layers of {thick:?}"), domain)
}

/// A random laminate of 2 to 5 layers with 1 to 4 holes, square or of up to 8 corners, through all
/// or some of them, and its name.
#[must_use]
pub fn random_laminate(seed: u64) -> (String, Domain) {
    let mut random = Random::new(seed ^ 0x1a31);
    let base = BASES[random.below(4) as usize];
    let (layers, regions) = (2 + random.below(4), random.below(2) == 1);
    let thick = thicknesses(&mut random, layers, 6);
    let counts = [1 + random.below(2), 1 + random.below(2)];
    let mut drills = Vec::new();
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            let pitch = [base[0] / counts[0] as f64, base[1] / counts[1] as f64];
            let centre = [(i as f64 + 0.5) * pitch[0], (j as f64 + 0.5) * pitch[1]];
            let radius = (0.15 + 0.2 * random.unit()) * pitch[0].min(pitch[1]);
            let corners = if random.below(2) == 0 { 4 } else { 3 + random.below(6) as u32 };
            let first = if random.below(2) == 0 { 0 } else { random.below(layers) };
            let last = if random.below(2) == 0 {
                layers
            } else {
                first + 1 + random.below(layers - first)
            };
            drills.push(Drill { centre, radius, corners, layers: first as usize..last as usize });
        }
    }
    let domain = laminate(base, &thick, &drills, regions);
    (format!("laminate {seed}: {base:?}, layers of {thick:?}, holes {drills:?}"), domain)
}

#[cfg(test)]
mod tests {
    use super::{Stack, random_honeycomb, random_laminate};
    use crate::domains::prepared;
    use std::collections::BTreeSet;

    #[test]
    fn stacks_are_of_every_kind_and_have_their_volume() {
        let (mut kinds, mut thinnest) = (BTreeSet::new(), 0);
        for seed in 0..600 {
            let stack = Stack::random(seed, 1e5);
            let ready = prepared(&stack.domain());
            assert_eq!(ready.moved, 0, "{stack}: off its lattice");
            let own = ready.report.volume().expect("a volume").to_f64();
            assert_eq!(own, stack.volume(), "{stack}");
            let cells = ready.report.cells.as_ref().map(Vec::len);
            assert_eq!(cells, Some(stack.thicknesses.len()), "{stack}");
            assert!(stack.thicknesses.iter().all(|&t| (1.0 / 64.0..=1.0).contains(&t)));
            thinnest += u32::from(stack.thicknesses.contains(&(1.0 / 64.0)));
            kinds.insert((stack.base.map(|c| c as u64), stack.thicknesses.len(), stack.regions));
            let few = Stack::random(seed, 1500.0);
            let cubes = few.thicknesses.iter().map(|t| few.base[0] * few.base[1] / (t * t));
            assert!(cubes.sum::<f64>() <= 1500.0, "{few}");
        }
        assert_eq!(kinds.len(), 4 * 7 * 2, "bases, layers, with and without regions");
        assert!(thinnest > 100, "{thinnest}");
    }

    #[test]
    fn honeycombs_and_laminates_are_sound() {
        let (mut voids, mut regions) = (0, 0);
        for seed in 0..200 {
            for (name, domain) in [random_honeycomb(seed), random_laminate(seed)] {
                let report = domain.check(&Default::default()).expect("a domain");
                assert!(report.is_meshable(), "{name}: {:?}", report.defects.first());
                let ready = prepared(&domain);
                // Right prisms stay so on the lattice.
                assert_eq!(ready.domain.facets.len(), domain.facets.len(), "{name}");
                let cells = ready.report.cells.as_ref().expect("cells");
                let filled = cells.iter().filter(|cell| cell.filled).count();
                assert_eq!(cells.len() - filled, domain.holes.len(), "{name}");
                assert!(domain.regions.len() <= filled, "{name}");
                voids += domain.holes.len();
                regions += domain.regions.len();
            }
        }
        assert!(voids > 10 && regions > 500, "{voids} {regions}");
    }
}
