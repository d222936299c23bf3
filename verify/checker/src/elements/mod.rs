//! A mesh as a *finite element mesh*: tetrahedra meet in whole faces, edges and vertices, or not at
//! all. The body may have any shape: holes, cavities, several pieces, pieces that touch, cracks
//! (two vertices at one place).
//!
//! Three kinds of meetings are defects: two tetrahedra *overlap* (their interiors meet), a vertex
//! *hangs* (it lies inside an edge or face of a tetrahedron that does not have it), two edges
//! *cross* (they meet inside both). Where none is, what two tetrahedra have in common is a face, an
//! edge or a vertex of both, up to vertices at one place: the intersection of two faces in one
//! plane is a convex polygon, and a corner of it that is no corner of both hangs or is a crossing.
//!
//! **What has to be compared.** Join faces in pairs of the same three vertices with tetrahedra on
//! opposite sides; call the other faces *free*.
//!
//! *If two tetrahedra overlap, there are a free face f of a tetrahedron t and another one u such
//! that t and u overlap, and u has points at an inner point of f, on that side of it on which t
//! is.* Let m(x) be the number of tetrahedra with x inside, and let m > 1 at some x. Go from x
//! along a line that meets no edge, until m ≤ 1; let p be that place. The tetrahedra that the line
//! leaves at p are more than those it enters there. A pair of joined faces is left and entered, so
//! that some tetrahedron t is left through a free face f. Just before p two tetrahedra at least are
//! there, so another one, u, is there, too.
//!
//! Hence free faces are compared with all tetrahedra: of a mesh of n tetrahedra with a smooth
//! boundary, about n^(2/3) faces with those near them.
//!
//! *If nothing overlaps, a vertex that hangs is a vertex of a free face, and hangs in a free face
//! or its edge.* If all faces at the vertex v are joined, its tetrahedra cover all around v (walk
//! around it: the number of them changes at free faces alone), and one that v hangs in overlaps one
//! of them. If the face or all faces at the edge in which v hangs are joined, the tetrahedra at it
//! cover all around v, and one that has v overlaps one of them. In the same way, edges that cross
//! are edges of free faces.
//!
//! [`pairs`] finds who may meet, [`apart`] and [`touch`] decide, exactly.

mod apart;
mod pairs;
mod plane;
mod touch;
mod verdict;

use crate::chunks::{Partial, pieces};
use crate::defect::Kind;
use crate::faces::Faces;
use crate::geometry::{Oriented, fold};
use crate::mesh::Side;
use crate::perturb::order;
use crate::predicates::Tally;
use pairs::{Found, Item, Search};
use rayon::prelude::*;
pub(crate) use verdict::{Verdict, verdict};

/// Meetings of one item in one place that are told, at most: overlaps of many with many would be a
/// list of squares.
const MOST: usize = 4;

/// Finds overlaps, hanging vertices and crossing edges of the tetrahedra that are neither unsound
/// nor flat. Cost: O(n log n) but for what lies across each other without meeting (see [`pairs`]).
pub(crate) fn contacts(mesh: &Oriented, faces: &Faces, limit: usize) -> Partial {
    let mut out = Partial::new(limit);
    let free = free_faces(mesh, faces);
    overlaps(mesh, &free, &mut out);
    let places = places(mesh, &free);
    hanging(mesh, &free, &places, &mut out);
    crossings(mesh, &free, &places, &mut out);
    out
}

/// Free faces, turned outward, each with its vertices first and the first of them once more.
fn free_faces(mesh: &Oriented, faces: &Faces) -> Vec<Item> {
    let parts = pieces(mesh.mesh.tets.len(), |range| {
        let mut free = Vec::new();
        for t in range.filter(|&t| mesh.sign(t) != 0) {
            for i in 0..4 {
                let other = faces.other(t, i);
                if other.is_none_or(|other| fold(mesh, Side { t, i }, other) != Some(false)) {
                    let [a, b, c] = mesh.outward(t, i);
                    let apex = Some(mesh.mesh.tets[t][i]);
                    free.push(Item { corners: [a, b, c, a], owner: t as u32, apex });
                }
            }
        }
        free
    });
    parts.concat()
}

fn search<M>(mesh: &Oriented, first: &[Item], second: &[Item], meet: M) -> Found
where
    M: Fn(&Item, &Item, &mut Tally) -> bool + Sync,
{
    let (points, tets) = (mesh.mesh.points, mesh.mesh.tets);
    Search { points, tets, first, second, meet, most: MOST }.run()
}

fn overlaps(mesh: &Oriented, free: &[Item], out: &mut Partial) {
    let solid = (0..mesh.mesh.tets.len()).filter(|&t| mesh.sign(t) != 0);
    let solid: Vec<Item> = solid
        .map(|t| Item { corners: mesh.positive_tet(t), owner: t as u32, apex: None })
        .collect();
    let corners = |t: u32| mesh.positive_tet(t as usize).map(|v| mesh.at(v));
    let found = search(mesh, free, &solid, |face, tet, tally| {
        face.owner != tet.owner && apart::overlap(corners(face.owner), corners(tet.owner), tally)
    });
    out.tally.merge(found.tally);
    let both = |&(f, u): &(u32, u32)| (free[f as usize].owner, solid[u as usize].owner);
    let ascending = |(t, u): (u32, u32)| if t < u { [t, u] } else { [u, t] };
    let mut all: Vec<[u32; 2]> = found.pairs.iter().map(both).map(ascending).collect();
    all.sort_unstable();
    all.dedup();
    for pair in all {
        out.findings.add(Kind::Overlap, &pair, &mesh.mesh.tets[pair[0] as usize]);
    }
}

fn hanging(mesh: &Oriented, free: &[Item], places: &[u32], out: &mut Partial) {
    let vertices = distinct(free, places, |[a, b, c]| [[a; 4], [b; 4], [c; 4]]);
    let at = |v: u32| mesh.at(v);
    let place = |vertex: &Item, face: &Item, tally: &mut Tally| {
        let [a, b, c, _] = face.corners;
        touch::inside(at(vertex.corners[0]), [a, b, c].map(at), tally)
    };
    let found =
        search(mesh, &vertices, free, |vertex, face, tally| place(vertex, face, tally).is_some());
    out.tally.merge(found.tally);
    // The faces at an edge have it in common: the first one tells of it.
    for of_one in found.pairs.chunk_by(|a, b| a.0 == b.0) {
        let (v, face) = (&vertices[of_one[0].0 as usize], &free[of_one[0].1 as usize]);
        let [a, b, c, _] = face.corners;
        let edge = place(v, face, &mut Tally::default()).flatten();
        let others = match edge {
            None => vec![a, b, c],
            Some(k) => vec![[a, b, c][k], [b, c, a][k]],
        };
        out.findings.add(Kind::HangingVertex, &[face.owner], &[&v.corners[..1], &others].concat());
    }
}

fn crossings(mesh: &Oriented, free: &[Item], places: &[u32], out: &mut Partial) {
    let edges = distinct(free, places, |[a, b, c]| {
        [(a, b), (b, c), (c, a)].map(|(a, b)| [a.min(b), a.max(b), a.min(b), a.max(b)])
    });
    let ends = |edge: &Item| [edge.corners[0], edge.corners[1]].map(|v| mesh.at(v));
    let found = search(mesh, &edges, &edges, |one, other, tally| {
        one.corners < other.corners && touch::cross(ends(one), ends(other), tally)
    });
    out.tally.merge(found.tally);
    for (e, f) in found.pairs {
        let (e, f) = (&edges[e as usize], &edges[f as usize]);
        let ([a, b, ..], [c, d, ..]) = (e.corners, f.corners);
        out.findings.add(Kind::CrossingEdges, &[e.owner, f.owner], &[a, b, c, d]);
    }
}

/// For each vertex of a free face the least one at its place; other points for themselves.
fn places(mesh: &Oriented, free: &[Item]) -> Vec<u32> {
    let mut vertices: Vec<u32> = free.iter().flat_map(|f| f.corners).collect();
    let places = |v: u32, w: u32| order(mesh.at(v), mesh.at(w));
    vertices.par_sort_unstable_by(|&v, &w| places(v, w).then(v.cmp(&w)));
    let mut first: Vec<u32> = (0..mesh.mesh.points.len() as u32).collect();
    for same in vertices.chunk_by(|&v, &w| places(v, w).is_eq()) {
        same.iter().for_each(|&v| first[v as usize] = same[0]);
    }
    first
}

/// The things that `parts` gives of each face, each once.
///
/// Of many vertices at one place the first one stands for all: else each of them would be compared
/// with all that is there.
fn distinct(free: &[Item], places: &[u32], parts: impl Fn([u32; 3]) -> [[u32; 4]; 3]) -> Vec<Item> {
    let of_face = |f: &Item| {
        let [a, b, c, _] = f.corners.map(|v| places[v as usize]);
        let owner = f.owner;
        parts([a, b, c]).map(|corners| Item { corners, owner, apex: None })
    };
    let mut all: Vec<Item> = free.iter().flat_map(of_face).collect();
    all.par_sort_unstable_by_key(|item| (item.corners, item.owner));
    all.dedup_by_key(|item| item.corners);
    all
}

#[cfg(test)]
mod tests;
