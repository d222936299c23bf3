//! `check_p1` to `check_p12`: the invariants of `docs/protocol.md` between two steps, over all
//! workers and all messages under way.
//!
//! Models, interleavings and simulations call [`Between::check`]; it costs time in proportion to
//! the whole mesh. What a state cannot show, that a name is never given again and that an attempt
//! is one above the last, is in [`History`].

mod history;
mod news;
mod view;

pub use history::History;
pub use news::{NewsNumbers, count_news};
pub use view::{OperationView, RequestView};

use crate::protocol::{
    BlockId, Broken, Invariant, Message, Name, Neighbour, Phase, Request, Rule, Rules, Source,
    Submesh, Ticket, Waiter, Want, Worker, WorkerId,
};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// A tetrahedron as checkers see it.
#[derive(Clone, Debug)]
pub struct Seen<T> {
    /// Its local handle.
    pub tet: T,
    /// Its name, if it has one.
    pub name: Option<Name>,
    /// Its vertices, in an order that depends on them alone: what tells it from all others.
    pub vertices: Vec<u64>,
    /// Its block.
    pub block: BlockId,
    /// The operation that has locked it.
    pub holder: Option<Ticket>,
    /// Its face neighbours.
    pub links: Vec<Neighbour<T>>,
}

/// A tetrahedron in a message: its name, and its vertices as in [`Seen::vertices`].
pub type Sent = (Option<Name>, Vec<u64>);

/// A submesh as checkers see it.
pub trait Inspect: Submesh {
    /// All its tetrahedra.
    fn seen(&self) -> Vec<Seen<Self::Tet>>;

    /// The tetrahedra that a patch makes.
    fn made(patch: &Self::Patch) -> Vec<Sent>;

    /// The names that a patch gives to tetrahedra which had none.
    fn named(patch: &Self::Patch) -> Vec<Name> {
        let _ = patch;
        Vec::new()
    }

    /// The tetrahedra that change their owner.
    fn carried(cargo: &Self::Cargo) -> Vec<Sent>;

    /// The kinds of news that a message brings: those that barriers wait for.
    fn kinds(news: &Self::News) -> Vec<&'static str> {
        let _ = news;
        Vec::new()
    }
}

/// The whole system between two steps.
pub struct Between<'a, S: Submesh, Q, C> {
    workers: Vec<&'a Worker<S, Q, C>>,
    /// Sender, receiver, message.
    under_way: Vec<UnderWay<'a, S>>,
    /// By worker.
    seen: Vec<Vec<Seen<S::Tet>>>,
    /// By name: where it is.
    places: HashMap<Name, (usize, usize)>,
    /// Tetrahedra in messages.
    sent: Vec<Sent>,
    /// Names of tetrahedra in messages, and names that a commit under way gives.
    names: HashSet<Name>,
    /// Do the workers count their messages?
    counts: bool,
}

/// The first broken invariant, if there is one.
pub type Check = Result<(), Broken>;

/// Fails with `what` unless `holds`.
fn require(invariant: Invariant, holds: bool, what: impl FnOnce() -> String) -> Check {
    if holds { Ok(()) } else { Err(Broken { invariant, what: what() }) }
}

/// A message under way.
#[derive(Debug)]
pub struct UnderWay<'a, S: Submesh> {
    /// Its sender.
    pub from: WorkerId,
    /// Its receiver.
    pub to: WorkerId,
    /// The message.
    pub message: &'a Message<S>,
}

impl<'a, S: Inspect, Q: Source<S>, C: Rules> Between<'a, S, Q, C> {
    /// Takes a look at all workers, and at all messages under way.
    pub fn new(
        workers: impl IntoIterator<Item = &'a Worker<S, Q, C>>,
        under_way: impl IntoIterator<Item = UnderWay<'a, S>>,
    ) -> Self {
        let workers: Vec<_> = workers.into_iter().collect();
        let under_way: Vec<_> = under_way.into_iter().collect();
        let seen: Vec<_> = workers.iter().map(|worker| worker.mesh.seen()).collect();
        let mut places = HashMap::new();
        for (w, tets) in seen.iter().enumerate() {
            for (k, tet) in tets.iter().enumerate() {
                places.extend(tet.name.map(|name| (name, (w, k))));
            }
        }
        let (mut sent, mut names) = (Vec::new(), HashSet::new());
        for UnderWay { message, .. } in &under_way {
            match message {
                Message::Commit { patch: Some(patch), .. } => {
                    sent.extend(S::made(patch));
                    names.extend(S::named(patch));
                }
                Message::Migrate { cargo, .. } | Message::Stray { cargo, .. } => {
                    sent.extend(S::carried(cargo));
                }
                _ => {}
            }
        }
        names.extend(sent.iter().filter_map(|(name, _)| *name));
        Self { workers, under_way, seen, places, sent, names, counts: true }
    }

    /// The look without counts of messages, for workers that do not keep them.
    pub fn without_counts(self) -> Self {
        Self { counts: false, ..self }
    }

    /// All invariants.
    ///
    /// # Errors
    /// The first one that is broken.
    pub fn check(&self) -> Check {
        let checks = [
            Self::check_p1,
            Self::check_p2,
            Self::check_p3,
            Self::check_p4,
            Self::check_p5,
            Self::check_p6,
            Self::check_p7,
            Self::check_p8,
            Self::check_p9,
            Self::check_p10,
            Self::check_p11,
            Self::check_p12,
        ];
        checks.into_iter().try_for_each(|check| check(self))
    }

    fn tets(&self) -> impl Iterator<Item = (usize, &Seen<S::Tet>)> {
        self.seen.iter().enumerate().flat_map(|(w, tets)| tets.iter().map(move |t| (w, t)))
    }

    /// Is a message of this kind under way to `to`?
    fn is_sent(&self, to: usize, kind: impl Fn(&Message<S>) -> bool) -> bool {
        self.under_way.iter().any(|letter| letter.to.index() == to && kind(letter.message))
    }

    fn commits(&self, to: usize, holder: Option<Ticket>) -> bool {
        let Some(holder) = holder else { return false };
        self.is_sent(to, |m| matches!(m, Message::Commit { ticket, .. } if *ticket == holder))
    }

    fn check_p1(&self) -> Check {
        self.tets().try_for_each(|(w, tet)| {
            let is_far = tet.links.iter().any(|link| matches!(link, Neighbour::Far(_)));
            require(Invariant::P1, !is_far || tet.name.is_some(), || {
                format!("worker {w}: {tet:?} has a far neighbour and no name")
            })
        })
    }

    fn check_p2(&self) -> Check {
        let here = self.tets().filter_map(|(_, tet)| tet.name);
        let mut names = HashSet::new();
        here.chain(self.sent.iter().filter_map(|(name, _)| *name)).try_for_each(|name| {
            require(Invariant::P2, names.insert(name), || format!("{name:?} is there twice"))
        })
    }

    fn check_p3(&self) -> Check {
        let blocks = self.workers.first().map_or(0, |worker| worker.directory.blocks().len());
        let mut owners = vec![0; blocks];
        for worker in &self.workers {
            for block in worker.directory.blocks().filter(|&b| worker.directory.is_mine(b)) {
                owners[block.index()] += 1;
            }
        }
        for UnderWay { message, .. } in &self.under_way {
            if let Message::Migrate { block, .. } = message {
                owners[block.index()] += 1;
            }
        }
        owners.iter().enumerate().try_for_each(|(block, &count)| {
            require(Invariant::P3, count == 1, || format!("block {block} is at {count} places"))
        })
    }

    fn check_p4(&self) -> Check {
        let mut all = HashSet::new();
        let here = self.tets().map(|(_, tet)| &tet.vertices);
        here.chain(self.sent.iter().map(|(_, vertices)| vertices)).try_for_each(|vertices| {
            require(Invariant::P4, all.insert(vertices), || format!("{vertices:?} is there twice"))
        })
    }

    fn check_p5(&self) -> Check {
        for (w, worker) in self.workers.iter().enumerate() {
            let mut held: BTreeMap<S::Tet, Ticket> = BTreeMap::new();
            for (&ticket, request) in &worker.locks.requests {
                for &t in &request.held {
                    require(Invariant::P5, held.insert(t, ticket).is_none(), || {
                        format!("worker {w}: {t:?} is held twice, by {ticket:?}")
                    })?;
                }
            }
            let locked = self.seen[w].iter().filter_map(|tet| Some((tet.tet, tet.holder?)));
            let locked: BTreeMap<S::Tet, Ticket> = locked.collect();
            require(Invariant::P5, held == locked, || {
                format!("worker {w}: requests hold {held:?}, locked are {locked:?}")
            })?;
        }
        Ok(())
    }

    fn check_p6(&self) -> Check {
        for (w, worker) in self.workers.iter().enumerate() {
            let links = self.seen[w].iter().map(|tet| (tet.tet, tet));
            let links: HashMap<S::Tet, &Seen<S::Tet>> = links.collect();
            for (&ticket, request) in &worker.locks.requests {
                // Once the operation is set back, other owners have released what is beside it.
                if !self.is_collecting(ticket, request) {
                    continue;
                }
                for want in &request.wants {
                    require(Invariant::P6, self.is_reachable(request, want, &links), || {
                        format!("worker {w}: {ticket:?} wants {want:?}, beside nothing it holds")
                    })?;
                }
            }
        }
        Ok(())
    }

    /// Does the home still collect the attempt of this request?
    fn is_collecting(&self, ticket: Ticket, request: &Request<S>) -> bool {
        let home = self.workers.get(request.home.index());
        let op = home.and_then(|home| home.operations.all.get(&ticket));
        op.is_some_and(|op| op.phase == Phase::Expanding && op.attempt == request.attempt)
    }

    /// Is what is wanted still there, and beside a tetrahedron that the request holds?
    fn is_reachable(
        &self,
        request: &Request<S>,
        want: &Want<S::Tet>,
        tets: &HashMap<S::Tet, &Seen<S::Tet>>,
    ) -> bool {
        match want {
            Want::Tet(t) => tets.get(t).is_some_and(|tet| {
                let is_held = |link: &Neighbour<S::Tet>| {
                    matches!(link, Neighbour::Near(u) if request.held.contains(u))
                };
                request.held.is_empty() || tet.links.iter().any(is_held)
            }),
            Want::Seed(handle) => {
                self.places.contains_key(&handle.name) || self.names.contains(&handle.name)
            }
        }
    }

    fn check_p7(&self) -> Check {
        for (w, worker) in self.workers.iter().enumerate() {
            let mut queued = BTreeSet::new();
            let names = worker.locks.absent.iter().flat_map(|(n, q)| q.iter().map(move |x| (n, x)));
            for (&name, &waiter) in names {
                let is_new = queued.insert(waiter);
                require(Invariant::P7, is_new && worker.mesh.resolve(name).is_none(), || {
                    format!("worker {w}: {waiter:?} awaits {name:?}, which is here")
                })?;
            }
            for (&t, queue) in &worker.locks.waiting {
                for &waiter in queue {
                    let is_right = queued.insert(waiter) && Self::waits_rightly(worker, t, waiter);
                    require(Invariant::P7, is_right, || {
                        let holder = worker.mesh.holder(t);
                        format!("worker {w}: {waiter:?} waits for {t:?}, held by {holder:?}")
                    })?;
                }
            }
            let denies = worker.config.rule == Rule::Paper;
            for (&ticket, _) in worker.locks.requests.iter().filter(|(_, r)| r.stalled && !denies) {
                require(Invariant::P7, queued.contains(&Waiter::Request(ticket)), || {
                    format!("worker {w}: the request of {ticket:?} waits for nothing")
                })?;
            }
        }
        Ok(())
    }

    /// Is `t` locked, the first that the waiter wants, and its holder told if the waiter is older?
    fn waits_rightly(worker: &Worker<S, Q, C>, t: S::Tet, waiter: Waiter) -> bool {
        let Some(holder) = worker.mesh.holder(t) else { return false };
        match waiter {
            Waiter::Walk(ticket) => {
                let op = worker.operations.all.get(&ticket);
                op.is_some_and(|op| op.phase == Phase::Walking)
            }
            Waiter::Request(ticket) => {
                let request = worker.locks.requests.get(&ticket);
                let is_first = request.is_some_and(|request| {
                    let first = request.wants.last().and_then(|want| match want {
                        Want::Tet(t) => Some(*t),
                        Want::Seed(handle) => worker.mesh.resolve(handle.name),
                    });
                    request.stalled && first == Some(t)
                });
                let other = worker.locks.requests.get(&holder);
                is_first && (holder < ticket || other.is_some_and(|other| other.wounded))
            }
        }
    }

    fn check_p8(&self) -> Check {
        let mut homes = BTreeMap::new();
        for (w, worker) in self.workers.iter().enumerate() {
            for (&ticket, op) in &worker.operations.all {
                require(Invariant::P8, homes.insert(ticket, w).is_none(), || {
                    format!("{ticket:?} has two homes, one of them {w}")
                })?;
                let is_ready = worker.operations.ready.contains(&ticket);
                require(Invariant::P8, is_ready == (op.phase == Phase::Ready), || {
                    format!("worker {w}: {ticket:?} is in {:?}", op.phase)
                })?;
            }
            let known = worker.operations.all.keys().chain(worker.locks.requests.keys());
            known.max_by_key(|ticket| ticket.clock).into_iter().try_for_each(|ticket| {
                require(Invariant::P8, worker.clock() >= ticket.clock, || {
                    format!("worker {w} has heard of {ticket:?}, its clock is {}", worker.clock())
                })
            })?;
        }
        for (w, worker) in self.workers.iter().enumerate() {
            for (&ticket, request) in &worker.locks.requests {
                require(Invariant::P8, self.has_cause(WorkerId::at(w), ticket, request), || {
                    format!("worker {w}: {ticket:?} has a request without a cause")
                })?;
            }
            for (&ticket, op) in &worker.operations.all {
                let Phase::Releasing(open) = op.phase else { continue };
                let answers = self.under_way.iter().filter(|letter| match letter.message {
                    Message::Abort { ticket: of, .. } | Message::Aborted { ticket: of, .. } => {
                        *of == ticket
                    }
                    _ => false,
                });
                require(Invariant::P8, answers.count() == open as usize, || {
                    format!("worker {w}: {ticket:?} awaits {open} releases")
                })?;
            }
        }
        Ok(())
    }

    /// Does the home collect this attempt, and know how many `Expand` the request has to answer? Or
    /// is the end of the attempt under way here?
    fn has_cause(&self, at: WorkerId, ticket: Ticket, request: &Request<S>) -> bool {
        let (mut ends, mut open) = (false, request.owed);
        for &UnderWay { from, to, message } in &self.under_way {
            if message.ticket() != Some(ticket) {
                continue;
            }
            match message {
                Message::Abort { .. } | Message::Commit { .. } if to == at => ends = true,
                Message::Expand { .. } if to == at => open += 1,
                Message::Grant { answers, .. } if from == at => open += answers,
                _ => {}
            }
        }
        let home = self.workers.get(request.home.index());
        let op = home.and_then(|home| home.operations.all.get(&ticket));
        ends || op.is_some_and(|op| {
            op.phase == Phase::Expanding
                && op.attempt == request.attempt
                && op.asked.get(at) == Some(&open)
        })
    }

    fn check_p9(&self) -> Check {
        for (w, tets) in self.seen.iter().enumerate() {
            let here: HashMap<S::Tet, &Seen<S::Tet>> = tets.iter().map(|t| (t.tet, t)).collect();
            for tet in tets {
                if self.commits(w, tet.holder) {
                    continue;
                }
                for link in &tet.links {
                    let is_right = match link {
                        Neighbour::Near(u) => here.get(u).is_some_and(|other| {
                            let back = other.links.iter();
                            back.into_iter().any(|l| *l == Neighbour::Near(tet.tet))
                                || self.commits(w, other.holder)
                        }),
                        Neighbour::Far(handle) => self.is_mutual(tet, handle.name),
                    };
                    require(Invariant::P9, is_right, || {
                        format!("worker {w}: {link:?} of {tet:?} leads to nothing, or not back")
                    })?;
                }
            }
        }
        Ok(())
    }

    /// Does the tetrahedron named `far` lead back to `tet`? One in a message is not looked at.
    fn is_mutual(&self, tet: &Seen<S::Tet>, far: Name) -> bool {
        let Some(&(v, k)) = self.places.get(&far) else {
            return self.names.contains(&far);
        };
        let other = &self.seen[v][k];
        let back = |link: &Neighbour<S::Tet>| match link {
            Neighbour::Far(handle) => Some(handle.name) == tet.name,
            Neighbour::Near(_) => false,
        };
        other.links.iter().any(back) || self.commits(v, other.holder)
    }

    fn check_p10(&self) -> Check {
        // By kind, not by `is_basic`: a kind that workers forget to count is found.
        let counts = |message: &Message<S>| !["token", "stop"].contains(&message.kind());
        let basic = self.under_way.iter().filter(|letter| counts(letter.message)).count();
        let sum: i64 = self.workers.iter().map(|worker| worker.termination.count()).sum();
        require(Invariant::P10, !self.counts || sum == basic as i64, || {
            format!("{basic} counted messages are under way, the counts add up to {sum}")
        })?;
        let is_over = self.workers.iter().any(|worker| worker.is_stopped());
        let is_still = basic == 0 && self.workers.iter().all(|worker| worker.is_quiescent());
        require(Invariant::P10, !is_over || is_still, || "stopped too early".to_owned())
    }

    fn check_p11(&self) -> Check {
        self.tets().try_for_each(|(w, tet)| {
            require(Invariant::P11, self.workers[w].directory.is_mine(tet.block), || {
                format!("worker {w} has {tet:?}, whose block is another's")
            })
        })
    }
    fn check_p12(&self) -> Check {
        let mut numbers = NewsNumbers::default();
        for UnderWay { message, .. } in &self.under_way {
            count_news(message, &mut numbers, 1);
        }
        self.workers.iter().try_for_each(|worker| check_news(worker, &numbers))
    }
}

/// P12 for one worker; `numbers` of news are under way.
///
/// # Errors
/// P12.
pub fn check_news<S: Submesh, Q: Source<S>, C: Rules>(
    worker: &Worker<S, Q, C>,
    numbers: &NewsNumbers,
) -> Check {
    let late = numbers.late::<S, Q>(worker.source());
    require(Invariant::P12, late.is_none(), || {
        format!("worker {}: {late:?} under way behind a barrier", worker.id())
    })
}
