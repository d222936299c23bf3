//! Advice to the system about the memory behind arrays.

use std::ops::Range;

/// Size of a huge page.
pub(super) const HUGE: usize = 1 << 21;

/// Types of which every bit pattern is a value, zeros among them.
///
/// # Safety
/// The type consists of numbers alone.
pub(crate) unsafe trait Zeroable: Copy + Send + Sync {}

// SAFETY: a number.
unsafe impl Zeroable for u32 {}
// SAFETY: a number.
unsafe impl Zeroable for f32 {}
// SAFETY: numbers, without anything between them.
unsafe impl<T: Zeroable, const N: usize> Zeroable for [T; N] {}

/// Makes a structure [`Zeroable`] whose fields are: named in full, or it does not compile.
macro_rules! zeroable {
    ($type:ident { $($field:tt: $value:ident),* }) => {
        const _: () = {
            fn is_zeroable<T: $crate::arena::Zeroable>(_: T) {}
            #[allow(dead_code, reason = "is compiled, not called")]
            fn fields_are_zeroable($type { $($field: $value),* }: $type) {
                $(is_zeroable($value);)*
            }
        };
        // SAFETY: every field is a number or an array of numbers, as the function above shows.
        #[allow(unsafe_code)]
        unsafe impl $crate::arena::Zeroable for $type {}
    };
}
pub(crate) use zeroable;

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

/// An advice about memory.
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
            // MADV_HUGEPAGE changes no content. After MADV_DONTNEED anonymous private memory reads
            // as zero, a value of what [`forget_memory`] has to itself. Whether it is such memory
            // is the global allocator's to say, not this crate's: in shared memory, or a file,
            // entries keep their values or have the file's, numbers as well, and nobody reads them
            // again. A failure is harmless.
            unsafe {
                libc::madvise(start as *mut libc::c_void, end - start, advice);
            }
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = (addresses, advice);
}
