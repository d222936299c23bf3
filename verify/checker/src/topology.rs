//! Level *topology*: the faces at which tetrahedra meet, without a coordinate.
//!
//! Every face has one or two tetrahedra (found in `faces.rs`); vertex orders put two neighbours
//! on opposite sides of their face; claimed adjacency and claimed hull are the real ones;
//! the mesh is connected; every edge of the hull has exactly two hull facets. The full depth
//! adds what makes the mesh a ball: around every inner vertex the tetrahedra form a ball, around
//! every vertex of the hull a half ball; V - E + F - T = 1; the hull is one sphere.
//!
//! *Vertex links.* The link of a vertex v is the surface made of the faces opposite v in its
//! tetrahedra. A surface connected through edges has V - E + F ≤ 2, with equality only for a
//! sphere, if it is closed, and ≤ 1, with equality only for a disk, if not; identifying
//! vertices of it (a pinch) lowers the number further. So "connected through edges, and 2 or 1"
//! is the whole test. Cost of all: linear but for sorting hull edges.

use crate::chunks::{Partial, Table, pieces, pieces_of};
use crate::defect::{Findings, Kind};
use crate::faces::{Faces, HULL};
use crate::mesh::{Mesh, NO_NEIGHBOUR, Side, VertexOrder, face, split};
use crate::structure::Sound;
use rayon::prelude::*;

/// Two hull facets that share an edge: positions in `Faces::hull`, and the index of the edge's
/// opposite vertex in the outward facet.
pub(crate) type HullPair = [(usize, usize); 2];

/// The surface of the mesh.
#[derive(Default)]
pub(crate) struct Hull {
    /// Pairs of facets at proper edges.
    pub(crate) pairs: Vec<HullPair>,
    pub(crate) vertices: usize,
    pub(crate) components: usize,
}

/// Compares neighbours with each other and with the claimed adjacency.
pub(crate) fn neighbours(
    mesh: &Mesh,
    faces: &Faces,
    sound: &[bool],
    order: VertexOrder,
    limit: usize,
) -> Partial {
    let mut out = Partial::new(limit);
    let claimed = mesh.neighbours.filter(|n| {
        let fits = n.len() == mesh.tets.len();
        if !fits {
            out.findings.add(Kind::AdjacencyLength, &[], &[]);
        }
        fits
    });
    let parts = pieces(mesh.tets.len(), |range| {
        let mut part = Partial::new(limit);
        for t in range.filter(|&t| sound[t]) {
            for i in 0..4 {
                let outer = face(&mesh.tets[t], i);
                let other = faces.other(t, i);
                if let Some(Side { t: u, i: j }) = other
                    && order == VertexOrder::Oriented
                    && t < u
                    && is_rotation(outer, face(&mesh.tets[u], j))
                {
                    part.findings.add(Kind::SameSide, &[t as u32, u as u32], &outer);
                }
                let Some(claimed) = claimed.map(|n| n[t][i]) else { continue };
                let real = match (other, faces.across[4 * t + i]) {
                    (Some(other), _) => other.t as u32,
                    (None, HULL) => NO_NEIGHBOUR,
                    (None, _) => {
                        part.untested += 1; // a face of three tetrahedra has no one neighbour
                        continue;
                    }
                };
                if claimed != real {
                    let kind = Kind::WrongNeighbour;
                    part.findings.add(kind, &[t as u32, claimed, real], &outer);
                }
            }
        }
        part
    });
    parts.into_iter().for_each(|part| out.merge(part));
    out
}

/// Whether two triples of the same vertices turn the same way round.
fn is_rotation(a: [u32; 3], b: [u32; 3]) -> bool {
    [[b[0], b[1], b[2]], [b[1], b[2], b[0]], [b[2], b[0], b[1]]].contains(&a)
}

/// Compares the claimed hull facets, if any, with the real ones.
pub(crate) fn claimed_hull(mesh: &Mesh, facets: &[u32], out: &mut Findings) {
    let Some(claimed) = mesh.hull else { return };
    let sorted = |mut facet: [u32; 3]| {
        facet.sort_unstable();
        facet
    };
    let mut claimed: Vec<[u32; 3]> = claimed.iter().map(|&f| sorted(f)).collect();
    claimed.par_sort_unstable();
    let mut real: Vec<([u32; 3], u32)> =
        facets.iter().map(|&c| (sorted(facet(mesh, c)), c >> 2)).collect();
    real.par_sort_unstable();
    let (mut i, mut j) = (0, 0);
    // Each turn advances i or j.
    while i < claimed.len() || j < real.len() {
        match (claimed.get(i), real.get(j)) {
            (Some(c), Some((r, _))) if c == r => (i, j) = (i + 1, j + 1),
            (Some(c), r) if r.is_none_or(|(r, _)| c < r) => {
                out.add(Kind::HullFacetExtra, &[], c);
                i += 1;
            }
            (_, Some((r, owner))) => {
                out.add(Kind::HullFacetMissing, &[*owner], r);
                j += 1;
            }
            (_, None) => i += 1, // not reached: a claim without a real facet is extra, above
        }
    }
}

/// The vertices of a face by its code, outward if its tetrahedron is positive.
fn facet(mesh: &Mesh, code: u32) -> [u32; 3] {
    let Side { t, i } = split(code);
    face(&mesh.tets[t], i)
}

/// A forest of sets (union by smaller index, path halving).
struct Sets(Vec<u32>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn root(&mut self, mut i: u32) -> u32 {
        // Parents are smaller than their children, so this ends.
        while self.0[i as usize] != i {
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    fn is_root(&self, i: usize) -> bool {
        self.0[i] as usize == i
    }
}

/// Finds the parts of the mesh that shared faces do not connect. Returns their number.
pub(crate) fn components(mesh: &Mesh, faces: &Faces, sound: &[bool], out: &mut Findings) -> usize {
    let mut sets = Sets::new(mesh.tets.len());
    for t in 0..mesh.tets.len() {
        for other in (0..4).filter_map(|i| faces.other(t, i)).filter(|other| t < other.t) {
            sets.join(t as u32, other.t as u32);
        }
    }
    let mut count = 0;
    for t in (0..mesh.tets.len()).filter(|&t| sound[t] && sets.is_root(t)) {
        count += 1;
        if count > 1 {
            out.add(Kind::Disconnected, &[t as u32], &mesh.tets[t]);
        }
    }
    count
}

/// Joins hull facets at their edges and finds edges without exactly two facets, and separate
/// surfaces.
pub(crate) fn hull(mesh: &Mesh, facets: &[u32], out: &mut Findings) -> Hull {
    // One entry per side of a facet: the edge, then facet and side in one number.
    let mut sides: Vec<(u64, u64)> = facets
        .par_iter()
        .enumerate()
        .flat_map_iter(|(h, &code)| {
            let f = facet(mesh, code);
            (0..3).map(move |k| {
                let (a, b) = (f[(k + 1) % 3], f[(k + 2) % 3]);
                (u64::from(a.min(b)) << 32 | u64::from(a.max(b)), (3 * h + k) as u64)
            })
        })
        .collect();
    sides.par_sort_unstable();
    let place = |side: u64| ((side / 3) as usize, (side % 3) as usize);
    let mut sets = Sets::new(facets.len());
    let mut pairs = Vec::with_capacity(sides.len() / 2);
    for edge in sides.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, a), (_, b)] = *edge {
            let (a, b) = (place(a), place(b));
            sets.join(a.0 as u32, b.0 as u32);
            pairs.push([a, b]);
        } else {
            let owners: Vec<u32> = edge.iter().map(|s| facets[place(s.1).0] >> 2).collect();
            out.add(Kind::HullEdge, &owners, &[(edge[0].0 >> 32) as u32, edge[0].0 as u32]);
        }
    }
    let mut components = 0;
    for h in (0..facets.len()).filter(|&h| sets.is_root(h)) {
        components += 1;
        if components > 1 {
            let code = facets[h];
            out.add(Kind::HullDisconnected, &[code >> 2], &facet(mesh, code));
        }
    }
    let mut on_hull = vec![false; mesh.points.len()];
    for &code in facets {
        facet(mesh, code).iter().for_each(|&v| on_hull[v as usize] = true);
    }
    let vertices = on_hull.iter().filter(|&&on| on).count();
    Hull { pairs, vertices, components }
}

/// The Euler characteristic of a ball, from the counts of [`links`].
pub(crate) fn euler(faces: &Faces, sound: &Sound, edges: u64) -> Findings {
    let mut out = Findings::new(1);
    let tets = sound.tet.iter().filter(|&&s| s).count();
    let ball = sound.vertices.len() as i64 - edges as i64 + faces.count as i64 - tets as i64;
    if tets > 0 && ball != 1 {
        out.add(Kind::Euler, &[], &[]);
    }
    out
}

/// The Euler characteristic of a hull in one piece.
pub(crate) fn hull_euler(mesh: &Mesh, facets: &[u32], hull: &Hull) -> Findings {
    let mut out = Findings::new(1);
    let sphere = hull.vertices as i64 - hull.pairs.len() as i64 + facets.len() as i64;
    if hull.components == 1 && sphere != 2 && !mesh.tets.is_empty() {
        out.add(Kind::HullEuler, &[], &[]);
    }
    out
}

/// Checks the link of every vertex; returns the number of edges of the mesh too.
pub(crate) fn links(mesh: &Mesh, faces: &Faces, sound: &[bool], limit: usize) -> (Partial, u64) {
    let star = Table::new(mesh.points.len(), |emit| {
        for (t, tet) in mesh.tets.iter().enumerate().filter(|&(t, _)| sound[t]) {
            (0..4).for_each(|i| emit(tet[i], (4 * t + i) as u32));
        }
    });
    // Few pieces: each one allocates a mark per point.
    let length = mesh.points.len().div_ceil(4 * rayon::current_num_threads()).max(1 << 12);
    let parts = pieces_of(length, mesh.points.len(), |range| {
        let mut part = Partial::new(limit);
        let marks = vec![u32::MAX; mesh.points.len()];
        let mut scratch = Scratch { marks, ..Scratch::default() };
        let mut ends = 0u64;
        for v in range.filter(|&v| !star.row(v).is_empty()) {
            let link = Link::of(mesh, faces, star.row(v), v as u32, &mut scratch);
            ends += link.vertices as u64;
            if !link.is_ball() {
                let owners: Vec<u32> = star.row(v).iter().map(|c| c >> 2).collect();
                part.findings.add(Kind::VertexLink, &owners, &[v as u32]);
            }
        }
        (part, ends)
    });
    let mut out = Partial::new(limit);
    let mut ends = 0;
    for (part, e) in parts {
        out.merge(part);
        ends += e;
    }
    (out, ends / 2)
}

#[derive(Default)]
struct Scratch {
    /// By vertex: the last one whose link it was found in.
    marks: Vec<u32>,
    reached: Vec<bool>,
    stack: Vec<usize>,
}

/// The counts that decide whether the link of a vertex is a sphere or a disk.
struct Link {
    triangles: usize,
    vertices: usize,
    /// Sides of link triangles that have no other triangle.
    border: usize,
    connected: bool,
}

impl Link {
    /// The link of `v`, whose corners are `star` (codes `4 * tet + position of v`, ascending).
    fn of(mesh: &Mesh, faces: &Faces, star: &[u32], v: u32, scratch: &mut Scratch) -> Self {
        let (mut vertices, mut border, mut reached) = (0, 0, 1);
        scratch.reached.clear();
        scratch.reached.resize(star.len(), false);
        scratch.reached[0] = true;
        scratch.stack.push(0);
        // Each corner is pushed once.
        while let Some(corner) = scratch.stack.pop() {
            let Side { t, i: k } = split(star[corner]);
            for i in (0..4).filter(|&i| i != k) {
                let Some(other) = faces.other(t, i) else { continue };
                let Ok(next) = star.binary_search_by_key(&(other.t as u32), |c| c >> 2) else {
                    continue;
                };
                if !scratch.reached[next] {
                    scratch.reached[next] = true;
                    reached += 1;
                    scratch.stack.push(next);
                }
            }
        }
        for &corner in star {
            let Side { t, i: k } = split(corner);
            for i in (0..4).filter(|&i| i != k) {
                let mark = &mut scratch.marks[mesh.tets[t][i] as usize];
                vertices += usize::from(*mark != v);
                *mark = v;
                border += usize::from(faces.other(t, i).is_none());
            }
        }
        Self { triangles: star.len(), vertices, border, connected: reached == star.len() }
    }

    fn is_ball(&self) -> bool {
        let edges = (3 * self.triangles + self.border) / 2;
        let expected = if self.border == 0 { 2 } else { 1 };
        self.connected && self.vertices + self.triangles == edges + expected
    }
}
