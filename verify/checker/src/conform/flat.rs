//! Which facets are coplanar within the tolerance of the domain: patches.
//!
//! Facets of one polygon are put into patches in the order of falling area (ties by the coordinates
//! of their corners, sorted). A patch spreads over edges of exactly two polygons of one marker on
//! which no segment lies. A polygon joins if its corners are within the tolerance of the patch's
//! plane, if its normal is within 60° of the plane's or it is lower than the tolerance, and if its
//! area in the projection along the largest entry of the plane's normal is positive. The plane is
//! that of the first polygon; then, as long as the patch grows and at most eight times, the one
//! through the same corner, the least of the first polygon, that is normal to the sum of all
//! normals, shortened to 52 bits. Polygons of one plane are no patch, nor those that edges connect
//! to an edge of an odd number of polygons.

use super::patch::{Cast, Patch};
use super::slab::{Slab, big_dot, dot, minus};
use super::whole::{Units, Whole};
use super::{Plc, edge};
use crate::mesh::Point;
use num_bigint::BigInt;
use std::collections::{HashMap, HashSet, VecDeque};

/// Coordinates of the domain in its own units are below 2^40: products of three differences fit.
const LARGEST: i128 = 1 << 40;
/// The normal of a polygon, as long as twice its area; `None` if it has none or is not planar.
fn normal_of(ring: &[u32], at: &[Whole]) -> Option<Whole> {
    let first = at[*ring.first()? as usize];
    let mut sum = [0; 3];
    for pair in ring.windows(2) {
        let [u, v] = [pair[0], pair[1]].map(|v| minus(&at[v as usize], &first));
        sum[0] += u[1] * v[2] - u[2] * v[1];
        sum[1] += u[2] * v[0] - u[0] * v[2];
        sum[2] += u[0] * v[1] - u[1] * v[0];
    }
    let flat = ring.iter().all(|&v| dot(&sum, &minus(&at[v as usize], &first)) == 0);
    (sum != [0; 3] && flat).then_some(sum)
}

/// The facets at an edge of polygons, and whether a segment lies on it.
type AtEdge = HashMap<[u32; 2], (Vec<u32>, bool)>;

fn at_edges(plc: &Plc) -> AtEdge {
    let mut at: AtEdge = HashMap::new();
    for (f, facet) in (0u32..).zip(&plc.facets) {
        for ring in &facet.polygons {
            for k in 0..ring.len() {
                let entry = at.entry(edge(ring[k], ring[(k + 1) % ring.len()])).or_default();
                if ring.len() == 2 { entry.1 = true } else { entry.0.push(f) }
            }
        }
    }
    for &[a, b] in &plc.segments {
        at.entry(edge(a, b)).or_default().1 = true;
    }
    at
}

/// Which facets edges connect to an edge of an odd number of polygons.
fn leaking(plc: &Plc, at: &AtEdge) -> Vec<bool> {
    // A forest of facets, each with the root of its tree.
    let mut parent: Vec<u32> = (0..plc.facets.len() as u32).collect();
    fn root(parent: &mut [u32], mut f: u32) -> u32 {
        while parent[f as usize] != f {
            parent[f as usize] = parent[parent[f as usize] as usize];
            f = parent[f as usize];
        }
        f
    }
    for (facets, _) in at.values() {
        for pair in facets.windows(2) {
            let (a, b) = (root(&mut parent, pair[0]), root(&mut parent, pair[1]));
            parent[a as usize] = b;
        }
    }
    let mut leaks = vec![false; parent.len()];
    for (facets, _) in at.values().filter(|(facets, _)| facets.len() % 2 == 1) {
        leaks[root(&mut parent, facets[0]) as usize] = true;
    }
    (0..parent.len() as u32).map(|f| leaks[root(&mut parent, f) as usize]).collect()
}

/// The patches of a domain; `corners` are its vertices in units of the mesh. `None` if its
/// coordinates are too fine to tell.
pub(crate) fn find(plc: &Plc, corners: &[Whole]) -> Option<Vec<Patch>> {
    let tolerance = plc.flat_tolerance;
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Some(Vec::new());
    }
    // Vertices that no facet names may be points of finer coordinates: none of them is looked at.
    let mut is_named = vec![false; plc.vertices.len()];
    let named = plc.facets.iter().flat_map(|f| &f.polygons).flatten();
    named.for_each(|&v| is_named[v as usize] = true);
    let named = plc.vertices.iter().zip(&is_named).filter(|(_, is_named)| **is_named);
    let units = Units::of(&[&named.map(|(p, _)| *p).collect::<Vec<Point>>()])?;
    let whole = |(p, is_named): (&Point, &bool)| {
        if *is_named { units.whole(p) } else { Whole::default() }
    };
    let at: Vec<Whole> = plc.vertices.iter().zip(&is_named).map(whole).collect();
    if at.iter().flatten().any(|c| c.abs() > LARGEST) {
        return None;
    }
    let slab = Slab::new(tolerance, &units);
    let edges = at_edges(plc);
    let leaks = leaking(plc, &edges);
    let ring = |f: u32| &plc.facets[f as usize].polygons[0];
    let normals: Vec<Option<Whole>> = (0u32..)
        .zip(&plc.facets)
        .map(|(f, facet)| match (&facet.polygons[..], leaks[f as usize]) {
            ([ring], false) if facet.holes.is_empty() && ring.len() > 2 => normal_of(ring, &at),
            _ => None,
        })
        .collect();
    let mut order: Vec<u32> =
        (0..normals.len() as u32).filter(|&f| normals[f as usize].is_some()).collect();
    order.sort_by_cached_key(|&f| {
        let mut places: Vec<Whole> = ring(f).iter().map(|&v| at[v as usize]).collect();
        places.sort_unstable();
        (normals[f as usize].map(|n| -big_dot(&n, &n)), places)
    });
    let mut taken = vec![false; normals.len()];
    let mut patches = Vec::new();
    for first in order {
        if taken[first as usize] {
            continue;
        }
        let Some(normal) = normals[first as usize] else { continue };
        let spread = Spread { plc, at: &at, edges: &edges, normals: &normals, taken: &taken };
        let origin = ring(first).iter().map(|&v| at[v as usize]).min().unwrap_or_default();
        let mut plane = Plane { normal, origin };
        let mut list = spread.from(first, &plane, &slab);
        for _ in 0..8 {
            let fitted = Plane { normal: shortened(spread.sum(&list)), origin };
            let larger = spread.from(first, &fitted, &slab);
            if larger.len() <= list.len() {
                break;
            }
            (plane, list) = (fitted, larger);
        }
        taken[first as usize] = true;
        list.iter().for_each(|of| taken[of.facet as usize] = true);
        let own = Plane { normal, origin };
        let corner = |v: &u32| own.height(&at[*v as usize]) == BigInt::ZERO;
        if !list.iter().flat_map(|of| ring(of.facet)).all(corner) {
            let rings: Vec<&Vec<u32>> = list.iter().map(|of| ring(of.facet)).collect();
            let facets = list.iter().map(|of| of.facet).collect();
            let least = ring(first).iter().map(|&v| corners[v as usize]).min();
            let origin = least.unwrap_or_default();
            let cast = Cast { axis: plane.axis(), normal: plane.normal, origin };
            patches.push(Patch::new(facets, cast, &rings, corners));
        }
    }
    Some(patches)
}

/// A plane in units of the domain.
struct Plane {
    normal: Whole,
    origin: Whole,
}

impl Plane {
    /// The axis of the largest entry of the normal; of equal ones the first.
    fn axis(&self) -> usize {
        let n = self.normal.map(i128::abs);
        (0..3).rev().max_by_key(|&k| n[k]).unwrap_or(0)
    }

    fn height(&self, p: &Whole) -> BigInt {
        big_dot(&self.normal, &minus(p, &self.origin))
    }
}

/// A vector with 52 bits in its largest entry, rounded towards zero.
fn shortened(sum: [BigInt; 3]) -> Whole {
    let largest = sum.iter().map(BigInt::bits).max().unwrap_or(0);
    sum.map(|c| {
        let size = BigInt::from(c.magnitude().clone());
        let size = match largest.checked_sub(52) {
            Some(down) => size >> down,
            None => size << (52 - largest),
        };
        let size = i128::try_from(size).unwrap_or(0);
        if c < BigInt::ZERO { -size } else { size }
    })
}

/// A facet of a patch.
#[derive(Clone, Copy)]
struct Member {
    facet: u32,
    /// Is its normal opposite to that of the first one?
    turned: bool,
}

/// The search for the polygons of a patch.
struct Spread<'s> {
    plc: &'s Plc,
    at: &'s [Whole],
    edges: &'s AtEdge,
    normals: &'s [Option<Whole>],
    taken: &'s [bool],
}

impl Spread<'_> {
    fn ring(&self, f: u32) -> &[u32] {
        &self.plc.facets[f as usize].polygons[0]
    }

    /// The normal of a facet, or its opposite.
    fn normal(&self, f: u32, turned: bool) -> Option<Whole> {
        let n = self.normals[f as usize]?;
        Some(if turned { n.map(|c| -c) } else { n })
    }

    /// The sum of the normals.
    fn sum(&self, list: &[Member]) -> [BigInt; 3] {
        let normals = || list.iter().filter_map(|of| self.normal(of.facet, of.turned));
        [0, 1, 2].map(|k| normals().map(|n| BigInt::from(n[k])).sum())
    }

    /// Does a facet with this normal belong to the patch of `plane`, whose normal is turned the way
    /// of the first facet?
    fn joins(&self, f: u32, n: &Whole, plane: &Plane, slab: &Slab) -> bool {
        let (axis, square) = (plane.axis(), big_dot(&plane.normal, &plane.normal));
        let (along, own) = (big_dot(n, &plane.normal), big_dot(n, n));
        let near = along > BigInt::ZERO && &along * &along * 4 >= &own * &square;
        let low = || {
            let ring = self.ring(f);
            let side = |k: usize| {
                let [a, b] = [ring[k], ring[(k + 1) % ring.len()]].map(|v| self.at[v as usize]);
                big_dot(&minus(&b, &a), &minus(&b, &a))
            };
            slab.squares(&own, &(0..ring.len()).map(side).max().unwrap_or_default())
        };
        let inside = |v: &u32| slab.holds(&plane.height(&self.at[*v as usize]), &square);
        n[axis].signum() * plane.normal[axis].signum() == 1
            && self.ring(f).iter().all(inside)
            && (near || low())
    }

    /// The facets of the patch of `plane` and a first facet.
    fn from(&self, first: u32, plane: &Plane, slab: &Slab) -> Vec<Member> {
        let start = self.normal(first, false);
        if !start.is_some_and(|n| self.joins(first, &n, plane, slab)) {
            return Vec::new();
        }
        let first = Member { facet: first, turned: false };
        let mut list = vec![first];
        let mut seen = HashSet::from([first.facet]);
        let mut queue = VecDeque::from([first]);
        while let Some(Member { facet: f, turned }) = queue.pop_front() {
            let own = self.ring(f);
            for k in 0..own.len() {
                let ends = [own[k], own[(k + 1) % own.len()]];
                let Some((facets, false)) = self.edges.get(&edge(ends[0], ends[1])) else {
                    continue;
                };
                let [a, b] = facets[..] else { continue };
                let g = if a == f { b } else { a };
                let [x, y] = [a, b].map(|f| self.plc.facets[f as usize].marker);
                if x != y || self.taken[g as usize] || seen.contains(&g) {
                    continue;
                }
                let other = self.ring(g);
                let along =
                    (0..other.len()).any(|k| [other[k], other[(k + 1) % other.len()]] == ends);
                // Two polygons that run the same way along their edge are turned to each other.
                let turned = turned != along;
                let Some(n) = self.normal(g, turned) else { continue };
                if self.joins(g, &n, plane, slab) {
                    seen.insert(g);
                    list.push(Member { facet: g, turned });
                    queue.push_back(Member { facet: g, turned });
                }
            }
        }
        list
    }
}
