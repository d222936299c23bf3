//! What the system is told of the memory behind arrays.

use crate::sphere::Sphere;
use crate::topology::Tet;
use std::ops::Range;

/// Size of a huge page.
pub(super) const HUGE: usize = 1 << 21;

/// Types of which every bit pattern is a value, zeros among them.
///
/// # Safety
/// The type consists of numbers alone.
pub(crate) unsafe trait Zeroable: Copy + Send + Sync {}

// SAFETY: eight 32-bit integers.
unsafe impl Zeroable for Tet {}
// SAFETY: four 32-bit floats.
unsafe impl Zeroable for Sphere {}

/// Gives the memory behind `entries` back to the system where it makes whole pages; they may read
/// as zero afterwards.
pub(super) fn forget_memory<T: Zeroable>(entries: &mut [T]) {
    let range = entries.as_mut_ptr_range();
    advise(range.start as usize..range.end as usize, Advice::Forget);
}

/// Asks for huge pages behind the whole capacity of `array`: fewer page faults and TLB misses.
pub(super) fn advise_huge<T>(array: &Vec<T>) {
    let start = array.as_ptr() as usize;
    advise(start..start + array.capacity() * size_of::<T>(), Advice::Huge);
}

/// What the system is told of memory.
#[derive(Clone, Copy)]
pub(super) enum Advice {
    /// To use huge pages.
    Huge,
    /// To take it back; it reads as zero afterwards. Only of [`Zeroable`] entries that the caller
    /// has to itself.
    Forget,
}

/// Says so of the whole pages at these addresses, which belong to one array. A hint: nothing
/// depends on it.
pub(super) fn advise(addresses: Range<usize>, advice: Advice) {
    #[cfg(target_os = "linux")]
    {
        let (page, advice) = match advice {
            Advice::Huge => (HUGE, libc::MADV_HUGEPAGE),
            // Not less than the largest page that is not huge.
            Advice::Forget => (1 << 16, libc::MADV_DONTNEED),
        };
        let start = addresses.start.next_multiple_of(page);
        let end = addresses.end & !(page - 1);
        if end > start {
            // SAFETY: start..end lies in the array's own allocation and is page-aligned.
            // MADV_HUGEPAGE changes no content; after MADV_DONTNEED anonymous memory reads as
            // zero, a value of what [`forget_memory`] has to itself. A failure is harmless.
            unsafe {
                libc::madvise(start as *mut libc::c_void, end - start, advice);
            }
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = (addresses, advice);
}
