//! The tiles of patches: which faces of the mesh are on the lower and the upper side of a patch.
//!
//! Vertices of a patch are not quite in one plane, so the Delaunay mesh may hold flat tetrahedra
//! whose four corners are on the patch. Those whose faces all lie in its polygons, in the
//! projection, are *dust*. The faces of the mesh that lie in the patch and have no dust below them
//! are its *lower layer*, those with none above them the *upper* one. Without dust the two are the
//! same, and with it one of them is needed, that on the inner side.
//!
//! A flat tetrahedron over the outline of the patch, of a hole for example, is no dust. A side of
//! the outline passes above or below it, and the mesh has that side; so the tetrahedron is below
//! the patch, or above it, and with it the dust below it, or above it. Faces between two such
//! tetrahedra are in no layer.

use super::state::{FACE, State};
use crate::table::{Map, triangle};
use ltbw_core::topology::{TetId, VertexId, slot_of, tet_of};

/// A face of a layer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile {
    pub(crate) key: [VertexId; 3],
    /// The tetrahedron on its side of the layer, and the face's slot there.
    pub(crate) tet: TetId,
    pub(crate) slot: usize,
}

/// The layers of a patch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layers {
    pub(crate) lower: Vec<Tile>,
    pub(crate) upper: Vec<Tile>,
    /// Which of them is complete.
    pub(crate) complete: [bool; 2],
}

/// All layers, by facet, and all dust with its facet.
#[derive(Clone, Debug, Default)]
pub(crate) struct Found {
    pub(crate) layers: Vec<Layers>,
    pub(crate) dust: Vec<Dust>,
}

/// A tetrahedron that is dust of a facet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dust {
    pub(crate) tet: TetId,
    pub(crate) facet: u32,
    /// Is it above the patch, or below it? `None` if it may be either.
    pub(crate) above: Option<bool>,
}

/// A flat tetrahedron over the outline of a patch, or dust beside one.
#[derive(Clone, Copy, Debug)]
struct Sided {
    tet: TetId,
    facet: u32,
    /// Is it above the patch, or below it?
    above: bool,
}

/// The faces of a tetrahedron that lie in patches, each with the sign of its projection.
type Faces = [Vec<(u32, i128)>; 4];

/// The flat tetrahedra of patches: above the patch, below it, or `None`.
type Flat = Map<(TetId, u32), Option<bool>>;

/// Is the apex of a positively oriented tetrahedron, opposite `slot`, above the face, whose
/// projection has this sign?
pub(crate) fn is_above(slot: usize, turn: i128) -> bool {
    (slot % 2 == 1) == (turn > 0)
}

impl State {
    /// The patches on which each vertex lies.
    pub(crate) fn patches_at(&self) -> Vec<Vec<u32>> {
        let is_patch = |f: &u32| self.is_patch(*f);
        let of = |carrier| self.plc.facets_of(carrier).iter().copied().filter(is_patch).collect();
        let mut all: Vec<Vec<u32>> = self.carriers.iter().skip(1).map(of).collect();
        all.insert(0, Vec::new());
        all
    }

    /// Finds the layers of all patches.
    pub(crate) fn find_layers(&self) -> Found {
        let patches = self.patches_at();
        let mut found = Found::default();
        found.layers.resize(self.plc.facets.len(), Layers::default());
        let (mut flat, mut all) = (Flat::default(), Vec::new());
        let mut stack: Vec<Sided> = Vec::new();
        for t in self.mesh.tet_ids() {
            let v = self.vertices(t);
            let faces: Faces =
                [0, 1, 2, 3].map(|slot| self.tiles_of(&patches, FACE[slot].map(|k| v[k])));
            let mut on: Vec<u32> = faces.iter().flatten().map(|&(f, _)| f).collect();
            on.sort_unstable();
            on.dedup();
            // A face that is nothing in the projection is no tile, but may be one of dust.
            let is_dust = |f: &&u32| faces.iter().all(|list| list.iter().any(|(g, _)| g == *f));
            if let Some(&f) = on.iter().find(is_dust) {
                found.dust.push(Dust { tet: t, facet: f, above: None });
                flat.insert((t, f), None);
                on.clear();
            }
            let is_flat = |f: &u32| v.iter().all(|&v| patches[v.index()].contains(f));
            for f in on.into_iter().filter(is_flat) {
                if let Some(above) = self.side_at_outline(f, v, &faces) {
                    flat.insert((t, f), Some(above));
                    stack.push(Sided { tet: t, facet: f, above });
                }
            }
            if faces.iter().any(|list| !list.is_empty()) {
                all.push((t, faces));
            }
        }
        self.spread_sides(&patches, &mut flat, stack);
        for dust in &mut found.dust {
            dust.above = flat.get(&(dust.tet, dust.facet)).copied().flatten();
        }
        for (t, faces) in &all {
            self.put_tiles(*t, faces, &flat, &mut found.layers);
        }
        found
    }

    /// Whether a flat tetrahedron is above the patch `f`, by the sides of the outline that pass
    /// through its faces in the projection.
    fn side_at_outline(&self, f: u32, v: [VertexId; 4], faces: &Faces) -> Option<bool> {
        let patch = self.plc.facets[f as usize].patch.as_ref()?;
        let is_tile = |slot: usize| faces[slot].iter().any(|(g, _)| *g == f);
        let heights = (0..4).filter(|&slot| !is_tile(slot)).filter_map(|slot| {
            let [a, b, c] = FACE[slot].map(|k| self.at(v[k]));
            patch.height_over_outline([&a, &b, &c])
        });
        let most = heights.max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        Some(most > 0.0)
    }

    /// Spreads the sides of flat tetrahedra to the dust above those above, and below those below.
    fn spread_sides(&self, patches: &[Vec<u32>], flat: &mut Flat, mut stack: Vec<Sided>) {
        // Each tetrahedron gets one side at most.
        while let Some(Sided { tet: t, facet: f, above }) = stack.pop() {
            let (v, neighbours) = (self.vertices(t), self.mesh.topology().at(t).neighbours());
            for (slot, face) in neighbours.into_iter().enumerate() {
                let tiles = self.tiles_of(patches, FACE[slot].map(|k| v[k]));
                let tile = tiles.into_iter().find(|(g, turn)| *g == f && *turn != 0);
                // The next one is on the other side of the face than this one.
                if tile.is_some_and(|(_, turn)| is_above(slot, turn) != above)
                    && let Some(side @ None) = flat.get_mut(&(tet_of(face), f))
                {
                    *side = Some(above);
                    stack.push(Sided { tet: tet_of(face), facet: f, above });
                }
            }
        }
    }

    /// Puts the faces of a tetrahedron into the layers on its side of them.
    fn put_tiles(&self, t: TetId, faces: &Faces, flat: &Flat, layers: &mut [Layers]) {
        let v = self.vertices(t);
        for (slot, list) in faces.iter().enumerate() {
            let [a, b, c] = FACE[slot].map(|k| v[k]);
            let key = triangle(a, b, c);
            let across = self.mesh.topology().at(t).neighbours()[slot];
            let ghost = self.mesh.topology().at(tet_of(across)).is_ghost();
            for &(f, turn) in list.iter().filter(|(_, turn)| *turn != 0) {
                let layers = &mut layers[f as usize];
                let above = is_above(slot, turn);
                let side = |t: TetId| flat.get(&(t, f)).copied();
                let (own, other) = (side(t), side(tet_of(across)));
                let is_own = own.is_none_or(|own| own == Some(above));
                if is_own && other != Some(Some(above)) {
                    layers.side(above).push(Tile { key, tet: t, slot });
                }
                if ghost && own != Some(Some(!above)) {
                    let (tet, slot) = (tet_of(across), slot_of(across));
                    layers.side(!above).push(Tile { key, tet, slot });
                }
            }
        }
    }

    /// The patches that a face of the mesh lies in, with the sign of its projection.
    fn tiles_of(&self, patches: &[Vec<u32>], face: [VertexId; 3]) -> Vec<(u32, i128)> {
        let [a, b, c] = face.map(|v| &patches[v.index()]);
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
}

impl Layers {
    /// The layer of the side on which a tetrahedron is.
    fn side(&mut self, above: bool) -> &mut Vec<Tile> {
        if above { &mut self.upper } else { &mut self.lower }
    }
}
