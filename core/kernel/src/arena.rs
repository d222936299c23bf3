//! Arrays without bounds checks, on huge pages: one of the three modules with unsafe code (the
//! others are the vector code of spheres, `sphere/simd.rs`, and `lanes`).
//!
//! Its gain (1M uniform points, order + insertion, measured side by side): see
//! `docs/decisions/02-cached-spheres.md`.
#![allow(unsafe_code)]

mod memory;

use memory::{Advice, HUGE, advise, advise_huge, forget_memory};
pub(crate) use memory::{Zeroable, zeroable};
use rayon::prelude::*;
use std::mem::MaybeUninit;
use std::ops::Range;

/// An array that is indexed without bounds checks in release: the large arrays of a mesh.
///
/// Invariant I7: every index that the kernel uses was made by this array's own growth (tetrahedron
/// ids and face handles by `Topology::take`, vertices by `Geometry::push`), arrays never shrink,
/// and ids that come from outside are compared with `len` first. Debug builds, and with them all
/// tests and fuzzing, check every index.
pub(crate) struct Arena<T> {
    /// All entries; none of an alias.
    data: Vec<T>,
    /// The first entry: of `data`, or of the array whose alias this is.
    first: *mut T,
    /// The number of entries that an alias may name.
    others: usize,
}

// SAFETY: an arena owns its entries. Of an alias its builder has promised that no entry is used by
// two threads at once ([`Arena::alias`]).
unsafe impl<T: Send> Send for Arena<T> {}
// SAFETY: through a shared reference entries are only read.
unsafe impl<T: Sync> Sync for Arena<T> {}

impl<T: Clone> Clone for Arena<T> {
    fn clone(&self) -> Self {
        Self::of(self.data.clone())
    }
}

impl<T: PartialEq> PartialEq for Arena<T> {
    fn eq(&self, other: &Self) -> bool {
        self.data == other.data
    }
}

impl<T: Eq> Eq for Arena<T> {}

impl<T: std::fmt::Debug> std::fmt::Debug for Arena<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.data.fmt(f)
    }
}

impl<T> Arena<T> {
    /// An empty array with room for `capacity` entries, on huge pages where there are any. The
    /// room is a hint: where it is refused the array grows as it is filled.
    pub(crate) fn with_capacity(capacity: usize) -> Self {
        let mut array = Vec::new();
        expect(&mut array, capacity);
        Self::of(array)
    }

    /// `len` times `entry`. Where it is zero, memory is taken when it is first written to.
    pub(crate) fn filled(entry: T, len: usize) -> Self
    where
        T: Clone,
    {
        Self::of(vec![entry; len])
    }

    /// These entries under another name, for one of several threads.
    ///
    /// # Safety
    /// As long as there are aliases the array is there, but is not used itself, and no entry is
    /// used through one of them while it is written through another. Aliases do not grow.
    pub(crate) unsafe fn alias(&mut self) -> Self {
        Self { data: Vec::new(), first: self.first, others: self.data.len() }
    }

    /// Asks for huge pages behind some entries: they are all to be written. A hint.
    pub(crate) fn prepare(&self, entries: Range<usize>) {
        if let Some(entries) = self.data.get(entries) {
            let range = entries.as_ptr_range();
            advise(range.start as usize..range.end as usize, Advice::Huge);
        }
    }

    /// The entries of `array`.
    pub(crate) fn of(mut data: Vec<T>) -> Self {
        let first = data.as_mut_ptr();
        Self { data, first, others: 0 }
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, entry: T) {
        self.data.push(entry);
        self.first = self.data.as_mut_ptr();
    }

    /// Appends `f` of the first `count` entries of `other`, piece by piece on all threads. The
    /// memory of a piece is given back as soon as it is copied, so that the next one may use it:
    /// fresh memory costs more than copying.
    pub(crate) fn append(&mut self, mut other: Self, count: usize, f: impl Fn(T) -> T + Sync)
    where
        T: Zeroable,
    {
        let (old, len) = (self.data.len(), count.min(other.data.len()));
        let capacity = self.data.capacity();
        self.data.reserve(len);
        self.first = self.data.as_mut_ptr();
        if self.data.capacity() != capacity {
            advise_huge(&self.data);
        }
        let source = &mut other.data[..len];
        // Pieces of whole huge pages; entries are smaller than one and fill it.
        let offset = (source.as_ptr() as usize).next_multiple_of(HUGE) - source.as_ptr() as usize;
        let head = (offset / size_of::<T>()).min(len);
        let (head, rest) = source.split_at_mut(head);
        let spare = &mut self.data.spare_capacity_mut()[..len];
        let (spare_head, spare_rest) = spare.split_at_mut(head.len());
        let copy = |source: &mut [T], spare: &mut [MaybeUninit<T>]| {
            for (entry, place) in source.iter().zip(spare) {
                place.write(f(*entry));
            }
            forget_memory(source);
        };
        let piece = HUGE / size_of::<T>();
        rayon::join(
            || copy(head, spare_head),
            || {
                let pieces = rest.par_chunks_mut(piece).zip(spare_rest.par_chunks_mut(piece));
                pieces.for_each(|(source, spare)| copy(source, spare));
            },
        );
        // SAFETY: room for `len` more was reserved, and each of them was written.
        unsafe { self.data.set_len(old + len) };
    }

    /// Grows to `len` entries, never shrinks.
    pub(crate) fn grow(&mut self, len: usize, entry: T)
    where
        T: Clone,
    {
        if self.data.len() < len {
            self.data.resize(len, entry);
            self.first = self.data.as_mut_ptr();
        }
    }

    /// Takes memory for `capacity` entries, on huge pages where there are any. A hint.
    pub(crate) fn expect(&mut self, capacity: usize) {
        expect(&mut self.data, capacity);
        self.first = self.data.as_mut_ptr();
    }

    /// All entries.
    #[inline(always)]
    pub(crate) fn all(&self) -> &[T] {
        &self.data
    }

    /// All entries.
    pub(crate) fn all_mut(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// Entry `i`, which must exist (I7).
    #[inline(always)]
    pub(crate) fn at(&self, i: impl Into<u32>) -> &T {
        let i = i.into() as usize;
        debug_assert!(self.has(i), "I7: {i} of {}", self.data.len().max(self.others));
        // SAFETY: I7, checked in debug builds.
        unsafe { &*self.first.add(i) }
    }

    /// Entry `i`, if there is one.
    pub(crate) fn get(&self, i: impl Into<u32>) -> Option<&T> {
        let i = i.into();
        self.has(i as usize).then(|| self.at(i))
    }

    /// Asks the processor to fetch entry `i` into its cache. A hint: nothing depends on it.
    #[inline(always)]
    pub(crate) fn prefetch(&self, i: impl Into<u32>) {
        prefetch(self.first.wrapping_add(i.into() as usize).cast_const());
    }

    /// Entry `i`, which must exist (I7).
    #[inline(always)]
    pub(crate) fn at_mut(&mut self, i: impl Into<u32>) -> &mut T {
        let i = i.into() as usize;
        debug_assert!(self.has(i), "I7: {i} of {}", self.data.len().max(self.others));
        // SAFETY: I7, checked in debug builds.
        unsafe { &mut *self.first.add(i) }
    }

    fn has(&self, i: usize) -> bool {
        i < self.data.len().max(self.others)
    }
}

impl<T> Default for Arena<T> {
    fn default() -> Self {
        Self::of(Vec::new())
    }
}

/// Takes memory for `capacity` entries, on huge pages where there are any. A hint: where it is
/// refused the array grows as it is filled.
pub fn expect<T>(array: &mut Vec<T>, capacity: usize) {
    let more = capacity.saturating_sub(array.len());
    if array.capacity() < capacity && array.try_reserve_exact(more).is_ok() {
        advise_huge(array);
    }
}

/// The system refuses memory that is going to be needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the machine lacks memory: {bytes} bytes more are refused")]
pub struct NoMemory {
    /// The bytes that were asked for.
    pub bytes: usize,
}

/// Asks the system whether it would give this number of bytes more; they are given back unused.
/// Where memory is promised beyond what there is, as most systems do without a limit, the answer
/// is yes.
///
/// # Errors
/// [`NoMemory`] if it would not.
pub fn ask(bytes: usize) -> Result<(), NoMemory> {
    let mut room: Vec<u8> = Vec::new();
    let given = room.try_reserve_exact(bytes);
    // Memory that nobody looks at need not be asked for.
    std::hint::black_box(&room);
    given.map_err(|_| NoMemory { bytes })
}

/// Asks the system whether a mesh of this number of vertices and tetrahedra finds room.
pub(crate) fn ask_for(vertices: usize, tets: usize) -> Result<(), NoMemory> {
    // Corners, neighbours and spheres of tetrahedra; coordinates and numbers of vertices.
    ask(tets.saturating_mul(48).saturating_add(vertices.saturating_mul(32)))
}

/// Asks the processor to fetch what is at an address into its cache. A hint: nothing depends on it.
#[inline(always)]
pub fn prefetch<T>(entry: *const T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: SSE is part of x86-64, and a prefetch of any address is harmless.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(entry.cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = entry;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn appended_entries_come_in_their_order() {
        let entry = |k: usize| [k as f32, 1.0, 2.0, 3.0];
        // From nothing to some huge pages' worth.
        for count in [0, 1, 1000, 131_072, 300_001] {
            let mut array = Arena::of((0..10).map(entry).collect());
            let other = Arena::of((10..20 + count).map(entry).collect());
            array.append(other, count, |s| [s[0], s[1], s[2], 4.0]);
            assert_eq!(array.all().len(), 10 + count);
            for (k, s) in array.all().iter().enumerate() {
                assert_eq!(*s, [k as f32, 1.0, 2.0, if k < 10 { 3.0 } else { 4.0 }]);
            }
        }
    }

    #[test]
    fn memory_that_there_cannot_be_is_refused() {
        assert_eq!((ask(0), ask(1 << 20)), (Ok(()), Ok(())));
        for bytes in [usize::MAX, usize::MAX / 2] {
            assert_eq!(ask(bytes), Err(NoMemory { bytes }));
        }
    }

    #[test]
    fn a_refused_reservation_is_no_failure() {
        for capacity in [usize::MAX, usize::MAX / 64, 100] {
            let mut array = Arena::with_capacity(capacity);
            array.push([1u64; 6]);
            array.grow(3, [2; 6]);
            assert_eq!(array.all(), [[1; 6], [2; 6], [2; 6]]);
        }
    }
}
