//! A mesh as the plain lists that the checker takes.

use ltbw::Mesh;
use ltbw::topology::TetId;
use ltbw_verify::NO_NEIGHBOUR;

/// The lists of a mesh.
pub(crate) struct Lists {
    /// Its tetrahedra, in the order of [`Mesh::tets`].
    pub(crate) tets: Vec<[u32; 4]>,
    /// Across the face opposite each of their vertices the number of the neighbour in that order,
    /// or [`NO_NEIGHBOUR`].
    pub(crate) neighbours: Vec<[u32; 4]>,
}

/// The lists of a mesh.
pub(crate) fn lists(mesh: &Mesh) -> Lists {
    let ids: Vec<_> = mesh.tet_ids().collect();
    let mut position = vec![NO_NEIGHBOUR; mesh.topology().slots()];
    for (k, &id) in (0u32..).zip(&ids) {
        position[id.index()] = k;
    }
    let place = |id: TetId| position[id.index()];
    let across = |id| [0, 1, 2, 3].map(|slot| mesh.neighbour(id, slot).map_or(NO_NEIGHBOUR, place));
    let neighbours = ids.iter().map(|&id| across(id)).collect();
    Lists { tets: mesh.tets().collect(), neighbours }
}
