//! Points on the boundary beside a tetrahedron.

use super::sliver::in_unit_ball;
use crate::complex::carrier::{Carrier, Line, free_point};
use crate::complex::measure::circumcircle;
use crate::mesh::item::Item;
use crate::mesh::key::sorted;
use crate::mesh::state::{Place, State};
use crate::rules::bounded::Bounded;
use crate::rules::verdict::{Filling, Judge};
use crate::rules::walk::Way;
use crate::table::edge;
use ltbw_core::topology::{TetId, VertexId};
use ltbw_exact::Point;

impl State {
    /// The boundary items beside a tetrahedron: its sides, the subface on its way to `centre`, and
    /// the subsegments of all these.
    pub(crate) fn beside(&self, t: TetId, centre: &Point, tolerance: f64) -> Vec<Item> {
        let mut faces = self.boundary_sides(t);
        if let Some(p) = free_point(centre, tolerance)
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

    /// The `k`-th place that is tried on a boundary item: where it would be split, then anywhere.
    pub(crate) fn place_beside(
        &self,
        item: Item,
        k: usize,
        seed: &mut u64,
        from: TetId,
        tolerance: f64,
    ) -> Option<Place> {
        let offset = in_unit_ball(seed);
        match item {
            Item::Segment(ends) => {
                let &s = self.segments.get(&ends)?;
                let [a, b] = ends.map(|v| self.parameter(v, s));
                let (low, high) = (a.min(b), a.max(b));
                let length = (high - low) as f64;
                let t = match k {
                    0 => self.plc.split_parameter(ends.map(|v| self.carriers[v.index()]), s)?,
                    _ => {
                        let aim = low as f64 + (0.5 + 0.45 * offset[0]) * length;
                        Line::near(aim, length / 512.0, low, high)?
                    }
                };
                let p = self.plc.segments[s as usize].line.point(t);
                Some(Place { p, carrier: Carrier::Segment(s, t), from })
            }
            Item::Subface(corners) => {
                let &f = self.subfaces.get(&corners)?;
                let [a, b, c] = &sorted(corners.map(|v| self.at(v)));
                let aim = match k {
                    0 => circumcircle(a, b, c).0,
                    _ => {
                        let parts = offset.map(|x| 0.5 * x + 0.501);
                        let sum: f64 = parts.iter().sum();
                        let [x, y, z] = parts.map(|part| part / sum);
                        [0, 1, 2].map(|k| x * a[k] + y * b[k] + z * c[k])
                    }
                };
                let (p, is_on) = self.plc.place_on(f, &aim, tolerance)?;
                is_on.then_some(Place { p, carrier: Carrier::Facet(f), from })
            }
            Item::Tet(..) => None,
        }
    }
}

impl Judge<'_> {
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
