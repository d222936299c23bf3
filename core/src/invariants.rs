//! The invariants of `docs/invariants.md`, one check each: slow, for tests and debugging.
//!
//! A failed check names the tetrahedron; the message is for the developer.

use crate::mesh::Mesh;
use crate::predicates::{Sign, exact, perturb};
use crate::topology::{FREE, INFINITE, TetId, Topology, slot_of, tet_of};

/// The vertices of the face opposite `slot`, ascending.
fn face(topology: &Topology, t: TetId, slot: usize) -> [u32; 3] {
    let v = topology.tet(t).vertices();
    let mut face = [v[(slot + 1) & 3], v[(slot + 2) & 3], v[(slot + 3) & 3]];
    face.sort_unstable();
    face
}

/// I1: neighbour `i` shares the face opposite vertex `i`, and neighbourhood is mutual.
pub fn check_i1(topology: &Topology) -> Result<(), String> {
    for (t, tet) in topology.iter() {
        for (slot, &n) in tet.neighbours().iter().enumerate() {
            let (u, back) = (tet_of(n), slot_of(n));
            if u as usize >= topology.slots() || topology.tet(u).is_free() {
                return Err(format!("I1: neighbour {u} of tetrahedron {t} does not exist"));
            }
            if topology.tet(u).neighbours()[back] != 4 * t + slot as u32 {
                return Err(format!("I1: tetrahedra {t} and {u} are not mutual neighbours"));
            }
            if face(topology, t, slot) != face(topology, u, back) {
                return Err(format!("I1: neighbours {t} and {u} do not share the face"));
            }
        }
    }
    Ok(())
}

/// I2: the vertex at infinity is only in the last slot; the vertices of a tetrahedron differ;
/// the number of ghosts is right.
pub fn check_i2(topology: &Topology) -> Result<(), String> {
    for (t, tet) in topology.iter() {
        let mut v = tet.vertices();
        if v[..3].contains(&INFINITE) {
            return Err(format!("I2: tetrahedron {t} has the vertex at infinity in {v:?}"));
        }
        v.sort_unstable();
        if v.windows(2).any(|w| w[0] == w[1]) {
            return Err(format!("I2: tetrahedron {t} has a vertex twice: {v:?}"));
        }
    }
    let ghosts = topology.iter().filter(|(_, t)| t.is_ghost()).count();
    if ghosts != topology.ghosts() {
        return Err(format!("I2: {ghosts} ghosts, but {} are counted", topology.ghosts()));
    }
    Ok(())
}

/// I3: the free list holds exactly the free slots, each once.
pub fn check_i3(topology: &Topology) -> Result<(), String> {
    let mut free = topology.free_slots().to_vec();
    free.sort_unstable();
    let slots = 0..topology.slots() as TetId;
    let expected: Vec<TetId> = slots.filter(|&t| topology.tet(t).vertices()[0] == FREE).collect();
    if free != expected {
        return Err(format!("I3: free list {free:?}, free slots {expected:?}"));
    }
    Ok(())
}

/// I4: outside an insertion no tetrahedron is marked.
pub fn check_i4(topology: &Topology) -> Result<(), String> {
    match topology.iter().find(|(_, t)| t.is_marked()) {
        Some((t, _)) => Err(format!("I4: tetrahedron {t} is still marked")),
        None => Ok(()),
    }
}

/// I5: every finite tetrahedron is positively oriented, and across every face the vertex on the
/// far side is outside the perturbed circumsphere: the mesh is locally Delaunay everywhere
/// (hull facets included: then it is locally convex).
pub fn check_i5(mesh: &Mesh) -> Result<(), String> {
    let topology = mesh.topology();
    let at = |v: u32| mesh.kernel_point(v);
    for (t, tet) in topology.iter() {
        let [a, b, c, d] = tet.vertices();
        if d != INFINITE && exact::orient3d(&at(a), &at(b), &at(c), &at(d)) != Sign::Positive {
            return Err(format!("I5: tetrahedron {t} is not positively oriented"));
        }
        for &n in &tet.neighbours() {
            let far = topology.tet(tet_of(n)).vertices()[slot_of(n)];
            if far == INFINITE {
                continue; // seen from the other side
            }
            let p = at(far);
            let side = if d == INFINITE {
                perturb::side_of_hull_facet(&at(a), &at(b), &at(c), &p)
            } else {
                match exact::insphere(&at(a), &at(b), &at(c), &at(d), &p) {
                    Sign::Zero => perturb::perturbed_side(&at(a), &at(b), &at(c), &at(d), &p),
                    sign => sign,
                }
            };
            if side != Sign::Negative {
                return Err(format!("I5: vertex {far} is inside the sphere of tetrahedron {t}"));
            }
        }
    }
    Ok(())
}

/// I6: no cached sphere contradicts exact arithmetic for any vertex across a face, nor for the
/// tetrahedron's own vertices (which must be undecided).
pub fn check_i6(mesh: &Mesh) -> Result<(), String> {
    let topology = mesh.topology();
    let at = |v: u32| mesh.kernel_point(v);
    for (t, tet) in topology.iter().filter(|(_, t)| !t.is_ghost()) {
        let [a, b, c, d] = tet.vertices();
        let far = tet.neighbours().map(|n| topology.tet(tet_of(n)).vertices()[slot_of(n)]);
        for v in far.into_iter().filter(|&v| v != INFINITE).chain([a, b, c, d]) {
            let expected = exact::insphere(&at(a), &at(b), &at(c), &at(d), &at(v));
            if let Some(sign) = mesh.cached_side(t, &at(v)).filter(|&sign| sign != expected) {
                return Err(format!("I6: cached sphere of {t} says {sign:?} of vertex {v}"));
            }
        }
    }
    Ok(())
}

/// All invariants of a mesh between two insertions.
pub fn check_all(mesh: &Mesh) -> Result<(), String> {
    check_i1(mesh.topology())?;
    check_i2(mesh.topology())?;
    check_i3(mesh.topology())?;
    check_i4(mesh.topology())?;
    check_i5(mesh)?;
    check_i6(mesh)
}
