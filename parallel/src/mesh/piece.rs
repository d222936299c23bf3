//! The owner's side of an operation: what is in conflict here, locked at once, and described to the
//! home by its faces.

use super::vertices::Vertices;
use super::{Link, LocalMesh, Piece, Side, Tets, wire_vertex};
use crate::protocol::{Handle, Ticket};
use ltbw_core::cavity::OTHERS;
use ltbw_core::submesh::Closure;
use ltbw_core::topology::{FaceId, INFINITE, TetId, slot_of, tet_of};

impl LocalMesh {
    /// Describes what was locked at once.
    pub(super) fn describe_closure(&mut self, closure: &Closure) -> Piece {
        let Self { tets: mesh, scratch, vertices, fixed, .. } = self;
        let told = fixed.is_none().then_some(&*vertices);
        let vertex = |v| wire_vertex(mesh, vertices, v);
        let tets = &closure.locked[..closure.inside];
        let corners = &mut scratch.corners;
        corners.start((3 * closure.boundary.len()).min(4 * tets.len()));
        let mut sides = Vec::with_capacity(closure.boundary.len());
        for &(v, outer) in &closure.boundary {
            let v = v.map(|v| corners.index(vertices.name(v), || vertex(v)));
            let link = mesh.far(tet_of(outer)).map_or_else(|| near(mesh, told, outer), Link::Far);
            sides.push(Side { v, link });
        }
        let mut names = Vec::with_capacity(8);
        names.extend(tets.iter().filter_map(|&t| mesh.tag_of(t)));
        Piece { tets: tets.to_vec(), names, vertices: corners.vertices.clone(), sides }
    }

    /// Describes tetrahedra that are in conflict with the point of the operation that has locked
    /// them.
    pub(super) fn describe(&mut self, tets: &[TetId]) -> Piece {
        let holder = tets.first().and_then(|&t| self.tets.holder(t));
        let mut corners = std::mem::take(&mut self.scratch.corners);
        corners.start(4 * tets.len());
        let mut names = Vec::new();
        // A ball of k tetrahedra has at most 2 k + 2 faces.
        let mut sides = Vec::with_capacity(2 * tets.len() + 2);
        for &t in tets {
            names.extend(self.tets.tag_of(t));
            let v = self.tets.vertices(t);
            let v = v.map(|v| corners.index(self.vertices.name(v), || self.wire_vertex(v)));
            for (slot, face) in self.tets.neighbours(t).into_iter().enumerate() {
                if let Some(link) = self.link_at(face, holder) {
                    sides.push(Side { v: OTHERS[slot].map(|k| v[k]), link });
                }
            }
        }
        let vertices = corners.vertices.clone();
        self.scratch.corners = corners;
        Piece { tets: tets.to_vec(), names, vertices, sides }
    }

    /// The other side of a face of a tetrahedron that `holder` has locked, as the home sees it;
    /// `None` if that is in conflict, too.
    fn link_at(&self, face: FaceId, holder: Option<Ticket>) -> Option<Link> {
        let tet = tet_of(face);
        if let Some(handle) = self.tets.far(tet) {
            return Some(Link::Far(handle));
        }
        let (lock, name) = (self.tets.lock_of(tet), self.tets.tag_of(tet));
        if let (Some((by, true)), Some(mine)) = (lock, holder)
            && by == mine
        {
            return None;
        }
        Some(match name {
            // It has come here after the operation had asked for it where it was: whether it is in
            // conflict is open, and will be known by its name.
            Some(name) if lock.map(|(by, _)| by) != holder => {
                Link::Far(Handle { name, block: self.block_of(tet), face: slot_of(face) as u8 })
            }
            _ => near(&self.tets, self.fixed.is_none().then_some(&self.vertices), face),
        })
    }
}

/// The tetrahedron here beyond a face of a cavity. Its apex is told where blocks tell owners.
fn near(mesh: &Tets, vertices: Option<&Vertices>, face: FaceId) -> Link {
    let (tet, slot) = (tet_of(face), slot_of(face));
    let apex = vertices.and_then(|vertices| {
        let apex = mesh.vertices(tet)[slot];
        (apex != INFINITE).then(|| vertices.block(apex))
    });
    Link::Near { tet, slot: slot as u8, apex, name: mesh.tag_of(tet) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Layout, WireVertex};
    use crate::protocol::{Found, Name, Neighbour, Source, Submesh, Walk, WorkerId};
    use ltbw_exact::PointSet;
    use ltbw_generate::{PointKind, generate};
    use std::collections::BTreeSet;

    const MINE: Ticket = Ticket { clock: 1, worker: WorkerId::new(0), sequence: 1 };
    const OTHER: Ticket = Ticket { clock: 0, worker: WorkerId::new(1), sequence: 1 };

    /// All that was locked, the far neighbours, and what is said of it, in an order of their own.
    #[derive(Debug, Default, PartialEq)]
    struct Closure {
        held: Vec<TetId>,
        foreign: Vec<Handle>,
        tets: Vec<TetId>,
        names: Vec<Name>,
        vertices: Vec<WireVertex>,
        sides: Vec<([u64; 3], String)>,
    }

    impl Closure {
        fn new(mut held: Vec<TetId>, mut foreign: Vec<Handle>, pieces: Vec<Piece>) -> Self {
            held.sort_unstable();
            foreign.sort_unstable_by_key(|h| (h.name, h.face));
            let mut all = Self { held, foreign, ..Self::default() };
            for Piece { tets, names, vertices, sides } in pieces {
                let vertex = |k: u32| vertices[k as usize].name;
                let side = |s: &Side| (s.v.map(vertex), format!("{:?}", s.link));
                all.sides.extend(sides.iter().map(side));
                all.tets.extend(tets);
                all.names.extend(names);
                all.vertices.extend(vertices);
            }
            all.tets.sort_unstable();
            all.names.sort_unstable();
            all.vertices.sort_unstable_by_key(|vertex| vertex.name);
            all.sides.sort_unstable();
            all
        }
    }

    fn at_once(mesh: &mut LocalMesh, seed: TetId, point: &WireVertex) -> Option<Closure> {
        let (mut held, mut pieces, mut foreign) = Default::default();
        let mut found = Found { held: &mut held, pieces: &mut pieces, foreign: &mut foreign };
        let all = mesh.lock_all(seed, point, MINE, &mut found);
        all.then(|| Closure::new(held, foreign, pieces))
    }

    /// As an owner does it that knows no other way.
    fn one_by_one(mesh: &mut LocalMesh, seed: TetId, point: &WireVertex) -> Closure {
        let (mut held, mut cavity, mut foreign, mut wants) = (vec![], vec![], vec![], vec![seed]);
        while let Some(t) = wants.pop() {
            if mesh.holder(t).is_some() {
                continue;
            }
            let inside = mesh.in_conflict(t, point);
            mesh.lock(t, MINE, inside);
            held.push(t);
            if inside {
                cavity.push(t);
                mesh.neighbours(t, |n| match n {
                    Neighbour::Near(u) => wants.push(u),
                    Neighbour::Far(handle) => foreign.push(handle),
                });
            }
        }
        let pieces = mesh.pieces(&cavity);
        Closure::new(held, foreign, pieces)
    }

    /// Locks `before` with their neighbours one by one, then the rest of the cavity `tets` at once.
    fn mixed(
        mesh: &mut LocalMesh,
        before: &[TetId],
        tets: &[TetId],
        point: &WireVertex,
    ) -> Closure {
        let (mut held, mut pieces, mut foreign) = (vec![], vec![], vec![]);
        for &t in before {
            mesh.lock(t, MINE, true);
            held.push(t);
            mesh.neighbours(t, |n| foreign.extend(Some(n).and_then(far)));
        }
        for &t in tets {
            if mesh.holder(t).is_none() {
                let (held, pieces, foreign) = (&mut held, &mut pieces, &mut foreign);
                let mut found = Found { held, pieces, foreign };
                assert!(mesh.lock_all(t, point, MINE, &mut found));
            }
        }
        for &t in before {
            let mut ring = Vec::new();
            mesh.neighbours(t, |n| ring.extend(Some(n).and_then(near)));
            for u in ring {
                if mesh.holder(u).is_none() {
                    mesh.lock(u, MINE, false);
                    held.push(u);
                }
            }
        }
        pieces.extend(mesh.pieces(before));
        let mut closure = Closure::new(held, foreign, pieces);
        closure.vertices.dedup();
        closure
    }

    fn far(neighbour: Neighbour<TetId>) -> Option<Handle> {
        match neighbour {
            Neighbour::Far(handle) => Some(handle),
            Neighbour::Near(_) => None,
        }
    }

    fn near(neighbour: Neighbour<TetId>) -> Option<TetId> {
        match neighbour {
            Neighbour::Near(t) => Some(t),
            Neighbour::Far(_) => None,
        }
    }

    #[test]
    fn what_is_locked_at_once_is_what_is_locked_one_by_one() {
        for kind in [PointKind::Uniform, PointKind::Grid, PointKind::Clusters] {
            let set = PointSet::new(generate(kind, 2000, 1)).expect("finite points");
            let prepared = Layout::new(set.len(), 3).distribute(&set).expect("a mesh");
            let (mut far, mut named, mut lone) = (0, 0, 0);
            for (_, mut mesh, mut field) in prepared.workers {
                while let Some(point) = field.next(&mesh) {
                    field.inserted(&mesh, &point);
                    let Walk::At(seed) = mesh.walk(&point, None) else { continue };
                    let expected = one_by_one(&mut mesh, seed, &point);
                    let open = |mesh: &mut LocalMesh, held: &[TetId]| {
                        held.iter().for_each(|&t| mesh.set_holder(t, None));
                        assert_eq!(mesh.tets.locked().count(), 0);
                    };
                    open(&mut mesh, &expected.held);
                    let closure = at_once(&mut mesh, seed, &point).expect("nothing is locked");
                    assert_eq!(closure, expected);
                    open(&mut mesh, &expected.held);
                    // A search that locks nothing finds the same, if all of it is here.
                    let search = |mesh: &mut LocalMesh| {
                        let found = mesh.cavity_of(seed, &point.point())?;
                        Some(Vec::from_iter(found.iter().copied().collect::<BTreeSet<_>>()))
                    };
                    let whole = expected.foreign.is_empty().then_some(&expected.tets);
                    assert_eq!(search(&mut mesh).as_ref(), whole);

                    // Not one is locked if another operation has one of them ...
                    mesh.lock(seed, OTHER, true);
                    assert_eq!(search(&mut mesh), None);
                    mesh.set_holder(seed, None);
                    let last = expected.held.iter().copied().rfind(|&t| t != seed);
                    if let Some(t) = last {
                        mesh.lock(t, OTHER, false);
                        assert_eq!(at_once(&mut mesh, seed, &point), None);
                        assert_eq!(search(&mut mesh), None);
                        assert_eq!(mesh.tets.locked().collect::<Vec<_>>(), [t]);
                        mesh.set_holder(t, None);
                    }
                    // ... and what this one has in its ring already stays as it is.
                    let ring = last.filter(|t| !expected.tets.contains(t));
                    if let Some(t) = ring {
                        mesh.lock(t, MINE, false);
                        let rest = at_once(&mut mesh, seed, &point).expect("nothing is locked");
                        assert_eq!(rest.sides, expected.sides);
                        assert_eq!(rest.held.len() + 1, expected.held.len());
                        open(&mut mesh, &expected.held);
                    }
                    // Tetrahedra locked one by one before, here every other of the cavity with its
                    // neighbours, and what is locked at once fit together.
                    let before: Vec<TetId> = expected.tets.iter().copied().step_by(2).collect();
                    let mixed = mixed(&mut mesh, &before, &expected.tets, &point);
                    assert_eq!(mixed, expected);
                    open(&mut mesh, &expected.held);
                    far += expected.foreign.len();
                    named += expected.names.len();
                    lone += usize::from(expected.tets.is_empty());
                }
            }
            assert!(far > 100 && named > 100 && lone == 0, "{kind:?}: {far} {named} {lone}");
        }
    }

    #[test]
    fn a_seed_that_is_not_in_conflict_is_locked_alone() {
        let set = PointSet::new(generate(PointKind::Uniform, 500, 1)).expect("finite points");
        let prepared = Layout::new(set.len(), 2).distribute(&set).expect("a mesh");
        let (_, mut mesh, mut field) = prepared.workers.into_iter().next().expect("a worker");
        let point = field.next(&mesh).expect("a point");
        let all: Vec<TetId> = mesh.tets.tets().map(|(t, _)| t).collect();
        let seed = all.into_iter().find(|&t| !mesh.in_conflict(t, &point)).expect("one far away");
        let closure = at_once(&mut mesh, seed, &point).expect("nothing is locked");
        assert_eq!(closure, Closure { held: vec![seed], ..Closure::default() });
    }
}
