//! The pieces that a segment crosses.

use super::super::whole::Whole;
use super::hom::Hom;
use super::pieces::Piece;
use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;

/// The crossing of a piece.
#[derive(Debug)]
pub(super) struct Hit {
    piece: usize,
    /// It is reached from its front.
    from_front: bool,
    /// The place on the segment, as a fraction of its length with a positive denominator.
    along: [BigInt; 2],
}

impl Hit {
    /// The side that is reached, and the one behind it.
    pub(super) fn near(&self) -> usize {
        2 * self.piece + usize::from(!self.from_front)
    }

    pub(super) fn far(&self) -> usize {
        2 * self.piece + usize::from(self.from_front)
    }

    fn order(&self, other: &Self) -> Ordering {
        (&self.along[0] * &other.along[1]).cmp(&(&other.along[0] * &self.along[1]))
    }
}

fn dot(n: &Whole, p: &[BigInt; 3]) -> BigInt {
    (0..3).map(|k| &p[k] * n[k]).sum()
}

/// The pieces that the segment from a far point to `to` crosses, in its order; `target`: a piece in
/// which `to` lies. `None` if it meets an edge, or ends on another piece.
pub(super) fn cast(
    pieces: &[Piece],
    corners: &[Whole],
    from: &Whole,
    to: &Hom,
    target: Option<usize>,
) -> Option<Vec<Hit>> {
    let near = Near::new(from.map(|c| c as f64), to.rounded());
    let origin = from.map(BigInt::from);
    let mut hits = Vec::new();
    for (k, piece) in pieces.iter().enumerate().filter(|(_, piece)| near.meets(&piece.bounds)) {
        let level = dot(&piece.normal, &corners[piece.origin as usize].map(BigInt::from));
        let start = dot(&piece.normal, &origin) - &level;
        let end = dot(&piece.normal, &to.x) - &level * &to.w;
        if start.sign() == Sign::NoSign {
            return None;
        }
        if end.sign() == Sign::NoSign {
            match (piece.holds(corners, to), target == Some(k)) {
                (Some(true), true) => {}
                (Some(false), false) => continue,
                _ => return None,
            }
        } else if start.sign() == end.sign() || target == Some(k) {
            continue;
        }
        let length = &start * &to.w - &end;
        let at = [0, 1, 2].map(|k| &to.x[k] * &start - &origin[k] * &end);
        let (at, w) = match length.sign() {
            Sign::Minus => (at.map(|c| -c), -&length),
            _ => (at, length.clone()),
        };
        if piece.holds(corners, &Hom { x: at, w: w.clone() })? {
            let along = &start * &to.w;
            let along = if length.sign() == Sign::Minus { -along } else { along };
            let from_front = start.sign() == Sign::Plus;
            hits.push(Hit { piece: k, from_front, along: [along, w] });
        }
    }
    hits.sort_by(Hit::order);
    Some(hits)
}

/// Chooses the boxes that a segment may meet: all that it does meet, and few others. In floating
/// point, with a slack far above its roundings.
struct Near {
    from: [f64; 3],
    to: [f64; 3],
    slack: f64,
}

impl Near {
    fn new(from: [f64; 3], to: [f64; 3]) -> Self {
        let largest = from.iter().chain(&to).fold(0.0, |most: f64, c| most.max(c.abs()));
        Self { from, to, slack: largest * 1e-9 }
    }

    fn meets(&self, bounds: &[[i128; 2]; 3]) -> bool {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for (k, &[low, high]) in bounds.iter().enumerate() {
            let (low, high) = (low as f64 - self.slack, high as f64 + self.slack);
            let step = self.to[k] - self.from[k];
            if step.abs() <= self.slack {
                if self.from[k].min(self.to[k]) > high || self.from[k].max(self.to[k]) < low {
                    return false;
                }
                continue;
            }
            let (a, b) = ((low - self.from[k]) / step, (high - self.from[k]) / step);
            enter = enter.max(a.min(b) - 1e-9);
            leave = leave.min(a.max(b) + 1e-9);
        }
        enter <= leave
    }
}
