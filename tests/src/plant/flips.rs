//! Bistellar flips: other tetrahedra in the same place, all positive, that are not Delaunay, or
//! not the canonical choice of several.
//!
//! ```text
//!      d           2-3: two tetrahedra over the face abc with apexes d and e become three around
//!     /|\               the edge de; 3-2 is the way back
//!    / | \         4-4: four around the edge ab, in the ring pqrs, become four around pr
//!   a--|--c        2-2: two with a flat quadrilateral on the hull, whose diagonal turns
//!    \ b /
//!     \|/
//!      e
//! ```
//!
//! New tetrahedra with the same boundary as the old ones that are all positive fill the same
//! place: the mesh stays a triangulation. As the Delaunay one is unique up to ties, the flipped
//! one is not Delaunay, or it differs in a tie, which the exact in-sphere test tells.

use super::{Expected, Subject, TIES, TOPOLOGY, opposite};
use crate::oracle;
use ltbw::Sign;
use ltbw_verify::{Kind, Level, NO_NEIGHBOUR};

const WRONG: Expected = Expected::new(&[Level::Delaunay], &[Kind::NotDelaunay]);
const TIE: Expected = Expected::new(&[Level::Canonical], TIES);

/// Replaces the tetrahedra `old` by `new` if all of these are positive.
fn replace(mesh: &mut Subject, old: &[usize], new: &[[u32; 4]]) -> Option<Expected> {
    if new.iter().any(|&t| mesh.orient(t) != Sign::Positive) {
        return None;
    }
    let mut kept = (0..mesh.tets.len()).filter(|t| !old.contains(t));
    let mut tets: Vec<[u32; 4]> = kept.by_ref().map(|t| mesh.tets[t]).collect();
    tets.extend(new);
    mesh.tets = tets;
    mesh.claim();
    Some(if locally_delaunay(mesh) { TIE } else { WRONG })
}

/// Is no apex strictly inside the sphere of its neighbour? By the oracle, all over the mesh.
fn locally_delaunay(mesh: &Subject) -> bool {
    let at = |v: u32| mesh.at(v);
    mesh.tets.iter().zip(&mesh.neighbours).all(|(tet, neighbours)| {
        let [a, b, c, d] = tet.map(at);
        neighbours.iter().filter(|&&n| n != NO_NEIGHBOUR).all(|&n| {
            let others = mesh.tets[n as usize].into_iter().filter(|v| !tet.contains(v));
            others.into_iter().all(|v| oracle::insphere(a, b, c, d, at(v)) != Sign::Positive)
        })
    })
}

/// The apex of the tetrahedron `t` beyond its face opposite `slot`, and that tetrahedron.
fn across(mesh: &Subject, t: usize, slot: usize) -> Option<(usize, u32)> {
    let n = mesh.neighbours[t][slot];
    let beyond = *mesh.tets.get(n as usize)?;
    let apex = beyond.into_iter().find(|v| !mesh.tets[t].contains(v))?;
    Some((n as usize, apex))
}

/// A tetrahedron is turned inside out. A mesh of one is mirrored then, which is no defect.
pub(super) fn flipped(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    if mesh.tets.len() == 1 {
        return None;
    }
    let (tet, slot) = mesh.place(choice);
    mesh.tets[tet].swap(slot, (slot + 1) % 4);
    mesh.neighbours[tet].swap(slot, (slot + 1) % 4);
    Some(Expected::new(TOPOLOGY, &[Kind::InvertedTet]))
}

pub(super) fn flip23(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let (t, slot) = mesh.place(choice);
    let (u, e) = across(mesh, t, slot)?;
    let d = mesh.tets[t][slot];
    // Outward of t: d is below a, b, c and e above.
    let [a, b, c] = opposite(&mesh.tets[t], slot);
    replace(mesh, &[t, u], &[[a, b, d, e], [b, c, d, e], [c, a, d, e]])
}

/// The other orientation.
fn turned([a, b, c, d]: [u32; 4]) -> [u32; 4] {
    [b, a, c, d]
}

/// The edges of a tetrahedron.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// The tetrahedron and the edge of it that a number names.
fn edge_of(mesh: &Subject, choice: usize) -> (usize, [usize; 2]) {
    (choice / 6 % mesh.tets.len(), EDGES[choice % 6])
}

/// The tetrahedra around an inner edge, in a row, with the vertices of the ring between
/// them; `None` if the edge is on the hull or there are not `count` of them.
struct Ring {
    edge: [u32; 2],
    tets: Vec<usize>,
    vertices: Vec<u32>,
}

impl Ring {
    fn of(mesh: &Subject, choice: usize, count: usize) -> Option<Self> {
        let (t, edge) = edge_of(mesh, choice);
        let edge = edge.map(|i| mesh.tets[t][i]);
        let others = |t: usize| -> Vec<u32> {
            mesh.tets[t].into_iter().filter(|v| !edge.contains(v)).collect()
        };
        let (mut tets, mut vertices) = (vec![t], others(t));
        // Each step leaves the last vertex but one behind.
        while tets.len() < count {
            let (here, left) = (*tets.last()?, vertices[vertices.len() - 2]);
            let slot = mesh.tets[here].iter().position(|&v| v == left)?;
            let (next, apex) = across(mesh, here, slot)?;
            tets.push(next);
            vertices.push(apex);
        }
        // Closed after exactly `count` steps: the last apex is the first vertex again.
        (vertices.pop()? == vertices[0] && vertices.len() == count).then_some(Self {
            edge,
            tets,
            vertices,
        })
    }
}

pub(super) fn flip32(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let Ring { edge: [d, e], tets, vertices } = Ring::of(mesh, choice, 3)?;
    let [a, b, c] = vertices.try_into().ok()?;
    // On different sides of the face a b c, if the edge goes through it.
    let new = [[a, b, c, d], [b, a, c, e]];
    let new = if mesh.orient(new[0]) == Sign::Negative { new.map(turned) } else { new };
    replace(mesh, &tets, &new)
}

pub(super) fn flip44(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let Ring { edge: [a, b], tets, vertices } = Ring::of(mesh, choice, 4)?;
    let [p, q, r, s] = vertices.try_into().ok()?;
    // Around pr, the ring is a q b s, the way that the sign of the first one tells; all four must
    // then go the same way.
    let around = [[p, r, a, q], [p, r, q, b], [p, r, b, s], [p, r, s, a]];
    let new = if mesh.orient(around[0]) == Sign::Negative { around.map(turned) } else { around };
    replace(mesh, &tets, &new)
}

pub(super) fn flip22(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    // The edge ac is on the hull, in the two tetrahedra alone: t and u, which share the face ace.
    let (t, [i, k]) = edge_of(mesh, choice);
    let [a, c] = [i, k].map(|j| mesh.tets[t][j]);
    let [x, y] = [0, 1].map(|n| (0..4).filter(|&j| j != i && j != k).nth(n));
    for (out, inn) in [(x?, y?), (y?, x?)] {
        // Opposite `out`: the face a, c, inn is shared; opposite `inn` is a hull facet a, c, out.
        let (b, e) = (mesh.tets[t][out], mesh.tets[t][inn]);
        if mesh.neighbours[t][inn] != NO_NEIGHBOUR {
            continue;
        }
        let Some((u, d)) = across(mesh, t, out) else { continue };
        let facet = mesh.tets[u].iter().position(|&v| v == e)?;
        if mesh.neighbours[u][facet] == NO_NEIGHBOUR && mesh.orient([a, b, c, d]) == Sign::Zero {
            // Both go the same way as t, if b d is a diagonal inside the quadrilateral.
            let new = [[a, b, d, e], [b, c, d, e]];
            let all = if mesh.orient(new[0]) == Sign::Negative { new.map(turned) } else { new };
            return replace(mesh, &[t, u], &all);
        }
    }
    None
}
