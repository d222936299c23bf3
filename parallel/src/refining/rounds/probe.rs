//! The home's side of the choice: probes, what comes of them, and who is chosen.

use super::candidate::{Outcome, Probe, What};
use super::serve::{corner, describe, is_near};
use super::source::Rounds;
use super::way::{WayEnd, walk_way};
use crate::protocol::{Directory, Handle, Rules, Submesh, Walk, WorkerId};
use crate::refining::domain::DomainMesh;
use crate::refining::news::{
    Bits, DomainNews, PartEnd, ProbeId, Proposal, WireClosure, bits, point,
};
use ltbw_core::topology::{TetId, tet_of};
use ltbw_domain::refine::{Aim, BoundaryItem, Carrier, NOWHERE, Rank, Ruling, Survey, way_start};

impl<C: Rules> Rounds<C> {
    pub(super) fn id(&self, number: u32) -> ProbeId {
        ProbeId { home: self.me, number }
    }

    fn proposal(&self, number: u32) -> Proposal {
        let Probe { to, carrier, rank, .. } = self.probes[number as usize];
        Proposal { probe: self.id(number), to, carrier, rank }
    }

    /// A new probe, to be launched.
    pub(super) fn add_probe(&mut self, what: What, rank: Rank, attempt: usize) -> u32 {
        self.probes.push(Probe::new(what, rank, attempt));
        self.open += 1;
        self.probes.len() as u32 - 1
    }

    /// Launches a probe.
    pub(super) fn launch(&mut self, mesh: &mut DomainMesh<'_>, directory: &Directory, k: u32) {
        let &Probe { ref what, attempt, .. } = &self.probes[k as usize];
        if let &What::Tet(t, v) = what
            && attempt == 0
            && self.take_found(mesh, k, (t, v))
        {
            let nothing = (PartEnd::Found, WireClosure::default(), Vec::new());
            return self.take_part(mesh, directory, self.me, k, nothing);
        }
        let what = &self.probes[k as usize].what;
        let aim = match what {
            What::Tet(_, v) => mesh.complex.aim_at_tet(v.map(|v| mesh.point(v)), attempt),
            What::Item(item) => mesh.complex.aim_at_item(item, attempt),
        };
        match aim {
            Aim::At { point, carrier, may } => {
                let probe = &mut self.probes[k as usize];
                (probe.to, probe.carrier, probe.may) = (bits(&point), carrier, may);
                probe.open = 1;
                let own = self.proposal(k);
                match &self.probes[k as usize].what {
                    &What::Tet(t, v) => {
                        let start = way_start(v.map(|v| mesh.point(v)));
                        self.go(mesh, directory, own, (t, None), (bits(&start), may));
                    }
                    What::Item(item) => {
                        let near = self.pending.get(&item.place()).and_then(|own| own.near);
                        self.near = near.filter(|&t| mesh.inner.tets().is_live(t)).or(self.near);
                        self.seek(mesh, directory, own, None);
                    }
                }
            }
            Aim::Skip => self.retry(mesh, directory, k),
            Aim::Exhausted => {
                let What::Tet(_, v) = self.probes[k as usize].what else { return self.give_up(k) };
                let sides = mesh.complex.sides_of(v.map(|v| corner(mesh, v)));
                match sides.first() {
                    Some(side) => self.conclude_with(mesh, k, *side),
                    None => self.give_up(k),
                }
            }
            Aim::Refused => self.give_up(k),
        }
    }

    /// Asks the processor to fetch what the next probes begin with. A hint.
    pub(super) fn fetch_ahead(&self, mesh: &DomainMesh<'_>) {
        let next = |k: usize| match self.probes[*self.to_launch.get(k)? as usize].what {
            What::Tet(t, _) => Some(t),
            What::Item(_) => None,
        };
        let tets = mesh.inner.tets();
        if let Some(t) = next(0) {
            for t in tets.neighbours(t).map(tet_of) {
                tets.prefetch(t);
                self.served.prefetch(t);
            }
        }
        next(1).into_iter().for_each(|t| tets.prefetch(t));
    }

    /// The next attempt for what a probe is for.
    fn retry(&mut self, mesh: &mut DomainMesh<'_>, directory: &Directory, k: u32) {
        let Probe { ref what, rank, attempt, .. } = self.probes[k as usize];
        let what = what.clone();
        self.conclude(k, Outcome::Dropped);
        let next = self.add_probe(what, rank, attempt + 1);
        self.launch(mesh, directory, next);
    }

    /// Nothing can be done: the rounds end, and others go on.
    fn give_up(&mut self, k: u32) {
        self.is_irregular = true;
        self.conclude(k, Outcome::Dropped);
    }

    fn conclude_with(&mut self, mesh: &DomainMesh<'_>, k: u32, item: BoundaryItem) {
        let outcome = self.probes[k as usize].what.asks(mesh, item);
        self.conclude(k, outcome);
    }

    fn conclude(&mut self, k: u32, outcome: Outcome) {
        self.probes[k as usize].outcome = outcome;
        self.open -= 1;
    }

    /// A probe on its straight way is at one of this worker's tetrahedra.
    pub(super) fn go(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        own: Proposal,
        at: (TetId, Option<usize>),
        (start, may): (Bits, bool),
    ) {
        match walk_way(mesh, at, &start, &own.to, may) {
            WayEnd::At(t) => self.serve(mesh, directory, own, &[t]),
            WayEnd::Far(at) => {
                let owner = directory.owner(at.block);
                self.send(owner, DomainNews::Way { own, at, start, may });
            }
            WayEnd::Not(end) => {
                self.answer(mesh, directory, own.probe, end, WireClosure::default(), Vec::new());
            }
        }
    }

    /// A probe looks for a tetrahedron in conflict with its point.
    pub(super) fn seek(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        own: Proposal,
        at: Option<TetId>,
    ) {
        // Along a curve the last one is near.
        let from = at.or_else(|| self.near.filter(|&t| mesh.inner.tets().is_live(t)));
        match mesh.seek(&point(&own.to), from) {
            Walk::At(t) | Walk::Locked(t) => {
                self.near = Some(t);
                self.serve(mesh, directory, own, &[t]);
            }
            Walk::Duplicate(_) => {
                let nothing = WireClosure::default();
                self.answer(mesh, directory, own.probe, PartEnd::Vertex, nothing, Vec::new());
            }
            Walk::Exits(at) => {
                let owner = directory.owner(at.block);
                self.send(owner, DomainNews::Seek { own, at: Some(at) });
            }
            Walk::NoTets => {
                let next = WorkerId::new((self.me.number() + 1) % self.workers);
                self.send(next, DomainNews::Seek { own, at: None });
            }
        }
    }

    /// Looks at this worker's part of a closure and tells the home.
    pub(super) fn serve(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        own: Proposal,
        seeds: &[TetId],
    ) {
        let probe = own.probe;
        // A probe that others know of may ask for one that is not in conflict.
        let is_first = probe.home == self.me
            && self.probes.get(probe.number as usize).is_some_and(|own| own.told.is_none());
        if let [seed] = *seeds
            && is_first
            && self.served.search_here(mesh, &own, seed)
        {
            let nothing = (PartEnd::Found, WireClosure::default(), Vec::new());
            return self.take_part(mesh, directory, self.me, probe.number, nothing);
        }
        let (before, foreign) = self.served.search(mesh, &own, seeds.iter().copied());
        let found = match self.served.part(probe) {
            // The home knows its own.
            Some(part) if probe.home != self.me => {
                describe(mesh, &part.order[before..], own.carrier)
            }
            _ => WireClosure::default(),
        };
        self.answer(mesh, directory, probe, PartEnd::Found, found, foreign);
    }

    fn answer(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        probe: ProbeId,
        end: PartEnd,
        found: WireClosure,
        foreign: Vec<Handle>,
    ) {
        if probe.home == self.me {
            return self.take_part(mesh, directory, self.me, probe.number, (end, found, foreign));
        }
        let number = probe.number;
        self.send(probe.home, DomainNews::Part { number, end, found, foreign });
    }

    /// Takes an owner's part of a probe of this worker.
    pub(super) fn take_part(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        from: WorkerId,
        k: u32,
        (end, found, foreign): (PartEnd, WireClosure, Vec<Handle>),
    ) {
        let probe = &mut self.probes[k as usize];
        probe.open -= 1;
        match end {
            PartEnd::Found => {}
            PartEnd::Blocked(item) => return self.conclude_with(mesh, k, item.item()),
            PartEnd::Outside | PartEnd::Vertex => return self.retry(mesh, directory, k),
        }
        probe.was_searched = true;
        if from != self.me {
            let told = probe.told.get_or_insert_default();
            if !told.owners.contains(&from) {
                told.owners.push(from);
            }
            probe.add(from, &found, &mut self.spare);
        }
        let mut seeds: Vec<(WorkerId, Vec<Handle>)> = Vec::new();
        for handle in foreign {
            if probe.told.get_or_insert_default().known.insert(handle.name) {
                let owner = directory.owner(handle.block);
                match seeds.iter_mut().find(|(other, _)| *other == owner) {
                    Some((_, list)) => list.push(handle),
                    None => seeds.push((owner, vec![handle])),
                }
            }
        }
        // R25.
        if !C::ENDS_PROBES && self.asks_already(mesh, k) {
            seeds.clear();
        }
        let probe = &mut self.probes[k as usize];
        probe.open += seeds.len() as u32;
        let own = self.proposal(k);
        for (owner, seeds) in seeds {
            if owner == self.me {
                let here: Vec<TetId> =
                    seeds.iter().filter_map(|handle| mesh.resolve(handle.name)).collect();
                self.serve(mesh, directory, own, &here);
            } else {
                self.send(owner, DomainNews::Search { own, seeds });
            }
        }
        let probe = &self.probes[k as usize];
        if probe.open == 0 && probe.outcome == Outcome::Open {
            self.judge(mesh, directory, k);
        }
    }

    /// Does a tetrahedron's probe ask for an item by what is known of its closure so far? (A
    /// known-bad variant stops there.)
    fn asks_already(&self, mesh: &DomainMesh<'_>, k: u32) -> bool {
        let own = &self.probes[k as usize];
        let survey = Survey::of(&mesh.complex, own.closure());
        matches!(own.what, What::Tet(..)) && !survey.rule_on_tet(&point(&own.to)).is_empty()
    }

    /// All of a probe's closure is known: the verdict.
    fn judge(&mut self, mesh: &mut DomainMesh<'_>, directory: &Directory, k: u32) {
        let id = self.id(k);
        let probe = &mut self.probes[k as usize];
        let is_item = matches!(probe.what, What::Item(_));
        let is_near = is_item
            || self.served.cavity(id).any(|t| is_near(mesh, t))
            || probe.closure().tets.iter().any(|(v, is_in)| {
                let corners = &probe.closure().corners;
                let is_on =
                    |v: &&u32| **v != NOWHERE && corners[**v as usize].carrier != Carrier::Free;
                *is_in && v.iter().filter(is_on).count() > 1
            });
        if is_near {
            let carrier = probe.carrier;
            match &probe.told {
                None => {
                    let closure = probe.closure_in(&mut self.spare);
                    self.served.describe_here(mesh, (id, carrier), closure);
                }
                Some(_) => {
                    self.served.complete(mesh, id);
                    let all = self.served.part(id).map_or(&[][..], |part| &part.order);
                    let found = describe(mesh, all, carrier);
                    probe.add(self.me, &found, &mut self.spare);
                }
            }
        }
        let p = point(&probe.to);
        let outcome = if is_near {
            let survey = Survey::of(&mesh.complex, probe.closure());
            let has_boundary = is_item || survey.is_marked();
            let outcome = match &probe.what {
                What::Tet(..) => match survey.rule_on_tet(&p).first() {
                    Some(first) => Some(probe.what.asks(mesh, *first)),
                    None => Some(Outcome::Fits(Vec::new())),
                },
                What::Item(item) => match survey.rule_on_item(item, &p) {
                    Ruling::Fill(removed) => Some(Outcome::Fits(removed)),
                    Ruling::Defer(first) => Some(Outcome::Asks(Box::new(first[0]), None)),
                    Ruling::Useless => None,
                    Ruling::Refuse => return self.give_up(k),
                },
            };
            probe.has_boundary = has_boundary;
            outcome
        } else {
            Some(Outcome::Fits(Vec::new()))
        };
        let has_own = match probe.what {
            What::Tet(t, _) => self.served.cavity(id).any(|other| other == t),
            What::Item(_) => true,
        };
        let outcome = match outcome {
            Some(Outcome::Fits(_)) if !has_own => None,
            other => other,
        };
        let Some(outcome) = outcome else {
            self.drop_parts(k);
            return self.retry(mesh, directory, k);
        };
        let fits = matches!(outcome, Outcome::Fits(_));
        if fits {
            let of_item = || self.served.cavity(id).next();
            let tets = mesh.inner.tets();
            self.probes[k as usize].start = match self.probes[k as usize].what {
                What::Tet(t, v) => Some((t, v)),
                What::Item(_) => of_item().map(|t| (t, tets.vertices(t))),
            };
        }
        if !fits && is_item {
            // A boundary item that waits for others is in nobody's way. (R23.)
            self.drop_parts(k);
        } else if fits && self.probes[k as usize].has_boundary && C::HEARS_OF_RIVALS {
            self.want_rivals(k);
        }
        // Its tetrahedra are in the cache.
        let Probe { rank, carrier, .. } = self.probes[k as usize];
        self.served.reserve_own(id, (rank, carrier));
        self.conclude(k, outcome);
    }

    /// The owners of a probe's parts, but for this worker.
    fn others(&self, k: u32) -> Vec<WorkerId> {
        self.probes[k as usize].told.as_ref().map_or_else(Vec::new, |told| told.owners.clone())
    }

    /// A probe reserves nothing after all.
    fn drop_parts(&mut self, k: u32) {
        let id = self.id(k);
        self.served.drop_part(id);
        // R24.
        let others = if C::TAKES_BACK { self.others(k) } else { Vec::new() };
        for owner in others {
            self.counts.notes += 1;
            self.send(owner, DomainNews::Void(id));
        }
    }

    /// All owners of a probe's parts are to tell of rivals.
    fn want_rivals(&mut self, k: u32) {
        let (id, others) = (self.id(k), self.others(k));
        self.probes[k as usize].due = others.len() as u32;
        for owner in others {
            self.counts.notes += 1;
            self.send(owner, DomainNews::WantRivals(id));
        }
    }
}
