//! The tiles of patches (`flat`): facets that are coplanar within the tolerance of the domain.
//!
//! The faces of the mesh on a patch lie where the domain ends or the tag changes. They have their
//! corners in the slab, all turn the same way in the projection, have the polygons' area, and form
//! a surface whose edges are of two of them, but for those of the patch's outline.

use super::outline::{Flat, Outline, Weighted, signed_area};
use super::slab::{Slab, big_dot, minus};
use super::whole::{Units, Whole, twice_area};
use super::{ConformityDefect, Run, edge};
use crate::faces::Faces;
use crate::mesh::{Side, face};
use num_bigint::BigInt;
use std::collections::{HashMap, HashSet};

/// A plane, and the axis along which it is projected.
#[derive(Clone, Copy)]
pub(crate) struct Cast {
    pub(crate) axis: usize,
    pub(crate) normal: Whole,
    pub(crate) origin: Whole,
}

/// A patch.
#[derive(Debug)]
pub(crate) struct Patch {
    /// Its facets, the largest first.
    pub(crate) facets: Vec<u32>,
    axis: usize,
    /// The normal of its plane, in units of the domain.
    normal: [i128; 3],
    /// The corner in its plane, in units of the mesh.
    origin: Whole,
    /// The polygons in the projection, in thirds of units of the mesh.
    outline: Outline,
    /// Twice their area there, in ninths of square units.
    area: BigInt,
}

impl Patch {
    pub(crate) fn new(
        facets: Vec<u32>,
        plane: Cast,
        rings: &[&Vec<u32>],
        corners: &[Whole],
    ) -> Self {
        let Cast { axis, normal, origin } = plane;
        let axes = [(axis + 1) % 3, (axis + 2) % 3];
        let flat = |ring: &&Vec<u32>| -> Vec<Flat> {
            ring.iter().map(|&v| axes.map(|k| 3 * corners[v as usize][k])).collect()
        };
        let rings: Vec<Vec<Flat>> = rings.iter().map(flat).collect();
        let outline = Outline::new(rings.iter().map(|ring| Weighted::once(ring)));
        let area = |ring: &Vec<Flat>| {
            let area = signed_area(ring);
            if area < BigInt::ZERO { -area } else { area }
        };
        let area = rings.iter().map(area).sum();
        Self { facets, axis, normal, origin, outline, area }
    }

    fn flat(&self, p: &Whole) -> Flat {
        [3 * p[(self.axis + 1) % 3], 3 * p[(self.axis + 2) % 3]]
    }

    /// Is the centroid of a triangle in a polygon, in the projection?
    fn holds_centroid(&self, corners: &[Whole; 3], steps: &mut u64) -> bool {
        let flats = corners.map(|p| self.flat(&p));
        let centre = [0, 1].map(|k| flats.iter().map(|p| p[k] / 3).sum::<i128>());
        self.outline.weight_at(centre, steps) > 0
    }

    /// Is a point within the tolerance of the plane?
    fn is_in_slab(&self, p: &Whole, slab: &Slab) -> bool {
        slab.holds(
            &big_dot(&self.normal, &minus(p, &self.origin)),
            &big_dot(&self.normal, &self.normal),
        )
    }

    /// An upper bound of the area in the plane, in square units.
    fn plane_area(&self) -> f64 {
        let projected = big_to_f64(&self.area) / 18.0;
        let n = self.normal.map(|c| c as f64);
        let length = n.iter().map(|c| c * c).sum::<f64>().sqrt();
        projected * length / n[self.axis].abs() * (1.0 + 1e-9)
    }
}

/// A big integer, rounded.
fn big_to_f64(n: &BigInt) -> f64 {
    n.to_string().parse().unwrap_or(f64::INFINITY)
}

/// A mesh in units of its own, its faces, and the tags of its tetrahedra.
#[derive(Clone, Copy)]
pub(crate) struct InUnits<'a> {
    pub(crate) units: &'a Units,
    pub(crate) points: &'a [Whole],
    pub(crate) faces: &'a Faces,
    pub(crate) tags: Option<&'a [i64]>,
}

/// The tiles of one patch.
#[derive(Default)]
struct Tiles {
    area: BigInt,
    /// The number of tiles at each edge.
    edges: HashMap<[u32; 2], u32>,
    /// Tiles by the way that they turn.
    turns: [u64; 2],
    /// One that turns each way: tetrahedron and corners.
    first: [Option<[u32; 4]>; 2],
}

impl Run<'_> {
    /// The tiles of all patches; adds the codes of their faces to `codes`. `on`: per vertex the
    /// facets in whose planes it is; `outline`: the edges of the mesh on edges of the domain.
    ///
    /// Returns per vertex the patches that it is on.
    pub(crate) fn patches(
        &mut self,
        patches: &[Patch],
        mesh: &InUnits<'_>,
        on: &[Vec<u32>],
        outline: &HashSet<[u32; 2]>,
        codes: &mut HashSet<u32>,
    ) -> Vec<Vec<u32>> {
        let InUnits { units, points, faces, tags } = *mesh;
        let mut of = vec![u32::MAX; self.plc.facets.len()];
        for (k, patch) in (0u32..).zip(patches) {
            patch.facets.iter().for_each(|&f| of[f as usize] = k);
        }
        let slab = Slab::new(self.plc.flat_tolerance, units);
        let patches_of = |(v, facets): (usize, &Vec<u32>)| {
            let mut list: Vec<u32> = facets.iter().map(|&f| of[f as usize]).collect();
            list.sort_unstable();
            list.dedup();
            let near = |k: &u32| patches[*k as usize].is_in_slab(&points[v], &slab);
            list.retain(|k| *k != u32::MAX && near(k));
            list
        };
        let on: Vec<Vec<u32>> = on.iter().enumerate().map(patches_of).collect();
        let mut tiles: Vec<Tiles> = patches.iter().map(|_| Tiles::default()).collect();
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
                if other.is_some_and(|other| tag(t) <= tag(other.t)) {
                    continue;
                }
                let [a, b, c] = corners.map(|v| &on[v as usize]);
                let places = corners.map(|v| points[v as usize]);
                for &k in a.iter().filter(|k| b.contains(k) && c.contains(k)) {
                    let patch = &patches[k as usize];
                    if !patch.holds_centroid(&places, &mut self.out.steps) {
                        continue;
                    }
                    let [p, q, r] = places.map(|p| patch.flat(&p));
                    let apex = points[tet[i] as usize];
                    let area = outward(twice_area(p, q, r), &places, &apex);
                    let tile = &mut tiles[k as usize];
                    tile.area += BigInt::from(area.abs());
                    let way = usize::from(area < 0);
                    tile.turns[way] += u64::from(area != 0);
                    tile.first[way].get_or_insert([t as u32, corners[0], corners[1], corners[2]]);
                    for (x, y) in [(0, 1), (1, 2), (0, 2)] {
                        *tile.edges.entry(edge(corners[x], corners[y])).or_default() += 1;
                    }
                    self.out.subfaces += 1;
                    codes.insert((4 * t + i) as u32);
                    codes.extend(other.map(Side::code));
                }
            }
        }
        let mut within = 0.0;
        for (patch, tile) in patches.iter().zip(tiles) {
            let fewer = usize::from(tile.turns[0] >= tile.turns[1]);
            if let Some(ids) = tile.first[fewer].filter(|_| tile.turns[fewer] > 0) {
                self.add(ConformityDefect::PatchFolded, &ids);
            }
            let mut odd = tile.edges.iter().filter(|(_, count)| **count % 2 == 1);
            if tile.area != patch.area || odd.any(|(e, _)| !outline.contains(e)) {
                self.add(ConformityDefect::FacetNotTiled, &patch.facets[..1]);
            }
            within += patch.plane_area() * 2.0;
        }
        self.out.patches = patches.len() as u64;
        self.out.volume_within = units.square(within) * self.plc.flat_tolerance;
        on
    }
}

/// `area` of the projection with the sign that it has for a face that points away from `apex`.
fn outward(area: i128, [a, b, c]: &[Whole; 3], apex: &Whole) -> i128 {
    let six = super::six_volumes([*a, *b, *c, *apex]);
    if six > BigInt::ZERO { -area } else { area }
}
