//! The figures of a run, joined from those of its workers.

use super::Nanos;
use super::collector::{Collector, Ending};
use super::figures::{Cavities, CavityTimes, Messages, Polls, Times, WorkerFigures, share};
use super::flow::About;
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
    /// The time of all workers in cavities.
    pub cavity_times: CavityTimes,
}

impl std::fmt::Display for Summary {
    /// A few lines for people.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let seconds = self.makespan as f64 * 1e-9;
        writeln!(f, "{} workers, {seconds:.3} s", self.workers.len())?;
        writeln!(f, "{} points inserted, {} setbacks", self.operations(), self.setbacks())?;
        write!(
            f,
            "latency tolerance {}, with idle time {}, of the worst worker {}, {}; \
             {} messages of {} bytes",
            tolerance(self.lt()),
            tolerance(self.lt_strict()),
            tolerance(self.worst_lt()),
            tolerance(self.worst_lt_strict()),
            self.all_messages().count,
            self.all_messages().bytes
        )
    }
}

/// A latency tolerance for people; `-` where there was nothing to tolerate.
pub fn tolerance(lt: Option<f64>) -> String {
    lt.map_or("-".to_owned(), |lt| format!("{lt:.4}"))
}

/// The workers with the smallest and the largest of a figure.
#[derive(Clone, Copy, Debug)]
pub struct Extremes<'a> {
    /// That of the smallest one.
    pub least: &'a WorkerFigures,
    /// That of the largest one.
    pub most: &'a WorkerFigures,
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
            cavity_times: CavityTimes::default(),
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

    /// Adds the figures of a later run of the same workers.
    pub(crate) fn go_on(&mut self, next: &Self) {
        for (worker, next) in self.workers.iter_mut().zip(&next.workers) {
            worker.go_on(next);
        }
        self.makespan += next.makespan;
        self.times.add(&next.times);
        self.cavities.add(&next.cavities);
        self.polls.add(&next.polls);
        self.cavity_times.add(&next.cavity_times);
        for (&kind, more) in &next.messages {
            let messages = self.messages.entry(kind).or_default();
            messages.count += more.count;
            messages.bytes += more.bytes;
        }
    }

    /// Adds a time in which all deal out the mesh anew, each at work for some of it.
    pub(crate) fn pause(&mut self, all: Nanos, own: &[Nanos]) {
        for (worker, &own) in self.workers.iter_mut().zip(own) {
            worker.times.balancing += own;
            worker.times.idle += all - own;
            self.times.balancing += own;
            self.times.idle += all - own;
        }
        self.makespan += all;
    }

    /// Tells the time of attempts that succeeded from that of attempts that were set back, for the
    /// worker that spent it. The time of an operation whose point was a vertex already, or that was
    /// never finished, is neither.
    fn attribute(&mut self, collectors: &[Collector]) {
        let endings: HashMap<Ticket, (Attempt, Ending)> =
            collectors.iter().flat_map(|c| c.endings.iter().map(|(&t, &e)| (t, e))).collect();
        for (collector, worker) in collectors.iter().zip(&mut self.workers) {
            let own = &mut worker.cavity_times;
            own.successful = worker.times.local;
            own.local_active = worker.times.local_active;
            for (&About { ticket, attempt }, &spent) in &collector.spent {
                match endings.get(&ticket) {
                    Some(&(last, _)) if attempt < last => own.set_back += spent.all,
                    Some((_, ending)) => {
                        own.successful += spent.all;
                        *match ending {
                            Ending::Local => &mut own.local_active,
                            Ending::Interface => &mut own.interface_active,
                        } += spent.active;
                    }
                    None => {}
                }
            }
            self.cavity_times.add(own);
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
    pub fn worst_setbacks(&self) -> u32 {
        self.workers.iter().map(|w| w.worst_setbacks).max().unwrap_or(0)
    }

    /// Latency tolerance of all workers together; none without an interface cavity.
    pub fn lt(&self) -> Option<f64> {
        self.cavity_times.lt()
    }

    /// LT strict of all workers together.
    pub fn lt_strict(&self) -> Option<f64> {
        self.cavity_times.lt_strict(&self.times)
    }

    /// The workers that tolerate latency worst and best, by LT: those of Tables IV and V. The first
    /// of equal ones; none in a run without interface cavities.
    pub fn extremes_of_tolerance(&self) -> Option<Extremes<'_>> {
        self.extremes(WorkerFigures::lt)
    }

    /// The lowest LT of any worker; none without an interface cavity.
    pub fn worst_lt(&self) -> Option<f64> {
        self.extremes_of_tolerance().and_then(|of| of.least.lt())
    }

    /// The lowest LT strict of any worker, which may be another one than that with the lowest LT.
    pub fn worst_lt_strict(&self) -> Option<f64> {
        self.extremes(WorkerFigures::lt_strict).and_then(|of| of.least.lt_strict())
    }

    /// The workers with the smallest and the largest share of useful polling, by time: those of
    /// Table VI.
    pub fn extremes_of_polling(&self) -> Option<Extremes<'_>> {
        self.extremes(|worker| Some(worker.polls.useful_share()))
    }

    fn extremes(&self, by: impl Fn(&WorkerFigures) -> Option<f64>) -> Option<Extremes<'_>> {
        let known = || self.workers.iter().filter_map(|worker| Some((by(worker)?, worker)));
        let order = |a: &(f64, &WorkerFigures), b: &(f64, &WorkerFigures)| a.0.total_cmp(&b.0);
        let (_, least) = known().min_by(order)?;
        // The last of equal ones is what `max_by` gives.
        let all: Vec<_> = known().collect();
        let &(_, most) = all.iter().rev().max_by(|a, b| order(a, b))?;
        Some(Extremes { least, most })
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
