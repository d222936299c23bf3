//! Circles of boundary items in a mesh that many processors share: one of them is lent what lies
//! around, and splits them as the engine with one mesh does.

use super::Asked;
use crate::RefineError;
use crate::complex::carrier::Carrier;
use crate::mesh::item::{Item, Queues};
use crate::mesh::window::Window;
use crate::queue::split::{Ends, Refinement};
use crate::rules::choice::{BoundaryItem, Corner, ItemPlace, NOWHERE, TetPlace};
use crate::rules::circles::circles;
use crate::rules::complex::Complex;
use crate::rules::past::Refusals;
use crate::rules::record::Refusal;
use crate::table::{Map, Set};
use ltbw_core::Builder;
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_exact::predicates::{Sign, orient3d};
use ltbw_exact::{Mode, Point, PointSet};
use std::collections::BTreeMap;

/// A tetrahedron that is lent.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LentTet {
    /// Its vertices among those lent, positively oriented; [`NOWHERE`] is the one at infinity.
    pub v: [u32; 4],
    /// Its region.
    pub region: u32,
}

/// Tetrahedra of the whole mesh.
#[doc(hidden)]
#[derive(Clone, Debug, Default)]
pub struct Lent {
    /// Their vertices.
    pub corners: Vec<Corner>,
    /// The tetrahedra.
    pub tets: Vec<LentTet>,
}

/// The boundary items that wait, and the past of all.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Waits<'w> {
    /// Boundary items that wait.
    pub asked: &'w [Asked],
    /// Boundary items that were refused.
    pub refused: &'w Refusals,
    /// The transactions of joint steps in rounds so far.
    pub spent: usize,
    /// The vertices of the whole mesh.
    pub num_vertices: usize,
}

/// A point of a joint step.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartedPoint {
    /// Its coordinates.
    pub point: Point,
    /// Where it lives.
    pub carrier: Carrier,
    /// The place of a tetrahedron that was lent and has it, if one has.
    pub within: Option<usize>,
}

/// The region of a tetrahedron.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Labelled {
    /// The tetrahedron.
    pub place: TetPlace,
    /// Its region.
    pub region: u32,
}

/// The outcome of all circles.
#[doc(hidden)]
#[derive(Clone, Debug, Default)]
pub struct Parted {
    /// The points to insert.
    pub points: Vec<PartedPoint>,
    /// The items that are not to be split any more, since they are gone, split or refused.
    pub ended: Vec<ItemPlace>,
    /// The items that are refused now, or are not any more.
    pub refused: Vec<(ItemPlace, Option<Refusal>)>,
    /// The transactions of joint steps in rounds so far.
    pub spent: usize,
    /// The regions of all new tetrahedra, and of others that have another one than before.
    pub labels: Vec<Labelled>,
    /// The places of these others among those lent.
    pub relabelled: Vec<usize>,
}

/// The end of an attempt.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub enum Parting {
    /// All circles are split, or their foremost items refused.
    Done(Parted),
    /// All tetrahedra at these vertices have to be lent, too.
    Beyond(Vec<Point>),
}

/// The circles among boundary items that wait for each other, each from its foremost one on.
#[doc(hidden)]
pub fn circles_among(asked: &[Asked]) -> Vec<Vec<BoundaryItem>> {
    let items: BTreeMap<ItemPlace, &Asked> =
        asked.iter().map(|own| (own.item.place(), own)).collect();
    let numbers: Map<ItemPlace, usize> = items.keys().copied().zip(0..).collect();
    let first_of = |own: &&Asked| numbers.get(&own.first?).copied();
    let all: Vec<&Asked> = items.into_values().collect();
    let first: Vec<Option<usize>> = all.iter().map(first_of).collect();
    let named = |circle: Vec<usize>| circle.into_iter().map(|k| all[k].item).collect();
    circles(&first).into_iter().map(named).collect()
}

/// A tetrahedron of a window by its vertices, ascending.
type Key = [VertexId; 4];

fn key(mut v: Key) -> Key {
    v.sort_unstable();
    v
}

/// A refinement of the window that was lent.
struct Borrowed<'b> {
    own: Refinement<'b>,
    /// The places among the tetrahedra lent.
    places: Map<Key, usize>,
    /// The boundary items, each with a tetrahedron at it.
    found: Map<ItemPlace, (Item, TetId)>,
    /// The vertices that were lent.
    count: usize,
}

impl Complex<'_> {
    /// Splits the circles among items that wait, one after the other, in the order of the places of
    /// their foremost items: as far as what was lent tells what comes of that.
    ///
    /// # Errors
    /// What was lent is no part of a Delaunay mesh; there is no room.
    pub fn part_circles(&self, lent: &Lent, waits: &Waits<'_>) -> Result<Parting, RefineError> {
        let mut window = self.window(lent, waits)?;
        let mut ended = Vec::new();
        for circle in circles_among(waits.asked) {
            let Some(foremost) = circle.first() else { continue };
            let place = foremost.place();
            let Some(&(item, _)) = window.found.get(&place) else {
                let corners = foremost.corners().iter().map(|corner| corner.point);
                return Ok(Parting::Beyond(corners.collect()));
            };
            if window.own.part_circle(item, &mut Queues::default()).is_err() {
                let missed = window.missed();
                return match missed.is_empty() {
                    true => Err(RefineError::Invariant { what: "room for points" }),
                    false => Ok(Parting::Beyond(missed)),
                };
            }
            ended.push(place);
        }
        Ok(window.outcome(lent, waits, ended))
    }

    /// The refinement of what was lent.
    fn window(&self, lent: &Lent, waits: &Waits<'_>) -> Result<Borrowed<'_>, RefineError> {
        let unfit = RefineError::Invariant { what: "what is lent is a part of a Delaunay mesh" };
        let points: Vec<Point> = lent.corners.iter().map(|own| own.point).collect();
        let (count, set) = (points.len(), PointSet::new(points)?);
        let is_vertex = |k: u32| k == NOWHERE || (k as usize) < count;
        let all_are = lent.tets.iter().flat_map(|own| own.v).all(is_vertex);
        if set.mode() != Mode::Normal || !all_are {
            return Err(unfit);
        }
        let mesh = Builder::new().build(&set)?.mesh;
        let mut at = vec![INFINITE; count];
        let mut carriers = vec![Carrier::Free; mesh.numbers().len()];
        for (v, &number) in mesh.numbers().iter().enumerate().skip(1) {
            at[number as usize] = VertexId::at(v);
            carriers[v] = lent.corners[number as usize].carrier;
        }
        let vertex = |k: u32| if k == NOWHERE { INFINITE } else { at[k as usize] };
        let named = |(place, own): (usize, &LentTet)| (key(own.v.map(vertex)), place);
        let places: Map<Key, usize> = lent.tets.iter().enumerate().map(named).collect();
        let (mut regions, mut is_filling) = (vec![0; mesh.topology().slots()], Vec::new());
        is_filling.resize(regions.len(), true);
        let mut there = 0;
        for (t, tet) in mesh.topology().iter() {
            if let Some(&place) = places.get(&key(tet.vertices())) {
                is_filling[t.index()] = false;
                regions[t.index()] = lent.tets[place].region;
                there += 1;
            }
        }
        if there != places.len() || mesh.num_vertices() != count {
            return Err(unfit);
        }
        let mut state = self.state(mesh, carriers);
        let elsewhere = waits.num_vertices.saturating_sub(count);
        state.window = Some(Window { is_filling, elsewhere, missed: Vec::new() });
        state.by_place = true;
        let found = state.enter_boundary_of_window(self, &regions);
        let ends = Ends { floor: self.floor, joint_most: self.joint_most, sweeps: 0 };
        let mut own = Refinement::new(state, count as u32, ends);
        own.bounds = Some(self.bounds().clone());
        own.record.joint_transactions = waits.spent;
        let item = |place: &ItemPlace| found.get(place).map(|own| own.0);
        let limits =
            waits.asked.iter().filter_map(|own| Some((item(&own.item.place())?, own.limit?)));
        own.record.limits.extend(limits);
        let refused = waits.refused.iter().filter_map(|(place, why)| Some((item(place)?, *why)));
        own.record.refused.extend(refused);
        Ok(Borrowed { own, places, found, count })
    }
}

impl Borrowed<'_> {
    /// The vertices around which more has to be lent, each once.
    fn missed(&mut self) -> Vec<Point> {
        let window = self.own.state.window.as_mut();
        let mut missed = window.map(|own| std::mem::take(&mut own.missed)).unwrap_or_default();
        missed.sort_unstable_by_key(|p| p.map(f64::to_bits));
        missed.dedup();
        missed
    }

    /// The outcome, when all foremost items have `ended`.
    fn outcome(mut self, lent: &Lent, waits: &Waits<'_>, ended: Vec<ItemPlace>) -> Parting {
        let mut parted =
            Parted { ended, spent: self.own.record.joint_transactions, ..Parted::default() };
        let mut changed = Vec::new();
        let mut stays: Set<usize> = Set::default();
        let state = &self.own.state;
        let has_patches = state.plc.has_patches();
        for t in state.mesh.tet_ids().filter(|&t| !state.has_filling(t)) {
            let (v, region) = (state.vertices(t), state.marks.region(t));
            let place = self.places.get(&key(v)).copied();
            stays.extend(place);
            if place.is_none_or(|place| lent.tets[place].region != region) {
                let place = TetPlace::of(v.map(|v| state.at(v)));
                parted.labels.push(Labelled { place, region });
            }
            let relabelled = place.filter(|&place| lent.tets[place].region != region);
            parted.relabelled.extend(relabelled);
            if relabelled.is_some() || place.is_none() && has_patches {
                changed.push(t);
            }
        }
        // Dust that goes to the other side of its patch has looked at tetrahedra two away, and so
        // has what is new at a patch.
        let beside: Vec<TetId> = changed.iter().flat_map(|&t| state.neighbours(t)).collect();
        changed.extend(beside);
        if self.own.state.filling_around(&changed).is_some() {
            return Parting::Beyond(self.missed());
        }
        self.collect_points(lent, &stays, &mut parted);
        self.collect_items(waits, &mut parted);
        Parting::Done(parted)
    }

    /// Collects the points, each with the tetrahedron that had it.
    fn collect_points(&self, lent: &Lent, stays: &Set<usize>, parted: &mut Parted) {
        let state = &self.own.state;
        let is_gone =
            |place: &usize| !stays.contains(place) && !lent.tets[*place].v.contains(&NOWHERE);
        let gone: Vec<usize> = (0..lent.tets.len()).filter(is_gone).collect();
        for v in self.count + 1..=state.mesh.num_vertices() {
            let (point, carrier) = (state.at(VertexId::at(v)), state.carriers[v]);
            let has = |&&place: &&usize| {
                let corners = lent.tets[place].v.map(|k| lent.corners[k as usize].point);
                (0..4).all(|k| {
                    let mut with = corners.each_ref();
                    with[k] = &point;
                    let [a, b, c, d] = with;
                    orient3d(a, b, c, d) != Sign::Negative
                })
            };
            let within = gone.iter().find(has).copied();
            parted.points.push(PartedPoint { point, carrier, within });
        }
    }

    /// Collects the items that are gone, and what is refused or not any more.
    fn collect_items(&self, waits: &Waits<'_>, parted: &mut Parted) {
        let (state, record) = (&self.own.state, &self.own.record);
        let is_there = |item: &Item| match item {
            Item::Segment(s) => state.segments.contains_key(s),
            Item::Subface(s) => state.subfaces.contains_key(s),
            Item::Tet(..) => false,
        };
        let is_gone =
            |place: &ItemPlace| self.found.get(place).is_some_and(|own| !is_there(&own.0));
        let asked = waits.asked.iter().map(|own| own.item.place());
        parted.ended.extend(asked.filter(is_gone));
        parted.ended.sort_unstable();
        parted.ended.dedup();
        let found = self.found.iter().filter(|own| is_there(&own.1.0));
        for (place, (item, _)) in found {
            let (before, now) = (waits.refused.get(place), record.refused.get(item));
            if before != now {
                parted.refused.push((*place, now.copied()));
            }
        }
        let gone = waits.refused.keys().filter(|place| is_gone(place));
        parted.refused.extend(gone.map(|place| (*place, None)));
        parted.refused.sort_unstable_by_key(|own| own.0);
    }
}
