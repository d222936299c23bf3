//! The pieces into which the polygons of a facet divide its plane.
//!
//! A facet of one polygon is one piece. Otherwise its edges make a plane graph, of which every
//! bounded face in which no hole point lies is a piece: half-edges are sorted around their vertices
//! and followed, always to the next one clockwise, which goes around the face on their left.

use super::super::facet::FlatFacet;
use super::super::whole::{Units, Whole, twice_area};
use super::super::{Plc, PlcFacet, edge};
use super::hom::Hom;
use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;
use std::collections::HashMap;

/// A connected part of a facet.
#[derive(Debug)]
pub(super) struct Piece {
    pub(super) facet: u32,
    /// Its normal; the component along the axis of projection is positive.
    pub(super) normal: Whole,
    /// The axes that are left in the projection.
    pub(super) axes: [usize; 2],
    /// A corner.
    pub(super) origin: u32,
    /// The edges around it and around holes in it, directed so that it is on their left, seen
    /// against the normal. An edge that ends inside is there in both directions.
    pub(super) rim: Vec<[u32; 2]>,
    /// Its box: of each axis the least and the largest coordinate.
    pub(super) bounds: [[i128; 2]; 3],
}

/// Directed edges.
type Rim = Vec<[u32; 2]>;

/// A facet in projection.
struct Flat<'a> {
    facet: u32,
    normal: Whole,
    axes: [usize; 2],
    corners: &'a [Whole],
}

impl Piece {
    /// The pieces of all facets; `None` if one has no area.
    pub(super) fn all(plc: &Plc, corners: &[Whole], units: &Units) -> Option<Vec<Self>> {
        let mut pieces = Vec::with_capacity(plc.facets.len());
        for (f, facet) in (0..).zip(&plc.facets) {
            let flat = Flat::new(f, facet, corners)?;
            match (&facet.polygons[..], &facet.holes[..]) {
                ([ring], []) if ring.len() > 2 => pieces.push(flat.piece(flat.around(ring))),
                _ => flat.divide(facet, units, &mut pieces),
            }
        }
        Some(pieces)
    }

    /// Where a point of the plane is: `None` on an edge.
    pub(super) fn holds(&self, corners: &[Whole], p: &Hom) -> Option<bool> {
        encloses(&self.rim, corners, self.axes, p)
    }
}

/// Do these edges enclose a point, an odd number of times? `None` on an edge.
fn encloses(rim: &[[u32; 2]], corners: &[Whole], axes: [usize; 2], p: &Hom) -> Option<bool> {
    let mut inside = false;
    let [x, y] = axes.map(|k| &p.x[k]);
    for &ends in rim {
        let [a, b] = ends.map(|v| axes.map(|k| &p.w * corners[v as usize][k]));
        let (above_a, above_b) = (a[1] > *y, b[1] > *y);
        let (low, high) = if a[1] < b[1] { (&a[1], &b[1]) } else { (&b[1], &a[1]) };
        if *y < *low || *y > *high {
            continue;
        }
        let side = (&b[0] - &a[0]) * (y - &a[1]) - (&b[1] - &a[1]) * (x - &a[0]);
        if side.sign() == Sign::NoSign {
            let (left, right) = if a[0] < b[0] { (&a[0], &b[0]) } else { (&b[0], &a[0]) };
            if *left <= *x && *x <= *right {
                return None;
            }
        }
        if above_a != above_b {
            inside ^= (side.sign() == Sign::Plus) == above_b;
        }
    }
    Some(inside)
}

impl<'a> Flat<'a> {
    fn new(facet: u32, polygons: &PlcFacet, corners: &'a [Whole]) -> Option<Self> {
        let at = |v: u32| corners[v as usize];
        let plane = FlatFacet::new(&polygons.polygons, &[], at)?;
        let [o, a, b] = plane.frame.map(at);
        let (p, q) = ([0, 1, 2].map(|k| a[k] - o[k]), [0, 1, 2].map(|k| b[k] - o[k]));
        let normal = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| p[i] * q[j] - p[j] * q[i]);
        let axis = 3 - plane.axes[0] - plane.axes[1];
        let normal = if normal[axis] < 0 { normal.map(|c| -c) } else { normal };
        Some(Self { facet, normal, axes: plane.axes, corners })
    }

    fn at(&self, v: u32) -> [i128; 2] {
        self.axes.map(|k| self.corners[v as usize][k])
    }

    /// The ring as directed edges, counterclockwise in the projection.
    fn around(&self, ring: &[u32]) -> Vec<[u32; 2]> {
        let n = ring.len();
        let edges: Vec<[u32; 2]> = (0..n).map(|k| [ring[k], ring[(k + 1) % n]]).collect();
        match self.area(&edges).sign() {
            Sign::Minus => edges.into_iter().map(|[a, b]| [b, a]).collect(),
            _ => edges,
        }
    }

    /// Twice the signed area that closed edges go around.
    fn area(&self, edges: &[[u32; 2]]) -> BigInt {
        let Some(&[o, _]) = edges.first() else { return BigInt::ZERO };
        let triangle = |[a, b]: [u32; 2]| twice_area(self.at(o), self.at(a), self.at(b));
        edges.iter().map(|&edge| BigInt::from(triangle(edge))).sum()
    }

    fn piece(&self, rim: Vec<[u32; 2]>) -> Piece {
        let bounds = [0, 1, 2].map(|k| {
            let all = || rim.iter().flatten().map(|&v| self.corners[v as usize][k]);
            [all().min().unwrap_or(0), all().max().unwrap_or(0)]
        });
        let origin = rim.first().map_or(0, |edge| edge[0]);
        Piece { facet: self.facet, normal: self.normal, axes: self.axes, origin, rim, bounds }
    }

    /// The pieces of a facet of several polygons, or with holes.
    fn divide(&self, facet: &PlcFacet, units: &Units, pieces: &mut Vec<Piece>) {
        let mut halves: Vec<[u32; 2]> = Vec::new();
        for ring in &facet.polygons {
            for (k, &a) in ring.iter().enumerate() {
                let b = ring[(k + 1) % ring.len()];
                halves.extend([[a, b], [b, a]]);
            }
        }
        halves.sort_unstable();
        halves.dedup();
        let (faces, rims): (Vec<_>, Vec<_>) = self
            .cycles(&halves)
            .into_iter()
            .map(|cycle| (self.area(&cycle), cycle))
            .partition(|(area, _)| area.sign() == Sign::Plus);
        let mut faces: Vec<(BigInt, Rim, Rim)> =
            faces.into_iter().map(|(area, cycle)| (area, cycle, Vec::new())).collect();
        // From the smallest on: the first face around the rim of a part is the one it lies in.
        faces.sort_by(|p, q| p.0.cmp(&q.0));
        let parts = parts(&halves);
        for (_, rim) in rims {
            let v = rim[0][0];
            let at = Hom::whole(self.corners[v as usize]);
            let around = |cycle: &[[u32; 2]]| {
                parts[&cycle[0][0]] != parts[&v]
                    && encloses(cycle, self.corners, self.axes, &at) == Some(true)
            };
            if let Some(face) = faces.iter_mut().find(|face| around(&face.1)) {
                face.2.extend(rim);
            }
        }
        let holes: Vec<Hom> = facet.holes.iter().map(|p| Hom::of(p, units)).collect();
        for (_, mut rim, inner) in faces {
            rim.extend(inner);
            let is_in = |p: &Hom| encloses(&rim, self.corners, self.axes, p) == Some(true);
            if !holes.iter().any(is_in) {
                pieces.push(self.piece(rim));
            }
        }
    }

    /// The closed walks around the faces of the graph, on whose left the face is.
    fn cycles(&self, halves: &[[u32; 2]]) -> Vec<Vec<[u32; 2]>> {
        // Half-edges are sorted by their first vertex: those at a vertex are a range of them.
        let mut around: Vec<[u32; 2]> = Vec::with_capacity(halves.len());
        for star in halves.chunk_by(|a, b| a[0] == b[0]) {
            let mut star = star.to_vec();
            star.sort_by(|p, q| self.by_angle(p, q));
            around.extend(star);
        }
        let place: HashMap<[u32; 2], usize> =
            around.iter().enumerate().map(|(k, half)| (*half, k)).collect();
        let next = |[a, b]: [u32; 2]| {
            let twin = place[&[b, a]];
            let is_same = |k: usize| around[k][0] == b;
            // The one before it around its first vertex, or the last there.
            match twin.checked_sub(1).filter(|&k| is_same(k)) {
                Some(k) => around[k],
                None => {
                    let end = (twin..around.len()).take_while(|&k| is_same(k)).last();
                    around[end.unwrap_or(twin)]
                }
            }
        };
        let mut done = vec![false; around.len()];
        let mut cycles = Vec::new();
        for &first in &around {
            let (mut half, mut cycle) = (first, Vec::new());
            // Every half-edge is in one walk.
            while !std::mem::replace(&mut done[place[&half]], true) {
                cycle.push(half);
                half = next(half);
            }
            if !cycle.is_empty() {
                cycles.push(cycle);
            }
        }
        cycles
    }

    /// The order of two half-edges counterclockwise around their common first vertex.
    fn by_angle(&self, p: &[u32; 2], q: &[u32; 2]) -> Ordering {
        let o = self.at(p[0]);
        let way = |v: u32| {
            let at = self.at(v);
            [at[0] - o[0], at[1] - o[1]]
        };
        let (u, v) = (way(p[1]), way(q[1]));
        let is_upper = |d: [i128; 2]| d[1] > 0 || (d[1] == 0 && d[0] > 0);
        is_upper(v).cmp(&is_upper(u)).then_with(|| 0.cmp(&(u[0] * v[1] - u[1] * v[0])))
    }
}

/// For each vertex of a graph the part that it is in, by its least vertex.
fn parts(halves: &[[u32; 2]]) -> HashMap<u32, u32> {
    let mut part: HashMap<u32, u32> = HashMap::new();
    for &[first, _] in halves {
        let mut stack = vec![first];
        // Every vertex is given its part once.
        while let Some(v) = stack.pop() {
            if part.contains_key(&v) {
                continue;
            }
            part.insert(v, first);
            let from = halves.partition_point(|half| half[0] < v);
            stack.extend(halves[from..].iter().take_while(|half| half[0] == v).map(|half| half[1]));
        }
    }
    part
}

/// The edge of a half-edge, and whether it runs from the smaller vertex to the larger.
pub(super) fn undirected([a, b]: [u32; 2]) -> ([u32; 2], bool) {
    (edge(a, b), a < b)
}
