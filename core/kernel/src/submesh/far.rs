//! The far sides of the interface faces of a submesh: a table beside the tetrahedra.
//!
//! Topology knows of an interface face only that a *far face* stands behind it. What the far face
//! stands for, a tetrahedron of another submesh, means something to the caller alone: its *far
//! handle* lies here, and the far face is tagged with its place.

use crate::sphere::{Sphere, TagKind};
use crate::topology::TetId;

/// Far handles by place.
#[derive(Debug)]
pub(super) struct FarTable<F> {
    handles: Vec<F>,
    /// The far face of each; no slot, if the place is free.
    slots: Vec<TetId>,
    free: Vec<u32>,
}

/// In place of a slot: none.
const NO_SLOT: TetId = TetId::new(u32::MAX);

/// The tag by which geometry sees far faces.
const KIND: TagKind = TagKind::Second;

impl<F: Copy> FarTable<F> {
    pub(super) fn new() -> Self {
        Self { handles: Vec::new(), slots: Vec::new(), free: Vec::new() }
    }

    /// The far handle of a far face by what it has in place of a sphere; `None` of other slots.
    #[inline]
    pub(super) fn get(&self, sphere: Sphere) -> Option<F> {
        self.handles.get(sphere.number(KIND)? as usize).copied()
    }

    /// All far faces, with their far handles.
    pub(super) fn all(&self) -> impl Iterator<Item = (TetId, F)> + '_ {
        let all = self.slots.iter().copied().zip(self.handles.iter().copied());
        all.filter(|&(t, _)| t != NO_SLOT)
    }

    /// Keeps the far handle of new far face `t`. The result stands in place of the face's sphere.
    pub(super) fn add(&mut self, t: TetId, handle: F) -> Sphere {
        let place = match self.free.pop() {
            Some(place) => {
                self.handles[place as usize] = handle;
                self.slots[place as usize] = t;
                place
            }
            None => {
                self.handles.push(handle);
                self.slots.push(t);
                (self.handles.len() - 1) as u32
            }
        };
        Sphere::tagged(KIND, place)
    }

    /// Replaces the far handle of a far face.
    pub(super) fn replace(&mut self, sphere: Sphere, handle: F) {
        let place = sphere.number(KIND).and_then(|place| self.handles.get_mut(place as usize));
        if let Some(place) = place {
            *place = handle;
        }
    }

    /// Forgets the far handle of a far face that goes.
    pub(super) fn remove(&mut self, sphere: Sphere) {
        if let Some(place) = sphere.number(KIND) {
            self.slots[place as usize] = NO_SLOT;
            self.free.push(place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_used_again() {
        let mut table = FarTable::new();
        let slots = [3, 5, 7].map(TetId::new);
        let [a, b] = [(slots[0], 'a'), (slots[1], 'b')].map(|(t, handle)| table.add(t, handle));
        assert_eq!((table.get(a), table.get(b)), (Some('a'), Some('b')));
        assert_eq!(table.get(Sphere::UNKNOWN), None);
        assert_eq!(table.get(Sphere::tagged(TagKind::First, 0)), None, "a tag of another table");
        table.replace(a, 'c');
        table.remove(b);
        assert_eq!(table.all().collect::<Vec<_>>(), [(slots[0], 'c')]);
        let d = table.add(slots[2], 'd');
        assert_eq!(table.all().collect::<Vec<_>>(), [(slots[0], 'c'), (slots[2], 'd')]);
        assert_eq!(table.get(d), Some('d'));
        assert_eq!((table.get(a), table.handles.len()), (Some('c'), 2));
    }
}
