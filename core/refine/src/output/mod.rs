//! The outcome: the mesh as plain arrays, and what is over its bounds.
//!
//! | module | what it holds |
//! |---|---|
//! | `refined` | the mesh and its boundary |
//! | `excuse`, `share` | what is over its bounds, and why; whether that is much |
//! | `part` | what is told of one worker's part of it |
//! | `display` | texts |

pub(crate) mod display;
pub(crate) mod excuse;
pub(crate) mod part;
pub(crate) mod refined;
pub(crate) mod share;
