//! Thin plates in a box of another material, at random: nearly coplanar facets between regions, and
//! boundary items that wait for each other in circles.

use crate::Random;
use ltbw_domain::{Domain, Facet, Region};

/// The faces of a box whose corners are numbered by the bits of their places, and their axes.
const FACES: [([u32; 4], usize); 6] = [
    ([0, 2, 3, 1], 2),
    ([4, 5, 7, 6], 2),
    ([0, 1, 5, 4], 1),
    ([2, 6, 7, 3], 1),
    ([0, 4, 6, 2], 0),
    ([1, 3, 7, 5], 0),
];

/// Thin plates in a box.
#[derive(Debug, Clone)]
pub struct Plates {
    /// The plates, and the box around them.
    pub domain: Domain,
    /// The volume of the box.
    pub volume: f64,
}

/// A domain under way.
struct Builder {
    domain: Domain,
    random: Random,
    /// The distance at most of a vertex inside a face from its plane.
    noise: f64,
}

impl Builder {
    fn below(&mut self, count: u64) -> usize {
        (self.random.bits() % count) as usize
    }

    /// A thickness in 64ths, most of them small.
    fn thickness(&mut self) -> f64 {
        let most = [4, 12, 55][self.below(3)];
        (1 + self.below(most)) as f64 / 64.0
    }

    fn add(&mut self, p: [f64; 3]) -> u32 {
        self.domain.vertices.push(p);
        self.domain.vertices.len() as u32 - 1
    }

    fn facet(&mut self, corners: &[u32], marker: i32) {
        self.domain.facets.push(Facet::polygon(corners, marker));
    }

    /// A box, by its lowest and highest corner. Its faces are fans around a vertex, or around a
    /// ring of four, that are not quite in their planes; or flat.
    fn boxed(&mut self, ends: [[f64; 3]; 2], marker: i32, is_flat: bool) {
        let corner = |k: u32| [0, 1, 2].map(|i| ends[(k >> i & 1) as usize][i]);
        let first = self.domain.vertices.len() as u32;
        self.domain.vertices.extend((0..8).map(corner));
        for (face, axis) in FACES {
            let mut ring = face.map(|k| first + k);
            if is_flat {
                self.facet(&ring, marker);
                continue;
            }
            let at = face.map(corner);
            let [u, w] = [(); 2].map(|()| 0.2 + 0.6 * self.random.unit());
            let along = |to: usize, k: usize| at[to][k] - at[0][k];
            let mut middle = [0, 1, 2].map(|k| at[0][k] + u * along(1, k) + w * along(3, k));
            middle[axis] += self.noise * (2.0 * self.random.unit() - 1.0);
            let in_middle = self.add(middle);
            if self.below(3) > 0 {
                let outer = ring;
                let share = 0.3 + 0.5 * self.random.unit();
                for (k, corner) in at.iter().enumerate() {
                    let mut p = [0, 1, 2].map(|i| middle[i] + share * (corner[i] - middle[i]));
                    p[axis] = corner[axis] + self.noise * (2.0 * self.random.unit() - 1.0);
                    ring[k] = self.add(p);
                }
                for k in 0..4 {
                    let next = (k + 1) % 4;
                    self.facet(&[outer[k], outer[next], ring[next]], marker);
                    self.facet(&[outer[k], ring[next], ring[k]], marker);
                }
            }
            for k in 0..4 {
                self.facet(&[ring[k], ring[(k + 1) % 4], in_middle], marker);
            }
        }
    }

    fn region(&mut self, seed: [f64; 3], number: u32) {
        let attribute = f64::from(number);
        self.domain.regions.push(Region { seed, attribute, max_volume: None });
    }
}

/// Plates on each other in a box of another material, as many and as thick as `seed` says. Facets
/// of one face are not quite in one plane: they are one within a tolerance of 1e-6.
#[must_use]
pub fn plates(seed: u64) -> Plates {
    let random = Random::new(seed.wrapping_mul(7919));
    let mut own = Builder { domain: Domain::default(), random, noise: 0.0 };
    let bases = [[1.0, 1.0], [3.0, 2.0], [2.0, 2.0], [1.0, 3.0], [2.0, 1.0]];
    let [x, y] = bases[own.below(5)];
    let count = 1 + own.below(3) as u32;
    let margin = own.thickness();
    own.noise = [1e-7, 1e-8, 3e-7][own.below(3)];
    let mut z = own.thickness();
    for number in 2..2 + count {
        let thickness = own.thickness();
        own.boxed([[0.0, 0.0, z], [x, y, z + thickness]], number as i32, false);
        own.region([x / 2.0, y / 2.0, z + thickness / 2.0], number);
        z += thickness + own.thickness();
    }
    let [low, high] = [[-margin, -margin, 0.0], [x + margin, y + margin, z]];
    let is_flat = own.below(2) == 1;
    own.boxed([low, high], 1, is_flat);
    own.region([-margin / 2.0, -margin / 2.0, z / 2.0], 1);
    Plates { domain: own.domain, volume: (0..3).map(|k| high[k] - low[k]).product() }
}
