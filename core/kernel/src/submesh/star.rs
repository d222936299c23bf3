//! Stars whose tetrahedra the caller names: what a submesh gets of a cavity that others share.

use super::Submesh;
use crate::cavity::{SMALL, SMALL_BOUNDARY, Star};
use crate::topology::{FaceId, TetId, VertexId, slot_of, tet_of};

/// A tetrahedron of a star that is to be made.
#[derive(Clone, Copy, Debug)]
pub struct StarTet {
    /// Indices of the corners beside the star's first one, so that it is positively oriented.
    pub border: [u32; 3],
    /// The faces beyond its own that are of the star, too, whose tetrahedra are counted from 0.
    pub links: [Option<FaceId>; 4],
}

impl<H: Copy + Eq, T: Copy, F: Copy> Submesh<H, T, F> {
    /// Makes the tetrahedra of a star about `corners[0]`. The faces that it does not name are still
    /// to be linked. The handles are put in `tets`, in the star's order; their spheres are cached,
    /// unless there are more than 64 other corners. `None` at the limit of tetrahedra.
    ///
    /// # Panics
    /// If a corner is no vertex, an index is none of a corner, or a face is none of the star.
    pub fn create_star(
        &mut self,
        corners: &[VertexId],
        star: impl ExactSizeIterator<Item = StarTet>,
        tets: &mut Vec<TetId>,
    ) -> Option<()> {
        self.blocked = None;
        tets.clear();
        self.topology.reserve(star.len()).ok()?;
        corners.iter().for_each(|&v| self.expect_vertex(v));
        // As in a cavity of the kernel, large stars have no spheres.
        let small = corners.len() <= SMALL + 1 && star.len() <= SMALL_BOUNDARY;
        let rim = if small { &corners[1..] } else { &[] };
        let mut faces = [[0; 4]; SMALL_BOUNDARY];
        // All slots first: a face may lead to a tetrahedron that comes later.
        tets.extend((0..star.len()).map(|_| self.topology.take()));
        for (k, StarTet { border, links }) in star.enumerate() {
            let [a, b, c] = border.map(|corner| corners[corner as usize]);
            // A face that is not linked yet leads to slot 0, which there is (I7).
            let beyond = |face| FaceId::new(tets[tet_of(face).index()], slot_of(face));
            let n = links.map(|face| face.map_or_else(FaceId::default, beyond));
            self.topology.write(tets[k], [corners[0], a, b, c], n);
            if small {
                let [a, b, c] = border.map(|corner| corner as u8 - 1);
                faces[k] = [a, b, c, 0];
            }
        }
        let Some(&hint) = tets.last() else { return Some(()) };
        let star = Star { tets, rim, faces: &faces[..tets.len().min(SMALL_BOUNDARY)] };
        let p = *self.geometry.point(corners[0]);
        self.geometry.created(self.topology.slots(), &star, &p);
        self.made += tets.len() as u64;
        self.hints[1..].rotate_right(1);
        self.hints[1] = hint;
        let place = self.place(corners[0]);
        self.places[place] = hint;
        Some(())
    }

    /// Links a face of a new tetrahedron with that of an old one. A far face that stood there is
    /// gone.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn link_new(&mut self, new: FaceId, old: FaceId) {
        self.expect_live(tet_of(new));
        self.expect_live(tet_of(old));
        self.blocked = None;
        self.forget_far_face(old);
        self.topology.link(new, old);
    }

    /// Puts a far face for `far` at a face, such as a new tetrahedron's, where none stands. `None`
    /// at the limit of tetrahedra.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn put_far(&mut self, face: FaceId, far: F) -> Option<()> {
        self.expect_live(tet_of(face));
        self.blocked = None;
        self.topology.reserve(1).ok()?;
        let far_face = self.topology.take();
        self.geometry.reserve_spheres(self.topology.slots());
        self.topology.put_far_face(far_face, face);
        let tag = self.far.add(far_face, far);
        self.geometry.set_sphere(far_face, tag);
        Some(())
    }
}
