//! Stars whose tetrahedra the caller names: what a submesh gets of a cavity that others share.

use super::Submesh;
use crate::cavity::{SMALL, SMALL_WALLS, Star};
use crate::topology::{FaceId, TetId, VertexId, tet_of};

impl<H: Copy + Eq, T: Copy, F: Copy> Submesh<H, T, F> {
    /// Makes the tetrahedra of `corners[0]` with three other corners each, given by their indices
    /// `walls`, positively oriented. Their handles are put in `tets`, in the same order; their
    /// spheres are cached, unless there are more than 64 other corners; their faces are still to be
    /// linked. `None` at the limit of tetrahedra.
    ///
    /// # Panics
    /// If a corner is no vertex, or an index is none of a corner.
    pub fn create_star(
        &mut self,
        corners: &[VertexId],
        walls: impl ExactSizeIterator<Item = [u32; 3]>,
        tets: &mut Vec<TetId>,
    ) -> Option<()> {
        self.blocked = None;
        tets.clear();
        self.topology.reserve(walls.len()).ok()?;
        corners.iter().for_each(|&v| self.expect_vertex(v));
        // As in a cavity of the kernel, large stars have no spheres.
        let small = corners.len() <= SMALL + 1 && walls.len() <= SMALL_WALLS;
        let rim = if small { &corners[1..] } else { &[] };
        let mut faces = [[0; 4]; SMALL_WALLS];
        for (k, wall) in walls.enumerate() {
            let [a, b, c] = wall.map(|corner| corners[corner as usize]);
            let t = self.topology.take();
            self.topology.write(t, [corners[0], a, b, c]);
            tets.push(t);
            if small {
                let [a, b, c] = wall.map(|corner| corner as u8 - 1);
                faces[k] = [a, b, c, 0];
            }
        }
        let Some(&hint) = tets.last() else { return Some(()) };
        let star = Star { tets, rim, faces: &faces[..tets.len().min(SMALL_WALLS)] };
        let p = *self.geometry.point(corners[0]);
        self.geometry.created(self.topology.slots(), &star, &p);
        self.made += tets.len() as u64;
        self.hints[1..].rotate_right(1);
        self.hints[1] = hint;
        let place = self.place(corners[0]);
        self.places[place] = hint;
        Some(())
    }

    /// Says that `beyond` lies beyond `face`, both of new tetrahedra, without the other direction.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn point_to(&mut self, face: FaceId, beyond: FaceId) {
        self.expect_live(tet_of(face));
        self.expect_live(tet_of(beyond));
        self.blocked = None;
        self.topology.point_to(face, beyond);
    }

    /// Links a face of a new tetrahedron with that of an old one. A proxy that stood there is
    /// gone.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn link_new(&mut self, new: FaceId, old: FaceId) {
        self.expect_live(tet_of(new));
        self.expect_live(tet_of(old));
        self.blocked = None;
        self.forget_proxy(old);
        self.topology.link(new, old);
    }

    /// Puts a proxy for `far` at a face, such as a new tetrahedron's, where none stands. `None` at
    /// the limit of tetrahedra.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn put_far(&mut self, face: FaceId, far: F) -> Option<()> {
        self.expect_live(tet_of(face));
        self.blocked = None;
        self.topology.reserve(1).ok()?;
        let proxy = self.topology.take();
        self.geometry.reserve_spheres(self.topology.slots());
        self.topology.put_proxy(proxy, face);
        let tag = self.far.add(far);
        self.geometry.set_sphere(proxy, tag);
        Some(())
    }
}
