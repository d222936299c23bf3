//! The layers of patches: recovery of patches within a tolerance.
//!
//! The tiles of a layer are found in `tiles`. A layer is complete if every subsegment of the patch
//! is an edge of as many triangles as there are polygons at the segment, and every other edge is
//! one of two: then, since all its triangles have a positive area in the projection and its
//! outline is that of the patch, it covers the patch exactly once.
//!
//! No triangulation of a patch is kept. Where a layer is not complete, the planar Delaunay
//! triangulation of the rounded projection tells where triangles are missing, and so where points
//! are inserted; that triangulation is never taken for true.

use crate::complex::carrier::Carrier;
use crate::complex::patch::Sides;
use crate::complex::plc::Plc;
use crate::mesh::marks::{DUST, face_bit};
use crate::mesh::state::{FACE, State};
use crate::mesh::tiles::{Found, Tile};
use crate::table::{Map, Set, sides, triangle};
use ltbw_core::Builder;
use ltbw_core::topology::{INFINITE, VertexId, slot_of, tet_of};
use ltbw_domain::vector::{cross, dot, minus};
use ltbw_exact::{Point, PointSet};
use std::sync::Arc;

/// The distance of an apex from the plane, in the units of the rounded projection.
const APEX: f64 = (1u64 << 52) as f64;

/// Circles are smaller than this, in fine steps.
const LARGEST: f64 = (1u64 << 60) as f64;

/// Where a patch is not in the mesh.
#[derive(Clone, Debug)]
pub(crate) struct Hole {
    pub(crate) facet: u32,
    /// The corners of the triangle that is missing.
    pub(crate) corners: [VertexId; 3],
    /// The centre of its circle.
    pub(crate) centre: Point,
    /// The subsegment between the triangle and the centre, if there is one.
    pub(crate) between: Option<[VertexId; 2]>,
    radius: f64,
}

/// A subsegment of a patch.
#[derive(Clone, Copy, Debug)]
struct Outlined {
    side: [VertexId; 2],
    /// The triangles of a layer that are to have it: two where the patch is on both sides.
    count: usize,
}

/// A planar triangulation: triangles with those across their sides, in the order of [`sides`].
struct Planar {
    places: Map<VertexId, [f64; 2]>,
    triangles: Vec<[VertexId; 3]>,
    at_edge: Map<[VertexId; 2], Vec<usize>>,
    frame: [Point; 3],
}

impl State {
    /// The subsegments of each patch.
    fn outlines(&self) -> Vec<Vec<Outlined>> {
        let mut outlines = vec![Vec::new(); self.plc.facets.len()];
        let mut all: Vec<(&[VertexId; 2], &u32)> = self.segments.iter().collect();
        all.sort_unstable();
        for (&side, &s) in all {
            let segment = &self.plc.segments[s as usize];
            for &f in &segment.facets {
                let count = if segment.twice.contains(&f) { 2 } else { 1 };
                outlines[f as usize].push(Outlined { side, count });
            }
        }
        outlines
    }

    /// The triangles that are missing where layers are not complete; or the patches for which that
    /// cannot be told.
    pub(crate) fn holes(&self, found: &mut Found) -> Result<Vec<Hole>, Vec<u32>> {
        let (mut holes, mut unknown) = (Vec::new(), Vec::new());
        let outlines = self.outlines();
        let mut on: Option<Vec<Vec<VertexId>>> = None;
        for (f, layers) in (0u32..).zip(&mut found.layers) {
            let Some(patch) = &self.plc.facets[f as usize].patch else { continue };
            for layer in [&mut layers.lower, &mut layers.upper] {
                drop_fins(layer, &outlines[f as usize]);
            }
            let open = [&layers.lower, &layers.upper]
                .map(|layer| open_edges(layer, &outlines[f as usize]));
            // An outline that crosses itself in the projection has edges enough, but another area.
            let area = |tile: &Tile| {
                let [a, b, c] = tile.key.map(|v| self.at(v));
                patch.area_of([&a, &b, &c])
            };
            let whole = |tiles: &[Tile]| tiles.iter().map(area).sum::<i128>() == patch.area();
            layers.complete = [
                open[0].is_empty() && whole(&layers.lower),
                open[1].is_empty() && whole(&layers.upper),
            ];
            if layers.complete.contains(&true) {
                continue;
            }
            let open: Set<[VertexId; 2]> = open.into_iter().flatten().collect();
            let on = on.get_or_insert_with(|| self.vertices_on_patches());
            let Some(planar) = self.planar(f, &on[f as usize]) else {
                unknown.push(f);
                continue;
            };
            let faces: Set<[VertexId; 3]> =
                layers.lower.iter().chain(&layers.upper).map(|tile| tile.key).collect();
            let before = holes.len();
            self.missing_in(f, &planar, &faces, &open, &mut holes);
            if holes.len() == before {
                unknown.push(f);
            }
        }
        if unknown.is_empty() { Ok(holes) } else { Err(unknown) }
    }

    fn vertices_on_patches(&self) -> Vec<Vec<VertexId>> {
        let mut on = vec![Vec::new(); self.plc.facets.len()];
        for (v, patches) in (0..).map(VertexId::new).zip(self.patches_at()) {
            patches.into_iter().for_each(|f| on[f as usize].push(v));
        }
        on
    }

    /// The planar Delaunay triangulation of vertices of patch `f`, in the rounded projection along
    /// its normal.
    fn planar(&self, f: u32, vertices: &[VertexId]) -> Option<Planar> {
        let facet = &self.plc.facets[f as usize];
        let patch = facet.patch.as_ref()?;
        let n = facet.plane.normal();
        let other = [0, 1, 2].map(|k| if k == (patch.axis + 1) % 3 { 1.0 } else { 0.0 });
        let unit = |v: Point| v.map(|c| c / dot(&v, &v).sqrt());
        let e = unit(cross(&n, &other));
        let g = unit(cross(&n, &e));
        let origin = self.at(*vertices.first()?);
        // A quarter of a fine step is lost: this is no test, but a guess where points are needed.
        let place = |v: VertexId| {
            let d = minus(&self.at(v), &origin);
            [(dot(&d, &e) * 0.25).round(), (dot(&d, &g) * 0.25).round()]
        };
        let places: Map<VertexId, [f64; 2]> = vertices.iter().map(|&v| (v, place(v))).collect();
        let mut points: Vec<Point> =
            vertices.iter().map(|v| [places[v][0], places[v][1], 0.0]).collect();
        points.push([points[0][0], points[0][1], APEX]);
        let count = vertices.len() as u32;
        let built = Builder::new().build(&PointSet::new(points).ok()?).ok()?.mesh;
        let mut planar = Planar {
            places,
            triangles: Vec::new(),
            at_edge: Map::default(),
            frame: [origin, e, g],
        };
        for t in built.tet_ids() {
            let Some(v) = built.tet(t) else { continue };
            let Some(slot) = v.iter().position(|&w| w == count) else { continue };
            let [a, b, c] = FACE[slot].map(|k| vertices[v[k] as usize]);
            let corners = [a, b, c].map(|v| self.at(v));
            if !patch.holds_triangle(corners.each_ref()) {
                continue;
            }
            let key = triangle(a, b, c);
            for (side, _) in sides(key) {
                planar.at_edge.entry(side).or_default().push(planar.triangles.len());
            }
            planar.triangles.push(key);
        }
        Some(planar)
    }

    /// The triangles of components that no faces of the mesh have and that touch an open edge.
    fn missing_in(
        &self,
        f: u32,
        planar: &Planar,
        faces: &Set<[VertexId; 3]>,
        open: &Set<[VertexId; 2]>,
        holes: &mut Vec<Hole>,
    ) {
        let mut seen: Vec<bool> = planar.triangles.iter().map(|t| faces.contains(t)).collect();
        for first in 0..planar.triangles.len() {
            if seen[first] {
                continue;
            }
            seen[first] = true;
            let (mut list, mut next) = (vec![first], 0);
            // Breadth first; each triangle enters once.
            while let Some(&k) = list.get(next) {
                next += 1;
                for (side, _) in sides(planar.triangles[k]) {
                    if self.segments.contains_key(&side) {
                        continue;
                    }
                    for &other in &planar.at_edge[&side] {
                        if !seen[other] {
                            seen[other] = true;
                            list.push(other);
                        }
                    }
                }
            }
            let corners: Set<VertexId> = list.iter().flat_map(|&k| planar.triangles[k]).collect();
            if open.iter().any(|e| e.iter().all(|v| corners.contains(v))) {
                let found = list.iter().map(|&k| planar.hole(f, k, &self.segments));
                // Corners on one line, but for rounding, are no triangle.
                holes.extend(found.filter(|hole| hole.radius < LARGEST));
            }
        }
    }

    /// Bars the layers, for the flood; dust belongs to no side yet. `false` if a face is in the
    /// layers of two facets.
    pub(crate) fn bar(&mut self, found: &Found) -> bool {
        for (f, layers) in (0u32..).zip(&found.layers) {
            for tile in layers.lower.iter().chain(&layers.upper) {
                if *self.subfaces.entry(tile.key).or_insert(f) != f {
                    return false;
                }
                self.mark_both(tile, true);
            }
        }
        for dust in &found.dust {
            self.marks.set_region(dust.tet, DUST);
        }
        true
    }

    fn mark_both(&mut self, tile: &Tile, set: bool) {
        let across = self.mesh.topology().at(tile.tet).neighbours()[tile.slot];
        for (t, slot) in [(tile.tet, tile.slot), (tet_of(across), slot_of(across))] {
            match set {
                true => self.marks.set(t, face_bit(slot)),
                false => self.marks.clear(t, face_bit(slot)),
            }
        }
    }

    /// After the flood: finds the sides of every patch, gives its dust to the outer one, and takes
    /// the inner layer for its subfaces. `false` if a patch has one label on both sides, or a label
    /// changes where there is no subface.
    pub(crate) fn choose_layers(&mut self, found: &Found) -> bool {
        for layers in &found.layers {
            for tile in layers.lower.iter().chain(&layers.upper) {
                self.subfaces.remove(&tile.key);
                self.mark_both(tile, false);
            }
        }
        for (f, layers) in (0u32..).zip(&found.layers) {
            let label = |layer: &[Tile]| {
                let labels = layer.iter().map(|tile| self.marks.region(tile.tet));
                let mut labels = labels.filter(|&label| label != DUST);
                let first = labels.next()?;
                labels.all(|label| label == first).then_some(first)
            };
            let facet = &self.plc.facets[f as usize];
            if facet.patch.is_none() {
                continue;
            }
            let (Some(below), Some(above)) = (label(&layers.lower), label(&layers.upper)) else {
                return false;
            };
            if below == above {
                return false;
            }
            // The exterior, label 0, is lower than any region.
            let upwards = below < above;
            let (inner, outer) = if upwards { (above, below) } else { (below, above) };
            let chosen = if upwards { &layers.upper } else { &layers.lower };
            if !layers.complete[usize::from(upwards)] {
                return false;
            }
            for tile in chosen {
                self.subfaces.insert(tile.key, f);
                self.mark_both(tile, true);
            }
            if let Some(patch) = &mut Arc::make_mut(&mut self.plc).facets[f as usize].patch {
                patch.sides = Some(Sides { inner, outer, upwards });
            }
        }
        for dust in &found.dust {
            let patch = self.plc.facets[dust.facet as usize].patch.as_ref();
            let Some(sides) = patch.and_then(|p| p.sides) else { return false };
            let is_inner = dust.above == Some(sides.upwards);
            self.marks.set_region(dust.tet, if is_inner { sides.inner } else { sides.outer });
        }
        self.mesh.topology().iter().all(|(t, tet)| {
            let (word, own) = (self.marks.of(t), self.marks.region(t));
            let mut others = tet.neighbours().into_iter().enumerate();
            others.all(|(slot, face)| {
                word & face_bit(slot) != 0 || self.marks.region(tet_of(face)) == own
            })
        })
    }

    /// Are all four corners on one patch? Those of a ghost are not.
    pub(crate) fn is_flat(&self, v: [VertexId; 4]) -> bool {
        v[3] != INFINITE && self.plc.is_flat(|k| self.carriers[v[k].index()])
    }
}

impl Plc {
    /// Are all four corners of a tetrahedron, which live there, on one patch?
    pub(crate) fn is_flat(&self, carrier: impl Fn(usize) -> Carrier) -> bool {
        let first = carrier(0);
        let on = |f: u32| (1..4).all(|k| self.lies_on(carrier(k), f));
        let mut all = self.facets_of(&first).iter();
        first != Carrier::Free && all.any(|&f| self.is_patch(f) && on(f))
    }
}

/// The number of triangles that are missing at each edge of a layer; negative where there are too
/// many.
fn missing_at(layer: &[Tile], outline: &[Outlined]) -> Map<[VertexId; 2], isize> {
    let mut counts: Map<[VertexId; 2], isize> = Map::default();
    for (side, _) in layer.iter().flat_map(|tile| sides(tile.key)) {
        *counts.entry(side).or_insert(2) -= 1;
    }
    for &Outlined { side, count } in outline {
        *counts.entry(side).or_insert(2) -= 2 - count as isize;
    }
    counts
}

/// The edges of which a layer has not as many triangles as it should.
fn open_edges(layer: &[Tile], outline: &[Outlined]) -> Vec<[VertexId; 2]> {
    let counts = missing_at(layer, outline);
    counts.into_iter().filter(|&(_, left)| left != 0).map(|(side, _)| side).collect()
}

/// Drops triangles of nearly collinear corners that hang on an edge with triangles enough, with
/// nothing at another edge: they lie in the patch as they lie in the one across its outline.
fn drop_fins(layer: &mut Vec<Tile>, outline: &[Outlined]) {
    let mut counts = missing_at(layer, outline);
    // Every pass but the last drops a triangle.
    loop {
        let before = layer.len();
        layer.retain(|tile| {
            let own = sides(tile.key).map(|(side, _)| side);
            let left = own.map(|side| counts.get(&side).copied().unwrap_or(0));
            let is_fin = left.iter().any(|&n| n < 0) && left.contains(&1);
            if is_fin {
                own.iter().for_each(|side| *counts.entry(*side).or_insert(0) += 1);
            }
            !is_fin
        });
        if layer.len() == before {
            return;
        }
    }
}

impl Planar {
    /// Triangle `k` as a hole.
    fn hole(&self, facet: u32, k: usize, segments: &Map<[VertexId; 2], u32>) -> Hole {
        let corners = self.triangles[k];
        let [a, b, c] = corners.map(|v| self.places[&v]);
        let (u, v) = (minus(&b, &a), minus(&c, &a));
        let (uu, vv) = (u[0] * u[0] + u[1] * u[1], v[0] * v[0] + v[1] * v[1]);
        let twice = 2.0 * (u[0] * v[1] - u[1] * v[0]);
        let x = (v[1] * uu - u[1] * vv) / twice;
        let y = (u[0] * vv - v[0] * uu) / twice;
        let at = [a[0] + x, a[1] + y];
        let [origin, e, g] = &self.frame;
        let centre = [0, 1, 2].map(|i| origin[i] + 4.0 * (at[0] * e[i] + at[1] * g[i]));
        let between = self.segment_between(k, at, segments);
        Hole { facet, corners, centre, between, radius: 4.0 * x.hypot(y) }
    }

    /// The first subsegment on the way from triangle `k` to a place.
    fn segment_between(
        &self,
        k: usize,
        to: [f64; 2],
        segments: &Map<[VertexId; 2], u32>,
    ) -> Option<[VertexId; 2]> {
        let turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        let (mut k, mut entry) = (k, None);
        // A walk in a Delaunay triangulation ends; with rounded numbers the bound ends it.
        for _ in 0..=self.triangles.len() {
            let beyond = |&(side, opposite): &([VertexId; 2], VertexId)| {
                let [a, b] = side.map(|v| self.places[&v]);
                Some(side) != entry && turn(a, b, to) * turn(a, b, self.places[&opposite]) < 0.0
            };
            let (side, _) = sides(self.triangles[k]).into_iter().find(beyond)?;
            if segments.contains_key(&side) {
                return Some(side);
            }
            k = *self.at_edge[&side].iter().find(|&&other| other != k)?;
            entry = Some(side);
        }
        None
    }
}

impl Hole {
    /// The largest first; of equal ones the first by its corners.
    pub(crate) fn order(&self, other: &Self) -> std::cmp::Ordering {
        other.radius.total_cmp(&self.radius).then(self.corners.cmp(&other.corners))
    }

    /// The square of the radius.
    pub(crate) fn square(&self) -> f64 {
        self.radius * self.radius
    }
}
