//! The part of a mesh that one worker of the parallel kernel owns.
//!
//! Vertices have one numbering for the whole mesh, 1 to n; a part knows the coordinates of those
//! that its tetrahedra have. Where a neighbour belongs to another part there stands a *proxy*: a
//! slot whose only neighbour is the tetrahedron in front of it, with a *far handle* that means
//! something to the caller.
//!
//! A tetrahedron can be *closed*, with a holder: no walk enters it and no cavity takes it. Closing
//! takes away the cached sphere, so that open tetrahedra are tested as fast as in a whole mesh:
//! what no sphere decides is looked at more closely, and then the lock or the proxy is seen. For
//! the same reason a tetrahedron that the caller must hear of when it goes ([`Part::watch`]) never
//! has a sphere.
//!
//! Numbers that come from outside are compared before they are used: a method that is given one of
//! no tetrahedron, face or vertex here panics. What is inside stays inside (I7): a link leads to a
//! slot, and a slot without a tetrahedron has no sphere, so that no walk and no cavity enters it,
//! even where the caller has not linked yet what it has made.

mod assemble;
mod closure;
mod conflict;
mod edit;
mod far;
mod insert;
mod star;
mod walk;

pub use crate::mesh::Assembly;
pub use assemble::{Misfit, assemble};
pub use closure::Closed;

use crate::cavity::{Cavity, Conflict};
use crate::geometry::Geometry;
use crate::special::Specials;
use crate::topology::{FaceId, INFINITE, MAX_TETS, TetId, Topology, VertexId};
use far::FarTable;
use ltbw_exact::Point;
use ltbw_exact::points::Mode;
use rayon::prelude::*;
use std::ops::Range;

/// Places of a part with a hint each: a power of two.
const PLACES: usize = 4096;
/// Of these, so many are for the part's own vertices at the start.
const HOME_PLACES: usize = 1024;

/// Where a walk in a part ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// At an open tetrahedron in conflict with the point.
    Conflict(TetId),
    /// At a vertex with the same coordinates.
    Vertex(VertexId),
    /// At a proxy.
    Proxy(TetId),
    /// At a closed tetrahedron.
    Closed(TetId),
    /// The part has no tetrahedron.
    Empty,
}

/// Which new tetrahedra of a local insertion would be the part's own.
#[derive(Clone, Copy, Debug)]
pub enum Owns<F> {
    /// All: none is looked at.
    All,
    /// None: the point is not inserted, but what is closed is met.
    None,
    /// Those of home vertices alone, and otherwise those of whose vertices this is true.
    By(F),
}

/// What became of a local insertion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Local {
    /// The point is a vertex.
    Inserted,
    /// A closed tetrahedron is in the way. The part is as before.
    Closed(TetId),
    /// No closed tetrahedron of the part is in the way, but a proxy or a new tetrahedron of another
    /// part. The part is as before.
    Blocked,
    /// The part would exceed the limit of tetrahedra. It is as before.
    Full,
}

/// The box, the arithmetic and the size of the whole mesh.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    low: Point,
    high: Point,
    wide: bool,
    step: f64,
    vertices: usize,
    max_tets: usize,
}

impl Setting {
    /// That of a mesh with these points, in kernel coordinates under `mode`.
    pub fn of(points: &[Point], mode: Mode) -> Self {
        let wide = mode == Mode::Wide;
        let of_chunk = |chunk: &[Point]| {
            let (low, high) = crate::build::bounding_box(chunk);
            (low, high, if wide { 0.0 } else { crate::geometry::common_step(chunk) })
        };
        let join = |(low, high, step): (Point, Point, f64), other: (Point, Point, f64)| {
            let low = [0, 1, 2].map(|k| low[k].min(other.0[k]));
            let high = [0, 1, 2].map(|k| high[k].max(other.1[k]));
            (low, high, step.min(other.2))
        };
        let none = || of_chunk(&[]);
        let (low, high, step) = points.par_chunks(1 << 14).map(of_chunk).reduce(none, join);
        Self { low, high, wide, step, vertices: points.len(), max_tets: MAX_TETS }
    }

    /// Sets how many tetrahedra, hull ghosts and proxies included, a part may have at most: no more
    /// than [`MAX_TETS`], which is the default.
    pub fn at_most(self, max_tets: usize) -> Self {
        Self { max_tets, ..self }
    }
}

/// A part of a mesh. `H` names the holder of a closed tetrahedron, `L` is the label of a watched
/// one, `F` says what lies beyond a proxy.
#[derive(Debug)]
pub struct Part<H, L, F> {
    topology: Topology,
    geometry: Geometry,
    cavity: Cavity,
    /// Seed and point of the cavity in `cavity`, if that was blocked and is, with its walls, what
    /// would be found now: whatever links, makes, removes, closes or opens a tetrahedron ends that.
    blocked: Option<(TetId, Point)>,
    /// Tetrahedra that are closed, or that the caller must hear of when an insertion removes them.
    specials: Specials<H, L>,
    /// What the proxies stand for.
    far: FarTable<F>,
    home: Range<VertexId>,
    /// There are vertices outside the home range.
    others: bool,
    /// Labels of the watched ones that the last insertion removed.
    gone: Vec<L>,
    /// Where walks may start: tetrahedra made lately, the last one first.
    hints: [TetId; 8],
    /// The vertex inserted last.
    last: VertexId,
    /// The same by place: vertices with near numbers are near each other.
    places: Vec<TetId>,
    /// Vertices of a place.
    grain: VertexId,
    /// Steps of walks so far.
    steps: u64,
    /// Tetrahedra made so far.
    made: u64,
}

impl<H: Copy + Eq, L: Copy, F: Copy> Part<H, L, F> {
    /// A part without tetrahedra.
    pub fn new(setting: &Setting) -> Self {
        let Setting { low, high, wide, step, vertices, max_tets } = *setting;
        let mut topology = Topology::default();
        topology.set_limit(max_tets);
        Self {
            topology,
            geometry: Geometry::part(low, high, wide, step, vertices),
            cavity: Cavity::for_vertices(vertices + 1),
            blocked: None,
            specials: Specials::new(),
            far: FarTable::new(),
            home: 0..0,
            others: true,
            gone: Vec::new(),
            hints: [0; 8],
            last: 0,
            places: vec![TetId::MAX; PLACES],
            grain: 1,
            steps: 0,
            made: 0,
        }
    }

    /// Reserves room for `tets` tetrahedra. A hint.
    pub fn reserve(&mut self, tets: usize) {
        debug_assert!(self.topology.is_empty());
        let limit = self.topology.limit();
        self.topology = Topology::with_capacity(tets.min(limit));
        self.topology.set_limit(limit);
        self.geometry.reserve_sphere_capacity(tets.min(limit));
    }

    /// The largest number of tetrahedra that the part may have, hull ghosts and proxies included.
    pub fn max_tets(&self) -> usize {
        self.topology.limit()
    }

    /// Is there room for `tets` more tetrahedra and proxies?
    pub fn has_room(&self, tets: usize) -> bool {
        self.topology.reserve(tets).is_ok()
    }

    /// Says which vertices are the part's own: a tetrahedron with no other vertex belongs to it.
    pub fn set_home(&mut self, home: Range<VertexId>) {
        self.others = home.start > 1 || (home.end as usize) < self.geometry.points().len();
        self.grain = (home.len() / HOME_PLACES + 1) as VertexId;
        self.home = home;
        let tets: Vec<(TetId, [VertexId; 4])> = self.tets().collect();
        for (t, v) in tets {
            self.cache_sphere(t);
            self.hint(t, v);
        }
    }

    /// Says that the vertices of `range` are not the part's own any more. What lies on the smaller
    /// side of them is not, either: the part's own vertices stay one range.
    pub fn leave(&mut self, range: Range<VertexId>) {
        let Range { start, end } = self.home;
        let below = start..range.start.clamp(start, end);
        let above = range.end.clamp(start, end)..end;
        self.home = if below.len() < above.len() { above } else { below };
        self.others = true;
    }

    /// The tetrahedra, proxies and free slots included.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The tetrahedra with their vertices, ghosts included.
    pub fn tets(&self) -> impl Iterator<Item = (TetId, [VertexId; 4])> + '_ {
        let real = self.topology.iter().filter(|(_, tet)| !tet.is_proxy());
        real.map(|(t, tet)| (t, tet.vertices()))
    }

    /// Is `t` a tetrahedron of this part?
    pub fn is_live(&self, t: TetId) -> bool {
        self.topology.get(t).is_some_and(|tet| !tet.is_vacant())
    }

    /// Is `v` a finite vertex of the whole mesh?
    pub fn is_vertex(&self, v: VertexId) -> bool {
        v != INFINITE && (v as usize) < self.geometry.points().len()
    }

    #[inline]
    #[track_caller]
    fn expect_slot(&self, t: TetId) {
        assert!((t as usize) < self.topology.slots(), "there is no slot {t}");
    }

    #[inline]
    #[track_caller]
    fn expect_live(&self, t: TetId) {
        assert!(self.is_live(t), "there is no tetrahedron {t}");
    }

    #[inline]
    #[track_caller]
    fn expect_vertex(&self, v: VertexId) {
        assert!((v as usize) < self.geometry.points().len(), "there is no vertex {v}");
    }

    /// The vertices of `t`; the vertex at infinity, 0, is only ever the last.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn vertices(&self, t: TetId) -> [VertexId; 4] {
        self.expect_slot(t);
        self.topology.tet(t).vertices()
    }

    /// The faces on the other sides of those of `t`, by the slot of the vertex opposite.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn neighbours(&self, t: TetId) -> [FaceId; 4] {
        self.expect_slot(t);
        self.topology.tet(t).neighbours()
    }

    /// Asks the processor to fetch tetrahedron `t`.
    #[inline]
    pub fn prefetch(&self, t: TetId) {
        self.topology.prefetch(t);
        self.geometry.prefetch_sphere(t);
    }

    /// The coordinates of vertex `v`.
    ///
    /// # Panics
    /// If there is no such vertex.
    #[inline]
    pub fn point(&self, v: VertexId) -> Point {
        self.expect_vertex(v);
        *self.geometry.point(v)
    }

    /// What proxy `t` stands for; `None` if `t` is not one.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn far(&self, t: TetId) -> Option<F> {
        self.expect_slot(t);
        self.far.get(self.geometry.sphere(t))
    }

    /// Steps of walks, conflict tests and tetrahedra made so far.
    pub fn work(&self) -> (u64, u64, u64) {
        (self.steps, self.geometry.stats.insphere_calls, self.made)
    }

    /// Watches `t`: should an insertion remove it, its label is among [`Part::take_gone`] then.
    ///
    /// # Panics
    /// If there is no such tetrahedron.
    pub fn watch(&mut self, t: TetId, label: L) {
        self.expect_live(t);
        let mut sphere = self.geometry.sphere(t);
        self.specials.entry(t, &mut sphere).label = Some(label);
        self.geometry.set_sphere(t, sphere);
    }

    /// The label of `t`, if it is watched.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn label(&self, t: TetId) -> Option<L> {
        self.expect_slot(t);
        self.specials.get(self.geometry.sphere(t))?.label
    }

    /// Stops to watch `t`; returns its label.
    ///
    /// # Panics
    /// If there is no such slot.
    pub fn unwatch(&mut self, t: TetId) -> Option<L> {
        self.expect_slot(t);
        unwatch(&mut self.specials, &mut self.geometry, t)
    }

    /// Is tetrahedron `t` in conflict with `p`?
    ///
    /// # Panics
    /// If there is no such tetrahedron.
    pub fn in_conflict(&mut self, t: TetId, p: &Point) -> bool {
        self.expect_live(t);
        self.geometry.stats.insphere_calls += 1;
        let sphere = self.geometry.sphere(t);
        let sphere = self.specials.get(sphere).map_or(sphere, |special| special.sphere);
        if let Some(sign) = self.geometry.side(sphere, p) {
            return sign.is_positive();
        }
        let mut conflict = self.geometry.conflict_of(p);
        conflict.in_conflict(&self.topology, t)
    }

    /// Who holds the closed tetrahedron `t`; `None` if it is open.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn holder(&self, t: TetId) -> Option<H> {
        self.closed_by(t).map(|(holder, _)| holder)
    }

    /// The closed tetrahedra.
    pub fn closed(&self) -> impl Iterator<Item = TetId> + '_ {
        self.specials.closed()
    }

    /// Closes `t`, which is open, as a tetrahedron of the holder's cavity (`inside`) or not.
    ///
    /// # Panics
    /// If there is no such tetrahedron.
    pub fn close(&mut self, t: TetId, holder: H, inside: bool) {
        self.expect_live(t);
        self.blocked = None;
        let mut sphere = self.geometry.sphere(t);
        self.specials.entry(t, &mut sphere).closed = Some((holder, inside));
        self.geometry.set_sphere(t, sphere);
    }

    /// Who holds the closed tetrahedron `t`, and whether as one of its cavity; `None` if it is open.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn closed_by(&self, t: TetId) -> Option<(H, bool)> {
        self.expect_slot(t);
        self.specials.get(self.geometry.sphere(t))?.closed
    }

    fn is_closed(&self, t: TetId) -> bool {
        self.specials.is_closed(self.geometry.sphere(t))
    }

    /// Opens `t`; nothing happens if it is open.
    ///
    /// # Panics
    /// If there is no such slot.
    pub fn open(&mut self, t: TetId) {
        self.expect_slot(t);
        self.blocked = None;
        let mut sphere = self.geometry.sphere(t);
        self.specials.open(&mut sphere);
        self.geometry.set_sphere(t, sphere);
    }
}

/// Takes the label of `t` away.
fn unwatch<H: Copy, L: Copy>(
    specials: &mut Specials<H, L>,
    geometry: &mut Geometry,
    t: TetId,
) -> Option<L> {
    let mut sphere = geometry.sphere(t);
    let label = specials.unwatch(&mut sphere);
    geometry.set_sphere(t, sphere);
    label
}
