//! The owner's side of the choice: searches, reservations, and what rivals there are.

use super::candidate::Seeker;
use super::ranked::rank_of;
use super::reserved::{LazyRank, Marks, Reservations, Whose};
use crate::protocol::{Handle, Rules, WorkerId};
use crate::refining::domain::DomainMesh;
use crate::refining::news::{INFINITE_CORNER, PartEnd, ProbeId, WireClosure, WireCorner, point};
use ltbw_core::expect;
use ltbw_core::topology::{INFINITE, TetId, VertexId, tet_of};
use ltbw_refine::{Carrier, Rank, Rival};
use rustc_hash::FxHashMap;
use std::ops::Range;

/// A tetrahedron of a closure.
#[derive(Clone, Copy, Debug)]
pub(super) struct LookedAt {
    pub(super) t: TetId,
    /// Is it in conflict with the point?
    pub(super) is_in: bool,
}

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
    /// The tetrahedra looked at, in the order in which the home was told; none if all of the
    /// closure is here.
    pub(super) order: Vec<LookedAt>,
}

/// An owner's answer to a probe.
#[derive(Debug)]
pub(super) struct Answer {
    pub(super) end: PartEnd,
    /// The part of the closure here.
    pub(super) found: WireClosure,
    /// Others' tetrahedra to go on with.
    pub(super) foreign: Vec<Handle>,
}

impl Answer {
    /// An answer that tells no part of a closure.
    pub(super) fn bare(end: PartEnd) -> Self {
        Self { end, found: WireClosure::default(), foreign: Vec::new() }
    }
}

impl Part {
    /// The tetrahedra in conflict; `cavities` has those of closures that are all here.
    fn cavity<'p>(&'p self, cavities: &'p [TetId]) -> impl Iterator<Item = TetId> + 'p {
        let order = if self.inside.is_empty() { &self.order[..] } else { &[] };
        let inside = cavities[self.inside.clone()].iter().copied();
        inside.chain(order.iter().filter(|own| own.is_in).map(|own| own.t))
    }
}

/// The parts that this worker has been asked for in a round.
#[derive(Debug, Default)]
pub(super) struct Served {
    me: WorkerId,
    /// The parts of own probes, by their numbers.
    own: Vec<Option<Part>>,
    /// The parts of others' probes, with the ranks and the carriers of these until they reserve.
    others: FxHashMap<ProbeId, (Part, Option<Whose>)>,
    pub(super) reserved: Reservations,
    /// The cavities of own probes whose closures are all here.
    cavities: Vec<TetId>,
    /// The memory of parts of rounds before.
    spare: Vec<Vec<LookedAt>>,
    /// Scratch: tetrahedra that a search has seen, and those that it has to look at.
    seen: Marks,
    stack: Vec<TetId>,
}

impl Served {
    /// The parts of worker `me`.
    pub(super) fn new(me: WorkerId) -> Self {
        Self { me, ..Self::default() }
    }

    /// Takes memory for about this many tetrahedra. A hint.
    pub(super) fn expect_tets(&mut self, tets: usize) {
        self.reserved.expect_tets(tets);
        expect(&mut self.seen.all, tets);
    }

    /// Starts a round.
    pub(super) fn clear(&mut self, mesh: &DomainMesh<'_>) {
        let others = self.others.drain().map(|(_, (part, _))| part);
        let ended = self.own.drain(..).flatten().chain(others);
        let orders = ended.map(|part| part.order);
        self.spare.extend(orders.filter(|order| order.capacity() > 0));
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
    fn enter(&mut self, own: &Seeker) -> &mut Part {
        let ProbeId { home, number } = own.probe;
        if home != self.me {
            let new = || (Part::default(), Some(own.whose()));
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
        own: &Seeker,
        seed: TetId,
    ) -> bool {
        if self.part(own.probe).is_some() {
            return false;
        }
        let Some(cavity) = mesh.cavity_of(seed, &point(&own.to)) else { return false };
        self.enter_found(own.probe, cavity);
        true
    }

    /// Enters the whole cavity of an own probe.
    pub(super) fn enter_found(&mut self, probe: ProbeId, cavity: &[TetId]) {
        let first = self.cavities.len();
        // Its reservations are asked for when the verdict has fallen.
        cavity.iter().for_each(|&t| self.reserved.prefetch(t));
        self.cavities.extend_from_slice(cavity);
        let inside = first..self.cavities.len();
        self.own_part(probe.number).inside = inside;
    }

    /// Looks at tetrahedra, and from those in conflict on. Returns the number of those known
    /// before, and the far neighbours of new ones in conflict.
    pub(super) fn search(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        own: &Seeker,
        seeds: impl Iterator<Item = TetId>,
    ) -> (usize, Vec<Handle>) {
        let p = &point(&own.to);
        debug_assert!(self.inside(own.probe).is_empty(), "nothing is left to look for");
        self.seen.clear(mesh.inner.tets().topology().slots());
        let mut seen = std::mem::take(&mut self.seen);
        let mut stack = std::mem::take(&mut self.stack);
        let mut memory = self.spare.pop().unwrap_or_default();
        memory.clear();
        let part = self.enter(own);
        if part.order.capacity() == 0 {
            std::mem::swap(&mut part.order, &mut memory);
        }
        let before = part.order.len();
        for own in &part.order {
            seen.mark(own.t.index());
        }
        let mut foreign = Vec::new();
        stack.extend(seeds);
        // Ends: each is looked at once.
        while let Some(t) = stack.pop() {
            if !seen.mark(t.index()) {
                continue;
            }
            let is_in = mesh.conflicts(t, p);
            part.order.push(LookedAt { t, is_in });
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
        (self.seen, self.stack) = (seen, stack);
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

    /// The verdict on an own probe has fallen: reserves the cavity in its part.
    pub(super) fn reserve_own<C: Rules>(
        &mut self,
        mesh: &DomainMesh<'_>,
        probe: ProbeId,
        whose: Whose,
    ) {
        let Self { own, reserved, cavities, .. } = self;
        if let Some(Some(part)) = own.get_mut(probe.number as usize) {
            let cavity = part.cavity(cavities);
            part.holder = Some(reserved.reserve(cavity, whose, |v| rank_of::<C>(mesh, v)));
        }
    }

    /// All probes have ended: reserves the cavities of others', unless void. Returns those whose
    /// homes want to hear of rivals.
    pub(super) fn reserve_others<C: Rules>(&mut self, mesh: &DomainMesh<'_>) -> Vec<ProbeId> {
        let Self { others, reserved, .. } = self;
        for (part, whose) in others.values_mut().filter(|(part, _)| !part.is_void) {
            if let Some(whose) = whose.take() {
                let cavity = part.cavity(&[]);
                part.holder = Some(reserved.reserve(cavity, whose, |v| rank_of::<C>(mesh, v)));
            }
        }
        let wanted = others.iter().filter(|(_, (part, _))| part.is_wanted);
        let mut wanted: Vec<ProbeId> = wanted.map(|(&probe, _)| probe).collect();
        wanted.sort_unstable();
        wanted
    }

    /// Is a candidate before an own probe with this rank in the way of its tetrahedron?
    pub(super) fn has_rival<C: Rules>(
        &self,
        mesh: &DomainMesh<'_>,
        probe: ProbeId,
        t: TetId,
        rank: &LazyRank,
    ) -> bool {
        let own = self.part(probe).and_then(|part| part.holder);
        let before = self.reserved.before(t, own, rank, |v| rank_of::<C>(mesh, v));
        // R26.
        before.is_some_and(|other| C::breaks_ties() || !Rank::is_tie(other.key(), rank.lead.key()))
    }

    /// Tells the rival of a probe that a tetrahedron has.
    pub(super) fn rival<C: Rules>(
        &self,
        mesh: &DomainMesh<'_>,
        probe: ProbeId,
    ) -> impl Fn(TetId) -> Rival {
        let own = self.part(probe).and_then(|part| part.holder);
        move |t| match own {
            Some(own) => self.reserved.rival(t, own, |v| rank_of::<C>(mesh, v)),
            None => Rival::default(),
        }
    }

    /// The rivals in a probe's part of its closure, in the order in which its home was told.
    pub(super) fn rivals<C: Rules>(&self, mesh: &DomainMesh<'_>, probe: ProbeId) -> Vec<Rival> {
        let order = self.part(probe).map_or(&[][..], |part| &part.order);
        let rival = self.rival::<C>(mesh, probe);
        order.iter().map(|own| rival(own.t)).collect()
    }

    /// Lists the closure of an own probe that is all here, some tetrahedra of it more than once.
    pub(super) fn list_closure(&mut self, mesh: &DomainMesh<'_>, probe: ProbeId) -> Range<usize> {
        let (inside, first) = (self.inside(probe), self.cavities.len());
        for k in inside {
            let t = self.cavities[k];
            self.cavities.push(t);
            self.cavities.extend(mesh.inner.tets().neighbours(t).map(tet_of));
        }
        first..self.cavities.len()
    }
}

/// The vertices of a tetrahedron in the closure of a point with this carrier, if they matter: if
/// two are on the boundary, or of a boundary item one, as its own corners have to be found; where
/// there are patches all do.
fn told_of(mesh: &DomainMesh<'_>, t: TetId, carrier: Carrier) -> Option<[VertexId; 4]> {
    let v = mesh.inner.tets().vertices(t);
    let least = match carrier {
        _ if mesh.complex.has_patches() => 0,
        Carrier::Free => 2,
        // Limits are about all vertices around.
        _ if mesh.complex.has_angles() => 0,
        _ => 1,
    };
    (v.iter().filter(|&&v| mesh.is_bound(v)).count() >= least).then_some(v)
}

/// Some tetrahedra of a part, of a point with this carrier, as their home gets to know them: of
/// those of a sliver's point all is told.
pub(super) fn describe(
    mesh: &DomainMesh<'_>,
    tets: &[LookedAt],
    carrier: Carrier,
    is_sliver: bool,
) -> WireClosure {
    let tets_told = Vec::with_capacity(tets.len());
    let mut found = WireClosure { tets: tets_told, ..WireClosure::default() };
    if mesh.complex.has_patches() || is_sliver {
        found.regions.extend(tets.iter().map(|own| mesh.region(own.t)));
    }
    if mesh.complex.has_patches() {
        found.slots.extend(tets.iter().map(|own| own.t));
    }
    let mut places: FxHashMap<VertexId, u32> = FxHashMap::default();
    for &LookedAt { t, is_in } in tets {
        let v = match is_sliver {
            true => mesh.inner.tets().vertices(t),
            false => told_of(mesh, t, carrier).unwrap_or([INFINITE; 4]),
        };
        let v = v.map(|v| match v {
            INFINITE => INFINITE_CORNER,
            v => *places.entry(v).or_insert_with(|| {
                found.corners.push(WireCorner::new(&mesh.corner(v)));
                found.corners.len() as u32 - 1
            }),
        });
        found.tets.push((v, is_in));
    }
    found
}
