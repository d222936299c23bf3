//! Which vertices of the mesh lie on a facet of the domain, and which along an edge of it.
//!
//! The vertices are found in a tree (`tree`), each facet and each edge by itself, and then tested
//! exactly: about n log n steps, and one for each that is found.

use super::facet::FlatFacet;
use super::place::along;
use super::tree::{Shape, Tree, bounds};
use super::whole::Whole;
use super::{ConformityDefect, Run, edge};
use crate::chunks::pieces_of;
use crate::predicates::{Tally, orient3d};
use std::collections::{HashMap, HashSet};

/// A vertex of the mesh on an edge of the domain, by its place along it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct OnEdge {
    pub(super) place: i128,
    pub(super) vertex: u32,
}

/// Facets, or edges, that are looked at together.
const PIECE: usize = 1 << 10;

impl Run<'_> {
    /// Per vertex of the mesh the facets in whose plane and box it lies, ascending.
    pub(super) fn vertices_on(
        &mut self,
        facets: &[Option<FlatFacet>],
        corners: &[Whole],
        tree: &Tree<'_>,
    ) -> Vec<Vec<u32>> {
        let (mesh, plc) = (self.mesh, self.plc);
        let parts = pieces_of(PIECE, facets.len(), |range| {
            let (mut pairs, mut steps) = (Vec::new(), 0);
            for f in range {
                let Some(flat) = &facets[f] else { continue };
                let all = plc.facets[f].polygons.iter().flatten();
                let own = bounds(all.map(|&v| corners[v as usize]));
                let shape = Shape::plane(own, flat.frame.map(|v| &corners[v as usize]));
                let [a, b, c] = flat.frame.map(|v| &plc.vertices[v as usize]);
                steps += tree.search(&shape, |v| {
                    let at = &mesh.points[v as usize];
                    if orient3d([a, b, c, at], &mut Tally::default()) == 0 {
                        pairs.push((v, f as u32));
                    }
                });
            }
            (pairs, steps)
        });
        let mut on = vec![Vec::new(); mesh.points.len()];
        for (pairs, steps) in parts {
            self.out.steps += steps + pairs.len() as u64;
            pairs.into_iter().for_each(|(v, f)| on[v as usize].push(f));
        }
        on
    }

    /// The edges inside the facets of one plane: of exactly two polygons there, and nothing else.
    fn continued(&self, groups: &[u32]) -> HashSet<[u32; 2]> {
        let mut uses: HashMap<[u32; 2], Vec<Option<u32>>> = HashMap::new();
        for (f, facet) in self.plc.facets.iter().enumerate() {
            for polygon in &facet.polygons {
                let group = (polygon.len() > 2).then_some(groups[f]);
                for (k, &a) in polygon.iter().enumerate() {
                    let key = edge(a, polygon[(k + 1) % polygon.len()]);
                    uses.entry(key).or_default().push(group);
                }
            }
        }
        for &[a, b] in &self.plc.segments {
            uses.entry(edge(a, b)).or_default().push(None);
        }
        let inner = |uses: &[Option<u32>]| matches!(uses, [Some(a), Some(b)] if a == b);
        uses.into_iter().filter(|(_, u)| inner(u)).map(|(edge, _)| edge).collect()
    }

    /// The edges of polygons that have to be in the mesh, and the segments, each once.
    pub(super) fn wanted(&self, groups: &[u32]) -> Vec<[u32; 2]> {
        let continued = self.continued(groups);
        let polygons = self.plc.facets.iter().flat_map(|facet| &facet.polygons);
        let sides = polygons.flat_map(|polygon| {
            polygon.iter().enumerate().map(|(k, &a)| edge(a, polygon[(k + 1) % polygon.len()]))
        });
        let sides = sides.filter(|side| !continued.contains(side));
        let segments = self.plc.segments.iter().map(|&[a, b]| edge(a, b));
        let mut wanted: Vec<[u32; 2]> = sides.chain(segments).collect();
        wanted.sort_unstable();
        wanted.dedup();
        wanted
    }

    /// The vertices of the mesh on each of some edges of the domain, by their places along it.
    pub(super) fn chains(
        &mut self,
        wanted: &[[u32; 2]],
        corners: &[Whole],
        points: &[Whole],
        tree: &Tree<'_>,
    ) -> Vec<Vec<OnEdge>> {
        let parts = pieces_of(PIECE, wanted.len(), |range| {
            let (mut chains, mut steps) = (Vec::new(), 0);
            for ends in &wanted[range] {
                let [a, b] = ends.map(|v| corners[v as usize]);
                let mut chain: Vec<OnEdge> = Vec::new();
                steps += tree.search(&Shape::segment(&a, &b), |v| {
                    let place = along(a, b, points[v as usize]);
                    chain.extend(place.map(|place| OnEdge { place, vertex: v }));
                });
                chain.sort_unstable();
                chains.push(chain);
            }
            (chains, steps)
        });
        let mut all = Vec::with_capacity(wanted.len());
        for (chains, steps) in parts {
            self.out.steps += steps;
            all.extend(chains);
        }
        all
    }

    /// Every edge of a polygon and every segment is a chain of edges of the mesh. Returns these.
    pub(super) fn edges(
        &mut self,
        corners: &[Whole],
        points: &[Whole],
        tree: &Tree<'_>,
        groups: &[u32],
    ) -> HashSet<[u32; 2]> {
        let wanted = self.wanted(groups);
        let mut links: HashMap<[u32; 2], Vec<[u32; 2]>> = HashMap::new();
        for (ends, chain) in wanted.iter().zip(self.chains(&wanted, corners, points, tree)) {
            self.out.steps += chain.len() as u64;
            for pair in chain.windows(2) {
                links.entry(edge(pair[0].vertex, pair[1].vertex)).or_default().push(*ends);
            }
        }
        let chains = links.keys().copied().collect();
        for tet in self.mesh.tets {
            for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
                links.remove(&edge(tet[i], tet[j]));
            }
        }
        let mut broken: Vec<[u32; 2]> = links.into_values().flatten().collect();
        broken.sort_unstable();
        broken.dedup();
        broken.iter().for_each(|ends| self.add(ConformityDefect::SegmentBroken, ends));
        chains
    }
}
