//! The few tetrahedra of a submesh that are locked or tagged: a table beside the tetrahedra.
//!
//! Most tetrahedra are neither, so that the state of the others lies apart. A tetrahedron that has
//! an entry has its number in place of its sphere: whoever looks at a tetrahedron has read that
//! anyway.

use crate::sphere::{Sphere, TagKind};
use crate::topology::TetId;

/// The tag by which geometry sees tetrahedra that have an entry.
const KIND: TagKind = TagKind::First;

/// The state of a locked or tagged tetrahedron.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry<H, T> {
    tet: TetId,
    /// The sphere that it has when it is neither any more.
    pub(crate) sphere: Sphere,
    /// Its holder, and whether as part of its cavity.
    pub(crate) lock: Option<(H, bool)>,
    /// The caller's tag.
    pub(crate) tag: Option<T>,
}

/// All of them. A tetrahedron's entry is found by what it has in place of a sphere.
#[derive(Debug)]
pub(crate) struct LockTable<H, T> {
    /// The entries; one with neither holder nor tag is free.
    entries: Vec<Entry<H, T>>,
    free: Vec<u32>,
}

impl<H: Copy, T: Copy> LockTable<H, T> {
    pub(crate) fn new() -> Self {
        Self { entries: Vec::new(), free: Vec::new() }
    }

    #[inline]
    pub(crate) fn get(&self, sphere: Sphere) -> Option<&Entry<H, T>> {
        self.entries.get(sphere.number(KIND)? as usize)
    }

    #[inline]
    pub(crate) fn get_mut(&mut self, sphere: Sphere) -> Option<&mut Entry<H, T>> {
        self.entries.get_mut(sphere.number(KIND)? as usize)
    }

    /// Is it locked?
    #[inline]
    pub(crate) fn is_locked(&self, sphere: Sphere) -> bool {
        self.get(sphere).is_some_and(|s| s.lock.is_some())
    }

    /// Is it tagged?
    #[inline]
    pub(crate) fn is_tagged(&self, sphere: Sphere) -> bool {
        self.get(sphere).is_some_and(|s| s.tag.is_some())
    }

    /// The entry of tetrahedron `t`, whose sphere is `sphere`: a new one if it has none yet. The
    /// sphere is then replaced by the entry's tag.
    #[inline]
    pub(crate) fn entry(&mut self, t: TetId, sphere: &mut Sphere) -> &mut Entry<H, T> {
        let place = sphere.number(KIND).unwrap_or_else(|| {
            let new = Entry { tet: t, sphere: *sphere, lock: None, tag: None };
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
            *sphere = Sphere::tagged(KIND, place);
            place
        });
        &mut self.entries[place as usize]
    }

    /// Takes the holder away. A tag for which no reason is left is replaced by the sphere.
    #[inline]
    pub(crate) fn unlock(&mut self, sphere: &mut Sphere) {
        let Some(place) = sphere.number(KIND) else { return };
        let entry = &mut self.entries[place as usize];
        entry.lock = None;
        if entry.tag.is_none() {
            // There is nothing to know any more.
            *sphere = entry.sphere;
            self.free.push(place);
        }
    }

    /// Takes the tag away, and restores the sphere likewise.
    #[inline]
    pub(crate) fn untag(&mut self, sphere: &mut Sphere) -> Option<T> {
        let place = sphere.number(KIND)?;
        let entry = &mut self.entries[place as usize];
        let tag = entry.tag.take();
        if entry.lock.is_none() {
            *sphere = entry.sphere;
            self.free.push(place);
        }
        tag
    }

    /// The tetrahedra that have an entry, with their spheres.
    pub(crate) fn spheres(&self) -> impl Iterator<Item = (TetId, Sphere)> + '_ {
        let used = |s: &&Entry<H, T>| s.lock.is_some() || s.tag.is_some();
        self.entries.iter().filter(used).map(|s| (s.tet, s.sphere))
    }

    /// The locked ones.
    pub(crate) fn locked(&self) -> impl Iterator<Item = TetId> + '_ {
        self.entries.iter().filter(|s| s.lock.is_some()).map(|s| s.tet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_lives_as_long_as_there_is_something_to_know() {
        let mut locks: LockTable<char, u32> = LockTable::new();
        // Of three tetrahedra.
        let [mut a, mut b, mut c] = [1.0, 2.0, 3.0].map(|x| Sphere([x, 0.0, 0.0, 4.0]));
        locks.unlock(&mut a);
        assert!(locks.get(a).is_none() && a.0[0] == 1.0);
        locks.entry(TetId::new(7), &mut a).tag = Some(70);
        locks.entry(TetId::new(7), &mut a).lock = Some(('a', true));
        locks.entry(TetId::new(3), &mut b).lock = Some(('b', false));
        assert!(a.0[3].is_nan() && b.0[3].is_nan());
        assert_eq!(locks.locked().collect::<Vec<_>>(), [7, 3].map(TetId::new));
        locks.unlock(&mut a);
        assert!(!locks.is_locked(a) && locks.is_tagged(a) && locks.is_locked(b));
        assert_eq!(locks.untag(&mut a), Some(70));
        assert_eq!(a.0, [1.0, 0.0, 0.0, 4.0], "the sphere is back");
        assert!(locks.get(a).is_none() && locks.untag(&mut a).is_none());
        // Its place is taken again.
        locks.entry(TetId::new(1000), &mut c).tag = Some(1);
        assert_eq!(locks.entries.len(), 2);
        assert!(locks.is_tagged(c) && locks.is_locked(b));
    }
}
