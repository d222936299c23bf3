//! The outline of a polygon, as a tree of pieces with boxes: is a point inside it?
//!
//! A ray to the right crosses a piece that is wholly to the right of its start as often, up to an
//! even number, as it passes between the piece's ends: only pieces whose box has the start are
//! looked into. Along a comb these are few. All is exact.

use std::cell::Cell;

/// A point of a plane; entries below 2^56.
pub(crate) type Flat = [i64; 2];

/// Edges in a piece that is not divided.
const FEW: usize = 8;

/// A closed outline.
#[derive(Clone, Debug)]
pub(crate) struct Ring {
    /// The corners, and the first one again.
    corners: Vec<Flat>,
    /// Lowest and highest corner of each piece. Piece k is cut into 2k + 1 and 2k + 2, each with
    /// half of the edges.
    boxes: Vec<[Flat; 2]>,
    /// Pieces and edges that were looked at so far.
    steps: Cell<u64>,
}

impl Ring {
    pub(crate) fn new(mut corners: Vec<Flat>) -> Self {
        let edges = corners.len();
        corners.extend(corners.first().copied());
        let (mut pieces, mut part) = (1, edges);
        while part > FEW {
            (pieces, part) = (2 * pieces + 1, part.div_ceil(2));
        }
        let mut ring = Self { corners, boxes: vec![[[0; 2]; 2]; pieces], steps: Cell::new(0) };
        ring.fill(0, 0, edges);
        ring
    }

    /// Sets the box of a piece from those of its halves. The depth is the logarithm of the edges.
    fn fill(&mut self, piece: usize, start: usize, end: usize) {
        let join = |[low, high]: [Flat; 2], p: &[Flat; 2]| {
            let low = [low[0].min(p[0][0]), low[1].min(p[0][1])];
            [low, [high[0].max(p[1][0]), high[1].max(p[1][1])]]
        };
        let none = [[i64::MAX; 2], [i64::MIN; 2]];
        self.boxes[piece] = if 2 * piece + 2 < self.boxes.len() {
            let middle = start + (end - start).div_ceil(2);
            self.fill(2 * piece + 1, start, middle);
            self.fill(2 * piece + 2, middle, end);
            join(self.boxes[2 * piece + 1], &self.boxes[2 * piece + 2])
        } else {
            let own = self.corners.get(start..=end).filter(|_| start < end);
            own.into_iter().flatten().fold(none, |found, p| join(found, &[*p, *p]))
        };
    }

    /// The box around all of it.
    pub(crate) fn bounds(&self) -> [Flat; 2] {
        self.boxes[0]
    }

    /// Is a point inside, or on an edge to the left of what is inside?
    pub(crate) fn encloses(&self, p: Flat) -> bool {
        let (mut inside, mut steps) = (false, 0);
        let passes = |a: Flat, b: Flat| (a[1] > p[1]) != (b[1] > p[1]);
        let mut stack = vec![(0, 0, self.corners.len().saturating_sub(1))];
        // Each piece is looked at once at most.
        while let Some((piece, start, end)) = stack.pop() {
            steps += 1;
            let [low, high] = self.boxes[piece];
            if high[0] <= p[0] || high[1] <= p[1] || low[1] > p[1] {
                continue;
            }
            if low[0] > p[0] {
                inside ^= passes(self.corners[start], self.corners[end]);
                continue;
            }
            if 2 * piece + 2 < self.boxes.len() {
                let middle = start + (end - start).div_ceil(2);
                stack.extend([(2 * piece + 1, start, middle), (2 * piece + 2, middle, end)]);
                continue;
            }
            steps += (end - start) as u64;
            for pair in self.corners[start..=end].windows(2) {
                inside ^= passes(pair[0], pair[1]) && is_right(pair[0], pair[1], p);
            }
        }
        self.steps.set(self.steps.get() + steps);
        inside
    }

    /// Pieces and edges that were looked at so far.
    #[cfg(test)]
    pub(crate) fn steps(&self) -> u64 {
        self.steps.get()
    }
}

/// Is an edge strictly to the right of a point between its levels? Products are below 2^114.
fn is_right(a: Flat, b: Flat, p: Flat) -> bool {
    let d = |p: Flat, q: Flat, k: usize| i128::from(p[k] - q[k]);
    let side = d(b, a, 0) * d(p, a, 1) - d(p, a, 0) * d(b, a, 1);
    if b[1] > a[1] { side > 0 } else { side < 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A comb of leaning teeth of different lengths.
    fn comb(teeth: i64, lean: i64) -> Vec<Flat> {
        let mut corners = vec![[4 * teeth, 0], [4 * teeth, -3], [0, -3]];
        for k in 0..teeth {
            let top = 15 + k * 7 % 11;
            corners.extend([[4 * k, 0], [4 * k + lean, top], [4 * k + lean + 2, top + 1]]);
            corners.push([4 * k + 2, 0]);
        }
        corners
    }

    /// The answer by all edges.
    fn slow(corners: &[Flat], p: Flat) -> bool {
        let edges = (0..corners.len()).map(|k| (corners[k], corners[(k + 1) % corners.len()]));
        let passes = |(a, b): (Flat, Flat)| (a[1] > p[1]) != (b[1] > p[1]) && is_right(a, b, p);
        edges.filter(|&edge| passes(edge)).count() % 2 == 1
    }

    #[test]
    fn the_tree_says_what_all_edges_say() {
        let square = |low: i64, high: i64| vec![[low, low], [high, low], [high, high], [low, high]];
        let spiral: Vec<Flat> = (0..60)
            .map(|k: i64| {
                let (turn, size) = (k % 4, 3 + 2 * (if k < 30 { k } else { 59 - k + 2 }));
                [[size, size], [-size, size], [-size, -size], [size, -size]][turn as usize]
            })
            .collect();
        for corners in [comb(10, 0), comb(10, 3), comb(10, -5), square(1, 9), spiral, vec![]] {
            let ring = Ring::new(corners.clone());
            for (x, y) in (-20..50).flat_map(|x| (-20..40).map(move |y| (x, y))) {
                assert_eq!(ring.encloses([x, y]), slow(&corners, [x, y]), "{x} {y}");
            }
        }
    }

    #[test]
    fn a_point_takes_few_steps_on_a_comb_of_many_teeth() {
        for teeth in [1 << 8, 1 << 14] {
            let ring = Ring::new(comb(teeth, 1));
            let inside = (0..100).filter(|k| ring.encloses([k * 8 % teeth, k % 20 - 2]));
            assert!(inside.count() > 0);
            assert!(ring.steps() < 100 * 100, "{} teeth: {} steps", teeth, ring.steps());
        }
    }
}
