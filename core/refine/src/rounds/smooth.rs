//! Smoothing: vertices inside are taken out of the mesh and put in elsewhere, where the smallest
//! dihedral angle around rises.
//!
//! A round looks at vertices no two of which have a neighbour in common, each on the mesh at its
//! start, which is restored after each look. A move is made where no other one of the round
//! changes tetrahedra with a vertex in common: all moves together are then what each is alone. So
//! a round is a function of the mesh, in whatever order vertices are looked at and moved.

use super::batch::Prober;
use super::{Look, Rounds};
use crate::RefineError;
use crate::complex::carrier::{Carrier, free_point};
use crate::complex::dihedral::DihedralBound;
use crate::mesh::item::Item;
use crate::mesh::key::{order_key, sorted};
use crate::mesh::state::{Place, State};
use crate::queue::split::Refinement;
use crate::rules::aim::TOLERANCE;
use crate::rules::beside::in_unit_ball;
use crate::rules::bounded::Bounded;
use crate::rules::star::{Made, star};
use ltbw_core::topology::{TetId, VertexId, tet_of};
use ltbw_domain::quality::sharpest;
use ltbw_domain::vector::{cross, distance2, dot, minus};
use ltbw_exact::Point;
use std::cmp::Reverse;

/// The parts of the way to the middle of its star at which a vertex is tried.
const PARTS: [f64; 3] = [1.0, 0.5, 0.25];
/// Places around that are tried beside these, and how far: in parts of its shortest edge.
const AROUND: usize = 6;
const REACH: f64 = 0.3;
/// The part by which the square of the cosine of the smallest angle has to fall.
const LEAST: f64 = 1.0 / (1 << 20) as f64;

/// The invariant that is broken where a vertex inside cannot be moved.
const BROKEN: RefineError = RefineError::Invariant { what: "a vertex inside can be moved" };

/// The corners of tetrahedra, each in the order of their coordinates.
type Corners = Vec<[Point; 4]>;

/// A vertex in another place.
struct Move {
    v: VertexId,
    p: Point,
    /// The vertices of all tetrahedra that go.
    around: Vec<VertexId>,
}

/// The room of a vertex that is taken out.
struct Room {
    region: u32,
    /// Its star.
    old: Corners,
    /// The tetrahedra that fill that now.
    hole: Vec<TetId>,
}

/// The gain of a vertex in a place.
struct Gain {
    /// The square of the cosine of the smallest dihedral angle of what comes.
    cos2: f64,
    /// The vertices of tetrahedra that go, and were not at the vertex.
    beyond: Vec<VertexId>,
}

/// The star of a vertex.
#[derive(Clone, Default)]
struct Star {
    /// Its vertices, with the one in the middle.
    around: Vec<VertexId>,
    /// The square of the cosine of its smallest dihedral angle.
    cos2: f64,
}

/// The memory of a smoothing.
struct Smoothing {
    /// A tetrahedron of each vertex.
    at: Vec<TetId>,
    /// The stars that are known, by vertex.
    stars: Vec<Option<Star>>,
    /// The round in which a vertex was last taken.
    taken: Vec<u32>,
    round: u32,
    prober: Prober,
}

impl Smoothing {
    fn new(state: &State) -> Self {
        let count = state.carriers.len();
        let mut own = Self {
            at: vec![TetId::default(); count],
            stars: vec![None; count],
            taken: vec![0; count],
            round: 0,
            prober: Prober::default(),
        };
        own.note(state, state.mesh.tet_ids());
        own
    }

    /// Notes tetrahedra that are there.
    fn note(&mut self, state: &State, tets: impl Iterator<Item = TetId>) {
        for t in tets {
            state.vertices(t).into_iter().for_each(|v| self.at[v.index()] = t);
        }
    }

    /// Takes some vertices, unless one of them was taken in this round.
    fn take(&mut self, all: &[VertexId]) -> bool {
        let is_free = all.iter().all(|v| self.taken[v.index()] != self.round);
        if is_free {
            all.iter().for_each(|v| self.taken[v.index()] = self.round);
        }
        is_free
    }

    /// Learns the star of a vertex, unless it is known.
    fn learn(&mut self, state: &State, v: VertexId) {
        if self.stars[v.index()].is_some() {
            return;
        }
        let star = self.star(state, v);
        let angle =
            |&t: &TetId| sharpest(sorted(state.vertices(t).map(|v| state.at(v))).each_ref());
        let cos2 = star.iter().map(angle).fold(0.0, f64::max);
        let around = vertices_of(state, star.iter().copied());
        self.stars[v.index()] = Some(Star { around, cos2 });
    }

    /// The tetrahedra of a vertex inside.
    fn star(&self, state: &State, v: VertexId) -> Vec<TetId> {
        let mut star = vec![self.at[v.index()]];
        let mut next = 0;
        // Ends: each tetrahedron enters once.
        while let Some(&t) = star.get(next) {
            next += 1;
            let tet = state.mesh.topology().at(t);
            for (corner, &face) in tet.vertices().into_iter().zip(&tet.neighbours()) {
                if corner != v && !star.contains(&tet_of(face)) {
                    star.push(tet_of(face));
                }
            }
        }
        star
    }
}

/// Distinct vertices of some tetrahedra.
fn vertices_of(state: &State, tets: impl Iterator<Item = TetId>) -> Vec<VertexId> {
    let mut all: Vec<VertexId> = tets.flat_map(|t| state.vertices(t)).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The square of the cosine of the smallest dihedral angle of some tetrahedra, rounded.
fn sharpest_of(all: &[[Point; 4]]) -> f64 {
    all.iter().map(|corners| sharpest(corners.each_ref())).fold(0.0, f64::max)
}

impl Rounds<'_, '_> {
    /// Moves vertices inside, each once in a sweep at most; `true` if the work is cancelled.
    ///
    /// Ends: each round looks at one vertex at least that this sweep has not looked at.
    ///
    /// # Errors
    /// A broken invariant.
    pub(super) fn smooth(&mut self, sweeps: u32, look: Look<'_>) -> Result<bool, RefineError> {
        if sweeps == 0 || self.own.bounds.is_none() {
            return Ok(false);
        }
        // Refused tetrahedra stay in their slots; other slots get others.
        let Refinement { state, record, .. } = &mut *self.own;
        record.refused.retain(|item, _| match *item {
            Item::Tet(t, v) => state.is_live(t, v),
            Item::Segment(_) | Item::Subface(_) => true,
        });
        let mut smoothing = Smoothing::new(&self.own.state);
        for _ in 0..sweeps {
            let mut pool = self.movable(&smoothing);
            while !pool.is_empty() {
                if look(self.own.state.mesh.num_vertices()) {
                    return Ok(true);
                }
                self.clock.begin();
                let before = pool.len();
                let moved = self.smooth_round(&mut pool, &mut smoothing)?;
                self.clock.end("smoothing", before - pool.len(), moved);
            }
        }
        let (state, bounds) = (&self.own.state, &self.own.bounds);
        let mut thin = Vec::new();
        if let Some(bounds) = bounds {
            bounds.over_of(state, state.mesh.tet_ids(), &mut thin).for_each(drop);
        }
        self.own.inserted.thin.tets = thin;
        Ok(false)
    }

    /// The vertices inside that are not given, and around which no tetrahedron is over its bounds.
    fn movable(&self, smoothing: &Smoothing) -> Vec<VertexId> {
        let (state, numbers) = (&self.own.state, self.own.state.mesh.numbers());
        let first = state.plc.count() as u32;
        let is_inside = |v: &VertexId| {
            state.carriers[v.index()] == Carrier::Free && numbers[v.index()] >= first
        };
        let is_met = |v: &VertexId| smoothing.star(state, *v).iter().all(|&t| self.is_met(t));
        let all = (1..state.carriers.len()).map(VertexId::at);
        all.filter(is_inside).filter(is_met).collect()
    }

    /// Is a tetrahedron one of a region, and within its bounds?
    fn is_met(&self, t: TetId) -> bool {
        let state = &self.own.state;
        let is_over = self.own.bounds.as_ref().is_none_or(|bounds| bounds.is_over(state, t));
        state.marks.region(t) != 0 && !is_over
    }

    /// One round: what was looked at leaves the pool. Returns the number of moves.
    fn smooth_round(
        &mut self,
        pool: &mut Vec<VertexId>,
        own: &mut Smoothing,
    ) -> Result<usize, RefineError> {
        let state = &self.own.state;
        pool.iter().for_each(|&v| own.learn(state, v));
        // The smallest angle first, then by place.
        let key = |v: &VertexId| {
            let cos2 = own.stars[v.index()].as_ref().map_or(0.0, |star| star.cos2);
            (Reverse(cos2.to_bits()), order_key(&state.at(*v)))
        };
        pool.sort_by_cached_key(key);
        own.round += 1;
        let (mut chosen, mut rest) = (Vec::new(), Vec::new());
        for &v in pool.iter() {
            let star = own.stars[v.index()].take().unwrap_or_default();
            let list = if own.take(&star.around) { &mut chosen } else { &mut rest };
            list.push(v);
            own.stars[v.index()] = Some(star);
        }
        let mut moves = Vec::new();
        for &v in &chosen {
            moves.extend(self.best_move(v, own)?);
        }
        own.round += 1;
        let mut count = 0;
        for Move { v, p, around } in moves {
            if !own.take(&around) {
                rest.push(v);
                continue;
            }
            self.carry_out(v, p, own)?;
            around.iter().for_each(|v| own.stars[v.index()] = None);
            count += 1;
        }
        self.stats.moved += count as u64;
        *pool = rest;
        Ok(count)
    }

    fn carry_out(&mut self, v: VertexId, p: Point, own: &mut Smoothing) -> Result<(), RefineError> {
        let state = &mut self.own.state;
        let number = state.mesh.numbers()[v.index()];
        let region = state.marks.region(own.at[v.index()]);
        state.take_out(v, region).map_err(|_| BROKEN)?;
        self.put_in(v, p, number, own)
    }

    /// Puts the vertex that was just taken out in at a place, with its number.
    fn put_in(
        &mut self,
        v: VertexId,
        p: Point,
        number: u32,
        own: &mut Smoothing,
    ) -> Result<(), RefineError> {
        let state = &mut self.own.state;
        own.note(state, state.mesh.cavity().star().tets.iter().copied());
        let from = state.holder(state.mesh.hint(), &p).ok_or(BROKEN)?;
        if state.put_in(p, number, from).ok() != Some(v) {
            return Err(BROKEN);
        }
        own.note(state, state.mesh.cavity().star().tets.iter().copied());
        Ok(())
    }

    /// The best other place for a vertex, if there is one. The mesh is as before, but for slots.
    fn best_move(&mut self, v: VertexId, own: &mut Smoothing) -> Result<Option<Move>, RefineError> {
        let state = &self.own.state;
        let star = own.star(state, v);
        let (p, number) = (state.at(v), state.mesh.numbers()[v.index()]);
        let region = state.marks.region(star[0]);
        let corners = |&t: &TetId| sorted(state.vertices(t).map(|v| state.at(v)));
        let mut old: Corners = star.iter().map(corners).collect();
        old.sort_by_cached_key(|corners| corners.map(|p| order_key(&p)));
        let (around, places) = (vertices_of(state, star.iter().copied()), places(&p, &old));
        self.own.state.take_out(v, region).map_err(|_| BROKEN)?;
        let hole = self.own.state.mesh.cavity().star().tets.to_vec();
        let room = Room { region, old, hole };
        let mut best: Option<(Point, Gain)> = None;
        for place in places {
            let gain = self.gain_at(place, &room, &mut own.prober);
            let is_better = |gain: &Gain| best.as_ref().is_none_or(|best| gain.cos2 < best.1.cos2);
            if let Some(gain) = gain.filter(is_better) {
                best = Some((place, gain));
            }
        }
        self.put_in(v, p, number, own)?;
        Ok(best.map(|(p, gain)| {
            let mut around = [around, gain.beyond].concat();
            around.sort_unstable();
            around.dedup();
            Move { v, p, around }
        }))
    }

    /// The gain of a vertex that was taken out in a place; `None` if it may not be there, or the
    /// smallest angle does not rise.
    fn gain_at(&self, p: Point, room: &Room, prober: &mut Prober) -> Option<Gain> {
        let (state, bounds) = (&self.own.state, self.own.bounds.as_ref()?);
        let Room { region, old, hole } = room;
        let from = state.holder(*hole.first()?, &p)?;
        let place = Place { p, carrier: Carrier::Free, from };
        let seen = prober.see(state, &place, |_| false).ok()?;
        let filling = seen.judge(&self.own.record).filling_beside(None, &place, |_| false)?;
        if !filling.changes.is_empty() {
            return None;
        }
        let beyond = || seen.tets.iter().copied().filter(|t| !hole.contains(t));
        if !beyond().all(|t| state.marks.region(t) == *region && self.is_met(t)) {
            return None;
        }
        let at = |t: TetId| state.vertices(t).map(|v| state.at(v));
        let mut new = Corners::new();
        let left = hole.iter().filter(|&&t| !seen.closure.is_in(t));
        if left.clone().any(|&t| state.is_flat(state.vertices(t))) {
            return None;
        }
        let left = left.map(|&t| Made { corners: at(t), region: *region });
        for Made { corners, region: own } in star(&seen.closure, &place, &[]).chain(left) {
            if own != *region || bounds.are_over(corners.each_ref(), own) {
                return None;
            }
            new.push(sorted(corners));
        }
        let mut gone = old.clone();
        gone.extend(beyond().map(|t| sorted(at(t))));
        let (before, cos2) = (sharpest_of(&gone), sharpest_of(&new));
        if cos2 >= before {
            return None;
        }
        // Rounded numbers propose it; that an angle goes which is below all that come is exact.
        let between = DihedralBound::of_cos2(before * (1.0 - LEAST));
        let is_below = |corners: &[Point; 4]| between.is_missed(corners.each_ref());
        let rises = gone.iter().any(is_below) && !new.iter().any(is_below);
        rises.then(|| Gain { cos2, beyond: vertices_of(state, beyond()) })
    }
}

/// The places that are tried for a vertex, as a function of its star: towards the mean of the
/// circumcentres of its tetrahedra, weighted by their volumes, and around.
fn places(p: &Point, star: &[[Point; 4]]) -> Vec<Point> {
    let (mut shortest, mut mean, mut sum) = (f64::INFINITY, [0.0; 3], 0.0);
    for [a, b, c, d] in star {
        let (u, v, w) = (minus(a, d), minus(b, d), minus(c, d));
        let (vw, wu, uv) = (cross(&v, &w), cross(&w, &u), cross(&u, &v));
        let squares = [dot(&u, &u), dot(&v, &v), dot(&w, &w)];
        let det = dot(&u, &vw);
        let volume = det.abs();
        for k in 0..3 {
            let n = squares[0] * vw[k] + squares[1] * wu[k] + squares[2] * uv[k];
            mean[k] += volume * (d[k] + 0.5 * n / det - p[k]);
        }
        sum += volume;
        for q in [a, b, c, d].into_iter().filter(|q| *q != p) {
            shortest = shortest.min(distance2(p, q));
        }
    }
    let shortest = shortest.sqrt();
    let towards = PARTS.map(|part| mean.map(|way| part * way / sum));
    let mut seed = 1;
    let around = std::array::from_fn::<_, AROUND, _>(|_| {
        in_unit_ball(&mut seed).map(|offset| REACH * shortest * offset)
    });
    let at = |way: &[f64; 3]| free_point(&[0, 1, 2].map(|k| p[k] + way[k]), shortest * TOLERANCE);
    towards.iter().chain(&around).filter_map(at).filter(|q| q != p).collect()
}
