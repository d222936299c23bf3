//! Witnesses: what a model must have reached, else it shows nothing about it.

/// Something that must happen in at least one state of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Witness {
    /// An operation is set back.
    SetBack,
    /// Two workers ask each other for a part of a closure at the same time.
    Crossing,
    /// An `Expand` names a cell that is not installed yet.
    Installation,
    /// A seed is sent back because its block has moved.
    Bounce,
    /// A cell was made for a block after it had moved.
    Stray,
    /// A wound is under way to an operation that has committed.
    LateWound,
    /// A walk goes on at another worker.
    Walk,
    /// A block is under way.
    Move,
}

/// All of them.
pub const ALL: [Witness; 8] = [
    Witness::SetBack,
    Witness::Crossing,
    Witness::Installation,
    Witness::Bounce,
    Witness::Stray,
    Witness::LateWound,
    Witness::Walk,
    Witness::Move,
];

impl Witness {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::SetBack => "a setback",
            Self::Crossing => "two remote expands cross",
            Self::Installation => "an expand waits for an installation",
            Self::Bounce => "a bounce",
            Self::Stray => "a stray",
            Self::LateWound => "a wound after the commit",
            Self::Walk => "a walk leaves",
            Self::Move => "a block moves",
        }
    }
}
