//! The figures of a run, joined from those of its workers.

use super::Nanos;
use super::collector::{Collector, Ending};
use super::figures::{Cavities, Messages, Polls, Times, WorkerFigures, share};
use crate::protocol::{Attempt, Ticket};
use std::collections::{BTreeMap, HashMap};

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

impl std::fmt::Display for Summary {
    /// A few lines for people.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let seconds = self.makespan as f64 * 1e-9;
        writeln!(f, "{} workers, {seconds:.3} s", self.workers.len())?;
        writeln!(f, "{} points inserted, {} setbacks", self.operations(), self.setbacks())?;
        write!(
            f,
            "latency tolerance {:.4}, with idle time {:.4}; {} messages of {} bytes",
            self.lt(),
            self.lt_strict(),
            self.all_messages().count,
            self.all_messages().bytes
        )
    }
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
