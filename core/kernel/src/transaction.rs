//! The guard of an open cavity: nobody pairs its opening and its end by hand.
//!
//! Between `Cavity::expand` and the filling the tetrahedra of a cavity are marked. An owner of
//! such a cavity, be it a mesh or a part of one, hands it out as an [`OpenCavity`], which is filled
//! or dropped. Dropping it is the *setback*: all is as before, bit for bit.

use crate::cavity::Cavity;
use crate::topology::{TetId, VertexId};

/// An owner of a cavity that can be open.
pub trait Opens {
    /// The cavity, open or not.
    fn cavity(&self) -> &Cavity;

    /// Gives the open cavity up: the mesh is as before, bit for bit.
    fn set_back(&mut self);
}

/// The open cavity of `owner`: to be filled, or dropped, which sets it back.
#[must_use]
pub struct OpenCavity<'a, O: Opens> {
    owner: &'a mut O,
    is_open: bool,
}

impl<'a, O: Opens> OpenCavity<'a, O> {
    /// The cavity that `owner` has just found, or that passes between it and a part of its own.
    #[inline(always)]
    pub fn new(owner: &'a mut O) -> Self {
        Self { owner, is_open: true }
    }

    /// The tetrahedra of the cavity.
    #[inline(always)]
    pub fn tets(&self) -> impl Iterator<Item = TetId> + '_ {
        self.owner.cavity().tets()
    }

    /// The vertices of the cavity's boundary faces; the point in front of them makes a positively
    /// oriented tetrahedron.
    #[inline(always)]
    pub fn faces(&self) -> impl Iterator<Item = [VertexId; 3]> + '_ {
        self.owner.cavity().faces()
    }

    /// The owner, to look at.
    #[inline(always)]
    pub fn owner(&self) -> &O {
        self.owner
    }

    /// The owner, to plan the filling with.
    #[inline(always)]
    pub fn owner_mut(&mut self) -> &mut O {
        self.owner
    }

    /// Ends the transaction by `fill`, which fills the cavity.
    #[inline(always)]
    pub fn end<R>(mut self, fill: impl FnOnce(&mut O) -> R) -> R {
        self.is_open = false;
        fill(self.owner)
    }
}

impl<O: Opens> Drop for OpenCavity<'_, O> {
    #[inline(always)]
    fn drop(&mut self) {
        if self.is_open {
            self.owner.set_back();
        }
    }
}
