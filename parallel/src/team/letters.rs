//! The way of a worker's messages to workers elsewhere: in letters.

use super::{Kind, Team};
use crate::mailbox::Received;
use crate::protocol::WorkerId;
use crate::transport::Transport;
use crate::wire::{Wire, open};
use ltbw_core::CancelToken;
use std::collections::VecDeque;
use std::time::{Duration, Instant, SystemTime};

/// The bytes of a letter, unless one message alone has more: what goes through at once on most
/// networks without a word between the two ends before.
pub const LONGEST: usize = 4000;

/// The figures of one member's mails.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LetterFigures {
    /// Messages sent.
    pub messages: u64,
    /// Letters sent.
    pub letters: u64,
    /// Their bytes.
    pub bytes: u64,
}

impl LetterFigures {
    /// Adds those of another member.
    pub fn add(&mut self, other: &Self) {
        self.messages += other.messages;
        self.letters += other.letters;
        self.bytes += other.bytes;
    }
}

/// A mail that has arrived.
pub(super) struct Arrived {
    from: WorkerId,
    letter: Vec<u8>,
    /// The time of its sending, if it is to be late.
    sent: Option<u64>,
}

impl Arrived {
    pub(super) fn of(from: WorkerId, kind: Kind, mut letter: Vec<u8>) -> Self {
        let mut sent = None;
        if let (Kind::Late, Some((own, time))) = (kind, letter.split_last_chunk()) {
            sent = Some(u64::from_le_bytes(*time));
            letter.truncate(own.len());
        }
        Self { from, letter, sent }
    }

    /// Does it say that the sender was stopped?
    pub(super) fn says_stop(&self) -> bool {
        self.letter.is_empty()
    }

    /// The part of a delay that is left.
    fn left_of(&self, latency: Duration) -> Duration {
        let since = self.sent.map_or(0, |sent| clock().saturating_sub(sent));
        latency.saturating_sub(Duration::from_nanos(since))
    }
}

/// The clock that all processes of a machine see, in nanoseconds.
fn clock() -> u64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
}

/// One worker's way, for one run of a team.
///
/// A letter without a byte says that the run is stopped: a token is one process's own.
pub struct Letters<'t> {
    team: &'t mut Team,
    /// By receiver: the letter that is written.
    written: Vec<Vec<u8>>,
    /// Receivers of letters that are written.
    dirty: Vec<WorkerId>,
    cancel: Option<&'t CancelToken>,
    /// The others know that the run is cancelled.
    has_told: bool,
    /// Letters on their way, in the order of their arrival.
    under_way: VecDeque<(Instant, WorkerId, Vec<u8>)>,
}

impl<'t> Letters<'t> {
    /// The way of the worker that is this member of the team; `cancel` is set where any member's
    /// is.
    pub fn new(team: &'t mut Team, cancel: Option<&'t CancelToken>) -> Self {
        let written = (0..team.size()).map(|_| Vec::new()).collect();
        let (dirty, under_way) = (Vec::new(), VecDeque::new());
        Self { team, written, dirty, cancel, has_told: false, under_way }
    }

    /// Tells the others once that the run is cancelled.
    fn tell_cancel(&mut self) {
        if self.has_told || !self.cancel.is_some_and(CancelToken::is_cancelled) {
            return;
        }
        self.has_told = true;
        let me = self.team.me();
        for to in WorkerId::below(self.team.size()).filter(|&to| to != me) {
            self.post(to, Vec::new());
        }
    }

    /// Hands over the letter to `to`, up to a place.
    fn hand_over(&mut self, to: WorkerId, until: usize) {
        let mut letter = self.team.post.spare();
        std::mem::swap(&mut letter, &mut self.written[to.index()]);
        if until < letter.len() {
            self.written[to.index()].extend_from_slice(&letter[until..]);
            letter.truncate(until);
        }
        self.team.figures.letters += 1;
        self.team.figures.bytes += letter.len() as u64;
        self.post(to, letter);
    }

    /// Sends a letter, with the time if it is to be late.
    fn post(&mut self, to: WorkerId, mut letter: Vec<u8>) {
        let mut kind = Kind::Mail;
        if !self.team.latency.is_zero() {
            letter.extend(clock().to_le_bytes());
            kind = Kind::Late;
        }
        self.team.post.send(to, kind, letter);
    }

    /// Reads a letter.
    fn read<M: Wire>(&mut self, from: WorkerId, letter: Vec<u8>, into: &mut Vec<Received<M>>) {
        if letter.is_empty() {
            // Everybody hears of it from the first one: nobody passes it on.
            self.has_told = true;
            self.cancel.iter().for_each(|token| token.cancel());
        } else if let Err(fault) =
            open(from, &letter, |message| into.push(Received { from, message }))
        {
            // The next ones would be out of order.
            self.team.fault.get_or_insert(fault);
        }
        self.team.post.keep(letter);
    }
}

impl<M: Wire> Transport<M> for Letters<'_> {
    fn send(&mut self, to: WorkerId, message: M) {
        let letter = &mut self.written[to.index()];
        let before = letter.len();
        if let Err(fault) = message.put(self.team.post.me(), letter) {
            self.team.fault.get_or_insert(fault);
            return;
        }
        self.team.figures.messages += 1;
        let length = letter.len();
        if before == 0 {
            self.dirty.push(to);
        } else if length > LONGEST {
            self.hand_over(to, before);
        }
    }

    fn flush(&mut self) {
        for place in 0..self.dirty.len() {
            self.hand_over(self.dirty[place], usize::MAX);
        }
        self.dirty.clear();
        self.tell_cancel();
        self.team.post.flush();
    }

    fn take(&mut self, into: &mut Vec<Received<M>>) {
        self.team.sort();
        let latency = self.team.latency;
        if latency.is_zero() {
            while let Some(Arrived { from, letter, .. }) = self.team.mails.pop_front() {
                self.read(from, letter, into);
            }
            return;
        }
        let now = Instant::now();
        let due = |own: &Arrived| now + own.left_of(latency);
        let late = self.team.mails.drain(..).map(|own| (due(&own), own.from, own.letter));
        // Mails stay in their order, whatever the clock says.
        self.under_way.extend(late);
        while self.under_way.front().is_some_and(|(due, ..)| *due <= now) {
            if let Some((_, from, letter)) = self.under_way.pop_front() {
                self.read(from, letter, into);
            }
        }
    }

    fn wait(&mut self, timeout: Option<Duration>) {
        Transport::<M>::flush(self);
        self.team.sort();
        if !self.team.mails.is_empty() {
            return;
        }
        let next = self.under_way.front();
        let due = next.map(|(due, ..)| due.saturating_duration_since(Instant::now()));
        self.team.post.wait(due.into_iter().chain(timeout).min());
    }

    fn failed(&self) -> Option<WorkerId> {
        let fault = self.team.fault.as_ref().map(|fault| fault.from);
        fault.or_else(|| self.team.post.failed())
    }

    fn fail(&mut self) {
        self.team.post.fail();
    }
}

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests {
    use super::*;

    #[test]
    fn a_delay_counts_from_the_sending() {
        let (me, second) = (WorkerId::default(), Duration::from_secs(1));
        let sent = |ago: u64| {
            let mut letter = vec![1, 2, 3];
            letter.extend(clock().saturating_sub(ago).to_le_bytes());
            Arrived::of(me, Kind::Late, letter)
        };
        let old = sent(5_000_000_000);
        assert_eq!((&old.letter[..], old.left_of(second)), (&[1, 2, 3][..], Duration::ZERO));
        let new = sent(0).left_of(second);
        assert!(new > Duration::ZERO && new <= second, "{new:?}");
        // Clocks of two machines differ.
        assert_eq!(sent(u64::MAX / 2).left_of(second), Duration::ZERO);
        let early = Arrived { sent: Some(u64::MAX), ..sent(0) };
        assert_eq!(early.left_of(second), second);
        let mail = Arrived::of(me, Kind::Mail, vec![9; 20]);
        assert_eq!((mail.letter.len(), mail.left_of(second)), (20, second));
        assert_eq!(Arrived::of(me, Kind::Late, vec![7]).letter, [7], "no time at its end");
    }
}
