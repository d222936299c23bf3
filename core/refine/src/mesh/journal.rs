//! The changes of a joint step, so that it can be taken back.

use super::item::Item;
use super::limit::Limit;
use super::marks::Word;
use crate::complex::carrier::Carrier;
use ltbw_core::topology::{TetId, VertexId};
use ltbw_core::undo::Undo;
use ltbw_exact::Point;

/// The limit that an item had before another one was set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LimitBefore {
    pub(crate) item: Item,
    pub(crate) limit: Option<Limit>,
}

/// The changes of a joint step so far.
#[derive(Debug, Default)]
pub(crate) struct Journal {
    /// The edges that may be made near small angles.
    pub(crate) limit: Option<Limit>,
    /// Are subfaces split opposite to its points?
    pub(crate) is_opposite: bool,
    /// Limits that were set, each as it was before.
    pub(crate) limits: Vec<LimitBefore>,
    /// The points inserted, and where they live.
    pub(crate) points: Vec<(Point, Carrier)>,
    /// The insertions, each with the marks of its cavity.
    pub(crate) insertions: Vec<(Undo, Vec<Word>)>,
    /// Entries of the tables, each as it was before.
    pub(crate) segments: Vec<([VertexId; 2], Option<u32>)>,
    pub(crate) subfaces: Vec<([VertexId; 3], Option<u32>)>,
    /// Items entered into the encroachment index.
    pub(crate) entered: Vec<Item>,
    /// New tetrahedra, whose bounds are looked at when the step is done.
    pub(crate) created: Vec<(TetId, [VertexId; 4])>,
}
