//! The faces at which parts touch, and those of the hull, where they have met.

use super::super::tiles::{Found, Planes, planes_of};
use super::super::tree::Tree;
use super::super::whole::{Units, Whole};
use super::super::{ConformityDefect, Run};
use super::{Facets, sums};
use crate::mesh::{Mesh, Point, split};
use crate::parted::Soundness;
use crate::parted::exchange::{Exchange, deal, member_of};
use crate::parted::faces::{Facet, Met};
use num_bigint::BigInt;
use std::collections::HashMap;

/// A face that has met here.
struct Face {
    /// Its vertices by coordinates, ascending.
    key: [u32; 3],
    /// The one tetrahedron that has it, with the corners by number; none if there are two.
    hull: Option<[u32; 4]>,
    /// Its corners among those here.
    corners: [u32; 3],
    is_tile: bool,
}

/// The faces that have met here.
pub(super) struct Between {
    /// In the order of their keys.
    faces: Vec<Face>,
    points: Vec<Point>,
    places: Vec<Whole>,
}

/// A side of a face: the key of the face, a tetrahedron, its component, and its tag in two halves.
pub(super) type Side = [u32; 7];

/// The sides of the faces that a part has once.
pub(super) fn sides(
    mesh: &Mesh<'_>,
    sound: &Soundness,
    cells: &[u32],
    tags: Option<&[i64]>,
) -> Vec<Side> {
    let side = |&code: &u32| {
        let own = split(code);
        let mut key =
            crate::mesh::face(&mesh.tets[own.t], own.i).map(|v| sound.by_place[v as usize]);
        key.sort_unstable();
        let [a, b, c] = key;
        let tag = tags.and_then(|tags| tags.get(own.t)).copied().unwrap_or_default() as u64;
        let tet = sound.first.saturating_add(own.t as u32);
        [a, b, c, tet, cells[own.t], tag as u32, (tag >> 32) as u32]
    };
    sound.faces.hull.iter().map(side).collect()
}

impl Between {
    pub(super) fn of(met: &Met, units: &Units) -> Self {
        let mut own = Self { faces: Vec::new(), points: Vec::new(), places: Vec::new() };
        let mut numbers: HashMap<u32, u32> = HashMap::new();
        let pairs = met.pairs.iter().map(|[one, _]| (one, false));
        for (facet, is_hull) in met.hull.iter().map(|facet| (facet, true)).chain(pairs) {
            let [a, b, c, _] = facet.v;
            let corners = [a, b, c].map(|v| {
                *numbers.entry(v.by_place).or_insert_with(|| {
                    own.points.push(v.corner.at);
                    own.places.push(units.whole(&v.corner.at));
                    own.points.len() as u32 - 1
                })
            });
            let hull = is_hull.then(|| ids_of(facet));
            own.faces.push(Face { key: facet.key(), hull, corners, is_tile: false });
        }
        own.faces.sort_unstable_by_key(|face| face.key);
        own
    }

    /// Finds those that are on facets, and adds their areas.
    pub(super) fn find_tiles(
        &mut self,
        run: &mut Run<'_>,
        &Facets { facets, corners, groups }: &Facets<'_>,
        planes: &Planes<'_>,
        areas: &mut [BigInt],
    ) {
        let mesh = Mesh::new(&self.points, &[]);
        let tree = Tree::new(&self.places, (0..self.places.len() as u32).collect());
        let here =
            Run { mesh: &mesh, exterior: Default::default(), out: Default::default(), ..*run };
        let on = { here }.vertices_on(facets, corners, &tree);
        let on = planes_of(&on, groups);
        let mut found = Found::default();
        for face in &mut self.faces {
            let places = face.corners.map(|v| self.places[v as usize]);
            let on = face.corners.map(|v| &on[v as usize]);
            face.is_tile = planes.is_tile(on, places, &mut found);
        }
        run.out.subfaces += found.subfaces;
        found.areas.into_iter().for_each(|(g, area)| areas[g as usize] += area);
    }

    /// Every face of one tetrahedron is on a facet.
    pub(super) fn hull(&self, run: &mut Run<'_>) {
        for ids in self.faces.iter().filter(|face| !face.is_tile).filter_map(|face| face.hull) {
            run.add(ConformityDefect::HullFaceOffFacet, &ids);
        }
    }

    /// The pairs of components that faces on no facet join, of all members; their tags are equal.
    pub(super) fn join<E: Exchange>(
        &self,
        run: &mut Run<'_>,
        team: &mut E,
        sides: Vec<Side>,
    ) -> Result<Vec<[u32; 2]>, E::Error> {
        let members = team.members();
        let met = deal(team, sides.into_iter(), |side| member_of(&side[..3], members))?;
        let mut met: Vec<Side> = met.into_iter().flatten().collect();
        met.sort_unstable();
        let mut joined = Vec::new();
        for pair in met.chunk_by(|a, b| a[..3] == b[..3]) {
            let [one, other] = pair else { continue };
            let key = [one[0], one[1], one[2]];
            let found = self.faces.binary_search_by_key(&key, |face| face.key);
            if found.is_ok_and(|k| self.faces[k].is_tile) {
                continue;
            }
            if one[5..] != other[5..] {
                run.add(ConformityDefect::TagsDiffer, &[one[3], other[3]]);
            }
            joined.push([one[4].min(other[4]), one[4].max(other[4])]);
        }
        joined.sort_unstable();
        joined.dedup();
        sums::all(team, &joined)
    }
}

/// The tetrahedron of a face, and its corners.
fn ids_of(facet: &Facet) -> [u32; 4] {
    let [a, b, c, _] = facet.v.map(|v| v.corner.number);
    [facet.tet, a, b, c]
}
