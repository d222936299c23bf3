//! Tetrahedra that hold given points.

use crate::body::{Body, NOWHERE};
use crate::failure::{Class, Failure};
use ltbw::order::hilbert;
use ltbw::query::{Cursor, Location, Queries};
use ltbw::topology::TetId;
use ltbw::{CancelToken, Mesh, Point};
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
    pub(crate) fn find(&self, points: &[Point], cancel: &CancelToken) -> Result<Vec<u32>, Failure> {
        let finite = |p: &Point| p.iter().all(|x| x.is_finite());
        if let Some(index) = points.iter().position(|p| !finite(p)) {
            let text = format!("point {index} is {:?}, which is no place", points[index]);
            let failure = Failure::new(Class::Input, "points.not-finite", text);
            return Err(failure.with(u32::try_from(index)));
        }
        let queries = self.asked.borrow_dependent();
        let find = |cursor: &mut Cursor<'_>, &k: &u32| {
            if cancel.is_cancelled() {
                return Err(Failure::new(
                    Class::Cancelled,
                    "cancelled",
                    "the search was cancelled",
                ));
            }
            Ok((k, self.find_one(queries.mesh(), cursor, points[k as usize])?))
        };
        // Walks from one point to the next are short along the curve.
        let order = hilbert(points);
        let found = order.par_iter().map_init(|| queries.cursor(), find);
        let found: Vec<(u32, u32)> = found.collect::<Result<_, Failure>>()?;
        let mut places = vec![NOWHERE; points.len()];
        for (k, place) in found {
            places[k as usize] = place;
        }
        Ok(places)
    }

    fn find_one(&self, mesh: &Mesh, cursor: &mut Cursor<'_>, p: Point) -> Result<u32, Failure> {
        let seen = |t: TetId| self.place.get(t.index()).copied().filter(|&k| k != NOWHERE);
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
