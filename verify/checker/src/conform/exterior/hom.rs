//! Points as whole numbers over a common denominator.

use super::super::whole::{Units, Whole};
use crate::exact::dyadic;
use crate::mesh::Point;
use num_bigint::BigInt;

/// The point x/w, w positive, in units.
#[derive(Debug, Clone)]
pub(super) struct Hom {
    pub(super) x: [BigInt; 3],
    pub(super) w: BigInt,
}

impl Hom {
    pub(super) fn whole(p: Whole) -> Self {
        Self { x: p.map(BigInt::from), w: BigInt::from(1) }
    }

    /// Half-way between two points.
    pub(super) fn middle(p: Whole, q: Whole) -> Self {
        Self { x: [0, 1, 2].map(|k| BigInt::from(p[k] + q[k])), w: BigInt::from(2) }
    }

    /// Any point of finite coordinates, exactly.
    pub(super) fn of(p: &Point, units: &Units) -> Self {
        let parts = p.map(dyadic);
        let used = parts.iter().filter(|(mantissa, _)| *mantissa != 0);
        let least = used.map(|(_, exponent)| exponent - units.exponent()).min().unwrap_or(0);
        let x = parts.map(|(mantissa, exponent)| match mantissa {
            0 => BigInt::ZERO,
            _ => BigInt::from(mantissa) << (exponent - units.exponent() - least.min(0)),
        });
        Self { x, w: BigInt::from(1) << (-least.min(0)) }
    }

    /// The coordinates, rounded.
    pub(super) fn rounded(&self) -> [f64; 3] {
        // Sixty-four bits of each are enough.
        let extra = i64::try_from(self.w.bits()).unwrap_or(i64::MAX) - 64;
        let cut = |n: &BigInt| {
            let n = if extra > 0 { n >> extra } else { n.clone() };
            n.to_string().parse::<f64>().unwrap_or(f64::INFINITY)
        };
        let w = cut(&self.w);
        [0, 1, 2].map(|k| cut(&self.x[k]) / w)
    }
}
