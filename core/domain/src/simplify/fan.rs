//! The bound on how far a surface moves when a fan of triangles gets another apex.
//!
//! Both fans are cut into strips along the spokes of the other one: a strip of an old triangle
//! belongs to one new triangle, and a strip of a new triangle to one old triangle. A triangle is
//! convex, so no point of a strip is farther from it than the farthest corner of the strip. Where
//! spokes cross is rounded; whatever comes of that, the strips of a triangle cover it, so the bound
//! holds. Corners and distances are rounded by less than [`SLACK`] of the largest coordinate, which
//! is added to every distance.

use crate::vector::{cross, dot, minus};
use ltbw_exact::Point;
use std::cmp::Ordering;

/// The part of the largest coordinate that roundings of a corner and its distance stay below: fewer
/// than 64 of them, of 2^-53 each.
pub(super) const SLACK: f64 = 1.0 / (1u64 << 46) as f64;

/// A fan before and after.
///
/// Its triangles are `old, ring[i], ring[i + 1]`, and `ring[0], ring[j], ring[j + 1]` afterwards,
/// for `j` from 1 on. A closed fan goes on to the first of the ring.
#[derive(Debug)]
pub(super) struct Fan<'a> {
    pub(super) old: Point,
    pub(super) ring: &'a [Point],
    pub(super) closed: bool,
    /// Of each old triangle: what the first surface is from it, and it from the first surface.
    pub(super) bounds: &'a [[f64; 2]],
    /// The slack that is added to every distance.
    pub(super) slack: f64,
}

/// Places on spokes and on new edges, from 0 at the apex to 1 at the ring, where those of the other
/// fan cross them; 1 where they do not.
struct Cuts {
    count: usize,
    home: usize,
    /// The places on a spoke and on a new edge, for each spoke and edge.
    places: Vec<[f64; 2]>,
}

impl Fan<'_> {
    fn corners(&self) -> usize {
        self.ring.len()
    }

    /// The number of old triangles.
    fn old_count(&self) -> usize {
        if self.closed { self.corners() } else { self.corners() - 1 }
    }

    /// A corner of the ring; the first one again after the last.
    fn at(&self, k: usize) -> &Point {
        &self.ring[k % self.corners()]
    }

    fn new_triangle(&self, j: usize) -> [&Point; 3] {
        [&self.ring[0], self.at(j), self.at(j + 1)]
    }

    fn old_triangle(&self, i: usize) -> [&Point; 3] {
        [&self.old, self.at(i), self.at(i + 1)]
    }

    /// The triangles before.
    pub(super) fn old_triangles(&self) -> impl Iterator<Item = [&Point; 3]> {
        (0..self.old_count()).map(|i| self.old_triangle(i))
    }

    /// The triangles afterwards.
    pub(super) fn new_triangles(&self) -> impl Iterator<Item = [&Point; 3]> {
        (1..self.corners() - 1).map(|j| self.new_triangle(j))
    }

    /// The sum of the normals of the old triangles, twice as long as their area.
    pub(super) fn normal(&self) -> Point {
        self.old_triangles().map(normal).fold([0.0; 3], |sum, n| [0, 1, 2].map(|k| sum[k] + n[k]))
    }

    /// For each new triangle, from the first on: what the first surface is from it, and it from the
    /// first surface. `None` if something is farther than `most`.
    pub(super) fn moved(&self, most: f64) -> Option<Vec<[f64; 2]>> {
        let last = self.old_count() - 1;
        let own = 1..last.max(1);
        // The new triangle that has the image of the old apex in it.
        let (apart, home) = if self.closed {
            let apart = |j| (distance(&self.old, self.new_triangle(j)), j);
            own.map(apart).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?
        } else {
            (distance(&self.old, self.new_triangle(last)), last)
        };
        if apart + self.slack > most {
            return None;
        }
        let image = match self.closed {
            true => nearest(&self.old, self.new_triangle(home)),
            false => nearest(&self.old, [&self.ring[0], &self.ring[0], self.at(last + 1)]),
        };
        let cuts = self.cuts(&image, home);
        let ends = if self.closed { last } else { last + 1 };
        let mut found = vec![[0.0_f64; 2]; ends - 1];
        let mut add = |way: usize, pair: [usize; 2], far: f64| {
            let [old, new] = pair;
            let bound = &mut found[new - 1][way];
            *bound = bound.max(self.bounds[old][way] + far + self.slack);
            *bound <= most
        };
        for i in 0..=last {
            for j in strips_of_old(i, home, self.corners()) {
                let triangle = self.new_triangle(j);
                let far = [i, i + 1].map(|s| {
                    let on = |place| self.on(&self.old, s, place, triangle);
                    let [from, to] = cuts.on_spoke(s, j);
                    on(from).max(on(to))
                });
                if !add(0, [i, j], far[0].max(far[1])) {
                    return None;
                }
            }
        }
        for j in 1..ends {
            for i in 0..=last {
                let triangle = self.old_triangle(i);
                let far = if j == home {
                    let exit = |s| distance(&self.exit(s, &cuts), triangle);
                    exit(i).max(exit(i + 1)).max(distance(&image, triangle))
                } else if if j < home { i <= j } else { i >= j } {
                    let far = [j, j + 1].map(|e| {
                        let on = |place| self.on(&self.ring[0], e, place, triangle);
                        let [from, to] = cuts.on_edge(e, i);
                        on(from).max(on(to))
                    });
                    far[0].max(far[1])
                } else {
                    continue;
                };
                if !add(1, [i, j], far) {
                    return None;
                }
            }
        }
        Some(found)
    }

    /// The distance of a place on the edge from an apex to a corner of the ring.
    fn on(&self, apex: &Point, corner: usize, place: f64, triangle: [&Point; 3]) -> f64 {
        let end = self.at(corner);
        if place >= 1.0 {
            // A corner of the triangle, nearly always.
            return if triangle.contains(&end) { 0.0 } else { distance(end, triangle) };
        }
        distance(&between(apex, end, place), triangle)
    }

    /// Where the spokes cross the new edges, in a plane across the fan's normal.
    fn cuts(&self, image: &Point, home: usize) -> Cuts {
        let axes = across(&self.normal());
        let flat = |p: &Point| axes.map(|axis| dot(&axis, &minus(p, &self.ring[0])));
        let count = self.corners();
        let middle = flat(if self.closed { &self.old } else { image });
        let mut cuts = Cuts { count, home, places: vec![[1.0; 2]; (count + 1) * count] };
        // Down from the home, spokes cross edges with larger numbers; up from it, smaller ones.
        for s in 1..count {
            let mut least = 0.0_f64;
            let mut cross = |e: usize| {
                let [place, along] = crossing(middle, flat(self.at(s)), flat(self.at(e)));
                least = least.max(place);
                *cuts.at(s, e) = [least, along];
            };
            match s <= home {
                true => (s + 1..=home).rev().for_each(&mut cross),
                false => (home + 1..s).for_each(&mut cross),
            }
        }
        for e in 1..count {
            let mut least = 0.0_f64;
            let mut rise = |s: usize| {
                let place = cuts.at(s, e);
                least = least.max(place[1]);
                place[1] = least;
            };
            match e <= home {
                true => (1..e).for_each(&mut rise),
                false => (e + 1..count).rev().for_each(&mut rise),
            }
        }
        cuts
    }

    /// Where a spoke leaves the new triangle that has the image of the old apex.
    fn exit(&self, spoke: usize, cuts: &Cuts) -> Point {
        let (spoke, home) = (spoke % self.corners(), cuts.home);
        let edge = if spoke <= home { home } else { home + 1 };
        match spoke {
            0 => self.ring[0],
            _ if spoke == home || spoke == home + 1 => self.ring[spoke],
            _ => between(&self.ring[0], self.at(edge), cuts.places[edge * cuts.count + spoke][1]),
        }
    }
}

/// The new triangles that an old one is cut into, of a fan with this number of corners on its ring.
fn strips_of_old(i: usize, home: usize, corners: usize) -> std::ops::RangeInclusive<usize> {
    if i < home { i.max(1)..=home } else { home..=i.min(corners - 2) }
}

impl Cuts {
    fn at(&mut self, spoke: usize, edge: usize) -> &mut [f64; 2] {
        &mut self.places[edge * self.count + spoke]
    }

    /// The part of a spoke in a new triangle.
    fn on_spoke(&self, spoke: usize, j: usize) -> [f64; 2] {
        let (spoke, home) = (spoke % self.count, self.home);
        let place = |e: usize| self.places[e * self.count + spoke][0];
        match j.cmp(&home) {
            // The first corner of the ring is one of all new triangles.
            Ordering::Equal if spoke == 0 => [0.0, 1.0],
            _ if spoke == 0 => [1.0, 1.0],
            Ordering::Equal => [0.0, place(if spoke <= home { home } else { home + 1 })],
            Ordering::Less => [place(j + 1), place(j)],
            Ordering::Greater => [place(j), place(j + 1)],
        }
    }

    /// The part of a new edge in an old triangle.
    fn on_edge(&self, e: usize, i: usize) -> [f64; 2] {
        let place = |s: usize| match s % self.count {
            0 => 0.0,
            s => self.places[e * self.count + s][1],
        };
        if e <= self.home { [place(i), place(i + 1)] } else { [place(i + 1), place(i)] }
    }
}

/// Twice the area of a triangle along its normal.
pub(super) fn normal([a, b, c]: [&Point; 3]) -> Point {
    cross(&minus(b, a), &minus(c, a))
}

/// Two directions across a normal.
fn across(normal: &Point) -> [Point; 2] {
    let least = (0..3).fold(0, |k, l| if normal[l].abs() < normal[k].abs() { l } else { k });
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let first = cross(normal, &axis);
    [first, cross(normal, &first)]
}

/// A point between two.
fn between(a: &Point, b: &Point, place: f64) -> Point {
    [0, 1, 2].map(|k| a[k] + place * (b[k] - a[k]))
}

/// Where the segment from `middle` to a corner crosses that from the origin to another: the places
/// on both, from 0 to 1.
fn crossing(middle: [f64; 2], corner: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    let along = [corner[0] - middle[0], corner[1] - middle[1]];
    let det = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let all = det(other, along);
    // NaN is no place.
    let place = |x: f64| if x >= 0.0 { x.min(1.0) } else { 0.0 };
    [place(det(middle, other) / all), place(det(middle, along) / all)]
}

/// The distance of a point from a triangle, rounded.
fn distance(p: &Point, triangle: [&Point; 3]) -> f64 {
    let d = minus(p, &nearest(p, triangle));
    dot(&d, &d).sqrt()
}

/// The point of a triangle that is nearest to a point, up to rounding.
pub(super) fn nearest(p: &Point, [a, b, c]: [&Point; 3]) -> Point {
    let (ab, ac) = (minus(b, a), minus(c, a));
    let n = cross(&ab, &ac);
    let nn = dot(&n, &n);
    if nn > 0.0 {
        let ap = minus(p, a);
        let v = dot(&cross(&ap, &ac), &n) / nn;
        let w = dot(&cross(&ab, &ap), &n) / nn;
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            return [0, 1, 2].map(|k| a[k] + v * ab[k] + w * ac[k]);
        }
    }
    let on = |p: &Point, a: &Point, b: &Point| {
        let along = minus(b, a);
        let place = dot(&minus(p, a), &along) / dot(&along, &along);
        let foot = between(a, b, if place > 0.0 { place.min(1.0) } else { 0.0 });
        let d = minus(p, &foot);
        (dot(&d, &d), foot)
    };
    let feet = [on(p, a, b), on(p, b, c), on(p, c, a)];
    let best = feet.iter().fold(&feet[0], |best, foot| if foot.0 < best.0 { foot } else { best });
    best.1
}
