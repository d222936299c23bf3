//! The conflict region of a point: what inserting it would change, without inserting it.

use super::target::{Spot, Target};
use super::{Cursor, Location};
use crate::cavity::OTHERS;
use crate::mesh::Vertex;
use crate::topology::{INFINITE, TetId, tet_of};
use ltbw_exact::Point;
use ltbw_exact::points::PointError;

/// The conflicts of a point ([`Cursor::conflicts`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Conflicts<'c> {
    /// It lies at this vertex: inserting it would change nothing.
    AtVertex(Vertex),
    /// Inserting it would replace this region by a star.
    Region(ConflictRegion<'c>),
}

/// A face on the boundary of a conflict region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RegionFace {
    /// Its corners: with the point before them they are a positively oriented tetrahedron, one
    /// that inserting the point would make.
    pub corners: [Vertex; 3],
    /// The finite tetrahedron beyond it, which stays; `None` beyond the hull.
    pub beyond: Option<TetId>,
}

/// The tetrahedra and hull facets that inserting a point would delete, and what bounds them.
///
/// All tetrahedra whose symbolically perturbed circumsphere has the point inside. Inserted, the
/// point would make one tetrahedron on each boundary face and one hull facet on each edge of the
/// horizon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConflictRegion<'c> {
    /// The finite tetrahedra; none if the point is outside the hull and all spheres.
    pub tets: &'c [TetId],
    /// The hull facets that would not be hull facets any more, counterclockwise from outside.
    pub hull: &'c [[Vertex; 3]],
    /// The finite faces of the boundary.
    pub boundary: &'c [RegionFace],
    /// The boundary of `hull`: edges of a closed path, directed so that the facet from the point
    /// over such an edge, (point, first, second), turns counterclockwise seen from outside.
    pub horizon: &'c [[Vertex; 2]],
}

/// Buffers of an answer.
#[derive(Clone, Debug, Default)]
pub(super) struct Buffers {
    hull: Vec<[Vertex; 3]>,
    boundary: Vec<RegionFace>,
    horizon: Vec<[Vertex; 2]>,
}

impl Buffers {
    pub(super) fn memory_bytes(&self) -> usize {
        self.hull.capacity() * size_of::<[Vertex; 3]>()
            + self.boundary.capacity() * size_of::<RegionFace>()
            + self.horizon.capacity() * size_of::<[Vertex; 2]>()
    }
}

impl Cursor<'_> {
    /// The conflict region of a point, exactly: what [`crate::Mesh::insert`] would change.
    ///
    /// Cost: a walk, then O(region).
    ///
    /// # Errors
    /// [`PointError::NotFinite`], with index 0.
    ///
    /// ```
    /// use ltbw_core::query::Conflicts;
    /// # use ltbw_core::Builder;
    /// # use ltbw_exact::PointSet;
    /// # let cube = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    /// # let mesh = Builder::new().build(&PointSet::new(cube)?)?.mesh;
    /// let queries = mesh.queries();
    /// let mut cursor = queries.cursor();
    /// let Conflicts::Region(region) = cursor.conflicts([0.5; 3])? else { panic!("not a vertex") };
    /// assert_eq!(region.tets.len(), mesh.num_tets(), "the centre is inside every sphere");
    /// assert_eq!((region.boundary.len(), region.hull.len()), (12, 0));
    /// assert_eq!(cursor.conflicts([0.0; 3])?, Conflicts::AtVertex(0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn conflicts(&mut self, p: Point) -> Result<Conflicts<'_>, PointError> {
        let queries = self.queries;
        let target = Target::new(queries.mesh, p)?;
        let spot = self.walk(&target);
        if let Location::Vertex(v) = queries.location(spot) {
            return Ok(Conflicts::AtVertex(v));
        }
        // A point in a tetrahedron, at none of its corners, is inside its sphere; one beyond a
        // hull facet is in conflict with its ghost.
        let (Spot::Inside(start, _) | Spot::Outside(start)) = spot;
        self.find_region(&target, start);
        let s = &self.scratch;
        Ok(Conflicts::Region(ConflictRegion {
            tets: &s.finite,
            hull: &s.region.hull,
            boundary: &s.region.boundary,
            horizon: &s.region.horizon,
        }))
    }

    /// Breadth-first from `start`, as [`crate::cavity`] does it. The region is connected across
    /// faces. Ends: each tetrahedron enters once.
    fn find_region(&mut self, target: &Target<'_>, start: TetId) {
        let queries = self.queries;
        let topology = &queries.mesh.topology;
        let s = &mut self.scratch;
        s.reached.clear();
        s.tets.clear();
        s.finite.clear();
        s.region.hull.clear();
        s.region.boundary.clear();
        s.region.horizon.clear();
        s.tets.insert(start);
        s.reached.push(start);
        let mut next = 0;
        while let Some(&t) = s.reached.get(next) {
            next += 1;
            let tet = topology.tet(t);
            let v = tet.vertices();
            if tet.is_ghost() {
                s.region.hull.push([v[0], v[1], v[2]].map(|v| queries.number(v)));
            } else {
                s.finite.push(t);
            }
            for (slot, n) in tet.neighbours().into_iter().enumerate() {
                let u = tet_of(n);
                if s.tets.contains(u) {
                    continue;
                }
                if target.conflicts(u) {
                    s.tets.insert(u);
                    s.reached.push(u);
                    continue;
                }
                let [a, b, c] = OTHERS[slot].map(|k| v[k]);
                if c == INFINITE {
                    // The new ghost (p, a, b, infinity) stands for the facet p, a, b.
                    s.region.horizon.push([a, b].map(|v| queries.number(v)));
                } else {
                    let corners = [a, b, c].map(|v| queries.number(v));
                    let beyond = (!topology.tet(u).is_ghost()).then_some(u);
                    s.region.boundary.push(RegionFace { corners, beyond });
                }
            }
        }
    }
}
