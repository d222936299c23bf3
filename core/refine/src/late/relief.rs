//! Relief: when nothing else is left to do, a point is looked for with which fewer tetrahedra are
//! over their bounds.
//!
//! At a small angle the circumcentre of a tetrahedron is kept away by boundary items that may not
//! be split. Other points in its ball may serve: nearer to its shortest edge, anywhere else in the
//! ball, or on the boundary beside it. One is inserted if fewer of its tetrahedra are over a bound
//! than it takes out of the mesh, where those with tiny dihedral angles count twice, and it takes
//! no other boundary item out. So there are at most twice as many points as tetrahedra were over
//! their bounds.
//!
//! Items do not keep points out of their balls here: those balls are large at small angles.
//! Tetrahedra are taken in the order of their coordinates, so that the mesh is a function of that
//! before.
//!
//! Afterwards the same is done for tetrahedra with tiny dihedral angles, the points being those
//! with which there are fewer such, and no more over their bounds than before. Most are under a
//! shallow fold between four vertices on one circle, with both its triangles for sides: any point
//! in the ball and below the fold divides them, but lies in the balls of these triangles.
//!
//! Nearly all points are refused. So a cavity is looked for on the mesh as it is, and opened if the
//! point makes fewer of what it is for; and of the tetrahedra that points of one target take out of
//! the mesh each is judged once.

use crate::complex::carrier::{Carrier, free_point};
use crate::complex::dihedral::{DihedralBound, TINY};
use crate::complex::measure::Shape;
use crate::mesh::bounds::Bounds;
use crate::mesh::item::{Item, Queues};
use crate::mesh::key::sorted;
use crate::mesh::state::{Place, State};
use crate::mesh::survey::Survey;
use crate::queue::split::Refinement;
use crate::rules::aim::TOLERANCE;
use crate::rules::beside::{OnItem, in_unit_ball};
use crate::rules::bounded::InMesh;
use crate::rules::record::Refusal;
use crate::rules::star::{Made, star};
use crate::rules::verdict::Judge;
use crate::rules::walk::Way;
use crate::table::{Map, Set};
use ltbw_core::search::Search;
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_domain::vector::distance2;
use ltbw_exact::Point;

/// The most times that all tetrahedra over their bounds are looked at, each time with other points.
const PASSES: u64 = 8;
/// Points tried for a tetrahedron in its ball, besides those towards its shortest edge.
const INSIDE: usize = 32;
/// Points tried for the sake of angles.
const INSIDE_FOR_ANGLES: usize = 64;
/// Points tried on each boundary item beside it.
const BESIDE: usize = 8;
/// Where they are tried on the way from the middle of the shortest edge to the circumcentre: parts
/// of the way, and of the distance at which a triangle with the edge meets the bound.
const WAY: [(f64, bool); 6] =
    [(1.0, false), (0.9, true), (0.5, true), (0.25, true), (0.5, false), (0.75, false)];
/// A new tetrahedron may miss the bound of shape by this factor, or by that of the worst that goes.
const WORST: f64 = 32.0;
/// Tetrahedra of cavities looked for: for each tetrahedron of the mesh, and in addition.
const OPENED: usize = 24;
const OPENED_MORE: usize = 1 << 19;

/// The tetrahedra of which a point is to leave fewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Goal {
    /// Tetrahedra over their bounds.
    Bounds,
    /// Tetrahedra with tiny dihedral angles, and none of those over their bounds more.
    Angles,
}

impl Goal {
    /// Points tried in the ball.
    fn inside(self) -> usize {
        match self {
            Self::Bounds => INSIDE,
            Self::Angles => INSIDE_FOR_ANGLES,
        }
    }
}

/// A tetrahedron to be relieved.
struct Target {
    t: TetId,
    goal: Goal,
    refusal: Refusal,
    radius: f64,
    /// May a point encroach items that are not refused? In a collar all is left as it is.
    may_encroach: bool,
}

/// Passes over the tetrahedra of which a goal asks for fewer, while they become fewer.
pub(crate) struct Relief {
    goal: Goal,
    pass: u64,
    /// The tetrahedra of this pass that were not looked at yet.
    tets: std::vec::IntoIter<(TetId, [VertexId; 4])>,
    /// The number of those of this pass.
    least: usize,
    /// Has this pass inserted a point?
    is_changed: bool,
    tries: Tries,
    /// Tetrahedra for which an earlier relief found no point.
    in_vain: Set<Item>,
}

/// The memory of points that are tried.
#[derive(Default)]
struct Tries {
    /// Tetrahedra of cavities that may still be looked for.
    left: usize,
    /// The cavity of the last point.
    search: Search,
    survey: Survey<TetId>,
    /// Tetrahedra that points of this target would take out of the mesh.
    gone: Map<TetId, Gone>,
}

/// The counts of a tetrahedron that a point would take out of the mesh.
#[derive(Clone, Copy, Default)]
struct Gone {
    is_over: bool,
    is_thin: bool,
    /// Its ratio over the bound, if it is over its bounds.
    ratio: f64,
}

impl Relief {
    pub(crate) fn new(goal: Goal, refinement: &Refinement<'_>) -> Self {
        let left = OPENED * refinement.state.mesh.num_tets() + OPENED_MORE;
        let tets = Vec::new().into_iter();
        let in_vain = match goal {
            Goal::Bounds => refinement.record.in_vain.clone(),
            Goal::Angles => Set::default(),
        };
        let tries = Tries { left, ..Tries::default() };
        Self { goal, pass: 0, tets, least: usize::MAX, is_changed: true, tries, in_vain }
    }

    /// Looks for a point that relieves the next tetrahedron, and inserts it; is there one? `None`
    /// if nothing is left to do.
    pub(crate) fn next(&mut self, refinement: &mut Refinement<'_>) -> Option<bool> {
        if self.tets.len() == 0 {
            self.begin_pass(refinement);
        }
        let (t, v) = self.tets.next().filter(|_| self.tries.left > 0)?;
        let is_relieved = refinement.relieve_tet(t, v, self.goal, self.pass, &mut self.tries);
        refinement.state.mesh.add_stats(std::mem::take(&mut self.tries.search.stats));
        self.is_changed |= is_relieved;
        if !is_relieved && self.goal == Goal::Bounds {
            refinement.record.in_vain.insert(Item::Tet(t, v));
        }
        Some(is_relieved)
    }

    /// Finds the tetrahedra of the next pass: none after one that has not made them fewer.
    fn begin_pass(&mut self, refinement: &mut Refinement<'_>) {
        if self.pass == PASSES || !self.is_changed {
            return;
        }
        let mut all = match self.goal {
            Goal::Bounds => refinement.refused_tets(),
            Goal::Angles => refinement.slivers(),
        };
        all.retain(|&(t, v)| !self.in_vain.contains(&Item::Tet(t, v)));
        if all.len() < self.least {
            (self.least, self.is_changed) = (all.len(), false);
            self.pass += 1;
            self.tets = all.into_iter();
        }
    }
}

impl Refinement<'_> {
    /// The tetrahedra over their bounds, in the order of their coordinates. All were refused.
    fn refused_tets(&self) -> Vec<(TetId, [VertexId; 4])> {
        let Some(bounds) = self.bounds.as_ref().filter(|bounds| bounds.ratio.is_some()) else {
            return Vec::new();
        };
        let mut all: Vec<_> = self.record.refused_over(bounds, &self.state).collect();
        all.sort_by_cached_key(|&(t, v)| self.state.place_of(Item::Tet(t, v)));
        all
    }

    /// Looks for a point that relieves tetrahedron `t`, in its ball, then on the boundary, and
    /// inserts it; is there one?
    fn relieve_tet(
        &mut self,
        t: TetId,
        v: [VertexId; 4],
        goal: Goal,
        pass: u64,
        tries: &mut Tries,
    ) -> bool {
        // Another point may have taken it out of the mesh, and its slot may have another one.
        if !self.state.is_live(t, v) {
            return false;
        }
        let refusal = self.record.refused.get(&Item::Tet(t, v)).copied();
        let refusal = match goal {
            Goal::Bounds => refusal,
            Goal::Angles => refusal.or_else(|| Some(Refusal::final_for(self.state.reason_near(v)))),
        };
        let Some(refusal) = refusal else { return false };
        let corners = sorted(v.map(|v| self.state.at(v)));
        let [a, b, c, d] = &corners;
        let shape = Shape::of([a, b, c, d]);
        let Some(centre) = shape.circumcentre(d) else { return false };
        let Some(bound) = self.bounds.as_ref().and_then(|bounds| bounds.ratio) else {
            return false;
        };
        let in_collar = || self.state.collar(v, bound.value()).is_some();
        let may_encroach = goal == Goal::Angles || !in_collar();
        let target = Target { t, goal, refusal, radius: shape.radius(), may_encroach };
        tries.gone.clear();
        let tolerance = target.radius * TOLERANCE;
        let mut seed = pass;
        let way = towards(&corners, &centre, bound.value());
        for k in 0..WAY.len() + goal.inside() {
            let aim = way.get(k).copied().unwrap_or_else(|| {
                let offset = in_unit_ball(&mut seed);
                [0, 1, 2].map(|k| centre[k] + target.radius * offset[k])
            });
            let Some(p) = free_point(&aim, tolerance) else { continue };
            let Way::Arrived(from) = self.state.way(t, &p) else { continue };
            let place = Place { p, carrier: Carrier::Free, from };
            if self.try_relief(&target, None, &place, tries) {
                return true;
            }
        }
        for item in self.state.beside(t, free_point(&centre, tolerance)) {
            let Some(own) = self.state.boundary_item(item) else { continue };
            for k in 0..BESIDE {
                let place = self.state.plc.place_beside(&own, k, &mut seed, tolerance);
                let Some(OnItem { point, carrier }) = place else { continue };
                let place = Place { p: point, carrier, from: t };
                if self.try_relief(&target, Some(item), &place, tries) {
                    return true;
                }
            }
        }
        false
    }

    /// Inserts a point, on boundary item `item` if there is one, if it relieves its target.
    fn try_relief(
        &mut self,
        target: &Target,
        item: Option<Item>,
        place: &Place,
        tries: &mut Tries,
    ) -> bool {
        let Some(bounds) = self.bounds.as_ref().filter(|_| tries.left > 0) else { return false };
        let Some(before) = self.state.relieves(target, place, bounds, tries) else { return false };
        let Tries { search, survey, .. } = tries;
        let closure = InMesh::found(&self.state, search);
        survey.look(&closure, &place.p, place.carrier);
        let judge = Judge::new(closure, survey, &self.record);
        let may = |hit: &Item| target.may_encroach || self.record.refused.contains_key(hit);
        let Some(filling) = judge.filling_beside(item, place, may) else { return false };
        if target.goal == Goal::Angles {
            // Now it is known what dust the point makes, too.
            let after = Tally::of(star(&closure, place, &filling.changes), bounds);
            if !after.is_better(&before, target.goal) {
                return false;
            }
        }
        let mut refusal = target.refusal;
        if refusal.reason.is_vague() {
            // A reason that has a place, of what was over its bounds there before, says more.
            let item = |&t: &TetId| Item::Tet(t, self.state.vertices(t));
            let refused = search.tets().iter().filter_map(|t| self.record.refused.get(&item(t)));
            let named = refused.map(|r| r.reason).filter(|r| r.is_corner() || r.is_segment());
            refusal.reason = named.min().unwrap_or(refusal.reason);
        }
        // The mesh may be full.
        let Ok(open) = self.state.begin(place) else { return false };
        let mut work = Queues::default();
        self.inserted.fill(open, place, &filling, Some(bounds), &mut work);
        debug_assert!(self.state.is_complete(), "nothing may be lost");
        while let Some(item) = work.next_tet() {
            self.record.refused.insert(item, refusal);
        }
        true
    }
}

/// Numbers of tetrahedra: over their bounds, and with small dihedral angles.
#[derive(Default)]
struct Tally {
    over: usize,
    thin: usize,
}

impl Tally {
    /// The numbers of a star.
    fn of(star: impl Iterator<Item = Made>, bounds: &Bounds<'_>) -> Self {
        let mut all = Self::default();
        for Made { corners, region } in star {
            let is_thin = |own: DihedralBound| own.is_missed(corners.each_ref());
            all.over += usize::from(bounds.are_over(corners.each_ref(), region));
            all.thin += usize::from(bounds.dihedral.is_some_and(is_thin));
        }
        all
    }

    /// Is this less than `before`?
    fn is_better(&self, before: &Self, goal: Goal) -> bool {
        match goal {
            Goal::Bounds => self.over + self.thin < before.over + before.thin,
            Goal::Angles => self.over <= before.over && self.thin < before.thin,
        }
    }
}

/// Points between the middle of a tetrahedron's shortest edge and its circumcentre.
fn towards(corners: &[Point; 4], centre: &Point, bound: f64) -> [Point; WAY.len()] {
    let pairs = (1..4).flat_map(|i| (0..i).map(move |j| [corners[i], corners[j]]));
    let length2 = |[a, b]: &[Point; 2]| distance2(a, b);
    let shortest = pairs.min_by(|x, y| length2(x).total_cmp(&length2(y)));
    let [a, b] = shortest.unwrap_or([corners[0], corners[1]]);
    let middle = [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
    let height = distance2(&middle, centre).sqrt();
    let enough = distance2(&a, &b).sqrt() * (bound + (bound * bound - 0.25).max(0.0).sqrt());
    let part = if enough < height { enough / height } else { 1.0 };
    WAY.map(|(share, is_off)| {
        let share = if is_off { share * part } else { share };
        [0, 1, 2].map(|k| middle[k] + share * (centre[k] - middle[k]))
    })
}

impl State {
    /// The numbers of a place's cavity, if it has the target, and the point makes fewer of what the
    /// target asks for, none of which is far worse. For the sake of bounds those over their bounds
    /// count, and once more those with tiny angles of these before, of all afterwards.
    fn relieves(
        &self,
        target: &Target,
        place: &Place,
        bounds: &Bounds<'_>,
        tries: &mut Tries,
    ) -> Option<Tally> {
        // A search begins in a tetrahedron that the point takes out of the mesh.
        let mut from = target.t;
        if !self.mesh.in_conflict(from, &place.p) {
            from = self.holder(from, &place.p)?;
        }
        let mut corners = self.vertices(from).into_iter().filter(|&v| v != INFINITE);
        if corners.any(|v| self.at(v) == place.p) {
            return None;
        }
        let Tries { left, search, gone, .. } = tries;
        search.find(&self.mesh, &place.p, from, |_| false);
        *left = left.saturating_sub(search.tets().len());
        if from != target.t && !search.has(target.t) {
            return None;
        }
        let thin = match target.goal {
            Goal::Bounds => TINY,
            Goal::Angles => bounds.dihedral?,
        };
        let (mut before, mut worst) = (Tally::default(), WORST);
        for &t in search.tets() {
            let own = gone.entry(t).or_insert_with(|| self.gone(t, target.goal, thin, bounds));
            before.over += usize::from(own.is_over);
            before.thin += usize::from(own.is_thin);
            worst = worst.max(own.ratio);
        }
        let is_better = |after: &Tally| after.is_better(&before, target.goal);
        let closure = InMesh::found(self, search);
        let (mut made, mut after) = (Vec::new(), Tally::default());
        // Bounds come first, which are told fast: nearly all points are refused by these.
        for own in closure.likely_star(target.t, place) {
            let is_over = bounds.are_over(own.corners.each_ref(), own.region);
            after.over += usize::from(is_over);
            if !is_better(&after) {
                return None;
            }
            made.push((own.corners, is_over));
        }
        for (corners, _) in &made {
            after.thin += usize::from(thin.is_missed(corners.each_ref()));
            if !is_better(&after) {
                return None;
            }
        }
        let ratio = bounds.ratio?;
        let is_worse = |&(corners, is_over): &([Point; 4], bool)| {
            is_over && Shape::of(sorted(corners).each_ref()).ratio_over(&ratio) > worst
        };
        (!made.iter().any(is_worse) && is_better(&after)).then_some(before)
    }

    /// The counts of a tetrahedron that goes. For the sake of bounds one that keeps its own counts
    /// nothing.
    fn gone(&self, t: TetId, goal: Goal, thin: DihedralBound, bounds: &Bounds<'_>) -> Gone {
        let v = self.vertices(t);
        if v[3] == INFINITE || self.marks.region(t) == 0 {
            return Gone::default();
        }
        let is_over = bounds.is_over(self, t);
        if !is_over && goal == Goal::Bounds {
            return Gone::default();
        }
        // Angles and ratios are rounded, in an order that is not that of the slots.
        let [a, b, c, d] = sorted(v.map(|v| self.at(v)));
        let counts = goal == Goal::Angles || !self.is_flat(v);
        let is_thin = counts && thin.is_missed([&a, &b, &c, &d]);
        let ratio = bounds.ratio.filter(|_| is_over);
        let ratio = ratio.map_or(0.0, |bound| Shape::of([&a, &b, &c, &d]).ratio_over(&bound));
        Gone { is_over, is_thin, ratio }
    }
}
