//! Polygons that are coplanar within a tolerance: which of them make one *patch*.
//!
//! From the largest polygon that is in no patch yet, over edges of exactly two polygons of one
//! marker that are not drawn: a polygon joins if all its corners are within the tolerance of the
//! patch's plane, its normal is within 60° of the plane's (but for needles, lower than the
//! tolerance), and its projection along the largest entry of the plane's normal has a positive
//! area. The plane is that of the first polygon; then, as long as the patch becomes larger, but
//! eight times at most, the one through its least corner that is normal to the sum of the normals
//! of all polygons, shortened to 52 bits.
//! A set of one plane is no patch: it stays what it is. So does a polygon that may have the same
//! cell on both sides: all polygons that edges connect to an edge of an odd number of them. (A
//! surface all of whose edges have even numbers separates: a way through one polygon changes
//! between odd and even.)
//!
//! All decisions are exact, and the order of the input does not matter: the checker of meshes finds
//! the same patches by itself.

use super::carrier::Grid;
use crate::RefineError;
use crate::heed::Heed;
use crate::table::{Map, Set, edge};
use ltbw_domain::Domain;
use num_bigint::BigInt;

/// A plane is fitted as many times at most.
const ROUNDS: u32 = 8;

/// Bits of the largest entry of a fitted normal.
const BITS: i32 = 52;

/// A facet of one polygon.
#[derive(Clone, Debug)]
pub(crate) struct Polygon {
    /// The facet of the domain.
    pub(crate) facet: u32,
    /// Its corners; of a polygon in a patch counter-clockwise in the projection.
    pub(crate) corners: Vec<u32>,
    /// Its normal, as long as twice its area. Differences are below 2^28, so entries below 2^57.
    normal: [i128; 3],
}

/// The polygons of a patch, the largest first, and the axis along which they are projected.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub(crate) polygons: Vec<Polygon>,
    pub(crate) axis: usize,
}

/// A polygon of a patch, as it is turned in it.
#[derive(Clone, Debug)]
struct Joined {
    /// Its place among all polygons.
    place: usize,
    polygon: Polygon,
}

/// An edge of polygons.
#[derive(Default)]
struct Uses {
    /// Facet, and place among the polygons if it has one.
    facets: Vec<(u32, Option<usize>)>,
    drawn: bool,
}

/// A tolerance as an exact number: mantissa · 2^exponent.
struct Tolerance {
    rounded: f64,
    mantissa: BigInt,
    exponent: i32,
}

fn dot(a: &[i128; 3], b: &[i128; 3]) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: &Grid, b: &Grid) -> [i128; 3] {
    [0, 1, 2].map(|k| i128::from(a[k] - b[k]))
}

impl Tolerance {
    fn new(value: f64) -> Self {
        let bits = value.to_bits();
        let exponent = (bits >> 52 & 0x7ff) as i32;
        let mantissa = bits & ((1 << 52) - 1) | u64::from(exponent > 0) << 52;
        let exponent = exponent.max(1) - 1075;
        Self { rounded: value, mantissa: BigInt::from(mantissa), exponent }
    }

    /// Is |a| at most the tolerance times the root of `square`?
    fn holds(&self, a: i128, square: i128) -> bool {
        let (left, right) = (a.unsigned_abs() as f64, self.rounded * (square as f64).sqrt());
        if left < 0.999 * right || left > 1.001 * right {
            return left < right;
        }
        let left = BigInt::from(a) * BigInt::from(a);
        let right = &self.mantissa * &self.mantissa * BigInt::from(square);
        match self.exponent {
            e @ 0.. => left <= right << (2 * e),
            e => left << (-2 * e) <= right,
        }
    }
}

/// The patches of the facets of a domain with these corners, within a tolerance in steps, and the
/// number of times that one ends where it would fold over itself.
///
/// # Errors
/// [`RefineError::Cancelled`].
pub(crate) fn patches(
    corners: &[Grid],
    domain: &Domain,
    tolerance: f64,
    heed: Heed<'_>,
) -> Result<(Vec<Group>, usize), RefineError> {
    let (polygons, uses) = polygons_of(corners, domain);
    let tolerance = Tolerance::new(tolerance);
    let open = open_facets(domain, &uses);
    let mut free: Vec<bool> = polygons.iter().map(|p| !open[p.facet as usize]).collect();
    let mut order: Vec<usize> = (0..polygons.len()).filter(|&k| free[k]).collect();
    order.sort_by_cached_key(|&k| {
        let mut at: Vec<Grid> = polygons[k].corners.iter().map(|&v| corners[v as usize]).collect();
        at.sort_unstable();
        (-dot(&polygons[k].normal, &polygons[k].normal), at)
    });
    let (mut groups, mut folds) = (Vec::new(), 0);
    for first in order {
        if !free[first] {
            continue;
        }
        heed.ask()?;
        let search = Search { corners, domain, uses: &uses, polygons: &polygons, free: &free };
        let mut base = Base::of(&polygons[first], corners);
        let mut list = search.spread(first, &base, &tolerance);
        for _ in 0..ROUNDS {
            let next = base.fitted(&list);
            let larger = search.spread(first, &next, &tolerance);
            if larger.len() <= list.len() {
                break;
            }
            (base, list) = (next, larger);
        }
        folds += usize::from(search.folds(&list, &base, &tolerance));
        free[first] = false;
        let first = Base::of(&polygons[first], corners);
        for joined in &list {
            free[joined.place] = false;
        }
        let level = |v: &u32| first.height(&corners[*v as usize]) == 0;
        if !list.iter().all(|joined| joined.polygon.corners.iter().all(level)) {
            let polygons = list.into_iter().map(|joined| joined.polygon).collect();
            groups.push(Group { polygons, axis: base.axis });
        }
    }
    Ok((groups, folds))
}

/// The plane of a patch.
#[derive(Clone, Debug)]
struct Base {
    normal: [i128; 3],
    origin: Grid,
    /// The axis of the normal's largest entry, which is positive.
    axis: usize,
}

impl Base {
    fn new(normal: [i128; 3], origin: Grid) -> Self {
        let larger = |a: usize, b: usize| if normal[b].abs() > normal[a].abs() { b } else { a };
        let axis = larger(larger(0, 1), 2);
        let normal = if normal[axis] < 0 { normal.map(|c| -c) } else { normal };
        Self { normal, origin, axis }
    }

    /// The plane of a polygon, through its least corner.
    fn of(polygon: &Polygon, corners: &[Grid]) -> Self {
        let least = polygon.corners.iter().map(|&v| corners[v as usize]).min();
        Self::new(polygon.normal, least.unwrap_or_default())
    }

    /// The plane through the same point that is normal to the sum of the polygons' normals.
    fn fitted(&self, list: &[Joined]) -> Self {
        let sum = [0, 1, 2].map(|k| list.iter().map(|own| own.polygon.normal[k]).sum::<i128>());
        let largest = sum.iter().map(|c| c.unsigned_abs()).max().unwrap_or(0);
        let bits = 128 - largest.leading_zeros() as i32;
        // Rounded towards zero, so that it does not matter how long the steps are.
        let short = sum.map(|c| match bits - BITS {
            up @ ..0 => c << -up,
            down => (c.abs() >> down) * c.signum(),
        });
        Self::new(short, self.origin)
    }

    fn height(&self, p: &Grid) -> i128 {
        dot(&self.normal, &minus(p, &self.origin))
    }
}

/// The search for the polygons of a patch.
struct Search<'s> {
    corners: &'s [Grid],
    domain: &'s Domain,
    uses: &'s Map<[u32; 2], Uses>,
    polygons: &'s [Polygon],
    free: &'s [bool],
}

impl Search<'_> {
    /// The polygons that belong to the patch of `base` and the first one, as they are turned in it.
    fn spread(&self, first: usize, base: &Base, tolerance: &Tolerance) -> Vec<Joined> {
        let mut start = self.polygons[first].clone();
        if start.normal[base.axis] < 0 {
            start.turn();
        }
        if !start.fits(base, self.corners, tolerance) {
            return Vec::new();
        }
        let mut seen: Set<usize> = [first].into_iter().collect();
        let mut list = vec![Joined { place: first, polygon: start }];
        let mut next = 0;
        // Breadth first; each polygon enters once.
        while let Some(own) = list.get(next).cloned() {
            next += 1;
            for joined in self.beside(&own) {
                let is_new = !seen.contains(&joined.place);
                if is_new && joined.polygon.fits(base, self.corners, tolerance) {
                    seen.insert(joined.place);
                    list.push(joined);
                }
            }
        }
        list
    }

    /// The free polygons across the edges of a polygon, turned as it is.
    fn beside<'a>(&'a self, own: &'a Joined) -> impl Iterator<Item = Joined> + 'a {
        let ring = &own.polygon.corners;
        ring.iter().enumerate().filter_map(move |(i, &a)| {
            let b = ring[(i + 1) % ring.len()];
            let across = across(self.uses, self.domain, [a, b], own.place);
            let place = across.filter(|other| self.free[*other])?;
            let mut polygon = self.polygons[place].clone();
            if polygon.runs(a, b) {
                polygon.turn();
            }
            Some(Joined { place, polygon })
        })
    }

    /// Does the patch end at a free polygon within the tolerance that would fold over it?
    fn folds(&self, list: &[Joined], base: &Base, tolerance: &Tolerance) -> bool {
        let inside: Set<usize> = list.iter().map(|own| own.place).collect();
        let mut ends = list.iter().flat_map(|own| self.beside(own));
        ends.any(|joined| {
            !inside.contains(&joined.place)
                && joined.polygon.is_within(base, self.corners, tolerance)
        })
    }
}

/// The facets that are one polygon with an area, and the edges of all facets.
fn polygons_of(corners: &[Grid], domain: &Domain) -> (Vec<Polygon>, Map<[u32; 2], Uses>) {
    let mut polygons: Vec<Polygon> = Vec::new();
    let mut uses: Map<[u32; 2], Uses> = Map::default();
    for (f, facet) in (0..).zip(&domain.facets) {
        let mut place = None;
        if let ([ring], []) = (&facet.polygons[..], &facet.holes[..])
            && let Some(polygon) = Polygon::new(f, ring, corners)
        {
            place = Some(polygons.len());
            polygons.push(polygon);
        }
        for ring in &facet.polygons {
            for (k, &a) in ring.iter().enumerate() {
                let entry = uses.entry(edge(a, ring[(k + 1) % ring.len()])).or_default();
                match ring.len() {
                    2 => entry.drawn = true,
                    _ => entry.facets.push((f, place)),
                }
            }
        }
    }
    for &([a, b], _) in &domain.segments {
        uses.entry(edge(a, b)).or_default().drawn = true;
    }
    (polygons, uses)
}

/// Per facet: is it connected to an edge of an odd number of polygons?
fn open_facets(domain: &Domain, uses: &Map<[u32; 2], Uses>) -> Vec<bool> {
    let mut open = vec![false; domain.facets.len()];
    let mut beside: Vec<Vec<u32>> = vec![Vec::new(); domain.facets.len()];
    let mut stack = Vec::new();
    for edge in uses.values() {
        let odd = edge.facets.len() % 2 == 1;
        for (k, &(f, _)) in edge.facets.iter().enumerate() {
            let (g, _) = edge.facets[(k + 1) % edge.facets.len()];
            beside[f as usize].push(g);
            beside[g as usize].push(f);
            if odd && !open[f as usize] {
                open[f as usize] = true;
                stack.push(f);
            }
        }
    }
    while let Some(f) = stack.pop() {
        for &g in &beside[f as usize] {
            if !open[g as usize] {
                open[g as usize] = true;
                stack.push(g);
            }
        }
    }
    open
}

/// The polygon across an edge of polygon `k`, if the surface may continue there.
fn across(
    uses: &Map<[u32; 2], Uses>,
    domain: &Domain,
    [a, b]: [u32; 2],
    k: usize,
) -> Option<usize> {
    let uses = uses.get(&edge(a, b)).filter(|uses| !uses.drawn)?;
    let [(f, Some(p)), (g, Some(q))] = uses.facets[..] else { return None };
    let marker = |f: u32| domain.facets[f as usize].marker;
    if marker(f) != marker(g) || p == q {
        return None;
    }
    Some(if p == k { q } else { p })
}

impl Polygon {
    /// `None` for one without an area, or one that is not planar.
    fn new(facet: u32, ring: &[u32], corners: &[Grid]) -> Option<Self> {
        let origin = corners[*ring.first()? as usize];
        let at = |v: u32| minus(&corners[v as usize], &origin);
        let mut normal = [0; 3];
        for k in 2..ring.len() {
            let (u, v) = (at(ring[k - 1]), at(ring[k]));
            for (i, entry) in normal.iter_mut().enumerate() {
                let (x, y) = ((i + 1) % 3, (i + 2) % 3);
                *entry += u[x] * v[y] - u[y] * v[x];
            }
        }
        let planar = normal != [0; 3] && ring.iter().all(|&v| dot(&normal, &at(v)) == 0);
        planar.then(|| Self { facet, corners: ring.to_vec(), normal })
    }

    /// Turns it over.
    fn turn(&mut self) {
        self.corners.reverse();
        self.normal = self.normal.map(|c| -c);
    }

    /// Does the outline run from `a` to `b`?
    fn runs(&self, a: u32, b: u32) -> bool {
        let ring = &self.corners;
        (0..ring.len()).any(|k| ring[k] == a && ring[(k + 1) % ring.len()] == b)
    }

    /// Does it belong to the patch of `base`?
    fn fits(&self, base: &Base, corners: &[Grid], tolerance: &Tolerance) -> bool {
        self.normal[base.axis] > 0
            && self.is_within(base, corners, tolerance)
            && (self.is_near(&base.normal) || self.is_needle(corners, tolerance))
    }

    /// Are its corners within the tolerance of a plane?
    fn is_within(&self, base: &Base, corners: &[Grid], tolerance: &Tolerance) -> bool {
        let square = dot(&base.normal, &base.normal);
        let height = |v: u32| base.height(&corners[v as usize]);
        self.corners.iter().all(|&v| tolerance.holds(height(v), square))
    }

    /// Is the normal within 60° of another one?
    fn is_near(&self, other: &[i128; 3]) -> bool {
        let product = dot(&self.normal, other);
        // Twice the product against the product of the lengths, all squared.
        let big = |x: i128| BigInt::from(x);
        let squares = big(dot(&self.normal, &self.normal)) * big(dot(other, other));
        product > 0 && big(product) * big(product) * 4 >= squares
    }

    /// Is twice its area at most the tolerance times its longest side?
    fn is_needle(&self, corners: &[Grid], tolerance: &Tolerance) -> bool {
        let ring = &self.corners;
        let side = |k: usize| {
            let [a, b] = [ring[k], ring[(k + 1) % ring.len()]].map(|v| &corners[v as usize]);
            let d = minus(b, a);
            dot(&d, &d)
        };
        let longest = (0..ring.len()).map(side).max().unwrap_or(0);
        // |n| ≤ tolerance · side: the root of the one against that of the other.
        let square = BigInt::from(dot(&self.normal, &self.normal));
        let right = &tolerance.mantissa * &tolerance.mantissa * BigInt::from(longest);
        match tolerance.exponent {
            e @ 0.. => square <= right << (2 * e),
            e => square << (-2 * e) <= right,
        }
    }
}
