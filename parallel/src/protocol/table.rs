//! A map of few entries: a sorted vector. Of equal contents there is one form, so that models can
//! compare states.

use smallvec::SmallVec;

/// A map from `K` to `V`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Table<K, V>(SmallVec<[(K, V); 2]>);

impl<K, V> Default for Table<K, V> {
    fn default() -> Self {
        Self(SmallVec::new())
    }
}

impl<K: Ord + Copy, V> Table<K, V> {
    /// Reserves room for this number of entries. A hint.
    pub(crate) fn reserve(&mut self, entries: usize) {
        self.0.reserve(entries);
    }

    fn place(&self, key: K) -> Result<usize, usize> {
        self.0.binary_search_by(|(k, _)| k.cmp(&key))
    }

    pub(crate) fn get(&self, key: K) -> Option<&V> {
        self.place(key).ok().map(|place| &self.0[place].1)
    }

    pub(crate) fn get_mut(&mut self, key: K) -> Option<&mut V> {
        let place = self.place(key).ok()?;
        Some(&mut self.0[place].1)
    }

    /// The value of `key`; `value()` is put there if there is none.
    pub(crate) fn entry(&mut self, key: K, value: impl FnOnce() -> V) -> &mut V {
        let place = self.place(key).unwrap_or_else(|place| {
            self.0.insert(place, (key, value()));
            place
        });
        &mut self.0[place].1
    }

    /// Puts a value there if there is none: was there none?
    pub(crate) fn insert_new(&mut self, key: K, value: impl FnOnce() -> V) -> bool {
        let place = self.place(key);
        if let Err(place) = place {
            self.0.insert(place, (key, value()));
        }
        place.is_err()
    }

    pub(crate) fn values(&self) -> impl Iterator<Item = &V> {
        self.0.iter().map(|(_, value)| value)
    }

    pub(crate) fn keys(&self) -> impl Iterator<Item = K> + '_ {
        self.0.iter().map(|&(key, _)| key)
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    pub(crate) fn entries(&self) -> &[(K, V)] {
        &self.0
    }

    pub(crate) fn into_entries(self) -> impl Iterator<Item = (K, V)> {
        self.0.into_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn a_table_is_a_sorted_map() {
        let (mut table, mut map) = (Table::default(), BTreeMap::new());
        for k in [5, 1, 9, 5, 3, 1, 7] {
            assert_eq!(table.insert_new(k, || 10 * k), !map.contains_key(&k));
            map.entry(k).or_insert(10 * k);
            *table.entry(k + 1, || 0) += 1;
            *map.entry(k + 1).or_insert(0) += 1;
        }
        assert!(table.get(2).is_some() && table.get(11).is_none());
        *table.get_mut(2).expect("an entry") += 7;
        *map.get_mut(&2).expect("an entry") += 7;
        assert!(table.keys().eq(map.keys().copied()) && table.values().eq(map.values()));
        assert_eq!(table.len(), map.len());
        assert!(table.into_entries().eq(map));
    }
}
