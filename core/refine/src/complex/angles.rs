//! Small angles of the input: where the theory of refinement gives no guarantee.
//!
//! Facets that meet along a segment, and facets and segments that meet only at a corner, are
//! *related* where the angle between them is below 20°. A point of one would take items of the
//! other out of the mesh again and again, the nearer to the segment or corner the more; so such a
//! point is refused, with the segment or corner for a reason, where it would take an item of an
//! unrelated facet only after that item was split. (But where a tetrahedron is too large both are
//! split together: `limit`, `turned`.) Features with narrow gaps between them (`near`)
//! are related, too.
//!
//! Features that meet at a corner alone are related there alone: the reason counts for items that
//! have the corner, which make its ball; the last shells are the radius. All others are as far
//! apart as the angle makes them at their distance from the corner, and are split as anywhere.
//!
//! The theory gives a guarantee from arccos(1/3) = 70.53° on, and none between. 20° was measured:
//! on surfaces of triangles a larger angle relates nearly all facets, since every flat edge is a
//! segment.
//!
//! Angles are computed in `f64`: they choose how hard to try, never what is true of the result.

use super::carrier::Carrier;
use super::near::{self, Pair};
use super::plc::Plc;
use crate::RefineError;
use crate::heed::Heed;
use crate::outcome::Reason;
use crate::table::{Map, Set, edge};
use ltbw_domain::vector::{cross, dot, minus};
use ltbw_exact::Point;

/// cos² of 20°, the angle below which features are related.
const SMALL: f64 = 0.883_022_221_559_489_1;
/// cos² of 60°, below which segments at a corner are split in concentric shells; a little more, so
/// that rounding makes none at the limit sharp.
const SHARP: f64 = 0.25 * (1.0 + 1e-9);
/// Corners with more facets than this are not looked at in pairs.
const CROWD: usize = 512;

/// The reasons why two features are related, or why one is related to any.
#[derive(Clone, Debug, Default)]
struct Reasons {
    list: Vec<Reason>,
    /// The reasons of the list, once there are many: a facet may have one for each of its corners.
    known: Set<Reason>,
}

/// Reasons from which on it is looked up whether there is another one.
const MANY: usize = 8;

impl Reasons {
    /// Adds a reason that is not there yet.
    fn add(&mut self, reason: Reason) {
        if self.list.len() == MANY {
            self.known.extend(&self.list);
        }
        let is_new = match self.list.len() < MANY {
            true => !self.list.contains(&reason),
            false => self.known.insert(reason),
        };
        if is_new {
            self.list.push(reason);
        }
    }
}

/// The related pairs, and per facet and segment the reasons why it is in one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Angles {
    facets: Map<[u32; 2], Reasons>,
    /// Segment and facet.
    segments: Map<(u32, u32), Reasons>,
    /// Two segments.
    sharp: Map<[u32; 2], Reasons>,
    /// Corner and facet.
    corners: Set<(u32, u32)>,
    of_facet: Map<u32, Reasons>,
    /// Per segment: pairs of facets at a small dihedral angle, with the square of the sine of half
    /// of it.
    wedges: Map<u32, Vec<([u32; 2], f64)>>,
    of_segment: Map<u32, Reasons>,
    /// Are there small dihedral angles, or segments at small angles?
    has_small: bool,
    /// The square of the sine of half the angle below which a bound on shapes is not met at tips.
    tips_below: f64,
}

/// Adds a reason that is not there yet.
fn add<K: Eq + std::hash::Hash>(map: &mut Map<K, Reasons>, key: K, reason: Reason) {
    map.entry(key).or_default().add(reason);
}

/// The first reason that counts for an item which has the corners that `has` says.
fn first(reasons: Option<&Reasons>, has: &impl Fn(u32) -> bool) -> Option<Reason> {
    let counts = |reason: &Reason| match *reason {
        Reason::SmallFaceAngle { corner } => has(corner),
        _ => true,
    };
    reasons?.list.iter().copied().find(counts)
}

/// Is the angle between two directions below the one whose squared cosine is `limit`?
fn is_small(a: &Point, b: &Point, limit: f64) -> bool {
    let product = dot(a, b);
    product > 0.0 && product * product > limit * dot(a, a) * dot(b, b)
}

/// The square of the sine of half the angle between two directions, rounded.
fn half_sine2(a: &Point, b: &Point) -> f64 {
    (1.0 - dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()).max(0.0) / 2.0
}

/// Do two segments with these directions leave a corner at less than 60°?
pub(crate) fn is_sharp(a: &Point, b: &Point) -> bool {
    is_small(a, b, SHARP)
}

impl Angles {
    /// Looks at all segments and corners, and at features nearer to each other than `limit` steps
    /// of the grid.
    ///
    /// # Errors
    /// [`RefineError::Cancelled`].
    pub(crate) fn of(plc: &Plc, limit: f64, heed: Heed<'_>) -> Result<Self, RefineError> {
        let mut angles = Self::default();
        let inward = inward_directions(plc);
        for (s, segment) in (0..).zip(&plc.segments) {
            heed.ask_at(s as usize)?;
            let none = Vec::new();
            for (k, &f) in segment.facets.iter().enumerate() {
                for &g in &segment.facets[..k] {
                    let [x, y] = [f, g].map(|f| inward.get(&(s, f)).unwrap_or(&none));
                    let pairs = x.iter().flat_map(|a| y.iter().map(move |b| (a, b)));
                    let small = pairs.filter(|(a, b)| is_small(a, b, SMALL));
                    let least = small.map(|(a, b)| half_sine2(a, b)).reduce(f64::min);
                    if let Some(half) = least {
                        angles.wedges.entry(s).or_default().push(([f, g], half));
                        let reason = Reason::SmallDihedral { segment: segment.ends };
                        angles.relate_facets(f, g, reason);
                        add(&mut angles.of_segment, s, reason);
                    }
                }
            }
        }
        for corner in 0..plc.corners.len() as u32 {
            heed.ask()?;
            angles.look_at_corner(plc, corner);
        }
        // Features near each other add to the same lists.
        angles.has_small = !angles.is_empty();
        for pair in near::pairs(plc, limit, heed)? {
            angles.relate_near(plc, pair);
        }
        Ok(angles)
    }

    /// Relates two features that are near each other, and what they are part of.
    fn relate_near(&mut self, plc: &Plc, pair: Pair) {
        match pair {
            Pair::CornerFacet(corner, f) => {
                let reason = Reason::NearFacet { corner };
                self.corners.insert((corner, f));
                for &s in &plc.segments_at[corner as usize] {
                    add(&mut self.segments, (s, f), reason);
                    add(&mut self.of_segment, s, reason);
                }
                for &g in plc.facets_at[corner as usize].iter().filter(|&&g| g != f) {
                    self.relate_facets(f, g, reason);
                }
            }
            Pair::Segments(s, r) => {
                let [a, b] = [s, r].map(|s| &plc.segments[s as usize]);
                let reason = Reason::NearSegments { first: a.ends, second: b.ends };
                add(&mut self.sharp, edge(s, r), reason);
                b.facets.iter().for_each(|&f| add(&mut self.segments, (s, f), reason));
                a.facets.iter().for_each(|&f| add(&mut self.segments, (r, f), reason));
                for s in [s, r] {
                    add(&mut self.of_segment, s, reason);
                }
                for &f in &a.facets {
                    for &g in b.facets.iter().filter(|&&g| g != f) {
                        self.relate_facets(f, g, reason);
                    }
                }
            }
        }
    }

    fn relate_facets(&mut self, f: u32, g: u32, reason: Reason) {
        add(&mut self.facets, edge(f, g), reason);
        add(&mut self.of_facet, f, reason);
        add(&mut self.of_facet, g, reason);
    }

    /// Relates what meets at one corner alone.
    fn look_at_corner(&mut self, plc: &Plc, corner: u32) {
        let segments = &plc.segments_at[corner as usize];
        let reason = Reason::SmallFaceAngle { corner };
        let facets = &plc.facets_at[corner as usize];
        if segments.len() > CROWD || facets.len() > CROWD {
            return;
        }
        let small = |s: u32, r: u32| {
            let [a, b] = [s, r].map(|s| direction(plc, s, corner));
            is_small(&a, &b, SMALL)
        };
        for (k, &s) in segments.iter().enumerate() {
            for &r in segments[..k].iter().filter(|&&r| small(s, r)) {
                add(&mut self.of_segment, s, reason);
                add(&mut self.of_segment, r, reason);
                add(&mut self.sharp, edge(s, r), reason);
                let [of_s, of_r] = [s, r].map(|s| &plc.segments[s as usize].facets);
                // Two sides of one facet: the small angle is in its plane, not between facets.
                if of_s.iter().any(|f| of_r.contains(f)) {
                    continue;
                }
                for &f in of_r.iter().filter(|f| !of_s.contains(f)) {
                    add(&mut self.segments, (s, f), reason);
                    add(&mut self.of_facet, f, reason);
                }
                for &f in of_s.iter().filter(|f| !of_r.contains(f)) {
                    add(&mut self.segments, (r, f), reason);
                    add(&mut self.of_facet, f, reason);
                }
                for &f in of_s {
                    for &g in of_r.iter().filter(|&&g| g != f && !share_segment(plc, f, g, corner))
                    {
                        self.relate_facets(f, g, reason);
                    }
                }
            }
        }
    }

    /// Is anything related to anything?
    pub(crate) fn relates(&self) -> bool {
        !(self.of_facet.is_empty() && self.of_segment.is_empty())
    }

    /// Is nothing at a small angle?
    pub(crate) fn is_empty(&self) -> bool {
        self.sharp.is_empty() && self.wedges.is_empty()
    }

    /// Do any rules count that are for small angles and near features?
    pub(crate) fn matter(&self) -> bool {
        self.relates() || !self.is_empty()
    }

    /// The ends of a segment at which two facets meet at a small dihedral angle.
    pub(crate) fn hinge(&self, f: u32, g: u32) -> Option<[u32; 2]> {
        self.facets.get(&edge(f, g))?.list.iter().find_map(|reason| match *reason {
            Reason::SmallDihedral { segment } => Some(segment),
            _ => None,
        })
    }

    /// Are there small dihedral angles, or segments at small angles?
    pub(crate) fn has_small(&self) -> bool {
        self.has_small
    }

    /// Takes the bound on shapes that tells which tips are too sharp for it.
    pub(crate) fn bound_tips(&mut self, bound: Option<f64>) {
        let sine2 = bound.map_or(0.0, |b| 0.25 / (b * b));
        self.tips_below = (1.0 - (1.0 - sine2).sqrt()) / 2.0;
    }

    /// The sine of half the least angle of segment `s` with another one at a corner, of those that
    /// are too sharp for the bound on shapes.
    pub(crate) fn sharpest(&self, plc: &Plc, s: u32, corner: u32) -> Option<f64> {
        let mine = direction(plc, s, corner);
        let others = plc.segments_at[corner as usize].iter().filter(|&&r| r != s);
        let tips = others.filter(|&&r| self.is_tip(s, r, corner));
        let halves = tips.map(|&r| half_sine2(&mine, &direction(plc, r, corner)));
        halves.filter(|&half| half < self.tips_below).reduce(f64::min).map(f64::sqrt)
    }

    /// The number of segments that are at a small angle with another one at a corner, by corner.
    pub(crate) fn needles(&self) -> Map<Reason, usize> {
        let at = |(pair, reasons): (&[u32; 2], &Reasons)| {
            reasons.list.iter().flat_map(|&reason| pair.map(|s| (reason, s))).collect::<Vec<_>>()
        };
        let mut counts: Map<Reason, usize> = Map::default();
        for (reason, _) in self.sharp.iter().flat_map(at).collect::<Set<(Reason, u32)>>() {
            *counts.entry(reason).or_default() += 1;
        }
        counts
    }

    /// Are two segments at a small angle at a corner?
    pub(crate) fn is_tip(&self, s: u32, r: u32, corner: u32) -> bool {
        let reason = Reason::SmallFaceAngle { corner };
        self.sharp.get(&edge(s, r)).is_some_and(|reasons| reasons.list.contains(&reason))
    }

    /// The pairs of facets at segment `s` whose dihedral angle is so small that the square of the
    /// sine of half of it is below `limit`.
    pub(crate) fn wedges(&self, s: u32, limit: f64) -> impl Iterator<Item = [u32; 2]> + '_ {
        let all = self.wedges.get(&s).into_iter().flatten();
        all.filter(move |(_, half)| *half < limit).map(|(pair, _)| *pair)
    }

    /// Why facet `f` is related to any other, if it is.
    pub(crate) fn reason_of_facet(&self, f: u32) -> Option<Reason> {
        self.of_facet.get(&f)?.list.first().copied()
    }

    /// Why segment `s` is related to any other, if it is.
    pub(crate) fn reason_of_segment(&self, s: u32) -> Option<Reason> {
        self.of_segment.get(&s)?.list.first().copied()
    }

    /// The small angle that a tetrahedron is at, if any of its vertices, which live there, is on
    /// something at one: the first one tells.
    pub(crate) fn reason_near(&self, plc: &Plc, carriers: [Carrier; 4]) -> Reason {
        let facets = |f: &u32| self.reason_of_facet(*f);
        let reason = carriers.into_iter().find_map(|carrier| match carrier {
            Carrier::Segment(s, _) => {
                let own = self.reason_of_segment(s);
                own.or_else(|| plc.segments[s as usize].facets.iter().find_map(facets))
            }
            Carrier::Corner(c) => plc.facets_at[c as usize].iter().find_map(facets),
            Carrier::Facet(f) => facets(&f),
            Carrier::Free => None,
        });
        reason.unwrap_or(Reason::Rounding)
    }

    /// Why facet `f` is related to any other, for an item of it with the corners that `has` says.
    pub(crate) fn reason_on_facet(&self, f: u32, has: &impl Fn(u32) -> bool) -> Option<Reason> {
        first(self.of_facet.get(&f), has)
    }

    /// Why segment `s` is related, for a subsegment with the corners that `has` says.
    pub(crate) fn reason_on_segment(&self, s: u32, has: &impl Fn(u32) -> bool) -> Option<Reason> {
        first(self.of_segment.get(&s), has)
    }

    /// Are two of some segments and facets related, at corners that `has` says?
    pub(crate) fn are_related(
        &self,
        segments: &[u32],
        facets: &[u32],
        has: &impl Fn(u32) -> bool,
    ) -> bool {
        let pairs = |k: usize| (0..k).map(move |j| (j, k));
        let mut both = (0..facets.len()).flat_map(pairs).map(|(j, k)| edge(facets[j], facets[k]));
        let mut sharp =
            (0..segments.len()).flat_map(pairs).map(|(j, k)| edge(segments[j], segments[k]));
        let mut mixed = segments.iter().flat_map(|&s| facets.iter().map(move |&f| (s, f)));
        both.any(|pair| first(self.facets.get(&pair), has).is_some())
            || sharp.any(|pair| first(self.sharp.get(&pair), has).is_some())
            || mixed.any(|pair| first(self.segments.get(&pair), has).is_some())
    }

    /// Why a vertex that lives on `carrier` is related to a subsegment of `s` with the corners that
    /// `has` says, if it is.
    pub(crate) fn related_segment(
        &self,
        carrier: Carrier,
        s: u32,
        has: &impl Fn(u32) -> bool,
    ) -> Option<Reason> {
        match carrier {
            Carrier::Facet(g) => first(self.segments.get(&(s, g)), has),
            Carrier::Segment(r, _) => first(self.sharp.get(&edge(r, s)), has),
            Carrier::Corner(_) | Carrier::Free => None,
        }
    }

    /// Why a vertex that lives on `carrier` is related to an item on facet `f` with the corners
    /// that `has` says, if it is.
    pub(crate) fn related(
        &self,
        plc: &Plc,
        carrier: Carrier,
        f: u32,
        has: &impl Fn(u32) -> bool,
    ) -> Option<Reason> {
        let with = |g: &u32| first(self.facets.get(&edge(f, *g)), has);
        match carrier {
            Carrier::Facet(g) => with(&g),
            Carrier::Segment(s, _) => first(self.segments.get(&(s, f)), has)
                .or_else(|| plc.segments[s as usize].facets.iter().find_map(with)),
            Carrier::Corner(corner) => {
                self.corners.contains(&(corner, f)).then_some(Reason::NearFacet { corner })
            }
            Carrier::Free => None,
        }
    }
}

/// The direction of segment `s` away from one of its corners.
pub(crate) fn direction(plc: &Plc, s: u32, corner: u32) -> Point {
    let ends = plc.segments[s as usize].ends;
    let far = ends[usize::from(ends[0] == corner)];
    let [a, b] = [corner, far].map(|c| plc.corners[c as usize].map(|x| x as f64));
    minus(&b, &a)
}

/// Do two facets share a segment at `corner`?
fn share_segment(plc: &Plc, f: u32, g: u32, corner: u32) -> bool {
    plc.segments_at[corner as usize].iter().any(|&s| {
        let facets = &plc.segments[s as usize].facets;
        facets.contains(&f) && facets.contains(&g)
    })
}

/// For each segment and facet at it: the directions in the facet's plane, normal to the segment,
/// in which the facet extends. Where a part has several polygons, both sides are taken.
fn inward_directions(plc: &Plc) -> Map<(u32, u32), Vec<Point>> {
    let by_ends: Map<[u32; 2], u32> = (0..).zip(&plc.segments).map(|(s, e)| (e.ends, s)).collect();
    let mut inward: Map<(u32, u32), Vec<Point>> = Map::default();
    for (f, facet) in (0..).zip(&plc.facets) {
        let n = facet.plane.normal();
        for part in &facet.parts {
            for polygon in &part.polygons {
                let at = |v: u32| plc.corners[v as usize].map(|c| c as f64);
                let turn: f64 = (1..polygon.len())
                    .map(|k| {
                        let o = at(polygon[0]);
                        let (a, b) = (minus(&at(polygon[k - 1]), &o), minus(&at(polygon[k]), &o));
                        dot(&cross(&a, &b), &n)
                    })
                    .sum();
                for (k, &a) in polygon.iter().enumerate() {
                    let b = polygon[(k + 1) % polygon.len()];
                    let Some(&s) = by_ends.get(&edge(a, b)) else { continue };
                    let side = cross(&n, &minus(&at(b), &at(a)));
                    let list = inward.entry((s, f)).or_default();
                    // Polygons of a patch do not enclose each other.
                    let single = part.polygons.len() == 1 || facet.patch.is_some();
                    let single = single && turn != 0.0;
                    if !single || turn > 0.0 {
                        list.push(side);
                    }
                    if !single || turn < 0.0 {
                        list.push(side.map(|c| -c));
                    }
                }
            }
        }
    }
    inward
}
