//! Circles: boundary items that wait for each other, when no other is left to be tried. One worker,
//! the conductor, is told of all that wait. It is lent all tetrahedra at vertices near the circles,
//! and splits these as the engine does, on a mesh of the vertices lent; if that comes to look at a
//! tetrahedron that is nobody's, it asks for what lies around. Then all are told the points, which
//! the protocol inserts, what becomes of the items, and the regions of the new tetrahedra.

use super::borrowed::{Circles, ball_around};
use super::candidate::ChosenPoint;
use super::contest::CONDUCTOR;
use super::source::{Rounds, Stage};
use crate::mesh::{WireVertex, made};
use crate::protocol::{Rules, WorkerId};
use crate::refining::domain::{DomainMesh, DomainPoint};
use crate::refining::flags::Flags;
use crate::refining::news::{
    Ball, Bits, DomainNews, WireAsked, WireCorner, WireItemRefusal, WireLent, WirePart, WireParted,
    WirePoint, WireRefusal, bits, point,
};
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_exact::Point;
use ltbw_refine::{Asked, NOWHERE, Parting, TetPlace, Waits, circles_among};
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeSet;

/// The times that the conductor asks for more before the engine splits the circles.
const MOST_LOANS: u32 = 64;

impl<C: Rules> Rounds<C> {
    /// All items that are left wait for each other: tells the conductor of those kept here.
    pub(super) fn enter_circles(&mut self) {
        self.stage = Stage::Parting;
        self.circles.given.clear();
        let left = self.demands.pending.values();
        let left = left.map(|own| Asked { item: own.item, first: own.first, limit: own.limit });
        let all = left.map(|own| WireAsked::new(&own)).collect();
        self.send(CONDUCTOR, DomainNews::Waiting(all));
    }

    /// The conductor hears of items that wait.
    pub(super) fn take_waiting(&mut self, all: &[WireAsked]) {
        let workers = self.workers;
        let own = &mut self.circles;
        if own.awaited == 0 {
            own.awaited = workers;
        }
        own.awaited = own.awaited.saturating_sub(1);
        own.asked.extend(all.iter().map(WireAsked::asked));
        if own.awaited == 0 {
            let circles = circles_among(&own.asked);
            let balls = circles.iter().flatten().map(ball_around).collect();
            self.borrow(balls);
        }
    }

    /// The conductor asks all for what lies in some balls.
    fn borrow(&mut self, balls: Vec<Ball>) {
        self.circles.awaited = self.workers;
        self.circles.loans += 1;
        self.circles.balls.extend(&balls);
        for to in (0..self.workers).map(WorkerId::new) {
            self.send(to, DomainNews::Lend(balls.clone()));
        }
    }

    /// Lends the conductor all tetrahedra at vertices in some balls that it has not yet.
    pub(super) fn lend(&mut self, mesh: &mut DomainMesh<'_>, balls: &[Ball]) {
        let spots: FxHashSet<Bits> = balls.iter().filter_map(Ball::spot).collect();
        let balls: Vec<&Ball> = balls.iter().filter(|ball| ball.spot().is_none()).collect();
        let mut near = Flags::default();
        for v in (1..=mesh.inner.num_vertices()).map(VertexId::at) {
            let p = mesh.point(v);
            if spots.contains(&bits(&p)) || balls.iter().any(|ball| ball.has(&p)) {
                near.set(v.index(), true);
            }
        }
        let is_near = |v: &VertexId| *v != INFINITE && near.has(v.index());
        // R34.
        let is_lent = |v: &[VertexId; 4]| match C::lends_stars() {
            true => v.iter().any(is_near),
            false => v.iter().all(|v| *v == INFINITE || is_near(v)),
        };
        let mut part = WirePart::default();
        let mut numbers: FxHashMap<VertexId, u32> = FxHashMap::default();
        let (mut looks, given) = (0, &mut self.circles.given);
        for (t, v) in mesh.inner.tets().tets() {
            looks += 1;
            if given.has(t.index()) || !is_lent(&v) {
                continue;
            }
            given.set(t.index(), true);
            let mut number = |v: VertexId| {
                *numbers.entry(v).or_insert_with(|| {
                    part.corners.push(WireCorner::new(&mesh.corner(v)));
                    part.corners.len() as u32 - 1
                })
            };
            let v = v.map(|v| if v == INFINITE { NOWHERE } else { number(v) });
            part.tets.push(WireLent { v, region: mesh.region(t), slot: t });
        }
        mesh.count_steps(looks / 8 + part.tets.len() as u64);
        self.send(CONDUCTOR, DomainNews::Lent(part));
    }

    /// The conductor is lent a worker's part. When it has all it splits the circles, or asks for
    /// more.
    pub(super) fn take_lent(&mut self, mesh: &mut DomainMesh<'_>, from: WorkerId, part: WirePart) {
        // Nobody is to lend what he was not asked for.
        let Some(awaited) = self.circles.awaited.checked_sub(1) else { return };
        self.circles.awaited = awaited;
        self.circles.enter(from, part);
        if self.circles.awaited > 0 {
            return;
        }
        let own = &self.circles;
        mesh.count_looks(own.lent.tets.len() as u64);
        let waits = Waits {
            asked: &own.asked,
            refused: &self.demands.refused.all,
            spent: self.spent,
            num_vertices: (self.budget.others + self.budget.total) as usize,
        };
        let parted = match mesh.complex.part_circles(&own.lent, &waits) {
            Ok(Parting::Done(parted)) => Some(own.wire(parted)),
            Ok(Parting::Beyond(missed)) => {
                let balls = own.new_balls(&missed);
                if !balls.is_empty() && own.loans < MOST_LOANS {
                    return self.borrow(balls);
                }
                None
            }
            Err(_) => None,
        };
        let given = std::mem::take(&mut self.circles.given);
        self.circles = Circles { given, ..Circles::default() };
        for to in (0..self.workers).map(WorkerId::new) {
            self.send(to, DomainNews::Parted(parted.clone().map(Box::new)));
        }
    }

    /// The circles are split: the points are inserted that begin here. If the conductor could not,
    /// nothing is, and the round that makes no progress is the last: the engine is to say why.
    pub(super) fn take_parted(&mut self, mesh: &mut DomainMesh<'_>, told: Option<Box<WireParted>>) {
        (self.choice.foremost, self.choice.entered, self.choice.fates) = (None, None, None);
        self.choice.has_boundary = true;
        let Some(told) = told else { return self.begin_to_insert() };
        self.figures.parted += 1;
        self.spent = told.spent as usize;
        self.budget.total += told.points.len() as i64;
        self.figures.parted_points += told.points.len() as u64;
        let points: Vec<Point> = told.points.iter().map(|own| point(&own.at)).collect();
        self.barriers.all.retain(|own| !points.iter().any(|p| own.block.is_touched_by(p)));
        let ended: BTreeSet<_> = told.ended.iter().copied().collect();
        self.demands.forget(&ended);
        for &WireItemRefusal { place, why } in &told.refused {
            self.demands.refused.set(place, why.map(WireRefusal::refusal));
        }
        for own in &told.points {
            self.choose_parted(mesh, own);
        }
        self.circles.parted = Some(told);
        self.begin_to_insert();
    }

    /// A point of a circle is to be inserted by the worker that has its place.
    fn choose_parted(&mut self, mesh: &mut DomainMesh<'_>, own: &WirePoint) {
        let me = self.me;
        if own.within.map_or(CONDUCTOR, |tet| tet.owner) != me {
            return;
        }
        let p = point(&own.at);
        // Others insert already: there may be another one in its slot.
        let mut is_seed = |t: &TetId| mesh.inner.tets().is_live(*t) && mesh.conflicts(*t, &p);
        let start = own.within.map(|own| own.tet).filter(|t| is_seed(t));
        let start = start.map(|t| (t, mesh.inner.tets().vertices(t)));
        self.points.made += 1;
        let vertex = WireVertex::new(made(me, self.points.made), p);
        let seed = start.map_or(TetId::default(), |(t, _)| t);
        let point = DomainPoint::chosen(vertex, own.carrier, seed);
        self.points.chosen.push_back(ChosenPoint { point, start, cavity: 0..0 });
    }

    /// The points of circles are in, if that is what was inserted: enters the regions of new
    /// tetrahedra. Some have inherited others, where the boundary was not complete in between.
    pub(super) fn label_parted(&mut self, mesh: &mut DomainMesh<'_>) {
        let Some(told) = self.circles.parted.take() else { return };
        let own = told.relabelled.iter().filter(|own| own.owner == self.me);
        self.created.extend(own.map(|own| own.tet));
        // R35.
        if !C::labels_circles() {
            return;
        }
        let labels: FxHashMap<TetPlace, u32> = told.labels.iter().copied().collect();
        for &t in &self.created {
            let v = mesh.inner.tets().vertices(t);
            if !mesh.inner.tets().is_live(t) || v.contains(&INFINITE) {
                continue;
            }
            let label = labels.get(&TetPlace::of(v.map(|v| mesh.point(v))));
            debug_assert!(label.is_some(), "all that circles make has its region told");
            if let Some(&region) = label {
                mesh.set_region(t, region);
            }
        }
    }
}
