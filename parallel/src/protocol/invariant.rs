//! The invariants by number, and what happens when one is broken.
//!
//! `invariant!(P8, holds, "...")` is on in releases: a state that cannot be must not become a wrong
//! mesh or a run without an end. It panics inside the worker; the runtimes catch that and end the
//! run with an error that has the number ([`Broken`]). `docs/protocol.md` lists the invariants, and
//! [`crate::check`] tests them over all workers at once.

use std::fmt;

/// The invariants by their numbers.
macro_rules! numbered {
    ($first:ident $($number:ident)*) => {
        /// An invariant of `docs/protocol.md`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[allow(missing_docs)] // the page has them
        pub enum Invariant {
            $first = 1, $($number),*
        }

        impl Invariant {
            /// All of them, ascending.
            pub const ALL: [Self; 12] = [Self::$first, $(Self::$number),*];
        }
    };
}

numbered!(P1 P2 P3 P4 P5 P6 P7 P8 P9 P10 P11 P12);

impl fmt::Display for Invariant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

/// A broken invariant: a defect of this crate, or of a runtime that breaks the order of messages.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Broken {
    /// Which one.
    pub invariant: Invariant,
    /// The finding.
    pub what: String,
}

/// The start of the message of a panic that a broken invariant causes.
const PREFIX: &str = "invariant ";
/// The text after the number there.
const INFIX: &str = " is broken: ";

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{PREFIX}{}{INFIX}{}", self.invariant, self.what)
    }
}

impl Broken {
    /// Reads the message of a panic; `None` if its cause is another one.
    pub fn from_message(message: &str) -> Option<Self> {
        let (number, what) = message.strip_prefix(PREFIX)?.split_once(INFIX)?;
        let invariant = Invariant::ALL.into_iter().find(|p| p.to_string() == number)?;
        Some(Self { invariant, what: what.to_owned() })
    }
}

/// The message of a panic that was caught.
pub fn message_of(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
    text.unwrap_or_else(|| "a panic without a message".to_owned())
}

/// Panics for a broken invariant.
#[cold]
#[inline(never)]
#[track_caller]
pub(crate) fn broken(invariant: Invariant, what: fmt::Arguments<'_>) -> ! {
    panic!("{}", Broken { invariant, what: what.to_string() })
}

/// `invariant!(P8, holds, "...", ...)` panics unless `holds`; `invariant!(P8, "...", ...)` panics:
/// this place is never reached.
macro_rules! invariant {
    ($number:ident, $what:literal $(, $arg:expr)* $(,)?) => {
        $crate::protocol::broken(
            $crate::protocol::Invariant::$number,
            format_args!($what $(, $arg)*),
        )
    };
    ($number:ident, $holds:expr, $what:literal $(, $arg:expr)* $(,)?) => {
        if !$holds {
            $crate::protocol::broken(
                $crate::protocol::Invariant::$number,
                format_args!($what $(, $arg)*),
            )
        }
    };
}

pub(crate) use invariant;

#[cfg(all(test, not(any(loom, shuttle))))]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_page() {
        assert_eq!(Invariant::ALL.map(|i| i as usize), [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
    }

    #[test]
    fn a_broken_invariant_is_read_back_from_its_panic() {
        for number in Invariant::ALL {
            let panic = std::panic::catch_unwind(|| broken(number, format_args!("{} of 3", 4)));
            let message = message_of(&*panic.expect_err("it panics"));
            let found = Broken::from_message(&message).expect("an invariant");
            assert_eq!((found.invariant, found.what.as_str()), (number, "4 of 3"));
        }
        assert_eq!(Broken::from_message("index out of bounds"), None);
        assert_eq!(Broken::from_message("invariant P13 is broken: no such number"), None);
    }

    #[test]
    fn an_invariant_that_holds_does_nothing() {
        invariant!(P3, 1 + 1 == 2, "arithmetic");
        let count = 3;
        let panic = std::panic::catch_unwind(|| invariant!(P4, count == 4, "{count} of {}", 4));
        let message = message_of(&*panic.expect_err("it panics"));
        assert_eq!(message, "invariant P4 is broken: 3 of 4");
    }
}
