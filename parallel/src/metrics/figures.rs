//! The figures of one worker, and those that a run has of all.

use super::Nanos;
use crate::protocol::WorkerId;

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

    pub(super) fn add(&mut self, other: &Self) {
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
    /// Nothing to do, asleep.
    pub idle: Nanos,
    /// Time with a cavity of the worker active.
    pub active: Nanos,
    /// Time with nothing to do, asleep or looking for messages, and a cavity of the worker active.
    pub idle_active: Nanos,
    /// Time with nothing to do, asleep or looking for messages, after the worker's last insertion.
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

    pub(super) fn add(&mut self, other: &Self) {
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

/// Time in cavities (Table V), where it was spent: on a worker's own and on those of others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CavityTimes {
    /// M: in cavities that succeeded.
    pub successful: Nanos,
    /// A: the part of M in local cavities, while a cavity of the worker was active.
    pub local_active: Nanos,
    /// I: the part of M in interface cavities, while a cavity of the worker was active.
    pub interface_active: Nanos,
    /// S: in cavities that were set back.
    pub set_back: Nanos,
}

impl CavityTimes {
    /// Latency tolerance (A + I) / (A + I + S); none if no cavity was ever active: then there was
    /// no latency to tolerate.
    pub fn lt(&self) -> Option<f64> {
        let all = self.local_active + self.interface_active + self.set_back;
        (all > 0).then(|| 1.0 - share(self.set_back, all))
    }

    /// LT strict: 1 − (idle while a cavity is active + S) / (time with a cavity active).
    pub(super) fn lt_strict(&self, times: &Times) -> Option<f64> {
        let lost = times.idle_active + self.set_back;
        (times.active > 0).then(|| 1.0 - share(lost, times.active))
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.successful += other.successful;
        self.local_active += other.local_active;
        self.interface_active += other.interface_active;
        self.set_back += other.set_back;
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
    /// The share of the time in polls that found a message.
    pub fn useful_share(&self) -> f64 {
        share(self.useful_time, self.total_time)
    }

    pub(super) fn add(&mut self, other: &Self) {
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
    /// The part of that time in cavities.
    pub cavity_times: CavityTimes,
    /// Cavities completed by it.
    pub cavities: Cavities,
    /// Points that were vertices already; in refining, points whose tetrahedron was gone.
    pub known: u64,
    /// Setbacks of operations at home here.
    pub setbacks: u64,
    /// The most setbacks of one of them.
    pub worst_setbacks: u32,
    /// Requests that had to wait for a lock here.
    pub waits: u64,
    /// Requests of others for a part of a closure, taken here (Figure 7).
    pub services: u64,
    /// The time of the steps that took them.
    pub service_time: Nanos,
    /// Messages sent.
    pub sent: Messages,
    /// Messages of others about operations, blocks or the end, taken.
    pub received: u64,
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

impl WorkerFigures {
    /// Adds the figures of a later run of the same worker.
    pub(super) fn go_on(&mut self, next: &Self) {
        self.times.add(&next.times);
        self.cavity_times.add(&next.cavity_times);
        self.cavities.add(&next.cavities);
        self.known += next.known;
        self.setbacks += next.setbacks;
        self.worst_setbacks = self.worst_setbacks.max(next.worst_setbacks);
        self.waits += next.waits;
        self.services += next.services;
        self.service_time += next.service_time;
        self.sent.count += next.sent.count;
        self.sent.bytes += next.sent.bytes;
        self.received += next.received;
        self.migrations += next.migrations;
        self.closure_parts += next.closure_parts;
        self.polls.add(&next.polls);
        (self.tets, self.interface_faces) = (next.tets, next.interface_faces);
    }

    /// Latency tolerance of this worker (Table V), if it had an interface cavity.
    pub fn lt(&self) -> Option<f64> {
        self.cavity_times.lt()
    }

    /// LT strict of this worker: idle time counts, too.
    pub fn lt_strict(&self) -> Option<f64> {
        self.cavity_times.lt_strict(&self.times)
    }
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

/// A part of a whole; 0 if there is no whole.
pub(super) fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}
