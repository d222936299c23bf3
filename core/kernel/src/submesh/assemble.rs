//! Submeshes put together to one mesh.

use super::{FarTable, Submesh};
use crate::geometry::{Geometry, PredicateStats};
use crate::mesh::{Assembly, Mesh};
use crate::topology::{FaceId, INFINITE, MAX_TETS, TetId, Topology, VertexId, slot_of, tet_of};

/// The numbers of a submesh's vertices in the whole mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Numbers {
    /// The number of the submesh's vertex 1; the next ones follow it ...
    pub first: VertexId,
    /// ... up to this one of its own.
    pub run: VertexId,
    /// Numbers of its vertices from there on.
    pub others: Vec<VertexId>,
}

impl Numbers {
    /// The numbers in the whole mesh of a slot's vertices in the submesh.
    #[inline(always)]
    fn of(&self, v: [VertexId; 4]) -> [VertexId; 4] {
        // Most tetrahedra have vertices of the run alone.
        if v.iter().all(|&w| w.number().wrapping_sub(1) < self.run.number()) {
            v.map(|w| VertexId::new(w.number() + (self.first.number() - 1)))
        } else {
            self.of_others(v)
        }
    }

    fn of_others(&self, v: [VertexId; 4]) -> [VertexId; 4] {
        // A vacant slot is known by its vertices.
        if v[0] == INFINITE {
            return v;
        }
        v.map(|w| match w.number().checked_sub(self.run.number() + 1) {
            _ if w == INFINITE => INFINITE,
            None => VertexId::new(self.first.number() + (w.number() - 1)),
            Some(place) => self.others.get(place as usize).copied().unwrap_or(INFINITE),
        })
    }

    /// Are the numbers up to `run` the same?
    fn keeps_run(&self) -> bool {
        self.first == VertexId::new(1)
    }
}

/// A submesh, and the numbers of its vertices in the whole mesh.
#[derive(Debug)]
pub struct Numbered<H, T, F> {
    /// The submesh.
    pub submesh: Submesh<H, T, F>,
    /// The numbers of its vertices.
    pub numbers: Numbers,
}

/// A face of one of several submeshes.
#[derive(Clone, Copy, Debug)]
pub struct Beyond {
    /// Index of the submesh.
    pub submesh: usize,
    /// The face there.
    pub face: FaceId,
}

/// Why submeshes could not be put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AssembleError<F> {
    /// There is no submesh.
    NoSubmeshes,
    /// Together they have too many tetrahedra.
    TooManyTets,
    /// Nobody has the tetrahedron beyond a far face.
    Dangling {
        /// Index of the submesh with the far face.
        submesh: usize,
        /// The far handle of the far face.
        far: F,
    },
}

/// Puts all submeshes of a mesh together, each with the numbers of its vertices. `find` finds the
/// submesh and the face beyond a far face by its far handle.
///
/// Vertices that no tetrahedron has are left out.
///
/// # Errors
/// [`AssembleError`] if there are too many tetrahedra, or if `find` finds nothing that is there.
///
/// Cost: O(tetrahedra), less those of the first.
pub fn assemble<H: Copy + Eq, T: Copy, F: Copy>(
    submeshes: Vec<Numbered<H, T, F>>,
    find: impl Fn(F) -> Option<Beyond>,
    assembly: Assembly<'_>,
) -> Result<Mesh, AssembleError<F>> {
    let settled = |Numbered { submesh, numbers }: Numbered<H, T, F>| (submesh.settle(), numbers);
    let mut submeshes = submeshes.into_iter().map(settled);
    let first = submeshes.next().ok_or(AssembleError::NoSubmeshes)?;
    let ((mut topology, mut geometry, far), numbers) = first;
    if !numbers.keeps_run() {
        topology.rename_above(INFINITE, |v| numbers.of(v));
    } else if !numbers.others.is_empty() {
        topology.rename_above(numbers.run, |v| numbers.of(v));
    }
    let mut tables = vec![far];
    // The limit of a submesh is not that of the whole mesh.
    topology.set_limit(MAX_TETS);
    let mut offsets = vec![0usize];
    for ((their_topology, their_geometry, far), numbers) in submeshes {
        tables.push(far);
        let (slots, theirs) = (topology.slots(), their_topology.slots());
        geometry.stats += their_geometry.stats;
        let offset = topology.append(their_topology, |v| numbers.of(v));
        offsets.push(offset.ok_or(AssembleError::TooManyTets)?);
        geometry.append_spheres(slots, their_geometry, theirs);
    }
    let (used, far_faces) = topology.survey(assembly.points.len());
    for &t in &far_faces {
        let tet = topology.tet(t);
        let face = tet.neighbours()[0];
        let at = offsets.partition_point(|&offset| offset <= t.index()) - 1;
        let Some(far) = tables[at].get(geometry.sphere(t)) else { continue };
        let beyond = find(far).and_then(|Beyond { submesh, face }| {
            let t = offsets.get(submesh)? + tet_of(face).index();
            (t <= MAX_TETS).then(|| FaceId::new(TetId::at(t), slot_of(face)))
        });
        match beyond.filter(|&beyond| topology.get(tet_of(beyond)).is_some()) {
            Some(beyond) => topology.point_to(face, beyond),
            None => return Err(AssembleError::Dangling { submesh: at, far }),
        }
    }
    for t in far_faces {
        topology.erase(t);
    }
    geometry.reserve_spheres(topology.slots());
    geometry.stats += assembly.predicates;
    Ok(Mesh::assembled(topology, geometry, &used, assembly))
}

impl<H: Copy + Eq, T: Copy, F: Copy> Submesh<H, T, F> {
    /// The numbers of predicate calls so far.
    pub fn predicates(&self) -> PredicateStats {
        self.geometry.stats
    }

    /// The mesh alone, nothing locked or tagged, and what lies beyond its interface faces.
    fn settle(mut self) -> (Topology, Geometry, FarTable<F>) {
        for (t, sphere) in self.locks.spheres() {
            self.geometry.set_sphere(t, sphere);
        }
        (self.topology, self.geometry, self.far)
    }
}
