//! The faces of the mesh that tile the facets of each plane.

use super::facet::FlatFacet;
use super::outline::Outline;
use super::whole::Whole;
use super::{ConformityDefect, Run};
use crate::chunks::pieces;
use crate::faces::Faces;
use crate::mesh::{Side, face};
use num_bigint::BigInt;
use std::collections::HashSet;

/// The facets of one plane.
struct Plane<'f> {
    /// One of them.
    first: &'f FlatFacet,
    outline: Outline,
    area: BigInt,
}

impl<'f> Plane<'f> {
    /// `None` if no facet of the plane is looked at here.
    fn new(members: &[u32], facets: &'f [Option<FlatFacet>]) -> Option<Self> {
        let flats = || members.iter().filter_map(|&f| facets[f as usize].as_ref());
        let outline = Outline::new(flats().flat_map(FlatFacet::weighted));
        let area = flats().map(FlatFacet::area).sum();
        Some(Self { first: flats().next()?, outline, area })
    }
}

/// The facets of all planes, by the first one of each.
pub(super) struct Planes<'f> {
    planes: Vec<Option<Plane<'f>>>,
    /// The facets of each.
    members: Vec<Vec<u32>>,
}

/// The tiles of a part of the mesh: codes of faces, and areas by planes.
#[derive(Default)]
pub(super) struct Found {
    codes: Vec<u32>,
    pub(super) areas: Vec<(u32, BigInt)>,
    pub(super) subfaces: u64,
    pub(super) steps: u64,
}

impl<'f> Planes<'f> {
    pub(super) fn new(facets: &'f [Option<FlatFacet>], groups: &[u32]) -> Self {
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); facets.len()];
        (0u32..).zip(groups).for_each(|(f, &g)| members[g as usize].push(f));
        let parts = pieces(facets.len(), |range| {
            range.map(|g| Plane::new(&members[g], facets)).collect::<Vec<_>>()
        });
        Self { planes: parts.into_iter().flatten().collect(), members }
    }

    /// Is a face on facets, whose corners are in these planes? Its area is noted.
    pub(super) fn is_tile(&self, on: [&Vec<u32>; 3], places: [Whole; 3], to: &mut Found) -> bool {
        let [a, b, c] = on;
        let mut is_tile = false;
        for &g in a.iter().filter(|g| b.contains(g) && c.contains(g)) {
            let Some(plane) = &self.planes[g as usize] else { continue };
            let centroid = plane.first.centroid(places);
            if plane.outline.weight_at(centroid, &mut to.steps) > 0 {
                to.areas.push((g, plane.first.area_of(places)));
                is_tile = true;
            }
        }
        to.subfaces += u64::from(is_tile);
        is_tile
    }

    /// The first facet of plane `g`, if its facets have another area than this.
    pub(super) fn untiled(&self, g: usize, area: &BigInt) -> Option<u32> {
        let differs = self.planes[g].as_ref().is_some_and(|plane| plane.area != *area);
        self.members[g].first().copied().filter(|_| differs)
    }
}

/// Per vertex the planes in which it lies, of the facets there. A face may cross from one facet of
/// its plane to the next: by planes, then.
pub(super) fn planes_of(on: &[Vec<u32>], groups: &[u32]) -> Vec<Vec<u32>> {
    let planes = |facets: &Vec<u32>| {
        let mut planes: Vec<u32> = facets.iter().map(|&f| groups[f as usize]).collect();
        planes.sort_unstable();
        planes.dedup();
        planes
    };
    on.iter().map(planes).collect()
}

impl Run<'_> {
    /// The tiles among the faces of the mesh, of those inside from one side, or all: their codes
    /// from both sides, and the areas of each plane.
    pub(super) fn found_tiles(
        &mut self,
        planes: &Planes<'_>,
        points: &[Whole],
        faces: &Faces,
        on: &[Vec<u32>],
        only_inside: bool,
    ) -> (HashSet<u32>, Vec<BigInt>) {
        let parts = pieces(self.mesh.tets.len(), |range| {
            let mut found = Found::default();
            for (t, i) in range.flat_map(|t| (0..4).map(move |i| (t, i))) {
                let corners = face(&self.mesh.tets[t], i);
                let other = faces.other(t, i);
                // An interior face is looked at from one side.
                if other.map_or(only_inside, |other| other.t < t) {
                    continue;
                }
                let places = corners.map(|v| points[v as usize]);
                if planes.is_tile(corners.map(|v| &on[v as usize]), places, &mut found) {
                    found.codes.push((4 * t + i) as u32);
                    found.codes.extend(other.map(Side::code));
                }
            }
            found
        });
        let mut areas: Vec<BigInt> = vec![BigInt::ZERO; planes.members.len()];
        let mut codes = HashSet::new();
        for part in parts {
            self.out.subfaces += part.subfaces;
            self.out.steps += part.steps;
            codes.extend(part.codes);
            part.areas.into_iter().for_each(|(g, area)| areas[g as usize] += area);
        }
        (codes, areas)
    }

    /// The faces on the facets of each plane have their area. Returns their codes, from both sides.
    pub(super) fn tiles(
        &mut self,
        facets: &[Option<FlatFacet>],
        points: &[Whole],
        faces: &Faces,
        on: &[Vec<u32>],
        groups: &[u32],
    ) -> HashSet<u32> {
        let (planes, on) = (Planes::new(facets, groups), planes_of(on, groups));
        let (codes, areas) = self.found_tiles(&planes, points, faces, &on, false);
        for (g, area) in areas.iter().enumerate() {
            if let Some(f) = planes.untiled(g, area) {
                self.add(ConformityDefect::FacetNotTiled, &[f]);
            }
        }
        codes
    }
}
