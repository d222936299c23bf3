//! The cancel token, asked by loops that run before there is a mesh to give.

use crate::RefineError;
use ltbw_core::CancelToken;

/// Elements that a loop of little work goes through between two looks at the token.
const CHECK_EVERY: usize = 1 << 14;

/// Heeds a token, if there is one.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Heed<'a>(pub(crate) Option<&'a CancelToken>);

impl Heed<'_> {
    /// Is the work cancelled?
    pub(crate) fn is_cancelled(self) -> bool {
        self.0.is_some_and(CancelToken::is_cancelled)
    }

    /// Goes on unless the work is cancelled.
    ///
    /// # Errors
    /// [`RefineError::Cancelled`].
    pub(crate) fn ask(self) -> Result<(), RefineError> {
        if self.is_cancelled() { Err(RefineError::Cancelled) } else { Ok(()) }
    }

    /// Asks once in a number of elements of a loop of little work.
    ///
    /// # Errors
    /// [`RefineError::Cancelled`].
    pub(crate) fn ask_at(self, element: usize) -> Result<(), RefineError> {
        if element.is_multiple_of(CHECK_EVERY) { self.ask() } else { Ok(()) }
    }
}
