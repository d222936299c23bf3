//! Wrong coordinates, and points too many.

use super::{Expected, STRUCTURE, Subject, TOPOLOGY, opposite};
use ltbw::{Point, Sign};
use ltbw_verify::{Kind, Level};

/// Moves a vertex of a tetrahedron through its opposite face, to its mirror image in the face's
/// centre. Some tetrahedra stay positive: else it may be the mirror image of a mesh.
pub(super) fn moved_beyond(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let (tet, slot) = mesh.place(choice);
    let v = mesh.tets[tet][slot];
    let [a, b, c] = opposite(&mesh.tets[tet], slot).map(|w| *mesh.at(w));
    let old = *mesh.at(v);
    let centre = |k: usize| a[k] / 3.0 + b[k] / 3.0 + c[k] / 3.0;
    let new: Point = std::array::from_fn(|k| 2.0 * centre(k) - old[k]);
    if mesh.points.contains(&new) || !new.iter().all(|c| c.is_finite()) {
        return None;
    }
    mesh.points[v as usize] = new;
    let signs: Vec<Sign> = mesh.tets.iter().map(|&t| mesh.orient(t)).collect();
    let grown = signs[tet] == Sign::Negative && signs.contains(&Sign::Positive);
    grown.then_some(Expected::new(&[Level::Orientation], &[Kind::InvertedTet]))
}

/// Two vertices lie at one place.
pub(super) fn moved_onto_another(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let n = mesh.points.len();
    let vertex = choice % n;
    let other = (vertex + 1 + choice / n % (n - 1)) % n;
    mesh.points[vertex] = mesh.points[other];
    Some(Expected::new(STRUCTURE, &[Kind::EqualVertices]))
}

/// A coordinate is NaN or infinite.
pub(super) fn not_finite(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let vertex = choice % mesh.points.len();
    mesh.points[vertex][choice / 3 % 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][choice % 3];
    Some(Expected::new(STRUCTURE, &[Kind::NotFinite]))
}

/// The middle of an edge is a point that the mesh has not got.
pub(super) fn forgotten_point(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let (tet, slot) = mesh.place(choice);
    let [a, b] = [slot, (slot + 1) % 4].map(|k| *mesh.at(mesh.tets[tet][k]));
    let middle: Point = std::array::from_fn(|k| a[k] / 2.0 + b[k] / 2.0);
    if mesh.points.contains(&middle) {
        return None;
    }
    mesh.points.push(middle);
    Some(Expected::new(STRUCTURE, &[Kind::PointLeftOut]))
}

/// A stretched copy of a tetrahedron elsewhere.
pub(super) fn second_body(mesh: &mut Subject, choice: usize) -> Option<Expected> {
    let (tet, _) = mesh.place(choice);
    let n = mesh.points.len() as u32;
    let copy = mesh.tets[tet].map(|v| mesh.at(v).map(|c| c + 4.0 * c.abs() + 4.0));
    let new = |p: &Point| p.iter().all(|c| c.is_finite()) && !mesh.points.contains(p);
    if !copy.iter().all(new) {
        return None;
    }
    mesh.points.extend(copy);
    let body = [n, n + 1, n + 2, n + 3];
    mesh.tets.push(match mesh.orient(body) {
        Sign::Positive => body,
        Sign::Negative => [n + 1, n, n + 2, n + 3],
        Sign::Zero => return None,
    });
    mesh.claim();
    Some(Expected::new(TOPOLOGY, &[Kind::Disconnected]))
}
