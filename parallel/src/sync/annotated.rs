//! The standard library's locks as ThreadSanitizer must see them: `cargo xtask tsan`.
//!
//! The sanitizer knows what happens before what from the atomics of instrumented code. The standard
//! library comes compiled without it, so that a lock taken in the library's slow path, after a
//! wait, looks like no lock at all. Here every lock has a shadow, an atomic of ours: read with
//! `Acquire` after the lock is taken, written with `Release` before it is given back. That says
//! what a mutex promises, and nothing more: both happen inside the critical section.
//!
//! One thing is assumed: the library's mutex is one. Everything around it is checked.
//! With the variable `LTBW_TSAN_CANARY` the shadows are not read: then races must be reported.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{LockResult, PoisonError, WaitTimeoutResult};
use std::time::Duration;

/// [`std::sync::Mutex`] with a shadow.
pub(crate) struct Mutex<T> {
    inner: std::sync::Mutex<T>,
    shadow: AtomicU32,
}

/// [`std::sync::MutexGuard`] with the shadow. Fields are dropped in their order.
pub(crate) struct MutexGuard<'a, T> {
    release: Release<'a>,
    inner: std::sync::MutexGuard<'a, T>,
}

struct Release<'a>(&'a AtomicU32);

impl Drop for Release<'_> {
    fn drop(&mut self) {
        self.0.fetch_add(1, Ordering::Release);
    }
}

/// Asked of the environment each time at first: the standard library's cells for what is computed
/// once are not compiled with the sanitizer, which would see a race in them.
fn is_canary() -> bool {
    /// 0: not asked yet; 1: no; 2: yes.
    static CANARY: AtomicU32 = AtomicU32::new(0);
    match CANARY.load(Ordering::Relaxed) {
        0 => {
            let canary = std::env::var_os("LTBW_TSAN_CANARY").is_some();
            CANARY.store(1 + u32::from(canary), Ordering::Relaxed);
            canary
        }
        known => known == 2,
    }
}

fn guard<'a, T>(
    inner: std::sync::MutexGuard<'a, T>,
    shadow: &'a AtomicU32,
) -> LockResult<MutexGuard<'a, T>> {
    if !is_canary() {
        shadow.load(Ordering::Acquire);
    }
    Ok(MutexGuard { release: Release(shadow), inner })
}

impl<T> Mutex<T> {
    pub(crate) fn new(value: T) -> Self {
        Self { inner: std::sync::Mutex::new(value), shadow: AtomicU32::new(0) }
    }

    /// Poison is ignored, as the mailbox does.
    pub(crate) fn lock(&self) -> LockResult<MutexGuard<'_, T>> {
        guard(self.inner.lock().unwrap_or_else(PoisonError::into_inner), &self.shadow)
    }
}

impl<T> std::ops::Deref for MutexGuard<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.inner
    }
}

impl<T> std::ops::DerefMut for MutexGuard<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.inner
    }
}

/// [`std::sync::Condvar`]: a wait gives the lock back and takes it again.
pub(crate) struct Condvar(std::sync::Condvar);

impl Condvar {
    pub(crate) fn new() -> Self {
        Self(std::sync::Condvar::new())
    }

    pub(crate) fn notify_one(&self) {
        self.0.notify_one();
    }

    pub(crate) fn wait<'a, T>(&self, lock: MutexGuard<'a, T>) -> LockResult<MutexGuard<'a, T>> {
        let MutexGuard { release, inner } = lock;
        let shadow = release.0;
        drop(release);
        guard(self.0.wait(inner).unwrap_or_else(PoisonError::into_inner), shadow)
    }

    pub(crate) fn wait_timeout<'a, T>(
        &self,
        lock: MutexGuard<'a, T>,
        timeout: Duration,
    ) -> LockResult<(MutexGuard<'a, T>, WaitTimeoutResult)> {
        let MutexGuard { release, inner } = lock;
        let shadow = release.0;
        drop(release);
        let woken = self.0.wait_timeout(inner, timeout);
        let (inner, result) = woken.unwrap_or_else(PoisonError::into_inner);
        Ok((guard(inner, shadow).unwrap_or_else(PoisonError::into_inner), result))
    }
}
