//! The few tetrahedra of a part that are closed or watched: a table beside the tetrahedra.
//!
//! Most tetrahedra are neither, so that the state of the others lies apart, found by an index of
//! four bytes a tetrahedron. Only those pages of the index are ever touched that have one.

use crate::sphere::Sphere;
use crate::topology::TetId;

/// What is known of a closed or watched tetrahedron.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Special<H, L> {
    tet: TetId,
    /// The sphere that it had when it was closed.
    pub(crate) sphere: Sphere,
    /// Who has closed it, and whether as part of its cavity.
    pub(crate) closed: Option<(H, bool)>,
    /// The label under which it is watched.
    pub(crate) label: Option<L>,
}

/// All of them.
#[derive(Debug)]
pub(crate) struct Specials<H, L> {
    /// By tetrahedron: 1 + its place in `entries`, or 0.
    index: Vec<u32>,
    /// Those with neither holder nor label are free.
    entries: Vec<Special<H, L>>,
    free: Vec<u32>,
}

impl<H: Copy, L: Copy> Specials<H, L> {
    pub(crate) fn new() -> Self {
        Self { index: Vec::new(), entries: Vec::new(), free: Vec::new() }
    }

    /// Room for tetrahedra `0..tets`; untouched memory until they are special.
    pub(crate) fn reserve(&mut self, tets: usize) {
        if self.entries.is_empty() {
            self.index = vec![0; tets];
        }
    }

    #[inline]
    pub(crate) fn get(&self, t: TetId) -> Option<&Special<H, L>> {
        let place = *self.index.get(t as usize)?;
        self.entries.get((place as usize).wrapping_sub(1))
    }

    #[inline]
    pub(crate) fn get_mut(&mut self, t: TetId) -> Option<&mut Special<H, L>> {
        let place = *self.index.get(t as usize)?;
        self.entries.get_mut((place as usize).wrapping_sub(1))
    }

    /// Is `t` closed?
    #[inline]
    pub(crate) fn is_closed(&self, t: TetId) -> bool {
        self.get(t).is_some_and(|s| s.closed.is_some())
    }

    /// Is `t` watched?
    #[inline]
    pub(crate) fn is_watched(&self, t: TetId) -> bool {
        self.get(t).is_some_and(|s| s.label.is_some())
    }

    /// The entry of `t`, a new one if it has none.
    pub(crate) fn entry(&mut self, t: TetId) -> &mut Special<H, L> {
        let slot = t as usize;
        if slot >= self.index.len() {
            self.index.resize((slot + 1).max(2 * self.index.len()), 0);
        }
        if self.index[slot] == 0 {
            let new = Special { tet: t, sphere: Sphere::UNKNOWN, closed: None, label: None };
            let place = match self.free.pop() {
                Some(place) => {
                    self.entries[place as usize] = new;
                    place
                }
                None => {
                    self.entries.push(new);
                    (self.entries.len() - 1) as u32
                }
            };
            self.index[slot] = place + 1;
        }
        &mut self.entries[self.index[slot] as usize - 1]
    }

    /// Frees the entry of `t` if there is nothing to know any more.
    fn tidy(&mut self, t: TetId) {
        if self.get(t).is_some_and(|s| s.closed.is_none() && s.label.is_none()) {
            self.free.push(self.index[t as usize] - 1);
            self.index[t as usize] = 0;
        }
    }

    /// Takes the holder of `t` away; returns the sphere that it had.
    pub(crate) fn open(&mut self, t: TetId) -> Option<Sphere> {
        let special = self.get_mut(t)?;
        special.closed.take()?;
        let sphere = special.sphere;
        self.tidy(t);
        Some(sphere)
    }

    /// Takes the label of `t` away.
    pub(crate) fn unwatch(&mut self, t: TetId) -> Option<L> {
        let label = self.get_mut(t)?.label.take();
        self.tidy(t);
        label
    }

    /// The closed ones.
    pub(crate) fn closed(&self) -> impl Iterator<Item = TetId> + '_ {
        self.entries.iter().filter(|s| s.closed.is_some()).map(|s| s.tet)
    }

    /// The watched ones, with their labels.
    pub(crate) fn watched(&self) -> impl Iterator<Item = (TetId, L)> + '_ {
        self.entries.iter().filter_map(|s| Some((s.tet, s.label?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_lives_as_long_as_there_is_something_to_know() {
        let mut specials: Specials<char, u32> = Specials::new();
        assert!(specials.get(7).is_none() && specials.open(7).is_none());
        specials.entry(7).label = Some(70);
        specials.entry(7).closed = Some(('a', true));
        specials.entry(3).closed = Some(('b', false));
        assert_eq!(specials.closed().collect::<Vec<_>>(), [7, 3]);
        assert_eq!(specials.watched().collect::<Vec<_>>(), [(7, 70)]);
        assert!(specials.open(7).is_some() && specials.open(7).is_none());
        assert!(!specials.is_closed(7) && specials.is_watched(7) && specials.is_closed(3));
        assert_eq!(specials.unwatch(7), Some(70));
        assert!(specials.get(7).is_none() && specials.unwatch(7).is_none());
        // Its place is taken again.
        specials.entry(1000).label = Some(1);
        assert_eq!(specials.entries.len(), 2);
        assert!(specials.is_watched(1000) && specials.is_closed(3));
        specials.reserve(10);
        assert!(specials.is_watched(1000), "reserving forgets nothing");
    }
}
