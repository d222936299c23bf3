//! Which points of a plane are inside polygons: by the weights of the edges to the right of them.
//!
//! A polygon of weight w adds w to its edges that run upwards, counterclockwise around it, and -w
//! to those that run downwards: the sum over the edges to the right of a point is w inside and 0
//! outside. Edges that polygons have in common are one edge, and are left out if they add nothing:
//! so of a plane of many triangles the outline is left.
//!
//! The levels of all ends cut the plane into strips. An edge is kept in few nodes of a binary tree
//! of strips, each all of whose strips it crosses; in a node edges are sorted from left to right.
//! A point looks for its place in the nodes of its strip. In all n log n, and for each point the
//! square of the logarithm. Edges that cross each other would be sorted somehow; the mesh has them
//! as chains of edges, which do not cross.

use super::whole::twice_area;
use num_bigint::BigInt;

/// A point of the plane: two of its coordinates, times three (below 2^62).
pub(crate) type Flat = [i128; 2];

/// So few edges are simply looked through.
const FEW: usize = 16;

/// An edge from its lower end to its higher one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    ends: [Flat; 2],
    weight: i64,
}

impl Edge {
    /// Is it strictly to the right of a point that is between its levels?
    fn is_right_of(&self, p: Flat) -> bool {
        twice_area(self.ends[0], self.ends[1], p) > 0
    }

    /// The place at a level between its ends, exactly: a whole number, and what is left of a
    /// fraction as numerator and denominator.
    fn at(&self, level: i128) -> Place {
        let [a, b] = self.ends;
        let (across, up) = (b[0] - a[0], b[1] - a[1]);
        // Factors are below 2^63.
        let product = (level - a[1]) * across;
        Place { whole: a[0] + product.div_euclid(up), rest: product.rem_euclid(up), of: up }
    }
}

/// An exact place along a level: whole + rest / of.
#[derive(Debug, PartialEq, Eq)]
struct Place {
    whole: i128,
    rest: i128,
    of: i128,
}

impl Ord for Place {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let fraction = || (self.rest * other.of).cmp(&(other.rest * self.of));
        self.whole.cmp(&other.whole).then_with(fraction)
    }
}

impl PartialOrd for Place {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// The edges that cross all strips of a node, from left to right, and the sums of the weights from
/// each on.
#[derive(Debug, Default)]
struct Node {
    edges: Vec<Edge>,
    sums: Vec<i64>,
}

/// Polygons with weights.
#[derive(Debug, Default)]
pub(crate) struct Outline {
    edges: Vec<Edge>,
    levels: Vec<i128>,
    /// Node k has the strips of the nodes 2k and 2k + 1; the last half of the nodes have one each.
    nodes: Vec<Node>,
}

/// Twice the signed area of a polygon.
pub(crate) fn signed_area(polygon: &[Flat]) -> BigInt {
    (2..polygon.len())
        .map(|i| BigInt::from(twice_area(polygon[0], polygon[i - 1], polygon[i])))
        .sum()
}

/// A polygon, and the weight of what is in it.
#[derive(Clone, Copy)]
pub(crate) struct Weighted<'a> {
    pub(crate) polygon: &'a [Flat],
    pub(crate) weight: i8,
}

impl<'a> Weighted<'a> {
    /// A polygon that counts once.
    pub(crate) fn once(polygon: &'a [Flat]) -> Self {
        Self { polygon, weight: 1 }
    }
}

impl Outline {
    /// The outline of polygons.
    pub(crate) fn new<'a>(polygons: impl Iterator<Item = Weighted<'a>>) -> Self {
        let mut edges: Vec<Edge> = Vec::new();
        for Weighted { polygon, weight } in polygons {
            let is_turned = signed_area(polygon) < BigInt::ZERO;
            let up = if is_turned { -i64::from(weight) } else { i64::from(weight) };
            for (k, &a) in polygon.iter().enumerate() {
                let b = polygon[(k + 1) % polygon.len()];
                match b[1].cmp(&a[1]) {
                    std::cmp::Ordering::Greater => edges.push(Edge { ends: [a, b], weight: up }),
                    std::cmp::Ordering::Less => edges.push(Edge { ends: [b, a], weight: -up }),
                    std::cmp::Ordering::Equal => {}
                }
            }
        }
        edges.sort_unstable();
        edges.dedup_by(|next, first| {
            let is_same = next.ends == first.ends;
            first.weight += if is_same { next.weight } else { 0 };
            is_same
        });
        edges.retain(|edge| edge.weight != 0);
        let mut outline = Self { edges, ..Self::default() };
        if outline.edges.len() > FEW {
            outline.build();
        }
        outline
    }

    fn build(&mut self) {
        self.levels = self.edges.iter().flat_map(|edge| edge.ends.map(|p| p[1])).collect();
        self.levels.sort_unstable();
        self.levels.dedup();
        let strips = self.levels.len().next_power_of_two();
        self.nodes.resize_with(2 * strips, Node::default);
        let strip = |level: i128| self.levels.partition_point(|&l| l < level);
        for edge in &self.edges {
            let [mut from, mut to] = edge.ends.map(|p| strips + strip(p[1]));
            // The largest nodes within the edge, from both ends: each turn is a floor higher.
            while from < to {
                if from % 2 == 1 {
                    self.nodes[from].edges.push(*edge);
                    from += 1;
                }
                if to % 2 == 1 {
                    to -= 1;
                    self.nodes[to].edges.push(*edge);
                }
                (from, to) = (from / 2, to / 2);
            }
        }
        for (k, node) in self.nodes.iter_mut().enumerate().skip(1) {
            if node.edges.is_empty() {
                continue;
            }
            let shift = strips.ilog2() - k.ilog2();
            let first = (k << shift) - strips;
            let ends = [first, first + (1 << shift)].map(|strip| self.levels[strip]);
            node.edges.sort_by_cached_key(|edge| ends.map(|level| edge.at(level)));
            let mut sum = 0;
            node.sums = node
                .edges
                .iter()
                .rev()
                .map(|edge| edge.weight)
                .map(|w| {
                    sum += w;
                    sum
                })
                .collect();
            node.sums.reverse();
        }
    }

    /// The sum of the weights of the polygons that a point is inside; on an edge, of one of its
    /// sides. `steps` counts the comparisons.
    pub(crate) fn weight_at(&self, p: Flat, steps: &mut u64) -> i64 {
        if self.nodes.is_empty() {
            *steps += self.edges.len() as u64;
            let right = self.edges.iter().filter(|edge| {
                let [a, b] = edge.ends;
                a[1] <= p[1] && p[1] < b[1] && edge.is_right_of(p)
            });
            return right.map(|edge| edge.weight).sum();
        }
        let above = self.levels.partition_point(|&level| level <= p[1]);
        if above == 0 || above == self.levels.len() {
            return 0;
        }
        let (mut sum, mut k) = (0, self.nodes.len() / 2 + above - 1);
        while k > 0 {
            let node = &self.nodes[k];
            let first = node.edges.partition_point(|edge| {
                *steps += 1;
                !edge.is_right_of(p)
            });
            sum += node.sums.get(first).copied().unwrap_or(0);
            *steps += 1;
            k /= 2;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conform::facet::encloses;

    /// A comb: a back and teeth that lean and have different lengths, all corners on a lattice.
    fn comb(teeth: i128, lean: i128) -> Vec<Flat> {
        let mut ring = vec![[4 * teeth, 0], [4 * teeth, -3], [0, -3]];
        for k in 0..teeth {
            let high = 20 + k * 7 % 11;
            ring.extend([[4 * k, 0], [4 * k + lean, high], [4 * k + lean + 2, high + 1]]);
            ring.push([4 * k + 2, 0]);
        }
        ring
    }

    fn agree(polygons: &[(Vec<Flat>, i8)]) {
        let outline = Outline::new(
            polygons.iter().map(|(polygon, weight)| Weighted { polygon, weight: *weight }),
        );
        for x in -3..60 {
            for y in -5..40 {
                let inside = polygons.iter().filter(|(p, _)| encloses(p, [x, y]));
                let wanted: i64 = inside.map(|(_, w)| i64::from(*w)).sum();
                assert_eq!(outline.weight_at([x, y], &mut 0), wanted, "{:?}", [x, y]);
            }
        }
    }

    #[test]
    fn weights_are_those_of_rays_through_all_edges() {
        let square =
            |low: i128, high: i128| vec![[low, low], [high, low], [high, high], [low, high]];
        for lean in [0, 1, 5, -7] {
            let mut turned = comb(8, lean);
            agree(&[(turned.clone(), 1)]);
            turned.reverse();
            let slot = vec![[5, -2], [9, -2], [9, -1], [5, -1]];
            agree(&[(turned, 1), (square(-30, 70), 1), (square(-29, 69), -1), (slot, 1)]);
        }
        // Triangles of a square of squares, turned as it comes.
        let mut triangles = Vec::new();
        for (x, y) in (0..36).map(|k| (6 * (k % 6), 6 * (k / 6))) {
            triangles.push((vec![[x, y], [x + 6, y], [x + 6, y + 6]], 1));
            triangles.push((vec![[x, y], [x, y + 6], [x + 6, y + 6]], 1));
        }
        agree(&triangles);
        let far: Vec<Flat> = vec![[-(3 << 60), -(3 << 60)], [3 << 60, 0], [5, 3 << 60]];
        let outline = Outline::new(vec![&far[..]; 20].into_iter().map(Weighted::once));
        assert_eq!(outline.weight_at([0, 0], &mut 0), 20);
        assert_eq!(outline.weight_at([3 << 60, 1], &mut 0), 0);
    }

    #[test]
    fn edges_that_cross_are_no_trouble() {
        let star: Vec<Flat> = (0..40).map(|k| [k * 17 % 41, k * 29 % 37]).collect();
        let outline = Outline::new([Weighted::once(&star)].into_iter());
        let sum: i64 = (0..40).map(|x| outline.weight_at([x, x], &mut 0)).sum();
        assert!(sum.abs() <= 40 * 40);
    }

    #[test]
    fn a_point_takes_few_steps_on_a_comb_of_many_teeth() {
        for (teeth, most) in [(1 << 8, 200), (1 << 12, 300)] {
            for lean in [0, 3] {
                let outline = Outline::new([Weighted::once(&comb(teeth, lean))].into_iter());
                let mut steps = 0;
                let at = |k: i128| [k * 9 % teeth, k % 20];
                let inside = (0..100).filter(|&k| outline.weight_at(at(k), &mut steps) > 0);
                assert!(inside.count() > 0);
                assert!(steps < 100 * most, "{steps}");
            }
        }
    }
}
