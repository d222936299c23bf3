//! A vertex inside that is taken out of the mesh, and put in elsewhere.

use crate::complex::carrier::Carrier;
use crate::mesh::marks::{ENDS, Word, edge_bit, face_bit};
use crate::mesh::state::{FACE, State};
use crate::table::{edge, triangle};
use ltbw_core::RemoveError;
use ltbw_core::mesh::At;
use ltbw_core::topology::{TetId, VertexId};
use ltbw_core::transaction::OpenCavity;
use ltbw_exact::Point;

impl State {
    /// Takes a vertex inside a region out of the mesh; what fills its star is in that region, too.
    /// The boundary stays: whatever is in a Delaunay mesh, and has not the vertex, is in that
    /// without the vertex.
    pub(crate) fn take_out(&mut self, v: VertexId, region: u32) -> Result<(), RemoveError> {
        self.mesh.take_out(v)?;
        self.marks.grow(self.mesh.topology().slots());
        for &t in self.mesh.cavity().star().tets {
            self.marks.enter(t, region, self.boundary_of(self.vertices(t)));
        }
        Ok(())
    }

    /// Puts a vertex that was taken out in at a place, with its number.
    pub(crate) fn put_in(&mut self, p: Point, number: u32, from: TetId) -> Result<VertexId, At> {
        self.mesh.begin_anywhere(p, from)?.end(|_| ());
        self.marks.gather(&self.mesh);
        let v = OpenCavity::new(&mut self.mesh).fill(p, number);
        self.marks.pass_on(&self.mesh);
        Ok(v)
    }

    /// The marks of a tetrahedron as the tables tell them.
    fn boundary_of(&self, v: [VertexId; 4]) -> Word {
        let is_on = v.map(|v| self.carriers[v.index()] != Carrier::Free);
        let mut word = 0;
        for [i, j] in ENDS {
            if is_on[i] && is_on[j] && self.segments.contains_key(&edge(v[i], v[j])) {
                word |= edge_bit(i, j);
            }
        }
        for (slot, face) in FACE.into_iter().enumerate() {
            let [a, b, c] = face.map(|k| v[k]);
            if face.iter().all(|&k| is_on[k]) && self.subfaces.contains_key(&triangle(a, b, c)) {
                word |= face_bit(slot);
            }
        }
        word
    }
}
