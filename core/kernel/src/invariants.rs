//! The invariants of `docs/invariants.md`, one check each: slow, for tests and debugging.
//!
//! A failed check names the tetrahedron; the message is for the developer.

use crate::mesh::Mesh;
use crate::topology::{FaceId, INFINITE, TetId, Topology, VertexId, slot_of, tet_of};
use ltbw_exact::predicates::{Sign, exact, perturb};

/// The vertices of the face opposite `slot`, ascending.
fn face(topology: &Topology, t: TetId, slot: usize) -> [VertexId; 3] {
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
            if u.index() >= topology.slots() || topology.tet(u).is_free() {
                return Err(format!("I1: neighbour {u} of tetrahedron {t} does not exist"));
            }
            if topology.tet(u).neighbours()[back] != FaceId::new(t, slot) {
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
    let slots = (0..topology.slots()).map(TetId::at);
    let expected: Vec<TetId> = slots.filter(|&t| topology.tet(t).is_free()).collect();
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
    let at = |v: VertexId| mesh.kernel_point(v);
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
    let at = |v: VertexId| mesh.kernel_point(v);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Builder;
    use ltbw_exact::{Point, PointSet};
    use ltbw_generate::{PointKind, generate};

    const THIRD: TetId = TetId::new(3);

    fn mesh() -> Mesh {
        let set = PointSet::new(generate(PointKind::Uniform, 60, 2)).expect("finite points");
        Builder::new().build(&set).expect("a mesh").mesh
    }

    /// The answer of `check` for a topology that `damage` has changed.
    fn damaged(
        check: impl Fn(&Topology) -> Result<(), String>,
        damage: impl Fn(&mut Topology),
    ) -> String {
        let mut topology = mesh().topology;
        check(&topology).expect("a sound mesh");
        damage(&mut topology);
        check(&topology).expect_err("a damaged mesh")
    }

    #[test]
    fn broken_adjacency_is_seen() {
        // `put` links the neighbour across face 0 back; the others stay as given.
        let rewrite = |topology: &mut Topology, slot: usize, face: FaceId| {
            let (v, mut n) = (topology.tet(THIRD).vertices(), topology.tet(THIRD).neighbours());
            n[slot] = face;
            topology.put(THIRD, v, n);
        };
        let far = FaceId::new(TetId::new(100_000), 0);
        let message = damaged(check_i1, |t| rewrite(t, 1, far));
        assert_eq!(message, "I1: neighbour 100000 of tetrahedron 3 does not exist");
        let message = damaged(check_i1, |t| {
            let neighbour = tet_of(t.tet(THIRD).neighbours()[2]);
            t.release(neighbour);
        });
        assert!(message.ends_with("does not exist"), "{message}");
        let message = damaged(check_i1, |t| {
            let other = t.tet(THIRD).neighbours()[2];
            rewrite(t, 1, other);
        });
        assert!(message.ends_with("are not mutual neighbours"), "{message}");
        let message = damaged(check_i1, |t| {
            let (a, b) = (t.tet(THIRD).neighbours()[0], t.tet(THIRD).neighbours()[1]);
            t.link(FaceId::new(THIRD, 0), b);
            t.link(FaceId::new(THIRD, 1), a);
        });
        assert!(message.ends_with("do not share the face"), "{message}");
    }

    #[test]
    fn wrong_vertices_and_counts_are_seen() {
        let with = |slot: usize, vertex: fn([VertexId; 4]) -> VertexId| {
            damaged(check_i2, |t| {
                let (mut v, n) = (t.tet(THIRD).vertices(), t.tet(THIRD).neighbours());
                v[slot] = vertex(v);
                t.put(THIRD, v, n);
            })
        };
        assert!(with(1, |_| INFINITE).contains("has the vertex at infinity in"));
        assert!(with(2, |v| v[0]).contains("has a vertex twice"));
        let message = damaged(check_i2, |t| t.add_ghosts(1));
        assert!(message.contains("ghosts, but"), "{message}");
    }

    #[test]
    fn a_wrong_free_list_is_seen() {
        let message = damaged(check_i3, |t| {
            t.release(THIRD);
            t.release(THIRD);
        });
        assert_eq!(message, "I3: free list [3, 3], free slots [3]");
    }

    #[test]
    fn a_mark_left_behind_is_seen() {
        assert_eq!(damaged(check_i4, |t| t.mark(THIRD)), "I4: tetrahedron 3 is still marked");
    }

    #[test]
    fn wrong_orientation_and_a_point_inside_a_sphere_are_seen() {
        let mut turned = mesh();
        let finite = turned.topology.iter().find(|(_, t)| !t.is_ghost()).map(|(t, _)| t);
        let t = finite.expect("a tetrahedron");
        let (mut v, n) = (turned.topology.tet(t).vertices(), turned.topology.tet(t).neighbours());
        v.swap(0, 1);
        turned.topology.put(t, v, n);
        let message = check_i5(&turned).expect_err("a turned tetrahedron");
        assert_eq!(message, format!("I5: tetrahedron {t} is not positively oriented"));

        // Squeezed along one axis the mesh stays a mesh, but not Delaunay.
        let mut moved = mesh();
        let stretch = |p: &Point| [p[0] * 0.01, p[1], p[2]];
        moved.geometry.widen(stretch);
        let message = check_i5(&moved).expect_err("points were moved");
        assert!(message.contains("is inside the sphere of tetrahedron"), "{message}");
    }

    #[test]
    fn a_wrong_sphere_is_seen() {
        let (sound, mut other) = (mesh(), mesh());
        check_i6(&sound).expect("a sound mesh");
        // The sphere stays while its tetrahedron gets the vertices of another.
        let finite: Vec<TetId> =
            other.topology.iter().filter(|(_, t)| !t.is_ghost()).map(|(t, _)| t).collect();
        let n = other.topology.tet(finite[0]).neighbours();
        let v = sound.topology.tet(finite[finite.len() - 1]).vertices();
        other.topology.put(finite[0], v, n);
        let message = check_i6(&other).expect_err("spheres of other tetrahedra");
        assert!(message.starts_with(&format!("I6: cached sphere of {} says", finite[0])));
        assert!(check_all(&sound).is_ok() && check_all(&other).is_err());
    }
}
