//! The figures of a run, joined from those of its workers.

use super::Nanos;
use super::collector::{Collector, Ending};
use crate::protocol::{Attempt, Ticket, WorkerId};
use std::collections::{BTreeMap, HashMap};

/// Completed cavities by kind (Table IV, Figure 7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Cavities {
    /// Local ones, while no cavity of the worker was active.
    pub local: u64,
    /// Local ones, while some cavity of the worker was active.
    pub local_active: u64,
    /// Interface ones, while no other cavity of the worker was active.
    pub interface: u64,
    /// Interface ones, while some other cavity of the worker was active.
    pub interface_active: u64,
}

impl Cavities {
    pub(super) fn count(&mut self, interface: bool, active: bool) {
        let counter = match (interface, active) {
            (false, false) => &mut self.local,
            (false, true) => &mut self.local_active,
            (true, false) => &mut self.interface,
            (true, true) => &mut self.interface_active,
        };
        *counter += 1;
    }

    /// All of them.
    pub fn all(&self) -> u64 {
        self.local + self.local_active + self.interface_all()
    }

    /// All interface cavities.
    pub fn interface_all(&self) -> u64 {
        self.interface + self.interface_active
    }

    /// The share completed while (another) cavity of the worker was active: what Table IV is
    /// about.
    pub fn share_active(&self) -> f64 {
        share(self.local_active + self.interface_active, self.all())
    }

    fn add(&mut self, other: &Self) {
        self.local += other.local;
        self.local_active += other.local_active;
        self.interface += other.interface;
        self.interface_active += other.interface_active;
    }
}

/// A worker's time (Figure 5). The first five add up to the run's length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Times {
    /// Point location, tests, filling.
    pub meshing: Nanos,
    /// Sending and receiving, and messages about termination.
    pub communication: Nanos,
    /// Looking for messages.
    pub polling: Nanos,
    /// Moving blocks, and messages about load.
    pub balancing: Nanos,
    /// Nothing to do.
    pub idle: Nanos,
    /// Time with a cavity of the worker active.
    pub active: Nanos,
    /// The part of the idle time with a cavity of the worker active.
    pub idle_active: Nanos,
    /// The part of the idle time after the worker's last insertion.
    pub idle_at_end: Nanos,
    /// Steps that inserted a point at once.
    pub local: Nanos,
    /// The part of that time with a cavity of the worker active.
    pub local_active: Nanos,
}

impl Times {
    /// All of the worker's time.
    pub fn all(&self) -> Nanos {
        self.meshing + self.communication + self.polling + self.balancing + self.idle
    }

    fn add(&mut self, other: &Self) {
        self.meshing += other.meshing;
        self.communication += other.communication;
        self.polling += other.polling;
        self.balancing += other.balancing;
        self.idle += other.idle;
        self.active += other.active;
        self.idle_active += other.idle_active;
        self.idle_at_end += other.idle_at_end;
        self.local += other.local;
        self.local_active += other.local_active;
    }
}

/// Looks for messages (Table VI).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Polls {
    /// All of them. A worker that sleeps until a message comes polls once.
    pub total: u64,
    /// The polls that found a message.
    pub useful: u64,
    /// The time of all.
    pub total_time: Nanos,
    /// The time of those that found a message.
    pub useful_time: Nanos,
}

impl Polls {
    fn add(&mut self, other: &Self) {
        self.total += other.total;
        self.useful += other.useful;
        self.total_time += other.total_time;
        self.useful_time += other.useful_time;
    }
}

/// One worker's figures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct WorkerFigures {
    /// The worker.
    pub worker: WorkerId,
    /// Its time.
    pub times: Times,
    /// Cavities completed by it.
    pub cavities: Cavities,
    /// Points that were vertices already.
    pub known: u64,
    /// Setbacks of operations at home here.
    pub setbacks: u64,
    /// The most setbacks of one of them.
    pub worst_setbacks: Attempt,
    /// Requests that had to wait for a lock here.
    pub waits: u64,
    /// Blocks given away.
    pub migrations: u64,
    /// Workers that had a part of an interface cavity's closure, summed over these cavities.
    pub closure_parts: u64,
    /// Looks for messages.
    pub polls: Polls,
    /// Tetrahedra at the end.
    pub tets: u64,
    /// Faces of these that are another worker's too.
    pub interface_faces: u64,
}

/// Messages of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Messages {
    /// Their number.
    pub count: u64,
    /// Their bytes.
    pub bytes: u64,
}

/// The figures of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Summary {
    /// Each worker's.
    pub workers: Vec<WorkerFigures>,
    /// From the start until the last worker has stopped.
    pub makespan: Nanos,
    /// The times of all workers.
    pub times: Times,
    /// The cavities of all workers.
    pub cavities: Cavities,
    /// The polls of all workers.
    pub polls: Polls,
    /// Messages by kind.
    pub messages: BTreeMap<&'static str, Messages>,
    /// M: time in cavities that succeeded.
    pub successful: Nanos,
    /// A: the part of M in local cavities, while a cavity of the worker was active.
    pub local_active: Nanos,
    /// I: the part of M in interface cavities, while a cavity of the worker was active.
    pub interface_active: Nanos,
    /// S: time in cavities that were set back.
    pub set_back: Nanos,
}

impl Summary {
    /// Joins the collectors of a run that took until `makespan`.
    pub fn new(collectors: &[Collector], makespan: Nanos) -> Self {
        let mut summary = Self {
            workers: collectors.iter().map(|c| c.figures).collect(),
            makespan,
            times: Times::default(),
            cavities: Cavities::default(),
            polls: Polls::default(),
            messages: BTreeMap::new(),
            successful: 0,
            local_active: 0,
            interface_active: 0,
            set_back: 0,
        };
        for collector in collectors {
            summary.times.add(&collector.figures.times);
            summary.cavities.add(&collector.figures.cavities);
            summary.polls.add(&collector.figures.polls);
            for (&kind, &(count, bytes)) in &collector.messages {
                let messages = summary.messages.entry(kind).or_default();
                messages.count += count;
                messages.bytes += bytes;
            }
        }
        summary.attribute(collectors);
        summary
    }

    /// Tells the time of attempts that succeeded from that of attempts that were set back. The
    /// time of an operation whose point was a vertex already, or that was never finished, is
    /// neither.
    fn attribute(&mut self, collectors: &[Collector]) {
        let endings: HashMap<Ticket, (Attempt, Ending)> =
            collectors.iter().flat_map(|c| c.endings.iter().map(|(&t, &e)| (t, e))).collect();
        self.successful = self.times.local;
        self.local_active = self.times.local_active;
        for (&(ticket, attempt), &spent) in collectors.iter().flat_map(|c| &c.spent) {
            match endings.get(&ticket) {
                Some(&(last, _)) if attempt < last => self.set_back += spent.all,
                Some((_, ending)) => {
                    self.successful += spent.all;
                    *match ending {
                        Ending::Local => &mut self.local_active,
                        Ending::Interface => &mut self.interface_active,
                    } += spent.active;
                }
                None => {}
            }
        }
    }

    /// Points inserted.
    pub fn operations(&self) -> u64 {
        self.cavities.all()
    }

    /// Attempts that were set back.
    pub fn setbacks(&self) -> u64 {
        self.workers.iter().map(|w| w.setbacks).sum()
    }

    /// The most setbacks of one operation.
    pub fn worst_setbacks(&self) -> Attempt {
        self.workers.iter().map(|w| w.worst_setbacks).max().unwrap_or(0)
    }

    /// Latency tolerance (A + I) / (A + I + S); 1 if no cavity was ever active.
    pub fn lt(&self) -> f64 {
        let useful = self.local_active + self.interface_active;
        1.0 - share(self.set_back, useful + self.set_back)
    }

    /// 1 − (idle while a cavity is active + S) / (time with a cavity active).
    pub fn lt_strict(&self) -> f64 {
        1.0 - share(self.times.idle_active + self.set_back, self.times.active)
    }

    /// Share of the processors' time that one processor would have needed for the whole run:
    /// `alone` is how long it takes.
    pub fn efficiency(&self, alone: Nanos) -> f64 {
        share(alone, self.makespan.saturating_mul(self.workers.len() as u64))
    }

    /// Setbacks per operation.
    pub fn setback_share(&self) -> f64 {
        share(self.setbacks(), self.operations())
    }

    /// Messages about operations, per interface cavity.
    pub fn messages_per_interface_cavity(&self) -> f64 {
        let other = ["migrate", "stray", "token", "stop", "load"];
        let about: u64 =
            self.messages.iter().filter(|(k, _)| !other.contains(k)).map(|(_, m)| m.count).sum();
        share(about, self.cavities.interface_all())
    }

    /// All messages.
    pub fn all_messages(&self) -> Messages {
        self.messages.values().fold(Messages::default(), |a, b| Messages {
            count: a.count + b.count,
            bytes: a.bytes + b.bytes,
        })
    }

    /// The largest share of interface faces per tetrahedron of any worker (Table III).
    pub fn surface_to_volume(&self) -> f64 {
        self.workers.iter().map(|w| share(w.interface_faces, w.tets)).fold(0.0, f64::max)
    }

    /// The most tetrahedra of a worker less the fewest (Table III).
    pub fn imbalance_tets(&self) -> u64 {
        let tets = || self.workers.iter().map(|w| w.tets);
        tets().max().unwrap_or(0) - tets().min().unwrap_or(0)
    }
}

/// A part of a whole; 0 if there is no whole.
fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}
