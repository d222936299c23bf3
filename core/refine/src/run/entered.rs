//! The boundary in a mesh of others, whose carriers and regions tell what it is.

use crate::complex::carrier::Carrier;
use crate::mesh::item::Item;
use crate::mesh::marks::{ENDS, Marks, Word, edge_bit, face_bit};
use crate::mesh::state::{FACE, State};
use crate::rules::choice::ItemPlace;
use crate::rules::complex::Complex;
use crate::table::{Map, edge, triangle};
use ltbw_core::topology::{INFINITE, Tet, TetId, VertexId};
use ltbw_exact::Point;
use rayon::prelude::*;

/// The values that tell the boundary, beside the carriers.
struct Told<'t> {
    complex: &'t Complex<'t>,
    /// The region of each slot.
    regions: &'t [u32],
    /// Which vertices are on the boundary: the one at infinity is not.
    is_on: &'t [bool],
}

/// A boundary item, its segment or facet, and a tetrahedron at it.
type Named = (Item, u32, TetId);

impl State {
    /// Enters the boundary that the carriers tell, and the regions. Returns all items by place if
    /// they are asked for, each with a tetrahedron at it.
    pub(super) fn enter_boundary(
        &mut self,
        complex: &Complex<'_>,
        regions: &[u32],
        is_asked: bool,
    ) -> Map<ItemPlace, (Item, TetId)> {
        self.marks = Marks::new(self.mesh.topology().slots());
        let is_on = self.on_boundary();
        let (this, told) = (&*self, Told { complex, regions, is_on: &is_on });
        let enter = |mut found: Vec<Named>, (t, tet): (TetId, &Tet)| {
            this.enter_marks(&told, t, tet, &mut found);
            found
        };
        let all = this.mesh.topology().par_iter().fold(Vec::new, enter);
        let all = all.collect::<Vec<_>>().into_iter().flatten().collect();
        self.enter_named(all, is_asked)
    }

    /// As [`State::enter_boundary`], of a window, in which filling has no boundary.
    pub(super) fn enter_boundary_of_window(
        &mut self,
        complex: &Complex<'_>,
        regions: &[u32],
    ) -> Map<ItemPlace, (Item, TetId)> {
        let is_on = self.on_boundary();
        let told = Told { complex, regions, is_on: &is_on };
        let (this, mut all) = (&*self, Vec::new());
        let known = this.mesh.topology().iter().filter(|own| !this.has_filling(own.0));
        known.for_each(|(t, tet)| this.enter_marks(&told, t, tet, &mut all));
        self.enter_named(all, true)
    }

    /// Which vertices are on the boundary? A byte for each is in the cache, unlike its carrier.
    fn on_boundary(&self) -> Vec<bool> {
        self.carriers.iter().map(|own| *own != Carrier::Free).collect()
    }

    /// Enters the marks and the region of a tetrahedron; tells of its boundary items.
    fn enter_marks(&self, told: &Told<'_>, t: TetId, tet: &Tet, found: &mut Vec<Named>) {
        let v = tet.vertices();
        let label = |t: TetId| match self.vertices(t)[3] {
            INFINITE => 0,
            _ => told.regions[t.index()],
        };
        let labels = |slot: usize| [t, self.neighbours(t)[slot]].map(label);
        let tell = |item, of| found.push((item, of, t));
        let bits = self.named(told, v, labels, tell);
        self.marks.enter(t, label(t), bits);
    }

    /// Enters boundary items into the tables.
    fn enter_named(&mut self, all: Vec<Named>, is_asked: bool) -> Map<ItemPlace, (Item, TetId)> {
        (self.segments, self.subfaces) = Default::default();
        let mut found = Map::default();
        for (item, of, t) in all {
            let corners = match &item {
                Item::Segment(ends) => {
                    self.segments.insert(*ends, of);
                    &ends[..]
                }
                Item::Subface(corners) => {
                    self.subfaces.insert(*corners, of);
                    &corners[..]
                }
                Item::Tet(..) => continue,
            };
            if is_asked {
                let points: Vec<Point> = corners.iter().map(|&v| self.at(v)).collect();
                found.insert(ItemPlace::of(&points), (item, t));
            }
        }
        found
    }

    /// Tells the boundary items of a tetrahedron, each with its segment or facet, where `labels`
    /// says the regions on both sides of a face. Returns its marks.
    fn named(
        &self,
        told: &Told<'_>,
        v: [VertexId; 4],
        labels: impl Fn(usize) -> [u32; 2],
        mut tell: impl FnMut(Item, u32),
    ) -> Word {
        let carrier = |v: VertexId| self.carriers[v.index()];
        let (complex, is_on) = (told.complex, v.map(|v| told.is_on[v.index()]));
        let mut bits = 0;
        if is_on.iter().filter(|on| **on).count() < 2 {
            return bits;
        }
        for [i, j] in ENDS {
            if is_on[i]
                && is_on[j]
                && let Some(s) = complex.segment([v[i], v[j]].map(carrier))
            {
                tell(Item::Segment(edge(v[i], v[j])), s);
                bits |= edge_bit(i, j);
            }
        }
        for (slot, face) in FACE.into_iter().enumerate() {
            if !face.iter().all(|&k| is_on[k]) {
                continue;
            }
            let [a, b, c] = face.map(|k| v[k]);
            let corners = [a, b, c].map(|v| self.corner(v));
            let patch = || complex.patch(corners, slot, || Some(labels(slot)));
            if let Some(f) = complex.facet(corners).or_else(patch) {
                tell(Item::Subface(triangle(a, b, c)), f);
                bits |= face_bit(slot);
            }
        }
        bits
    }
}
