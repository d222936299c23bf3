//! The way of a worker's messages to workers elsewhere: in letters.

use super::{Kind, Team};
use crate::mailbox::Received;
use crate::protocol::WorkerId;
use crate::transport::Transport;
use crate::wire::{Wire, open};
use ltbw_core::CancelToken;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

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

/// One worker's way, for one run of a team.
///
/// A letter without a byte says that the run is cancelled: a token is one process's own.
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
            self.team.post.send(to, Kind::Mail, Vec::new());
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
        self.team.post.send(to, Kind::Mail, letter);
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
            while let Some((from, letter)) = self.team.mails.pop_front() {
                self.read(from, letter, into);
            }
            return;
        }
        let now = Instant::now();
        let late = self.team.mails.drain(..).map(|(from, letter)| (now + latency, from, letter));
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
