//! The only place of this crate that says where locks come from: the standard library, or one of
//! the model checkers of `verify/models`, which run every interleaving (loom) or many (shuttle).

#[cfg(tsan)]
mod annotated;
mod tally;

pub(crate) use tally::Tally;

#[cfg(tsan)]
pub(crate) use annotated::{Condvar, Mutex, MutexGuard};
#[cfg(loom)]
pub(crate) use loom::sync::{Arc, Condvar, Mutex, MutexGuard};
#[cfg(shuttle)]
pub(crate) use shuttle::sync::{Arc, Condvar, Mutex, MutexGuard};
#[cfg(not(any(loom, shuttle)))]
pub(crate) use std::sync::Arc;
#[cfg(not(any(loom, shuttle, tsan)))]
pub(crate) use std::sync::{Condvar, Mutex, MutexGuard};
