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
    /// The places at which something has changed, if anybody wants to know.
    changed: Option<Vec<u32>>,
}

/// In place of a slot: none.
const NO_SLOT: TetId = TetId::new(u32::MAX);

/// The tag by which geometry sees far faces.
const KIND: TagKind = TagKind::Second;

impl<F: Copy> FarTable<F> {
    pub(super) fn new() -> Self {
        Self { handles: Vec::new(), slots: Vec::new(), free: Vec::new(), changed: None }
    }

    /// The far handle of a far face by what it has in place of a sphere; `None` of other slots.
    #[inline]
    pub(super) fn get(&self, sphere: Sphere) -> Option<F> {
        self.handles.get(sphere.number(KIND)? as usize).copied()
    }

    /// The far face at a place, with its far handle; `None` if the place is free.
    pub(super) fn at(&self, place: u32) -> Option<(TetId, F)> {
        let t = *self.slots.get(place as usize)?;
        (t != NO_SLOT).then(|| (t, self.handles[place as usize]))
    }

    /// The place of a far face by what it has in place of a sphere; `None` of other slots.
    #[inline]
    pub(super) fn place(sphere: Sphere) -> Option<u32> {
        sphere.number(KIND)
    }

    /// Notes from now on where something changes; all places that are taken count as changed.
    pub(super) fn watch(&mut self) {
        let all = 0..self.slots.len() as u32;
        self.changed = Some(all.filter(|&place| self.at(place).is_some()).collect());
    }

    /// Moves the places at which something has changed to the end of a list, those of many changes
    /// as often.
    pub(super) fn take_changed(&mut self, list: &mut Vec<u32>) {
        self.changed.iter_mut().for_each(|changed| list.append(changed));
    }

    fn note(&mut self, place: u32) {
        if let Some(changed) = &mut self.changed {
            changed.push(place);
        }
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
        self.note(place);
        Sphere::tagged(KIND, place)
    }

    /// Replaces the far handle of a far face.
    pub(super) fn replace(&mut self, sphere: Sphere, handle: F) {
        if let Some(place) = sphere.number(KIND) {
            self.handles[place as usize] = handle;
            self.note(place);
        }
    }

    /// Forgets the far handle of a far face that goes.
    pub(super) fn remove(&mut self, sphere: Sphere) {
        if let Some(place) = sphere.number(KIND) {
            self.slots[place as usize] = NO_SLOT;
            self.free.push(place);
            self.note(place);
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
        let all = |table: &FarTable<char>| [0, 1].map(|place| table.at(place));
        assert_eq!(all(&table), [Some((slots[0], 'c')), None]);
        let d = table.add(slots[2], 'd');
        assert_eq!(all(&table), [Some((slots[0], 'c')), Some((slots[2], 'd'))]);
        assert_eq!(table.at(2), None);
        assert_eq!(table.get(d), Some('d'));
        assert_eq!((table.get(a), table.handles.len()), (Some('c'), 2));
        assert_eq!(FarTable::<char>::place(d), Some(1));
    }

    #[test]
    fn changes_are_noted_from_the_watch_on() {
        let mut table = FarTable::new();
        let taken = |table: &mut FarTable<char>| {
            let mut list = Vec::new();
            table.take_changed(&mut list);
            list
        };
        let [a, b] = [3, 5].map(|t| table.add(TetId::new(t), 'x'));
        table.remove(a);
        assert!(taken(&mut table).is_empty());
        table.watch();
        assert_eq!(taken(&mut table), [1]);
        table.replace(b, 'y');
        table.add(TetId::new(7), 'z');
        table.remove(b);
        assert_eq!(taken(&mut table), [1, 0, 1]);
        assert!(taken(&mut table).is_empty());
    }
}
