//! Wrong claims and wrong tetrahedra: the points stay as they are.

use super::{Expected, STRUCTURE, Subject, TILING, TOPOLOGY, opposite, sorted};
use ltbw_verify::{Kind, NO_NEIGHBOUR};

/// Only the claims are spoilt, by a defect of this kind.
fn in_claims(kinds: &'static [Kind]) -> Option<Expected> {
    Some(Expected { in_claims: true, ..Expected::new(TOPOLOGY, kinds) })
}

/// Two neighbours of a tetrahedron change places.
pub(super) fn swapped_neighbours(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let (tet, slot) = mesh.place(choice);
    let n = &mut mesh.neighbours[tet];
    let other = (0..4).find(|&i| n[i] != n[slot])?;
    n.swap(slot, other);
    in_claims(&[Kind::WrongNeighbour])
}

/// A neighbour becomes the tetrahedron itself, one out of range, none, or any other.
pub(super) fn wrong_neighbour(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let (tet, slot) = mesh.place(choice);
    let tets = mesh.tets.len() as u32;
    let n = &mut mesh.neighbours[tet][slot];
    let wrong = [tet as u32, tets, NO_NEIGHBOUR, choice as u32 % tets];
    *n = wrong.into_iter().cycle().skip(choice / 16 % 4).find(|w| *w != *n)?;
    in_claims(&[Kind::WrongNeighbour])
}

/// The claimed hull lacks a facet.
pub(super) fn missing_hull_facet(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    mesh.hull.swap_remove(choice % mesh.hull.len());
    in_claims(&[Kind::HullFacetMissing])
}

/// The claimed hull has an inner face, or a facet twice.
pub(super) fn foreign_hull_facet(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let (tet, _) = mesh.place(choice);
    let inner = (0..4).find(|&i| mesh.neighbours[tet][i] != NO_NEIGHBOUR);
    let facet = inner.map_or(mesh.hull[0], |i| opposite(&mesh.tets[tet], i));
    mesh.hull.push(facet);
    in_claims(&[Kind::HullFacetExtra])
}

/// A tetrahedron is gone.
pub(super) fn missing_tet(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let (tet, _) = mesh.place(choice);
    mesh.tets.swap_remove(tet);
    mesh.claim();
    let none = Expected::new(STRUCTURE, &[Kind::Empty]);
    Some(if mesh.tets.is_empty() { none } else { TILING })
}

/// A tetrahedron is there twice, in another order of its vertices.
pub(super) fn duplicated_tet(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let (tet, slot) = mesh.place(choice);
    let mut copy = mesh.tets[tet];
    copy.rotate_left(slot);
    mesh.tets.push(copy);
    mesh.claim();
    Some(Expected::new(STRUCTURE, &[Kind::DuplicateTet]))
}

/// A tetrahedron of the mesh's own vertices that it does not have.
pub(super) fn foreign_tet(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let n = mesh.points.len();
    let corner = |k: u32| (choice / n.pow(k) % n) as u32;
    let new = [corner(0), corner(1), corner(2), (choice * 7 % n) as u32];
    let four = (0..4).all(|i| !new[..i].contains(&new[i]));
    if !four || mesh.tets.iter().any(|t| sorted(*t) == sorted(new)) {
        return None;
    }
    mesh.tets.push(new);
    mesh.claim();
    Some(TILING)
}

/// A tetrahedron names a vertex twice.
pub(super) fn repeated_vertex(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let (tet, slot) = mesh.place(choice);
    mesh.tets[tet][slot] = mesh.tets[tet][(slot + 1) % 4];
    Some(Expected::new(STRUCTURE, &[Kind::RepeatedVertex]))
}

/// A tetrahedron names a point that does not exist.
pub(super) fn index_out_of_range(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let (tet, slot) = mesh.place(choice);
    let beyond = mesh.points.len() as u32;
    mesh.tets[tet][slot] = if choice.is_multiple_of(3) { u32::MAX } else { beyond };
    Some(Expected::new(STRUCTURE, &[Kind::IndexOutOfRange]))
}

/// A tetrahedron names another vertex of the mesh instead of its own.
pub(super) fn renamed_vertex(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let (tet, slot) = mesh.place(choice);
    let vertex = (choice % mesh.points.len()) as u32;
    if mesh.tets[tet].contains(&vertex) {
        return None;
    }
    mesh.tets[tet][slot] = vertex;
    mesh.claim();
    Some(TILING)
}
