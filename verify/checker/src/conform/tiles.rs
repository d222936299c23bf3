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

/// The tiles of a part of the mesh: codes of faces, and areas by planes.
#[derive(Default)]
struct Found {
    codes: Vec<u32>,
    areas: Vec<(u32, BigInt)>,
    subfaces: u64,
    steps: u64,
}

impl Run<'_> {
    /// The faces on the facets of each plane have their area. Returns their codes, from both sides.
    pub(super) fn tiles(
        &mut self,
        facets: &[Option<FlatFacet>],
        points: &[Whole],
        faces: &Faces,
        on: &[Vec<u32>],
        groups: &[u32],
    ) -> HashSet<u32> {
        // A face may cross from one facet of its plane to the next: by groups, then.
        let on: Vec<Vec<u32>> = on
            .iter()
            .map(|facets| {
                let mut planes: Vec<u32> = facets.iter().map(|&f| groups[f as usize]).collect();
                planes.sort_unstable();
                planes.dedup();
                planes
            })
            .collect();
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); facets.len()];
        (0u32..).zip(groups).for_each(|(f, &g)| members[g as usize].push(f));
        let parts = pieces(facets.len(), |range| {
            range.map(|g| Plane::new(&members[g], facets)).collect::<Vec<_>>()
        });
        let planes: Vec<Option<Plane<'_>>> = parts.into_iter().flatten().collect();
        let parts = pieces(self.mesh.tets.len(), |range| {
            let mut found = Found::default();
            for (t, i) in range.flat_map(|t| (0..4).map(move |i| (t, i))) {
                let corners = face(&self.mesh.tets[t], i);
                let other = faces.other(t, i);
                // An interior face is looked at from one side.
                if other.is_some_and(|other| other.t < t) {
                    continue;
                }
                let [a, b, c] = corners.map(|v| &on[v as usize]);
                let places = corners.map(|v| points[v as usize]);
                let mut is_tile = false;
                for &g in a.iter().filter(|g| b.contains(g) && c.contains(g)) {
                    let Some(plane) = &planes[g as usize] else { continue };
                    let centroid = plane.first.centroid(places);
                    if plane.outline.weight_at(centroid, &mut found.steps) > 0 {
                        found.areas.push((g, plane.first.area_of(places)));
                        is_tile = true;
                    }
                }
                if is_tile {
                    found.subfaces += 1;
                    found.codes.push((4 * t + i) as u32);
                    found.codes.extend(other.map(Side::code));
                }
            }
            found
        });
        let mut areas: Vec<BigInt> = vec![BigInt::ZERO; facets.len()];
        let mut codes = HashSet::new();
        for part in parts {
            self.out.subfaces += part.subfaces;
            self.out.steps += part.steps;
            codes.extend(part.codes);
            part.areas.into_iter().for_each(|(g, area)| areas[g as usize] += area);
        }
        for ((plane, area), list) in planes.iter().zip(areas).zip(&members) {
            if plane.as_ref().is_some_and(|plane| plane.area != area) {
                self.add(ConformityDefect::FacetNotTiled, &list[..1]);
            }
        }
        codes
    }
}
