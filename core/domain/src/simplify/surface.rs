//! The surface that is simplified: triangles, and for each vertex those around it.
//!
//! Vertices are numbered by their coordinates, so that nothing depends on the order of the input.

use super::fan::normal;
use crate::vector::dot;
use ltbw_exact::Point;

/// The cosine of the angle between the normals of two triangles beyond which their edge is sharp.
const SHARP: f64 = 0.75;

/// The corners of a triangle that is gone.
const GONE: [u32; 3] = [u32::MAX; 3];

/// The triangles of a domain.
pub(super) struct Surface {
    /// Vertices, ascending by their coordinates.
    pub(super) points: Vec<Point>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) markers: Vec<i32>,
    /// Of each triangle: what the first surface is from it, and it from the first surface.
    pub(super) bounds: Vec<[f64; 2]>,
    /// Of each vertex the triangles that have it.
    pub(super) stars: Vec<Vec<u32>>,
    /// Of each vertex others that an edge of something else than a triangle connects it to; those
    /// of vertices with such neighbours stay.
    pub(super) beside: Vec<Vec<u32>>,
    /// The tolerance.
    pub(super) most: f64,
}

/// The triangles around a vertex that follow each other over edges that are no features.
#[derive(Debug)]
pub(super) struct Sector {
    /// The corners opposite to the vertex, in their order.
    pub(super) ring: Vec<u32>,
    /// The triangles between them.
    pub(super) triangles: Vec<u32>,
    /// They go round the vertex.
    pub(super) closed: bool,
}

/// The triangles around a vertex.
#[derive(Debug)]
pub(super) struct Star {
    pub(super) sectors: Vec<Sector>,
    /// The other ends of its two feature edges, if it has such.
    pub(super) along: Option<[u32; 2]>,
}

impl Surface {
    pub(super) fn at(&self, v: u32) -> &Point {
        &self.points[v as usize]
    }

    pub(super) fn is_gone(&self, t: u32) -> bool {
        self.triangles[t as usize] == GONE
    }

    pub(super) fn corners(&self, t: u32) -> [&Point; 3] {
        self.triangles[t as usize].map(|v| self.at(v))
    }

    /// The other two corners of a triangle.
    pub(super) fn opposite(&self, t: u32, v: u32) -> [u32; 2] {
        let [a, b, c] = self.triangles[t as usize];
        if a == v {
            [b, c]
        } else if b == v {
            [c, a]
        } else {
            [a, b]
        }
    }

    /// Are two vertices connected?
    pub(super) fn are_neighbours(&self, v: u32, w: u32) -> bool {
        let has = |t: &u32| self.triangles[*t as usize].contains(&w);
        self.stars[v as usize].iter().any(has) || self.beside[v as usize].contains(&w)
    }

    /// The vertices that triangles connect a vertex to, ascending, and how many triangles do each.
    fn neighbours(&self, v: u32) -> Vec<(u32, usize)> {
        let star = self.stars[v as usize].iter();
        let mut all: Vec<u32> = star.flat_map(|&t| self.opposite(t, v)).collect();
        all.sort_unstable();
        all.chunk_by(u32::eq).map(|same| (same[0], same.len())).collect()
    }

    /// The triangles around a vertex, in sectors, if it may go: no edge of another kind ends there,
    /// and one sector goes round it or all are between the same two feature edges.
    pub(super) fn star(&self, v: u32) -> Option<Star> {
        let own = &self.stars[v as usize];
        if own.is_empty() || own.len() > MOST || !self.beside[v as usize].is_empty() {
            return None;
        }
        let mut features = Vec::new();
        for (w, count) in self.neighbours(v) {
            if count != 2 || self.is_sharp(v, w) {
                features.push(w);
                if features.len() > 2 {
                    return None;
                }
            }
        }
        let mut left = own.clone();
        let mut sectors = Vec::new();
        while let Some(&first) = left.first() {
            let start = match features.first() {
                Some(&w) => {
                    // A triangle at one of the two ends; others cannot be reached.
                    let at_end = |t: &&u32| self.triangles[**t as usize].contains(&w);
                    *left.iter().find(at_end)?
                }
                None => first,
            };
            sectors.push(self.sector(v, start, &features, &mut left)?);
        }
        let along = match features[..] {
            [] if sectors.len() == 1 && sectors[0].closed => None,
            [a, b] if sectors.iter().all(|s| !s.closed && s.ring.last() == Some(&b)) => {
                Some([a, b])
            }
            _ => return None,
        };
        Some(Star { sectors, along })
    }

    /// The sector that a triangle is in, out of those that are left: from the first feature, or
    /// all round.
    fn sector(&self, v: u32, start: u32, features: &[u32], left: &mut Vec<u32>) -> Option<Sector> {
        let [mut first, mut next] = self.opposite(start, v);
        if features.first() == Some(&next) {
            (first, next) = (next, first);
        }
        let mut sector = Sector { ring: vec![first, next], triangles: vec![start], closed: false };
        left.retain(|&t| t != start);
        while !features.contains(&next) && next != first {
            let beside = |t: &&u32| self.triangles[**t as usize].contains(&next);
            let t = *left.iter().find(beside)?;
            left.retain(|&u| u != t);
            let [a, b] = self.opposite(t, v);
            next = if a == next { b } else { a };
            sector.ring.push(next);
            sector.triangles.push(t);
        }
        if next == first {
            sector.ring.pop();
            sector.closed = true;
        }
        Some(sector)
    }

    /// Is the edge of two triangles a feature: are their markers others, or do they meet at an
    /// angle, and neither is lower than the tolerance?
    fn is_sharp(&self, v: u32, w: u32) -> bool {
        let (v, w) = (v.min(w), v.max(w));
        let star = self.stars[v as usize].iter();
        let mut both = star.filter(|t| self.triangles[**t as usize].contains(&w));
        let (Some(&one), Some(&other)) = (both.next(), both.next()) else { return true };
        if self.markers[one as usize] != self.markers[other as usize] {
            return true;
        }
        let apex = |t: u32| {
            let [a, b] = self.opposite(t, v);
            self.at(if a == w { b } else { a })
        };
        let (p, q) = (self.at(v), self.at(w));
        let (m, n) = (normal([p, q, apex(one)]), normal([q, p, apex(other)]));
        let (mm, nn) = (dot(&m, &m), dot(&n, &n));
        let edge = crate::vector::distance2(p, q);
        let low = self.most * self.most * edge;
        let along = dot(&m, &n);
        (along < 0.0 || along * along < SHARP * SHARP * mm * nn) && mm > low && nn > low
    }

    /// Puts one vertex in place of another, and gives the new triangles their bounds.
    pub(super) fn collapse(&mut self, v: u32, w: u32) {
        for t in std::mem::take(&mut self.stars[v as usize]) {
            let corners = self.triangles[t as usize];
            if corners.contains(&w) {
                self.triangles[t as usize] = GONE;
                let others = corners.into_iter().filter(|&u| u != v);
                others.for_each(|u| self.stars[u as usize].retain(|&other| other != t));
            } else {
                self.triangles[t as usize] = corners.map(|u| if u == v { w } else { u });
                self.stars[w as usize].push(t);
            }
        }
    }
}

/// The most triangles around a vertex that may go.
const MOST: usize = 64;
