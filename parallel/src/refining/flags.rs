//! A bit for each slot or vertex: few enough bytes to stay in the cache.

/// Flags by place. Those that were never set are not.
#[derive(Clone, Debug, Default)]
pub(super) struct Flags {
    words: Vec<u64>,
}

impl Flags {
    pub(super) fn has(&self, place: usize) -> bool {
        let word = self.words.get(place / 64).copied().unwrap_or_default();
        word >> (place % 64) & 1 == 1
    }

    pub(super) fn set(&mut self, place: usize, is: bool) {
        if self.words.len() <= place / 64 {
            self.words.resize(place / 64 + 1, 0);
        }
        let (word, bit) = (&mut self.words[place / 64], 1 << (place % 64));
        *word = if is { *word | bit } else { *word & !bit };
    }

    /// The flags of two together.
    pub(super) fn join(mut self, mut other: Self) -> Self {
        if self.words.len() < other.words.len() {
            std::mem::swap(&mut self, &mut other);
        }
        self.words.iter_mut().zip(other.words).for_each(|(own, other)| *own |= other);
        self
    }

    /// Unsets all.
    pub(super) fn clear(&mut self) {
        self.words.fill(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_those_that_were_set_last() {
        let mut own = Flags::default();
        own.set(3, true);
        own.set(130, true);
        own.set(3, false);
        assert_eq!(
            [0, 3, 129, 130, 131, 900].map(|k| own.has(k)),
            [false, false, false, true, false, false]
        );
        own.set(64, true);
        let mut other = Flags::default();
        other.set(1, true);
        let both = other.join(own.clone());
        assert_eq!([1, 2, 64, 130].map(|k| both.has(k)), [true, false, true, true]);
        own.clear();
        assert_eq!([64, 130].map(|k| own.has(k)), [false; 2]);
    }
}
