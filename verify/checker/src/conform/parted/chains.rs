//! Edges of the domain are chains of edges of the mesh: each edge is put together by one member.

use super::super::incidence::OnEdge;
use super::super::{ConformityDefect, Run, edge};
use crate::parted::exchange::{Exchange, deal};
use std::collections::{HashMap, HashSet};

/// A vertex on an edge of the domain, or an edge of the mesh along it: the number of the edge and
/// one place along it, or two; of a vertex its number by coordinates.
type Link = [u64; 4];

impl Run<'_> {
    /// Every edge of a polygon and every segment is a chain of edges of the mesh, whoever has them.
    /// `chains` are the part's vertices on each of these, `by_place` the numbers of its vertices.
    ///
    /// Returns the edges of the mesh on the edges of the domain that this member has put together.
    pub(super) fn edges_in_parts<E: Exchange>(
        &mut self,
        team: &mut E,
        wanted: &[[u32; 2]],
        chains: &[Vec<OnEdge>],
        by_place: &[u32],
    ) -> Result<Vec<[u32; 2]>, E::Error> {
        let mut links: HashSet<Link> = HashSet::new();
        // The edges of the domain that a vertex is on, with its place along each: most are on none.
        let mut on: HashMap<u32, Vec<[u64; 2]>> = HashMap::new();
        for (e, chain) in (0u64..).zip(chains) {
            for &OnEdge { place, vertex } in chain {
                // Places are differences of coordinates, and so below 2^61.
                let place = place as u64;
                links.insert([e, place, place, u64::from(by_place[vertex as usize])]);
                on.entry(vertex).or_default().push([e, place]);
            }
        }
        for tet in self.mesh.tets {
            let on: Vec<&Vec<[u64; 2]>> = tet.iter().filter_map(|v| on.get(v)).collect();
            for (k, first) in on.iter().enumerate() {
                for [e, a] in first.iter().copied() {
                    let others = on[k + 1..].iter().flat_map(|other| other.iter());
                    for &[_, b] in others.filter(|own| own[0] == e) {
                        links.insert([e, a.min(b), a.max(b), 0]);
                    }
                }
            }
        }
        let members = team.members() as u64;
        let met = deal(team, links.into_iter(), |link| (link[0] % members) as usize)?;
        let mut met: Vec<Link> = met.into_iter().flatten().collect();
        met.sort_unstable();
        met.dedup();
        let mut outline = Vec::new();
        for of_edge in met.chunk_by(|a, b| a[0] == b[0]) {
            let vertices: Vec<&Link> = of_edge.iter().filter(|link| link[1] == link[2]).collect();
            let pairs = vertices.windows(2);
            outline.extend(pairs.clone().map(|pair| edge(pair[0][3] as u32, pair[1][3] as u32)));
            let is_edge = |pair: &[&Link]| {
                of_edge.binary_search(&[pair[0][0], pair[0][1], pair[1][1], 0]).is_ok()
            };
            if let Some(ends) = wanted.get(of_edge[0][0] as usize)
                && !pairs.clone().all(is_edge)
            {
                self.add(ConformityDefect::SegmentBroken, ends);
            }
        }
        outline.sort_unstable();
        outline.dedup();
        Ok(outline)
    }
}
