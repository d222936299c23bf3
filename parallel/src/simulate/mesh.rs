//! The real mesh on simulated processors.

use super::cost::Payload;
use super::{Options, Simulation, SimulationError, simulate};
use crate::mesh::{GatherError, Gathered, Layout, LocalMesh, Ownership, gather};
use crate::mesh::{Link, Moving, Patch, Piece, Side, WireVertex};
use crate::metrics::{SubmeshSize, Summary, Trace};
use crate::protocol::{Config, Correct, Rules, Worker};
use ltbw_core::BuildError;
use ltbw_exact::PointSet;

/// The name of a vertex, which is short if it was given, and its coordinates.
fn vertex_bytes(vertex: &WireVertex) -> u64 {
    let name = if u32::try_from(vertex.name).is_ok() { 4 } else { 8 };
    name + 24
}

fn vertices_bytes(all: &[WireVertex]) -> u64 {
    all.iter().map(vertex_bytes).sum()
}

/// A name, or none.
const NAME: u64 = 9;
/// A kind and a handle: the longest of the ways to say where a face leads.
const FACE: u64 = 14;
/// A new tetrahedron: a name, four indices of vertices, a block, four faces.
const NEW: u64 = NAME + 4 * 2 + 4 + 4 * FACE;

impl Payload for LocalMesh {
    fn point_bytes(point: &WireVertex) -> u64 {
        vertex_bytes(point)
    }

    fn piece_bytes(piece: &Piece) -> u64 {
        let Piece { tets, names, sides, .. } = piece;
        let near = |side: &&Side| matches!(side.link, Link::Near { .. });
        // A near link has a local number, a slot, a vertex and perhaps a name.
        let more = sides.iter().filter(near).count() as u64 * (NAME - 3);
        16 + 4 * tets.len() as u64
            + (NAME - 1) * names.len() as u64
            + vertices_bytes(&piece.vertices)
            + (3 * 2 + FACE) * sides.len() as u64
            + more
    }

    fn patch_bytes(patch: &Patch) -> u64 {
        let Patch { remove, create, relink, .. } = patch;
        16 + 4 * remove.len() as u64
            + vertices_bytes(&patch.vertices)
            + create.len() as u64 * NEW
            + relink.len() as u64 * (NAME + 1 + NAME + FACE)
    }

    fn cargo_bytes(cargo: &Vec<Moving>) -> u64 {
        // A tetrahedron of four vertices and four faces.
        4 + cargo.iter().map(|tet| NAME + 4 * FACE + vertices_bytes(&tet.v)).sum::<u64>()
    }
}

impl SubmeshSize for LocalMesh {
    fn tets(&self) -> u64 {
        self.num_tets() as u64
    }

    fn interface_faces(&self) -> u64 {
        self.num_interface_faces() as u64
    }
}

/// A mesh built on simulated processors.
#[derive(Debug)]
pub struct Meshed {
    /// The mesh: the one of its points, as always.
    pub gathered: Gathered,
    /// The figures of the processors' time, from when the coarse mesh is distributed.
    pub summary: Summary,
    /// Events of the simulation.
    pub events: u64,
    /// The timeline, if one was asked for.
    pub trace: Option<Trace>,
}

/// Why there is no mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The points have no mesh.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The run did not end properly.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The submeshes do not fit together.
    #[error(transparent)]
    Gather(#[from] GatherError),
}

/// Meshes `set` on simulated processors, one for each worker of `layout`.
///
/// # Errors
///
/// [`MeshError`].
pub fn simulate_mesh(
    set: &PointSet,
    layout: &Layout,
    config: Config,
    options: &Options,
) -> Result<Meshed, MeshError> {
    simulate_as::<Correct>(set, layout, config, options)
}

/// [`simulate_mesh`] with other rules: for checkers that must find a defect.
///
/// # Errors
///
/// [`MeshError`].
pub fn simulate_as<C: Rules>(
    set: &PointSet,
    layout: &Layout,
    config: Config,
    options: &Options,
) -> Result<Meshed, MeshError> {
    if layout.ownership != Ownership::Block
        && (options.storm.is_some() || options.balance.is_some())
    {
        return Err(SimulationError::Options(Ownership::STAYS.to_owned()).into());
    }
    let prepared = layout.distribute(set)?;
    let config = Config { workers: layout.workers, ..config };
    let workers = prepared
        .workers
        .into_iter()
        .map(|(directory, mesh, field)| Worker::<_, _, C>::new(config, directory, mesh, field))
        .collect();
    let Simulation { workers, summary, events, trace } = simulate(workers, options)?;
    let meshes = workers.into_iter().map(|worker| worker.into_parts().0).collect();
    let gathered = gather(meshes, prepared.common)?;
    Ok(Meshed { gathered, summary, events, trace })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::made;
    use crate::protocol::WorkerId;

    #[test]
    fn the_name_of_a_vertex_that_was_made_is_longer() {
        let vertices =
            [WireVertex::new(7u32, [0.5; 3]), WireVertex::new(made(WorkerId::new(3), 7), [0.5; 3])];
        assert_eq!(vertices.map(|v| LocalMesh::point_bytes(&v)), [28, 32]);
        let patch = |vertex| Patch { vertices: vec![vertex], ..Patch::default() };
        assert_eq!(vertices.map(|v| LocalMesh::patch_bytes(&patch(v))), [44, 48]);
    }
}
