//! The tiles of patches: of facets that are coplanar within the tolerance of the domain.
//!
//! The faces of the mesh on a patch lie where the domain ends or the tag changes. They have their
//! corners in the slab, all turn the same way in the projection, have the polygons' area, and form
//! a surface whose edges are of two of them, but for those of the patch's outline.

use super::facet::FlatFacet;
use super::flat;
use super::patch::Patch;
use super::place::groups;
use super::slab::Slab;
use super::whole::{Units, Whole, twice_area};
use super::{ConformityDefect, Plc, Run, edge};
use crate::faces::Faces;
use crate::mesh::{Side, face};
use num_bigint::BigInt;
use std::collections::{HashMap, HashSet};

/// A mesh in units of its own, its faces, and the tags of its tetrahedra.
#[derive(Clone, Copy)]
pub(crate) struct InUnits<'a> {
    pub(crate) units: &'a Units,
    pub(crate) points: &'a [Whole],
    pub(crate) faces: &'a Faces,
    pub(crate) tags: Option<&'a [i64]>,
    /// The names that it has in the whole, if it is a part: a face that it has once is left out.
    pub(crate) part: Option<Names<'a>>,
}

/// The names of a part's tetrahedra and vertices in the whole mesh.
#[derive(Clone, Copy)]
pub(crate) struct Names<'a> {
    /// The number of the first tetrahedron.
    pub(crate) first: u32,
    /// The numbers of the vertices.
    pub(crate) numbers: &'a [u32],
    /// The numbers of the vertices by coordinates.
    pub(crate) by_place: &'a [u32],
}

/// A face of the mesh beside which a tetrahedron lies.
pub(crate) struct Beside<'a> {
    /// The patches that each corner is on.
    pub(crate) on: [&'a Vec<u32>; 3],
    pub(crate) places: [Whole; 3],
    /// The vertex of the tetrahedron that is none of the face.
    pub(crate) apex: Whole,
    /// The names of the corners, by which edges meet.
    pub(crate) corners: [u32; 3],
    /// The tetrahedron and the corners, for a finding.
    pub(crate) ids: [u32; 4],
}

/// The tiles of one patch.
#[derive(Clone, Default)]
pub(crate) struct Tiles {
    pub(crate) area: BigInt,
    /// The number of tiles at each edge.
    pub(crate) edges: HashMap<[u32; 2], u32>,
    /// Tiles by the way that they turn.
    pub(crate) turns: [u64; 2],
    /// One that turns each way: tetrahedron and corners.
    pub(crate) first: [Option<[u32; 4]>; 2],
}

impl Tiles {
    /// The edges of an odd number of tiles.
    pub(crate) fn odd(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.edges.iter().filter(|(_, count)| **count % 2 == 1).map(|own| *own.0)
    }
}

/// The tiles of all patches, and what it took to find them.
pub(crate) struct Tiled {
    pub(crate) tiles: Vec<Tiles>,
    pub(crate) subfaces: u64,
    pub(crate) steps: u64,
}

/// The patches of a domain.
pub(crate) struct Patches {
    pub(crate) list: Vec<Patch>,
    /// The patch of each facet; the largest number for none.
    of: Vec<u32>,
    slab: Slab,
}

impl Patches {
    /// The patches of a domain whose vertices are `corners`, in these units; `None` if coordinates
    /// are too fine to tell.
    pub(crate) fn find(plc: &Plc, corners: &[Whole], units: &Units) -> Option<Self> {
        Some(Self::of(flat::find(plc, corners)?, plc, units))
    }

    /// No patches.
    pub(crate) fn none(plc: &Plc, units: &Units) -> Self {
        Self::of(Vec::new(), plc, units)
    }

    fn of(list: Vec<Patch>, plc: &Plc, units: &Units) -> Self {
        let mut of = vec![u32::MAX; plc.facets.len()];
        for (k, patch) in (0u32..).zip(&list) {
            patch.facets.iter().for_each(|&f| of[f as usize] = k);
        }
        Self { list, of, slab: Slab::new(plc.flat_tolerance, units) }
    }

    /// Per facet the first one of its patch or plane. Facets of patches have no plane any more.
    pub(crate) fn groups(&self, flat: &mut [Option<FlatFacet>], corners: &[Whole]) -> Vec<u32> {
        let facets = || self.list.iter().flat_map(|patch| &patch.facets);
        facets().for_each(|&f| flat[f as usize] = None);
        let mut groups = groups(flat, corners);
        for patch in &self.list {
            patch.facets.iter().for_each(|&f| groups[f as usize] = patch.facets[0]);
        }
        groups
    }

    /// Per vertex the patches that it is on; `on`: the facets in whose planes it is.
    pub(crate) fn at(&self, on: &[Vec<u32>], points: &[Whole]) -> Vec<Vec<u32>> {
        let patches_of = |(v, facets): (usize, &Vec<u32>)| {
            let mut list: Vec<u32> = facets.iter().map(|&f| self.of[f as usize]).collect();
            list.sort_unstable();
            list.dedup();
            let near = |k: &u32| self.list[*k as usize].is_in_slab(&points[v], &self.slab);
            list.retain(|k| *k != u32::MAX && near(k));
            list
        };
        on.iter().enumerate().map(patches_of).collect()
    }

    /// No tiles yet.
    pub(crate) fn tiled(&self) -> Tiled {
        Tiled { tiles: vec![Tiles::default(); self.list.len()], subfaces: 0, steps: 0 }
    }

    /// Takes a face where the domain ends, or where the tag changes, seen from the higher one: is
    /// it a tile?
    pub(crate) fn take(&self, face: &Beside<'_>, to: &mut Tiled) -> bool {
        let Beside { on: [a, b, c], places, apex, corners, ids } = face;
        let before = to.subfaces;
        for &k in a.iter().filter(|k| b.contains(k) && c.contains(k)) {
            let patch = &self.list[k as usize];
            if !patch.holds_centroid(places, &mut to.steps) {
                continue;
            }
            let [p, q, r] = places.map(|p| patch.flat(&p));
            let area = outward(twice_area(p, q, r), places, apex);
            let tile = &mut to.tiles[k as usize];
            tile.area += BigInt::from(area.abs());
            let way = usize::from(area < 0);
            tile.turns[way] += u64::from(area != 0);
            tile.first[way].get_or_insert(*ids);
            for (x, y) in [(0, 1), (1, 2), (0, 2)] {
                *tile.edges.entry(edge(corners[x], corners[y])).or_default() += 1;
            }
            to.subfaces += 1;
        }
        to.subfaces > before
    }

    /// The volume that lies between the patches and their planes, at most.
    fn within(&self, units: &Units, tolerance: f64) -> f64 {
        let area = self.list.iter().fold(0.0, |sum, patch| sum + patch.plane_area() * 2.0);
        units.square(area) * tolerance
    }
}

impl Run<'_> {
    /// The tiles of all patches; adds the codes of their faces to `codes`, which has those of faces
    /// on other facets. `on`: per vertex the patches that it is on.
    pub(crate) fn found_on_patches(
        &mut self,
        patches: &Patches,
        mesh: &InUnits<'_>,
        on: &[Vec<u32>],
        codes: &mut HashSet<u32>,
    ) -> Tiled {
        let InUnits { units, points, faces, tags, part } = *mesh;
        self.out.patches = patches.list.len() as u64;
        self.out.volume_within = patches.within(units, self.plc.flat_tolerance);
        let mut tiled = patches.tiled();
        let tag = |t: usize| tags.and_then(|tags| tags.get(t));
        for (t, tet) in self.mesh.tets.iter().enumerate() {
            for i in 0..4 {
                let corners = face(tet, i);
                // A low facet beside a patch, steep or folded under it, may have its corners in the
                // slab. Its faces are exactly on it, and are no tiles of the patch.
                let is_elsewhere = codes.contains(&((4 * t + i) as u32));
                if is_elsewhere || corners.iter().any(|&v| on[v as usize].is_empty()) {
                    continue;
                }
                let other = faces.other(t, i);
                // Between two tags the face is looked at from the higher one.
                if other.map_or(part.is_some(), |other| tag(t) <= tag(other.t)) {
                    continue;
                }
                let [a, b, c] = corners;
                let (ids, names) = match part {
                    None => ([t as u32, a, b, c], corners),
                    Some(Names { first, numbers, by_place }) => {
                        let [a, b, c] = corners.map(|v| numbers[v as usize]);
                        let names = corners.map(|v| by_place[v as usize]);
                        ([first.saturating_add(t as u32), a, b, c], names)
                    }
                };
                let beside = Beside {
                    on: corners.map(|v| &on[v as usize]),
                    places: corners.map(|v| points[v as usize]),
                    apex: points[tet[i] as usize],
                    corners: names,
                    ids,
                };
                if patches.take(&beside, &mut tiled) {
                    codes.insert((4 * t + i) as u32);
                    codes.extend(other.map(Side::code));
                }
            }
        }
        tiled
    }

    /// The tiles of all patches of a whole mesh, as [`Run::found_on_patches`] finds them, and what
    /// is wrong with them; `outline`: the edges of the mesh on edges of the domain.
    pub(crate) fn patches(
        &mut self,
        patches: &Patches,
        mesh: &InUnits<'_>,
        on: &[Vec<u32>],
        outline: &HashSet<[u32; 2]>,
        codes: &mut HashSet<u32>,
    ) {
        let tiled = self.found_on_patches(patches, mesh, on, codes);
        self.out.subfaces += tiled.subfaces;
        self.out.steps += tiled.steps;
        for (patch, tiles) in patches.list.iter().zip(&tiled.tiles) {
            let is_open = tiles.odd().any(|edge| !outline.contains(&edge));
            self.judge_tiles(patch, tiles, is_open);
        }
    }

    /// The tiles of a patch turn one way, have its area, and end at its outline alone.
    pub(crate) fn judge_tiles(&mut self, patch: &Patch, tiles: &Tiles, is_open: bool) {
        let fewer = usize::from(tiles.turns[0] >= tiles.turns[1]);
        if let Some(ids) = tiles.first[fewer].filter(|_| tiles.turns[fewer] > 0) {
            self.add(ConformityDefect::PatchFolded, &ids);
        }
        if tiles.area != patch.area || is_open {
            self.add(ConformityDefect::FacetNotTiled, &patch.facets[..1]);
        }
    }
}

/// `area` of the projection with the sign that it has for a face that points away from `apex`.
fn outward(area: i128, [a, b, c]: &[Whole; 3], apex: &Whole) -> i128 {
    let six = super::six_volumes([*a, *b, *c, *apex]);
    if six > BigInt::ZERO { -area } else { area }
}
