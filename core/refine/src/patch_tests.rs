//! Tests of patches: spheres by latitude and longitude, prisms of rounded triangles.

use super::*;
use crate::complex::carrier::Carrier;
use crate::complex::measure::Shape;
use crate::complex::patch::{flat, turn};
use crate::complex::plc::Plc;
use crate::heed::Heed;
use crate::mesh::item::Queues;
use crate::mesh::marks::face_bit;
use crate::mesh::state::{FACE, State};
use crate::queue::split::Step;
use crate::rules::complex::Complex;
use crate::table::{Map, Set, sides as sides_of, triangle};
use ltbw_core::topology::{TetId, VertexId, slot_of, tet_of};
use ltbw_domain::{Domain, Facet, PrepareOptions, Prepared};
use ltbw_exact::Point;
use std::f64::consts::PI;

/// A sphere of n rings and n meridians with single-precision coordinates.
fn sphere(n: u32) -> Prepared {
    let rings = n - 2;
    let mut vertices: Vec<Point> = vec![[0.0, 0.0, 0.5], [0.0, 0.0, -0.5]];
    for j in 0..n {
        for i in 1..=rings {
            let (sin, cos) = (PI * f64::from(i) / f64::from(n - 1)).sin_cos();
            let (y, x) = (2.0 * PI * f64::from(j) / f64::from(n)).sin_cos();
            vertices.push([sin * x, sin * y, cos].map(|c| f64::from((0.5 * c) as f32)));
        }
    }
    let at = |j: u32, i: u32| 2 + (j % n) * rings + i;
    let mut triangles = Vec::new();
    for j in 0..n {
        triangles.push([0, at(j, 0), at(j + 1, 0)]);
        triangles.push([1, at(j + 1, rings - 1), at(j, rings - 1)]);
        for i in 0..rings - 1 {
            triangles.push([at(j, i), at(j, i + 1), at(j + 1, i)]);
            triangles.push([at(j, i + 1), at(j + 1, i + 1), at(j + 1, i)]);
        }
    }
    let mut domain = Domain { vertices, ..Domain::default() };
    domain.facets.extend(triangles.iter().map(|t| Facet::polygon(t, 0)));
    domain.prepare(&PrepareOptions { oriented: true, ..PrepareOptions::default() }).expect("sound")
}

/// The mesh has the diagonals that it likes: no point is needed.
#[test]
fn quads_cut_in_two_are_recovered_without_a_point() {
    for n in [12, 30] {
        let ready = sphere(n);
        let refiner = Refiner::new().flat_tolerance(5e-7);
        let (run, regions) = refiner.recovered(&ready.domain, &ready.lattice).expect("a mesh");
        assert_eq!(run.refinement.inserted.points.total(), 0, "{n}");
        assert_eq!(regions.len(), 2);
        let state = &run.refinement.state;
        assert!(state.plc.facets.iter().filter(|f| f.patch.is_some()).count() > n as usize);
        check_labels(state);
    }
}

/// The vertices of a sphere have one circumsphere: the first point inside takes nearly the whole
/// mesh, with the dust on it. The subfaces below the dust become those above it, and none is lost.
#[test]
fn seeds_part_the_mesh_and_keep_every_patch_covered() {
    let ready = sphere(30);
    let refiner = Refiner::new().flat_tolerance(5e-7);
    let (mut run, _) = refiner.recovered(&ready.domain, &ready.lattice).expect("a mesh");
    let before: Vec<[VertexId; 3]> = run.refinement.state.subfaces.keys().copied().collect();
    run.refinement.seed(u64::MAX, Heed::default(), &mut run.work);
    let state = &run.refinement.state;
    check_labels(state);
    let points = run.refinement.inserted.points;
    assert!(points.free > 4 && points.total() == points.free, "{points:?}");
    let gone = before.iter().filter(|s| !state.subfaces.contains_key(*s)).count();
    assert!(gone > 10 && before.len() == state.subfaces.len(), "{gone}");
    let all: Vec<TetId> = state.mesh.tet_ids().collect();
    let largest = all.iter().filter(|&&t| {
        let [a, b, c, d] = state.vertices(t).map(|v| state.at(v));
        Shape::of([&a, &b, &c, &d]).ratio() > 8.0 && state.marks.region(t) > 0
    });
    assert!(largest.count() < all.len() / 4);
}

/// A side of a cube with a vertex on it that is inside by the last bit of a float: a triangle that
/// cuts it off is no part of the side, though nearly all of it is.
#[test]
fn triangles_that_cut_off_a_vertex_of_the_outline_are_no_tiles() {
    let bit = f64::from(f32::EPSILON) / 2.0;
    let mut vertices: Vec<Point> =
        (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    vertices.extend([[0.5, bit, 1.0 - bit], [0.5, 0.5, 1.0 - bit]]);
    let mut domain = Domain { vertices, ..Domain::default() };
    let top = [[8, 5, 9], [5, 7, 9], [7, 6, 9], [6, 4, 9], [4, 8, 9]];
    let front = [[0, 1, 8], [1, 5, 8], [0, 8, 4]];
    domain.facets.extend(top.iter().chain(&front).map(|t| Facet::polygon(t, 0)));
    let rest = [[0, 2, 3, 1], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    domain.facets.extend(rest.iter().map(|f| Facet::polygon(f, 0)));
    let ready = domain.prepare(&PrepareOptions { oriented: true, ..PrepareOptions::default() });
    let ready = ready.expect("sound");
    let refiner = Refiner::new().flat_tolerance(5e-7);
    let (run, _) = refiner.recovered(&ready.domain, &ready.lattice).expect("a mesh");
    check_labels(&run.refinement.state);
    let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    assert_eq!((refined.stats.patches, refined.stats.patches_given_up), (2, 0));
    assert_eq!(refined.outcome, RefineOutcome::Met);
}

/// The top of a box runs back under itself and on, all within the tolerance, and its first part is
/// bent by less than that.
#[test]
fn patches_end_where_they_would_fold() {
    let profile =
        [[0.0, 1.0], [0.6, 1.0], [0.4, 1.0 - 2e-7], [1.0, 1.0 - 4e-7], [1.0, 0.0], [0.0; 2]];
    let at = |x: f64| profile.map(|[y, z]| [x, y, z]);
    let mut domain = Domain { vertices: [at(0.0), at(1.0)].concat(), ..Domain::default() };
    domain.vertices.push([0.5, 0.3, 1.0 - 5e-8]);
    let mut add = |corners: &[u32]| domain.facets.push(Facet::polygon(corners, 0));
    add(&[0, 1, 2, 3, 4, 5]);
    add(&[11, 10, 9, 8, 7, 6]);
    for k in 1..6 {
        let l = (k + 1) % 6;
        add(&[k, 6 + k, 6 + l, l]);
    }
    for [a, b] in [[0, 6], [6, 7], [7, 1], [1, 0]] {
        add(&[a, b, 12]);
    }
    let options = PrepareOptions { oriented: true, ..PrepareOptions::default() };
    let ready = domain.prepare(&options).expect("sound");
    let found = |tolerance: f64| {
        let plc =
            Plc::within(&ready.domain, &ready.lattice, tolerance, &Set::default(), Heed::default());
        let plc = plc.expect("a complex");
        (plc.folds, plc.facets.iter().filter(|facet| facet.patch.is_some()).count())
    };
    assert_eq!(found(5e-7), (2, 1));
    // The parts of the top are then not within it of each other.
    assert_eq!(found(1e-7), (0, 1));
}

/// A side of a cube with a pocket whose edge is inside by the last bit of a float: a large triangle
/// over the pocket is no part of the side, though its middle is, and the middles of its sides.
#[test]
fn triangles_over_a_pocket_are_no_tiles() {
    let bit = f64::from(f32::EPSILON) / 2.0;
    let mut vertices: Vec<Point> =
        (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    let square = [[0.375, 0.125], [0.625, 0.125], [0.625, 0.25], [0.375, 0.25]];
    for z in [1.0 - bit, 0.5] {
        vertices.extend(square.map(|[x, y]| [x, y, z]));
    }
    let mut domain = Domain { vertices, ..Domain::default() };
    let outer = [4, 5, 7, 6];
    let mut add = |corners: &[u32]| domain.facets.push(Facet::polygon(corners, 0));
    for k in 0..4 {
        let l = (k + 1) % 4;
        let [a, b, c, d] = [outer[k], outer[l], 8 + l as u32, 8 + k as u32];
        add(&[a, b, c]);
        add(&[a, c, d]);
        add(&[d, c, c + 4, d + 4]);
    }
    let rest =
        [[12, 13, 14, 15], [0, 2, 3, 1], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    rest.iter().for_each(|corners| add(corners));
    let ready = domain.prepare(&PrepareOptions { oriented: true, ..PrepareOptions::default() });
    let ready = ready.expect("sound");
    let refiner = Refiner::new().flat_tolerance(5e-7);
    let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    assert_eq!((refined.stats.patches, refined.stats.patches_given_up), (1, 0));
    assert_eq!(refined.outcome, RefineOutcome::Met);
    let (run, _) = refiner.recovered(&ready.domain, &ready.lattice).expect("a mesh");
    check_labels(&run.refinement.state);
}

/// Labels and subfaces after every transaction, by looking at every face: a label changes at the
/// subfaces of patches only, from side to side, and every patch has its area.
#[test]
fn every_transaction_keeps_every_patch_covered() {
    let ready = sphere(10);
    let refiner = Refiner::new().flat_tolerance(5e-7).max_volume(2e-4);
    let (mut run, _) = refiner.recovered(&ready.domain, &ready.lattice).expect("a mesh");
    let mut work = Queues::default();
    std::mem::swap(&mut work, &mut run.work);
    let (mut inserted, mut on_patches) = (0, 0);
    for _ in 0..20_000 {
        let Some(item) = work.next_boundary().or_else(|| work.next_tet()) else { break };
        let step = run.refinement.split(item, &mut work);
        if step == Step::Inserted {
            inserted += 1;
            let state = &run.refinement.state;
            on_patches += usize::from(state.carriers.last() != Some(&Carrier::Free));
            if on_patches % 16 == 0 {
                check_labels(state);
            }
        }
    }
    check_labels(&run.refinement.state);
    assert!(inserted > 100 && on_patches > 50, "{inserted} {on_patches}");
}

/// Dust that is given to the inner side is moved back in the end. That is seen beforehand, by the
/// carriers of its corners and the regions around it alone; where one of these is not known, too.
#[test]
fn dust_on_the_inner_side_is_seen_before_it_is_moved() {
    let ready = sphere(30);
    let refiner = Refiner::new().flat_tolerance(5e-7);
    let (run, _) = refiner.recovered(&ready.domain, &ready.lattice).expect("a mesh");
    let own = run.refinement;
    let bounds = own.bounds.expect("all is there");
    let complex = Complex::of(&own.state, bounds, own.floor, own.joint_most);
    let mut state = own.state;
    state.settle_all_dust();
    let is_seen = |state: &State, t: TetId, region: u32, unknown: Option<usize>| {
        let corners = state.cornered(state.vertices(t));
        let beyond = |slot: usize| state.marks.region(state.neighbours(t)[slot]);
        let known = |slot| (Some(slot) != unknown).then(|| beyond(slot));
        complex.may_be_dust(corners, region, known)
    };
    let mut moved = 0;
    for t in state.mesh.tet_ids().collect::<Vec<TetId>>() {
        assert!(!is_seen(&state, t, state.marks.region(t), None), "{t} stays where it is");
        let is_outer = state.is_flat(state.vertices(t)) && state.marks.region(t) == 0;
        if !is_outer || !is_seen(&state, t, 1, None) {
            continue;
        }
        assert!((0..4).all(|slot| is_seen(&state, t, 1, Some(slot))), "{t}");
        let (v, neighbours) = (state.vertices(t), state.mesh.topology().at(t).neighbours());
        let key = |slot: usize| {
            let [a, b, c] = FACE[slot].map(|k| v[k]);
            triangle(a, b, c)
        };
        let of = (0..4).find_map(|slot| state.subfaces.get(&key(slot)).copied());
        for (slot, across) in neighbours.into_iter().enumerate() {
            let bit = face_bit(slot_of(across));
            if state.marks.region(tet_of(across)) == 1 {
                state.marks.clear(t, face_bit(slot));
                state.marks.clear(tet_of(across), bit);
                state.remove_subface(key(slot));
            } else {
                state.marks.set(t, face_bit(slot));
                state.marks.set(tet_of(across), bit);
                state.add_subface(key(slot), of.expect("a subface below it"));
            }
        }
        state.marks.set_region(t, 1);
        check_labels(&state);
        state.settle_dust([t]);
        assert_eq!(state.marks.region(t), 0, "{t} is moved back");
        check_labels(&state);
        moved += 1;
    }
    assert!(moved > 10, "{moved}");
}

pub(super) fn check_labels(state: &State) {
    assert!(state.is_complete());
    let mut areas = vec![0; state.plc.facets.len()];
    let mut edges: Map<(u32, [VertexId; 2]), u32> = Map::default();
    for (t, tet) in state.mesh.topology().iter() {
        let (word, v, own) = (state.marks.of(t), tet.vertices(), state.marks.region(t));
        for (slot, face) in tet.neighbours().into_iter().enumerate() {
            let other = state.marks.region(tet_of(face));
            let corners = FACE[slot].map(|k| v[k]);
            let [a, b, c] = corners;
            let key = triangle(a, b, c);
            assert_eq!(word & face_bit(slot) != 0, state.subfaces.contains_key(&key));
            assert_eq!(own != other, state.subfaces.contains_key(&key), "{t} {slot}");
            let Some(&f) = state.subfaces.get(&key) else { continue };
            let Some(patch) = &state.plc.facets[f as usize].patch else { continue };
            let sides = patch.sides.expect("known sides");
            if own != sides.inner {
                continue;
            }
            assert_eq!(other, sides.outer);
            let p = corners.map(|v| state.at(v));
            let [a, b, c] = [&p[0], &p[1], &p[2]].map(|p| flat(patch.axis, p));
            let area = turn(a, b, c);
            // The apex of a positively oriented tetrahedron is on the side that the face turns to
            // at odd slots.
            assert_eq!((slot % 2 == 1) == (area > 0), sides.upwards);
            areas[f as usize] += area.abs();
            for (side, _) in sides_of(key) {
                *edges.entry((f, side)).or_default() += 1;
            }
        }
    }
    for (f, facet) in (0u32..).zip(&state.plc.facets) {
        let Some(patch) = &facet.patch else { continue };
        assert_eq!(areas[f as usize], patch.area(), "the area of patch {f}");
    }
    for ((f, side), count) in edges {
        let on = state.segments.get(&side).map(|&s| &state.plc.segments[s as usize].facets);
        assert_eq!(count, if on.is_some_and(|on| on.contains(&f)) { 1 } else { 2 });
    }
}
