//! What happens when a request meets a locked tetrahedron.

use super::Ticket;

/// The conflict rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Rule {
    /// An older request wounds the holder and waits; a younger one waits (Rosenkrantz, Stearns
    /// and Lewis, ACM TODS 3, 1978). Free of deadlock and livelock without any backoff.
    #[default]
    WoundWait,
    /// An older request waits; a younger one is denied, and starts again when the holder has
    /// released its locks.
    WaitDie,
    /// The paper's: every request that meets a lock is denied and tried again later. Lives by
    /// randomised backoff only.
    Paper,
}

/// What an operation locks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Closure {
    /// The cavity and its face neighbours: what is needed.
    #[default]
    Face,
    /// The paper's equation (5): all tetrahedra that share a finite vertex with the cavity. Some
    /// ten times as many; to reproduce the paper's figures.
    Vertex,
}

impl Closure {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Face, Self::Vertex];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Face => "face",
            Self::Vertex => "vertex",
        }
    }
}

/// Consequence of a conflict for the request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Wait,
    WoundAndWait,
    Deny,
}

impl Rule {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::WoundWait, Self::WaitDie, Self::Paper];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::WoundWait => "wound-wait",
            Self::WaitDie => "wait-die",
            Self::Paper => "paper",
        }
    }

    pub(crate) fn decide(self, request: Ticket, holder: Ticket) -> Verdict {
        let older = request < holder;
        match self {
            Self::WoundWait if older => Verdict::WoundAndWait,
            Self::WoundWait => Verdict::Wait,
            Self::WaitDie if older => Verdict::Wait,
            Self::WaitDie | Self::Paper => Verdict::Deny,
        }
    }
}

/// Reads and writes the names of `ALL`.
macro_rules! named {
    ($($type:ident: $what:literal),*) => {$(
        impl std::str::FromStr for $type {
            type Err = String;

            fn from_str(text: &str) -> Result<Self, String> {
                let found = Self::ALL.into_iter().find(|one| one.name() == text);
                found.ok_or_else(|| {
                    let names = Self::ALL.map(Self::name).join(", ");
                    format!("no {} `{text}`; there are {names}", $what)
                })
            }
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    )*};
}

named!(Rule: "rule", Closure: "closure");
