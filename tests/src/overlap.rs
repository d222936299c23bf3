//! Whether tetrahedra overlap, by brute force over GMP integers: all corners of the intersection.
//!
//! Shares nothing with the checker, which looks for planes between them.

use crate::oracle::{Exact, scale};
use ltbw::Point;
use rug::Integer;
use std::array::from_fn;

/// A half-space `normal · x < offset`.
struct Half {
    normal: Exact,
    offset: Integer,
}

fn minor(u: &[Integer; 2], v: &[Integer; 2]) -> Integer {
    Integer::from(&u[0] * &v[1]) - Integer::from(&u[1] * &v[0])
}

fn cross(u: &Exact, v: &Exact) -> Exact {
    from_fn(|k| {
        let pair = |w: &Exact| [w[(k + 1) % 3].clone(), w[(k + 2) % 3].clone()];
        minor(&pair(u), &pair(v))
    })
}

fn dot(u: &Exact, v: &Exact) -> Integer {
    u.iter().zip(v).map(|(x, y)| Integer::from(x * y)).sum()
}

/// The half-spaces whose intersection a tetrahedron is; `None` if it is flat.
fn halves(corners: &[Exact]) -> Option<[Half; 4]> {
    let all: Vec<Half> = (0..4)
        .filter_map(|apex| {
            let [a, b, c] = from_fn(|k| &corners[(apex + 1 + k) % 4]);
            let minus = |p: &Exact| from_fn(|k| Integer::from(&p[k] - &a[k]));
            let normal = cross(&minus(b), &minus(c));
            let (offset, inside) = (dot(&normal, a), dot(&normal, &corners[apex]));
            match inside.cmp(&offset) {
                std::cmp::Ordering::Less => Some(Half { normal, offset }),
                std::cmp::Ordering::Equal => None,
                std::cmp::Ordering::Greater => {
                    Some(Half { normal: normal.map(|x| -x), offset: -offset })
                }
            }
        })
        .collect();
    all.try_into().ok()
}

/// The common point of three planes as numerators and a positive denominator.
fn corner([f, g, h]: [&Half; 3]) -> Option<(Exact, Integer)> {
    let (gh, hf, fg) =
        (cross(&g.normal, &h.normal), cross(&h.normal, &f.normal), cross(&f.normal, &g.normal));
    let det = dot(&f.normal, &gh);
    if det == 0 {
        return None;
    }
    let turn = if det < 0 { -1 } else { 1 };
    let at = from_fn(|k| {
        let sum = Integer::from(&f.offset * &gh[k])
            + Integer::from(&g.offset * &hf[k])
            + Integer::from(&h.offset * &fg[k]);
        sum * turn
    });
    Some((at, det * turn))
}

/// Whether two tetrahedra have inner points in common; a flat one has none.
///
/// The intersection of eight half-spaces has inner points exactly if each of them holds strictly at
/// one of its corners: then all hold strictly at the mean of the corners.
///
/// # Panics
/// If a coordinate is not finite.
#[must_use]
pub fn overlap(p: [Point; 4], q: [Point; 4]) -> bool {
    let bounds = |t: &[Point; 4], k: usize| {
        t.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[k]), h.max(p[k])))
    };
    let apart = |k: usize| {
        let (p, q) = (bounds(&p, k), bounds(&q, k));
        p.1 <= q.0 || q.1 <= p.0
    };
    if (0..3).any(apart) {
        return false;
    }
    let all = scale(&[p, q].concat());
    let (Some(own), Some(others)) = (halves(&all[..4]), halves(&all[4..])) else { return false };
    let planes: Vec<&Half> = own.iter().chain(&others).collect();
    let mut strict = [false; 8];
    for i in 0..8 {
        for j in i + 1..8 {
            for k in j + 1..8 {
                let Some((at, whole)) = corner([planes[i], planes[j], planes[k]]) else { continue };
                let beyond = |h: &Half| dot(&h.normal, &at).cmp(&Integer::from(&h.offset * &whole));
                let sides: Vec<std::cmp::Ordering> = planes.iter().map(|h| beyond(h)).collect();
                if sides.iter().all(|side| side.is_le()) {
                    strict.iter_mut().zip(&sides).for_each(|(own, side)| *own |= side.is_lt());
                }
            }
        }
    }
    strict == [true; 8]
}

#[cfg(test)]
mod tests {
    use super::overlap;

    #[test]
    fn what_overlaps_and_what_touches() {
        let p = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
        let moved = |x: f64, y: f64, z: f64| p.map(|[a, b, c]| [a + x, b + y, c + z]);
        assert!(overlap(p, p) && overlap(p, moved(1.0, 1.0, 1.0)));
        assert!(!overlap(p, moved(4.0, 0.0, 0.0)) && !overlap(p, moved(2.0, 2.0, 0.0)));
        assert!(overlap(p, moved(1.9375, 2.0, 0.0)));
        // On the slanted face, from outside; and just inside.
        let q = |x: f64| [[x, x, x], [4.0, 4.0, 4.0], [9.0, 1.0, 1.0], [1.0, 9.0, 1.0]];
        assert!(!overlap(p, q(1.5)) && overlap(p, q(1.25)));
        let flat = [[1.0, 1.0, 0.5], [2.0, 1.0, 0.5], [1.0, 2.0, 0.5], [2.0, 2.0, 0.5]];
        assert!(!overlap(p, flat));
    }
}
