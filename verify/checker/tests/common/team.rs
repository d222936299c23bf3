//! Teams of threads, whose members share nothing but bytes in channels.

use ltbw_verify::Exchange;
use std::sync::mpsc::{Receiver, Sender, channel};

/// Why a member has come to no end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Lost {
    /// Bytes of this member make no sense.
    Nonsense(usize, &'static str),
    /// Another member has ended early.
    Ended,
}

/// The exchange whose bytes are changed, and by what.
type Garbler = (usize, fn(&mut Vec<u8>));

/// One member of a team.
pub(crate) struct Member {
    me: usize,
    /// Ways to all members, and from them.
    to: Vec<Sender<Vec<u8>>>,
    from: Vec<Receiver<Vec<u8>>>,
    /// The exchanges so far, and the one whose bytes are changed, by what.
    exchanges: usize,
    garbler: Option<Garbler>,
}

impl Member {
    /// Changes the bytes that this member sends to all in exchange number `k`.
    pub(crate) fn garble(&mut self, k: usize, how: fn(&mut Vec<u8>)) {
        self.garbler = Some((k, how));
    }

    pub(crate) fn exchanges(&self) -> usize {
        self.exchanges
    }
}

impl Exchange for Member {
    type Error = Lost;

    fn me(&self) -> usize {
        self.me
    }

    fn members(&self) -> usize {
        self.to.len()
    }

    fn exchange(&mut self, parts: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>, Lost> {
        let is_garbled = self.garbler.filter(|garbler| garbler.0 == self.exchanges);
        self.exchanges += 1;
        for (to, mut part) in self.to.iter().zip(parts) {
            is_garbled.iter().for_each(|(_, how)| how(&mut part));
            to.send(part).map_err(|_| Lost::Ended)?;
        }
        self.from.iter().map(|from| from.recv().map_err(|_| Lost::Ended)).collect()
    }

    fn in_turn(
        &mut self,
        first: Vec<u8>,
        own: &mut dyn FnMut(Vec<u8>) -> Vec<u8>,
    ) -> Result<Vec<u8>, Lost> {
        let before = match self.me {
            0 => first,
            me => self.from[me - 1].recv().map_err(|_| Lost::Ended)?,
        };
        let made = own(before);
        let last = self.to.len() - 1;
        if self.me < last {
            self.to[self.me + 1].send(made).map_err(|_| Lost::Ended)?;
        } else {
            for to in &self.to {
                to.send(made.clone()).map_err(|_| Lost::Ended)?;
            }
        }
        self.from[last].recv().map_err(|_| Lost::Ended)
    }

    fn nonsense(&self, from: usize, what: &'static str) -> Lost {
        Lost::Nonsense(from, what)
    }
}

/// Runs every member of a team on a thread of its own; what comes of it, by member.
pub(crate) fn on_team<R: Send>(members: usize, member: impl Fn(&mut Member) -> R + Sync) -> Vec<R> {
    // By receiver, then by sender.
    let (mut ways, mut ends): (Vec<_>, Vec<_>) = (0..members)
        .map(|_| (0..members).map(|_| channel()).unzip::<_, _, Vec<_>, Vec<_>>())
        .unzip();
    let all: Vec<Member> = (0..members)
        .rev()
        .map(|me| {
            let to = ways.iter_mut().map(|way| way.pop().unwrap()).collect();
            let from = ends.pop().unwrap();
            Member { me, to, from, exchanges: 0, garbler: None }
        })
        .collect();
    std::thread::scope(|scope| {
        let member = &member;
        let run = |mut own| scope.spawn(move || member(&mut own));
        let threads: Vec<_> = all.into_iter().rev().map(run).collect();
        threads.into_iter().map(|thread| thread.join().expect("no member panics")).collect()
    })
}
