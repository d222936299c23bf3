//! A team of processes, or threads, that share nothing: what carries their letters ([`Post`]), and
//! what they do all together ([`Team`]), without a word of what is below.
//!
//! | module | what it holds |
//! |---|---|
//! | `post` | letters from one member to another: the trait, and the posts of this process |
//! | `letters` | the way of a worker's messages, as letters |
//! | `alone` | work of the first member that all others wait for |
//!
//! Members call collectives in one order. A member that fails tells the others: whoever waits for
//! it gets [`TeamError::Failed`].

mod alone;
mod letters;
mod post;

use letters::Arrived;
pub use letters::{LONGEST, LetterFigures, Letters};
pub use post::{Alone, Kind, Post, Threads, threads};

use crate::protocol::WorkerId;
use crate::wire::{WireError, bytes_of, value_of};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::VecDeque;
use std::time::Duration;

/// Bytes of a piece of what collectives send.
const PIECE: usize = 1 << 20;

/// Whether a piece is the last one of what is sent: its first byte.
const MORE: u8 = 0;
const LAST: u8 = 1;

/// Why a team has not come to its end.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TeamError {
    /// Another member has failed, and has told why itself.
    #[error("worker {0} has failed")]
    Failed(WorkerId),
    /// A letter makes no sense.
    #[error(transparent)]
    Wire(#[from] WireError),
}

/// One member's part in a team.
pub struct Team {
    post: Box<dyn Post>,
    /// Mails that have arrived, in the order of their arrival.
    mails: VecDeque<Arrived>,
    /// Letters of collectives that have arrived, by sender.
    letters: Vec<VecDeque<Vec<u8>>>,
    /// A mail that made no sense.
    fault: Option<WireError>,
    /// The figures of all mails so far.
    figures: LetterFigures,
    /// The time that a mail takes, beside what it takes anyhow.
    latency: Duration,
}

impl std::fmt::Debug for Team {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "member {} of {}", self.me(), self.size())
    }
}

impl Team {
    /// A team of one.
    pub fn alone() -> Self {
        Self::new(Alone)
    }

    /// A member's part in the team that this post connects.
    pub fn new(post: impl Post + 'static) -> Self {
        let post = Box::new(post);
        let letters = (0..post.members()).map(|_| VecDeque::new()).collect();
        let figures = LetterFigures::default();
        let latency = Duration::ZERO;
        Self { post, mails: VecDeque::new(), letters, fault: None, figures, latency }
    }

    /// Delays every mail from its sending on, by the clock of the machine: to see how the kernel
    /// tolerates it.
    pub fn latency(mut self, latency: Duration) -> Self {
        self.latency = latency;
        self
    }

    /// The number of this member.
    pub fn me(&self) -> WorkerId {
        self.post.me()
    }

    /// Is it the first one, which puts together what all have made?
    pub fn is_first(&self) -> bool {
        self.me() == WorkerId::default()
    }

    /// Number of members.
    pub fn size(&self) -> u32 {
        self.post.members()
    }

    /// The figures of this member's mails so far.
    pub fn figures(&self) -> LetterFigures {
        self.figures
    }

    /// Tells all others that this member has failed.
    pub fn fail(&mut self) {
        self.post.fail();
    }

    /// Why a loop of this member has ended early, as far as the team knows.
    pub fn error(&mut self) -> Option<TeamError> {
        let fault = self.fault.take().map(TeamError::Wire);
        fault.or_else(|| self.post.failed().map(TeamError::Failed))
    }

    /// Takes what has arrived.
    fn sort(&mut self) {
        while let Some((from, kind, letter)) = self.post.take() {
            match kind {
                Kind::Mail | Kind::Late => self.mails.push_back(Arrived::of(from, kind, letter)),
                Kind::Team => match self.letters.get_mut(from.index()) {
                    Some(own) => own.push_back(letter),
                    None => self.post.keep(letter),
                },
            }
        }
    }

    /// Sends bytes to another member, in pieces.
    pub(crate) fn send(&mut self, to: WorkerId, bytes: &[u8]) {
        let mut pieces = bytes.chunks(PIECE).peekable();
        if pieces.peek().is_none() {
            self.post.send(to, Kind::Team, vec![LAST]);
        }
        while let Some(piece) = pieces.next() {
            let mut letter = Vec::with_capacity(1 + piece.len());
            letter.push(if pieces.peek().is_some() { MORE } else { LAST });
            letter.extend_from_slice(piece);
            self.post.send(to, Kind::Team, letter);
        }
        self.post.flush();
    }

    /// The bytes that another member sends next.
    ///
    /// Ends: a member sends what all have agreed upon, or fails, which is heard; and whatever
    /// carries the letters ends all members when one is lost.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed.
    pub(crate) fn receive(&mut self, from: WorkerId) -> Result<Vec<u8>, TeamError> {
        let mut bytes = Vec::new();
        loop {
            self.sort();
            if let Some(letter) = self.letters.get_mut(from.index()).and_then(VecDeque::pop_front) {
                let (first, piece) = letter.split_first().unwrap_or((&LAST, &[]));
                let is_last = *first == LAST;
                bytes.extend_from_slice(piece);
                self.post.keep(letter);
                if is_last {
                    return Ok(bytes);
                }
                continue;
            }
            if let Some(member) = self.post.failed() {
                return Err(TeamError::Failed(member));
            }
            self.post.wait(None);
        }
    }

    /// Brings what each member has to the first one, by member; the others get nothing.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed.
    pub fn gather(&mut self, own: Vec<u8>) -> Result<Option<Vec<Vec<u8>>>, TeamError> {
        if !self.is_first() {
            self.send(WorkerId::default(), &own);
            return Ok(None);
        }
        let mut all = vec![own];
        for from in WorkerId::below(self.size()).skip(1) {
            all.push(self.receive(from)?);
        }
        Ok(Some(all))
    }

    /// Brings what the first member has to all: down a tree in which each tells twice as many.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed.
    pub fn tell(&mut self, of_first: Vec<u8>) -> Result<Vec<u8>, TeamError> {
        let (me, size) = (u64::from(self.me().number()), u64::from(self.size()));
        let own_bit = if me == 0 { size.next_power_of_two() } else { me & me.wrapping_neg() };
        let bytes = match me {
            0 => of_first,
            _ => self.receive(WorkerId::new((me - own_bit) as u32))?,
        };
        let mut bit = own_bit / 2;
        while bit > 0 {
            if me + bit < size {
                self.send(WorkerId::new((me + bit) as u32), &bytes);
            }
            bit /= 2;
        }
        Ok(bytes)
    }

    /// Sends a value to the first member, which calls [`Team::parcels`] at the same time.
    ///
    /// # Errors
    /// [`TeamError`] if the value cannot be written.
    pub fn send_parcel<T: Serialize>(&mut self, own: &T) -> Result<(), TeamError> {
        let own = bytes_of(own, self.me())?;
        self.gather(own).map(drop)
    }

    /// The values of all other members at the first one, which call [`Team::send_parcel`], by
    /// sender.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed, or has sent no such value.
    pub fn parcels<T: DeserializeOwned>(&mut self) -> Result<Vec<(WorkerId, T)>, TeamError> {
        let all = self.gather(Vec::new())?.unwrap_or_default();
        let others = WorkerId::below(all.len() as u32).zip(all).skip(1);
        others.map(|(from, bytes)| Ok((from, value_of(from, &bytes)?))).collect()
    }

    /// As [`Team::gather`], of values.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed, or has sent no such value.
    pub fn gather_values<T>(&mut self, own: &T) -> Result<Option<Vec<T>>, TeamError>
    where
        T: Serialize + DeserializeOwned,
    {
        let own = bytes_of(own, self.me())?;
        let all = self.gather(own)?.map(|all| {
            let each = WorkerId::below(all.len() as u32).zip(&all);
            each.map(|(from, bytes)| value_of(from, bytes)).collect::<Result<Vec<T>, _>>()
        });
        Ok(all.transpose()?)
    }

    /// As [`Team::tell`], of a value that the first member has.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed, or has sent no such value.
    pub fn tell_value<T>(&mut self, of_first: Option<T>) -> Result<T, TeamError>
    where
        T: Serialize + DeserializeOwned,
    {
        let own = of_first.as_ref().map(|value| bytes_of(value, self.me()));
        let bytes = self.tell(own.transpose()?.unwrap_or_default())?;
        match of_first {
            Some(value) => Ok(value),
            None => Ok(value_of(WorkerId::default(), &bytes)?),
        }
    }

    /// All members get what each of them has, by member. For what is small.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed, or has sent no such value.
    pub fn gather_all<T>(&mut self, own: &T) -> Result<Vec<T>, TeamError>
    where
        T: Serialize + DeserializeOwned,
    {
        let all = self.gather_values(own)?;
        self.tell_value(all)
    }

    /// Is this so at any member?
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed.
    pub fn is_any(&mut self, own: bool) -> Result<bool, TeamError> {
        let any = self.gather_values(&own)?.map(|all| all.contains(&true));
        self.tell_value(any)
    }

    /// Goes through all members in their order: each makes something of what the one before it has
    /// made, the first one of `first`. All get what the last one has made.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed, and that of `own`.
    pub fn in_turn(
        &mut self,
        first: Vec<u8>,
        own: impl FnOnce(Vec<u8>) -> Result<Vec<u8>, TeamError>,
    ) -> Result<Vec<u8>, TeamError> {
        let (me, size) = (self.me().number(), self.size());
        let before = match me.checked_sub(1) {
            None => first,
            Some(before) => self.receive(WorkerId::new(before))?,
        };
        let mut made = own(before)?;
        // From the last one to the first, who tells it to all.
        if size > 1 {
            self.send(WorkerId::new((me + 1) % size), &made);
        }
        if me == 0 && size > 1 {
            made = self.receive(WorkerId::new(size - 1))?;
        }
        self.tell(made)
    }

    /// Each member gets what the others have for it: parts by receiver in, by sender out. A part
    /// that is not there is empty.
    ///
    /// # Errors
    /// [`TeamError`] if a member has failed.
    pub fn exchange(&mut self, parts: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>, TeamError> {
        let (me, size) = (self.me(), self.size());
        let mut all: Vec<Vec<u8>> = vec![Vec::new(); size as usize];
        let parts = parts.into_iter().chain(std::iter::repeat(Vec::new()));
        for (to, part) in WorkerId::below(size).zip(parts) {
            match to == me {
                true => all[me.index()] = part,
                false => self.send(to, &part),
            }
        }
        for from in WorkerId::below(size).filter(|&from| from != me) {
            all[from.index()] = self.receive(from)?;
        }
        Ok(all)
    }
}

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests;
