//! `predicates`: bytes to five points, all predicates compared with `rug`.

use crate::families::{snap, spheres, two_to};
use crate::five_points::{PREDICATES, each_predicate};
use crate::oracle::{self, Exact, exact as by_rug};
use arbitrary::{Result, Unstructured};
use ltbw::predicates::{exact, twin};
use ltbw::{Point, Sign};
use std::sync::OnceLock;

/// Compares every predicate with `rug` on the five points of `bytes`.
///
/// # Panics
/// If one differs.
pub fn predicates(bytes: &[u8]) {
    let Some(mut points) = points(bytes) else { return };
    let with_twins = bytes.get(3).is_some_and(|jitter| jitter & 0x30 == 0x30);
    for turn in 0..5 {
        let scaled = oracle::scale(&points);
        let scaled = std::array::from_fn(|i| &scaled[i]);
        each_predicate(&points, &scaled, |predicate, ours, rug| {
            assert_eq!(ours, rug, "{} of {points:?}", PREDICATES[predicate]);
        });
        // The twins take tens of microseconds each.
        slow(&points, &scaled, with_twins && turn == 0);
        // Every point is the fifth once; two are exchanged each time to turn the tetrahedron.
        points.rotate_left(1);
        points.swap(turn % 3, 3);
    }
}

/// The exact stages by themselves, and the big-integer twins.
fn slow(points: &[Point; 5], scaled: &[&Exact; 5], with_twins: bool) {
    let [a, b, c, d, e] = points;
    let &[xa, xb, xc, xd, xe] = scaled;
    let see = |name: &str, exact: Sign, twin: &dyn Fn() -> Sign, rug: Sign| {
        assert_eq!(exact, rug, "exact {name} of {points:?}");
        if with_twins {
            assert_eq!(twin(), rug, "twin {name} of {points:?}");
        }
    };
    let volume = by_rug::orient3d(xa, xb, xc, xd);
    see("orient3d", exact::orient3d(a, b, c, d), &|| twin::orient3d(a, b, c, d), volume);
    let side = by_rug::insphere(xa, xb, xc, xd, xe);
    see("insphere", exact::insphere(a, b, c, d, e), &|| twin::insphere(a, b, c, d, e), side);
    let turn = by_rug::coplanar_orient(xa, xb, xc);
    see("turn", exact::coplanar_orient(a, b, c), &|| twin::coplanar_orient(a, b, c), turn);
    if volume == Sign::Zero && turn != Sign::Zero {
        let side = by_rug::side_of_bounded_circle(xa, xb, xc, xd);
        let twin = || twin::side_of_bounded_circle(a, b, c, d);
        see("circle", exact::side_of_bounded_circle(a, b, c, d), &twin, side);
    }
}

/// The five points of `bytes`; `None` where they are not finite.
#[must_use]
pub fn points(bytes: &[u8]) -> Option<[Point; 5]> {
    let points = draw(&mut Unstructured::new(bytes)).ok()?;
    points.iter().flatten().all(|c| c.is_finite()).then_some(points)
}

/// A carrier, a power of two for some of the points, and some ulps. Where the bytes end, zeros
/// follow.
fn draw(u: &mut Unstructured<'_>) -> Result<[Point; 5]> {
    let [carrier, scaled, exponent, jitter]: [u8; 4] = u.arbitrary()?;
    let mut points = match carrier % 8 {
        0 => numbers(u, |u| Ok(f64::from_bits(u.arbitrary()?)))?,
        1 => numbers(u, |u| Ok(f64::from(u.arbitrary::<i8>()? % 4)))?,
        2 => numbers(u, |u| Ok(f64::from(u.arbitrary::<i16>()?)))?,
        3 => cospherical(u)?,
        4 => coplanar(u)?,
        // Coordinates of many scales: what the filters' guards are for.
        5 => numbers(u, |u| {
            let exponent = 4 * i32::from(u.arbitrary::<i8>()?);
            Ok(f64::from(u.arbitrary::<i8>()?) * two_to(exponent))
        })?,
        // 53 bits: every product rounds.
        6 => numbers(u, |u| {
            let bits = u.arbitrary::<u64>()?;
            Ok((bits >> 11) as f64 * two_to(-52) - 1.0)
        })?,
        _ => {
            let style = u.arbitrary()?;
            let cells: [[u8; 4]; 5] = u.arbitrary()?;
            snap(style, &cells).try_into().unwrap_or([[0.0; 3]; 5])
        }
    };
    let factor = two_to((8 * i32::from(exponent as i8)).clamp(-1022, 1016));
    for (i, p) in points.iter_mut().enumerate() {
        // All of them, unless the high bits single some out.
        if scaled >> 5 == 0 || scaled >> i & 1 == 1 {
            *p = p.map(|c| c * factor);
        }
    }
    for _ in 0..jitter % 8 {
        let which: u8 = u.arbitrary()?;
        let c = &mut points[usize::from(which >> 4) % 5][usize::from(which >> 2 & 3) % 3];
        *c = if which & 1 == 0 { c.next_up() } else { c.next_down() };
    }
    Ok(points)
}

fn numbers(
    u: &mut Unstructured<'_>,
    mut number: impl FnMut(&mut Unstructured<'_>) -> Result<f64>,
) -> Result<[Point; 5]> {
    let mut points = [[0.0; 3]; 5];
    for c in points.iter_mut().flatten() {
        *c = number(u)?;
    }
    Ok(points)
}

/// Integer points of one sphere, moved.
fn cospherical(u: &mut Unstructured<'_>) -> Result<[Point; 5]> {
    static SPHERES: OnceLock<[Vec<Point>; 4]> = OnceLock::new();
    let spheres = SPHERES.get_or_init(|| [3, 9, 41, 1001].map(|square| spheres(&[square])));
    let sphere = &spheres[usize::from(u.arbitrary::<u8>()?) % 4];
    let offset: [i32; 3] = u.arbitrary()?;
    let chosen: [u16; 5] = u.arbitrary()?;
    let at = |i: u16| sphere[usize::from(i) % sphere.len()];
    Ok(chosen.map(|i| {
        let p = at(i);
        std::array::from_fn(|k| p[k] + f64::from(offset[k]))
    }))
}

/// a + i u + j v in integers.
fn coplanar(u: &mut Unstructured<'_>) -> Result<[Point; 5]> {
    let [a, s, t]: [[i16; 3]; 3] = u.arbitrary()?;
    let steps: [[i8; 2]; 5] = u.arbitrary()?;
    let at = |k: usize, [i, j]: [i8; 2]| {
        f64::from(a[k]) + f64::from(i) * f64::from(s[k]) + f64::from(j) * f64::from(t[k])
    };
    Ok(steps.map(|ij| std::array::from_fn(|k| at(k, ij))))
}
