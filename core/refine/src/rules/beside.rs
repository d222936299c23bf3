//! Points on the boundary beside a tetrahedron.

use super::bounded::Bounded;
use super::choice::BoundaryItem;
use super::verdict::{Filling, Judge};
use super::walk::Way;
use crate::complex::carrier::{Carrier, Line};
use crate::complex::measure::circumcircle;
use crate::complex::plc::Plc;
use crate::mesh::item::Item;
use crate::mesh::state::{Place, State};
use crate::table::edge;
use ltbw_core::topology::{TetId, VertexId};
use ltbw_exact::Point;

impl State {
    /// The boundary items beside a tetrahedron: its sides, the subface on its way to a point, and
    /// the subsegments of all these.
    pub(crate) fn beside(&self, t: TetId, towards: Option<Point>) -> Vec<Item> {
        let mut faces = self.boundary_sides(t);
        if let Some(p) = towards
            && let Way::Blocked(subface) = self.way(t, &p)
        {
            faces.push(Item::Subface(subface));
        }
        self.sort(&mut faces);
        faces.dedup();
        let mut edges: Vec<[VertexId; 2]> = Vec::new();
        let mut add = |corners: &[VertexId]| {
            let pairs = (1..corners.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
            edges.extend(pairs.map(|(i, j)| edge(corners[i], corners[j])));
        };
        add(&self.vertices(t));
        for face in &faces {
            if let Item::Subface(corners) = face {
                add(corners);
            }
        }
        edges.retain(|e| self.segments.contains_key(e));
        let mut segments: Vec<Item> = edges.into_iter().map(Item::Segment).collect();
        self.sort(&mut segments);
        segments.dedup();
        faces.extend(segments);
        faces
    }

    /// A boundary item by its corners.
    pub(crate) fn boundary_item(&self, item: Item) -> Option<BoundaryItem> {
        match item {
            Item::Segment(s) => {
                Some(BoundaryItem::new(&s.map(|v| self.corner(v)), *self.segments.get(&s)?))
            }
            Item::Subface(s) => {
                Some(BoundaryItem::new(&s.map(|v| self.corner(v)), *self.subfaces.get(&s)?))
            }
            Item::Tet(..) => None,
        }
    }
}

/// A point on a boundary item.
pub(crate) struct OnItem {
    pub(crate) point: Point,
    pub(crate) carrier: Carrier,
}

impl Plc {
    /// The `k`-th point that is tried on a boundary item: where it would be split, then anywhere.
    pub(crate) fn place_beside(
        &self,
        item: &BoundaryItem,
        k: usize,
        seed: &mut u64,
        tolerance: f64,
    ) -> Option<OnItem> {
        let offset = in_unit_ball(seed);
        let of = item.of();
        if let [a, b] = item.corners() {
            let ends = [a.carrier, b.carrier];
            let [a, b] = ends.map(|end| self.parameter(end, of));
            let (low, high) = (a.min(b), a.max(b));
            let length = (high - low) as f64;
            let t = match k {
                0 => self.split_parameter(ends, of)?,
                _ => {
                    let aim = low as f64 + (0.5 + 0.45 * offset[0]) * length;
                    Line::near(aim, length / 512.0, low, high)?
                }
            };
            let point = self.segments[of as usize].line.point(t);
            return Some(OnItem { point, carrier: Carrier::Segment(of, t) });
        }
        let [a, b, c] = &item.points();
        let aim = match k {
            0 => circumcircle(a, b, c).0,
            _ => {
                let parts = offset.map(|x| 0.5 * x + 0.501);
                let sum: f64 = parts.iter().sum();
                let [x, y, z] = parts.map(|part| part / sum);
                [0, 1, 2].map(|k| x * a[k] + y * b[k] + z * c[k])
            }
        };
        let (point, is_on) = self.place_on(of, &aim, tolerance)?;
        is_on.then_some(OnItem { point, carrier: Carrier::Facet(of) })
    }
}

impl<B: Bounded> Judge<'_, B> {
    /// The changes of the boundary with a point on `item`, or inside, that takes no other item out
    /// of the mesh.
    pub(crate) fn filling_beside(
        &self,
        item: Option<Item>,
        place: &Place,
        may_encroach: impl Fn(&Item) -> bool,
    ) -> Option<Filling> {
        let (mut changes, mut split) = (Vec::new(), None);
        if let Some(item) = item {
            split = match item {
                Item::Segment(ends) => Some((ends, self.closure.segment(ends)?)),
                Item::Subface(_) => None,
                Item::Tet(..) => return None,
            };
            changes = self.planned(place, item)?;
        }
        let ends = split.map(|(ends, _)| ends);
        let changes = self.with_patches(place, ends, changes)?;
        let may = self.hits().iter().all(|hit| Some(*hit) == item || may_encroach(hit));
        let is_kept = may && self.losses(ends, &changes).is_empty();
        is_kept.then_some(Filling { split, changes, lost: Vec::new() })
    }
}

/// The next point of a sequence in the unit ball, the same everywhere.
pub(crate) fn in_unit_ball(seed: &mut u64) -> Point {
    let mut next = || {
        *seed =
            seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 32) as f64 / f64::from(1u32 << 31) - 1.0
    };
    let mut point = [0.0; 3];
    // Half of the cube is in the ball; a point outside is shortened in the end.
    for _ in 0..16 {
        point = [next(), next(), next()];
        if point.iter().map(|c| c * c).sum::<f64>() <= 1.0 {
            return point;
        }
    }
    point.map(|c| 0.5 * c)
}
