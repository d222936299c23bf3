//! The LTBW protocol: cavities that reach other processors' submeshes (paper, algorithms 1 to 3).
//!
//! A *worker* owns blocks of tetrahedra outright. A point whose closure (cavity and ring of face
//! neighbours) lies in its own unlocked tetrahedra is inserted at once, without a lock. Every
//! other insertion is an *operation*:
//!
//! ```text
//! home                                   owner (any worker, the home among them)
//!   walk to a tetrahedron in conflict
//!   Expand{op, attempt, seeds}  ------->  lock, test, spread over its own tetrahedra;
//!                                         a locked one: wait, or wound its holder
//!   collect              <------- Grant{op, pieces, foreign seeds}
//!   ... until no seed is left
//!   fill; Commit{patch}  ------------->  replace, unlock, wake what waits
//! or, when wounded or denied (setback):
//!   Abort                ------------->  unlock, wake what waits
//!   start again          <------- Aborted
//! ```
//!
//! [`Worker::step`] is a pure state machine: no clock, no thread, no randomness, no float.
//! Threads, the simulator and the models of `verify/models` all run it; the mesh is behind
//! [`Submesh`], the points to insert behind [`Source`], and every deliberate defect that the
//! models must find is a question of [`Rules`]. `docs/protocol.md` is the specification.
//!
//! | module | what it holds |
//! |---|---|
//! | `worker` | events, actions, and the routing of events |
//! | `config` | conflict rule, closure, window |
//! | `state` | what a worker knows of its operations and lock requests |
//! | `operation` | the home's side of an operation |
//! | `lock_request` | the owner's side: requests, queues, grants |
//! | `migration` | blocks that change their owner |
//! | `termination` | the token, in waves over a tree |
//! | `directory`, `table` | who owns which block; a small map |
//! | `news` | what sources tell each other |
//! | `rules` | R1 to R33, a question each |
//! | `invariant` | P1 to P12, as assertions that hold in releases |
//! | `submesh` | what is needed of a mesh and of a supply of points |
//! | `variants` | the steps of the paper's conflict rule and closure |

mod config;
mod directory;
mod invariant;
mod lock_request;
mod migration;
mod news;
mod operation;
mod rules;
mod state;
mod submesh;
pub(crate) mod table;
mod termination;
#[cfg(all(test, not(any(loom, shuttle))))]
mod tests;
mod variants;
mod worker;

pub use config::{Closure, Config, Rule};
pub use directory::{BlockId, Directory, WorkerId};
pub use invariant::{Broken, Invariant, message_of};
pub(crate) use invariant::{broken, invariant};
pub use news::{NoNews, Standing};
pub use rules::{Correct, Rules};
pub(crate) use state::{Phase, Request, Waiter, Want};
pub use submesh::{
    Costs, Found, Insert, Item, Neighbour, Part, Source, Submesh, SubmeshError, Walk,
};
pub use termination::Token;
pub use worker::{Action, Event, Note, Worker};

/// The age of an operation, kept across setbacks: the smaller one is older.
///
/// A Lamport clock at the first admission to a window, made unique by worker and sequence number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ticket {
    /// Lamport clock: above that of every ticket that the worker had seen.
    pub clock: u32,
    /// The worker that issued it.
    pub worker: WorkerId,
    /// Counts that worker's tickets.
    pub sequence: u32,
}

ltbw_core::ids! {
    /// Number of an attempt: the setbacks of its operation so far. It tells a message from one of
    /// an earlier attempt.
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    Attempt
}

impl Attempt {
    /// The one after it.
    #[inline]
    pub const fn next(self) -> Self {
        Self(self.0 + 1)
    }
}

/// The name of a tetrahedron that another worker knows: never given twice.
///
/// The worker that makes it and a counter of that worker: a name says nothing about where the
/// tetrahedron is, so that a migration renames nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Name {
    /// The worker that named it.
    pub by: WorkerId,
    /// Counts that worker's names.
    pub number: u32,
}

/// The far side of an interface face: a tetrahedron of another worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Handle {
    /// The tetrahedron's name.
    pub name: Name,
    /// The block that it belongs to; the directory knows whose that is.
    pub block: BlockId,
    /// The face, as the slot of the vertex opposite it.
    pub face: u8,
}

/// The messages of workers to each other. `S` is the submesh that the payloads belong to.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound(
        serialize = "S::Point: serde::Serialize, S::Piece: serde::Serialize, \
                     S::Patch: serde::Serialize, S::Cargo: serde::Serialize, \
                     S::News: serde::Serialize",
        deserialize = "S::Point: serde::Deserialize<'de>, S::Piece: serde::Deserialize<'de>, \
                       S::Patch: serde::Deserialize<'de>, S::Cargo: serde::Deserialize<'de>, \
                       S::News: serde::Deserialize<'de>"
    ))
)]
pub enum Message<S: Submesh> {
    /// Point location goes on at the receiver, which becomes the operation's home.
    Walk {
        /// The operation.
        ticket: Ticket,
        /// Its setbacks so far.
        attempt: Attempt,
        /// The point to insert.
        point: S::Point,
        /// The tetrahedron that the walk enters; `None` if the sender has none at all.
        at: Option<Handle>,
    },
    /// The sender, the operation's home, asks for the receiver's part of a closure.
    Expand {
        /// The operation.
        ticket: Ticket,
        /// Its attempt.
        attempt: Attempt,
        /// The point to insert.
        point: S::Point,
        /// Tetrahedra to lock and test; the part spreads from those in conflict.
        seeds: Vec<Handle>,
        /// Empty while the cavity is collected. Then, if the closure is [`Closure::Vertex`], the
        /// cavity's vertices: to lock is what touches them, without a test; it spreads from the
        /// seeds and from all that is locked.
        #[cfg_attr(feature = "serde", serde(default))]
        around: Vec<u64>,
    },
    /// The answer to `answers` messages `Expand`: everything asked for is locked.
    Grant {
        /// The operation.
        ticket: Ticket,
        /// Its attempt.
        attempt: Attempt,
        /// The number of `Expand` that this answers.
        answers: u32,
        /// The tetrahedra in conflict, found since the last grant.
        pieces: Vec<S::Piece>,
        /// Tetrahedra of other workers next to those.
        foreign: Vec<Handle>,
        /// Seeds whose block has moved away: to be asked for where the directory says now.
        bounced: Vec<Handle>,
        /// Where the blocks of `bounced` are: worker and epoch.
        moved: Vec<(BlockId, WorkerId, u32)>,
    },
    /// The paper's rule: the request met a lock, the operation is set back.
    Deny {
        /// The operation.
        ticket: Ticket,
        /// Its attempt.
        attempt: Attempt,
    },
    /// An older operation waits for a lock of this one: set it back.
    Wound {
        /// The operation.
        ticket: Ticket,
        /// Its attempt.
        attempt: Attempt,
    },
    /// The setback: release all locks of the operation.
    Abort {
        /// The operation.
        ticket: Ticket,
        /// Its attempt.
        attempt: Attempt,
    },
    /// All locks of the attempt are released.
    Aborted {
        /// The operation.
        ticket: Ticket,
        /// Its attempt.
        attempt: Attempt,
    },
    /// The cavity is filled: replace, unlock. Also sent to workers that own new tetrahedra only.
    Commit {
        /// The operation.
        ticket: Ticket,
        /// The changes of the receiver's submesh.
        patch: Option<S::Patch>,
    },
    /// A block with its tetrahedra and points changes its owner.
    Migrate {
        /// The block.
        block: BlockId,
        /// Counts its moves.
        epoch: u32,
        /// Its tetrahedra.
        cargo: S::Cargo,
        /// Its points that are still to be inserted.
        points: Vec<S::Point>,
    },
    /// Tetrahedra made for a block after it had moved: they follow it.
    Stray {
        /// The block.
        block: BlockId,
        /// Its tetrahedra.
        cargo: S::Cargo,
    },
    /// The news of a source for another one.
    News(S::News),
    /// Termination detection. Not counted by it.
    Token(Token),
    /// All work is done everywhere. Not counted by termination detection.
    Stop,
}

impl<S: Submesh> Message<S> {
    /// Does termination detection count this message?
    pub fn is_basic(&self) -> bool {
        !matches!(self, Self::Token(_) | Self::Stop)
    }

    /// Is it about an operation, or a block?
    fn is_of_operation(&self) -> bool {
        self.is_basic() && !matches!(self, Self::News(_))
    }

    /// The operation that it is about.
    pub fn ticket(&self) -> Option<Ticket> {
        match self {
            Self::Walk { ticket, .. }
            | Self::Expand { ticket, .. }
            | Self::Grant { ticket, .. }
            | Self::Deny { ticket, .. }
            | Self::Wound { ticket, .. }
            | Self::Abort { ticket, .. }
            | Self::Aborted { ticket, .. }
            | Self::Commit { ticket, .. } => Some(*ticket),
            Self::Migrate { .. }
            | Self::Stray { .. }
            | Self::News(_)
            | Self::Token(_)
            | Self::Stop => None,
        }
    }

    /// The name of its kind, for traces.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Walk { .. } => "walk",
            Self::Expand { .. } => "expand",
            Self::Grant { .. } => "grant",
            Self::Deny { .. } => "deny",
            Self::Wound { .. } => "wound",
            Self::Abort { .. } => "abort",
            Self::Aborted { .. } => "aborted",
            Self::Commit { .. } => "commit",
            Self::Migrate { .. } => "migrate",
            Self::Stray { .. } => "stray",
            Self::News(_) => "news",
            Self::Token(_) => "token",
            Self::Stop => "stop",
        }
    }
}
