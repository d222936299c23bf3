//! The boundary items that wait for each other, as far as one worker knows.

use super::values::ItemKey;
use rustc_hash::FxHashMap;

/// The item that a boundary item waits for.
#[derive(Clone, Copy, Debug)]
struct Wait {
    first: ItemKey,
    /// The item is in the list of another worker, which has asked for the first.
    is_far: bool,
}

/// The items that boundary items wait for: those of a worker's list, and those of others for which
/// its items were asked.
#[derive(Debug, Default)]
pub(super) struct Waits(FxHashMap<ItemKey, Wait>);

impl Waits {
    /// An item of this worker's list waits for another one.
    pub(super) fn set(&mut self, item: ItemKey, first: ItemKey) {
        self.0.insert(item, Wait { first, is_far: false });
    }

    /// Another worker's item waits for one of this worker's list.
    pub(super) fn set_far(&mut self, item: ItemKey, first: ItemKey) {
        self.0.insert(item, Wait { first, is_far: true });
    }

    /// An item is done: it waits for nothing.
    pub(super) fn end(&mut self, item: &ItemKey) {
        self.0.remove(item);
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Does what an item waits for wait for the item, or for something that does? What others have
    /// told is used up by that: it may be different by now, and they tell it again if it is not.
    pub(super) fn is_circle(&mut self, item: &ItemKey) -> bool {
        let mut far = Vec::new();
        let mut next = *item;
        for _ in 0..self.0.len() {
            let Some(wait) = self.0.get(&next) else { return false };
            far.extend(wait.is_far.then_some(next));
            next = wait.first;
            if next == *item {
                far.iter().for_each(|own| self.end(own));
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_is_seen_once_for_each_time_that_others_tell_of_their_part() {
        let [a, b, c, d] = [1, 2, 3, 4].map(|k| [0, k, 9]);
        let mut waits = Waits::default();
        waits.set(d, a);
        waits.set(a, b);
        waits.set(b, c);
        assert!(!waits.is_circle(&a), "nobody has told of c");
        for _ in 0..2 {
            waits.set_far(c, a);
            assert!(!waits.is_circle(&d), "it waits for a circle");
            assert!(waits.is_circle(&b) && !waits.is_circle(&b));
        }
        waits.set_far(c, a);
        waits.end(&b);
        assert!(!waits.is_circle(&a), "b is done");
    }
}
