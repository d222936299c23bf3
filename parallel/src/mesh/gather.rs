//! The end of a parallel run: submeshes put together to one mesh.

use super::{LocalMesh, SharedInput};
use crate::protocol::{Handle, Name, SubmeshError, WorkerId};
use ltbw_core::submesh::{AssembleError, Assembly, assemble};
use ltbw_core::topology::{FaceId, TetId};
use ltbw_core::{Mesh, Vertex};
use rustc_hash::FxHashMap;

/// The result of a run.
#[derive(Debug)]
pub struct Gathered {
    /// The whole mesh.
    pub mesh: Mesh,
    /// Input indices of duplicates met, each with the index of the vertex kept; ascending.
    pub duplicates: Vec<(Vertex, Vertex)>,
}

/// The submeshes do not fit together: a defect of the run, never of its input.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GatherError {
    /// The far side of an interface face is nowhere.
    #[error("worker {worker}: no worker has tetrahedron {name:?} beyond an interface face")]
    Dangling {
        /// The worker that has the face.
        worker: u32,
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

/// Puts the submeshes of a finished run together.
///
/// # Errors
/// [`GatherError`] if there are too many tetrahedra, or if the submeshes do not fit together.
pub fn gather(meshes: Vec<LocalMesh>, common: SharedInput) -> Result<Gathered, GatherError> {
    let SharedInput { points, numbers, next, mut duplicates, mode, predicates } = common;
    if let Some((worker, error)) = meshes.iter().find_map(|m| Some((m.me, m.error?))) {
        return Err(GatherError::Failed { worker, error });
    }
    let mut places: FxHashMap<Name, (usize, TetId)> = FxHashMap::default();
    for (k, mesh) in meshes.iter().enumerate() {
        places.extend(mesh.names.iter().map(|(&name, &t)| (name, (k, t))));
    }
    for mesh in &meshes {
        duplicates.extend(&mesh.duplicates);
    }
    let far = |there: Handle| {
        let &(place, t) = places.get(&there.name)?;
        Some((place, FaceId::new(t, usize::from(there.face & 3))))
    };
    let workers: Vec<WorkerId> = meshes.iter().map(|mesh| mesh.me).collect();
    let parts = meshes.into_iter().map(|mesh| mesh.tets).collect();
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
