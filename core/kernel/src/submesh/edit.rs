//! Changes to a submesh from outside: vertices, tetrahedra and links that come from others.

use super::Submesh;
use crate::sphere::Sphere;
use crate::topology::{FaceId, TetId, VertexId, slot_of, tet_of};
use ltbw_exact::Point;

impl<H: Copy + Eq, T: Copy, F: Copy> Submesh<H, T, F> {
    /// Makes room for the coordinates of vertices up to `last`.
    pub fn make_vertices(&mut self, last: VertexId) {
        if last.index() >= self.geometry.points().len() {
            self.geometry.grow_points(last);
            self.cavity.reserve_vertices(last.index() + 1);
            self.others = true;
        }
    }

    /// Says that the mesh has a vertex at `p` that is none of the points of its parameters.
    pub fn refine_step(&mut self, p: &Point) {
        self.geometry.refine_step(p);
    }

    /// Gives vertex `v` its coordinates.
    ///
    /// # Panics
    /// If there is no such finite vertex.
    pub fn set_point(&mut self, v: VertexId, p: Point) {
        assert!(self.is_vertex(v), "there is no finite vertex {v}");
        self.geometry.set_point(v, p);
    }

    /// Gives the vertices from `first` on their coordinates.
    ///
    /// # Panics
    /// If there are no such finite vertices.
    pub fn set_points(&mut self, first: VertexId, points: &[Point]) {
        let Some(more) = points.len().checked_sub(1) else { return };
        let last = VertexId::new(u32::try_from(first.index() + more).unwrap_or(u32::MAX));
        assert!(self.is_vertex(first) && self.is_vertex(last), "there is no vertex {last}");
        self.geometry.prepare_points(first, points.len());
        for (v, p) in (first.number()..).map(VertexId::new).zip(points) {
            self.geometry.set_point(v, *p);
        }
    }

    /// Makes a tetrahedron, whose neighbours are still to be linked and whose sphere is still to be
    /// cached. `None` at the limit of tetrahedra.
    ///
    /// # Panics
    /// If one of these is no vertex, or the vertex at infinity is another than the last.
    pub fn create(&mut self, v: [VertexId; 4]) -> Option<TetId> {
        let [a, b, c, d] = v;
        self.expect_vertex(d);
        assert!([a, b, c].iter().all(|&v| self.is_vertex(v)), "{v:?} is no tetrahedron");
        self.blocked = None;
        self.topology.reserve(1).ok()?;
        let t = self.topology.take();
        self.topology.write(t, v, [FaceId::default(); 4]);
        self.geometry.reserve_spheres(self.topology.slots());
        self.geometry.set_sphere(t, Sphere::UNKNOWN);
        self.made += 1;
        self.hint(t, v);
        Some(t)
    }

    /// Caches the sphere of `t`.
    ///
    /// # Panics
    /// If there is no such tetrahedron.
    pub fn cache_sphere(&mut self, t: TetId) {
        self.expect_live(t);
        let sphere = self.geometry.compute_sphere(self.topology.tet(t).vertices());
        match self.locks.get_mut(self.geometry.sphere(t)) {
            Some(entry) => entry.sphere = sphere,
            None => self.geometry.set_sphere(t, sphere),
        }
    }

    /// Makes two faces of tetrahedra of this submesh each other's neighbour. A far face that stood
    /// at either is gone.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn link(&mut self, a: FaceId, b: FaceId) {
        self.expect_live(tet_of(a));
        self.expect_live(tet_of(b));
        self.blocked = None;
        self.forget_far_face(a);
        self.forget_far_face(b);
        self.topology.link(a, b);
    }

    /// Puts a far face for `far` at `face`, or lets the one there stand for that. `None` at the
    /// limit of tetrahedra.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn link_far(&mut self, face: FaceId, far: F) -> Option<()> {
        self.expect_live(tet_of(face));
        self.blocked = None;
        let there = tet_of(self.topology.tet(tet_of(face)).neighbours()[slot_of(face)]);
        if !self.is_far_face_of(there, face) {
            return self.put_far(face, far);
        }
        self.far.replace(self.geometry.sphere(there), far);
        Some(())
    }

    /// Removes tetrahedron `t`, which is unlocked, and the far faces at its faces; returns its tag.
    /// What links to it is still to be linked anew.
    ///
    /// # Panics
    /// If there is no such tetrahedron.
    pub fn remove(&mut self, t: TetId) -> Option<T> {
        self.expect_live(t);
        self.blocked = None;
        debug_assert!(!self.is_locked(t));
        let tag = self.locks.untag(&mut self.geometry.sphere(t));
        for (slot, beyond) in self.topology.tet(t).neighbours().into_iter().enumerate() {
            self.forget_far_face_at(FaceId::new(t, slot), tet_of(beyond));
        }
        self.geometry.set_sphere(t, Sphere::UNKNOWN);
        self.topology.erase(t);
        tag
    }

    /// Is slot `t`, to which a link leads (I7), a far face at `face`? Links that are not made yet
    /// lead to any slot.
    #[inline]
    fn is_far_face_of(&self, t: TetId, face: FaceId) -> bool {
        let tet = self.topology.tet(t);
        tet.is_far_face() && tet.neighbours()[0] == face
    }

    #[inline]
    pub(super) fn forget_far_face(&mut self, face: FaceId) {
        let there = tet_of(self.topology.tet(tet_of(face)).neighbours()[slot_of(face)]);
        self.forget_far_face_at(face, there);
    }

    /// Forgets the far face at `face` if slot `there` beyond it is one.
    #[inline]
    fn forget_far_face_at(&mut self, face: FaceId, there: TetId) {
        if self.is_far_face_of(there, face) {
            self.far.remove(self.geometry.sphere(there));
            self.geometry.set_sphere(there, Sphere::UNKNOWN);
            self.topology.erase(there);
        }
    }
}
