//! Random numbers, the same on every machine: integer arithmetic and `+ - * /` and `sqrt` alone,
//! whose results IEEE 754 fixes to the bit.

use ltbw_exact::Point;

/// SplitMix64 (Steele, Lea, Flood, "Fast splittable pseudorandom number generators", 2014): a
/// counter passed through a mixing function; every seed is a good one.
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// A generator that `seed` alone determines.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A multiple of 2^-53 in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// An integer below `bound`, nearly uniform (the bias is below `bound` / 2^64).
    pub fn below(&mut self, bound: u64) -> u64 {
        ((u128::from(self.bits()) * u128::from(bound)) >> 64) as u64
    }

    /// Shuffles `items` (Fisher and Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i as u64 + 1) as usize);
        }
    }

    /// A point uniform in the unit cube.
    pub fn cube(&mut self) -> Point {
        [self.unit(), self.unit(), self.unit()]
    }

    /// A direction, by rejection from the ball and division by the length.
    pub fn direction(&mut self) -> Point {
        // A try succeeds with probability 0.52; 2000 failures in a row do not happen.
        for _ in 0..2000 {
            let p = self.cube().map(|c| 2.0 * c - 1.0);
            let square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
            if square > 1e-6 && square <= 1.0 {
                let length = square.sqrt();
                return p.map(|c| c / length);
            }
        }
        [1.0, 0.0, 0.0]
    }
}
