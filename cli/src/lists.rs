//! A mesh as the plain lists that the checker takes.

use ltbw::Mesh;
use ltbw::topology::TetId;
use ltbw_verify::NO_NEIGHBOUR;

/// The tetrahedra of a mesh, in the order of [`Mesh::tets`], and across the face opposite each of
/// their vertices the number of the neighbour in that order, or [`NO_NEIGHBOUR`].
pub(crate) fn lists(mesh: &Mesh) -> (Vec<[u32; 4]>, Vec<[u32; 4]>) {
    let ids: Vec<_> = mesh.tet_ids().collect();
    let mut position = vec![NO_NEIGHBOUR; mesh.topology().slots()];
    for (k, &id) in (0u32..).zip(&ids) {
        position[id.index()] = k;
    }
    let place = |id: TetId| position[id.index()];
    let across = |id| [0, 1, 2, 3].map(|slot| mesh.neighbour(id, slot).map_or(NO_NEIGHBOUR, place));
    (mesh.tets().collect(), ids.iter().map(|&id| across(id)).collect())
}
