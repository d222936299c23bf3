//! The boundary of a domain, its bounds and the points that split things, as functions of values:
//! for engines whose mesh is on many processors.

use crate::RefineError;
use crate::complex::angles::Angles;
use crate::complex::carrier::{Carrier, free_point, within_box};
use crate::complex::measure::Shape;
use crate::complex::plc::Plc;
use crate::mesh::bounds::{Bounds, Solid};
use crate::mesh::item::Item;
use crate::mesh::key::{order_key, sorted, spot};
use crate::mesh::names::Names;
use crate::mesh::region::RegionInfo;
use crate::mesh::state::State;
use crate::outcome::Reason;
use crate::rules::aim::{Aim, Aims};
use crate::rules::choice::{BoundaryItem, Corner};
use crate::rules::group::Group;
use crate::rules::strategy::{Order, Strategy};
use ltbw_core::Random;
use ltbw_core::mesh::{Mesh, Vertex};
use ltbw_core::topology::{FaceId, INFINITE, MAX_TETS, Tet, TetId, VertexId, slot_of, tet_of};
use ltbw_exact::{Mode, Point};
use std::sync::Arc;

/// Why a domain cannot be refined by engines on many processors.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ComplexError {
    /// There is no mesh to start with.
    #[error(transparent)]
    Refine(#[from] RefineError),
    /// Its mesh is in a state that only one processor deals with.
    #[error("{0}")]
    Unsupported(&'static str),
}

/// The vertices of the face opposite a slot, ascending.
fn corners_but(tet: &Tet, slot: usize) -> [VertexId; 4] {
    let mut v = tet.vertices();
    v[slot] = INFINITE;
    v.sort_unstable();
    v
}

/// A mesh to start with, all subsegments and subfaces in it.
#[doc(hidden)]
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Start {
    /// The coordinates of a vertex of the mesh, as [`Mode::from_kernel`] makes them of those here.
    pub mode: Mode,
    /// The vertices, by number less 1.
    pub points: Vec<Point>,
    /// Where they live.
    pub carriers: Vec<Carrier>,
    /// All slots of the mesh, free ones, exterior and hull included.
    pub tets: Vec<Tet>,
    /// The regions of finite tetrahedra, by slot.
    pub labels: Vec<u32>,
    /// The regions, the exterior first.
    pub regions: Vec<RegionInfo>,
    /// The most points to insert.
    pub most: u64,
    /// The number of tetrahedra for which memory may be taken beforehand; 0 if nobody can tell.
    pub expected: usize,
}

/// The boundary of a domain and the bounds of its mesh.
#[doc(hidden)]
pub struct Complex<'a> {
    plc: Arc<Plc>,
    angles: Arc<Angles>,
    bounds: Bounds<'a>,
    pub(crate) floor: f64,
    /// The most transactions of a joint step, if they are fewer than usual.
    pub(crate) joint_most: usize,
    pub(crate) strategy: Strategy,
    names: Names,
    has_patches: bool,
}

impl std::fmt::Debug for Complex<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Complex").field("facets", &self.plc.facets.len()).finish_non_exhaustive()
    }
}

/// The most features of a closure that are looked at in pairs.
const MOST_FEATURES: usize = 64;
/// The most places in a tetrahedron that tell where its parts will be.
const MOST: f64 = 64.0;

impl Start {
    /// The number of tetrahedra for which one of some workers may take memory beforehand.
    pub fn expected_of(&self, workers: u32) -> usize {
        // Parts are of equal work, which is not quite an equal number of tetrahedra.
        self.expected / workers.max(1) as usize / 4 * 5
    }

    /// The points inserted so far.
    pub fn made(&self) -> u64 {
        let is_made = |carrier: &&Carrier| !matches!(carrier, Carrier::Corner(_));
        self.carriers.iter().filter(is_made).count() as u64
    }

    /// Does it fit together? One that comes from elsewhere may not.
    pub fn fits(&self) -> bool {
        let (slots, vertices) = (self.tets.len(), self.points.len());
        let fits = |(t, tet): (usize, &Tet)| {
            let [a, b, c, d] = tet.vertices().map(VertexId::index);
            let are_finite = [a, b, c].iter().all(|v| (1..=vertices).contains(v));
            let leads_back = |(slot, &face): (usize, &FaceId)| {
                let (n, back) = (tet_of(face), slot_of(face));
                let there = self.tets.get(n.index()).filter(|own| !own.is_free() && n.index() != t);
                there.is_some_and(|there| {
                    there.neighbours()[back] == FaceId::new(TetId::at(t), slot)
                        && corners_but(there, back) == corners_but(tet, slot)
                })
            };
            let leads_somewhere = || tet.neighbours().iter().enumerate().all(leads_back);
            match tet.is_free() {
                true => tet.is_ghost(),
                false => are_finite && d <= vertices && leads_somewhere(),
            }
        };
        let is_whole = self.labels.len() == slots && self.carriers.len() == vertices;
        is_whole && slots <= MAX_TETS && self.tets.iter().enumerate().all(fits)
    }

    /// The finite tetrahedra, exterior included: the vertices, from 0 on and ascending, and the
    /// region.
    pub fn finite(&self) -> impl Iterator<Item = ([u32; 4], u32)> + '_ {
        let all = self.tets.iter().zip(&self.labels).filter(|(tet, _)| !tet.is_ghost());
        all.map(|(tet, &region)| {
            let mut v = tet.vertices().map(|v| v.number() - 1);
            v.sort_unstable();
            (v, region)
        })
    }

    /// About `places` places inside the domain, at least one in each tetrahedron, with the numbers
    /// of tetrahedra that there will be around them, as far as these can be told: for the balance
    /// of work.
    pub fn weights(&self, complex: &Complex<'_>, places: usize) -> Vec<(Point, u64)> {
        let mut random = Random::new(1);
        let mut weights = Vec::new();
        let corners_of = |v: [u32; 4]| v.map(|v| self.points[v as usize]);
        let predict = |(v, region)| complex.predicted(corners_of(v), region);
        let all: Vec<f64> = self.finite().map(predict).collect();
        let part = (places as f64 / all.iter().sum::<f64>().max(1.0)).min(1.0);
        for ((v, _), own) in self.finite().zip(all) {
            let corners = corners_of(v);
            let count = (own * part).ceil().min(MOST);
            let weight = (own / count.max(1.0) * 256.0) as u64;
            for _ in 0..count as usize {
                // The parts of an interval that three points cut.
                let mut cuts = [random.unit(), random.unit(), random.unit()];
                cuts.sort_unstable_by(f64::total_cmp);
                let [a, b, c] = cuts;
                let parts = [a, b - a, c - b, 1.0 - c];
                let sum = |k: usize| (0..4).map(|v| parts[v] * corners[v][k]).sum();
                weights.push(([0, 1, 2].map(sum), weight));
            }
        }
        weights
    }

    /// This one with another mesh: where its vertices live, by number, and the regions of its
    /// finite tetrahedra.
    pub fn with_mesh(
        self,
        mesh: &Mesh,
        carrier: impl Fn(Vertex) -> Carrier,
        region: impl Fn(TetId) -> u32,
    ) -> Self {
        let vertices = || (1..=mesh.num_vertices()).map(VertexId::at);
        let slots = || TetId::below(mesh.topology().slots() as u32);
        let lives = |v: VertexId| mesh.number(v).map_or(Carrier::Free, &carrier);
        Self {
            points: vertices().map(|v| mesh.kernel_point(v)).collect(),
            carriers: vertices().map(lives).collect(),
            tets: slots().map(|t| *mesh.topology().at(t)).collect(),
            labels: slots().map(region).collect(),
            ..self
        }
    }

    pub(crate) fn of(state: &State, regions: Vec<RegionInfo>, most: u64) -> Self {
        let mesh = &state.mesh;
        let slots = || TetId::below(mesh.topology().slots() as u32);
        let all = (1..=mesh.num_vertices()).map(|v| mesh.kernel_point(VertexId::at(v)));
        Self {
            mode: mesh.mode(),
            points: all.collect(),
            carriers: state.carriers[1..].to_vec(),
            tets: slots().map(|t| *mesh.topology().at(t)).collect(),
            labels: slots().map(|t| state.marks.region(t)).collect(),
            regions,
            // Points that the domain says count as made.
            most: most.saturating_add(state.plc.points.len() as u64),
            expected: state.expected,
        }
    }
}

impl<'a> Complex<'a> {
    pub(crate) fn of(state: &State, bounds: Bounds<'a>, floor: f64, joint_most: usize) -> Self {
        let (plc, angles) = (Arc::clone(&state.plc), Arc::clone(&state.angles));
        let (has_patches, names) = (plc.has_patches(), Names::of(state));
        let strategy = Strategy::default();
        Self { plc, angles, bounds, floor, joint_most, strategy, names, has_patches }
    }

    /// The state of a part of the mesh with this boundary, of which nothing is entered.
    pub(crate) fn state(&self, mesh: Mesh, carriers: Vec<Carrier>) -> State {
        let (plc, angles) = (Arc::clone(&self.plc), Arc::clone(&self.angles));
        State::with(mesh, carriers, plc, angles, self.bounds.fine_step)
    }

    pub(crate) fn angles(&self) -> &Angles {
        &self.angles
    }

    /// Are there small angles, or features near each other? Then the corners of all of a closure
    /// count.
    pub fn has_angles(&self) -> bool {
        self.angles.matter()
    }

    /// Are angles to be counted before slivers are split?
    pub fn counts_angles(&self) -> bool {
        self.bounds.count_angles
    }

    /// Is splitting a tetrahedron of a region no help, which is over its bounds?
    pub fn is_beyond_help(&self, corners: [Corner; 4], region: u32) -> bool {
        if self.angles.is_empty() {
            return false;
        }
        let of = |ends: [usize; 2]| self.segment(ends.map(|k| corners[k].carrier));
        let points = corners.each_ref().map(|own| &own.point);
        let is_sharp = self.angles.beyond_help(&self.plc, &corners, of, &self.bounds).is_some();
        is_sharp && !self.bounds.is_large_in(points, region)
    }

    /// The small angle that a tetrahedron is at, or that it is at none.
    pub fn reason_near(&self, mut corners: [Corner; 4]) -> Reason {
        corners.sort_by_key(|own| order_key(&own.point));
        self.angles.reason_near(&self.plc, corners.map(|own| own.carrier))
    }

    /// The reason why a boundary item cannot be split for which no aim is left.
    pub fn reason_without_aim(&self, item: &BoundaryItem) -> Reason {
        let facet = || self.angles.reason_of_facet(item.of());
        let named = if item.is_segment() { None } else { facet() };
        named.unwrap_or_else(|| self.unserved_at(item))
    }

    /// The reason that no point splits a boundary item.
    fn unserved_at(&self, item: &BoundaryItem) -> Reason {
        let number = |k: u32| VertexId::new(k + 1);
        let all = match item.is_segment() {
            true => Item::Segment([0, 1].map(number)),
            false => Item::Subface([0, 1, 2].map(number)),
        };
        self.unserved(all, |v| item.corners()[v.index() - 1].point)
    }

    /// The reason that no point splits a boundary item.
    pub(crate) fn unserved(&self, item: Item, at: impl Fn(VertexId) -> Point) -> Reason {
        Reason::Unserved { at: spot(item, at, self.bounds.fine_step) }
    }

    /// The segment that an edge of the mesh between two vertices is on, if it is a subsegment.
    pub fn segment(&self, ends: [Carrier; 2]) -> Option<u32> {
        self.names.segment(&self.plc, ends)
    }

    /// The facet that a triangle of the mesh is on, if it is a subface, but not of a patch.
    pub fn facet(&self, corners: [Corner; 3]) -> Option<u32> {
        self.names.facet(&self.plc, corners)
    }

    /// The patch of which a face of a tetrahedron is a subface, which is opposite a slot; `labels`
    /// tells the regions of the tetrahedron and of the one beyond.
    pub(crate) fn patch(
        &self,
        corners: [Corner; 3],
        slot: usize,
        labels: impl FnOnce() -> Option<[u32; 2]>,
    ) -> Option<u32> {
        let is_on = self.has_patches && corners.iter().all(|own| own.carrier != Carrier::Free);
        if is_on { self.plc.patch_at(corners, slot, labels()?) } else { None }
    }

    /// Are some features at a small angle, or too near to each other, on which vertices live that
    /// are in one closure? Then limits tell what may be split.
    pub fn are_related(&self, carriers: &[Carrier]) -> bool {
        if !self.angles.relates() {
            return false;
        }
        let (mut facets, mut segments) = (Vec::new(), Vec::new());
        for carrier in carriers {
            facets.extend_from_slice(self.plc.facets_of(carrier));
            match *carrier {
                Carrier::Segment(s, _) => segments.push(s),
                Carrier::Corner(c) => segments.extend_from_slice(&self.plc.segments_at[c as usize]),
                Carrier::Facet(_) | Carrier::Free => {}
            }
        }
        for list in [&mut facets, &mut segments] {
            list.sort_unstable();
            list.dedup();
        }
        let has = |corner: u32| carriers.contains(&Carrier::Corner(corner));
        // Where so much meets, something is related.
        facets.len() + segments.len() > MOST_FEATURES
            || self.angles.are_related(&segments, &facets, &has)
    }

    /// May a tetrahedron, of whose corners some live there, have a subface of a patch? Then labels
    /// tell whether it has.
    pub fn is_at_patch(&self, carriers: &[Carrier]) -> bool {
        let on =
            |f: &u32| carriers.iter().filter(|own| self.plc.facets_of(own).contains(f)).count();
        // Of four corners at least three are on it then, so one of any two.
        let mut facets = carriers.iter().skip(2).flat_map(|own| self.plc.facets_of(own));
        self.has_patches && facets.any(|f| self.plc.is_patch(*f) && on(f) >= 3)
    }

    /// Are all four corners of a finite tetrahedron, which live there, on one patch? Then it is
    /// over no bound.
    pub fn is_flat(&self, carrier: impl Fn(usize) -> Carrier) -> bool {
        self.has_patches && self.plc.is_flat(carrier)
    }

    /// The group of the circumsphere of a tetrahedron, if it has one.
    pub fn group_of(&self, corners: [Point; 4]) -> Option<Group> {
        let corners = sorted(corners);
        let [a, b, c, d] = &corners;
        let shape = Shape::of([a, b, c, d]);
        shape.circumcentre(d).map(|centre| Group::of(&centre, shape.radius()))
    }

    /// Is a facet a patch?
    pub fn is_patch(&self, facet: u32) -> bool {
        self.has_patches && self.plc.is_patch(facet)
    }

    /// Has the domain patches? Then regions tell of the boundary.
    pub fn has_patches(&self) -> bool {
        self.has_patches
    }

    /// Is a tetrahedron of a region over its bounds? Its vertices are positively oriented.
    pub fn is_over(&self, corners: [&Point; 4], region: u32) -> bool {
        region != 0 && self.bounds.are_over(corners, region)
    }

    /// Which of some tetrahedra of the domain, given with their corners and regions, are over their
    /// bounds, in their order. `thin` is told of those that may have tiny dihedral angles.
    pub fn over_among<'b>(
        &'b self,
        tets: impl Iterator<Item = Solid<TetId>> + 'b,
        thin: impl FnMut(TetId) + 'b,
    ) -> impl Iterator<Item = TetId> + 'b {
        self.bounds.over_among(tets, thin)
    }

    pub(crate) fn plc(&self) -> &Plc {
        &self.plc
    }

    pub(crate) fn bounds(&self) -> &Bounds<'a> {
        &self.bounds
    }

    /// The ground of aims.
    pub(crate) fn aims(&self) -> Aims<'_> {
        Aims { plc: &self.plc, floor: self.floor }
    }

    /// The order in which tetrahedra are taken where there are no rounds.
    pub fn order(&self) -> Order {
        self.strategy.order
    }

    /// The circumradius of a tetrahedron, rounded.
    pub fn radius(&self, corners: [&Point; 4]) -> f64 {
        Shape::of(corners).radius()
    }

    /// The point that splits a tetrahedron, at the given attempt, and `true`. Of one that is nearly
    /// flat the centre may be outside the box: then a point on the way there, where whatever bars
    /// the way can be found, and no point may be inserted.
    pub fn point_of_tet(&self, corners: [&Point; 4], attempt: usize) -> Option<(Point, bool)> {
        let shape = Shape::of(corners);
        let place = self.strategy.place(&shape, corners);
        let aim = self.aims().tet(shape.radius(), place, attempt);
        let Aim::At { point, may, .. } = aim else { return None };
        if may {
            return Some((point, true));
        }
        let sum = |k: usize| sorted(corners.map(|p| *p)).iter().map(|p| p[k] * 0.25).sum();
        let target = within_box(&[0, 1, 2].map(sum), &point);
        free_point(&target, 1.0).map(|p| (p, false))
    }
}
