//! The owner's side of the choice: searches, reservations, and what rivals there are.

use super::reserved::{Holders, Marks};
use crate::protocol::{Correct, Handle, Rules, WorkerId};
use crate::refining::domain::DomainMesh;
use crate::refining::news::{INFINITE_CORNER, ProbeId, Proposal, WireClosure, WireCorner, point};
use ltbw_core::cavity::OTHERS;
use ltbw_core::topology::{INFINITE, TetId, VertexId, tet_of};
use ltbw_core::{expect, prefetch};
use ltbw_domain::refine::{Carrier, Closure, Corner, NOWHERE, Rank, Rival};
use rustc_hash::FxHashMap;
use std::ops::Range;

/// One probe's part of its closure here.
#[derive(Debug, Default)]
pub(super) struct Part {
    /// Its number among those that have reserved, if it has.
    holder: Option<u32>,
    /// It reserves nothing.
    is_void: bool,
    /// Its home wants to hear of rivals.
    is_wanted: bool,
    /// If all of the closure is here: the cavity in the list of those.
    inside: Range<usize>,
    /// The tetrahedra looked at, in the order in which the home was told, and whether each is in
    /// conflict; none, as long as nobody asks, if all of the closure is here.
    pub(super) order: Vec<(TetId, bool)>,
}

impl Part {
    /// The tetrahedra in conflict; `cavities` has those of closures that are all here.
    fn cavity<'p>(&'p self, cavities: &'p [TetId]) -> impl Iterator<Item = TetId> + 'p {
        let order = if self.inside.is_empty() { &self.order[..] } else { &[] };
        let inside = cavities[self.inside.clone()].iter().copied();
        inside.chain(order.iter().filter(|own| own.1).map(|own| own.0))
    }
}

/// The parts that this worker has been asked for in a round.
#[derive(Debug, Default)]
pub(super) struct Served {
    me: WorkerId,
    /// The parts of own probes, by their numbers.
    own: Vec<Option<Part>>,
    /// The parts of others' probes, with the ranks and the carriers of these.
    others: FxHashMap<ProbeId, (Part, (Rank, Carrier))>,
    /// By slot: the number in `holders` of the foremost candidate with it in its cavity.
    reserved: Marks,
    holders: Holders,
    /// The cavities of own probes whose closures are all here.
    cavities: Vec<TetId>,
    /// The memory of parts of rounds before.
    spare: Vec<Vec<(TetId, bool)>>,
    /// Scratch: tetrahedra that a search has seen.
    seen: Marks,
    /// Scratch: the numbers of vertices in a closure.
    places: Marks,
}

impl Served {
    /// The parts of worker `me`.
    pub(super) fn new(me: WorkerId) -> Self {
        Self { me, ..Self::default() }
    }

    /// Takes memory for about this many tetrahedra. A hint.
    pub(super) fn expect_tets(&mut self, tets: usize) {
        expect(&mut self.reserved.all, tets);
        expect(&mut self.seen.all, tets);
    }

    /// Asks the processor to fetch what is reserved of a tetrahedron. A hint.
    pub(super) fn prefetch(&self, t: TetId) {
        prefetch(self.reserved.all.as_ptr().wrapping_add(t.index()));
    }

    /// Starts a round.
    pub(super) fn clear(&mut self, mesh: &DomainMesh<'_>) {
        let others = self.others.drain().map(|(_, (part, _))| part);
        let ended = self.own.drain(..).flatten().chain(others);
        let orders = ended.map(|part| part.order);
        self.spare.extend(orders.filter(|order| order.capacity() > 0));
        self.holders.clear();
        self.cavities.clear();
        self.reserved.clear(mesh.inner.tets().topology().slots());
    }

    pub(super) fn part(&self, probe: ProbeId) -> Option<&Part> {
        match probe.home == self.me {
            true => self.own.get(probe.number as usize)?.as_ref(),
            false => self.others.get(&probe).map(|own| &own.0),
        }
    }

    /// The tetrahedra in conflict in a probe's part.
    pub(super) fn cavity(&self, probe: ProbeId) -> impl Iterator<Item = TetId> + '_ {
        self.part(probe).into_iter().flat_map(|part| part.cavity(&self.cavities))
    }

    /// The cavity of an own probe among those whose closures are all here; empty if it is none.
    pub(super) fn inside(&self, probe: ProbeId) -> Range<usize> {
        self.part(probe).map_or(0..0, |part| part.inside.clone())
    }

    /// The cavity there.
    pub(super) fn cavity_at(&self, inside: &Range<usize>) -> &[TetId] {
        self.cavities.get(inside.clone()).unwrap_or_default()
    }

    fn part_mut(&mut self, probe: ProbeId) -> Option<&mut Part> {
        match probe.home == self.me {
            true => self.own.get_mut(probe.number as usize)?.as_mut(),
            false => self.others.get_mut(&probe).map(|own| &mut own.0),
        }
    }

    /// The part of a probe, made if there is none.
    fn enter(&mut self, own: &Proposal) -> &mut Part {
        let ProbeId { home, number } = own.probe;
        if home != self.me {
            let new = || (Part::default(), (own.rank, own.carrier));
            return &mut self.others.entry(own.probe).or_insert_with(new).0;
        }
        self.own_part(number)
    }

    /// The part of an own probe, made if there is none.
    fn own_part(&mut self, number: u32) -> &mut Part {
        let place = number as usize;
        if self.own.len() <= place {
            self.own.resize_with(place + 1, || None);
        }
        self.own[place].get_or_insert_default()
    }

    /// Finds the whole cavity of an own probe from a tetrahedron in conflict with its point, if
    /// nothing of its closure is another worker's. The tetrahedra around it are not looked at.
    pub(super) fn search_here(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        own: &Proposal,
        seed: TetId,
    ) -> bool {
        if self.part(own.probe).is_some() {
            return false;
        }
        let Some(cavity) = mesh.cavity_of(seed, &point(&own.to)) else { return false };
        self.enter_found(own.probe, cavity.tets());
        true
    }

    /// Enters the whole cavity of an own probe.
    pub(super) fn enter_found(&mut self, probe: ProbeId, cavity: impl Iterator<Item = TetId>) {
        let first = self.cavities.len();
        self.cavities.extend(cavity);
        let inside = first..self.cavities.len();
        self.own_part(probe.number).inside = inside;
    }

    /// Adds the tetrahedra around a cavity that is all here. Returns whether there was one, of
    /// which the places are marked as seen then.
    pub(super) fn complete(&mut self, mesh: &DomainMesh<'_>, probe: ProbeId) -> bool {
        let tets = mesh.inner.tets();
        let lacks_ring = |part: &&Part| part.order.is_empty() && !part.inside.is_empty();
        let Some(part) = self.part(probe).filter(lacks_ring) else { return false };
        let (inside, mut order) = (part.inside.clone(), self.spare.pop().unwrap_or_default());
        let cavity = &self.cavities[inside];
        self.seen.clear(tets.topology().slots());
        order.clear();
        order.reserve(3 * cavity.len() + 2);
        for (place, &t) in cavity.iter().enumerate() {
            self.seen.mark(t.index(), place as u32);
            order.push((t, true));
        }
        for &t in cavity {
            for u in tets.neighbours(t).map(tet_of) {
                if self.seen.mark(u.index(), order.len() as u32) {
                    order.push((u, false));
                }
            }
        }
        self.part_mut(probe).into_iter().for_each(|part| part.order = std::mem::take(&mut order));
        true
    }

    /// Looks at tetrahedra, and from those in conflict on. Returns the number of those known
    /// before, and the far neighbours of new ones in conflict.
    pub(super) fn search(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        own: &Proposal,
        seeds: impl Iterator<Item = TetId>,
    ) -> (usize, Vec<Handle>) {
        let p = &point(&own.to);
        self.complete(mesh, own.probe);
        self.seen.clear(mesh.inner.tets().topology().slots());
        let mut seen = std::mem::take(&mut self.seen);
        let mut memory = self.spare.pop().unwrap_or_default();
        memory.clear();
        let part = self.enter(own);
        if part.order.capacity() == 0 {
            std::mem::swap(&mut part.order, &mut memory);
        }
        if !part.order.is_empty() {
            part.inside = 0..0;
        }
        let before = part.order.len();
        for (t, _) in &part.order {
            seen.mark(t.index(), 0);
        }
        let mut foreign = Vec::new();
        let mut stack: Vec<TetId> = seeds.collect();
        // Ends: each is looked at once.
        while let Some(t) = stack.pop() {
            if !seen.mark(t.index(), 0) {
                continue;
            }
            let is_in = mesh.conflicts(t, p);
            part.order.push((t, is_in));
            if is_in {
                let tets = mesh.inner.tets();
                for u in tets.neighbours(t).map(tet_of) {
                    match tets.far(u) {
                        Some(handle) => foreign.push(handle),
                        None => stack.push(u),
                    }
                }
            }
        }
        self.seen = seen;
        if memory.capacity() > 0 {
            self.spare.push(memory);
        }
        (before, foreign)
    }

    /// A probe reserves nothing.
    pub(super) fn drop_part(&mut self, probe: ProbeId) {
        if let Some(part) = self.part_mut(probe) {
            part.is_void = true;
        }
    }

    /// The home of a probe wants to hear of rivals.
    pub(super) fn want_rivals(&mut self, probe: ProbeId) {
        if let Some(part) = self.part_mut(probe) {
            part.is_wanted = true;
        }
    }

    /// The verdict on an own probe has fallen: reserves the cavity in its part, unless void.
    pub(super) fn reserve_own(&mut self, probe: ProbeId, whose: (Rank, Carrier)) {
        let Self { own, reserved, holders, cavities, .. } = self;
        if let Some(Some(part)) = own.get_mut(probe.number as usize) {
            reserve((part, whose), cavities, reserved, holders);
        }
    }

    /// All probes have ended: reserves the cavities of others'. Returns those whose homes want to
    /// hear of rivals.
    pub(super) fn reserve_others(&mut self) -> Vec<ProbeId> {
        let Self { others, reserved, holders, .. } = self;
        let all = others.values_mut();
        all.for_each(|(part, whose)| reserve((part, *whose), &[], reserved, holders));
        let wanted = others.iter().filter(|(_, (part, _))| part.is_wanted);
        let mut wanted: Vec<ProbeId> = wanted.map(|(&probe, _)| probe).collect();
        wanted.sort_unstable();
        wanted
    }

    /// The number of the holder of a tetrahedron.
    fn holder(&self, t: TetId) -> Option<u32> {
        self.reserved.get(t.index())
    }

    /// Is a candidate before this one in the way of its own tetrahedron?
    pub(super) fn has_rival<C: Rules>(&self, t: TetId, rank: Rank) -> bool {
        // R26.
        let counts = |own: u32| {
            let key = self.holders.leads[own as usize].1.0;
            C::BREAKS_TIES || !Rank::is_tie(key, rank.key())
        };
        self.holder(t).is_some_and(|own| self.holders.is_before(own, &rank) && counts(own))
    }

    /// The rivals in a probe's part of its closure, in the order in which its home was told.
    pub(super) fn rivals(&self, probe: ProbeId) -> Vec<Rival> {
        let Some(part) = self.part(probe) else { return Vec::new() };
        let Some(own) = part.holder else { return Vec::new() };
        let (rank, carrier) = self.holders.all[own as usize];
        let rival = |(t, _): &(TetId, bool)| match self.holder(*t) {
            Some(number) if self.holders.is_before(number, &rank) => {
                let (other, at) = self.holders.all[number as usize];
                let is_apart = !is_same(at, carrier);
                Rival { is_there: true, is_boundary: other.is_boundary(), is_apart }
            }
            _ => Rival::default(),
        };
        part.order.iter().map(rival).collect()
    }

    /// Adds a probe's part to a closure that has nothing yet.
    pub(super) fn describe_here(
        &mut self,
        mesh: &DomainMesh<'_>,
        (probe, carrier): (ProbeId, Carrier),
        closure: &mut Closure,
    ) {
        let is_whole = self.complete(mesh, probe);
        let tets = mesh.inner.tets();
        self.places.clear(mesh.inner.num_vertices() + 1);
        let mut places = std::mem::take(&mut self.places);
        let order = self.part(probe).map_or(&[][..], |part| &part.order);
        let Closure { corners, tets: told, beyond } = closure;
        let mut describe = |v: [VertexId; 4], corners: &mut Vec<Corner>| {
            v.map(|v| match v {
                INFINITE => NOWHERE,
                v => {
                    let next = corners.len() as u32;
                    if places.mark(v.index(), next) {
                        corners.push(corner(mesh, v));
                    }
                    places.get(v.index()).unwrap_or(next)
                }
            })
        };
        if !is_whole {
            told.extend(order.iter().map(|&(t, is_in)| {
                let corners = told_of(mesh, t, carrier).map(|v| describe(v, corners));
                (corners.unwrap_or([NOWHERE; 4]), is_in)
            }));
            self.places = places;
            return;
        }
        let inside = order.partition_point(|own| own.1);
        told.resize(order.len(), ([NOWHERE; 4], false));
        beyond.resize(inside, [NOWHERE; 4]);
        for (k, &(t, _)) in order[..inside].iter().enumerate() {
            told[k].1 = true;
            let Some(v) = told_of(mesh, t, carrier) else { continue };
            let v = describe(v, corners);
            told[k].0 = v;
            let around = tets.neighbours(t).map(|face| self.seen.get(tet_of(face).index()));
            let around = around.map(|place| place.unwrap_or(NOWHERE));
            beyond[k] = around;
            let is_on = v.map(|v| v != NOWHERE && corners[v as usize].carrier != Carrier::Free);
            for (face, place) in OTHERS.into_iter().zip(around) {
                let is_ring = (inside..order.len()).contains(&(place as usize));
                if is_ring && face.iter().all(|&slot| is_on[slot]) {
                    let ring = order[place as usize].0;
                    told[place as usize].0 = describe(tets.vertices(ring), corners);
                }
            }
        }
        self.places = places;
    }
}

/// The numbers of those candidates inside, each with its rank, its own slot and its cavity, that no
/// candidate before them kills: the rule alone, for ports.
#[doc(hidden)]
pub fn unkilled(candidates: &[(Rank, TetId, Vec<TetId>)]) -> Vec<usize> {
    let mut served = Served::default();
    let slots = candidates.iter().flat_map(|(_, own, cavity)| cavity.iter().chain([own]));
    served.reserved.clear(slots.map(|t| t.index() + 1).max().unwrap_or(0));
    for (rank, _, cavity) in candidates {
        let order = cavity.iter().map(|&t| (t, true)).collect();
        let (mut part, whose) = (Part { order, ..Part::default() }, (*rank, Carrier::Free));
        reserve((&mut part, whose), &[], &mut served.reserved, &mut served.holders);
    }
    let dies = |k: usize| served.has_rival::<Correct>(candidates[k].1, candidates[k].0);
    (0..candidates.len()).filter(|&k| !dies(k)).collect()
}

/// Reserves the cavity in a part, unless that is void, where no candidate before it has.
fn reserve(
    (part, (rank, carrier)): (&mut Part, (Rank, Carrier)),
    cavities: &[TetId],
    reserved: &mut Marks,
    holders: &mut Holders,
) {
    if part.is_void {
        return;
    }
    let number = holders.push(rank, carrier);
    part.holder = Some(number);
    for t in part.cavity(cavities) {
        let other = reserved.get(t.index());
        if other.is_none_or(|other| holders.compare(other, &rank).is_gt()) {
            reserved.set(t.index(), number);
        }
    }
}

/// Are two boundary points on one segment, or in one facet?
fn is_same(a: Carrier, b: Carrier) -> bool {
    match (a, b) {
        (Carrier::Segment(s, _), Carrier::Segment(r, _)) => s == r,
        (Carrier::Facet(f), Carrier::Facet(g)) => f == g,
        _ => false,
    }
}

/// A corner of a tetrahedron here.
pub(super) fn corner(mesh: &DomainMesh<'_>, v: VertexId) -> Corner {
    Corner { point: mesh.point(v), carrier: mesh.carrier(v) }
}

/// May something of a tetrahedron be boundary? A subface has three corners there, an edge of which
/// no face is one is a subsegment or nothing.
pub(super) fn is_near(mesh: &DomainMesh<'_>, t: TetId) -> bool {
    let corners = mesh.inner.tets().vertices(t);
    let is_bound = corners.map(|v| mesh.is_bound(v));
    match is_bound.iter().filter(|is| **is).count() {
        0 | 1 => false,
        2 => {
            let mut ends = corners.into_iter().zip(is_bound).filter(|own| own.1);
            let mut end = || ends.next().map_or(Carrier::Free, |(v, _)| mesh.carrier(v));
            mesh.complex.segment([end(), end()]).is_some()
        }
        _ => true,
    }
}

/// The vertices of a tetrahedron in the closure of a point with this carrier, if they matter: if
/// two are on the boundary, or of a boundary item one, as its own corners have to be found.
fn told_of(mesh: &DomainMesh<'_>, t: TetId, carrier: Carrier) -> Option<[VertexId; 4]> {
    let v = mesh.inner.tets().vertices(t);
    let least = if carrier == Carrier::Free { 2 } else { 1 };
    (v.iter().filter(|&&v| mesh.is_bound(v)).count() >= least).then_some(v)
}

/// Some tetrahedra of a part, of a point with this carrier, as their home gets to know them.
pub(super) fn describe(
    mesh: &DomainMesh<'_>,
    tets: &[(TetId, bool)],
    carrier: Carrier,
) -> WireClosure {
    let mut found = WireClosure::default();
    let mut places: FxHashMap<VertexId, u32> = FxHashMap::default();
    for &(t, is_in) in tets {
        let v = told_of(mesh, t, carrier).unwrap_or([INFINITE; 4]).map(|v| match v {
            INFINITE => INFINITE_CORNER,
            v => *places.entry(v).or_insert_with(|| {
                found.corners.push(WireCorner::new(&corner(mesh, v)));
                found.corners.len() as u32 - 1
            }),
        });
        found.tets.push((v, is_in));
    }
    found
}
