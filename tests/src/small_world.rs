//! All Delaunay meshes of the subsets of a few points, by definition and in no time. All conflicts
//! of a world are computed once, by [`crate::epsilon`], and kept as bit masks.
//!
//! "A tetrahedron is in the mesh iff it is not flat and no point is in its perturbed sphere", and
//! the same for the infinite ones over the hull facets, is then one `and` for each.

use crate::epsilon::{self, Small};
use ltbw::Sign;

/// The largest number of points: a set of points is a 32-bit mask.
const MOST: usize = 32;

/// A few distinct integer points and everything about their quadruples and triples.
#[derive(Debug)]
pub struct World {
    points: Vec<Small>,
    /// For a < b < c < d, under `((a * n + b) * n + c) * n + d`: the points in conflict.
    tets: Vec<Conflicts>,
    /// For a < b < c, under `(a * n + b) * n + c`: the points in conflict with the infinite
    /// tetrahedron over a, b, c, and over a, c, b.
    facets: Vec<[Conflicts; 2]>,
}

/// The points in conflict with a simplex; `None` if it is flat.
type Conflicts = Option<u32>;

/// The expected mesh of a subset of a world.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Expected {
    /// Affine dimension: -1 for the empty set.
    pub dimension: i32,
    /// Tetrahedra: ascending, sorted.
    pub tets: Vec<[u32; 4]>,
    /// Hull facets, outward: the smallest vertex first, sorted.
    pub hull: Vec<[u32; 3]>,
}

impl World {
    /// The world of some points.
    ///
    /// # Panics
    /// If there are more than 32, or two are equal.
    #[must_use]
    pub fn new(points: Vec<Small>) -> Self {
        let n = points.len();
        assert!(n <= MOST && (0..n).all(|i| !points[..i].contains(&points[i])));
        let mut world =
            Self { points, tets: vec![None; n.pow(4)], facets: vec![[None; 2]; n.pow(3)] };
        for a in 0..n {
            for b in a + 1..n {
                for c in b + 1..n {
                    world.facets[(a * n + b) * n + c] =
                        [world.beyond([a, b, c]), world.beyond([a, c, b])];
                    for d in c + 1..n {
                        world.tets[((a * n + b) * n + c) * n + d] = world.inside([a, b, c, d]);
                    }
                }
            }
        }
        world
    }

    /// All points of a grid with the given number of points in each direction.
    #[must_use]
    pub fn grid([nx, ny, nz]: [i64; 3]) -> Self {
        let at = |i: i64| [i / (ny * nz), i / nz % ny, i % nz];
        Self::new((0..nx * ny * nz).map(at).collect())
    }

    /// The points.
    #[must_use]
    pub fn points(&self) -> &[Small] {
        &self.points
    }

    fn mask(&self, corners: &[usize], conflict: impl Fn(Small) -> Sign) -> u32 {
        let others = (0..self.points.len()).filter(|i| !corners.contains(i));
        let inside = others.filter(|&i| conflict(self.points[i]) == Sign::Positive);
        inside.fold(0, |mask, i| mask | 1 << i)
    }

    fn inside(&self, corners: [usize; 4]) -> Conflicts {
        let [a, b, c, d] = corners.map(|i| self.points[i]);
        let flat = epsilon::orient3d(&[a, b, c, d]) == Sign::Zero;
        (!flat).then(|| self.mask(&corners, |p| epsilon::side_of_sphere(&[a, b, c, d, p])))
    }

    fn beyond(&self, corners: [usize; 3]) -> Conflicts {
        let [a, b, c] = corners.map(|i| self.points[i]);
        let flat = epsilon::coplanar_orient([a, b, c]) == Sign::Zero;
        (!flat).then(|| self.mask(&corners, |p| epsilon::side_of_hull_facet(&[a, b, c, p])))
    }

    /// The mesh of the points in `set`, by definition.
    #[must_use]
    pub fn mesh(&self, set: u32) -> Expected {
        let n = self.points.len();
        let empty = |conflicts: Conflicts| conflicts.is_some_and(|mask| mask & set == 0);
        let all: Vec<u32> = (0..n as u32).filter(|i| set >> i & 1 == 1).collect();
        let mut mesh = Expected { dimension: all.len().min(2) as i32 - 1, ..Expected::default() };
        for (ia, &a) in all.iter().enumerate() {
            for (ib, &b) in all.iter().enumerate().skip(ia + 1) {
                for (ic, &c) in all.iter().enumerate().skip(ib + 1) {
                    let facet = (a as usize * n + b as usize) * n + c as usize;
                    let [up, down] = self.facets[facet];
                    mesh.dimension = mesh.dimension.max(if up.is_some() { 2 } else { 1 });
                    mesh.hull.extend(empty(up).then_some([a, b, c]));
                    mesh.hull.extend(empty(down).then_some([a, c, b]));
                    for &d in &all[ic + 1..] {
                        let conflicts = self.tets[facet * n + d as usize];
                        mesh.tets.extend(empty(conflicts).then_some([a, b, c, d]));
                        mesh.dimension =
                            mesh.dimension.max(if conflicts.is_some() { 3 } else { 1 });
                    }
                }
            }
        }
        mesh.hull.sort_unstable();
        mesh
    }
}

/// All sets of `size` of `count` points, as masks, ascending.
pub fn subsets(count: usize, size: usize) -> impl Iterator<Item = u32> {
    assert!(count <= MOST && 0 < size && size <= count);
    let first = (1u64 << size) - 1;
    // The next larger number with as many bits (Gosper).
    let next = |&set: &u64| {
        let low = set & set.wrapping_neg();
        let ripple = set + low;
        Some((((ripple ^ set) >> 2) / low) | ripple)
    };
    std::iter::successors(Some(first), next)
        .take_while(move |set| set >> count == 0)
        .map(|set| set as u32)
}

#[cfg(test)]
mod tests {
    use super::{World, subsets};

    #[test]
    fn subsets_are_all_there() {
        assert_eq!(subsets(5, 2).collect::<Vec<_>>(), [3, 5, 6, 9, 10, 12, 17, 18, 20, 24]);
        assert_eq!(subsets(27, 5).count(), 80_730);
        assert_eq!(subsets(32, 32).collect::<Vec<_>>(), [u32::MAX]);
    }

    #[test]
    fn meshes_by_definition_are_balls() {
        let world = World::grid([2, 2, 2]);
        let cube = world.mesh(0xff);
        assert_eq!((cube.dimension, cube.hull.len()), (3, 12));
        assert!(cube.tets.len() == 5 || cube.tets.len() == 6);
        assert_eq!(world.mesh(0xf).dimension, 2);
        assert_eq!(world.mesh(0x3).dimension, 1);
        // Each hull facet is the face of exactly one tetrahedron.
        for mut facet in cube.hull {
            facet.sort_unstable();
            let owners = cube.tets.iter().filter(|t| facet.iter().all(|v| t.contains(v)));
            assert_eq!(owners.count(), 1);
        }
    }
}
