//! Verdicts on proposed points, and the rules that keep points of one round apart, from a closure
//! alone: for engines whose mesh is on many processors.

use super::block::Block;
use super::bounded::{Bounded, ByValues};
use super::choice::{BoundaryItem, Corner, Filled, Relabelled, Ruling};
use super::complex::Complex;
use super::past::Past;
use super::record::Record;
use super::sliver::{Trial, Tried};
use super::surveyed::Surveyed;
use super::verdict::{Filling, Judge, Verdict};
use super::watch::Watch;
use crate::complex::carrier::Carrier;
use crate::mesh::item::Item;
use crate::mesh::state::Place;
use crate::mesh::survey;
use crate::table::{edge, triangle};
use ltbw_core::topology::{INFINITE, TetId, VertexId};
use ltbw_exact::Point;

/// The corners of a subface that is in no closure here.
const ELSEWHERE: [VertexId; 3] = [VertexId::new(u32::MAX); 3];

/// A boundary item that a point is tried on for a sliver.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct OnBoundary<'i> {
    /// The item.
    pub item: &'i BoundaryItem,
    /// May the point lie in no ball of another item?
    pub gives_way: bool,
}

/// The verdict on a point that is tried for a sliver.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub enum SliverRuling {
    /// It serves.
    Serves {
        /// The changes that come with it.
        filled: Filled,
        /// The sharpest angle of its tetrahedra: the square of its cosine.
        sharpest: f64,
    },
    /// These items keep it away.
    Barred(Vec<BoundaryItem>),
    /// It does not serve.
    Fails,
}

/// The closure of a point, with what is boundary in it and what the point encroaches.
#[doc(hidden)]
#[derive(Debug)]
pub struct Survey<'c, R: Surveyed> {
    closure: ByValues<'c, R>,
    found: survey::Survey<R::Tet>,
    place: Place,
    record: Record,
}

impl<'c, R: Surveyed> Survey<'c, R> {
    /// The survey of the closure of `p`, which lives on `carrier`.
    pub fn of(complex: &'c Complex<'c>, closure: &'c R, p: &Point, carrier: Carrier) -> Self {
        let closure = ByValues { complex, closure, num_vertices: 0 };
        let mut found = survey::Survey::default();
        found.look(&closure, p, carrier);
        let place = Place { p: *p, carrier, from: TetId::default() };
        Self { closure, found, place, record: Record::default() }
    }

    fn judge(&self) -> Judge<'_, ByValues<'c, R>> {
        Judge::new(self.closure, &self.found, &self.record)
    }

    /// An item by the coordinates of its corners.
    fn named(&self, item: Item) -> Option<BoundaryItem> {
        match item {
            Item::Segment(s) => {
                let of = self.closure.segment(s)?;
                Some(BoundaryItem::new(&s.map(|v| self.closure.corner(v)), of))
            }
            Item::Subface(s) => {
                let of = self.found.faces.iter().find(|face| face.key == s)?.facet;
                Some(BoundaryItem::new(&s.map(|v| self.closure.corner(v)), of))
            }
            Item::Tet(..) => None,
        }
    }

    /// An item of the cavity; `None` if that does not have all of its corners.
    fn here(&self, item: &BoundaryItem) -> Option<Item> {
        let at = |corner: &Corner| {
            let all = || self.closure.cavity().flat_map(|t| self.closure.vertices(t));
            let is = |&v: &VertexId| v != INFINITE && self.closure.at(v) == corner.point;
            all().find(is)
        };
        let own: Vec<VertexId> = item.corners().iter().map(at).collect::<Option<_>>()?;
        match own[..] {
            [a, b] => Some(Item::Segment(edge(a, b))),
            [a, b, c] => Some(Item::Subface(triangle(a, b, c))),
            _ => None,
        }
    }

    /// The verdict on a point inside.
    pub fn rule_on_tet(&self) -> Ruling {
        self.ruling(self.judge().on_free(&self.place))
    }

    /// The verdict on a point of the boundary that is to split an item; one of a facet is on it if
    /// it `is_on`.
    pub fn rule_on_item(&self, item: &BoundaryItem, is_on: bool, past: &Past<'_>) -> Ruling {
        let Some(own) = self.here(item) else { return Ruling::Useless };
        let closure = ByValues { num_vertices: past.num_vertices, ..self.closure };
        let mut record = Record { joint_transactions: past.spent, ..Record::default() };
        record.limits.extend(past.limit.map(|limit| (own, limit)));
        if !past.refused.is_empty() {
            let refused = |item: Item| {
                let place = self.named(item)?.place();
                past.refused.get(&place).map(|refusal| (item, *refusal))
            };
            let edges = self.found.edges.iter().map(|edge| Item::Segment(edge.key));
            let faces = self.found.faces.iter().map(|face| Item::Subface(face.key));
            record.refused.extend(edges.chain(faces).filter_map(refused));
        }
        let judge = Judge::new(closure, &self.found, &record);
        self.ruling(judge.on_boundary(own, &self.place, is_on))
    }

    /// The verdict on a point that is tried for a sliver, inside or on a boundary item. Its cavity
    /// has the sliver if it `has_sliver`.
    pub fn rule_on_sliver(&self, on: Option<OnBoundary<'_>>, has_sliver: bool) -> SliverRuling {
        let Some(terms) = self.closure.complex.terms() else { return SliverRuling::Fails };
        let on = match on {
            None => None,
            Some(OnBoundary { item, gives_way }) => match self.here(item) {
                Some(own) => Some((own, gives_way)),
                // On a patch a point may be somewhere else.
                None if !item.is_segment() => Some((Item::Subface(ELSEWHERE), gives_way)),
                None => return SliverRuling::Fails,
            },
        };
        match self.judge().serves(&Trial { place: &self.place, on, has_sliver }, &terms) {
            Tried::Serves(filling, sharpest) => {
                SliverRuling::Serves { filled: self.filled(&filling), sharpest }
            }
            Tried::Barred(items) => SliverRuling::Barred(
                items.into_iter().filter_map(|item| self.named(item)).collect(),
            ),
            Tried::Fails => SliverRuling::Fails,
        }
    }

    /// The subfaces that the refused point would take out of the mesh, if they may not be split.
    pub fn blocks(&self, past: &Past<'_>) -> Vec<Block> {
        if past.refused.is_empty() {
            return Vec::new();
        }
        let bars = |own: BoundaryItem| past.bars(own.place()).is_some();
        let found = self.judge().blocks(|s| self.named(Item::Subface(s)).is_some_and(bars));
        found.into_iter().map(|own| own.0).collect()
    }

    /// The changes that come with the point by coordinates.
    fn filled(&self, Filling { split, changes, .. }: &Filling) -> Filled {
        let faces = changes.iter().flat_map(|change| &change.removed);
        let faces = faces.map(|&s| Item::Subface(s));
        let split = split.map(|(s, _)| Item::Segment(s));
        let wall = |&(corners, region): &([VertexId; 3], u32)| Relabelled {
            corners: corners.map(|v| self.closure.at(v)),
            region,
        };
        Filled {
            gone: faces.chain(split).filter_map(|item| self.named(item)).collect(),
            relabelled: changes.iter().flat_map(|own| &own.relabelled).map(wall).collect(),
            is_alone: changes.iter().any(|change| self.closure.plc().is_patch(change.facet)),
        }
    }

    /// A verdict by the coordinates of items.
    fn ruling(&self, verdict: Verdict) -> Ruling {
        match verdict {
            Verdict::Fill(filling) => Ruling::Fill(self.filled(&filling)),
            Verdict::Defer(first) => {
                Ruling::Defer(first.into_iter().filter_map(|item| self.named(item)).collect())
            }
            Verdict::Refuse(reason) => Ruling::Refuse(reason),
            Verdict::Useless => Ruling::Useless,
        }
    }

    /// The watch of a point inside; none if no part of its cavity is marked.
    pub fn watch_in_tet(&self) -> Option<Watch<R::Tet>> {
        self.found.watch_in_tet(&self.closure)
    }

    /// The watch of a point of the boundary that splits an item.
    pub fn watch_at_item(&self, item: &BoundaryItem) -> Watch<R::Tet> {
        self.found.watch_at_item(&self.closure, self.here(item), self.place.carrier)
    }
}
