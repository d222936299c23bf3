//! Is a mesh Delaunay? Each tetrahedron that the Delaunay mesh of all vertices has is; of others a
//! vertex is looked for that is strictly inside the circumsphere. Where there is none vertices are
//! on one sphere, which may be divided in several ways.

use super::{NONE, Skin, SkinError};
use crate::vector::{cross, dot, minus};
use ltbw_core::Builder;
use ltbw_exact::predicates::{Sign, insphere};
use ltbw_exact::{Point, PointSet};
use rstar::RTree;
use rstar::primitives::GeomWithData;
use std::cell::OnceCell;
use std::collections::HashSet;

/// The part by which a rounded sphere is taken larger.
const ROUNDING: f64 = 1e-6;

impl Skin<'_> {
    /// Finds the first tetrahedron with a vertex strictly inside its circumsphere.
    ///
    /// # Errors
    /// [`SkinError::NotDelaunay`] names the two; vertices that have no mesh.
    pub fn check_delaunay(&self) -> Result<(), SkinError> {
        let [mut used, inner] = self.vertices();
        used.extend(inner);
        used.sort_unstable();
        let failed = |error: &dyn ToString| SkinError::Vertices(error.to_string());
        let set = PointSet::new(self.places(&used)).map_err(|e| failed(&e))?;
        let built = Builder::new().build(&set).map_err(|e| failed(&e))?.mesh;
        let ascending = |mut v: [u32; 4]| {
            v.sort_unstable();
            v
        };
        let known: HashSet<[u32; 4]> =
            built.tets().map(|v| ascending(v.map(|v| used[v as usize]))).collect();
        let tree = OnceCell::new();
        for (t, v) in self.tets.iter().enumerate() {
            if known.contains(&ascending(*v)) {
                continue;
            }
            let across = self.across(t);
            let all = || {
                let place = |&v: &u32| GeomWithData::new(*self.at(v), v);
                RTree::bulk_load(used.iter().map(place).collect())
            };
            let found = across.or_else(|| self.inside(v, tree.get_or_init(all)));
            if let Some(vertex) = found {
                let (corner, at) = (*self.at(v[0]), *self.at(vertex));
                return Err(SkinError::NotDelaunay { tet: self.numbers[t], corner, vertex, at });
            }
        }
        Ok(())
    }

    fn holds(&self, tet: &[u32; 4], vertex: u32) -> bool {
        let [a, b, c, d] = tet.map(|v| self.at(v));
        !tet.contains(&vertex) && insphere(a, b, c, d, self.at(vertex)) == Sign::Positive
    }

    /// A vertex of a neighbour that is inside the circumsphere.
    fn across(&self, t: usize) -> Option<u32> {
        let beyond = self.neighbours[t].iter().filter(|&&u| u != NONE);
        beyond.flat_map(|&u| self.tets[u as usize]).find(|&v| self.holds(&self.tets[t], v))
    }

    /// A vertex that is inside the circumsphere, the least of all.
    fn inside(&self, tet: &[u32; 4], tree: &RTree<GeomWithData<Point, u32>>) -> Option<u32> {
        let [a, b, c, d] = tet.map(|v| self.at(v));
        let [u, v, w] = [b, c, d].map(|p| minus(p, a));
        let (vw, wu, uv) = (cross(&v, &w), cross(&w, &u), cross(&u, &v));
        let volume = 2.0 * dot(&u, &vw);
        let [uu, vv, ww] = [u, v, w].map(|p| dot(&p, &p));
        let way = [0, 1, 2].map(|k| (uu * vw[k] + vv * wu[k] + ww * uv[k]) / volume);
        let square = dot(&way, &way) * (1.0 + ROUNDING);
        let centre = [0, 1, 2].map(|k| a[k] + way[k]);
        let near: Vec<u32> = match square.is_finite() {
            true => tree.locate_within_distance(centre, square).map(|own| own.data).collect(),
            false => tree.iter().map(|own| own.data).collect(),
        };
        near.into_iter().filter(|&v| self.holds(tet, v)).min()
    }
}
