//! The few tetrahedra of a part that are closed or watched: a table beside the tetrahedra.
//!
//! Most tetrahedra are neither, so that the state of the others lies apart. A tetrahedron that has
//! an entry has its number in place of its sphere: whoever looks at a tetrahedron has read that
//! anyway.

use crate::sphere::{Sphere, Tag};
use crate::topology::TetId;

/// The tag of tetrahedra that have an entry.
const TAG: Tag = Tag::First;

/// The state of a closed or watched tetrahedron.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Special<H, L> {
    tet: TetId,
    /// The sphere that it has when it is neither any more.
    pub(crate) sphere: Sphere,
    /// Its holder, if it is closed, and whether it is in the holder's cavity.
    pub(crate) closed: Option<(H, bool)>,
    /// The label under which it is watched.
    pub(crate) label: Option<L>,
}

/// All of them. A tetrahedron's entry is found by what it has in place of a sphere.
#[derive(Debug)]
pub(crate) struct Specials<H, L> {
    /// The entries; one with neither holder nor label is free.
    entries: Vec<Special<H, L>>,
    free: Vec<u32>,
}

impl<H: Copy, L: Copy> Specials<H, L> {
    pub(crate) fn new() -> Self {
        Self { entries: Vec::new(), free: Vec::new() }
    }

    #[inline]
    pub(crate) fn get(&self, sphere: Sphere) -> Option<&Special<H, L>> {
        self.entries.get(sphere.number(TAG)? as usize)
    }

    #[inline]
    pub(crate) fn get_mut(&mut self, sphere: Sphere) -> Option<&mut Special<H, L>> {
        self.entries.get_mut(sphere.number(TAG)? as usize)
    }

    /// Is it closed?
    #[inline]
    pub(crate) fn is_closed(&self, sphere: Sphere) -> bool {
        self.get(sphere).is_some_and(|s| s.closed.is_some())
    }

    /// Is it watched?
    #[inline]
    pub(crate) fn is_watched(&self, sphere: Sphere) -> bool {
        self.get(sphere).is_some_and(|s| s.label.is_some())
    }

    /// The entry of tetrahedron `t` that has `sphere`; a new one if that is none yet. `sphere` is
    /// then what the tetrahedron is to have in its place.
    #[inline]
    pub(crate) fn entry(&mut self, t: TetId, sphere: &mut Sphere) -> &mut Special<H, L> {
        let place = sphere.number(TAG).unwrap_or_else(|| {
            let new = Special { tet: t, sphere: *sphere, closed: None, label: None };
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
            *sphere = Sphere::tagged(TAG, place);
            place
        });
        &mut self.entries[place as usize]
    }

    /// Frees the entry if there is nothing to know any more; `sphere` is then the sphere.
    #[inline]
    fn tidy(&mut self, sphere: &mut Sphere) {
        if let Some(place) = sphere.number(TAG) {
            let special = &self.entries[place as usize];
            if special.closed.is_none() && special.label.is_none() {
                *sphere = special.sphere;
                self.free.push(place);
            }
        }
    }

    /// Takes the holder away; `sphere` is then what the tetrahedron is to have.
    #[inline]
    pub(crate) fn open(&mut self, sphere: &mut Sphere) {
        if let Some(special) = self.get_mut(*sphere) {
            special.closed = None;
            self.tidy(sphere);
        }
    }

    /// Takes the label away; `sphere` is then what the tetrahedron is to have.
    #[inline]
    pub(crate) fn unwatch(&mut self, sphere: &mut Sphere) -> Option<L> {
        let label = self.get_mut(*sphere)?.label.take();
        self.tidy(sphere);
        label
    }

    /// The tetrahedra that have an entry, with their spheres.
    pub(crate) fn spheres(&self) -> impl Iterator<Item = (TetId, Sphere)> + '_ {
        let used = |s: &&Special<H, L>| s.closed.is_some() || s.label.is_some();
        self.entries.iter().filter(used).map(|s| (s.tet, s.sphere))
    }

    /// The closed ones.
    pub(crate) fn closed(&self) -> impl Iterator<Item = TetId> + '_ {
        self.entries.iter().filter(|s| s.closed.is_some()).map(|s| s.tet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_lives_as_long_as_there_is_something_to_know() {
        let mut specials: Specials<char, u32> = Specials::new();
        // Of three tetrahedra.
        let [mut a, mut b, mut c] = [1.0, 2.0, 3.0].map(|x| Sphere([x, 0.0, 0.0, 4.0]));
        specials.open(&mut a);
        assert!(specials.get(a).is_none() && a.0[0] == 1.0);
        specials.entry(7, &mut a).label = Some(70);
        specials.entry(7, &mut a).closed = Some(('a', true));
        specials.entry(3, &mut b).closed = Some(('b', false));
        assert!(a.0[3].is_nan() && b.0[3].is_nan());
        assert_eq!(specials.closed().collect::<Vec<_>>(), [7, 3]);
        specials.open(&mut a);
        assert!(!specials.is_closed(a) && specials.is_watched(a) && specials.is_closed(b));
        assert_eq!(specials.unwatch(&mut a), Some(70));
        assert_eq!(a.0, [1.0, 0.0, 0.0, 4.0], "the sphere is back");
        assert!(specials.get(a).is_none() && specials.unwatch(&mut a).is_none());
        // Its place is taken again.
        specials.entry(1000, &mut c).label = Some(1);
        assert_eq!(specials.entries.len(), 2);
        assert!(specials.is_watched(c) && specials.is_closed(b));
    }
}
