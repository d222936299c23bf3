//! The kinds of news that barriers wait for.

use super::DomainNews;

/// The kinds of news that barriers wait for, in the order in which a round has them.
pub(crate) const NEWS_KINDS: [&str; 23] = [
    "Keys",
    "Way",
    "Seek",
    "Search",
    "Beyond",
    "Part",
    "Blocks",
    "Void",
    "WantRivals",
    "Entrants",
    "Launch",
    "Report",
    "Fates",
    "Waiting",
    "Lend",
    "Lent",
    "Parted",
    "Rivals",
    "Ask",
    "Gone",
    "Release",
    "Refused",
    "Unblocked",
];

impl DomainNews {
    /// The kinds of all that it tells, of [`NEWS_KINDS`].
    pub(crate) fn kinds(&self) -> Vec<&'static str> {
        let kind = match self {
            Self::Keys { .. } => 0,
            Self::Way { .. } => 1,
            Self::Seek { .. } => 2,
            Self::Search { .. } => 3,
            Self::Beyond { .. } => 4,
            Self::Part { .. } => 5,
            Self::Blocks(_) => 6,
            Self::Void(_) => 7,
            Self::WantRivals(_) => 8,
            Self::Entrants(_) => 9,
            Self::Launch(_) => 10,
            Self::Report(_) => 11,
            Self::Fates(_) => 12,
            Self::Waiting(_) => 13,
            Self::Lend(_) => 14,
            Self::Lent(_) => 15,
            Self::Parted(_) => 16,
            Self::Rivals { .. } => 17,
            Self::Ask { .. } => 18,
            Self::Gone(_) => 19,
            Self::Release(_) => 20,
            Self::Refused(_) => 21,
            Self::Unblocked(_) => 22,
            Self::Several(all) => return all.iter().flat_map(Self::kinds).collect(),
            Self::Up(_) | Self::Down(_) | Self::Ended(_) => return Vec::new(),
        };
        vec![NEWS_KINDS[kind]]
    }
}
