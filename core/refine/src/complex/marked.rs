//! Sizing by tetrahedra that are to be split: half of the volume of each, inside it.

use super::background::{BackgroundError, Leaf, is_inside};
use super::measure::USUAL_EDGE;
use ltbw_core::TetMesh;
use ltbw_domain::vector::{cross, dot, minus};
use ltbw_exact::Point;
use rstar::{AABB, RTree};

/// Tetrahedra that are to be split, as edge lengths: inside of one that of the regular tetrahedron
/// with half of its volume, elsewhere none.
#[derive(Debug)]
pub struct Marked {
    corners: Vec<[Point; 4]>,
    lengths: Vec<f64>,
    boxes: RTree<Leaf>,
}

impl Marked {
    /// The tetrahedra of these numbers.
    ///
    /// # Errors
    /// [`BackgroundError`]: a number that names no tetrahedron; no number; corners that are not
    /// there.
    pub fn new(mesh: &TetMesh, numbers: &[usize]) -> Result<Self, BackgroundError> {
        let mut corners = Vec::with_capacity(numbers.len());
        for &tet in numbers {
            let own = mesh.tets.get(tet).ok_or(BackgroundError::Index { tet })?;
            let at = |v: &u32| mesh.points.get(*v as usize).copied();
            let own: Option<Vec<Point>> = own.iter().map(at).collect();
            let own = own.and_then(|own| <[Point; 4]>::try_from(own).ok());
            corners.push(own.ok_or(BackgroundError::Index { tet })?);
        }
        if corners.is_empty() {
            return Err(BackgroundError::Empty);
        }
        let length = |[a, b, c, d]: &[Point; 4]| {
            let volume = dot(&cross(&minus(b, a), &minus(c, a)), &minus(d, a)).abs() / 6.0;
            (volume / 2.0 * 6.0 * 2.0_f64.sqrt()).cbrt() / USUAL_EDGE
        };
        let leaves = (0..).zip(&corners).map(|(k, own)| Leaf::of(k, own)).collect();
        let lengths = corners.iter().map(length).collect();
        Ok(Self { boxes: RTree::bulk_load(leaves), lengths, corners })
    }

    /// The usual edge length at a place, as a sizing function has it: infinite outside of them.
    #[must_use]
    pub fn at(&self, p: Point) -> f64 {
        let near = self.boxes.locate_in_envelope_intersecting(AABB::from_point(p));
        let own = near.filter(|leaf| is_inside(self.corners[leaf.tet as usize].each_ref(), &p));
        own.map(|leaf| self.lengths[leaf.tet as usize]).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marked_tetrahedra_ask_for_half_of_their_volume() {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]];
        let mesh = TetMesh { points, tets: vec![[0, 1, 2, 3], [1, 2, 3, 4]], ..TetMesh::default() };
        let marked = Marked::new(&mesh, &[0]).expect("a tetrahedron");
        let length = USUAL_EDGE * marked.at([0.25; 3]);
        assert!((length.powi(3) / (6.0 * 2.0_f64.sqrt()) - 1.0 / 12.0).abs() < 1e-15);
        assert_eq!(marked.at([0.6; 3]), f64::INFINITY);
        let wrong = Marked::new(&mesh, &[1, 2]).expect_err("two tetrahedra");
        assert_eq!(wrong, BackgroundError::Index { tet: 2 });
        assert_eq!(Marked::new(&mesh, &[]).expect_err("no number"), BackgroundError::Empty);
    }
}
