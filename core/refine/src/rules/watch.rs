//! Joint kills: the tetrahedra at which candidates before a point make it wait, so that two points
//! of a round, each of which takes nothing out of the mesh, do not do so together (rules (b), (c)
//! and (d) of `docs/rounds.md`).

use super::bounded::Bounded;
use super::choice::Rival;
use crate::complex::carrier::Carrier;
use crate::complex::measure::in_equatorial_ball;
use crate::mesh::item::Item;
use crate::mesh::marks::{ENDS, edge_bit};
use crate::mesh::survey::{Face, Survey};
use crate::table::edge;
use ltbw_core::topology::INFINITE;

impl<T: Copy + Ord> Survey<T> {
    /// The watch of a point inside; none if no part of its cavity is marked.
    pub(crate) fn watch_in_tet<B: Bounded<Tet = T>>(&self, closure: &B) -> Option<Watch<T>> {
        if self.is_bare() {
            return None;
        }
        let mut watch = Watch { any: Vec::new(), own: Vec::new(), anywhere: Anywhere::Boundary };
        self.watch_faces(closure, Carrier::Free, &mut watch.any);
        self.watch_edges(closure, None, &mut watch.any);
        Some(watch)
    }

    /// The watch of a point of the boundary on `carrier` that splits an item.
    pub(crate) fn watch_at_item<B: Bounded<Tet = T>>(
        &self,
        closure: &B,
        item: Option<Item>,
        carrier: Carrier,
    ) -> Watch<T> {
        let is_own = |face: &&Face<T>| item == Some(Item::Subface(face.key));
        let own = self.faces.iter().filter(is_own).flat_map(Face::inside).collect();
        let split = match carrier {
            Carrier::Segment(s, _) => Some(s),
            _ => None,
        };
        let mut watch = Watch { any: Vec::new(), own, anywhere: Anywhere::Apart };
        self.watch_faces(closure, carrier, &mut watch.any);
        self.watch_edges(closure, split, &mut watch.any);
        watch
    }

    /// Rule (b).
    fn watch_faces<B: Bounded<Tet = T>>(&self, closure: &B, carrier: Carrier, any: &mut Vec<T>) {
        let is_lost = |face: &Face<T>| {
            if carrier != Carrier::Free {
                return !closure.plc().lies_on(carrier, face.facet);
            }
            let [a, b, c] = face.key.map(|v| closure.at(v));
            let apexes =
                face.sides.into_iter().flatten().filter_map(|t| {
                    closure.vertices(t).into_iter().find(|v| !face.key.contains(v))
                });
            apexes
                .filter(|v| *v != INFINITE)
                .any(|apex| in_equatorial_ball(&a, &b, &c, &closure.at(apex)))
        };
        for face in self.faces.iter().filter(|face| is_lost(face)) {
            // From either side that is in the cavity.
            let [one, other] = face.sides;
            any.extend(other.into_iter().chain(one.filter(|_| face.is_inner)));
        }
    }

    /// Rule (c), but for edges of segment `split`.
    fn watch_edges<B: Bounded<Tet = T>>(&self, closure: &B, split: Option<u32>, any: &mut Vec<T>) {
        if self.edges.iter().all(|edge| Some(edge.segment) == split) {
            return;
        }
        for t in closure.cavity() {
            let (word, v) = (closure.marks(t), closure.vertices(t));
            let marked = ENDS.into_iter().filter(|&[i, j]| word & edge_bit(i, j) != 0);
            let is_other = |&[i, j]: &[usize; 2]| {
                split.is_none() || closure.segment(edge(v[i], v[j])) != split
            };
            for [i, j] in marked.filter(is_other) {
                let beside = (0..4).filter(|&slot| slot != i && slot != j);
                any.push(t);
                any.extend(beside.filter_map(|slot| closure.beyond(t, slot)));
            }
        }
    }
}

/// The tetrahedra at which candidates that come before a point make it wait.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Watch<T> {
    /// It waits if one of these has a rival.
    any: Vec<T>,
    /// It waits if all of these have, unless there are none: the tetrahedra at its own subface.
    own: Vec<T>,
    anywhere: Anywhere,
}

/// The rivals for which a point waits wherever they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Anywhere {
    Boundary,
    Apart,
}

impl<T: Copy> Watch<T> {
    /// That of a point which waits for others anywhere in its closure.
    pub fn over(closure: Vec<T>) -> Self {
        Self { any: closure, own: Vec::new(), anywhere: Anywhere::Boundary }
    }

    /// The number of tetrahedra in it.
    pub fn size(&self) -> usize {
        self.any.len() + self.own.len()
    }

    /// This watch over tetrahedra with other names, in the order of these.
    pub fn named<U: Ord>(&self, name: impl Fn(T) -> U) -> Watch<U> {
        let named = |all: &[T]| {
            let mut all: Vec<U> = all.iter().copied().map(&name).collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        Watch { any: named(&self.any), own: named(&self.own), anywhere: self.anywhere }
    }

    /// Does the point wait, if the tetrahedra of its closure, which are these, have these rivals?
    pub fn yields(&self, all: impl IntoIterator<Item = T>, rival: impl Fn(T) -> Rival) -> bool {
        let matters = |own: Rival| match self.anywhere {
            Anywhere::Boundary => own.is_boundary,
            Anywhere::Apart => own.is_apart,
        };
        let has = |&t: &T| rival(t).is_there;
        self.any.iter().any(has)
            || !self.own.is_empty() && self.own.iter().all(has)
            || all.into_iter().map(&rival).any(|own| own.is_there && matters(own))
    }
}
