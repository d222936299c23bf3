//! The configuration of a worker: the conflict rule and the closure among it. Those that are not
//! the default are the paper's; their steps are in `variants`.

/// The configuration, which does not change during a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Config {
    /// Number of workers.
    pub workers: u32,
    /// The conflict rule.
    pub rule: Rule,
    /// The closure that an operation locks.
    pub closure: Closure,
    /// A worker starts a point only while fewer operations than this are at home here. Walks that
    /// come in are always taken, and count like its own operations.
    pub window: usize,
}

impl Config {
    /// The default rule and window for `workers` workers.
    pub fn new(workers: u32) -> Self {
        Self { workers, rule: Rule::default(), closure: Closure::default(), window: 256 }
    }
}

/// The conflict rule: what happens when a request meets a locked tetrahedron.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Rule {
    /// An older request wounds the holder and waits; a younger one waits (Rosenkrantz, Stearns
    /// and Lewis, ACM TODS 3, 1978). Free of deadlock and livelock without any backoff.
    #[default]
    WoundWait,
    /// The paper's: every request that meets a lock is denied and tried again later. Lives by
    /// randomised backoff only.
    Paper,
}

/// The closure that an operation locks.
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

/// Gives variants their names: reads and writes them.
macro_rules! named {
    ($($type:ident, $what:literal: $($variant:ident $name:literal)*;)*) => {$(
        impl $type {
            /// All of them.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// Its name.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name),*
                }
            }
        }

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

named! {
    Rule, "rule": WoundWait "wound-wait" Paper "paper";
    Closure, "closure": Face "face" Vertex "vertex";
}
