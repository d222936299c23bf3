//! Tetrahedra that hold given points.

use crate::body::{Body, NOWHERE};
use crate::failure::Failure;
use ltbw::query::{Cursor, Location, Queries};
use ltbw::topology::TetId;
use ltbw::{Mesh, Point};
use rayon::prelude::*;
use std::sync::Arc;

self_cell::self_cell!(
    /// A mesh with what questions to it need.
    struct Asked {
        owner: Arc<Body>,
        #[covariant]
        dependent: Queries,
    }
);

/// Answers to where points are.
pub(crate) struct Locator {
    asked: Asked,
    /// Places of tetrahedra among those that the caller sees.
    place: Vec<u32>,
}

impl Locator {
    pub(crate) fn new(body: &Arc<Body>) -> Self {
        let asked = Asked::new(Arc::clone(body), |body| body.mesh().queries());
        Self { asked, place: body.places() }
    }

    /// For each point a tetrahedron that holds it, or [`NOWHERE`].
    pub(crate) fn find(&self, points: &[Point]) -> Result<Vec<u32>, Failure> {
        let queries = self.asked.borrow_dependent();
        let find = |cursor: &mut Cursor<'_>, &p: &Point| self.find_one(queries.mesh(), cursor, p);
        points.par_iter().map_init(|| queries.cursor(), find).collect()
    }

    fn find_one(&self, mesh: &Mesh, cursor: &mut Cursor<'_>, p: Point) -> Result<u32, Failure> {
        let seen = |t: TetId| self.place.get(t as usize).copied().filter(|&k| k != NOWHERE);
        // On a vertex, edge or face any tetrahedron there will do; of several the first seen.
        let corners: Vec<u32> = match cursor.locate(p)? {
            Location::Tet(t) => return Ok(seen(t).unwrap_or(NOWHERE)),
            Location::OutsideHull { .. } => return Ok(NOWHERE),
            Location::Vertex(v) => vec![v],
            Location::Edge { ends, .. } => ends.to_vec(),
            Location::Facet { corners, .. } => corners.to_vec(),
        };
        let star = corners.first().and_then(|&v| cursor.star(v)).unwrap_or_default();
        let has_all =
            |t: TetId| mesh.tet(t).is_some_and(|tet| corners.iter().all(|v| tet.contains(v)));
        let at = star.iter().copied().filter(|&t| has_all(t)).filter_map(seen).min();
        Ok(at.unwrap_or(NOWHERE))
    }
}
