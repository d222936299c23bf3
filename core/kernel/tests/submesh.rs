//! Submeshes that are told nonsense: they stay inside their arrays.

use ltbw_core::search::Search;
use ltbw_core::submesh::{Closure, MeshParams, StarTet, Submesh};
use ltbw_core::topology::{FaceId, INFINITE, MAX_TETS, TetId, VertexId};
use ltbw_core::{Mode, Point, Random};
use ltbw_generate::{PointKind, generate};
use std::panic::{AssertUnwindSafe, catch_unwind};

type Tets = Submesh<u32, u32, u32>;

fn face(t: TetId, slot: u32) -> FaceId {
    FaceId::new(t, slot as usize)
}

const POINTS: usize = 40;

fn mesh(points: &[Point]) -> Tets {
    let mut mesh = Tets::new(&MeshParams::of(points, Mode::Normal));
    mesh.set_points(VertexId::new(1), points);
    mesh
}

/// Tetrahedra that are not linked, or anyhow, and slots that are free again: walks and closures
/// end, and no index is out of range (debug builds test every one).
#[test]
fn walks_and_closures_stay_inside_whatever_the_links_are() {
    let (mut walks, mut closures, mut search) = (0, 0, Search::default());
    for seed in 0..200 {
        let points = generate(PointKind::Uniform, POINTS, seed);
        let (mut mesh, mut random) = (mesh(&points), Random::new(seed));
        let mut below = |bound: usize| random.below(bound as u64) as u32;
        let mut live = Vec::new();
        for _ in 0..60 {
            let v = [0; 3].map(|_| VertexId::new(1 + below(POINTS)));
            let d = VertexId::new(below(POINTS + 1));
            live.push(mesh.create([v[0], v[1], v[2], d]).expect("room"));
        }
        for step in 0..200 {
            let t = live[below(live.len()) as usize];
            let u = live[below(live.len()) as usize];
            match below(8) {
                0 if live.len() > 5 => {
                    live.retain(|&u| u != t);
                    mesh.unlock(t);
                    mesh.remove(t);
                }
                1 => mesh.put_far(face(t, below(4)), step).expect("room"),
                2 => mesh.link_far(face(t, below(4)), step).expect("room"),
                3 => {
                    let star = [[1, 2, 3], [2, 1, 4]].map(|bound| {
                        let links = [0; 4]
                            .map(|_| (below(2) == 1).then(|| face(TetId::new(below(2)), below(4))));
                        StarTet { border: bound, links }
                    });
                    let corners = [0; 5].map(|_| VertexId::new(1 + below(POINTS)));
                    let mut made = Vec::new();
                    mesh.create_star(&corners, star.into_iter(), &mut made).expect("room");
                    live.extend(made);
                }
                4 => mesh.cache_sphere(t),
                5 => mesh.link(face(t, below(4)), face(u, below(4))),
                6 => mesh.tag(t, step),
                _ if mesh.holder(t).is_none() => mesh.lock(t, step, false),
                _ => mesh.unlock(t),
            }
            let v = VertexId::new(1 + below(POINTS));
            let p = [0; 3].map(|_| f64::from(below(1000)) / 1000.0);
            let start = (step % 2 == 0).then_some(t).filter(|t| live.contains(t));
            mesh.walk(v, &p, start);
            walks += 1;
            let seed = live[below(live.len()) as usize];
            mesh.search(seed, &p, &mut search);
            if mesh.holder(seed).is_none() {
                let mut closure = Closure::default();
                if mesh.lock_closure(seed, &p, u32::MAX, &mut closure) {
                    closures += closure.inside.min(1);
                    closure.locked.iter().for_each(|&t| mesh.unlock(t));
                }
            }
        }
    }
    assert!(walks > 1000 && closures > 1000, "{walks} walks, {closures} closures");
}

#[test]
fn numbers_of_nothing_are_refused() {
    let points = generate(PointKind::Uniform, POINTS, 1);
    let mut mesh = mesh(&points);
    let corners = [1, 2, 3, 4].map(VertexId::new);
    let [a, b, c, d] = corners;
    let beyond = VertexId::at(POINTS + 1);
    let t = mesh.create(corners).expect("room");
    let removed_tags = mesh.create([b, a, c, d]).expect("room");
    mesh.remove(removed_tags);
    let (far, last) = (TetId::new(1 << 20), TetId::new(u32::MAX));
    let p = points[0];
    let mut refused = |what: &str, f: &mut dyn FnMut(&mut Tets)| {
        let result = catch_unwind(AssertUnwindSafe(|| f(&mut mesh)));
        let text = *result.expect_err(what).downcast::<String>().expect("a text");
        assert!(text.starts_with("there is no") || text.ends_with("is no tetrahedron"), "{text}");
    };
    for u in [far, last] {
        refused("vertices", &mut |mesh| _ = mesh.vertices(u));
        refused("neighbours", &mut |mesh| _ = mesh.neighbours(u));
        refused("far", &mut |mesh| _ = mesh.far(u));
        refused("tag", &mut |mesh| _ = mesh.tag_of(u));
        refused("holder", &mut |mesh| _ = mesh.holder(u));
        refused("untag", &mut |mesh| _ = mesh.untag(u));
        refused("open", &mut |mesh| mesh.unlock(u));
        refused("point", &mut |mesh| _ = mesh.point(VertexId::new(u.number())));
    }
    for u in [far, removed_tags, last] {
        refused("close", &mut |mesh| mesh.lock(u, 1, true));
        refused("tag", &mut |mesh| mesh.tag(u, 1));
        refused("remove", &mut |mesh| _ = mesh.remove(u));
        refused("conflict", &mut |mesh| _ = mesh.in_conflict(u, &p));
        refused("search", &mut |mesh| _ = mesh.search(u, &p, &mut Search::default()));
        refused("sphere", &mut |mesh| mesh.cache_sphere(u));
        refused("closure", &mut |mesh| _ = mesh.lock_closure(u, &p, 1, &mut Closure::default()));
        let beyond = face(u.min(TetId::at(MAX_TETS)), 0);
        refused("link", &mut |mesh| mesh.link(beyond, face(t, 0)));
        refused("link", &mut |mesh| mesh.link(face(t, 0), beyond));
        refused("link new", &mut |mesh| mesh.link_new(face(t, 0), beyond));
        refused("link far", &mut |mesh| _ = mesh.link_far(beyond, 1));
        refused("put far", &mut |mesh| _ = mesh.put_far(beyond, 1));
    }
    for v in [INFINITE, beyond, VertexId::new(u32::MAX)] {
        refused("set point", &mut |mesh| mesh.set_point(v, p));
        refused("set points", &mut |mesh| mesh.set_points(v, &points[..1]));
        refused("create", &mut |mesh| _ = mesh.create([v, a, b, c]));
        refused("create", &mut |mesh| _ = mesh.create([a, b, v, c]));
    }
    refused("set points", &mut |mesh| mesh.set_points(b, &points));
    refused("create", &mut |mesh| _ = mesh.create([a, b, c, beyond]));
    refused("star", &mut |mesh| {
        let star = [StarTet { border: [1, 2, 3], links: [None; 4] }];
        _ = mesh.create_star(&[a, b, VertexId::new(99), c], star.into_iter(), &mut Vec::new());
    });
    let beyond = [Some(face(TetId::new(1), 0)), None, None, None];
    for (border, links) in [([1, 2, 3], beyond), ([1, 2, 4], [None; 4])] {
        let star = [StarTet { border, links }];
        let all = catch_unwind(AssertUnwindSafe(|| {
            mesh.create_star(&corners, star.into_iter(), &mut Vec::new())
        }));
        assert!(all.is_err(), "{star:?}");
    }
}
