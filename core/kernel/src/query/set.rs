//! A set of numbers that is emptied in no time and allocates only to grow: the "visited" marks of
//! a query, which may not mark the shared mesh.

/// Open addressing, linear probing, at most half full. An entry is `stamp << 32 | number`; it
/// counts only if its stamp is the current one.
#[derive(Clone, Debug)]
pub(crate) struct Marks {
    table: Vec<u64>,
    stamp: u32,
    len: usize,
}

/// Initial number of entries: a power of two.
const FIRST: usize = 256;

impl Default for Marks {
    fn default() -> Self {
        Self { table: vec![0; FIRST], stamp: 1, len: 0 }
    }
}

impl Marks {
    /// Removes all numbers.
    pub(crate) fn clear(&mut self) {
        self.len = 0;
        if self.stamp == u32::MAX {
            self.table.fill(0);
            self.stamp = 0;
        }
        self.stamp += 1;
    }

    /// The place of `number`, or the free place for it. Ends: half of the table is empty.
    #[inline(always)]
    fn place(&self, number: u32) -> (usize, bool) {
        let mask = self.table.len() - 1;
        let mut at = (number.wrapping_mul(0x9e37_79b9) >> 7) as usize & mask;
        loop {
            let entry = self.table[at];
            if (entry >> 32) as u32 != self.stamp {
                return (at, false);
            }
            if entry as u32 == number {
                return (at, true);
            }
            at = (at + 1) & mask;
        }
    }

    /// Is `number` in the set?
    #[inline]
    pub(crate) fn contains(&self, number: impl Into<u32>) -> bool {
        self.place(number.into()).1
    }

    /// Adds `number`; was it new?
    #[inline]
    pub(crate) fn insert(&mut self, number: impl Into<u32>) -> bool {
        let number = number.into();
        let (at, found) = self.place(number);
        if found {
            return false;
        }
        self.table[at] = u64::from(self.stamp) << 32 | u64::from(number);
        self.len += 1;
        if 2 * self.len > self.table.len() {
            self.grow();
        }
        true
    }

    #[cold]
    fn grow(&mut self) {
        let size = 2 * self.table.len();
        let old = std::mem::replace(&mut self.table, vec![0; size]);
        for entry in old {
            if (entry >> 32) as u32 == self.stamp {
                let (at, _) = self.place(entry as u32);
                self.table[at] = entry;
            }
        }
    }

    /// Bytes of memory held.
    pub(crate) fn memory_bytes(&self) -> usize {
        self.table.capacity() * size_of::<u64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_a_tree_set_through_growth_and_clearing() {
        let mut marks = Marks::default();
        let mut s = 1u32;
        for round in 0..50u32 {
            if round == 30 {
                marks.stamp = u32::MAX; // the stamps run out
            }
            marks.clear();
            let mut twin = std::collections::BTreeSet::new();
            for _ in 0..40 * round {
                s = s.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let number = (s >> 8) % 1500;
                assert_eq!(marks.contains(number), twin.contains(&number));
                assert_eq!(marks.insert(number), twin.insert(number));
            }
        }
    }
}
