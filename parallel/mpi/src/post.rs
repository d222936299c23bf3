//! The post of a process: letters by MPI, and how it waits for them.

use crate::raw::Calls;
use ltbw::protocol::WorkerId;
use ltbw::team::{Kind, Post};
use mpi::topology::{Communicator, SimpleCommunicator};
use std::time::{Duration, Instant};

/// The way in which a process waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Waiting {
    /// It looks again at once.
    Spin,
    /// It lets others run between looks.
    Yield,
    /// It sleeps between looks: there are more processes here than cores.
    Nap,
}

impl Waiting {
    /// That of a process of `world`, unless `asked` names one.
    pub(crate) fn of(world: &SimpleCommunicator, asked: Option<&str>) -> Result<Self, String> {
        match asked {
            Some("spin") => Ok(Self::Spin),
            Some("yield") => Ok(Self::Yield),
            Some("nap") => Ok(Self::Nap),
            Some(other) => Err(format!("LTBW_MPI_WAIT is `{other}`: spin, yield or nap")),
            None => {
                // A process that is bound to a core sees that one alone.
                let seen = std::thread::available_parallelism().map_or(1, usize::from);
                let online = std::fs::read_to_string("/sys/devices/system/cpu/online");
                let cores = online.map_or(seen, |text| cores(&text).max(seen));
                let here = usize::try_from(world.split_shared(world.rank()).size()).unwrap_or(1);
                Ok(if here > cores { Self::Nap } else { Self::Yield })
            }
        }
    }
}

/// The number of cores in a list of ranges: `0-3,8`.
fn cores(list: &str) -> usize {
    let of_range = |range: &str| {
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        let number = |text: &str| text.trim().parse::<usize>().ok();
        let (first, last) = (number(first)?, number(last)?);
        (last + 1).checked_sub(first)
    };
    list.split(',').filter_map(of_range).sum()
}

/// Looks before it does anything but look.
const LOOKS: u32 = 100;
/// The shortest and the longest sleep.
const NAP: Duration = Duration::from_micros(20);
const LONG_NAP: Duration = Duration::from_millis(1);
/// The time after which whoever waits is sure to wait for long.
const PATIENCE: Duration = Duration::from_millis(20);
/// Letters whose memory is kept, and the bytes of the largest: those of collectives are larger.
const SPARE: usize = 256;
const LARGEST: usize = 1 << 16;

const MAIL: i32 = 1;
const TEAM: i32 = 2;
const LATE: i32 = 3;

/// The post of this process.
pub(crate) struct Mpi {
    calls: Calls,
    me: WorkerId,
    members: u32,
    waiting: Waiting,
    /// Letters without what was in them.
    spare: Vec<Vec<u8>>,
    /// None, between calls.
    done: Vec<Vec<u8>>,
    failed: Option<WorkerId>,
    /// The mails to be sent before a planted panic.
    fault: Option<u64>,
}

impl Mpi {
    /// The post of this process of `world`; a test may plant a panic instead of its mail number
    /// `fault`.
    pub(crate) fn new(world: &SimpleCommunicator, waiting: Waiting, fault: Option<u64>) -> Self {
        let calls = Calls::on(world);
        let me = WorkerId::new(u32::try_from(calls.comm().rank()).unwrap_or(0));
        let members = u32::try_from(calls.comm().size()).unwrap_or(1);
        let (spare, done) = (Vec::new(), Vec::new());
        Self { calls, me, members, waiting, spare, done, failed: None, fault }
    }

    /// Takes back what MPI is done with.
    fn complete(&mut self) {
        let mut done = std::mem::take(&mut self.done);
        self.calls.complete(&mut done);
        done.drain(..).for_each(|letter| self.keep(letter));
        self.done = done;
    }
}

impl Post for Mpi {
    fn me(&self) -> WorkerId {
        self.me
    }

    fn members(&self) -> u32 {
        self.members
    }

    fn send(&mut self, to: WorkerId, kind: Kind, letter: Vec<u8>) {
        let tag = match kind {
            Kind::Mail => MAIL,
            Kind::Late => LATE,
            Kind::Team => TEAM,
        };
        if kind != Kind::Team {
            self.fault = self.fault.map(|left| left.wrapping_sub(1));
            assert!(self.fault != Some(u64::MAX), "planted");
        }
        let to = i32::try_from(to.number()).unwrap_or(i32::MAX);
        if self.calls.send(to, tag, letter).is_err() {
            self.failed = Some(self.me);
        }
    }

    fn flush(&mut self) {
        self.complete();
    }

    fn take(&mut self) -> Option<(WorkerId, Kind, Vec<u8>)> {
        let mut letter = self.spare();
        let Some((from, tag)) = self.calls.take(&mut letter) else {
            self.keep(letter);
            return None;
        };
        let kind = match tag {
            MAIL => Kind::Mail,
            LATE => Kind::Late,
            _ => Kind::Team,
        };
        Some((WorkerId::new(u32::try_from(from).unwrap_or(u32::MAX)), kind, letter))
    }

    fn wait(&mut self, timeout: Option<Duration>) {
        let begin = Instant::now();
        let (mut looks, mut nap) = (0_u32, NAP);
        // Ends when a letter comes, which may be never: then whatever runs the job ends it.
        while !self.calls.has_some() {
            let waited = begin.elapsed();
            if timeout.is_some_and(|timeout| waited >= timeout) {
                return;
            }
            self.complete();
            looks += 1;
            match self.waiting {
                _ if waited >= PATIENCE => std::thread::sleep(LONG_NAP),
                _ if looks < LOOKS => std::hint::spin_loop(),
                Waiting::Spin => std::hint::spin_loop(),
                Waiting::Yield => std::thread::yield_now(),
                Waiting::Nap => {
                    std::thread::sleep(nap);
                    nap = (2 * nap).min(10 * NAP);
                }
            }
        }
    }

    fn spare(&mut self) -> Vec<u8> {
        self.spare.pop().unwrap_or_default()
    }

    fn keep(&mut self, mut letter: Vec<u8>) {
        if self.spare.len() < SPARE && letter.capacity() <= LARGEST {
            letter.clear();
            self.spare.push(letter);
        }
    }

    fn failed(&self) -> Option<WorkerId> {
        self.failed
    }

    /// The program says why, and then ends the job.
    fn fail(&mut self) {
        self.failed = Some(self.me);
    }
}

#[cfg(test)]
mod tests {
    use super::cores;

    #[test]
    fn cores_are_counted_in_ranges() {
        assert_eq!(["0-3,8\n", "0", "", "2-1", "x"].map(cores), [5, 1, 0, 0, 0]);
    }
}
