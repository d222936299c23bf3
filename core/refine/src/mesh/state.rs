//! The state of a refinement: the mesh, its marks, and the tables of subsegments and subfaces.
//!
//! The tables name every subsegment and subface, with its segment or facet, whether the mesh has
//! it or not; the marks are on those that the mesh has. Every simplex that an insertion creates has
//! the new point, so an item that the mesh has lost never comes back: it has to be split.

use super::encroachment::EncroachmentIndex;
use super::item::{Item, Queues, has_corner};
use super::journal::Journal;
use super::marks::Marks;
use super::survey::Survey;
use super::window::Window;
use crate::RefineError;
use crate::complex::angles::Angles;
use crate::complex::carrier::{Carrier, Corner};
use crate::complex::measure::circumcircle;
use crate::complex::plc::Plc;
use crate::heed::Heed;
use crate::table::{Map, Set, sides};
use ltbw_core::cavity::{Cavity, Setback};
use ltbw_core::mesh::{At, Mesh};
use ltbw_core::topology::{INFINITE, TetId, VertexId, tet_of};
use ltbw_core::transaction::{OpenCavity, Opens};
use ltbw_domain::vector::distance2;
use ltbw_exact::Point;
use std::sync::Arc;

/// Vertices of the face opposite each slot.
pub(crate) const FACE: [[usize; 3]; 4] = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];

/// Mesh, marks and tables.
#[derive(Debug)]
pub(crate) struct State {
    pub(crate) mesh: Mesh,
    pub(crate) plc: Arc<Plc>,
    pub(crate) angles: Arc<Angles>,
    pub(crate) marks: Marks,
    /// Where each kernel vertex lives; entry 0 is the vertex at infinity.
    pub(crate) carriers: Vec<Carrier>,
    /// Subsegments, with their segments.
    pub(crate) segments: Map<[VertexId; 2], u32>,
    /// Subfaces, with their facets.
    pub(crate) subfaces: Map<[VertexId; 3], u32>,
    /// Subfaces that the mesh does not have; none after the recovery.
    pub(crate) missing: Set<[VertexId; 3]>,
    /// Subsegments that the mesh does not have; none after the recovery.
    pub(crate) missing_segments: Set<[VertexId; 2]>,
    /// While the boundary is recovered: the subfaces at each edge of one.
    pub(crate) at_edge: Option<Map<[VertexId; 2], Vec<[VertexId; 3]>>>,
    pub(crate) encroachment: EncroachmentIndex,
    /// The changes of a joint step, while there is one.
    pub(crate) journal: Option<Journal>,
    /// The boundary in the open cavity.
    pub(crate) survey: Survey<TetId>,
    /// The tetrahedra for which memory was taken beforehand.
    pub(crate) expected: usize,
    /// Are lists of items in the order of their coordinates?
    pub(crate) by_place: bool,
    /// The fine step in the coordinates of the mesh.
    pub(crate) fine_step: f64,
    /// If this is a part of a mesh: which one.
    pub(crate) window: Option<Window>,
}

impl Opens for State {
    fn cavity(&self) -> &Cavity {
        self.mesh.cavity()
    }

    fn set_back(&mut self) {
        self.mesh.set_back();
    }
}

/// Where to insert a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) p: Point,
    pub(crate) carrier: Carrier,
    /// The start of the walk.
    pub(crate) from: TetId,
}

/// The lengths that a refinement knows from its start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lengths {
    /// Features nearer to each other are not refined towards each other: in steps of the grid.
    pub(crate) near: f64,
    /// The fine step in the coordinates of the mesh.
    pub(crate) fine_step: f64,
}

impl State {
    /// The state before anything of the boundary is entered.
    ///
    /// # Errors
    /// [`RefineError::Cancelled`].
    pub(crate) fn new(
        mesh: Mesh,
        plc: Plc,
        carriers: Vec<Carrier>,
        lengths: Lengths,
        heed: Heed<'_>,
    ) -> Result<Self, RefineError> {
        let Lengths { near, fine_step } = lengths;
        let angles = Angles::of(&plc, near, heed)?;
        Ok(Self::with(mesh, carriers, Arc::new(plc), Arc::new(angles), fine_step))
    }

    /// The state with these small angles before anything of the boundary is entered.
    pub(crate) fn with(
        mesh: Mesh,
        carriers: Vec<Carrier>,
        plc: Arc<Plc>,
        angles: Arc<Angles>,
        fine_step: f64,
    ) -> Self {
        Self {
            marks: Marks::new(mesh.topology().slots()),
            mesh,
            angles,
            plc,
            carriers,
            segments: Map::default(),
            subfaces: Map::default(),
            missing: Set::default(),
            missing_segments: Set::default(),
            at_edge: None,
            encroachment: EncroachmentIndex::default(),
            journal: None,
            survey: Survey::default(),
            by_place: false,
            expected: 0,
            fine_step,
            window: None,
        }
    }

    /// Takes memory for what comes with about this many tetrahedra. A hint.
    pub(crate) fn expect_tets(&mut self, tets: usize) {
        self.expected = tets;
        self.marks.expect(tets);
    }

    /// Finds the cavity of a place. In a window one with something around it that is not known is
    /// set back.
    pub(crate) fn begin(&mut self, place: &Place) -> Result<OpenCavity<'_, Self>, At> {
        self.mesh.begin_anywhere(place.p, place.from)?.end(|_| ());
        if let Some(t) = self.filling_in_closure() {
            self.set_back();
            return Err(At::SetBack(Setback::Refused(t)));
        }
        Ok(OpenCavity::new(self))
    }

    /// Opens the cavity of a place again, of which `tets` are what an earlier search has found,
    /// where only slots that are `changed` since then are looked at. Says whether all of the
    /// closure is as it was.
    pub(crate) fn begin_again(
        &mut self,
        place: &Place,
        tets: &[TetId],
        changed: &impl Fn(TetId) -> bool,
    ) -> Result<(OpenCavity<'_, Self>, bool), At> {
        let sorted = |cavity: &Cavity| {
            let mut tets: Vec<TetId> = cavity.tets().collect();
            tets.sort_unstable();
            tets
        };
        let mut found = Vec::new();
        if cfg!(debug_assertions) {
            let from = self.start_near(place.from);
            self.mesh.begin_anywhere(place.p, from)?.end(|_| ());
            found = sorted(self.mesh.cavity());
            self.set_back();
        }
        let again = self.mesh.reopen(&place.p, tets, changed).map_err(At::SetBack)?;
        let is_same = again.map(|(open, is_same)| open.end(|_| is_same));
        if is_same.is_none() {
            let from = self.start_near(place.from);
            self.mesh.begin_anywhere(place.p, from)?.end(|_| ());
        }
        debug_assert_eq!(sorted(self.mesh.cavity()), found, "a point has one cavity");
        Ok((OpenCavity::new(self), is_same == Some(true)))
    }

    /// Finds the cavity of a place, and looks at the boundary in it.
    pub(crate) fn begin_and_look(&mut self, place: &Place) -> Result<OpenCavity<'_, Self>, At> {
        let mut open = self.begin(place)?;
        open.owner_mut().look(place);
        Ok(open)
    }

    /// Asks the processor to fetch a tetrahedron that is about to be looked at, and its corners. A
    /// hint.
    #[inline(always)]
    pub(crate) fn fetch(&self, t: TetId, v: [VertexId; 4]) {
        self.mesh.prefetch(t);
        v.into_iter().for_each(|v| self.mesh.prefetch_point(v));
    }

    /// Where a walk starts that should start at slot `t`.
    pub(crate) fn start_near(&self, t: TetId) -> TetId {
        if self.mesh.topology().at(t).is_free() { self.mesh.hint() } else { t }
    }

    pub(crate) fn at(&self, v: VertexId) -> Point {
        self.mesh.kernel_point(v)
    }

    /// A vertex with where it lives.
    pub(crate) fn corner(&self, v: VertexId) -> Corner {
        Corner { point: self.at(v), carrier: self.carriers[v.index()] }
    }

    pub(crate) fn vertices(&self, t: TetId) -> [VertexId; 4] {
        self.mesh.topology().at(t).vertices()
    }

    /// The tetrahedra beyond the faces of one.
    #[inline(always)]
    pub(crate) fn neighbours(&self, t: TetId) -> [TetId; 4] {
        self.mesh.topology().at(t).neighbours().map(tet_of)
    }

    /// Is `t` still the tetrahedron with these vertices?
    pub(crate) fn is_live(&self, t: TetId, v: [VertexId; 4]) -> bool {
        t.index() < self.mesh.topology().slots() && self.vertices(t) == v
    }

    /// Does a vertex with this carrier lie on facet `f`?
    pub(crate) fn lies_on(&self, carrier: Carrier, f: u32) -> bool {
        self.plc.lies_on(carrier, f)
    }

    /// Is an input corner a vertex of a boundary item?
    pub(crate) fn has_corner(&self, item: Item, corner: u32) -> bool {
        has_corner(item, corner, |v| self.carriers[v.index()])
    }

    /// The ball of a boundary item, rounded.
    pub(crate) fn ball(&self, item: Item) -> (Point, f64) {
        match item {
            Item::Segment([a, b]) => {
                let (a, b) = (self.at(a), self.at(b));
                ([0, 1, 2].map(|k| (a[k] + b[k]) / 2.0), distance2(&a, &b).sqrt() / 2.0)
            }
            Item::Subface([a, b, c]) => {
                let (centre, square) = circumcircle(&self.at(a), &self.at(b), &self.at(c));
                (centre, square.sqrt())
            }
            Item::Tet(_, v) => (self.at(v[0]), 0.0),
        }
    }

    /// Enters a boundary item into the encroachment index; `false` if it is there already.
    pub(crate) fn enter(&mut self, item: Item) -> bool {
        let (centre, radius) = self.ball(item);
        let new = self.encroachment.enter(item, centre, radius);
        if let Some(journal) = self.journal.as_mut().filter(|_| new) {
            journal.entered.push(item);
        }
        new
    }

    /// Notes that the mesh does not have a boundary item, which has to be split.
    pub(crate) fn miss(&mut self, item: Item, work: &mut Queues) {
        let new = match item {
            Item::Segment(s) => self.missing_segments.insert(s),
            Item::Subface(s) => self.missing.insert(s),
            Item::Tet(..) => false,
        };
        // An item that others wait for may be in the encroachment index already.
        if new {
            self.enter(item);
            work.put(item, 1.0);
        }
    }

    /// Is all of the boundary in the mesh?
    pub(crate) fn is_complete(&self) -> bool {
        self.missing.is_empty() && self.missing_segments.is_empty()
    }

    /// Enters a subsegment of segment `s`.
    pub(crate) fn add_segment(&mut self, key: [VertexId; 2], s: u32) {
        let before = self.segments.insert(key, s);
        if let Some(journal) = &mut self.journal {
            journal.segments.push((key, before));
        }
    }

    /// Forgets a subsegment that was split.
    pub(crate) fn remove_segment(&mut self, key: [VertexId; 2]) {
        let before = self.segments.remove(&key);
        if let Some(journal) = &mut self.journal {
            journal.segments.push((key, before));
        }
        self.missing_segments.remove(&key);
        self.encroachment.remove(Item::Segment(key));
    }

    /// Enters a subface of facet `f`.
    pub(crate) fn add_subface(&mut self, key: [VertexId; 3], f: u32) {
        let before = self.subfaces.insert(key, f);
        if let Some(journal) = &mut self.journal {
            journal.subfaces.push((key, before));
        }
        if let Some(at_edge) = &mut self.at_edge {
            for (side, _) in sides(key) {
                at_edge.entry(side).or_default().push(key);
            }
        }
    }

    /// Forgets a subface that its facet's triangulation no longer has.
    pub(crate) fn remove_subface(&mut self, key: [VertexId; 3]) {
        let before = self.subfaces.remove(&key);
        if let Some(journal) = &mut self.journal {
            journal.subfaces.push((key, before));
        }
        self.missing.remove(&key);
        self.encroachment.remove(Item::Subface(key));
        if let Some(at_edge) = &mut self.at_edge {
            for (side, _) in sides(key) {
                if let Some(list) = at_edge.get_mut(&side) {
                    list.retain(|s| *s != key);
                }
            }
        }
    }

    /// The missing subfaces of facet `f` whose balls may hold `p`.
    pub(crate) fn missing_near(&self, f: u32, p: &Point) -> Vec<[VertexId; 3]> {
        if self.missing.is_empty() {
            return Vec::new();
        }
        let near = self.encroachment.near(p).filter_map(|item| match item {
            Item::Subface(s) => Some(s),
            _ => None,
        });
        near.filter(|s| self.missing.contains(s) && self.subfaces.get(s) == Some(&f)).collect()
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.mesh.memory_bytes()
            + self.marks.memory_bytes()
            + self.carriers.capacity() * size_of::<Carrier>()
    }
}

impl State {
    /// The vertices of the whole mesh.
    pub(crate) fn num_vertices(&self) -> usize {
        self.mesh.num_vertices() + self.window.as_ref().map_or(0, |own| own.elsewhere)
    }

    /// Is what a slot has filling?
    pub(crate) fn has_filling(&self, t: TetId) -> bool {
        self.window.as_ref().is_some_and(|own| own.has_filling(t))
    }

    /// The first tetrahedron of the open cavity or beside it that is filling, if this is a window;
    /// its vertices are noted then, and those of all these tetrahedra.
    pub(crate) fn filling_in_closure(&mut self) -> Option<TetId> {
        self.window.as_ref()?;
        let cavity: Vec<TetId> = self.mesh.cavity().tets().collect();
        self.filling_around(&cavity)
    }

    /// As [`State::filling_in_closure`], of some tetrahedra and those beside them.
    pub(crate) fn filling_around(&mut self, tets: &[TetId]) -> Option<TetId> {
        let window = self.window.as_ref()?;
        let beside = tets.iter().flat_map(|&t| self.neighbours(t));
        let all: Vec<TetId> = tets.iter().copied().chain(beside).collect();
        let found = all.iter().copied().find(|&t| window.has_filling(t))?;
        let corners = all.iter().flat_map(|&t| self.vertices(t)).filter(|&v| v != INFINITE);
        let corners: Vec<Point> = corners.map(|v| self.at(v)).collect();
        self.window.as_mut()?.missed.extend(corners);
        Some(found)
    }
}
