//! Point location by a remembering visibility walk.
//!
//! From tetrahedron to tetrahedron, across a face that has the target strictly on its far side,
//! never back through the face just crossed. In a Delaunay triangulation such a walk visits no
//! tetrahedron twice (Edelsbrunner, Combinatorica 10, 1990; the perturbed triangulation is a
//! regular one, for which the theorem holds too), so it ends; the bound below only guards it.

use crate::cavity::Conflict;
use crate::geometry::{Geometry, PointConflict};
use crate::topology::{INFINITE, TetId, Topology, VertexId, slot_of, tet_of};
use ltbw_exact::predicates::Sign;

/// The end of a walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Found {
    /// A tetrahedron certainly in conflict with the target: no vertex lies at the target.
    Conflict(TetId),
    /// The finite tetrahedron that holds the target, in its closure.
    Inside(TetId),
    /// A ghost: the target lies strictly beyond its hull facet.
    Outside(TetId),
    /// A slot that the walk may not enter.
    Barred(TetId),
}

/// Says which tetrahedra a walk may enter.
pub(crate) trait Access {
    /// Are there any that it may not enter? Then it goes around them as long as it can.
    const IS_LIMITED: bool;

    /// May the walk not enter `t`? Asked of tetrahedra whose sphere does not hold the target for
    /// certain.
    fn bars(&self, topology: &Topology, geometry: &Geometry, t: TetId) -> bool;
}

/// Lets every walk pass: the sequential kernel. Compiles to nothing.
impl Access for () {
    const IS_LIMITED: bool = false;

    #[inline(always)]
    fn bars(&self, _: &Topology, _: &Geometry, _: TetId) -> bool {
        false
    }
}

/// Walks from `start` towards the target, and stops at the first tetrahedron that is certain to be
/// in conflict: inserting needs no more.
#[inline(always)]
pub(crate) fn walk(topology: &Topology, conflict: &mut PointConflict<'_>, start: TetId) -> Found {
    walk_through(topology, conflict, start, &(), &mut 0)
}

/// [`walk`], through the tetrahedra that `access` lets it enter; counts them in `steps`.
#[inline(never)]
pub(crate) fn walk_through<G: Access>(
    topology: &Topology,
    conflict: &mut PointConflict<'_>,
    start: TetId,
    access: &G,
    steps: &mut u64,
) -> Found {
    let p = conflict.target();
    let mut t = start;
    let mut entry = 4; // no face
    if topology.tet(t).is_ghost() && !access.bars(topology, conflict.geometry(), t) {
        let back = topology.tet(t).neighbours()[3];
        t = tet_of(back);
    }
    for _ in 0..=topology.slots() {
        *steps += 1;
        let tet = topology.tet(t);
        if tet.vertices()[3] == INFINITE {
            if access.bars(topology, conflict.geometry(), t) {
                return Found::Barred(t);
            }
            return Found::Outside(t);
        }
        if conflict.sphere_says_inside(t) {
            return Found::Conflict(t);
        }
        let geometry = conflict.geometry();
        if access.bars(topology, geometry, t) {
            return Found::Barred(t);
        }
        let [a, b, c, d] = tet.vertices();
        let neighbours = tet.neighbours();
        // The face opposite `slot` with p in place of the vertex there, p moved to the end.
        let faces = [[c, b, d], [d, a, c], [b, a, d], [a, b, c]];
        let mut exit = (0..4).filter(|&slot| slot != entry).find(|&slot| {
            let side = geometry.orient(faces[slot], &p);
            side == Sign::Negative
        });
        if G::IS_LIMITED
            && let Some(first) = exit
            && access.bars(topology, geometry, tet_of(neighbours[first]))
        {
            let around = (first + 1..4).filter(|&slot| slot != entry).find(|&slot| {
                !access.bars(topology, geometry, tet_of(neighbours[slot]))
                    && geometry.orient(faces[slot], &p) == Sign::Negative
            });
            exit = around.or(exit);
        }
        match exit {
            None => return Found::Inside(t),
            Some(slot) => {
                t = tet_of(neighbours[slot]);
                entry = slot_of(neighbours[slot]);
            }
        }
    }
    scan(topology, conflict, access)
}

/// Walks from `start` to a tetrahedron that has the vertex `v`; `None` if there is none.
pub(crate) fn walk_to(
    topology: &Topology,
    geometry: &mut Geometry,
    start: TetId,
    v: VertexId,
) -> Option<TetId> {
    let p = *geometry.point(v);
    let mut conflict = geometry.conflict_of(&p);
    let geometry = conflict.geometry();
    let has = |t: TetId| topology.tet(t).vertices().contains(&v);
    let (mut t, mut entry) = (start, 4);
    if topology.tet(t).is_ghost() && !has(t) {
        t = tet_of(topology.tet(t).neighbours()[3]);
    }
    for _ in 0..=topology.slots() {
        if has(t) {
            return Some(t);
        }
        let tet = topology.tet(t);
        let [a, b, c, d] = tet.vertices();
        let faces = [[c, b, d], [d, a, c], [b, a, d], [a, b, c]];
        let mut exits = (0..4).filter(|&slot| slot != entry);
        let exit = exits.find(|&slot| geometry.orient(faces[slot], &p) == Sign::Negative);
        // A vertex lies beyond no hull facet.
        let Some(face) = exit.map(|slot| tet.neighbours()[slot]) else { break };
        (t, entry) = (tet_of(face), slot_of(face));
    }
    topology.iter().map(|(t, _)| t).find(|&t| has(t))
}

/// Finds a conflict by looking at every tetrahedron: right whatever a walk does.
#[cold]
fn scan<G: Access>(topology: &Topology, conflict: &mut PointConflict<'_>, access: &G) -> Found {
    let p = conflict.target();
    let mut barred = None;
    for (t, tet) in topology.iter() {
        if access.bars(topology, conflict.geometry(), t) {
            barred = Some(t);
            continue;
        }
        let at_vertex = tet.vertices().iter().any(|&v| *conflict.geometry().point(v) == p);
        if at_vertex && tet.is_ghost() {
            // A finite neighbour has the vertex too; no conflict is defined for equal points.
            continue;
        }
        if at_vertex {
            return Found::Inside(t);
        }
        if conflict.in_conflict(topology, t) {
            return Found::Conflict(t);
        }
    }
    // I5: every point that is not a vertex conflicts with some tetrahedron, here or beyond the
    // barred ones.
    barred.map_or(Found::Outside(TetId::default()), Found::Barred)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Builder;
    use ltbw_exact::PointSet;
    use ltbw_generate::{PointKind, generate};

    /// Lets no walk pass.
    struct Shut;

    impl Access for Shut {
        const IS_LIMITED: bool = true;

        fn bars(&self, _: &Topology, _: &Geometry, _: TetId) -> bool {
            true
        }
    }

    /// The fallback is never needed by a sound mesh: its answers are compared with the walk's.
    #[test]
    fn a_scan_finds_what_a_walk_finds() {
        let points = generate(PointKind::Uniform, 80, 3);
        let set = PointSet::new(points.clone()).expect("finite points");
        let mut mesh = Builder::new().build(&set).expect("a mesh").mesh;
        let mut queries = generate(PointKind::Uniform, 40, 4);
        queries.extend([[5.0, 5.0, 5.0], [-1.0, 0.5, 0.5]]);
        for p in &queries {
            let mut conflict = mesh.geometry.conflict_of(p);
            let Found::Conflict(t) = scan(&mesh.topology, &mut conflict, &()) else {
                panic!("no conflict with {p:?}");
            };
            assert!(conflict.in_conflict(&mesh.topology, t));
            let t = match walk(&mesh.topology, &mut conflict, TetId::default()) {
                Found::Conflict(t) | Found::Inside(t) | Found::Outside(t) => t,
                Found::Barred(t) => panic!("{t} was barred by nobody"),
            };
            assert!(conflict.in_conflict(&mesh.topology, t));
            let shut = scan(&mesh.topology, &mut conflict, &Shut);
            assert!(matches!(shut, Found::Barred(_)), "{shut:?}");
            // A conflict that a sphere decides needs no entry.
            let steps = &mut 0;
            match walk_through(&mesh.topology, &mut conflict, t, &Shut, steps) {
                Found::Conflict(u) => assert!(u == t && conflict.sphere_says_inside(t)),
                found => assert!(found == Found::Barred(t) && !conflict.sphere_says_inside(t)),
            }
            assert_eq!(*steps, 1);
        }
        for p in &points {
            let mut conflict = mesh.geometry.conflict_of(p);
            let Found::Inside(t) = scan(&mesh.topology, &mut conflict, &()) else {
                panic!("{p:?} is a vertex");
            };
            let tet = *mesh.topology.tet(t);
            assert!(!tet.is_ghost());
            assert!(tet.vertices().iter().any(|&v| mesh.geometry.point(v) == p));
        }
    }
}
