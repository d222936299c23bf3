//! Sizing by a background mesh: an edge length at each of its points, linear in between.
//!
//! Sizes at the input vertices of a domain are the special case of the Delaunay mesh of these
//! vertices. Interpolation is rounded, but the same for the same place: the sizes are a wish, and
//! the bound that a refinement derives from them is tested exactly.
//!
//! Cost: a tree of the tetrahedra's boxes; one look at it for every new tetrahedron of a
//! refinement.

use ltbw_core::build::BuildError;
use ltbw_core::{Builder, TetMesh};
use ltbw_domain::Prepared;
use ltbw_domain::vector::{cross, dot, minus};
use ltbw_exact::points::PointError;
use ltbw_exact::{Point, PointSet};
use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree, RTreeObject};

/// Why there is no background mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BackgroundError {
    /// Sizes and points are not equally many.
    #[error("{sizes} sizes for {points} points")]
    Count {
        /// The number of sizes.
        sizes: usize,
        /// The number of points.
        points: usize,
    },
    /// A size is not a length.
    #[error("size {number} is {size:?}; an edge length is positive and finite")]
    Size {
        /// Its place in the list.
        number: usize,
        /// The size.
        size: f64,
    },
    /// A tetrahedron names a point that does not exist.
    #[error("tetrahedron {tet} names a point that is not there")]
    Index {
        /// Its place in the list.
        tet: usize,
    },
    /// The mesh has no tetrahedra.
    #[error("a background mesh without tetrahedra")]
    Empty,
    /// The points are not a point set.
    #[error(transparent)]
    Points(#[from] PointError),
    /// The points have no mesh.
    #[error(transparent)]
    Build(#[from] BuildError),
}

/// A tetrahedron in the tree: its box, and its place in the list.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    low: Point,
    high: Point,
    pub(super) tet: u32,
}

impl Leaf {
    pub(super) fn of(tet: u32, p: &[Point; 4]) -> Self {
        let fold =
            |f: fn(f64, f64) -> f64| [0, 1, 2].map(|k| p.iter().map(|p| p[k]).fold(p[0][k], f));
        Self { low: fold(f64::min), high: fold(f64::max), tet }
    }
}

impl RTreeObject for Leaf {
    type Envelope = AABB<Point>;

    fn envelope(&self) -> AABB<Point> {
        AABB::from_corners(self.low, self.high)
    }
}

/// Edge lengths at the points of a mesh.
///
/// ```
/// use ltbw_refine::Background;
/// let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let sizes = Background::of_points(&points, &[0.1, 0.5, 0.5, 0.5])?;
/// assert!((sizes.at([0.5, 0.0, 0.0]) - 0.3).abs() < 1e-12);
/// assert_eq!(sizes.at([-3.0, 0.0, 0.0]), 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Background {
    points: Vec<Point>,
    tets: Vec<[u32; 4]>,
    sizes: Vec<f64>,
    boxes: RTree<Leaf>,
    corners: RTree<GeomWithData<Point, u32>>,
}

impl Background {
    /// Sizes at the points of any tetrahedral mesh.
    ///
    /// # Errors
    /// [`BackgroundError`] says what does not fit.
    pub fn new(mesh: &TetMesh, sizes: &[f64]) -> Result<Self, BackgroundError> {
        let points = mesh.points.len();
        if sizes.len() != points {
            return Err(BackgroundError::Count { sizes: sizes.len(), points });
        }
        if let Some(number) = sizes.iter().position(|s| !(s.is_finite() && *s > 0.0)) {
            return Err(BackgroundError::Size { number, size: sizes[number] });
        }
        PointSet::new(mesh.points.clone())?;
        let missing = |tet: &[u32; 4]| tet.iter().any(|&v| v as usize >= points);
        if let Some(tet) = mesh.tets.iter().position(missing) {
            return Err(BackgroundError::Index { tet });
        }
        if mesh.tets.is_empty() {
            return Err(BackgroundError::Empty);
        }
        let corners = |v: &[u32; 4]| v.map(|v| mesh.points[v as usize]);
        let leaves = (0..).zip(&mesh.tets).map(|(tet, v)| Leaf::of(tet, &corners(v)));
        let used = (0..).zip(&mesh.points).map(|(v, &p)| GeomWithData::new(p, v));
        Ok(Self {
            boxes: RTree::bulk_load(leaves.collect()),
            corners: RTree::bulk_load(used.collect()),
            points: mesh.points.clone(),
            tets: mesh.tets.clone(),
            sizes: sizes.to_vec(),
        })
    }

    /// Sizes at points, linear in the tetrahedra of their Delaunay mesh. Of points at one place the
    /// first counts.
    ///
    /// # Errors
    /// [`BackgroundError`] says what does not fit.
    pub fn of_points(points: &[Point], sizes: &[f64]) -> Result<Self, BackgroundError> {
        let mesh = Builder::new().build(&PointSet::new(points.to_vec())?)?.mesh;
        let mesh =
            TetMesh { points: points.to_vec(), tets: mesh.tets().collect(), ..TetMesh::default() };
        Self::new(&mesh, sizes)
    }

    /// Sizes at the vertices of the input of a prepared domain; of vertices that
    /// became one the least size counts.
    ///
    /// # Errors
    /// [`BackgroundError`] says what does not fit.
    pub fn at_vertices(ready: &Prepared, sizes: &[f64]) -> Result<Self, BackgroundError> {
        let mut vertices = ready.domain.vertices.clone();
        vertices.extend(&ready.domain.points);
        let points = ready.vertex_map.len();
        if sizes.len() != points {
            return Err(BackgroundError::Count { sizes: sizes.len(), points });
        }
        if let Some(number) = sizes.iter().position(|s| !(s.is_finite() && *s > 0.0)) {
            return Err(BackgroundError::Size { number, size: sizes[number] });
        }
        // Nothing is said of points beside the vertices.
        let mut own = vec![f64::INFINITY; vertices.len()];
        for (&v, &size) in ready.vertex_map.iter().zip(sizes) {
            if let Some(own) = own.get_mut(v as usize) {
                *own = own.min(size);
            }
        }
        let known = |(k, p): (usize, &Point)| own[k].is_finite().then_some(*p);
        let vertices: Vec<Point> = vertices.iter().enumerate().filter_map(known).collect();
        own.retain(|size| size.is_finite());
        Self::of_points(&vertices, &own)
    }

    /// The edge length at a place; outside the mesh that of the nearest of its points.
    #[must_use]
    pub fn at(&self, p: Point) -> f64 {
        // Of several tetrahedra, by rounding or because they overlap, the one with p deepest
        // inside.
        let mut best: Option<(f64, u32, [f64; 4])> = None;
        for leaf in self.boxes.locate_in_envelope_intersecting(AABB::from_point(p)) {
            let corners = self.tets[leaf.tet as usize].map(|v| &self.points[v as usize]);
            let Some(weights) = barycentric(corners, &p) else { continue };
            let depth = weights.into_iter().fold(f64::INFINITY, f64::min);
            let deeper = best.is_none_or(|(d, t, _)| depth > d || depth == d && leaf.tet < t);
            if depth >= -ROUNDING && deeper {
                best = Some((depth, leaf.tet, weights));
            }
        }
        if let Some((_, tet, weights)) = best {
            let sizes = self.tets[tet as usize].map(|v| self.sizes[v as usize]);
            let (low, high) =
                sizes.iter().fold((sizes[0], sizes[0]), |(l, h), &s| (s.min(l), s.max(h)));
            let sum: f64 = sizes.iter().zip(weights).map(|(s, w)| s * w).sum();
            return sum.clamp(low, high);
        }
        let nearest = self.corners.nearest_neighbor(p);
        nearest.map_or(f64::INFINITY, |corner| self.sizes[corner.data as usize])
    }
}

/// A place counts as inside a tetrahedron if rounding may have put it out.
const ROUNDING: f64 = 1e-9;

/// Is a place in a tetrahedron, or out of it by rounding alone?
pub(super) fn is_inside(corners: [&Point; 4], p: &Point) -> bool {
    barycentric(corners, p).is_some_and(|all| all.iter().all(|weight| *weight >= -ROUNDING))
}

/// The weights of the corners whose mean `p` is, rounded; `None` for a flat tetrahedron.
fn barycentric([a, b, c, d]: [&Point; 4], p: &Point) -> Option<[f64; 4]> {
    let det = |a: &Point, b: &Point, c: &Point, d: &Point| {
        let (x, y, z) = (minus(a, d), minus(b, d), minus(c, d));
        dot(&x, &cross(&y, &z))
    };
    let whole = det(a, b, c, d);
    let parts = [det(p, b, c, d), det(a, p, c, d), det(a, b, p, d), det(a, b, c, p)];
    let weights = parts.map(|part| part / whole);
    weights.iter().all(|w| w.is_finite()).then_some(weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_function_is_given_back() {
        // The corners of a box and points inside: 1 + x + 2y + 3z.
        let mut points: Vec<Point> =
            (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
        points.extend([[0.3, 0.4, 0.7], [0.8, 0.1, 0.2], [0.5; 3]]);
        let size = |p: &Point| 1.0 + p[0] + 2.0 * p[1] + 3.0 * p[2];
        let sizes: Vec<f64> = points.iter().map(size).collect();
        let field = Background::of_points(&points, &sizes).expect("a mesh");
        for k in 0..1000 {
            let p = [k % 10, k / 10 % 10, k / 100].map(|c| f64::from(c) / 9.0);
            assert!((field.at(p) - size(&p)).abs() < 1e-12, "{p:?}");
        }
        // Outside: the nearest point.
        assert_eq!(field.at([2.0, 2.0, 2.0]), 7.0);
        assert_eq!(field.at([-1.0, 0.0, 0.0]), 1.0);
    }

    #[test]
    fn what_does_not_fit_is_said() {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let error = |sizes: &[f64]| Background::of_points(&points, sizes).expect_err("no field");
        assert_eq!(error(&[1.0; 3]), BackgroundError::Count { sizes: 3, points: 4 });
        for size in [0.0, -1.0, f64::INFINITY] {
            assert_eq!(error(&[1.0, size, 1.0, 1.0]), BackgroundError::Size { number: 1, size });
        }
        assert!(matches!(
            error(&[1.0, f64::NAN, 1.0, 1.0]),
            BackgroundError::Size { number: 1, .. }
        ));
        let mesh = |tets| TetMesh { points: points.clone(), tets, ..TetMesh::default() };
        let error = |tets| Background::new(&mesh(tets), &[1.0; 4]).expect_err("no field");
        assert_eq!(error(vec![]), BackgroundError::Empty);
        assert_eq!(error(vec![[0, 1, 2, 3], [0, 1, 2, 4]]), BackgroundError::Index { tet: 1 });
        let flat = Background::of_points(&points[..3], &[1.0; 3]).expect_err("no mesh");
        assert!(matches!(flat, BackgroundError::Build(_)), "{flat}");
    }
}
