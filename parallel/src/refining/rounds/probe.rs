//! The home's side of the choice: probes, what comes of them, and who is chosen.

use super::candidate::{Outcome, Probe, Seeker, Waits, What};
use super::here::Here;
use super::ranked::rank_of;
use super::reserved::Whose;
use super::ruled::Verdict;
use super::serve::{Answer, describe};
use super::source::Rounds;
use super::way::{Begin, Entry, WayEnd, walk_way};
use crate::protocol::table::Table;
use crate::protocol::{Directory, Handle, Rules, Submesh, Walk, WorkerId};
use crate::refining::domain::{DomainMesh, FarFace, is_near};
use crate::refining::news::{DomainNews, PartEnd, ProbeId, WireClosure, bits, point};
use ltbw_core::topology::{TetId, tet_of};
use ltbw_refine::{Aim, BoundaryItem, Collected, Filled, RankLead, Reason, Ruling, middle};

impl<C: Rules> Rounds<C> {
    pub(super) fn id(&self, number: u32) -> ProbeId {
        ProbeId { home: self.me, number }
    }

    pub(super) fn seeker(&self, number: u32) -> Seeker {
        let probe = &self.choice.probes[number as usize];
        let Probe { to, carrier, .. } = *probe;
        Seeker { probe: self.id(number), to, carrier, rank: probe.rank() }
    }

    /// A new probe, to be launched.
    pub(super) fn add_probe(&mut self, what: What, lead: RankLead, attempt: usize) -> u32 {
        self.choice.probes.push(Probe::new(what, lead, attempt));
        self.choice.open += 1;
        self.choice.probes.len() as u32 - 1
    }

    /// Launches a probe.
    pub(super) fn launch(&mut self, mesh: &mut DomainMesh<'_>, directory: &Directory, k: u32) {
        let &Probe { ref what, attempt, ref sliver, .. } = &self.choice.probes[k as usize];
        if sliver.is_some() {
            return self.try_on(mesh, directory, k);
        }
        if let &What::Tet(t, v) = what
            && attempt == 0
            && self.take_found(mesh, k, (t, v))
        {
            self.note_barred(mesh, k);
            let nothing = Answer::bare(PartEnd::Found);
            return self.take_part(mesh, directory, self.me, k, nothing);
        }
        let what = &self.choice.probes[k as usize].what;
        let aim = match what {
            What::Tet(_, v) => mesh.complex.aim_at_tet(v.map(|v| mesh.point(v)), attempt),
            What::Item(item) => mesh.complex.aim_at_item(item, attempt),
        };
        match aim {
            Aim::At { point, carrier, may } => {
                let probe = &mut self.choice.probes[k as usize];
                (probe.to, probe.carrier, probe.may) = (bits(&point), carrier, may);
                probe.open = 1;
                self.note_barred(mesh, k);
                let own = &self.seeker(k);
                match &self.choice.probes[k as usize].what {
                    &What::Tet(t, v) => {
                        let start = middle(v.map(|v| mesh.point(v)));
                        let begin = Begin { start: bits(&start), may };
                        self.go(mesh, directory, own, Entry { t, by: None }, begin);
                    }
                    What::Item(item) => {
                        let near = self.demands.pending.get(&item.place()).and_then(|own| own.near);
                        self.choice.near =
                            near.filter(|&t| mesh.inner.tets().is_live(t)).or(self.choice.near);
                        self.seek(mesh, directory, own, None);
                    }
                }
            }
            Aim::Skip => self.retry(mesh, directory, k),
            Aim::Exhausted => {
                let What::Tet(t, v) = self.choice.probes[k as usize].what else {
                    return self.refuse_without_aim(mesh, k);
                };
                match self.choice.probes[k as usize].sides(mesh, t, v) {
                    Some(sides) => self.conclude_with(mesh, k, &sides),
                    None => self.ask_beyond(mesh, directory, k),
                }
            }
            Aim::Refused => self.refuse(mesh, k, Reason::Floor),
        }
    }

    /// Asks the processor to fetch what the next probes begin with. A hint.
    pub(super) fn fetch_ahead(&self, mesh: &DomainMesh<'_>) {
        let next = |k: usize| match self.choice.probes[*self.choice.to_launch.get(k)? as usize].what
        {
            What::Tet(t, _) => Some(t),
            What::Item(_) => None,
        };
        let tets = mesh.inner.tets();
        if let Some(t) = next(0) {
            for t in tets.neighbours(t).map(tet_of) {
                tets.prefetch(t);
                self.served.reserved.prefetch(t);
            }
        }
        next(1).into_iter().for_each(|t| tets.prefetch(t));
    }

    /// The next attempt for what a probe is for.
    fn retry(&mut self, mesh: &mut DomainMesh<'_>, directory: &Directory, k: u32) {
        let Probe { ref what, lead, attempt, .. } = self.choice.probes[k as usize];
        let what = what.clone();
        // Of an item one search counts.
        if matches!(what, What::Item(_)) {
            self.choice.probes[k as usize].was_searched = false;
        }
        self.conclude(k, Outcome::Dropped);
        let next = self.add_probe(what, lead, attempt + 1);
        self.pass_turn_on(k, next);
        self.launch(mesh, directory, next);
    }

    /// Nothing can be done: the rounds end, and others go on.
    pub(super) fn give_up(&mut self, mesh: &DomainMesh<'_>, k: u32) {
        self.is_irregular = true;
        self.conclude(k, Outcome::Dropped);
        self.report(mesh, k);
    }

    pub(super) fn conclude_with(&mut self, mesh: &DomainMesh<'_>, k: u32, first: &[BoundaryItem]) {
        let what = &self.choice.probes[k as usize].what;
        let outcome = what.asks(mesh, first, &self.past(what));
        self.conclude(k, outcome);
        self.report(mesh, k);
    }

    pub(super) fn conclude(&mut self, k: u32, outcome: Outcome) {
        self.choice.probes[k as usize].outcome = outcome;
        self.choice.open -= 1;
    }

    /// A probe on its straight way is at one of this worker's tetrahedra.
    pub(super) fn go(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        own: &Seeker,
        at: Entry,
        Begin { start, may }: Begin,
    ) {
        match walk_way(mesh, at, &start, &own.to, may) {
            WayEnd::At(_) if self.is_barred(own.probe) => {
                self.answer(mesh, directory, own.probe, Answer::bare(PartEnd::Found));
            }
            WayEnd::At(t) => self.serve(mesh, directory, own, &[t]),
            WayEnd::Far(FarFace { at, region }) => {
                let owner = directory.owner(at.block);
                let own = own.proposal(|v| rank_of::<C>(mesh, v));
                self.send(owner, DomainNews::Way { own, at, start, may, region });
            }
            WayEnd::Not(end) => {
                self.answer(mesh, directory, own.probe, Answer::bare(end));
            }
        }
    }

    /// A probe looks for a tetrahedron in conflict with its point.
    pub(super) fn seek(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        own: &Seeker,
        at: Option<TetId>,
    ) {
        // Along a curve the last one is near.
        let from = at.or_else(|| self.choice.near.filter(|&t| mesh.inner.tets().is_live(t)));
        match mesh.seek(&point(&own.to), from) {
            Walk::At(t) | Walk::Locked(t) => {
                self.choice.near = Some(t);
                self.serve(mesh, directory, own, &[t]);
            }
            Walk::Duplicate(_) => {
                self.answer(mesh, directory, own.probe, Answer::bare(PartEnd::Vertex));
            }
            Walk::Exits(at) => {
                let owner = directory.owner(at.block);
                let own = own.proposal(|v| rank_of::<C>(mesh, v));
                self.send(owner, DomainNews::Seek { own, at: Some(at) });
            }
            Walk::NoTets => {
                let next = WorkerId::new((self.me.number() + 1) % self.workers);
                let own = own.proposal(|v| rank_of::<C>(mesh, v));
                self.send(next, DomainNews::Seek { own, at: None });
            }
        }
    }

    /// Looks at this worker's part of a closure and tells the home.
    pub(super) fn serve(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        own: &Seeker,
        seeds: &[TetId],
    ) {
        let probe = own.probe;
        // A probe that others know of may ask for one that is not in conflict.
        let is_first = probe.home == self.me
            && self.choice.probes.get(probe.number as usize).is_some_and(|own| own.told.is_none());
        if let [seed] = *seeds
            && is_first
            && self.served.search_here(mesh, own, seed)
        {
            let nothing = Answer::bare(PartEnd::Found);
            return self.take_part(mesh, directory, self.me, probe.number, nothing);
        }
        let (before, foreign) = self.served.search(mesh, own, seeds.iter().copied());
        let found = match self.served.part(probe) {
            // The home knows its own.
            Some(part) if probe.home != self.me => {
                describe(mesh, &part.order[before..], own.carrier, own.rank.lead.is_sliver())
            }
            _ => WireClosure::default(),
        };
        self.answer(mesh, directory, probe, Answer { end: PartEnd::Found, found, foreign });
    }

    pub(super) fn answer(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        probe: ProbeId,
        answer: Answer,
    ) {
        let number = probe.number;
        if probe.home == self.me {
            return self.take_part(mesh, directory, self.me, number, answer);
        }
        let Answer { end, found, foreign } = answer;
        self.send(probe.home, DomainNews::Part { number, end, found, foreign });
    }

    /// Takes an owner's part of a probe of this worker.
    pub(super) fn take_part(
        &mut self,
        mesh: &mut DomainMesh<'_>,
        directory: &Directory,
        from: WorkerId,
        k: u32,
        Answer { end, found, foreign }: Answer,
    ) {
        let probe = &mut self.choice.probes[k as usize];
        probe.open -= 1;
        if (probe.follows || probe.barred.is_some()) && self.end_barred(mesh, from, k, &end) {
            return;
        }
        let probe = &mut self.choice.probes[k as usize];
        match end {
            PartEnd::Found if probe.asks_beyond => {
                return self.take_beyond(mesh, directory, from, k, &found);
            }
            PartEnd::Found => {}
            end if probe.sliver.is_some() => return self.end_try(mesh, directory, k, end),
            PartEnd::Blocked(item) => return self.conclude_with(mesh, k, &[item.item()]),
            PartEnd::Outside | PartEnd::Vertex => return self.retry(mesh, directory, k),
        }
        probe.was_searched = true;
        if from != self.me {
            let told = probe.told.get_or_insert_default();
            if !told.owners.contains(&from) {
                told.owners.push(from);
            }
            told.add(from, &found);
        }
        let far = foreign.len();
        let mut seeds: Table<WorkerId, Vec<Handle>> = Table::default();
        for handle in foreign {
            if probe.told.get_or_insert_default().known.insert_new(handle.name, || ()) {
                let owner = directory.owner(handle.block);
                seeds.entry(owner, || Vec::with_capacity(far)).push(handle);
            }
        }
        // R25.
        if !C::ends_probes() && self.asks_already(mesh, k) {
            seeds.clear();
        }
        let probe = &mut self.choice.probes[k as usize];
        probe.open += seeds.len() as u32;
        if seeds.len() == 0 {
            return self.judge_if_known(mesh, directory, k);
        }
        let own = &self.seeker(k);
        let proposal = own.proposal(|v| rank_of::<C>(mesh, v));
        for (owner, seeds) in seeds.into_entries() {
            if owner == self.me {
                let here: Vec<TetId> =
                    seeds.iter().filter_map(|handle| mesh.resolve(handle.name)).collect();
                self.serve(mesh, directory, own, &here);
            } else {
                self.send(owner, DomainNews::Search { own: proposal, seeds });
            }
        }
        self.judge_if_known(mesh, directory, k);
    }

    /// Does a tetrahedron's probe ask for an item by what is known of its closure so far? (A
    /// known-bad variant stops there.)
    fn asks_already(&self, mesh: &DomainMesh<'_>, k: u32) -> bool {
        let own = &self.choice.probes[k as usize];
        let (What::Tet(..), Some(told)) = (&own.what, &own.told) else { return false };
        let closure = Collected::of(&told.closure);
        matches!(own.survey(mesh, &closure).rule_on_tet(), Ruling::Defer(_))
    }

    /// Judges a probe of whose closure all is known.
    fn judge_if_known(&mut self, mesh: &mut DomainMesh<'_>, directory: &Directory, k: u32) {
        let probe = &self.choice.probes[k as usize];
        if probe.open == 0 && probe.outcome == Outcome::Open {
            self.judge(mesh, directory, k);
        }
    }

    /// Adds this worker's part to a closure of which others have told, unless no part of it can be
    /// boundary. Returns whether it may be.
    pub(super) fn complete(&mut self, mesh: &DomainMesh<'_>, k: u32) -> bool {
        let (me, id) = (self.me, self.id(k));
        let meets_boundary = self.choice.probes[k as usize].may_meet_boundary(mesh);
        let Probe { carrier, ref mut told, ref sliver, .. } = self.choice.probes[k as usize];
        let told = told.get_or_insert_default();
        let closure = &told.closure;
        let count = |place: usize| closure.bound(place).into_iter().filter(|on| *on).count();
        let mut cavity = (0..closure.tets.len()).filter(|&place| closure.tets[place].1);
        let is_near = meets_boundary
            || self.served.cavity(id).any(|t| is_near(mesh, t))
            || cavity.any(|place| count(place) > 1);
        if is_near {
            let all = self.served.part(id).map_or(&[][..], |part| &part.order);
            told.add(me, &describe(mesh, all, carrier, sliver.is_some()));
        }
        is_near
    }

    /// The verdict on a probe whose closure is all here, and what makes it wait then.
    fn rule_here(&mut self, mesh: &DomainMesh<'_>, k: u32) -> (Verdict, Option<Waits>) {
        let (id, probe) = (self.id(k), &self.choice.probes[k as usize]);
        let cavity = self.served.cavity_at(&self.served.inside(id));
        let here = Here::of(mesh, cavity);
        let past = self.past(&probe.what);
        if !probe.may_meet_boundary(mesh) && !cavity.iter().any(|&t| is_near(mesh, t)) {
            let verdict = Verdict::Is(Outcome::Fits(Filled::default()));
            debug_assert!(probe.rules_so_by_values(&here, &verdict, None, &past));
            return (verdict, None);
        }
        let (verdict, watch) = probe.rule(mesh, &probe.survey(mesh, &here), &past);
        debug_assert!(probe.rules_so_by_values(&here, &verdict, watch.as_ref(), &past));
        // Without candidates of the boundary it does not matter who else is near.
        let all = match &watch {
            Some(_) if self.choice.has_boundary && !self.has_turns(mesh) => {
                self.served.list_closure(mesh, id)
            }
            _ => 0..0,
        };
        (verdict, watch.map(|watch| Waits::Here(watch, all)))
    }

    /// The verdict on a probe of whose closure others have told, and what makes it wait then.
    fn rule_told(&mut self, mesh: &DomainMesh<'_>, k: u32) -> (Verdict, Option<Waits>) {
        let may_be_boundary = self.complete(mesh, k);
        let probe = &self.choice.probes[k as usize];
        let Some(told) = probe.told.as_ref().filter(|_| may_be_boundary) else {
            return (Verdict::Is(Outcome::Fits(Filled::default())), None);
        };
        let closure = Collected::of(&told.closure);
        let past = self.past(&probe.what);
        let (verdict, watch) = probe.rule(mesh, &probe.survey(mesh, &closure), &past);
        (verdict, watch.map(Waits::Told))
    }

    /// All of a probe's closure is known: the verdict.
    fn judge(&mut self, mesh: &mut DomainMesh<'_>, directory: &Directory, k: u32) {
        let id = self.id(k);
        if self.choice.probes[k as usize].sliver.is_some() {
            return self.judge_try(mesh, directory, k);
        }
        let (verdict, waits) = match self.served.inside(id).is_empty() {
            true => self.rule_told(mesh, k),
            false => self.rule_here(mesh, k),
        };
        let has_own = match self.choice.probes[k as usize].what {
            What::Tet(t, _) => self.served.cavity(id).any(|other| other == t),
            What::Item(_) => true,
        };
        let outcome = match verdict {
            Verdict::Blocked(reason, blocks) => {
                self.tell_blocks(&blocks);
                Some(Outcome::Refused(reason))
            }
            Verdict::Is(Outcome::Fits(_)) if !has_own => None,
            Verdict::Is(outcome) => Some(outcome),
            Verdict::Useless => None,
        };
        let Some(outcome) = outcome else {
            self.pass(mesh, k);
            self.drop_parts(k);
            return self.retry(mesh, directory, k);
        };
        let probe = &mut self.choice.probes[k as usize];
        let is_item = matches!(probe.what, What::Item(_));
        let fits = matches!(outcome, Outcome::Fits(_));
        if fits {
            self.choice.fits += 1;
            if is_item {
                let tets = mesh.inner.tets();
                probe.start = self.served.cavity(id).next().map(|t| (t, tets.vertices(t)));
            }
        }
        if probe.turn.is_some() {
            probe.waits = waits.map(Box::new);
            self.conclude(k, outcome);
            return self.report(mesh, k);
        }
        if !fits && (is_item || matches!(outcome, Outcome::Refused(_))) {
            // A boundary item that waits for others is in nobody's way, nor is what is refused.
            // (R24.)
            self.drop_parts(k);
            return self.conclude(k, outcome);
        }
        if fits && let Some(waits) = waits {
            probe.waits = Some(Box::new(waits));
            // R23.
            if C::hears_of_rivals() {
                self.want_rivals(k);
            }
        }
        // Its tetrahedra are in the cache.
        let probe = &self.choice.probes[k as usize];
        self.served.reserve_own::<C>(
            mesh,
            id,
            Whose { rank: probe.rank(), carrier: probe.carrier },
        );
        self.conclude(k, outcome);
    }

    /// The owners of a probe's parts, but for this worker.
    fn others(&self, k: u32) -> Vec<WorkerId> {
        self.choice.probes[k as usize]
            .told
            .as_ref()
            .map_or_else(Vec::new, |told| told.owners.clone())
    }

    /// A probe reserves nothing after all.
    pub(super) fn drop_parts(&mut self, k: u32) {
        let id = self.id(k);
        self.served.drop_part(id);
        // R24.
        let others = if C::takes_back() { self.others(k) } else { Vec::new() };
        for owner in others {
            self.counts.notes += 1;
            self.send(owner, DomainNews::Void(id));
        }
    }

    /// All owners of a probe's parts are to tell of rivals.
    pub(super) fn want_rivals(&mut self, k: u32) {
        let (id, others) = (self.id(k), self.others(k));
        if let Some(told) = &mut self.choice.probes[k as usize].told {
            told.due = others.len() as u32;
        }
        for owner in others {
            self.counts.notes += 1;
            self.send(owner, DomainNews::WantRivals(id));
        }
    }
}
