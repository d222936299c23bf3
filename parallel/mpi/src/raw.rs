//! The calls of MPI whose buffers outlive them: the only unsafe code of this crate.
//!
//! A send owns its bytes until MPI says that it is done with them, which no borrow of a scope can
//! say. All calls come from the thread that has initialised MPI (`MPI_THREAD_FUNNELED`). Errors of
//! MPI end the job: that is what a communicator does unless it is told otherwise.

use mpi::ffi;
use mpi::point_to_point::Source;
use mpi::raw::AsRaw;
use mpi::topology::{Communicator, SimpleCommunicator};
use std::marker::PhantomData;
use std::os::raw::c_int;
use std::ptr::from_mut;

/// Sends that MPI is not done with yet, and what has arrived.
pub(crate) struct Calls {
    comm: SimpleCommunicator,
    requests: Vec<ffi::MPI_Request>,
    /// The bytes of each request, which stay where they are until it is complete.
    buffers: Vec<Vec<u8>>,
    indices: Vec<c_int>,
    /// Not to be sent to another thread.
    here: PhantomData<*const ()>,
}

impl Calls {
    /// The calls of this process on a communicator of its own, like `world`.
    pub(crate) fn on(world: &SimpleCommunicator) -> Self {
        let comm = world.duplicate();
        let (requests, buffers, indices) = (Vec::new(), Vec::new(), Vec::new());
        Self { comm, requests, buffers, indices, here: PhantomData }
    }

    /// The communicator.
    pub(crate) fn comm(&self) -> &SimpleCommunicator {
        &self.comm
    }

    /// Begins to send these bytes; gives them back if they are more than MPI can count.
    pub(crate) fn send(&mut self, to: c_int, tag: c_int, bytes: Vec<u8>) -> Result<(), Vec<u8>> {
        let Ok(count) = c_int::try_from(bytes.len()) else { return Err(bytes) };
        // SAFETY: a request is plain data of C, which the call below overwrites.
        let mut request: ffi::MPI_Request = unsafe { std::mem::zeroed() };
        // SAFETY: the memory of `bytes` is on the heap and stays there: `buffers` keeps the vector
        // unchanged until the request is complete, and `Drop` waits for those that are not.
        unsafe {
            ffi::MPI_Isend(
                bytes.as_ptr().cast(),
                count,
                ffi::RSMPI_UINT8_T,
                to,
                tag,
                self.comm.as_raw(),
                &raw mut request,
            );
        }
        self.requests.push(request);
        self.buffers.push(bytes);
        Ok(())
    }

    /// Moves the bytes of sends that are complete to `done`. Lets MPI go on with the others.
    pub(crate) fn complete(&mut self, done: &mut Vec<Vec<u8>>) {
        let Ok(open) = c_int::try_from(self.requests.len()) else { return };
        if open == 0 {
            return;
        }
        self.indices.resize(self.requests.len(), 0);
        let mut count: c_int = 0;
        // SAFETY: `requests` and `indices` have `open` elements each, and statuses are ignored.
        unsafe {
            ffi::MPI_Testsome(
                open,
                self.requests.as_mut_ptr(),
                &raw mut count,
                self.indices.as_mut_ptr(),
                ffi::RSMPI_STATUSES_IGNORE,
            );
        }
        let complete = usize::try_from(count).unwrap_or(0).min(self.indices.len());
        self.indices.truncate(complete);
        // From the last one on, so that those before stay in their places.
        self.indices.sort_unstable_by(|a, b| b.cmp(a));
        for &k in &self.indices {
            let k = k as usize;
            self.requests.swap_remove(k);
            done.push(self.buffers.swap_remove(k));
        }
    }

    /// Takes a message that has arrived, into the memory of `bytes`: its sender and tag.
    pub(crate) fn take(&mut self, bytes: &mut Vec<u8>) -> Option<(c_int, c_int)> {
        let (mut flag, mut count): (c_int, c_int) = (0, 0);
        // SAFETY: both are plain data of C, which the calls below fill in.
        let mut message: ffi::MPI_Message = unsafe { std::mem::zeroed() };
        // SAFETY: as above.
        let mut status: ffi::MPI_Status = unsafe { std::mem::zeroed() };
        // SAFETY: all pointers are to variables that live until the call returns.
        unsafe {
            ffi::MPI_Improbe(
                ffi::RSMPI_ANY_SOURCE,
                ffi::RSMPI_ANY_TAG,
                self.comm.as_raw(),
                &raw mut flag,
                &raw mut message,
                from_mut(&mut status),
            );
        }
        if flag == 0 {
            return None;
        }
        // SAFETY: `status` is that of the message found.
        unsafe { ffi::MPI_Get_count(&raw const status, ffi::RSMPI_UINT8_T, &raw mut count) };
        bytes.clear();
        bytes.resize(usize::try_from(count).unwrap_or(0), 0);
        // SAFETY: `bytes` has room for the `count` bytes of the message, which nobody else can
        // receive since it was probed as `message`.
        unsafe {
            ffi::MPI_Mrecv(
                bytes.as_mut_ptr().cast(),
                count,
                ffi::RSMPI_UINT8_T,
                &raw mut message,
                from_mut(&mut status),
            );
        }
        Some((status.MPI_SOURCE, status.MPI_TAG))
    }

    /// Has a message arrived?
    pub(crate) fn has_some(&self) -> bool {
        self.comm.any_process().immediate_probe().is_some()
    }
}

impl Drop for Calls {
    fn drop(&mut self) {
        // Ends: the team has come to its end, where all that was sent is received; a process that
        // ends otherwise aborts the job and comes by here no more.
        let mut done = Vec::new();
        while !self.requests.is_empty() {
            self.complete(&mut done);
        }
    }
}
