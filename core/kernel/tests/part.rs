//! Parts of a mesh that are told nonsense: they stay inside their arrays.

use ltbw_core::part::{Closed, Part, Setting};
use ltbw_core::{Mode, Point, Random};
use ltbw_generate::{PointKind, generate};
use std::panic::{AssertUnwindSafe, catch_unwind};

type Tets = Part<u32, u32, u32>;

const POINTS: usize = 40;

fn part(points: &[Point]) -> Tets {
    let mut part = Tets::new(&Setting::of(points, Mode::Normal));
    part.set_points(1, points);
    part
}

/// Tetrahedra that are not linked, or anyhow, and slots that are free again: walks and closures
/// end, and no index is out of range (debug builds test every one).
#[test]
fn walks_and_closures_stay_inside_whatever_the_links_are() {
    let (mut walks, mut closures) = (0, 0);
    for seed in 0..200 {
        let points = generate(PointKind::Uniform, POINTS, seed);
        let (mut part, mut random) = (part(&points), Random::new(seed));
        let mut below = |bound: usize| random.below(bound as u64) as u32;
        let mut live = Vec::new();
        for _ in 0..60 {
            let v = [0; 3].map(|_| 1 + below(POINTS));
            let d = below(POINTS + 1);
            live.push(part.create([v[0], v[1], v[2], d]).expect("room"));
        }
        for step in 0..200 {
            let t = live[below(live.len()) as usize];
            let u = live[below(live.len()) as usize];
            match below(8) {
                0 if live.len() > 5 => {
                    live.retain(|&u| u != t);
                    part.open(t);
                    part.remove(t);
                }
                1 => part.put_far(4 * t + below(4), step).expect("room"),
                2 => part.link_far(4 * t + below(4), step).expect("room"),
                3 => part.point_to(4 * t + below(4), 4 * u + below(4)),
                4 => part.cache_sphere(t),
                5 => part.link(4 * t + below(4), 4 * u + below(4)),
                6 => part.watch(t, step),
                _ if part.holder(t).is_none() => part.close(t, step, false),
                _ => part.open(t),
            }
            let v = 1 + below(POINTS);
            let p = [0; 3].map(|_| f64::from(below(1000)) / 1000.0);
            let start = (step % 2 == 0).then_some(t).filter(|t| live.contains(t));
            part.walk(v, &p, start);
            walks += 1;
            let seed = live[below(live.len()) as usize];
            if part.holder(seed).is_none() {
                let mut closed = Closed::default();
                if part.close_all(seed, &p, u32::MAX, &mut closed) {
                    closures += closed.inside.min(1);
                    closed.held.iter().for_each(|&t| part.open(t));
                }
            }
        }
    }
    assert!(walks > 1000 && closures > 1000, "{walks} walks, {closures} closures");
}

#[test]
fn numbers_of_nothing_are_refused() {
    let points = generate(PointKind::Uniform, POINTS, 1);
    let mut part = part(&points);
    let t = part.create([1, 2, 3, 4]).expect("room");
    let gone = part.create([2, 1, 3, 4]).expect("room");
    part.remove(gone);
    let far = 1 << 20;
    let p = points[0];
    let mut refused = |what: &str, f: &mut dyn FnMut(&mut Tets)| {
        let result = catch_unwind(AssertUnwindSafe(|| f(&mut part)));
        let text = *result.expect_err(what).downcast::<String>().expect("a text");
        assert!(text.starts_with("there is no") || text.ends_with("is no tetrahedron"), "{text}");
    };
    for u in [far, u32::MAX] {
        refused("vertices", &mut |part| _ = part.vertices(u));
        refused("neighbours", &mut |part| _ = part.neighbours(u));
        refused("far", &mut |part| _ = part.far(u));
        refused("label", &mut |part| _ = part.label(u));
        refused("holder", &mut |part| _ = part.holder(u));
        refused("unwatch", &mut |part| _ = part.unwatch(u));
        refused("open", &mut |part| part.open(u));
        refused("point", &mut |part| _ = part.point(u));
    }
    for u in [far, gone, u32::MAX] {
        refused("close", &mut |part| part.close(u, 1, true));
        refused("watch", &mut |part| part.watch(u, 1));
        refused("remove", &mut |part| part.remove(u));
        refused("conflict", &mut |part| _ = part.in_conflict(u, &p));
        refused("sphere", &mut |part| part.cache_sphere(u));
        refused("closure", &mut |part| _ = part.close_all(u, &p, 1, &mut Closed::default()));
        let face = u.wrapping_mul(4);
        refused("link", &mut |part| part.link(face, 4 * t));
        refused("link", &mut |part| part.link(4 * t, face));
        refused("link new", &mut |part| part.link_new(4 * t, face));
        refused("point to", &mut |part| part.point_to(4 * t, face));
        refused("link far", &mut |part| _ = part.link_far(face, 1));
        refused("put far", &mut |part| _ = part.put_far(face, 1));
    }
    for v in [0, POINTS as u32 + 1, u32::MAX] {
        refused("set point", &mut |part| part.set_point(v, p));
        refused("set points", &mut |part| part.set_points(v, &points[..1]));
        refused("create", &mut |part| _ = part.create([v, 1, 2, 3]));
        refused("create", &mut |part| _ = part.create([1, 2, v, 3]));
    }
    refused("set points", &mut |part| part.set_points(2, &points));
    refused("create", &mut |part| _ = part.create([1, 2, 3, POINTS as u32 + 1]));
    refused("star", &mut |part| {
        _ = part.create_star(&[1, 2, 99, 3], [[1, 2, 3]].into_iter(), &mut Vec::new());
    });
}
