//! Slivers in rounds: when all bounds are met, the tetrahedra with small dihedral angles are
//! candidates, each with the point that serves it best in the mesh at the start of the round.
//!
//! A point is inserted only where no other one is, so that its tetrahedra are those looked at, and
//! no sliver follows from another.

use super::batch::Prober;
use super::{CHECK_EVERY, Candidate, Look, Rounds};
use crate::complex::carrier::Carrier;
use crate::complex::measure::in_equatorial_ball;
use crate::mesh::item::Item;
use crate::mesh::state::{Place, State};
use crate::mesh::survey::Survey;
use crate::rules::sliver::{Trial, Tried, Tries, Try};
use crate::rules::verdict::Filling;
use crate::rules::walk::Way;
use crate::thin::Thin;
use ltbw_core::PredicateStats;
use ltbw_core::topology::TetId;
use ltbw_exact::Point;
use rayon::prelude::*;

/// Slivers that a thread looks at at a time; fewer are not worth another thread.
const BATCH: usize = if cfg!(test) { 3 } else { 16 };

/// The point that serves a sliver best.
struct Served {
    /// The boundary item that it splits, or the sliver.
    item: Item,
    place: Place,
    cavity: Vec<TetId>,
    filling: Filling,
}

impl Rounds<'_, '_> {
    /// Is any sliver left? They are looked for once, when all bounds are met.
    pub(super) fn has_slivers(&mut self) -> bool {
        if self.late.slivers.is_none() {
            self.late.slivers = Some(self.own.slivers());
        }
        self.late.slivers.as_ref().is_some_and(|slivers| !slivers.is_empty())
    }

    /// The slivers of the first step of these, if others are to split them.
    pub(super) fn slivers_for_others(&mut self) -> Option<Vec<Thin>> {
        let few = self.leaves_slivers?;
        let is_first = self.late.is_at_first_slivers();
        self.late.slivers.take_if(|slivers| is_first && slivers.len() >= few)
    }

    /// Chooses points for slivers; `true` if the work is cancelled. A sliver is looked at again as
    /// long as others are in the way of its point.
    pub(super) fn choose_slivers(&mut self, look: Look<'_>) -> bool {
        let mut slivers = self.late.slivers.take().unwrap_or_default();
        slivers.retain(|&(t, v)| self.own.state.is_live(t, v));
        self.reserved.start(slivers.len(), 0);
        let vertices = self.own.state.mesh.num_vertices();
        let mut left = Vec::new();
        for (k, list) in slivers.chunks(CHECK_EVERY).enumerate() {
            if k > 0 && look(vertices) {
                self.late.slivers = Some(slivers);
                return true;
            }
            for (&sliver, served) in list.iter().zip(self.serve_slivers(list)) {
                if let Some(served) = served {
                    self.take_served(served, left.len() as u32);
                    left.push(sliver);
                }
            }
        }
        self.late.slivers = Some(left);
        let stats = std::mem::take(&mut self.prober.search.stats);
        self.own.state.mesh.add_stats(stats);
        for k in 0..self.choice.candidates.len() {
            if self.survives(k) {
                self.choice.chosen.push(k);
            }
        }
        false
    }

    /// The best points for some slivers, in their order.
    fn serve_slivers(&mut self, list: &[Thin]) -> Vec<Option<Served>> {
        let mut own = std::mem::take(&mut self.prober);
        let this = &*self;
        let serve = |prober: &mut Prober, list: &[Thin]| {
            let served: Vec<_> = list.iter().map(|&(t, _)| this.serve(t, prober)).collect();
            (served, std::mem::take(&mut prober.search.stats))
        };
        let batches: Vec<(Vec<Option<Served>>, PredicateStats)> =
            match self.threads > 1 && list.len() >= 2 * BATCH {
                true => list.par_chunks(BATCH).map_init(Prober::default, serve).collect(),
                false => vec![serve(&mut own, list)],
            };
        self.prober = own;
        let mut all = Vec::with_capacity(list.len());
        for (served, stats) in batches {
            self.own.state.mesh.add_stats(stats);
            all.extend(served);
        }
        all
    }

    fn take_served(&mut self, served: Served, rank: u32) {
        let Served { item, place, cavity, filling } = served;
        let cavity = self.choice.add_cavity(&cavity);
        // One that is alone has nobody to watch.
        let (fits, watch, alone) = (true, None, true);
        let own = Candidate { item, rank, fits, watch, alone, place, cavity, filling };
        self.choice.candidates.push(own);
        self.reserved.note_alone(rank, alone);
        self.reserve_last();
    }

    /// The best of the first points that serve a sliver.
    fn serve(&self, t: TetId, prober: &mut Prober) -> Option<Served> {
        let state = &self.own.state;
        let v = state.vertices(t);
        let mut tries = Tries::of(v.map(|v| state.at(v)))?;
        let (mut best, mut barred) = (None, Barred::default());
        let inside = |p: Point| match state.way(t, &p) {
            Way::Arrived(from) => {
                let place = Place { p, carrier: Carrier::Free, from };
                Some(Trying { item: Item::Tet(t, v), place, gives_way: true })
            }
            _ => None,
        };
        // Ends: the number of tries is bounded.
        loop {
            let trying = match tries.next(&state.plc) {
                Try::Inside(p) if barred.is_surely(state, &p) => continue,
                Try::Inside(p) => match inside(p) {
                    Some(trying) => trying,
                    None => continue,
                },
                Try::Look(towards) => {
                    for p in std::mem::take(&mut barred.unseen) {
                        if let Some(trying) = inside(p) {
                            self.try_point(t, trying, prober, &mut barred);
                        }
                    }
                    let items = &mut barred.by;
                    items.extend(state.beside(t, towards));
                    state.sort(items);
                    items.dedup();
                    let named = items.iter().map(|&item| state.boundary_item(item));
                    tries.beside(named.collect::<Option<_>>()?);
                    continue;
                }
                Try::Beside { item, point: p, carrier, gives_way } => {
                    let Some(from) = state.holder(t, &p) else { continue };
                    let place = Place { p, carrier, from };
                    Trying { item: barred.by[item], place, gives_way }
                }
                Try::Over => return best,
            };
            let served = self.try_point(t, trying, prober, &mut barred);
            if let Some((served, sharpest)) = served
                && tries.take(sharpest)
            {
                best = Some(served);
            }
        }
    }

    /// A point for a sliver and its sharpest angle, if it serves; else `barred` is told of the
    /// items that keep it away.
    fn try_point(
        &self,
        t: TetId,
        trying: Trying,
        prober: &mut Prober,
        barred: &mut Barred,
    ) -> Option<(Served, f64)> {
        let Trying { item, place, gives_way } = trying;
        let seen = prober.see(&self.own.state, &place, |_| false).ok()?;
        let on = (!matches!(item, Item::Tet(..))).then_some((item, gives_way));
        let trial = Trial { place: &place, on, has_sliver: seen.tets.contains(&t) };
        match seen.judge(&self.own.record).serves(&trial, &self.terms()?) {
            Tried::Serves(filling, sharpest) => {
                let cavity = seen.tets.to_vec();
                Some((Served { item, place, cavity, filling }, sharpest))
            }
            Tried::Barred(items) => {
                barred.note(&self.own.state, &items, seen.survey);
                None
            }
            Tried::Fails => None,
        }
    }
}

/// A point that is tried on a boundary item, or inside for the sliver.
struct Trying {
    item: Item,
    place: Place,
    /// May it lie in no ball of another item?
    gives_way: bool,
}

/// The items that keep points inside away from a sliver.
#[derive(Default)]
struct Barred {
    /// The items.
    by: Vec<Item>,
    /// The subfaces among them: their corners, and the tetrahedra beside them.
    subfaces: Vec<([Point; 3], [Option<TetId>; 2])>,
    /// Points that are kept away, of which it is not known by what else.
    unseen: Vec<Point>,
}

impl Barred {
    fn note(&mut self, state: &State, items: &[Item], survey: &Survey<TetId>) {
        for item in items {
            let Item::Subface(key) = *item else { continue };
            let own = survey.faces.iter().find(|face| face.key == key);
            if let Some(face) = own.filter(|_| !self.by.contains(item)) {
                self.subfaces.push((key.map(|v| state.at(v)), face.sides));
            }
        }
        self.by.extend(items);
    }

    /// Does one of the subfaces keep this point away, too? It does if the point is in its ball, and
    /// a tetrahedron beside it in the cavity. Then nothing has to be looked for.
    fn is_surely(&mut self, state: &State, p: &Point) -> bool {
        let is_in = |t: &TetId| state.mesh.in_conflict(*t, p);
        let bars = |([a, b, c], sides): &([Point; 3], [Option<TetId>; 2])| {
            in_equatorial_ball(a, b, c, p) && sides.iter().flatten().any(is_in)
        };
        let is_barred = self.subfaces.iter().any(bars);
        if is_barred {
            self.unseen.push(*p);
        }
        is_barred
    }
}
