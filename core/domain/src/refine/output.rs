//! A refined domain as plain arrays: tetrahedra with their regions, boundary triangles with the
//! markers of their facets.

use super::marks::face_bit;
use super::run::Refined;
use super::table::triangle;
use ltbw_core::cavity::OTHERS;
use ltbw_core::mesh::Vertex;
use ltbw_core::tetmesh::{BoundaryFace, TetMesh};
use ltbw_core::topology::{VertexId, tet_of};

impl Refined {
    /// The mesh as plain arrays, tetrahedra tagged with their regions; with the exterior (tag 0)
    /// on request.
    pub fn to_tet_mesh(&self, exterior: bool) -> TetMesh {
        let mut mesh = TetMesh { tets: Vec::new(), ..self.state.mesh.to_tet_mesh() };
        let mut tags = Vec::new();
        for t in self.state.mesh.tet_ids() {
            let region = self.region(t);
            if exterior || region != 0 {
                mesh.tets.extend(self.state.mesh.tet(t));
                tags.push(i64::from(region));
            }
        }
        mesh.tet_tags = Some(tags);
        mesh
    }

    /// The triangles that the mesh has of the domain's facets, with the facets' markers; each
    /// belongs to a tetrahedron of [`Refined::to_tet_mesh`] with the same argument, and points out
    /// of it. A triangle between two regions belongs to one of them; one that stands free in the
    /// exterior to none, and is left out unless the exterior is wanted.
    pub fn boundary(&self, exterior: bool) -> Vec<BoundaryFace> {
        let (state, topology) = (&self.state, self.state.mesh.topology());
        let mut faces = Vec::new();
        let mut place = 0;
        let kept = |t| exterior || self.region(t) != 0;
        for t in state.mesh.tet_ids().filter(|&t| kept(t)) {
            let (word, tet) = (state.marks.of(t), topology.at(t));
            for slot in (0..4).filter(|&slot| word & face_bit(slot) != 0) {
                let other = tet_of(tet.neighbours()[slot]);
                // Of two tetrahedra at a triangle, that of the lower region has it, but for the
                // exterior; of equal ones the first.
                let rank = |t| (self.region(t) == 0, self.region(t), t);
                let shared = kept(other) && !topology.at(other).is_ghost();
                if shared && rank(other) < rank(t) {
                    continue;
                }
                let corners = OTHERS[slot].map(|k| tet.vertices()[k]);
                let [a, b, c] = corners;
                let marker = state.marker(triangle(a, b, c));
                let corners = corners.map(|v| state.mesh.numbers()[v as usize]);
                faces.push(BoundaryFace { corners, marker: i64::from(marker), tet: place });
            }
            place += 1;
        }
        faces
    }

    /// The subfaces that the mesh has: corners as vertex numbers, ascending.
    pub fn subfaces(&self) -> Vec<[Vertex; 3]> {
        let state = &self.state;
        let present = state.subfaces.keys().filter(|s| !state.missing.contains(*s));
        let number = |v: &VertexId| state.mesh.numbers()[*v as usize];
        let mut all: Vec<[Vertex; 3]> = present
            .map(|s| {
                let mut corners = [number(&s[0]), number(&s[1]), number(&s[2])];
                corners.sort_unstable();
                corners
            })
            .collect();
        all.sort_unstable();
        all
    }
}
