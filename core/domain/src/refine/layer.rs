//! The layers of patches: recovery of patches within a tolerance.
//!
//! Vertices of a patch are not quite in one plane, so the Delaunay mesh may hold *dust*: tetrahedra
//! whose four corners are on the patch and whose faces all lie in its polygons, in the projection.
//! The faces of the mesh that lie in the patch and have no dust below them are its *lower layer*,
//! those with none above them the *upper* one. Without dust the two are the same, and with it one
//! of them is needed, that on the inner side. A layer is complete if every subsegment of the patch
//! is an edge of as many triangles as there are polygons at the segment, and every other edge is
//! one of two: then, since all its triangles have a positive area in the projection and its
//! outline is that of the patch, it covers the patch exactly once.
//!
//! No triangulation of a patch is kept. Where a layer is not complete, the planar Delaunay
//! triangulation of the rounded projection tells where triangles are missing, and so where points
//! are inserted; that triangulation is never taken for true.

use super::carrier::{cross, dot, minus};
use super::marks::{DUST, face_bit};
use super::patch::Sides;
use super::state::{FACE, State};
use super::table::{Map, Set, sides, triangle};
use ltbw_core::Builder;
use ltbw_core::topology::{TetId, VertexId, slot_of, tet_of};
use ltbw_exact::{Point, PointSet};

/// The distance of an apex from the plane, in the units of the rounded projection.
const APEX: f64 = (1u64 << 52) as f64;

/// Circles are smaller than this, in fine steps.
const LARGEST: f64 = (1u64 << 60) as f64;

/// A face of a layer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile {
    pub(crate) key: [VertexId; 3],
    /// The tetrahedron on its side of the layer, which is not dust, and the face's slot there.
    tet: TetId,
    slot: usize,
}

/// The layers of a patch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layers {
    lower: Vec<Tile>,
    upper: Vec<Tile>,
    /// Which of them is complete.
    complete: [bool; 2],
}

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

/// All layers, by facet, and all dust with its facet.
#[derive(Clone, Debug, Default)]
pub(crate) struct Found {
    layers: Vec<Layers>,
    dust: Vec<(TetId, u32)>,
}

/// A planar triangulation: triangles with those across their sides, in the order of [`sides`].
struct Planar {
    places: Map<VertexId, [f64; 2]>,
    triangles: Vec<[VertexId; 3]>,
    at_edge: Map<[VertexId; 2], Vec<usize>>,
    frame: [Point; 3],
}

/// Is the apex of a positively oriented tetrahedron, opposite `slot`, above the face, whose
/// projection has this sign?
pub(crate) fn is_above(slot: usize, turn: i128) -> bool {
    (slot % 2 == 1) == (turn > 0)
}

impl State {
    /// The patches on which each vertex lies.
    fn patches_at(&self) -> Vec<Vec<u32>> {
        let is_patch = |f: &u32| self.plc.facets[*f as usize].patch.is_some();
        let of = |&carrier| self.facets_of(carrier).into_iter().filter(is_patch).collect();
        let mut all: Vec<Vec<u32>> = self.carriers.iter().skip(1).map(of).collect();
        all.insert(0, Vec::new());
        all
    }

    /// Finds the layers of all patches.
    pub(crate) fn find_layers(&self) -> Found {
        let patches = self.patches_at();
        let mut found = Found::default();
        found.layers.resize(self.plc.facets.len(), Layers::default());
        for t in self.mesh.tet_ids() {
            let v = self.vertices(t);
            let mut faces = [const { Vec::new() }; 4];
            for (slot, list) in faces.iter_mut().enumerate() {
                *list = self.tiles_of(&patches, FACE[slot].map(|k| v[k]));
            }
            // A face that is nothing in the projection is no tile, but may be one of dust.
            let mut dust: Vec<u32> = faces.iter().flatten().map(|&(f, _)| f).collect();
            dust.sort_unstable();
            dust.dedup();
            dust.retain(|f| faces.iter().all(|list| list.iter().any(|(g, _)| g == f)));
            found.dust.extend(dust.first().map(|&f| (t, f)));
            for (slot, list) in faces.iter().enumerate() {
                let [a, b, c] = FACE[slot].map(|k| v[k]);
                let key = triangle(a, b, c);
                let across = self.mesh.topology().at(t).neighbours()[slot];
                let ghost = self.mesh.topology().at(tet_of(across)).is_ghost();
                for &(f, turn) in list.iter().filter(|(_, turn)| *turn != 0) {
                    let layers = &mut found.layers[f as usize];
                    let above = is_above(slot, turn);
                    if !dust.contains(&f) {
                        layers.side(above).push(Tile { key, tet: t, slot });
                    }
                    if ghost {
                        let (tet, slot) = (tet_of(across), slot_of(across));
                        layers.side(!above).push(Tile { key, tet, slot });
                    }
                }
            }
        }
        found
    }

    /// The patches that a face of the mesh lies in, with the sign of its projection.
    fn tiles_of(&self, patches: &[Vec<u32>], face: [VertexId; 3]) -> Vec<(u32, i128)> {
        let [a, b, c] = face.map(|v| &patches[v as usize]);
        let common = a.iter().filter(|f| b.contains(f) && c.contains(f));
        let p = || face.map(|v| self.at(v));
        let tile = |&f: &u32| {
            let [a, b, c] = p();
            let patch = self.plc.facets[f as usize].patch.as_ref()?;
            let turn = patch.turn([&a, &b, &c]);
            patch.holds_triangle([&a, &b, &c]).then_some((f, turn))
        };
        common.filter_map(tile).collect()
    }

    /// The subsegments of each patch.
    fn outlines(&self) -> Vec<Vec<([VertexId; 2], usize)>> {
        let mut outlines = vec![Vec::new(); self.plc.facets.len()];
        let mut all: Vec<(&[VertexId; 2], &u32)> = self.segments.iter().collect();
        all.sort_unstable();
        for (&key, &s) in all {
            let segment = &self.plc.segments[s as usize];
            for &f in &segment.facets {
                let count = if segment.twice.contains(&f) { 2 } else { 1 };
                outlines[f as usize].push((key, count));
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
        for (v, patches) in (0..).zip(self.patches_at()) {
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
        for &(t, _) in &found.dust {
            self.marks.set_region(t, DUST);
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
                let first = self.marks.region(layer.first()?.tet);
                layer.iter().all(|tile| self.marks.region(tile.tet) == first).then_some(first)
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
            if let Some(patch) = &mut self.plc.facets[f as usize].patch {
                patch.sides = Some(Sides { inner, outer, upwards });
            }
        }
        for &(t, f) in &found.dust {
            let sides = self.plc.facets[f as usize].patch.as_ref().and_then(|p| p.sides);
            let Some(sides) = sides else { return false };
            self.marks.set_region(t, sides.outer);
        }
        self.mesh.topology().iter().all(|(t, tet)| {
            let (word, own) = (self.marks.of(t), self.marks.region(t));
            let mut others = tet.neighbours().into_iter().enumerate();
            others.all(|(slot, face)| {
                word & face_bit(slot) != 0 || self.marks.region(tet_of(face)) == own
            })
        })
    }

    /// Are all four corners on one patch?
    pub(crate) fn is_flat(&self, v: [VertexId; 4]) -> bool {
        let mut patches = self.facets_of(self.carriers[v[0] as usize]);
        patches.retain(|&f| {
            let on = |v: &VertexId| self.lies_on(self.carriers[*v as usize], f);
            self.plc.facets[f as usize].patch.is_some() && v[1..].iter().all(on)
        });
        !patches.is_empty()
    }
}

impl Layers {
    /// The layer of the side on which a tetrahedron is.
    fn side(&mut self, above: bool) -> &mut Vec<Tile> {
        if above { &mut self.upper } else { &mut self.lower }
    }
}

/// The edges of which a layer has not as many triangles as it should.
fn open_edges(layer: &[Tile], outline: &[([VertexId; 2], usize)]) -> Vec<[VertexId; 2]> {
    let mut counts: Map<[VertexId; 2], isize> = Map::default();
    for (side, _) in layer.iter().flat_map(|tile| sides(tile.key)) {
        *counts.entry(side).or_insert(2) -= 1;
    }
    for &(side, count) in outline {
        *counts.entry(side).or_insert(2) -= 2 - count as isize;
    }
    counts.into_iter().filter(|&(_, left)| left != 0).map(|(side, _)| side).collect()
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
