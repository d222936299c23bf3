//! Parts put together to one mesh.

use super::Part;
use crate::geometry::Geometry;
use crate::topology::{FaceId, MAX_TETS, Topology, VertexId};
use crate::{Mesh, PredicateStats, Vertex};
use ltbw_exact::{Mode, Point};

/// What [`assemble`] needs beside the parts.
#[derive(Debug)]
pub struct Assembly<'a> {
    /// Kernel coordinates by vertex less 1.
    pub points: Vec<Point>,
    /// Public number by vertex less 1.
    pub numbers: Vec<Vertex>,
    /// Vertices whose points were vertices already, each with that vertex.
    pub duplicates: &'a [(VertexId, VertexId)],
    /// How the points are computed with.
    pub mode: Mode,
    /// Predicate calls made elsewhere.
    pub predicates: PredicateStats,
}

/// Why parts of a mesh could not be put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Misfit {
    /// There is no part.
    NoParts,
    /// Together they have too many tetrahedra.
    TooManyTets,
    /// Nobody has the tetrahedron beyond a proxy.
    Dangling {
        /// Index of the part with the proxy.
        part: usize,
        /// The words that the proxy carries.
        words: [u32; 4],
    },
}

/// Puts all parts of a mesh together. `far` finds the part and face beyond a proxy by its words.
///
/// Vertices that no tetrahedron has are left out.
///
/// # Errors
/// [`Misfit`] if there are too many tetrahedra, or if `far` finds nothing.
///
/// Cost: O(tetrahedra), less those of the first part.
pub fn assemble<H: Copy + Eq + Send + Sync, L: Copy + Send + Sync>(
    parts: Vec<Part<H, L>>,
    far: impl Fn([u32; 4]) -> Option<(usize, FaceId)>,
    assembly: Assembly<'_>,
) -> Result<Mesh, Misfit> {
    let mut parts = parts.into_iter().map(Part::settle);
    let (mut topology, mut geometry) = parts.next().ok_or(Misfit::NoParts)?;
    // The limit of a part is not that of the whole mesh.
    topology.set_limit(MAX_TETS);
    let mut offsets = vec![0];
    for (their_topology, their_geometry) in parts {
        let (slots, theirs) = (topology.slots(), their_topology.slots());
        geometry.stats += their_geometry.stats;
        offsets.push(topology.append(their_topology).ok_or(Misfit::TooManyTets)?);
        geometry.append_spheres(slots, their_geometry, theirs);
    }
    let (used, proxies) = topology.survey(assembly.points.len());
    for &t in &proxies {
        let tet = topology.tet(t);
        let (face, mut words) = (tet.neighbours()[0], tet.words());
        // Appending shifts the links of a proxy, two of which are words.
        let at = offsets.partition_point(|&offset| offset <= t) - 1;
        for word in &mut words[2..] {
            *word -= 4 * offsets[at];
        }
        let (part, beyond) = far(words).ok_or(Misfit::Dangling { part: at, words })?;
        let offset = offsets.get(part).ok_or(Misfit::Dangling { part: at, words })?;
        topology.point_to(face, beyond + 4 * offset);
    }
    for t in proxies {
        topology.erase(t);
    }
    geometry.reserve_spheres(topology.slots());
    geometry.stats += assembly.predicates;
    Ok(Mesh::assembled(topology, geometry, &used, assembly))
}

impl<H: Copy + Eq, L: Copy> Part<H, L> {
    /// The mesh alone, nothing closed or watched.
    fn settle(mut self) -> (Topology, Geometry) {
        for (t, sphere) in self.specials.spheres() {
            self.geometry.set_sphere(t, sphere);
        }
        (self.topology, self.geometry)
    }
}
