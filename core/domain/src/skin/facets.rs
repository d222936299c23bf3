//! Boundary triangles that are in one plane exactly make one facet: its outlines, cut at the
//! corners of the domain, and what else is drawn in it.

use super::{Face, NONE, Skin};
use crate::check::contact::sides_of;
use crate::straight::Line;
use crate::triangulate::{self, sorted};
use crate::vector::{cross, dominant, dot, minus};
use crate::{Domain, Facet, Lattice};
use ltbw_exact::Point;
use ltbw_exact::predicates::{Sign, collinear, orient2d, orient3d};
use std::collections::{HashMap, HashSet};

/// The segments of a boundary: edges where no facet continues.
struct Segments {
    edges: HashSet<[u32; 2]>,
    /// The vertices at which they end: all but those between two in one line.
    corners: HashSet<u32>,
    /// The other ends of those at a vertex.
    at: HashMap<u32, Vec<u32>>,
}

impl Skin<'_> {
    /// The boundary as wide facets; none if it cannot be told so.
    pub(super) fn wide_facets(&self) -> Option<Domain> {
        let mut at_edge: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
        for (f, face) in self.faces.iter().enumerate() {
            sides_of(face.corners)
                .iter()
                .for_each(|side| at_edge.entry(sorted(*side)).or_default().push(f));
        }
        let continues = |own: &[usize]| match own {
            &[f, g] => self.continues(&self.faces[f], &self.faces[g]),
            _ => false,
        };
        let edges: HashSet<[u32; 2]> =
            at_edge.iter().filter(|(_, own)| !continues(own)).map(|(edge, _)| *edge).collect();
        let mut segments = self.segments(edges);
        self.part(&mut segments);
        let mut corners: Vec<u32> = segments.corners.iter().copied().collect();
        corners.sort_unstable();
        let mut number = vec![NONE; self.points.len()];
        (0..).zip(&corners).for_each(|(k, &v)| number[v as usize] = k);
        let [mut others, _] = self.vertices();
        others.retain(|v| !segments.corners.contains(v));
        let (vertices, points) = (self.places(&corners), self.places(&others));
        let mut domain = Domain { vertices, points, ..self.seeds() };
        let mut seen = vec![false; self.faces.len()];
        for first in 0..self.faces.len() {
            if std::mem::replace(&mut seen[first], true) {
                continue;
            }
            let (mut group, mut next) = (vec![first], 0);
            while let Some(&f) = group.get(next) {
                next += 1;
                for side in sides_of(self.faces[f].corners) {
                    let own = &at_edge[&sorted(side)];
                    if segments.edges.contains(&sorted(side)) {
                        continue;
                    }
                    group.extend(own.iter().filter(|&&g| !std::mem::replace(&mut seen[g], true)));
                }
            }
            domain.facets.push(self.facet(&group, &segments, &number)?);
        }
        Some(domain)
    }

    /// Does a facet go on from one triangle to another at an edge that no third one has?
    fn continues(&self, one: &Face, other: &Face) -> bool {
        let [a, b, c] = one.corners.map(|v| self.at(v));
        let apex = other.corners.into_iter().find(|v| !one.corners.contains(v));
        one.marker == other.marker
            && one.is_outer == other.is_outer
            && apex.is_some_and(|v| orient3d(a, b, c, self.at(v)) == Sign::Zero)
    }

    fn segments(&self, edges: HashSet<[u32; 2]>) -> Segments {
        let mut at: HashMap<u32, Vec<u32>> = HashMap::new();
        for &[a, b] in &edges {
            at.entry(a).or_default().push(b);
            at.entry(b).or_default().push(a);
        }
        let is_between = |v: u32, own: &[u32]| match own {
            &[a, b] => {
                let [p, a, b] = [v, a, b].map(|v| self.at(v));
                collinear(a, p, b) && dot(&minus(a, p), &minus(b, p)) < 0.0
            }
            _ => false,
        };
        let ends = at.iter().filter(|(v, own)| !is_between(**v, own)).map(|(v, _)| *v).collect();
        Segments { edges, corners: ends, at }
    }

    /// Ends segments in one line at further vertices, as few as there have to be for all others to
    /// have whole parameters: where a vertex of the domain is between two in one line. Where that
    /// is not to be had they stay.
    fn part(&self, segments: &mut Segments) {
        let ends: Vec<u32> = segments.corners.iter().copied().collect();
        let corners = Domain { vertices: self.places(&ends), ..Domain::default() };
        let Ok(lattice) = Lattice::of(&corners) else { return };
        let mut more = Vec::new();
        for &start in &ends {
            for &next in segments.at.get(&start).into_iter().flatten() {
                let chain = segments.chain(start, next);
                // Each from one of its ends.
                if chain.len() > 2 && chain.last() > chain.first() {
                    more.extend(self.breaks(&chain, &lattice));
                }
            }
        }
        segments.corners.extend(more);
    }

    /// The vertices between the ends of a chain at which it is to be cut.
    fn breaks(&self, chain: &[u32], lattice: &Lattice) -> Vec<u32> {
        let steps: Vec<_> = chain.iter().map(|&v| lattice.steps(self.at(v))).collect();
        let fine: Option<Vec<Point>> = chain
            .iter()
            .map(|&v| Some(lattice.fine_steps(self.at(v))?.map(|c| c as f64)))
            .collect();
        let Some(fine) = fine else { return Vec::new() };
        // For each vertex on the lattice the fewest segments up to it, and the start of the last.
        let mut best: Vec<Option<(usize, usize)>> = vec![None; chain.len()];
        best[0] = Some((0, 0));
        for end in 1..chain.len() {
            let Some(to) = steps[end] else { continue };
            for start in 0..end {
                let (Some(from), Some((count, _))) = (steps[start], best[start]) else { continue };
                let line = Line { from, to };
                let is_better = best[end].is_none_or(|(other, _)| count + 1 < other);
                let inner = &fine[start + 1..end];
                if is_better && inner.iter().all(|p| line.parameter(p).is_some()) {
                    best[end] = Some((count + 1, start));
                }
            }
        }
        let (mut at, mut breaks) = (chain.len() - 1, Vec::new());
        while let Some((_, start)) = best[at].filter(|_| at > 0) {
            breaks.extend((start > 0).then(|| chain[start]));
            at = start;
        }
        breaks
    }

    /// The facet of some triangles in one plane.
    fn facet(&self, group: &[usize], segments: &Segments, number: &[u32]) -> Option<Facet> {
        let first = &self.faces[*group.first()?];
        let axis = {
            let [a, b, c] = first.corners.map(|v| self.at(v));
            dominant(&cross(&minus(b, a), &minus(c, a)))
        };
        let axes = [(axis + 1) % 3, (axis + 2) % 3];
        // The corner beyond each side, all triangles turned alike in the projection.
        let mut beyond: HashMap<[u32; 2], u32> = HashMap::new();
        for &f in group {
            let [a, b, c] = self.faces[f].corners;
            let turn = orient2d(self.at(a), self.at(b), self.at(c), axes);
            let [a, b, c] = if turn == Sign::Negative { [a, c, b] } else { [a, b, c] };
            beyond.extend([([a, b], c), ([b, c], a), ([c, a], b)]);
        }
        let is_end = |side: &[u32; 2]| {
            segments.edges.contains(&sorted(*side)) && !beyond.contains_key(&[side[1], side[0]])
        };
        let mut ends: Vec<[u32; 2]> = beyond.keys().copied().filter(is_end).collect();
        ends.sort_unstable();
        let (mut seen, mut facet) =
            (HashSet::new(), Facet { marker: first.marker, ..Facet::default() });
        for &start in &ends {
            let (mut side, mut ring) = (start, Vec::new());
            while seen.insert(side) {
                ring.push(side[0]);
                side = next(&beyond, &is_end, side)?;
            }
            for ring in simple(ring) {
                let corners = ring.iter().copied().filter(|v| segments.corners.contains(v));
                let corners: Vec<u32> = corners.collect();
                if corners.len() < 3 {
                    return None;
                }
                if self.area(&corners, axes) < 0.0 {
                    facet.holes.push(self.within(&corners)?);
                }
                facet.polygons.push(corners.iter().map(|&v| number[v as usize]).collect());
            }
        }
        // Segments with the facet on both sides.
        let mut drawn: Vec<[u32; 2]> = beyond
            .keys()
            .filter(|side| side[0] < side[1] && beyond.contains_key(&[side[1], side[0]]))
            .filter(|side| segments.edges.contains(*side))
            .map(|&side| segments.whole(side))
            .collect::<Option<_>>()?;
        drawn.sort_unstable();
        drawn.dedup();
        facet.polygons.extend(drawn.iter().map(|ends| ends.map(|v| number[v as usize]).to_vec()));
        Some(facet)
    }

    /// Twice the area of a ring in the projection, rounded.
    fn area(&self, ring: &[u32], axes: [usize; 2]) -> f64 {
        let flat = |v: u32| axes.map(|k| self.at(v)[k] - self.at(ring[0])[k]);
        let part = |k: usize| {
            let [a, b] = [flat(ring[k]), flat(ring[(k + 1) % ring.len()])];
            a[0] * b[1] - a[1] * b[0]
        };
        (0..ring.len()).map(part).sum()
    }

    /// A point inside a ring.
    fn within(&self, ring: &[u32]) -> Option<Point> {
        let vertices = self.places(ring);
        let all: Vec<u32> = (0..ring.len() as u32).collect();
        let found = triangulate::facet(&vertices, &Facet::polygon(&all, 0));
        let size = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| &vertices[v as usize]);
            let n = cross(&minus(b, a), &minus(c, a));
            dot(&n, &n)
        };
        let widest = found.triangles.iter().max_by(|a, b| size(a).total_cmp(&size(b)))?;
        let [a, b, c] = widest.map(|v| vertices[v as usize]);
        Some([0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0))
    }
}

impl Segments {
    /// The vertices from one on, along a line, up to where it ends.
    fn chain(&self, start: u32, next: u32) -> Vec<u32> {
        let mut chain = vec![start, next];
        while let [.., from, at] = chain[..] {
            let is_end = self.corners.contains(&at) || chain.len() > self.edges.len();
            let onwards = self.at.get(&at).into_iter().flatten().copied().find(|&v| v != from);
            match onwards.filter(|_| !is_end) {
                Some(next) => chain.push(next),
                None => break,
            }
        }
        chain
    }

    /// The ends of the segment that an edge is a part of, ascending.
    fn whole(&self, [a, b]: [u32; 2]) -> Option<[u32; 2]> {
        Some(sorted([*self.chain(b, a).last()?, *self.chain(a, b).last()?]))
    }
}

/// The side of the outline that follows another one, around the inside at its end.
fn next(
    beyond: &HashMap<[u32; 2], u32>,
    is_end: &impl Fn(&[u32; 2]) -> bool,
    side: [u32; 2],
) -> Option<[u32; 2]> {
    let mut inner = side;
    for _ in 0..beyond.len() {
        let onwards = [inner[1], *beyond.get(&inner)?];
        if is_end(&onwards) {
            return Some(onwards);
        }
        inner = [onwards[1], onwards[0]];
    }
    None
}

/// A ring in parts that name each vertex once.
fn simple(ring: Vec<u32>) -> Vec<Vec<u32>> {
    let (mut parts, mut open) = (Vec::new(), Vec::<u32>::new());
    for v in ring {
        if let Some(k) = open.iter().position(|&w| w == v) {
            parts.push(open.split_off(k));
        }
        open.push(v);
    }
    parts.push(open);
    parts.retain(|part| !part.is_empty());
    parts
}
