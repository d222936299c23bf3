//! The vertices of a mesh in a tree of boxes, and the shapes that are looked for in it.
//!
//! A search visits the boxes that a shape may meet. Boxes are compared exactly; planes, lines are
//! compared in f64 with a slack far above all rounding, so that no box that they meet is passed
//! over. What is found is to be tested exactly by whoever asks.

use super::whole::Whole;

/// Points in a box that is not divided.
const FEW: usize = 8;

/// Part of the products' largest size that a rounded sum has to differ from its bound by: sums of
/// fewer than 32 products, each with an error of less than 16 · 2^-53 of it.
const SLACK: f64 = 1.0 / (1u64 << 40) as f64;

/// A box: its lowest and its highest corner.
pub(crate) type Bounds = [Whole; 2];

/// The box of some points; an empty one without points.
pub(crate) fn bounds(points: impl Iterator<Item = Whole>) -> Bounds {
    points.fold([[i128::MAX; 3], [i128::MIN; 3]], |[low, high], p| {
        [[0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k]))]
    })
}

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    (0..3).all(|k| a[0][k] <= b[1][k] && b[0][k] <= a[1][k])
}

/// The aim of a search: all points in a box that are on a plane or on a line, and some others.
#[derive(Debug)]
pub(crate) struct Shape {
    bounds: Bounds,
    origin: [f64; 3],
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    Box,
    /// A normal, and a bound of the products that made it.
    Plane([f64; 3], f64),
    /// A direction, and its largest entry.
    Line([f64; 3], f64),
}

fn rounded(p: &Whole) -> [f64; 3] {
    p.map(|c| c as f64)
}

fn largest(p: &[f64; 3]) -> f64 {
    p.iter().fold(0.0, |m: f64, c| m.max(c.abs()))
}

impl Shape {
    /// All of a box.
    pub(crate) fn within(bounds: Bounds) -> Self {
        Self { bounds, origin: [0.0; 3], kind: Kind::Box }
    }

    /// The part in `bounds` of the plane through three points that are not collinear.
    pub(crate) fn plane(bounds: Bounds, [o, a, b]: [&Whole; 3]) -> Self {
        let [p, q] = [a, b].map(|v| rounded(&[0, 1, 2].map(|k| v[k] - o[k])));
        let normal = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| p[i] * q[j] - p[j] * q[i]);
        let kind = Kind::Plane(normal, largest(&p) * largest(&q));
        Self { bounds, origin: rounded(o), kind }
    }

    /// The points between two points.
    pub(crate) fn segment(a: &Whole, b: &Whole) -> Self {
        let along = rounded(&[0, 1, 2].map(|k| b[k] - a[k]));
        let kind = Kind::Line(along, largest(&along));
        Self { bounds: bounds([*a, *b].into_iter()), origin: rounded(a), kind }
    }

    /// Is a point in the box?
    pub(crate) fn holds(&self, p: &Whole) -> bool {
        (0..3).all(|k| self.bounds[0][k] <= p[k] && p[k] <= self.bounds[1][k])
    }

    /// May the shape meet a box?
    fn may_meet(&self, other: &Bounds) -> bool {
        if !overlap(&self.bounds, other) {
            return false;
        }
        let [low, high] = other.map(|p| rounded(&p));
        // From the shape's origin to the middle of the box, and half of the box.
        let middle = [0, 1, 2].map(|k| (low[k] + high[k]) / 2.0 - self.origin[k]);
        let half = [0, 1, 2].map(|k| (high[k] - low[k]) / 2.0);
        let reach = largest(&low) + largest(&high) + largest(&self.origin);
        match &self.kind {
            Kind::Box => true,
            Kind::Plane(n, size) => {
                let height: f64 = (0..3).map(|k| n[k] * middle[k]).sum();
                let own: f64 = (0..3).map(|k| n[k].abs() * half[k]).sum();
                height.abs() <= own + SLACK * size * reach
            }
            // Seen along each axis.
            Kind::Line(d, size) => [(1, 2), (2, 0), (0, 1)].iter().all(|&(i, j)| {
                let off = middle[i] * d[j] - middle[j] * d[i];
                let own = half[i] * d[j].abs() + half[j] * d[i].abs();
                off.abs() <= own + SLACK * size * reach
            }),
        }
    }
}

/// The tree. Box k is divided into the boxes 2k + 1 and 2k + 2, each with half of the points.
#[derive(Debug)]
pub(crate) struct Tree<'p> {
    points: &'p [Whole],
    order: Vec<u32>,
    boxes: Vec<Bounds>,
}

impl<'p> Tree<'p> {
    /// The tree of the points with these numbers.
    pub(crate) fn new(points: &'p [Whole], order: Vec<u32>) -> Self {
        let mut tree = Self { points, order, boxes: Vec::new() };
        let count = tree.order.len();
        let (mut wanted, mut part) = (1, count);
        while part > FEW {
            (wanted, part) = (2 * wanted + 1, part.div_ceil(2));
        }
        tree.boxes = vec![[[0; 3]; 2]; wanted];
        let mut order = std::mem::take(&mut tree.order);
        tree.divide(0, &mut order);
        tree.order = order;
        tree
    }

    /// Sorts the numbers of a box into its halves. The depth is the logarithm of their number.
    fn divide(&mut self, node: usize, order: &mut [u32]) {
        let own = bounds(order.iter().map(|&v| self.points[v as usize]));
        self.boxes[node] = own;
        if 2 * node + 2 >= self.boxes.len() {
            return;
        }
        let axis = (0..3).max_by_key(|&k| own[1][k].saturating_sub(own[0][k])).unwrap_or(0);
        let middle = order.len().div_ceil(2);
        if middle < order.len() {
            order.select_nth_unstable_by_key(middle, |&v| self.points[v as usize][axis]);
        }
        let (left, right) = order.split_at_mut(middle);
        self.divide(2 * node + 1, left);
        self.divide(2 * node + 2, right);
    }

    /// Gives the points that may be on a shape to `found`; returns the number of steps.
    pub(crate) fn search(&self, shape: &Shape, mut found: impl FnMut(u32)) -> u64 {
        let (mut steps, mut stack) = (0, vec![(0, 0, self.order.len())]);
        while let Some((node, start, end)) = stack.pop() {
            steps += 1;
            if start == end || !shape.may_meet(&self.boxes[node]) {
                continue;
            }
            if 2 * node + 2 >= self.boxes.len() {
                let near = self.order[start..end].iter().copied();
                near.filter(|&v| shape.holds(&self.points[v as usize])).for_each(&mut found);
                continue;
            }
            let middle = start + (end - start).div_ceil(2);
            stack.push((2 * node + 1, start, middle));
            stack.push((2 * node + 2, middle, end));
        }
        steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a lattice, and a few far ones.
    fn points() -> Vec<Whole> {
        let far = 1i128 << 59;
        let lattice = (0..1000).map(|i| [i % 10, i / 10 % 10, i / 100].map(i128::from));
        lattice.chain([[far, 0, 0], [-far, far, 3], [0, -far, -far]]).collect()
    }

    fn found(tree: &Tree<'_>, shape: &Shape, exact: impl Fn(&Whole) -> bool) -> Vec<u32> {
        let mut list = Vec::new();
        tree.search(shape, |v| list.extend(exact(&tree.points[v as usize]).then_some(v)));
        list.sort_unstable();
        list
    }

    #[test]
    fn a_search_passes_over_no_point_of_a_plane_or_a_segment() {
        let points = points();
        let all: Vec<u32> = (0..points.len() as u32).collect();
        let tree = Tree::new(&points, all.clone());
        let corners = [[0, 0, 0], [9, 9, 0], [9, 0, 9], [3, 7, 2], [9, 9, 9], [1 << 59, 0, 0]];
        for a in &corners {
            for b in &corners {
                let along = |p: &Whole| super::super::place::along(*a, *b, *p).is_some();
                let wanted: Vec<u32> =
                    all.iter().copied().filter(|&v| along(&points[v as usize])).collect();
                if a != b {
                    assert_eq!(found(&tree, &Shape::segment(a, b), along), wanted);
                }
                for c in &corners {
                    let own = bounds([*a, *b, *c].into_iter());
                    let shape = Shape::plane(own, [a, b, c]);
                    let flat = |p: &Whole| {
                        shape.holds(p) && super::super::six_volumes([*a, *b, *c, *p]) == 0.into()
                    };
                    let wanted: Vec<u32> =
                        all.iter().copied().filter(|&v| flat(&points[v as usize])).collect();
                    assert_eq!(found(&tree, &shape, flat), wanted);
                }
            }
        }
        let none = Tree::new(&points, Vec::new());
        assert!(found(&none, &Shape::segment(&[0; 3], &[1; 3]), |_| true).is_empty());
    }

    #[test]
    fn a_search_takes_few_steps() {
        let points: Vec<Whole> = (0..1 << 14).map(|i| [i % 128, i / 128, i % 7]).collect();
        let tree = Tree::new(&points, (0..1 << 14).collect());
        // Steps for a few points that are found: the depth, and not the number of points.
        let steps = tree.search(&Shape::segment(&[5, 7, 0], &[6, 8, 6]), |_| {});
        assert!(steps < 64, "{steps}");
        // A line across everything, along which no box is flat.
        let steps = tree.search(&Shape::segment(&[0, 0, 0], &[127, 126, 6]), |_| {});
        assert!(steps < 2000, "{steps}");
    }
}
