//! The end of a parallel run: submeshes put together to one mesh.

use super::name::{count_of, maker_of};
use super::{LocalMesh, SharedInput, VertexName, given, made};
use crate::protocol::{Handle, Name, SubmeshError, WorkerId};
use ltbw_core::submesh::{AssembleError, Assembly, Beyond, Numbered, Numbers, assemble};
use ltbw_core::topology::{FaceId, INFINITE, TetId, VertexId};
use ltbw_core::{Duplicate, Mesh, Vertex};
use ltbw_exact::Point;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// The result of a run.
#[derive(Debug)]
pub struct Gathered {
    /// The whole mesh.
    pub mesh: Mesh,
    /// Duplicates met, by input indices, ascending.
    pub duplicates: Vec<Duplicate>,
}

/// The submeshes do not fit together: a defect of the run, never of its input.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GatherError {
    /// The far side of an interface face is nowhere.
    #[error("worker {worker}: no worker has tetrahedron {name:?} beyond an interface face")]
    Dangling {
        /// The worker that has the face.
        worker: WorkerId,
        /// The name it leads to.
        name: Name,
    },
    /// A submesh has failed: the run had no end.
    #[error("worker {worker}: {error}")]
    Failed {
        /// The worker.
        worker: WorkerId,
        /// Why its submesh has failed.
        error: SubmeshError,
    },
    /// There is no submesh.
    #[error("there is no submesh to put together")]
    NoParts,
    /// The mesh has more tetrahedra than it can number.
    #[error("the mesh would exceed the limit of tetrahedra, hull ghosts included")]
    TooManyTets,
}

/// The vertices that were made on the way. They have the numbers after those given, in the order
/// of their names: the order of their makers, and of each one's making.
struct MadeVertices {
    /// Ascending.
    names: Vec<VertexName>,
    points: Vec<Point>,
    /// By maker: the place of its first one.
    firsts: Vec<usize>,
    /// The number of the first one of all.
    number: VertexId,
}

impl MadeVertices {
    fn of(meshes: &[LocalMesh], given_ones: usize) -> Self {
        let mut all: Vec<(VertexName, Point)> = Vec::new();
        for mesh in meshes {
            let (_, others) = mesh.vertices.all();
            let named = (mesh.vertices.after_run().number()..).map(VertexId::new).zip(others);
            let made = named.filter(|&(_, name)| given(name).is_none());
            all.extend(made.map(|(v, name)| (name, mesh.tets.point(v))));
        }
        all.par_sort_unstable_by_key(|&(name, _)| name);
        all.dedup_by_key(|&mut (name, _)| name);
        let (names, points): (Vec<VertexName>, Vec<Point>) = all.into_iter().unzip();
        let makers = (0..meshes.len() as u32).map(|by| made(WorkerId::new(by), 0));
        let firsts = makers.map(|least| names.partition_point(|&name| name < least)).collect();
        Self { names, points, firsts, number: VertexId::new(given_ones as u32 + 1) }
    }

    /// The number of a vertex in the whole mesh.
    fn number(&self, name: VertexName) -> Option<VertexId> {
        if let Some(place) = given(name) {
            return Some(VertexId::new(place));
        }
        let first = maker_of(name).and_then(|by| self.firsts.get(by.number() as usize));
        // Most makers have counted without gaps.
        let guess = first.map(|first| first + (count_of(name) as usize).saturating_sub(1));
        let place = match guess.filter(|&guess| self.names.get(guess) == Some(&name)) {
            Some(place) => place,
            None => self.names.binary_search(&name).ok()?,
        };
        Some(VertexId::new(self.number.number() + place as u32))
    }
}

/// Puts the submeshes of a finished run together.
///
/// # Errors
/// [`GatherError`] if there are too many tetrahedra, or if the submeshes do not fit together.
pub fn gather(meshes: Vec<LocalMesh>, common: SharedInput) -> Result<Gathered, GatherError> {
    let SharedInput { mut points, mut numbers, next, mut duplicates, mode, predicates } = common;
    if let Some((worker, error)) = meshes.iter().find_map(|m| Some((m.me, m.error?))) {
        return Err(GatherError::Failed { worker, error });
    }
    let mut places: FxHashMap<Name, (usize, TetId)> = FxHashMap::default();
    for (k, mesh) in meshes.iter().enumerate() {
        places.extend(mesh.names.iter().map(|(&name, &t)| (name, (k, t))));
    }
    let made = MadeVertices::of(&meshes, points.len());
    for mesh in &meshes {
        let pair = |&(point, v): &(VertexName, VertexName)| {
            Some((VertexId::new(given(point)?), made.number(v)?))
        };
        duplicates.extend(mesh.duplicates.iter().filter_map(pair));
    }
    points.extend(made.points.iter().copied());
    numbers.extend((0..made.points.len()).map(|k| next + k as Vertex));
    let next = next + made.points.len() as Vertex;
    let far = |there: Handle| {
        let &(submesh, t) = places.get(&there.name)?;
        Some(Beyond { submesh, face: FaceId::new(t, usize::from(there.face & 3)) })
    };
    let workers: Vec<WorkerId> = meshes.iter().map(|mesh| mesh.me).collect();
    let part = |mesh: LocalMesh| {
        let (first, others) = mesh.vertices.all();
        let first = VertexId::new(first);
        let others = others.map(|name| made.number(name).unwrap_or(INFINITE)).collect();
        Numbered {
            submesh: mesh.tets,
            numbers: Numbers { first, run: mesh.vertices.run(), others },
        }
    };
    let parts = meshes.into_iter().map(part).collect();
    let assembly = Assembly { points, numbers, duplicates: &duplicates, mode, predicates };
    let mut mesh = assemble(parts, far, assembly).map_err(|misfit| match misfit {
        AssembleError::Dangling { submesh, far } => {
            GatherError::Dangling { worker: workers[submesh], name: far.name }
        }
        AssembleError::TooManyTets => GatherError::TooManyTets,
        AssembleError::NoSubmeshes => GatherError::NoParts,
    })?;
    mesh.set_next_number(next);
    Ok(Gathered { duplicates: mesh.duplicates().to_vec(), mesh })
}
