//! Small angles of the input: what is excused there, and what is met elsewhere.

use super::{ready, refine};
use crate::late::again::Asking;
use crate::late::relief::{Goal, Relief};
use crate::mesh::item::Item;
use crate::queue::split::Refinement;
use crate::run::Run;
use crate::{Reason, RefineOutcome, Refined, Refiner};
use ltbw_core::invariants::check_all;
use ltbw_core::topology::TetId;
use ltbw_domain::{Domain, Facet, PrepareOptions, Prepared};
use ltbw_exact::Point;
use ltbw_generate::{DomainKind, Shape, surfaces};

fn wedge(angle: f64) -> Prepared {
    ready(DomainKind::Wedge, &Shape { angle: Some(angle), ..Shape::default() })
}

/// The points that were inserted.
fn points(refined: &Refined) -> u64 {
    let stats = refined.stats;
    stats.segment_points + stats.facet_points + stats.free_points
}

/// A prism of rounded triangles.
fn prism(corners: u32, noise: f64, seed: u64) -> Prepared {
    // The generator was built on another instance of this crate, whose types are not these.
    let made = surfaces::prism(corners, noise, seed);
    let mut domain = Domain { vertices: made.vertices, ..Domain::default() };
    domain.facets.extend(made.facets.iter().map(|f| Facet::polygon(&f.polygons[0], 0)));
    domain.prepare(&PrepareOptions::default()).expect("a sound domain")
}

/// A sphere by latitude and longitude, of 30 rings and meridians.
fn globe(noise: f64) -> Prepared {
    globe_of(noise, 0)
}

fn globe_of(noise: f64, seed: u64) -> Prepared {
    let made = surfaces::single(surfaces::globe(30, 30, noise, seed));
    let mut domain = Domain { vertices: made.vertices, ..Domain::default() };
    domain.facets.extend(made.facets.iter().map(|f| Facet::polygon(&f.polygons[0], 0)));
    domain.prepare(&PrepareOptions::default()).expect("a sound domain")
}

/// A cone of `n` triangles on a band of rings, each `step` below the one before, with a flat base.
fn cone(n: u32, height: f64, rings: u32, step: f64) -> Prepared {
    let mut domain = Domain { vertices: vec![[0.0, 0.0, height]], ..Domain::default() };
    for ring in 0..=rings {
        for k in 0..n {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(n)).sin_cos();
            domain.vertices.push([0.5 * cos, 0.5 * sin, -step * f64::from(ring)]);
        }
    }
    let at = |ring: u32, k: u32| 1 + ring * n + k % n;
    for k in 0..n {
        domain.facets.push(Facet::polygon(&[0, at(0, k), at(0, k + 1)], 0));
        for r in 0..rings {
            let side = [at(r, k), at(r + 1, k), at(r + 1, k + 1), at(r, k + 1)];
            domain.facets.push(Facet::polygon(&side, 0));
        }
    }
    let base: Vec<u32> = (0..n).rev().map(|k| at(rings, k)).collect();
    domain.facets.push(Facet::polygon(&base, 0));
    domain.prepare(&PrepareOptions::default()).expect("a sound domain")
}

/// The numbers of tetrahedra are those from before small angles got rules of their own.
#[test]
fn wedges_from_25_degrees_on_meet_every_bound() {
    for (angle, count) in [(25.0, 404.0), (30.0, 468.0), (45.0, 657.0), (60.0, 789.0)] {
        let refined = refine(&Refiner::new().max_volume(1e-3).min_dihedral(0.0), &wedge(angle));
        assert_eq!(refined.outcome, RefineOutcome::Met, "{angle}");
        let tets = refined.num_tets() as f64;
        assert!((tets / count - 1.0).abs() <= 0.02, "{angle}: {tets}");
        assert_eq!(refine(&Refiner::new(), &wedge(angle)).num_tets(), 3, "{angle}");
    }
}

/// A prism over a triangle or rhombus with this angle; `lean`: the edges of the sides leave the
/// base's edge along x at this angle, too, not at a right one.
fn prism_of(angle: f64, rhombus: bool, lean: bool) -> Prepared {
    let (sin, cos) = angle.to_radians().sin_cos();
    let mut base = vec![[0.0, 0.0], [1.0, 0.0], [cos, sin]];
    if rhombus {
        base.insert(2, [1.0 + cos, sin]);
    }
    let n = base.len() as u32;
    let (along, up) = if lean { (cos, sin) } else { (0.0, 1.0) };
    let mut domain = Domain::default();
    domain.vertices.extend(base.iter().map(|&[x, y]| [x, y, 0.0]));
    domain.vertices.extend(base.iter().map(|&[x, y]| [x + along, y, up]));
    let mut polygons: Vec<Vec<u32>> = vec![(0..n).rev().collect(), (n..2 * n).collect()];
    polygons.extend((0..n).map(|k| (k, (k + 1) % n)).map(|(k, l)| vec![k, l, n + l, n + k]));
    domain.facets.extend(polygons.iter().map(|polygon| Facet::polygon(polygon, 0)));
    domain.prepare(&PrepareOptions::default()).expect("a sound domain")
}

/// Between 20 degrees and those of the theory nothing is excused, in rounds or before them.
#[test]
fn prisms_from_25_degrees_on_meet_every_bound() {
    for angle in [25.0, 30.0, 45.0, 60.0] {
        for (rhombus, lean) in [(false, false), (true, false), (false, true), (true, true)] {
            let ready = prism_of(angle, rhombus, lean);
            for (start, volume) in [usize::MAX, 0].map(|e| [(e, 1.0), (e, 1e-3)]).as_flattened() {
                let refined = refine(&Refiner::new().start(*start).max_volume(*volume), &ready);
                check_all(refined.mesh()).expect("invariants of the mesh");
                let name = format!("{angle} {rhombus} {lean} {start} {volume}");
                assert_eq!(refined.outcome, RefineOutcome::Met, "{name}");
                assert!(refined.excuses.is_empty() && refined.excused().is_empty(), "{name}");
            }
        }
    }
}

/// They took 5 to 6 points, and four times as many tetrahedra were excused.
#[test]
fn wedges_too_thin_for_their_bound_of_shape_are_left_as_they_are() {
    for angle in [0.1, 1.0, 5.0, 10.0, 14.0] {
        let refined = refine(&Refiner::new(), &wedge(angle));
        check_all(refined.mesh()).expect("invariants of the mesh");
        assert_eq!((points(&refined), refined.num_tets()), (0, 3), "{angle}");
        assert_eq!(refined.outcome, RefineOutcome::Excused, "{angle}");
    }
    // With another bound on shapes another angle is too small: none of these wedges is over it.
    assert_eq!(refine(&Refiner::new().radius_edge(6.0), &wedge(10.0)).outcome, RefineOutcome::Met);
    assert!(points(&refine(&Refiner::new(), &wedge(15.0))) > 0, "it may be met, but for rounding");
}

/// The number of tetrahedra inside that are larger than a volume, but for rounding.
pub(super) fn larger(refined: &Refined, volume: f64) -> usize {
    refined.tets().filter(|&t| refined.volume_of(t) > volume * (1.0 + 1e-9)).count()
}

/// Wedges of up to 7 degrees were left as they are, six tetrahedra of which all were too large.
#[test]
fn bounds_on_volumes_are_met_at_small_angles() {
    for angle in [1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 14.0] {
        for volume in [1e-2, 1e-3, 1e-4] {
            let refined = refine(&Refiner::new().max_volume(volume), &wedge(angle));
            check_all(refined.mesh()).expect("invariants of the mesh");
            assert_eq!(larger(&refined, volume), 0, "{angle} {volume:e}");
        }
    }
    for angle in [1.0, 2.0, 5.0, 10.0] {
        let spike = ready(DomainKind::Spike, &Shape { angle: Some(angle), ..Shape::default() });
        let refined = refine(&Refiner::new().max_volume(1e-4), &spike);
        check_all(refined.mesh()).expect("invariants of the mesh");
        assert_eq!(larger(&refined, 1e-4), 0, "spike {angle}");
    }
}

/// The sheets kept each other from being split, whatever was asked for far from the hinge: 12 to
/// 29 % of all volume were in tetrahedra over a bound, most of them too large.
#[test]
fn sheets_at_small_angles_are_refined_to_their_size() {
    for (sheets, angle, most) in [(2, 1.0, 0.01), (2, 12.0, 0.01), (3, 5.0, 0.02), (6, 10.0, 0.04)]
    {
        let ready = surface!(surfaces::book(sheets, angle));
        let name = format!("{sheets} sheets, {angle} degrees");
        let refined = refine(&Refiner::new().max_volume(5e-3), &ready);
        check_all(refined.mesh()).expect("invariants of the mesh");
        assert_eq!(larger(&refined, 5e-3), 0, "{name}");
        let excused: f64 = refined.excused().iter().map(|own| own.volume).sum();
        assert!(excused <= most * refined.volume(), "{name}: {excused:e}");
        let is_named = |r: Reason| r.is_corner() || r.is_segment();
        assert!(refined.excuses.iter().all(|e| is_named(e.reason)), "{name}");
    }
}

/// Lengths are asked for as volumes are.
#[test]
fn lengths_are_met_at_small_angles() {
    let length = 0.2_f64;
    let volume = (1.18 * length).powi(3) * 2.0_f64.sqrt() / 12.0;
    let field = |_: Point| length;
    for ready in [surface!(surfaces::book(2, 8.0)), wedge(6.0)] {
        let refined = refine(&Refiner::new().sizing(&field), &ready);
        assert!(points(&refined) > 0);
        assert_eq!(larger(&refined, volume), 0);
    }
}

/// 187 and 267 tetrahedra were excused.
#[test]
fn the_tips_of_a_cone_are_excused_once() {
    for height in [1.0, 2.0] {
        let refined = refine(&Refiner::new(), &cone(48, height, 0, 0.0));
        assert!(refined.excuses.len() <= 48, "{height}: {}", refined.excuses.len());
        assert!(refined.num_tets() <= 60, "{height}: {}", refined.num_tets());
        let apex = |r| matches!(r, Reason::SmallFaceAngle { corner: 0 });
        assert!(refined.excuses.iter().all(|e| apex(e.reason)), "{height}");
    }
}

/// The facets of a cone were related to each other everywhere since they meet at the apex: 79
/// tetrahedra, most of them near the base, were excused.
#[test]
fn needles_are_refined_far_from_their_tips() {
    let refined = refine(&Refiner::new(), &cone(24, 1.0, 4, 0.02));
    check_all(refined.mesh()).expect("invariants of the mesh");
    assert!(refined.excuses.len() <= 48, "{}", refined.excuses.len());
}

/// Where one needle was cut its neighbours could not follow: 288 tetrahedra were excused.
#[test]
fn needles_are_cut_alike_or_not_at_all() {
    let refined = refine(&Refiner::new(), &cone(48, 2.0, 1, 0.05));
    check_all(refined.mesh()).expect("invariants of the mesh");
    assert!(refined.excuses.len() <= 230, "{}", refined.excuses.len());
    let apex = |r| matches!(r, Reason::SmallFaceAngle { corner: 0 });
    assert!(refined.excuses.iter().all(|e| apex(e.reason)));
}

/// Subsegments at one corner displaced each other, and refused each other for it, and with them all
/// that waited for them: 170 and 244 tetrahedra were excused.
#[test]
fn subsegments_at_a_small_angle_are_split_together() {
    for (corners, noise, seed, most) in [(12, 1e-6, 1, 62), (16, 1e-2, 2, 112)] {
        let ready = prism(corners, noise, seed);
        let refined = refine(&Refiner::new(), &ready);
        check_all(refined.mesh()).expect("invariants of the mesh");
        assert!(refined.excuses.len() <= most, "{corners}: {}", refined.excuses.len());
        let is_named = |r: Reason| r.is_corner() || r.is_segment();
        assert!(refined.excuses.iter().all(|e| is_named(e.reason)), "{corners}");
    }
}

/// A wedge is excused as a whole, so that the volumes by corner and segment are that of the wedge.
#[test]
fn excuses_are_counted_by_corner_and_segment_with_their_volume() {
    let refined = refine(&Refiner::new(), &wedge(5.0));
    let all = refined.excused();
    assert_eq!(all.iter().map(|e| e.tets).sum::<usize>(), refined.excuses.len());
    assert!(all.iter().any(|e| e.reason.is_corner()) && all.iter().any(|e| e.reason.is_segment()));
    assert!(all.windows(2).all(|pair| pair[0].reason < pair[1].reason));
    let mesh = refined.mesh();
    let volume = |t: [u32; 4]| {
        let [a, b, c, d] = t.map(|v| mesh.point(v).expect("a vertex"));
        let [u, v, w] = [b, c, d].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
        let (x, y) = (v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2]);
        (u[0] * x + u[1] * y + u[2] * (v[0] * w[1] - v[1] * w[0])).abs() / 6.0
    };
    let whole: f64 = refined.tets().filter_map(|t| refined.tet(t)).map(volume).sum();
    let told: f64 = all.iter().map(|e| e.volume).sum();
    assert!((told / whole - 1.0).abs() < 1e-9, "{told:e} {whole:e}");
    assert!((refined.volume() / whole - 1.0).abs() < 1e-12, "{whole:e}");
}

/// The tetrahedra over their bounds, by brute force.
pub(super) fn over(run: &Run<'_>) -> Vec<Item> {
    let (state, bounds) = (&run.refinement.state, run.refinement.bounds.as_ref());
    let bounds = bounds.expect("the boundary is complete");
    let is_over = |&t: &TetId| bounds.is_over(state, t);
    state.mesh.tet_ids().filter(is_over).map(|t| Item::Tet(t, state.vertices(t))).collect()
}

/// Relieves tetrahedra while that makes those that the goal asks for fewer.
pub(super) fn relieve(run: &mut Run<'_>, goal: Goal) {
    let mut relief = Relief::new(goal, &run.refinement);
    while relief.next(&mut run.refinement).is_some() {}
}

/// Asks refused tetrahedra for shorter edges as often as that is of use.
fn insist(run: &mut Run<'_>) {
    let mut asking = Asking::default();
    loop {
        let asked = run.refinement.insist(&mut asking);
        if asked.is_empty() {
            return;
        }
        for t in asked {
            run.work.put(Item::Tet(t, run.refinement.state.vertices(t)), 1.0);
        }
        run.refine(usize::MAX).expect("no error");
    }
}

#[test]
fn relief_makes_fewer_tetrahedra_over_their_bounds() {
    for (corners, noise, seed) in [(12, 1e-6, 1), (16, 1e-2, 2), (24, 1e-4, 0)] {
        let ready = prism(corners, noise, seed);
        let recovered = Refiner::new().recovered(&ready.domain, &ready.lattice);
        let (mut run, _) = recovered.expect("a sound domain");
        run.refine(usize::MAX).expect("no error");
        let (before, points) = (over(&run).len(), run.refinement.inserted.points.total());
        relieve(&mut run, Goal::Bounds);
        let (after, state) = (over(&run), &run.refinement.state);
        let points = run.refinement.inserted.points.total() - points;
        assert!(points > 0 && points as usize <= 2 * before, "{corners}: {points}");
        assert!(after.len() * 4 <= before * 3, "{corners}: {before} {}", after.len());
        // The boundary is complete, labels change at it alone, and all that is over has a reason.
        assert!(state.is_complete(), "{corners}");
        assert!(state.is_labelled(state.mesh.tet_ids()), "{corners}");
        let refused = &run.refinement.record.refused;
        assert!(after.iter().all(|item| refused.contains_key(item)), "{corners}");
    }
}

/// On a part of 1,000 triangles one tip that was not cut left 54 tetrahedra over their bounds.
#[test]
fn many_refused_at_one_corner_are_asked_again() {
    for (corners, noise, seed) in [(24, 1e-2, 0), (24, 1e-2, 1), (24, 1e-6, 1)] {
        let ready = prism(corners, noise, seed);
        let recovered = Refiner::new().recovered(&ready.domain, &ready.lattice);
        let (mut run, _) = recovered.expect("a sound domain");
        run.refine(usize::MAX).expect("no error");
        relieve(&mut run, Goal::Bounds);
        let (before, tets) = (over(&run).len(), run.refinement.state.mesh.num_tets());
        insist(&mut run);
        relieve(&mut run, Goal::Bounds);
        let (after, state) = (over(&run), &run.refinement.state);
        assert!(after.len() * 10 <= before * 9, "{seed}: {before} {}", after.len());
        assert!(state.mesh.num_tets() <= 2 * tets, "{seed}: {tets}");
        // The boundary is complete, labels change at it alone, and all that is over has a reason.
        assert!(state.is_complete(), "{seed}");
        assert!(state.is_labelled(state.mesh.tet_ids()), "{seed}");
        let refused = &run.refinement.record.refused;
        assert!(after.iter().all(|item| refused.contains_key(item)), "{seed}");
    }
}

/// Needles at the poles were halved one by one for the sake of what was beside them, which left
/// flat tetrahedra with ratios of 700 over the folds between them.
#[test]
fn needles_around_a_pole_stay_whole() {
    let ready = globe(0.0);
    for start in [usize::MAX, 0] {
        let refined = refine(&Refiner::new().start(start).flat_tolerance(1e-6), &ready);
        let slivers = &refined.slivers;
        assert!(slivers.len() <= 10, "{start}: {slivers:?}");
        assert!(slivers.iter().all(|own| own.angle >= 1.0), "{start}: {slivers:?}");
        // There are 60 tips, and two have a tetrahedron in common only where it is flat.
        let excused = refined.excuses.len();
        assert!((60..=63).contains(&excused), "{start}: {excused}");
        assert!(refined.num_tets() < 4500, "{start}: {}", refined.num_tets());
    }
}

/// Needles that are folded narrowly around the poles were cut nearer and nearer to them, down to
/// the floor, and 7 to 17 triangles were missing in the end.
#[test]
fn narrow_folds_around_a_corner_are_recovered_by_points_on_arcs() {
    for (seed, start) in [1, 2, 3].map(|s| [(s, usize::MAX), (s, 0)]).into_iter().flatten() {
        let ready = globe_of(3e-2, seed);
        let refined = refine(&Refiner::new().start(start).flat_tolerance(1e-6), &ready);
        check_all(refined.mesh()).expect("invariants of the mesh");
        assert_eq!(refined.outcome, RefineOutcome::Excused, "{seed}: {:?}", refined.lost.first());
        let elsewhere = refined.excuses.iter().filter(|e| !e.reason.is_corner()).count();
        assert!(elsewhere <= 6, "{seed} {start}: {elsewhere}");
        assert!(
            refined.excuses.len() * 100 <= refined.num_tets(),
            "{seed}: {}",
            refined.excuses.len()
        );
        assert!(refined.num_tets() < 10_000, "{seed}: {}", refined.num_tets());
    }
}

#[test]
fn folds_between_four_vertices_on_a_circle_leave_few_slivers() {
    let ready = globe(1e-3);
    let recovered = Refiner::new().min_dihedral(1.0).recovered(&ready.domain, &ready.lattice);
    let (mut run, _) = recovered.expect("a sound domain");
    run.refine(usize::MAX).expect("no error");
    let slivers = |run: &Run<'_>| {
        let Refinement { state, bounds, .. } = &run.refinement;
        let bounds = bounds.as_ref().expect("bounds");
        state.mesh.tet_ids().filter(|&t| state.is_sliver(t, bounds)).count()
    };
    let (before, bad) = (slivers(&run), over(&run).len());
    relieve(&mut run, Goal::Angles);
    let (after, state) = (slivers(&run), &run.refinement.state);
    assert!(before > 300 && after <= 10, "{before} {after}");
    assert!(over(&run).len() <= bad, "{} {bad}", over(&run).len());
    assert!(state.is_complete() && state.is_labelled(state.mesh.tet_ids()));
    let refused = &run.refinement.record.refused;
    assert!(over(&run).iter().all(|item| refused.contains_key(item)));
}

/// A wall of 1/4000 of a cube's side did not end in a minute: it takes a million tetrahedra.
#[test]
fn walls_too_thin_to_be_refined_are_excused_by_name() {
    let made = surfaces::shell(0.00025);
    let mut domain = Domain { vertices: made.vertices, ..Domain::default() };
    domain.facets.extend(made.facets.iter().map(|f| Facet::polygon(&f.polygons[0], 0)));
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refined = refine(&Refiner::new(), &ready);
    check_all(refined.mesh()).expect("invariants of the mesh");
    assert_eq!(refined.outcome, RefineOutcome::Excused);
    assert!(refined.num_tets() < 1000, "{}", refined.num_tets());
    assert!(refined.excuses.iter().all(|e| e.reason != Reason::Rounding));
}
