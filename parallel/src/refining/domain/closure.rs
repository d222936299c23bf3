//! The closure of a point whose locks are all held, as far as the boundary is concerned: what the
//! owners of its cavity have told, put together for the verdict.

use super::values::{DomainPiece, DomainPoint, ItemKey, segment_key, subface_key};
use crate::mesh::VertexName;
use crate::protocol::{Part, WorkerId};
use ltbw_core::topology::TetId;
use ltbw_domain::vector::distance2;
use ltbw_exact::Point;
use ltbw_refine::{
    BoundaryItem, Carrier, Closure, Collected, Complex, Corner, NOWHERE, Past, Refusals, Ruling,
    Survey,
};
use rustc_hash::{FxHashMap, FxHashSet};
use smallvec::SmallVec;

/// A boundary item of a locked closure, and where it can be split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Located {
    pub(super) key: ItemKey,
    /// Its segment or facet.
    pub(super) of: u32,
    /// The owner of a tetrahedron at it.
    pub(super) owner: WorkerId,
    /// That tetrahedron, there.
    pub(super) tet: TetId,
    /// An owner knows that it cannot be split.
    pub(super) is_refused: bool,
}

/// The verdict on a point whose closure is locked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LockedRuling {
    /// It may be inserted.
    Fill,
    /// This item goes first.
    Defer(Located),
    /// It does not do what it was made for; another one may.
    Useless,
    /// Labels and limits are needed to judge: it is left to the engine.
    Leave,
}

/// The tetrahedra of a locked cavity at which something may be boundary.
#[derive(Debug, Default)]
pub(super) struct LockedClosure {
    closure: Closure,
    /// The names of its corners.
    names: Vec<VertexName>,
    /// The owners of its tetrahedra, and what these are there.
    at: Vec<(WorkerId, TetId)>,
    refused: FxHashSet<ItemKey>,
    /// Where all vertices of the cavity live that are on the boundary.
    bound: FxHashMap<VertexName, Carrier>,
}

impl LockedClosure {
    /// Puts together what the owners have told. A vertex has one number, whoever names it.
    pub(super) fn of(parts: &[Part<DomainPiece>]) -> Self {
        let mut own = Self::default();
        let mut numbers: FxHashMap<VertexName, u32> = FxHashMap::default();
        let all = parts.iter().flat_map(|(owner, pieces)| pieces.iter().map(move |p| (owner, p)));
        own.bound.extend(all.clone().flat_map(|(_, told)| told.bound.iter().copied()));
        for (&owner, told) in all.filter(|(_, told)| !told.near.is_empty()) {
            for near in &told.near {
                let v = near.v.map(|k| {
                    let Some(vertex) = told.piece.vertices.get(k as usize) else { return NOWHERE };
                    *numbers.entry(vertex.name).or_insert_with(|| {
                        let carrier = own.bound.get(&vertex.name).copied();
                        let carrier = carrier.unwrap_or(Carrier::Free);
                        own.closure.corners.push(Corner { point: vertex.point(), carrier });
                        own.names.push(vertex.name);
                        own.names.len() as u32 - 1
                    })
                });
                own.closure.tets.push((v, true));
                own.at.push((owner, near.tet));
            }
            own.refused.extend(&told.refused);
        }
        own
    }

    /// The verdict on a point. Of several items that may go first it is the one nearest to the
    /// point: two that displace each other would else wait for each other (decision 61).
    pub(super) fn rule(&self, complex: &Complex<'_>, point: &DomainPoint) -> LockedRuling {
        if self.is_delicate(complex, point.carrier) {
            return LockedRuling::Leave;
        }
        let p = point.vertex.point();
        let collected = Collected::of(&self.closure);
        let survey = Survey::of(complex, &collected, &p, point.carrier);
        let ruling = match point.carrier {
            Carrier::Free => survey.rule_on_tet(),
            Carrier::Segment(of, _) | Carrier::Facet(of) => match self.item(&point.item, of) {
                Some(item) => {
                    survey.rule_on_item(&item, point.may, &Past::without(&Refusals::new()))
                }
                None => Ruling::Useless,
            },
            Carrier::Corner(_) => Ruling::Useless,
        };
        let distance = |item: &BoundaryItem| distance2(&item.middle(), &p);
        match ruling {
            Ruling::Fill(_) => LockedRuling::Fill,
            Ruling::Defer(first) => {
                let nearest = first.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
                nearest.map_or(LockedRuling::Useless, |item| self.defer(item))
            }
            Ruling::Refuse(_) | Ruling::Useless => LockedRuling::Useless,
        }
    }

    /// Is anything of the closure of a patch, or are features related that vertices are on?
    fn is_delicate(&self, complex: &Complex<'_>, own: Carrier) -> bool {
        let at_patch = |(tet, _): &([u32; 4], bool)| {
            let finite = tet.iter().filter_map(|&v| self.closure.corners.get(v as usize));
            let carriers: SmallVec<[Carrier; 4]> = finite.map(|corner| corner.carrier).collect();
            complex.is_at_patch(&carriers)
        };
        let related = || {
            let all: Vec<Carrier> = self.bound.values().copied().chain([own]).collect();
            complex.are_related(&all)
        };
        complex.has_patches() && self.closure.tets.iter().any(at_patch)
            || complex.has_angles() && related()
    }

    fn defer(&self, item: &BoundaryItem) -> LockedRuling {
        self.locate(item).map_or(LockedRuling::Useless, LockedRuling::Defer)
    }

    /// The item with this key, of a segment or facet, if a tetrahedron is at it: others may have
    /// split it meanwhile.
    fn item(&self, key: &ItemKey, of: u32) -> Option<BoundaryItem> {
        let number = |name: &VertexName| self.names.iter().position(|own| own == name);
        let corners: Option<Vec<usize>> =
            key.iter().filter(|name| **name != 0).map(number).collect();
        let corners = corners.filter(|own| (2..=3).contains(&own.len()))?;
        self.place(&corners)?;
        let corners: Vec<Corner> = corners.into_iter().map(|v| self.closure.corners[v]).collect();
        Some(BoundaryItem::new(&corners, of))
    }

    /// An item of the closure by the names of its corners, at the first tetrahedron told that has
    /// them.
    fn locate(&self, item: &BoundaryItem) -> Option<Located> {
        let number = |p: &Point| self.closure.corners.iter().position(|own| own.point == *p);
        let corners: Option<Vec<usize>> =
            item.corners().iter().map(|corner| number(&corner.point)).collect();
        let corners = corners?;
        let (owner, tet) = self.at[self.place(&corners)?];
        let key = match corners[..] {
            [a, b] => segment_key([a, b].map(|v| self.names[v])),
            [a, b, c] => subface_key([a, b, c].map(|v| self.names[v])),
            _ => return None,
        };
        let is_refused = self.refused.contains(&key);
        Some(Located { key, of: item.of(), owner, tet, is_refused })
    }

    /// The place of the first tetrahedron that has these corners.
    fn place(&self, corners: &[usize]) -> Option<usize> {
        let has = |tet: &[u32; 4]| corners.iter().all(|&own| tet.contains(&(own as u32)));
        self.closure.tets.iter().position(|(tet, _)| has(tet))
    }
}
