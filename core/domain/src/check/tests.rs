//! Contacts against an oracle that clips triangles in rational arithmetic, and shares no formula.

use super::contact::{Contact, Contacts};
use ltbw_exact::Point;
use ltbw_exact::predicates::collinear;
use proptest::prelude::*;

/// A point as integers over a common denominator.
type Rational = [i128; 4];

fn reduced(p: Rational) -> Rational {
    fn gcd(a: i128, b: i128) -> i128 {
        if b == 0 { a.abs() } else { gcd(b, a % b) }
    }
    let d = p.iter().fold(0, |d, &c| gcd(d, c)) * p[3].signum();
    p.map(|c| c / d)
}

/// The value of a plane (three coefficients and the constant) at a point.
fn value(plane: &Rational, p: &Rational) -> i128 {
    (0..4).map(|k| plane[k] * p[k]).sum()
}

/// The part of a convex polygon, segment or point where the plane is not negative.
fn clip(polygon: &[Rational], plane: &Rational) -> Vec<Rational> {
    let mut kept = Vec::new();
    for (i, p) in polygon.iter().enumerate() {
        let q = &polygon[(i + 1) % polygon.len()];
        let (vp, vq) = (value(plane, p), value(plane, q));
        if vp >= 0 {
            kept.push(*p);
        }
        if vp.signum() * vq.signum() < 0 {
            // p·vq - q·vp lies on the plane; so does its negative.
            let cut: Rational = std::array::from_fn(|k| p[k] * vq - q[k] * vp);
            kept.push(reduced(cut));
        }
    }
    kept.sort_unstable();
    kept.dedup();
    // Sorting lost the order around; that of at most a few points is found again by brute force.
    around(kept)
}

/// Orders the corners of a convex polygon around it.
fn around(mut points: Vec<Rational>) -> Vec<Rational> {
    if points.len() < 4 {
        return points;
    }
    let plain = |p: &Rational| [0, 1, 2].map(|k| p[k] as f64 / p[3] as f64);
    let centre = points.iter().map(plain).fold([0.0; 3], |s, p| [0, 1, 2].map(|k| s[k] + p[k]));
    let centre = centre.map(|c| c / points.len() as f64);
    let minus = |p: Point| [0, 1, 2].map(|k| p[k] - centre[k]);
    let dot = |p: Point, q: Point| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let u = minus(plain(&points[0]));
    let far = points.iter().map(|p| minus(plain(p))).max_by(|p, q| {
        let off = |p: &Point| {
            let t = dot(*p, u) / dot(u, u);
            let d = [0, 1, 2].map(|k| p[k] - t * u[k]);
            dot(d, d)
        };
        off(p).total_cmp(&off(q))
    });
    let w = far.unwrap();
    let t = dot(w, u) / dot(u, u);
    let v = [0, 1, 2].map(|k| w[k] - t * u[k]);
    points.sort_by(|p, q| {
        let angle = |p: &Rational| {
            let d = minus(plain(p));
            (dot(d, v) / dot(v, v).sqrt()).atan2(dot(d, u) / dot(u, u).sqrt())
        };
        angle(p).total_cmp(&angle(q))
    });
    points
}

fn integers(p: &Point) -> [i128; 3] {
    p.map(|c| c as i128)
}

fn cross(u: [i128; 3], v: [i128; 3]) -> [i128; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn minus(u: [i128; 3], v: [i128; 3]) -> [i128; 3] {
    [0, 1, 2].map(|k| u[k] - v[k])
}

/// The plane through `p` with this normal.
fn plane(normal: [i128; 3], p: [i128; 3]) -> Rational {
    let d: i128 = (0..3).map(|k| normal[k] * p[k]).sum();
    [normal[0], normal[1], normal[2], -d]
}

/// The corners of the common part of two triangles.
fn common(p: [Point; 3], q: [Point; 3]) -> Vec<Rational> {
    let q = q.map(|c| integers(&c));
    let normal = cross(minus(q[1], q[0]), minus(q[2], q[0]));
    let own = plane(normal, q[0]);
    let mut part: Vec<Rational> = p.iter().map(integers).map(|[x, y, z]| [x, y, z, 1]).collect();
    part = clip(&part, &own);
    part = clip(&part, &own.map(|c| -c));
    for k in 0..3 {
        let inwards = cross(normal, minus(q[(k + 1) % 3], q[k]));
        part = clip(&part, &plane(inwards, q[k]));
    }
    part
}

/// Do the points lie in no line?
fn has_area(points: &[Rational]) -> bool {
    let Some((a, rest)) = points.split_first() else { return false };
    let from = |p: &Rational| -> [i128; 3] { std::array::from_fn(|k| p[k] * a[3] - a[k] * p[3]) };
    rest.iter().any(|b| rest.iter().any(|c| cross(from(b), from(c)) != [0; 3]))
}

/// The oracle's answer: is there an illegal contact, and is it one of an area?
fn oracle(points: &[Point], p: [u32; 3], q: [u32; 3]) -> (bool, bool) {
    let at = |t: [u32; 3]| t.map(|v| points[v as usize]);
    let part = common(at(p), at(q));
    let shared: Vec<u32> = p.into_iter().filter(|v| q.contains(v)).collect();
    // The hull of the shared vertices is legal: a point of the common part must be in it.
    let legal = |x: &Rational| match shared.as_slice() {
        [] => false,
        [v] => {
            let [a, b, c] = integers(&points[*v as usize]);
            *x == [a, b, c, 1]
        }
        [v, w, ..] => {
            let (a, b) = (integers(&points[*v as usize]), integers(&points[*w as usize]));
            let (u, x3) = (minus(b, a), [x[0], x[1], x[2]]);
            let d = [0, 1, 2].map(|k| x3[k] - a[k] * x[3]);
            let along: i128 = (0..3).map(|k| d[k] * u[k]).sum();
            let length: i128 = u.iter().map(|c| c * c).sum();
            cross(d, u) == [0; 3] && (0..=length * x[3]).contains(&along)
        }
    };
    (!part.iter().all(legal), has_area(&part))
}

/// Two triangles of the points `0..6` of a small grid that share `shared` vertices.
fn triangles(size: i32) -> impl Strategy<Value = (Vec<Point>, usize)> {
    let point = prop::array::uniform3(0..size).prop_map(|p| p.map(f64::from));
    (prop::collection::vec(point, 6), 0..3_usize)
}

fn agree(points: &[Point], shared: usize) -> Result<(), TestCaseError> {
    let p = [0, 1, 2];
    let q = match shared {
        0 => [3, 4, 5],
        1 => [4, 0, 5],
        _ => [1, 5, 0],
    };
    let used: Vec<&Point> = p.iter().chain(&q).map(|&v: &u32| &points[v as usize]).collect();
    let flat = |t: [u32; 3]| {
        let [a, b, c] = t.map(|v| &points[v as usize]);
        collinear(a, b, c)
    };
    let mut numbers: Vec<u32> = p.into_iter().chain(q).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let distinct = numbers
        .iter()
        .all(|&v| numbers.iter().all(|&w| v == w || points[v as usize] != points[w as usize]));
    prop_assume!(distinct && !flat(p) && !flat(q));
    let (illegal, area) = oracle(points, p, q);
    for (one, other) in [(p, q), (q, p), ([p[1], p[2], p[0]], [q[2], q[1], q[0]])] {
        let found = Contacts { points }.triangles(one, other);
        prop_assert_eq!(found.is_some(), illegal, "{:?} {:?}", found, used);
        prop_assert_eq!(found == Some(Contact::Overlap), area, "{:?} {:?}", found, used);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 40_000,
        max_global_rejects: 1_000_000,
        ..ProptestConfig::default()
    })]

    #[test]
    fn contacts_are_those_of_the_oracle((points, shared) in triangles(3)) {
        agree(&points, shared)?;
    }

    #[test]
    fn contacts_are_those_of_the_oracle_on_a_larger_grid((points, shared) in triangles(6)) {
        agree(&points, shared)?;
    }
}
