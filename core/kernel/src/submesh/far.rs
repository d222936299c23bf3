//! The far sides of the interface faces of a submesh: a table beside the tetrahedra.
//!
//! Topology knows of an interface face only that a *far face* stands behind it. What the far face
//! stands for, a tetrahedron of another submesh, means something to the caller alone: its *far
//! handle* lies here, and the far face is tagged with its place.

use crate::sphere::{Sphere, TagKind};

/// Far handles by place.
#[derive(Debug)]
pub(super) struct FarTable<F> {
    handles: Vec<F>,
    free: Vec<u32>,
}

/// The tag by which geometry sees far faces.
const KIND: TagKind = TagKind::Second;

impl<F: Copy> FarTable<F> {
    pub(super) fn new() -> Self {
        Self { handles: Vec::new(), free: Vec::new() }
    }

    /// The far handle of a far face by what it has in place of a sphere; `None` of other slots.
    #[inline]
    pub(super) fn get(&self, sphere: Sphere) -> Option<F> {
        self.handles.get(sphere.number(KIND)? as usize).copied()
    }

    /// Keeps the far handle of a new far face. The result stands in place of the face's sphere.
    pub(super) fn add(&mut self, handle: F) -> Sphere {
        let place = match self.free.pop() {
            Some(place) => {
                self.handles[place as usize] = handle;
                place
            }
            None => {
                self.handles.push(handle);
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
        self.free.extend(sphere.number(KIND));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_used_again() {
        let mut table = FarTable::new();
        let [a, b] = ['a', 'b'].map(|handle| table.add(handle));
        assert_eq!((table.get(a), table.get(b)), (Some('a'), Some('b')));
        assert_eq!(table.get(Sphere::UNKNOWN), None);
        assert_eq!(table.get(Sphere::tagged(TagKind::First, 0)), None, "a tag of another table");
        table.replace(a, 'c');
        table.remove(b);
        let d = table.add('d');
        assert_eq!(table.get(d), Some('d'));
        assert_eq!((table.get(a), table.handles.len()), (Some('c'), 2));
    }
}
