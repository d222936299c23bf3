//! Slivers: tetrahedra with small dihedral angles, which bounds on their shape allow.
//!
//! When all bounds are met, a point is looked for whose cavity has the sliver and whose own
//! tetrahedra meet the bounds and have no such angle: inside, near the circumcentre, or on the
//! boundary beside it. So no sliver follows from another, and the number of tries is bounded. Where
//! none serves the sliver stays.
//!
//! Which points are tried, in which order, and which of them serves is told here, for a sliver by
//! its corners and a closure by values: for whoever has them.

use super::beside::{OnItem, in_unit_ball};
use super::bounded::Bounded;
use super::choice::{BoundaryItem, Corner};
use super::complex::Complex;
use super::star::{Made, star};
use super::verdict::{Filling, Judge, Verdict};
use crate::complex::angles::Angles;
use crate::complex::carrier::{Carrier, free_point};
use crate::complex::dihedral::DihedralBound;
use crate::complex::measure::Shape;
use crate::complex::plc::Plc;
use crate::mesh::bounds::Bounds;
use crate::mesh::facet::Change;
use crate::mesh::item::Item;
use crate::mesh::key::sorted;
use crate::mesh::state::Place;
use crate::rules::aim::TOLERANCE;
use ltbw_exact::Point;

/// Points inside that are tried for a sliver, within a part of the circumradius of the
/// circumcentre: fewer of a small part, then more of a larger one.
const REGIONS: [(usize, f64); 2] = [(16, 0.5), (32, 0.9)];
/// Points that serve a sliver, of which the best is taken.
const ENOUGH: usize = 4;
/// Points tried on each boundary item beside it.
const BESIDE: usize = 8;

/// The next thing to do for a sliver.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Try {
    /// A point inside is tried, if a straight way leads there from the middle of the sliver.
    Inside(Point),
    /// The boundary items beside the sliver are asked for, with the one on the straight way to this
    /// point, if there is one: [`Tries::beside`] takes them.
    Look(Option<Point>),
    /// A point of the boundary is tried.
    Beside {
        /// The number of its item among those that were given.
        item: usize,
        /// The point.
        point: Point,
        /// Where it lives.
        carrier: Carrier,
        /// May it lie in no ball of another item?
        gives_way: bool,
    },
    /// Nothing is left to try: the best of those that serve is taken.
    Over,
}

/// The part of the tries that is under way.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    Inside,
    Looking,
    Beside { gives_way: bool },
    Over,
}

/// The tries for a sliver, one after the other: inside, else on the boundary, where items are
/// beside it or keep points inside away; there at last in the balls of other items. Of the first
/// that serve the best is taken.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct Tries {
    centre: Point,
    radius: f64,
    part: Part,
    /// The tries in this part so far, and the state of their random numbers.
    count: usize,
    seed: u64,
    items: Vec<BoundaryItem>,
    /// The points that serve so far, and the sharpest angle of the best one: the square of its
    /// cosine.
    served: usize,
    least: f64,
}

impl Tries {
    /// The tries for the sliver with these corners; none if it has no circumsphere.
    pub fn of(corners: [Point; 4]) -> Option<Self> {
        // Rounded in an order that is always the same.
        let corners = sorted(corners);
        let [a, b, c, d] = &corners;
        let shape = Shape::of([a, b, c, d]);
        Some(Self {
            centre: shape.circumcentre(d)?,
            radius: shape.radius(),
            part: Part::Inside,
            count: 0,
            seed: 1,
            items: Vec::new(),
            served: 0,
            least: f64::INFINITY,
        })
    }

    /// Takes the boundary items that keep points inside away, or are beside the sliver, in the
    /// order of their places, each once.
    pub fn beside(&mut self, items: Vec<BoundaryItem>) {
        self.items = items;
        self.begin(Part::Beside { gives_way: true });
    }

    /// A point serves, with this sharpest angle: is it the best so far?
    pub fn take(&mut self, sharpest: f64) -> bool {
        self.served += 1;
        let is_best = sharpest < self.least;
        self.least = self.least.min(sharpest);
        is_best
    }

    fn begin(&mut self, part: Part) {
        (self.part, self.count, self.seed) = (part, 0, 1);
    }

    /// The next thing to do.
    pub(crate) fn next(&mut self, plc: &Plc) -> Try {
        let tolerance = self.radius * TOLERANCE;
        // Ends: each step counts, or begins a later part.
        loop {
            match self.part {
                Part::Over => return Try::Over,
                Part::Looking => return Try::Look(free_point(&self.centre, tolerance)),
                Part::Inside => {
                    let within = part_of(self.count).filter(|_| self.served < ENOUGH);
                    let Some(part) = within else {
                        self.begin(if self.served > 0 { Part::Over } else { Part::Looking });
                        continue;
                    };
                    self.count += 1;
                    let offset = in_unit_ball(&mut self.seed);
                    let at = |k: usize| self.centre[k] + part * self.radius * offset[k];
                    if let Some(p) = free_point(&[0, 1, 2].map(at), tolerance) {
                        return Try::Inside(p);
                    }
                }
                Part::Beside { gives_way } => {
                    let (item, k) = (self.count / BESIDE, self.count % BESIDE);
                    let Some(own) = self.items.get(item).filter(|_| self.served < ENOUGH) else {
                        let is_over = self.served > 0 || !gives_way;
                        let next = Part::Beside { gives_way: false };
                        self.begin(if is_over { Part::Over } else { next });
                        continue;
                    };
                    self.count += 1;
                    let place = plc.place_beside(own, k, &mut self.seed, tolerance);
                    if let Some(OnItem { point, carrier }) = place {
                        return Try::Beside { item, point, carrier, gives_way };
                    }
                }
            }
        }
    }
}

/// The part of the circumradius for the k-th point inside.
fn part_of(k: usize) -> Option<f64> {
    let mut first = 0;
    REGIONS.into_iter().find_map(|(tries, part)| {
        first += tries;
        (k < first).then_some(part)
    })
}

/// The terms on which a point is taken for a sliver.
pub(crate) struct Terms<'b> {
    pub(crate) bounds: &'b Bounds<'b>,
    /// Its tetrahedra have no smaller dihedral angle.
    pub(crate) dihedral: DihedralBound,
    /// They keep all bounds. Else those that do not are split by the rounds that follow.
    pub(crate) keeps_bounds: bool,
}

/// A point that is tried for a sliver.
pub(crate) struct Trial<'p> {
    pub(crate) place: &'p Place,
    /// Of the boundary: the item that it is on, and whether it may lie in no ball of another one.
    pub(crate) on: Option<(Item, bool)>,
    /// Has its cavity the sliver?
    pub(crate) has_sliver: bool,
}

/// The outcome of a trial.
pub(crate) enum Tried {
    /// The point serves: what comes with it, and the square of the cosine of its sharpest angle.
    Serves(Filling, f64),
    /// These items keep a point inside away.
    Barred(Vec<Item>),
    /// It does not serve.
    Fails,
}

impl<B: Bounded> Judge<'_, B> {
    /// Does a point serve a sliver?
    pub(crate) fn serves(&self, trial: &Trial<'_>, terms: &Terms<'_>) -> Tried {
        let &Trial { place, on, has_sliver } = trial;
        let filling = match on {
            None => match self.on_free(place) {
                Verdict::Defer(items) => return Tried::Barred(items),
                Verdict::Fill(filling) if has_sliver => Some(filling),
                Verdict::Fill(_) | Verdict::Useless | Verdict::Refuse(_) => None,
            },
            Some((item, gives_way)) if has_sliver => {
                self.filling_beside(Some(item), place, |_| !gives_way)
            }
            Some(_) => None,
        };
        let sharpest = |filling: &Filling| self.sharpest_of_star(place, &filling.changes, terms);
        match filling.and_then(|filling| Some((sharpest(&filling)?, filling))) {
            Some((sharpest, filling)) => Tried::Serves(filling, sharpest),
            None => Tried::Fails,
        }
    }

    /// The sharpest angle among the tetrahedra that a point makes with these changes, as the square
    /// of its cosine; `None` if one is not as the terms ask for.
    fn sharpest_of_star(
        &self,
        place: &Place,
        changes: &[Change],
        terms: &Terms<'_>,
    ) -> Option<f64> {
        let &Terms { bounds, dihedral, keeps_bounds } = terms;
        let mut most = 0.0f64;
        for Made { corners, region } in star(&self.closure, place, changes) {
            most = most.max(dihedral.sharpest_if_met(sorted(corners).each_ref())?);
            if keeps_bounds && bounds.are_over(corners.each_ref(), region) {
                return None;
            }
        }
        Some(most)
    }
}

/// Is a tetrahedron of a region a sliver that a point may serve: none in a collar, where the domain
/// asks for small angles?
pub(crate) fn is_open_sliver(
    plc: &Plc,
    angles: &Angles,
    bounds: &Bounds<'_>,
    corners: &[Corner; 4],
    region: u32,
) -> bool {
    let is_small = |own: DihedralBound| own.is_missed(corners.each_ref().map(|own| &own.point));
    let in_collar = || {
        let bound = bounds.ratio.as_ref();
        bound.is_some_and(|bound| angles.collar(plc, corners, bound.value()).is_some())
    };
    region != 0 && bounds.dihedral.is_some_and(is_small) && !in_collar()
}

impl Complex<'_> {
    /// Are slivers split?
    pub fn splits_slivers(&self) -> bool {
        self.bounds().dihedral.is_some()
    }

    /// Is a tetrahedron of a region a sliver that a point may serve?
    pub fn is_sliver(&self, corners: [Corner; 4], region: u32) -> bool {
        is_open_sliver(self.plc(), self.angles(), self.bounds(), &corners, region)
    }

    /// The next thing to do for a sliver.
    pub fn next_try(&self, tries: &mut Tries) -> Try {
        tries.next(self.plc())
    }

    /// The boundary items that points are tried on for a sliver, by their places: `faces` beside
    /// it, the subsegments of all these, and those that keep points inside away.
    pub fn items_beside(
        &self,
        corners: [Corner; 4],
        faces: Vec<BoundaryItem>,
        barred_by: Vec<BoundaryItem>,
    ) -> Vec<BoundaryItem> {
        let mut items = barred_by;
        let mut add = |corners: &[Corner]| {
            let pairs = (1..corners.len()).flat_map(|i| (0..i).map(move |j| [i, j]));
            items.extend(pairs.filter_map(|pair| {
                let ends = pair.map(|k| corners[k]);
                let of = self.segment(ends.map(|own| own.carrier))?;
                Some(BoundaryItem::new(&ends, of))
            }));
        };
        add(&corners);
        faces.iter().for_each(|face| add(face.corners()));
        items.extend(faces);
        items.sort_by_cached_key(BoundaryItem::place);
        items.dedup_by_key(|item| item.place());
        items
    }

    /// The terms on which a point is taken for a sliver when all bounds are met.
    pub(crate) fn terms(&self) -> Option<Terms<'_>> {
        let bounds = self.bounds();
        Some(Terms { bounds, dihedral: bounds.dihedral?, keeps_bounds: true })
    }
}
