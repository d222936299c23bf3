//! The guard of cached spheres at its edges: a query one unit in the last place beyond the frame,
//! a distance one unit within the tolerance, a radius one unit above the largest. No mesh comes
//! near these, so no test of a mesh would tell. Plain and vector code are compared with each other
//! and with the bounds that `docs/numerics.md` states.

use super::{FLATNESS, Frame, MAX_RADIUS, Query, Sphere, SphereBuilder, TOLERANCE, Verdict, simd};
use crate::arena::Arena;
use crate::topology::TetId;
use ltbw_exact::Point;

/// The verdict of plain and vector code, which is one, in whichever lane the sphere is.
fn verdict(sphere: &Sphere, q: &Query) -> Verdict {
    let plain = sphere.test(q);
    for lane in 0..4 {
        let mut four = [&Sphere::UNKNOWN; 4];
        four[lane] = sphere;
        let (inside, outside) = simd::test_spheres(four, q);
        assert_eq!((inside | outside) & !(1 << lane), 0, "an unknown sphere decides");
        let expected = match plain {
            Verdict::Inside => (1 << lane, 0),
            Verdict::Outside => (0, 1 << lane),
            Verdict::Unknown => (0, 0),
        };
        assert_eq!((inside, outside), expected, "lane {lane} of {sphere:?}, {q:?}");
    }
    plain
}

#[test]
fn beyond_the_frame_no_sphere_decides() {
    // Of half widths 1, 2 and 2^90.
    let boxes: [(Point, Point); 3] = [
        ([-1.0; 3], [1.0; 3]),
        ([2.0, 5.0, -8.0], [6.0, 8.0, -6.0]),
        ([-(2f64.powi(90)); 3], [2f64.powi(90); 3]),
    ];
    let spheres = [Sphere([0.0, 0.0, 0.0, 0.25]), Sphere([1.0, 1.0, -1.0, 2.0])];
    for (low, high) in boxes {
        let frame = Frame::of_box(low, high).expect("an ordinary box");
        let (reach, points) = (1.0 / frame.scale, Arena::default());
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
            let at = |c: f64| {
                let mut p = frame.origin;
                p[axis] = c;
                p
            };
            let edge = frame.origin[axis] + sign * reach;
            let inside = frame.query(&at(edge));
            assert!(inside.0.iter().all(|c| c.is_finite()), "{edge} is in the frame");
            let known = spheres.iter().filter(|s| verdict(s, &inside) != Verdict::Unknown);
            assert!(known.count() > 0, "queries at the edge of the frame are decided");
            // The first one behind it. Ends: a few units are a difference.
            let mut next = edge;
            while (frame.place(&at(next))[axis]).abs() <= 1.0 {
                next = if sign > 0.0 { next.next_up() } else { next.next_down() };
            }
            let far = [1.25, 2.0, 3.9, 1e30].map(|k| frame.origin[axis] + sign * k * reach);
            for c in far.into_iter().chain([next, sign * f64::INFINITY, f64::NAN]) {
                let outside = frame.query(&at(c));
                for sphere in &spheres {
                    assert_eq!(verdict(sphere, &outside), Verdict::Unknown, "{c} of {frame:?}");
                }
                let mut builder = SphereBuilder::default();
                assert!(!builder.at_apex(&frame, &points, &[], &at(c)), "{c} has no spheres");
            }
            assert!(SphereBuilder::default().at_apex(&frame, &points, &[], &at(edge)));
        }
    }
}

/// Along an axis all numbers are exact but for the squares.
#[test]
fn within_the_tolerance_nothing_is_decided_and_just_beyond_it_all_is() {
    assert_eq!(TOLERANCE, 2f32.powi(-20), "docs/numerics.md");
    for exponent in -12..=1 {
        let r = 2f32.powi(exponent);
        let (near, far) = (r - 2f32.powi(-20), r + 2f32.powi(-20));
        let cases = [
            (near.next_down(), Verdict::Inside),
            (near, Verdict::Unknown),
            (r, Verdict::Unknown),
            (far, Verdict::Unknown),
            (far.next_up(), Verdict::Outside),
        ];
        for (distance, expected) in cases {
            for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
                let mut at = [0.0; 4];
                at[axis] = sign * distance;
                let [x, y, z, _] = at;
                let found = verdict(&Sphere([0.0, 0.0, 0.0, r]), &Query(at));
                assert_eq!(found, expected, "a point {distance} from the centre, {r}");
                let found = verdict(&Sphere([x, y, z, r]), &Query([0.0; 4]));
                assert_eq!(found, expected, "a centre {distance} from the point, {r}");
            }
        }
    }
    // A sphere smaller than the tolerance has no inside.
    for r in [0.0, TOLERANCE / 2.0, TOLERANCE] {
        assert_eq!(verdict(&Sphere([0.0, 0.0, 0.0, r]), &Query([0.0; 4])), Verdict::Unknown);
    }
}

/// In any direction, up to the rounding of a distance of 2 in single precision.
#[test]
fn the_tolerance_is_kept_in_all_directions() {
    let mut state = 88_172_645_463_325_252u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / 2f32.powi(23) - 1.0
    };
    let (tolerance, room) = (2f64.powi(-20), 2f64.powi(-22));
    let mut seen = [0; 3];
    for _ in 0..20_000 {
        let (centre, q) = ([next(), next(), next()], [next(), next(), next(), 0.0]);
        let square = |k: usize| (f64::from(q[k]) - f64::from(centre[k])).powi(2);
        let distance = (square(0) + square(1) + square(2)).sqrt();
        if distance > 2.0 {
            continue;
        }
        let r = (distance + 2.0 * tolerance * f64::from(next())) as f32;
        let over = distance - f64::from(r);
        let found = verdict(&Sphere([centre[0], centre[1], centre[2], r]), &Query(q));
        seen[found as usize] += 1;
        if over.abs() <= tolerance - room {
            assert_eq!(found, Verdict::Unknown, "{over} of {r}");
        } else if over.abs() >= tolerance + room {
            let side = if over > 0.0 { Verdict::Outside } else { Verdict::Inside };
            assert_eq!(found, side, "{over} of {r}");
        }
    }
    assert!(seen.iter().all(|&n| n > 2000), "{seen:?}");
}

/// Is the sphere through 0 and three points on the axes, at these places, a sound one? Plain and
/// vector code say the same.
fn is_sound(places: [f64; 3], scale: f64) -> bool {
    let mut builder = SphereBuilder { scale, ..SphereBuilder::default() };
    for (k, &place) in places.iter().enumerate() {
        builder.rim[k][k] = place;
        builder.rim[k][3] = place * place;
    }
    let plain = builder.sphere([0, 1, 2, 0]);
    let mut vector = Arena::default();
    vector.grow(1, Sphere::UNKNOWN);
    match simd::make_spheres(&builder, &mut vector, &[TetId::new(0)], &[[0, 1, 2, 0]]) {
        true => assert_eq!(vector.at(0u32).is_blank(), plain.is_blank(), "{places:?}, {scale}"),
        false => println!("SKIPPED: no AVX2 on this machine"),
    }
    !plain.is_blank()
}

#[test]
fn radius_and_flatness_are_refused_from_their_bounds_on() {
    // 1² + 2² + 2² = 3²: the radius of edges 2, 4, 4 is 3, exactly.
    let edges = [2.0, 4.0, 4.0];
    assert_eq!(MAX_RADIUS, 2.0, "docs/numerics.md");
    let mut scale = 2.0 / 3.0;
    assert!(is_sound(edges, scale) && 3.0 * scale == 2.0);
    // Ends: a step is a third of a unit of the product.
    while 3.0 * scale <= 2.0 {
        scale = f64::next_up(scale);
    }
    assert!(!is_sound(edges, scale), "one unit above the largest radius");
    // Two edges 1 and one that is shorter and shorter.
    let (mut low, mut high) = (2f64.powi(-18), 2f64.powi(-14));
    assert!(!is_sound([1.0, 1.0, low], 1.0) && is_sound([1.0, 1.0, high], 1.0));
    // Ends: the range is halved.
    while low.next_up() < high {
        let middle = f64::from_bits(low.to_bits().midpoint(high.to_bits()));
        *(if is_sound([1.0, 1.0, middle], 1.0) { &mut high } else { &mut low }) = middle;
    }
    // Twice the determinant exceeds 2^-15 times the radius, which is √½ or hardly more.
    let bound = FLATNESS * (0.5 + high * high / 4.0).sqrt() / 2.0;
    assert!((high / bound - 1.0).abs() < 1e-12, "{high} {bound}");
    assert_eq!(FLATNESS.to_bits(), 2f64.powi(-15).to_bits());
}
