//! The faces at which parts touch, and those of the hull, where they have met.

use super::super::facet::FlatFacet;
use super::super::patches::{Beside, Patches, Tiled};
use super::super::tiles::{Found, Planes, planes_of};
use super::super::tree::Tree;
use super::super::whole::{Units, Whole};
use super::super::{ConformityDefect, Run};
use super::sums;
use crate::mesh::{Mesh, Point, split};
use crate::parted::Soundness;
use crate::parted::exchange::{Exchange, deal, member_of};
use crate::parted::faces::{Facet, Met};
use num_bigint::BigInt;
use std::collections::HashMap;

/// A face that has met here.
struct Face<'m> {
    /// Its vertices by coordinates, ascending.
    key: [u32; 3],
    /// It, as the one tetrahedron has it, or of two that of the higher tag.
    facet: &'m Facet,
    /// The tags of two tetrahedra; none if it is one's.
    tags: Option<[i64; 2]>,
    /// Its corners among those here.
    corners: [u32; 3],
    is_tile: bool,
}

/// The faces that have met here.
pub(super) struct Between<'m> {
    /// In the order of their keys.
    faces: Vec<Face<'m>>,
    points: Vec<Point>,
    places: Vec<Whole>,
    /// The facets in whose planes each point is.
    on: Vec<Vec<u32>>,
}

/// A side of a face: the key of the face, a tetrahedron, and its component.
pub(super) type Side = [u32; 5];

/// The sides of the faces that a part has once.
pub(super) fn sides(mesh: &Mesh<'_>, sound: &Soundness, cells: &[u32]) -> Vec<Side> {
    let side = |&code: &u32| {
        let own = split(code);
        let mut key =
            crate::mesh::face(&mesh.tets[own.t], own.i).map(|v| sound.by_place[v as usize]);
        key.sort_unstable();
        let [a, b, c] = key;
        let tet = sound.first.saturating_add(own.t as u32);
        [a, b, c, tet, cells[own.t]]
    };
    sound.faces.hull.iter().map(side).collect()
}

impl<'m> Between<'m> {
    /// The faces that have met, with the facets that they may be on.
    pub(super) fn of(
        met: &'m Met,
        units: &Units,
        run: &Run<'_>,
        facets: &[Option<FlatFacet>],
        corners: &[Whole],
    ) -> Self {
        let (points, places, on) = Default::default();
        let mut own = Self { faces: Vec::new(), points, places, on };
        let mut numbers: HashMap<u32, u32> = HashMap::new();
        let pair = |[one, other]: &'m [Facet; 2]| {
            let higher = if one.tag < other.tag { other } else { one };
            (higher, Some([one.tag, other.tag]))
        };
        let hull = met.hull.iter().map(|facet| (facet, None));
        for (facet, tags) in hull.chain(met.pairs.iter().map(pair)) {
            let [a, b, c, _] = facet.v;
            let corners = [a, b, c].map(|v| {
                *numbers.entry(v.by_place).or_insert_with(|| {
                    own.points.push(v.corner.at);
                    own.places.push(units.whole(&v.corner.at));
                    own.points.len() as u32 - 1
                })
            });
            own.faces.push(Face { key: facet.key(), facet, tags, corners, is_tile: false });
        }
        own.faces.sort_unstable_by_key(|face| face.key);
        let mesh = Mesh::new(&own.points, &[]);
        let tree = Tree::new(&own.places, (0..own.places.len() as u32).collect());
        let here =
            Run { mesh: &mesh, exterior: Default::default(), out: Default::default(), ..*run };
        own.on = { here }.vertices_on(facets, corners, &tree);
        own
    }

    /// Finds those that are on facets, and adds their areas.
    pub(super) fn find_tiles(
        &mut self,
        run: &mut Run<'_>,
        groups: &[u32],
        planes: &Planes<'_>,
        areas: &mut [BigInt],
    ) {
        let on = planes_of(&self.on, groups);
        let mut found = Found::default();
        for face in &mut self.faces {
            let places = face.corners.map(|v| self.places[v as usize]);
            let on = face.corners.map(|v| &on[v as usize]);
            face.is_tile = planes.is_tile(on, places, &mut found);
        }
        run.out.subfaces += found.subfaces;
        found.areas.into_iter().for_each(|(g, area)| areas[g as usize] += area);
    }

    /// Finds those that are on patches and on no other facet, as inside of parts.
    pub(super) fn find_on_patches(&mut self, patches: &Patches, units: &Units, to: &mut Tiled) {
        let on = patches.at(&self.on, &self.places);
        for face in self.faces.iter_mut().filter(|face| !face.is_tile) {
            if face.tags.is_some_and(|[one, other]| one == other) {
                continue;
            }
            let [a, b, c, apex] = face.facet.v;
            let beside = Beside {
                on: face.corners.map(|v| &on[v as usize]),
                places: face.corners.map(|v| self.places[v as usize]),
                apex: units.whole(&apex.corner.at),
                corners: [a, b, c].map(|v| v.by_place),
                ids: ids_of(face.facet),
            };
            face.is_tile = patches.take(&beside, to);
        }
    }

    /// Every face of one tetrahedron is on a facet.
    pub(super) fn hull(&self, run: &mut Run<'_>) {
        let hull = self.faces.iter().filter(|face| face.tags.is_none());
        for face in hull.filter(|face| !face.is_tile) {
            run.add(ConformityDefect::HullFaceOffFacet, &ids_of(face.facet));
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
            let face = found.ok().map(|k| &self.faces[k]);
            if face.is_some_and(|face| face.is_tile) {
                continue;
            }
            let tags = face.and_then(|face| face.tags);
            if tags.is_none_or(|[one, other]| one != other) {
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
