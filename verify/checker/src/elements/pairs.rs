//! Pairs of things that may meet: all, but for those that a plane separates.
//!
//! The things of two lists are divided by a plane, those that it cuts going to both sides; pairs
//! on different sides are separated and never looked at. Each side is divided again, until few
//! pairs are left, which are asked.
//!
//! Boxes alone would not do: those of needles around one edge, or of cones of one apex, all have
//! points in common. So if no plane of an axis divides well, planes through faces of tetrahedra
//! are tried: in a mesh, they run between the needles. Planes are chosen by samples, and by how
//! many pairs they leave; a choice is good or bad for the time, never for the answer. Things that
//! no plane of these divides (a heap of crossed needles that do not touch) are compared pair by
//! pair.

use super::plane::Plane;
use crate::mesh::{OUTWARD, Point};
use crate::predicates::Tally;

/// Pairs that are not divided further.
const FEW: usize = 1024;
/// Divisions one in the other, at most.
const DEEPEST: usize = 100;
/// Things of a list by which a plane is chosen.
const SAMPLE: usize = 24;
/// Things of a sample whose tetrahedra's faces are tried.
const KNIVES: usize = 2;
/// Things that are divided on more than one thread.
const MANY: usize = 1 << 13;

/// A thing: a tetrahedron, a face, an edge, a vertex.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item {
    /// Its corners; if there are fewer than four, some of them again.
    pub(super) corners: [u32; 4],
    /// A tetrahedron that it is of, not a flat one.
    pub(super) owner: u32,
    /// The vertex whose side of a plane counts if all corners are on it; without one, both do.
    pub(super) apex: Option<u32>,
}

/// A search for pairs of things that meet.
pub(super) struct Search<'a, M> {
    pub(super) points: &'a [Point],
    pub(super) tets: &'a [[u32; 4]],
    pub(super) first: &'a [Item],
    pub(super) second: &'a [Item],
    /// Whether two meet. Not asked of pairs that a plane separates.
    pub(super) meet: M,
    /// Meetings told of one thing of the first list, each time that it is asked.
    pub(super) most: usize,
}

/// The pairs that meet, as places in the lists, ascending.
#[derive(Default)]
pub(super) struct Found {
    pub(super) pairs: Vec<(u32, u32)>,
    /// The tests made: sides of planes, boxes, meetings.
    pub(super) tally: Tally,
}

impl Found {
    fn merge(mut self, other: Self) -> Self {
        self.pairs.extend(other.pairs);
        self.tally.merge(other.tally);
        self
    }
}

impl<M: Fn(&Item, &Item, &mut Tally) -> bool + Sync> Search<'_, M> {
    /// Finds the pairs that meet.
    pub(super) fn run(&self) -> Found {
        let all = |items: &[Item]| (0..items.len() as u32).collect();
        let mut found = self.divide(all(self.first), all(self.second), 0);
        found.pairs.sort_unstable();
        found.pairs.dedup();
        found
    }

    fn divide(&self, a: Vec<u32>, b: Vec<u32>, depth: usize) -> Found {
        let mut tally = Tally::default();
        let halves = match depth < DEEPEST {
            true => self.halves(&a, &b, &mut tally),
            false => None,
        };
        let mut found = match halves {
            None => self.ask(&a, &b),
            Some([(a0, b0), (a1, b1)]) => {
                let many = a.len() + b.len() > MANY;
                drop((a, b));
                let one = || self.divide(a0, b0, depth + 1);
                let other = || self.divide(a1, b1, depth + 1);
                let (one, other) = if many { rayon::join(one, other) } else { (one(), other()) };
                one.merge(other)
            }
        };
        found.tally.merge(tally);
        found
    }

    /// The things of both lists on either side of a plane that leaves clearly fewer pairs. The more
    /// pairs there are, the more planes are tried, and the larger are the samples; the tests for it
    /// stay fewer than the pairs.
    fn halves(&self, a: &[u32], b: &[u32], tally: &mut Tally) -> Option<[(Vec<u32>, Vec<u32>); 2]> {
        let pairs = a.len() * b.len();
        let mut effort = 1;
        while effort * effort * FEW < pairs {
            if let Some(plane) = self.plane(a, b, effort, tally) {
                let [a0, a1] = self.sides(&plane, self.first, a, tally);
                let [b0, b1] = self.sides(&plane, self.second, b, tally);
                // The sample may have deceived.
                if a0.len() * b0.len() + a1.len() * b1.len() <= pairs / 8 * 7 {
                    return Some([(a0, b0), (a1, b1)]);
                }
            }
            effort *= 2;
        }
        None
    }

    /// Asks all pairs whose boxes have a point in common.
    fn ask(&self, a: &[u32], b: &[u32]) -> Found {
        let mut found = Found::default();
        let boxes: Vec<[Point; 2]> = match a {
            [] => Vec::new(),
            _ => b.iter().map(|&j| self.bounds(&self.second[j as usize])).collect(),
        };
        for &i in a {
            let one = &self.first[i as usize];
            let bounds = self.bounds(one);
            let mut left = self.most;
            for (&j, other) in b.iter().zip(&boxes) {
                found.tally.filter += 1;
                if touch(&bounds, other)
                    && (self.meet)(one, &self.second[j as usize], &mut found.tally)
                {
                    found.pairs.push((i, j));
                    left -= 1;
                    if left == 0 {
                        break;
                    }
                }
            }
        }
        found
    }

    fn at(&self, v: u32) -> &Point {
        &self.points[v as usize]
    }

    /// The least and the largest coordinates.
    fn bounds(&self, item: &Item) -> [Point; 2] {
        let [mut low, mut high] = [*self.at(item.corners[0]); 2];
        for p in item.corners[1..].iter().map(|&v| self.at(v)) {
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        [low, high]
    }

    /// The things on either side of a plane.
    fn sides(
        &self,
        plane: &Plane<'_>,
        items: &[Item],
        list: &[u32],
        tally: &mut Tally,
    ) -> [Vec<u32>; 2] {
        let mut sides = [Vec::new(), Vec::new()];
        for &i in list {
            let on = self.side(plane, &items[i as usize], tally);
            (0..2).filter(|&side| on[side]).for_each(|side| sides[side].push(i));
        }
        sides
    }

    /// Whether a thing counts on the negative and on the positive side of a plane.
    fn side(&self, plane: &Plane<'_>, item: &Item, tally: &mut Tally) -> [bool; 2] {
        let mut on = [false; 2];
        for &v in &item.corners {
            match plane.side(self.at(v), tally) {
                0 => {}
                side => on[usize::from(side > 0)] = true,
            }
        }
        if on == [false; 2] {
            let side = item.apex.map_or(0, |v| plane.side(self.at(v), tally));
            on = [side <= 0, side >= 0];
        }
        on
    }

    /// The plane that leaves the fewest pairs of two samples, if it leaves three quarters of them
    /// at most.
    fn plane<'s>(
        &'s self,
        a: &[u32],
        b: &[u32],
        effort: usize,
        tally: &mut Tally,
    ) -> Option<Plane<'s>> {
        let items = |all, list| spread(list, SAMPLE * effort).map(|&i| item(all, i)).collect();
        let a: Vec<&Item> = items(self.first, a);
        let b: Vec<&Item> = items(self.second, b);
        let pairs = a.len() * b.len();
        let (mut least, mut best) = (pairs, None);
        let mut weigh = |plane: Plane<'s>, tally: &mut Tally| {
            let mut sides = [[0usize; 2]; 2];
            for (list, count) in [&a, &b].into_iter().zip(&mut sides) {
                for item in list {
                    let on = self.side(&plane, item, tally);
                    (0..2).for_each(|side| count[side] += usize::from(on[side]));
                }
            }
            let left = sides[0][0] * sides[1][0] + sides[0][1] * sides[1][1];
            if left < least {
                (least, best) = (left, Some(plane));
            }
            least
        };
        let mut so_far = pairs;
        for list in [&a, &b] {
            for k in 0..3 {
                // The least coordinates: of cells of a grid, those of planes between them.
                let mut all: Vec<f64> = list.iter().map(|item| self.bounds(item)[0][k]).collect();
                all.sort_unstable_by(f64::total_cmp);
                so_far = weigh(Plane::Axis(k, all[all.len() / 2]), tally);
            }
        }
        if 8 * so_far > 5 * pairs {
            for item in [&a, &b].into_iter().flat_map(|list| spread(list, KNIVES * effort)) {
                let tet = self.tets[item.owner as usize];
                for face in OUTWARD {
                    weigh(Plane::Through(face.map(|k| self.at(tet[k]))), tally);
                }
            }
        }
        best.filter(|_| 4 * least <= 3 * pairs)
    }
}

fn item(all: &[Item], i: u32) -> &Item {
    &all[i as usize]
}

/// At most `most` of a list, evenly spread.
fn spread<T>(list: &[T], most: usize) -> impl Iterator<Item = &T> {
    let count = list.len().min(most);
    (0..count).map(move |k| &list[k * list.len() / count])
}

/// Whether two boxes have a point in common.
fn touch([low, high]: &[Point; 2], [least, most]: &[Point; 2]) -> bool {
    (0..3).all(|k| low[k] <= most[k] && least[k] <= high[k])
}
