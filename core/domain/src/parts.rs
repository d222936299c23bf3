//! [`Parts`]: the parts of a surface whose facets go on smoothly into each other.
//!
//! Two facets are of one part if exactly two polygons meet at an edge of both and their normals
//! are less than the feature angle apart; and all that are connected so. Normals are whole vectors
//! on the lattice and the angle is the square of a cosine, so that all is decided exactly. Of a
//! needle, a triangle lower than the tolerance within which facets are coplanar, the normal means
//! nothing: it has that of the neighbour at its longest side.
//!
//! Parts are numbered from 1: the largest area first, as a single-precision number, so that parts
//! of one size are told apart by their place: the least corner of their boxes.

use crate::triangulate::sorted;
use crate::{Domain, Prepared};
use ltbw_exact::Point;
use num_bigint::BigInt;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// The feature angle of a surface where nobody asks for another one, in degrees.
pub const FEATURE_ANGLE: f64 = 40.0;

/// The largest feature angle, in degrees.
pub const LARGEST_FEATURE_ANGLE: f64 = 90.0;

/// The parts of a domain's boundary.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Parts {
    /// The marker of each facet: that of its part.
    pub markers: Vec<i32>,
    /// The parts, by their markers.
    pub list: Vec<Part>,
}

/// A part of a domain's boundary.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Its marker.
    pub marker: i32,
    /// Its facets.
    pub facets: usize,
    /// Its area, rounded.
    pub area: f64,
    /// Its box, in the coordinates of the input.
    pub low: Point,
    /// The other corner of the box.
    pub high: Point,
    /// The mean of its normals, of length 1; none where they are all round.
    pub normal: Option<Point>,
}

/// Components of a mean normal below which it is none, of the area.
const ROUND: f64 = 1e-6;

/// Needles beside each other that are looked through at most.
const CHAIN: usize = 64;

/// A vector of whole steps.
type Whole = [i128; 3];

/// A polygon: its facet, its normal as long as twice its area, and the longest side of a
/// needle.
struct Face {
    facet: usize,
    normal: Whole,
    needle: Option<[u32; 2]>,
}

/// A side of a polygon.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    edge: [u32; 2],
    face: usize,
    is_forward: bool,
}

impl Parts {
    /// The smooth parts of a domain that can be meshed, for a feature angle in degrees, at most
    /// [`LARGEST_FEATURE_ANGLE`], and the tolerance within which its facets are coplanar.
    #[must_use]
    pub fn smooth(ready: &Prepared, degrees: f64, flat_tolerance: f64) -> Self {
        let (domain, lattice) = (&ready.domain, &ready.lattice);
        let at = |v: u32| lattice.steps(&domain.vertices[v as usize]).unwrap_or_default();
        let (mut faces, mut sides) = (Vec::new(), Vec::new());
        for (facet, own) in domain.facets.iter().enumerate() {
            for ring in own.polygons.iter().filter(|ring| ring.len() > 2) {
                let corners: Vec<[i64; 3]> = ring.iter().map(|&v| at(v)).collect();
                let (normal, face) = (normal(&corners), faces.len());
                let needle = longest(ring, &corners, &normal, flat_tolerance / lattice.step());
                faces.push(Face { facet, normal, needle });
                sides.extend((0..ring.len()).map(|k| {
                    let (a, b) = (ring[k], ring[(k + 1) % ring.len()]);
                    Side { edge: sorted([a, b]), face, is_forward: a < b }
                }));
            }
        }
        sides.sort_unstable();
        straighten(&mut faces, &sides);
        let bound = Cosine::of(degrees);
        let mut groups = Groups((0..domain.facets.len()).collect());
        for [s, t] in pairs(&sides) {
            let (one, other) = (&faces[s.face], &faces[t.face]);
            if bound.is_above(&one.normal, &other.normal, is_turned([s, t])) {
                groups.join(one.facet, other.facet);
            }
        }
        let of: Vec<usize> = (0..domain.facets.len()).map(|f| groups.first(f)).collect();
        Self::numbered(ready, &of)
    }

    /// The parts that the markers of the facets are.
    #[must_use]
    pub fn marked(ready: &Prepared) -> Self {
        let markers: Vec<i32> = ready.domain.facets.iter().map(|f| f.marker).collect();
        let mut list = described(ready, &markers);
        list.iter_mut().for_each(|(marker, part)| part.marker = *marker);
        Self { markers, list: list.into_values().collect() }
    }

    /// Numbers parts by area and place; `of` is a facet of the part of each facet.
    fn numbered(ready: &Prepared, of: &[usize]) -> Self {
        let mut list: Vec<(usize, Part)> = described(ready, of).into_iter().collect();
        list.sort_by(|(_, a), (_, b)| by_area_and_place(a, b));
        let mut markers = vec![0; of.len()];
        for (marker, (first, part)) in (1..).zip(&mut list) {
            part.marker = marker;
            markers[*first] = marker;
        }
        let markers = of.iter().map(|&first| markers[first]).collect();
        Self { markers, list: list.into_iter().map(|(_, part)| part).collect() }
    }
}

/// The sides of exactly two polygons that lie on each other.
fn pairs(sides: &[Side]) -> impl Iterator<Item = [Side; 2]> {
    sides.chunk_by(|s, t| s.edge == t.edge).filter_map(|own| <[Side; 2]>::try_from(own).ok())
}

/// Do the normals of two polygons look to different sides? So they do if their sides run the same
/// way.
fn is_turned([s, t]: [Side; 2]) -> bool {
    s.is_forward == t.is_forward
}

/// Gives needles the normals of their neighbours.
fn straighten(faces: &mut [Face], sides: &[Side]) {
    let mut across = BTreeMap::new();
    for [s, t] in pairs(sides) {
        for (own, other) in [(s, t), (t, s)] {
            if faces[own.face].needle == Some(own.edge) {
                across.insert(own.face, (other.face, is_turned([s, t])));
            }
        }
    }
    let normals: Vec<(usize, Whole)> = across
        .keys()
        .filter_map(|&needle| {
            let (mut face, mut turned) = (needle, false);
            for _ in 0..CHAIN {
                let &(next, turns) = across.get(&face)?;
                (face, turned) = (next, turned != turns);
                if faces[face].needle.is_none() {
                    let sign = if turned { -1 } else { 1 };
                    return Some((needle, faces[face].normal.map(|c| sign * c)));
                }
            }
            None
        })
        .collect();
    normals.into_iter().for_each(|(needle, normal)| faces[needle].normal = normal);
}

fn by_area_and_place(a: &Part, b: &Part) -> Ordering {
    let places = (0..3).map(|k| (a.low[k], b.low[k])).chain((0..3).map(|k| (a.high[k], b.high[k])));
    let areas = (b.area as f32).total_cmp(&(a.area as f32));
    places.fold(areas, |order, (a, b)| order.then(a.total_cmp(&b)))
}

/// The parts of a domain, by what each facet has of its part.
fn described<K: Ord + Copy>(ready: &Prepared, of: &[K]) -> BTreeMap<K, Part> {
    let (domain, offset) = (&ready.domain, ready.lattice.offset());
    let mut areas: BTreeMap<K, Vec<[f64; 4]>> = BTreeMap::new();
    let mut parts: BTreeMap<K, Part> = BTreeMap::new();
    for (f, key) in (0..).zip(of) {
        let part = parts.entry(*key).or_insert_with(|| Part {
            marker: 0,
            facets: 0,
            area: 0.0,
            low: [f64::INFINITY; 3],
            high: [f64::NEG_INFINITY; 3],
            normal: None,
        });
        part.facets += 1;
        for &v in domain.facets[f as usize].polygons.iter().flatten() {
            let p = domain.vertices[v as usize];
            part.low = [0, 1, 2].map(|k| part.low[k].min(p[k] + offset[k]));
            part.high = [0, 1, 2].map(|k| part.high[k].max(p[k] + offset[k]));
        }
        let all = areas.entry(*key).or_default();
        all.extend(
            triangles(domain, f).map(|corners| area(&corners.map(|v| domain.vertices[v as usize]))),
        );
    }
    for (key, mut all) in areas {
        let Some(part) = parts.get_mut(&key) else { continue };
        // Sums must not depend on the order of the file.
        all.sort_unstable_by(|a, b| {
            (0..4).fold(Ordering::Equal, |order, k| order.then(a[k].total_cmp(&b[k])))
        });
        let [x, y, z, area] =
            all.iter().fold([0.0; 4], |sum, own| [0, 1, 2, 3].map(|k| sum[k] + own[k]));
        part.area = area;
        let length = (x * x + y * y + z * z).sqrt();
        let normal = [x, y, z].map(|c| c / length + 0.0);
        part.normal = (length > ROUND * area).then_some(normal);
    }
    parts
}

/// The triangles of a facet.
fn triangles(domain: &Domain, f: u32) -> impl Iterator<Item = [u32; 3]> {
    let facet = &domain.facets[f as usize];
    let own = match (facet.polygons.as_slice(), facet.holes.as_slice()) {
        ([ring], []) => <[u32; 3]>::try_from(ring.as_slice()).ok().map(|triangle| vec![triangle]),
        _ => None,
    };
    let found = || domain.triangulate(f).map(|found| found.triangles);
    own.or_else(found).unwrap_or_default().into_iter()
}

/// The normal of a triangle, as long as its area, and the area.
fn area([a, b, c]: &[Point; 3]) -> [f64; 4] {
    use crate::vector::{cross, dot, minus};
    let n = cross(&minus(b, a), &minus(c, a)).map(|c| c / 2.0);
    [n[0], n[1], n[2], dot(&n, &n).sqrt()]
}

/// The normal of a polygon, as long as twice its area. Differences of corners are below 2^28.
fn normal(corners: &[[i64; 3]]) -> Whole {
    let from = |p: &[i64; 3]| [0, 1, 2].map(|k| i128::from(p[k] - corners[0][k]));
    let mut sum = [0; 3];
    for pair in corners.windows(2).skip(1) {
        let (u, v) = (from(&pair[0]), from(&pair[1]));
        for (k, entry) in sum.iter_mut().enumerate() {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            *entry += u[i] * v[j] - u[j] * v[i];
        }
    }
    sum
}

/// The longest side of a triangle that is lower than `tolerance` over it.
fn longest(ring: &[u32], corners: &[[i64; 3]], normal: &Whole, tolerance: f64) -> Option<[u32; 2]> {
    if ring.len() != 3 {
        return None;
    }
    let length = |k: usize| -> i128 {
        let (a, b) = (&corners[k], &corners[(k + 1) % 3]);
        (0..3).map(|i| i128::from(b[i] - a[i]).pow(2)).sum()
    };
    let side = (0..3).max_by_key(|&k| length(k))?;
    let is_low = dot(normal, normal) as f64 <= tolerance * tolerance * length(side) as f64;
    is_low.then(|| sorted([ring[side], ring[(side + 1) % 3]]))
}

/// Entries of normals are below 2^57, or the largest area of a polygon.
fn dot(a: &Whole, b: &Whole) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// An angle of at most 90 degrees, as the square of its cosine.
struct Cosine {
    square: f64,
}

impl Cosine {
    fn of(degrees: f64) -> Self {
        // The series of the sine and not that of a library, whose last bits are its own.
        let x = degrees.clamp(0.0, LARGEST_FEATURE_ANGLE).to_radians();
        let (mut sine, mut term) = (x, x);
        for k in 1..16 {
            let k = f64::from(2 * k);
            term *= -x * x / (k * (k + 1.0));
            sine += term;
        }
        Self { square: (1.0 - sine * sine).max(0.0) }
    }

    /// Are two normals, one of which may have to be turned, less than the angle apart? Exactly.
    fn is_above(&self, m: &Whole, n: &Whole, turned: bool) -> bool {
        let product = if turned { -dot(m, n) } else { dot(m, n) };
        if product <= 0 {
            return false;
        }
        let (lengths, own) = ([dot(m, m), dot(n, n)], product as f64);
        let (left, right) = (own * own, self.square * lengths[0] as f64 * lengths[1] as f64);
        if left < 0.999 * right || left > 1.001 * right {
            return left > right;
        }
        // The square is a whole number of steps of 2^-1074.
        let bits = self.square.to_bits();
        let exponent = (bits >> 52) as u32;
        let mantissa = bits & ((1 << 52) - 1) | u64::from(exponent > 0) << 52;
        let right = BigInt::from(mantissa) * BigInt::from(lengths[0]) * BigInt::from(lengths[1]);
        let product = BigInt::from(product);
        (&product * &product) << (1075 - exponent.max(1)) > right
    }
}

/// Sets of facets, each known by its first one.
struct Groups(Vec<usize>);

impl Groups {
    fn first(&mut self, mut k: usize) -> usize {
        // Every turn leads to a smaller number.
        while self.0[k] != k {
            self.0[k] = self.0[self.0[k]];
            k = self.0[k];
        }
        k
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first(a), self.first(b));
        self.0[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests;
