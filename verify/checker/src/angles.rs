//! Dihedral angles against a bound, exactly, and the least of them, rounded.
//!
//! At the edge that two faces have in common the cosine of the angle is the negative one between
//! their normals, all of which are outward or all inward. It is compared in doubles, with an error
//! that is bounded generously, then in big integers.

use crate::chunks::pieces;
use crate::exact::{big_differences, dyadic};
use crate::mesh::{Mesh, Point};
use crate::structure;
use num_bigint::BigInt;
use serde::Serialize;

/// The tetrahedra with a dihedral angle below a bound.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SmallAngles {
    /// The bound in degrees.
    pub bound: f64,
    /// Number of tetrahedra with an angle strictly below, exactly.
    pub count: u64,
    /// The first of them.
    pub tets: Vec<u32>,
    /// The least angle of the tetrahedra that were looked at; `None` if none has one.
    pub least: Option<LeastAngle>,
}

/// A least angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LeastAngle {
    /// The angle in degrees, rounded.
    pub value: f64,
    /// The first tetrahedron that has it.
    pub tet: u32,
}

/// The tetrahedra of a mesh with a dihedral angle strictly below some degrees, which are above 0
/// and at most 90; at most `limit` of them are listed. Exact, once the degrees have become the
/// square of a cosine, a double: twelve terms of the sine's series, squared, from 1. The order of
/// vertices means nothing. Flat tetrahedra have an angle of zero; at the edges of a face without
/// area there is none; tetrahedra that name a point that is not there or not finite are passed
/// over. Never panics, whatever the mesh.
///
/// ```
/// use ltbw_verify::{Mesh, small_angles};
///
/// // Half of a prism over a right triangle, and a low one.
/// let points = [[0.0; 3], [8.0, 0.0, 0.0], [8.0, 8.0, 0.0], [8.0, 8.0, 8.0], [8.0, 8.0, -1.0]];
/// let found = small_angles(&Mesh::new(&points, &[[0, 1, 2, 3], [0, 2, 1, 4]]), 12.0, 100);
/// assert_eq!((found.count, &found.tets[..]), (1, &[1][..]));
/// assert!((found.least.expect("two").value - 7.125).abs() < 1e-3);
/// ```
pub fn small_angles(mesh: &Mesh, degrees: f64, limit: usize) -> SmallAngles {
    let bound = Bound::new(degrees);
    let count = if structure::fits(mesh) { mesh.tets.len() } else { 0 };
    let parts = pieces(count, |range| {
        let mut part = Found::new(limit);
        for t in range {
            let corners = mesh.tets[t].map(|v| mesh.points.get(v as usize));
            let [Some(a), Some(b), Some(c), Some(d)] = corners else { continue };
            if [a, b, c, d].iter().all(|p| p.iter().all(|c| c.is_finite())) {
                part.add(t as u32, &bound.of_points([a, b, c, d]));
            }
        }
        part
    });
    parts.into_iter().fold(Found::new(limit), Found::merge).under(degrees)
}

/// The tetrahedra found so far.
pub(crate) struct Found {
    limit: usize,
    count: u64,
    tets: Vec<u32>,
    /// The largest cotangent of an angle, and its tetrahedron.
    largest: Option<(f64, u32)>,
}

impl Found {
    /// None, of which `limit` will be listed.
    pub(crate) fn new(limit: usize) -> Self {
        Self { limit, count: 0, tets: Vec::new(), largest: None }
    }

    /// Adds a tetrahedron that is behind all others.
    pub(crate) fn add(&mut self, t: u32, angles: &Angles) {
        if angles.is_below {
            self.count += 1;
            if self.tets.len() < self.limit {
                self.tets.push(t);
            }
        }
        self.reach(angles.largest, t);
    }

    fn reach(&mut self, cotangent: f64, t: u32) {
        let most = self.largest.map_or(f64::NEG_INFINITY, |(most, _)| most);
        if cotangent > most {
            self.largest = Some((cotangent, t));
        }
    }

    /// These, and those of a later part.
    pub(crate) fn merge(mut self, later: Self) -> Self {
        self.count += later.count;
        let room = self.limit.saturating_sub(self.tets.len());
        self.tets.extend(later.tets.into_iter().take(room));
        if let Some((cotangent, t)) = later.largest {
            self.reach(cotangent, t);
        }
        self
    }

    /// The report on them.
    pub(crate) fn under(self, degrees: f64) -> SmallAngles {
        let least = self.largest.map(|(cotangent, tet)| {
            let value = 1f64.atan2(cotangent).to_degrees();
            LeastAngle { value, tet }
        });
        SmallAngles { bound: degrees, count: self.count, tets: self.tets, least }
    }
}

/// The angles of one tetrahedron.
pub(crate) struct Angles {
    /// Is one of them below the bound?
    is_below: bool,
    /// The largest of their cotangents, rounded; NaN if there is no angle.
    largest: f64,
}

/// A bound on dihedral angles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bound {
    /// The square of its cosine: what angles are compared with.
    cos2: f64,
}

/// Pairs of faces, and the ends of the edge that they have in common.
const PAIRS: [[usize; 4]; 6] =
    [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 0, 2], [2, 3, 0, 1]];

const UNIT_ROUNDOFF: f64 = 1.0 / (1u64 << 53) as f64;

impl Bound {
    /// The bound of some degrees, above 0 and at most 90.
    ///
    /// Twelve terms of the series of the sine, not a library's sine, whose last bits differ from
    /// one to the next: the definition that refinement has, too.
    pub(crate) fn new(degrees: f64) -> Self {
        let x = degrees.to_radians();
        let (mut sine, mut term) = (x, x);
        for k in 1..12 {
            let k = f64::from(2 * k);
            term *= -x * x / (k * (k + 1.0));
            sine += term;
        }
        // At 90 degrees the sine is rounded up to more than 1.
        Self { cos2: (1.0 - sine * sine).max(0.0) }
    }

    /// The angles of finite corners.
    fn of_points(&self, [a, b, c, d]: [&Point; 4]) -> Angles {
        let rows = [a, b, c].map(|p| [0, 1, 2].map(|k| p[k] - d[k]));
        self.of(rows, || big_differences([a, b, c], d))
    }

    /// The angles of corners in units.
    pub(crate) fn of_whole(&self, [a, b, c, d]: [[i128; 3]; 4]) -> Angles {
        let rows = [a, b, c].map(|p| [0, 1, 2].map(|k| p[k] - d[k]));
        self.of(rows.map(|row| row.map(|x| x as f64)), || rows.map(|row| row.map(BigInt::from)))
    }

    /// The angles of a tetrahedron by the differences of three corners to the last one: rounded,
    /// and exact ones proportional to them.
    fn of(&self, rows: [[f64; 3]; 3], exact: impl FnOnce() -> [[BigInt; 3]; 3]) -> Angles {
        let Some(rows) = scaled(rows) else {
            let rows = exact();
            let largest = scaled(shortened(&rows)).map_or(f64::NAN, |rows| self.rounded(rows).0);
            return Angles { is_below: self.is_below_exactly(&rows), largest };
        };
        let (largest, is_below) = self.rounded(rows);
        let is_below = is_below.unwrap_or_else(|| self.is_below_exactly(&exact()));
        Angles { is_below, largest }
    }

    /// The largest cotangent of an angle, rounded, and whether an angle is below, if that is
    /// certain. The largest of the differences is at least 1 and below 2.
    fn rounded(&self, [a, b, c]: [[f64; 3]; 3]) -> (f64, Option<bool>) {
        let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let cross = |p: [f64; 3], q: [f64; 3]| {
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        };
        let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
        let last = [0, 1, 2].map(|k| -(bc[k] + ca[k] + ab[k]));
        let (normals, corners) = ([bc, ca, ab, last], [a, b, c, [0.0; 3]]);
        let det = dot(a, bc).abs();
        let m = corners.as_flattened().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        // A normal has at most 6 products of two differences in an axis, the product of two of them
        // 108 of four, either side 11664 of eight. None has more than 45 roundings, those of the
        // differences included. What is above the error has a product of normals above
        // 1000 √u m⁴, whose error is far less: its sign is right.
        let m4 = m * m * m * m;
        let error = 45.0 * UNIT_ROUNDOFF * 2.0 * 11_664.0 * m4 * m4;
        let (mut largest, mut is_below, mut is_certain) = (f64::NAN, false, true);
        for [i, j, k, l] in PAIRS {
            let product = -dot(normals[i], normals[j]);
            let squares = dot(normals[i], normals[i]) * dot(normals[j], normals[j]);
            let over = product * product - self.cos2 * squares;
            is_below |= over > error && product > 0.0;
            is_certain &= over.abs() > error;
            let edge = [0, 1, 2].map(|x| corners[k][x] - corners[l][x]);
            // The product is |normals| |normals| cos, and D |edge| the same with the sine.
            let cotangent = product / (det * dot(edge, edge).sqrt());
            largest = f64::max(largest, cotangent);
        }
        (largest, (is_below || is_certain).then_some(is_below))
    }

    /// Is an angle below the bound? In big integers.
    fn is_below_exactly(&self, [a, b, c]: &[[BigInt; 3]; 3]) -> bool {
        let dot = |p: &[BigInt; 3], q: &[BigInt; 3]| -> BigInt {
            p.iter().zip(q).map(|(x, y)| x * y).sum()
        };
        let cross = |p: &[BigInt; 3], q: &[BigInt; 3]| {
            [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &p[i] * &q[j] - &p[j] * &q[i])
        };
        let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
        let last = [0, 1, 2].map(|k| -(&bc[k] + &ca[k] + &ab[k]));
        let normals = [bc, ca, ab, last];
        // A number that is at most 1 has an exponent below zero.
        let (mantissa, exponent) = dyadic(self.cos2);
        let mantissa = BigInt::from(mantissa);
        PAIRS.iter().any(|&[i, j, ..]| {
            let product = -dot(&normals[i], &normals[j]);
            let squares = dot(&normals[i], &normals[i]) * dot(&normals[j], &normals[j]);
            let left = (&product * &product) << exponent.unsigned_abs();
            product > BigInt::ZERO && left > &mantissa * squares
        })
    }
}

/// The differences times a power of two with which the largest is at least 1 and below 2; `None`
/// if they are all zero, or too small or too large for that. What underflows is far below the
/// roundings of the largest.
fn scaled(rows: [[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let m = rows.as_flattened().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let exponent = (m.to_bits() >> 52) as i32 - 1023;
    if !(-1000..=1000).contains(&exponent) {
        return None;
    }
    let factor = f64::from_bits(((1023 - exponent) as u64) << 52);
    Some(rows.map(|row| row.map(|x| x * factor)))
}

/// The leading bits of integers, in proportion.
fn shortened(rows: &[[BigInt; 3]; 3]) -> [[f64; 3]; 3] {
    let bits = rows.iter().flatten().map(BigInt::bits).max().unwrap_or(0);
    let shift = bits.saturating_sub(62);
    let lead = |x: &BigInt| i64::try_from(x >> shift).unwrap_or(0) as f64;
    rows.each_ref().map(|row| row.each_ref().map(lead))
}

#[cfg(test)]
mod tests;
