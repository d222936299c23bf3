//! Surfaces as people bring them: prisms and spheres of rounded triangles, sheets hinged on a line.
//! Nothing of their boundary is ever lost, whatever becomes of the bounds.

use ltbw::Random;
use ltbw::domain::{Domain, Facet, PrepareOptions};
use ltbw::quality::Quality;
use ltbw::refine::{Excuse, Reason, RefineOutcome, Refined, Refiner};
use ltbw_generate::surfaces::{single, turned};
use ltbw_verify::{ConformityDefect, Limits, Mesh, Options, conforms};
use std::f64::consts::PI;

/// A domain of triangles.
fn surface(vertices: Vec<[f64; 3]>, triangles: &[[u32; 3]]) -> Domain {
    let mut domain = Domain { vertices, ..Domain::default() };
    domain.facets.extend(triangles.iter().map(|t| Facet::polygon(t, 0)));
    domain
}

/// Every vertex times 1 + `noise` · x with x even in -1..1.
fn shaken(domain: &mut Domain, noise: f64, seed: u64) {
    let mut random = Random::new(seed);
    for v in &mut domain.vertices {
        let factor = 1.0 + noise * (2.0 * random.unit() - 1.0);
        *v = v.map(|c| c * factor);
    }
}

/// A prism over a polygon of n corners: sides of two triangles each, caps as fans.
fn prism(n: u32, noise: f64, seed: u64) -> Domain {
    let ring = |z: f64| {
        (0..n).map(move |k| {
            let (sin, cos) = (2.0 * PI * f64::from(k) / f64::from(n)).sin_cos();
            [0.5 * cos, 0.5 * sin, z]
        })
    };
    let mut triangles = Vec::new();
    for k in 0..n {
        let l = (k + 1) % n;
        triangles.extend([[k, l, n + l], [k, n + l, n + k]]);
    }
    for k in 1..n - 1 {
        triangles.extend([[0, k + 1, k], [n, n + k, n + k + 1]]);
    }
    let mut domain = surface(ring(-0.5).chain(ring(0.5)).collect(), &triangles);
    shaken(&mut domain, noise, seed);
    domain
}

/// A sphere of n rings and n meridians with single-precision coordinates.
fn sphere(n: u32, noise: f64, seed: u64) -> Domain {
    let rings = n - 2;
    let mut vertices = vec![[0.0, 0.0, 0.5], [0.0, 0.0, -0.5]];
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
    let mut domain = surface(vertices, &triangles);
    shaken(&mut domain, noise, seed);
    domain
}

/// A box with sheets in it that are hinged on one line, 10 degrees apart.
fn book(sheets: u32) -> Domain {
    let vertices = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| f64::from(2 * b) - 1.0));
    let mut domain = Domain { vertices: vertices.collect(), ..Domain::default() };
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    domain.facets.extend(faces.map(|f| Facet::polygon(&f, 0)));
    domain.vertices.extend([[-0.5, 0.0, -0.5], [-0.5, 0.0, 0.5]]);
    for k in 0..sheets {
        let (sin, cos) = (10.0 * f64::from(k)).to_radians().sin_cos();
        let i = domain.vertices.len() as u32;
        domain.vertices.extend([-0.5, 0.5].map(|z| [cos - 0.5, sin, z]));
        domain.facets.push(Facet::polygon(&[8, 9, i + 1, i], 0));
    }
    domain
}

/// Refines and has the mesh judged: the boundary is all there, and exactly the excused tetrahedra
/// are over their bounds. Or the outcome says that the boundary could not be recovered.
fn certified(domain: &Domain, refiner: &Refiner<'_>, volume: Option<f64>, name: &str) -> Refined {
    certified_within(domain, refiner, volume, 0.0, name)
}

/// Refines and has the mesh judged, within the tolerance of the refiner.
fn certified_within(
    domain: &Domain,
    refiner: &Refiner<'_>,
    volume: Option<f64>,
    tolerance: f64,
    name: &str,
) -> Refined {
    let options = PrepareOptions { oriented: false, ..PrepareOptions::default() };
    let ready = domain.prepare(&options).expect("a sound domain");
    let refined = refiner.refine(&ready.domain, &ready.lattice).expect("a mesh");
    if refined.outcome == RefineOutcome::Unrecovered {
        assert!(!refined.lost.is_empty() && refined.num_tets() == 0, "{name}");
        return refined;
    }
    assert!(refined.lost.is_empty(), "{name}: {:?}", refined.lost.first());
    let mesh = refined.inside();
    let plc = ltbw_cli::plc_of(&ready.domain, tolerance);
    let limits = Limits { radius_edge: Some(2.0), max_volume: volume, ..Limits::default() };
    let view = Mesh::new(&mesh.points, &mesh.tets);
    let options = Options { numbered_regions: true, ..Options::default() };
    let found = conforms(&view, &plc, mesh.tet_tags.as_deref(), &limits, &options);
    assert_eq!(found.mesh_defect_count, 0, "{name}: {:?}", found.mesh_defects.first());
    let bounds = |b: &ConformityDefect| {
        matches!(b, ConformityDefect::RatioExceeded | ConformityDefect::VolumeExceeded)
    };
    assert!(found.counts.keys().all(bounds), "{name}: {:?}", found.findings.first());
    assert!(found.counts.values().all(|&n| n <= refined.excuses.len() as u64), "{name}");
    let own = ready.report.volume().expect("a volume").to_string();
    assert_eq!(found.patches > 0, refined.stats.flat_tolerance > 0.0, "{name}");
    let off = found.volume.expect("a volume").difference(&own).expect("a fraction");
    assert!(off <= found.volume_within, "{name}: {off:e} {:e}", found.volume_within);
    assert!(found.patches > 0 || found.volume_within == 0.0, "{name}");
    refined
}

/// All prisms were refused as not watertight when n was 12 or more and the noise not zero.
#[test]
fn prisms_of_rounded_triangles_are_meshed() {
    for n in [6, 12, 24] {
        for noise in [0.0, 1e-6, 1e-4, 1e-2] {
            let name = format!("prism of {n}, noise {noise:e}");
            let refined = certified(&prism(n, noise, 1), &Refiner::new(), None, &name);
            assert_ne!(refined.outcome, RefineOutcome::Unrecovered, "{name}: {:?}", refined.lost);
        }
    }
}

/// With noise 1e-2 some of the domain was taken for the exterior: a wrong mesh.
#[test]
fn noisy_spheres_keep_their_boundary() {
    for noise in [0.0, 1e-3, 1e-2] {
        let name = format!("sphere, noise {noise:e}");
        let refined = certified(&sphere(20, noise, 1), &Refiner::new(), None, &name);
        assert_ne!(refined.outcome, RefineOutcome::Unrecovered, "{name}: {:?}", refined.lost);
    }
}

/// The sheets took each other's triangles, down to the floor of edge lengths.
#[test]
fn sheets_hinged_on_a_line_do_not_displace_each_other() {
    let refined = certified(&book(6), &Refiner::new(), None, "book");
    assert_eq!(refined.outcome, RefineOutcome::Excused);
    assert!(refined.num_tets() <= 2000, "{}", refined.num_tets());
}

/// The least dihedral angle in degrees, and the largest circumradius to shortest edge.
fn shape(refined: &Refined) -> (f64, f64) {
    let mesh = refined.inside();
    let quality = Quality::of(&mesh.points, &mesh.tets).expect("tetrahedra");
    (quality.dihedral.least.value, quality.radius_edge.largest.value)
}

/// A torus of n meridians and m rings, quads cut in two.
fn torus(n: u32, m: u32) -> Domain {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    let angle = |k: u32, n: u32| (2.0 * PI * f64::from(k) / f64::from(n)).sin_cos();
    for i in 0..n {
        for j in 0..m {
            let ((y, x), (z, r)) = (angle(i, n), angle(j, m));
            let r = 1.0 + 0.3 * r;
            vertices.push([r * x, r * y, 0.3 * z].map(|c| f64::from(c as f32)));
            let at = |i: u32, j: u32| (i % n) * m + j % m;
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    surface(vertices, &triangles)
}

const FLAT: f64 = 5e-7;

/// A bored flange of n sides, turned about the axis (1, 2, 3): its planes are planes up to
/// rounding, and many of its corners are on one sphere.
fn flange(n: u32, degrees: f64) -> Domain {
    let profile = [[0.2, 0.0], [0.5, 0.0], [0.5, 0.1], [0.3, 0.1], [0.3, 0.8], [0.2, 0.8]];
    let k = profile.len() as u32;
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let axis = [1.0, 2.0, 3.0].map(|c: f64| c / 14.0_f64.sqrt());
    let mut vertices = Vec::new();
    for side in 0..n {
        let (y, x) = (2.0 * PI * f64::from(side) / f64::from(n)).sin_cos();
        for [r, z] in profile {
            let p = [r * x, r * y, z];
            let along = [0, 1, 2].map(|i| axis[i] * p[i]).iter().sum::<f64>() * (1.0 - cosine);
            vertices.push([0, 1, 2].map(|k: usize| {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                p[k] * cosine + (axis[i] * p[j] - axis[j] * p[i]) * sine + axis[k] * along
            }));
        }
    }
    let at = |side: u32, j: u32| side % n * k + j % k;
    let quads = (0..n).flat_map(|side| (0..k).map(move |j| (side, j)));
    let triangles: Vec<[u32; 3]> = quads
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    surface(vertices, &triangles)
}

/// One tetrahedron of four corners of a trapezoid, of some 1e-6 degrees, was left: every point for
/// it made tetrahedra over their bounds, which could have been split.
#[test]
fn hardly_anything_flat_is_left_of_turned_flanges() {
    let mut flat = 0;
    for (n, degrees) in [(8, 10.0), (8, 30.0), (12, 10.0), (16, 50.0), (24, 30.0)] {
        let name = format!("flange of {n} sides, turned by {degrees} degrees");
        let refiner = Refiner::new().flat_tolerance(FLAT);
        let refined = certified_within(&flange(n, degrees), &refiner, None, FLAT, &name);
        assert_eq!(refined.outcome, RefineOutcome::Met, "{name}");
        let (angle, _) = shape(&refined);
        assert!(angle >= 8.0 || !refined.slivers.is_empty(), "{name}: {angle} degrees");
        flat += refined.slivers.len();
    }
    // No point at all serves this one, between four segments of an octagon.
    assert!(flat <= 1, "{flat} slivers");
}

/// Folds of the last bit of a float were segments: dihedral angles of 1e-7 degrees, and twice the
/// tetrahedra.
#[test]
fn spheres_of_quads_cut_in_two_are_small_and_round() {
    let refiner = Refiner::new().flat_tolerance(FLAT);
    for n in [12, 20, 30] {
        let name = format!("sphere of {n}");
        let domain = sphere(n, 0.0, 1);
        let refined = certified_within(&domain, &refiner, None, FLAT, &name);
        let exact = certified(&domain, &Refiner::new(), None, &name);
        assert!(refined.stats.patches > 0, "{name}");
        assert!(refined.num_tets() < exact.num_tets(), "{name}: {}", refined.num_tets());
        // TetGen makes 3,907 of a sphere of 30 rings.
        assert!(n < 30 || refined.num_tets() * 2 <= 3 * 3907, "{}", refined.num_tets());
        // Where the edges of the poles' triangles meet at 12 degrees, bounds are excused.
        assert!(
            refined.excuses.len() * 40 <= refined.num_tets(),
            "{name}: {}",
            refined.excuses.len()
        );
        let corner = |e: &Excuse| matches!(e.reason, Reason::SmallFaceAngle { corner: 0 | 1 });
        assert!(refined.excuses.iter().all(corner), "{name}: {:?}", refined.excuses);
    }
}

#[test]
fn tori_of_quads_cut_in_two_are_met() {
    let refiner = Refiner::new().flat_tolerance(FLAT);
    let refined = certified_within(&torus(24, 24), &refiner, None, FLAT, "torus");
    assert_eq!(refined.outcome, RefineOutcome::Met);
    let (angle, ratio) = shape(&refined);
    // Slivers are split as long as that makes no others.
    assert!(angle > 0.999 && ratio <= 2.0, "{angle} {ratio}");
}

#[test]
fn prisms_within_the_tolerance_are_small_and_round() {
    let refiner = Refiner::new().flat_tolerance(FLAT);
    for n in [12, 24, 48] {
        for (noise, seed) in [(1e-8, 1), (1e-7, 0), (1e-7, 1), (1e-7, 2)] {
            let name = format!("prism of {n}, noise {noise:e}, {seed}");
            let refined = certified_within(&prism(n, noise, seed), &refiner, None, FLAT, &name);
            let few = refined.excuses.len() * 50 <= refined.num_tets();
            assert!(
                refined.stats.patches > 0 && (few || noise > 1e-8),
                "{name}: {:?}",
                refined.excuses
            );
            assert!(noise > 1e-8 || shape(&refined).0 > 0.01, "{name}: {:?}", shape(&refined));
        }
    }
}

/// Noise that is within the tolerance leaves no needles: without it 96 angles of the facets of a
/// prism of 24 sides are too small for the bound, whatever is inserted.
#[test]
fn prisms_of_noise_within_the_tolerance_meet_every_bound() {
    for n in [12, 24, 48] {
        for (noise, seed) in [(1e-6, 0), (1e-6, 1), (1e-4, 0), (1e-4, 1)] {
            let (name, tolerance) = (format!("prism of {n}, noise {noise:e}"), 3.0 * noise);
            let refiner = Refiner::new().flat_tolerance(tolerance);
            let domain = prism(n, noise, seed);
            let refined = certified_within(&domain, &refiner, None, tolerance, &name);
            assert_eq!(refined.outcome, RefineOutcome::Met, "{name}");
            assert!(refined.num_tets() < 45 * n as usize, "{name}: {}", refined.num_tets());
        }
    }
}

/// A box of height 1 with pockets in its top, between every other pair of these numbers.
fn pockets(x: &[f64], y: &[f64], depth: f64) -> Domain {
    let (columns, rows) = (x.len() as u32, y.len() as u32);
    let mut vertices = Vec::new();
    x.iter().for_each(|&x| vertices.extend(y.iter().map(|&y| [x, y, 1.0])));
    let top = |i: u32, j: u32| i * rows + j;
    let mut triangles = Vec::new();
    for i in 0..columns - 1 {
        for j in 0..rows - 1 {
            let edge = [top(i, j), top(i + 1, j), top(i + 1, j + 1), top(i, j + 1)];
            let [a, b, c, d] = edge;
            if i % 2 == 0 || j % 2 == 0 {
                triangles.extend([[a, b, c], [a, c, d]]);
                continue;
            }
            let first = vertices.len() as u32;
            let floor = edge.map(|v| vertices[v as usize]).map(|[x, y, z]| [x, y, z - depth]);
            vertices.extend(floor);
            triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| first + k)));
            for k in 0..4 {
                let l = (k + 1) % 4;
                let [a, b] = [edge[k as usize], edge[l as usize]];
                triangles.extend([[a, b, first + l], [a, first + l, first + k]]);
            }
        }
    }
    let base = vertices.len() as u32;
    let corners = [[0, 0], [columns - 1, 0], [columns - 1, rows - 1], [0, rows - 1]];
    let corners = corners.map(|[i, j]| vertices[top(i, j) as usize]);
    vertices.extend(corners.map(|[x, y, _]| [x, y, 0.0]));
    triangles.extend([[0, 2, 1], [0, 3, 2]].map(|t| t.map(|k| base + k)));
    let sides: [Vec<u32>; 4] = [
        (0..columns).map(|i| top(i, 0)).collect(),
        (0..rows).map(|j| top(columns - 1, j)).collect(),
        (0..columns).rev().map(|i| top(i, rows - 1)).collect(),
        (0..rows).rev().map(|j| top(0, j)).collect(),
    ];
    for (k, side) in (0..).zip(sides) {
        let [p, q] = [base + k, base + (k + 1) % 4];
        triangles.extend(side.windows(2).map(|pair| [p, pair[1], pair[0]]));
        triangles.push([p, q, side[side.len() - 1]]);
    }
    surface(vertices, &triangles)
}

/// Flat tetrahedra lie over the edges of the pockets: faces between two of them were taken for
/// parts of the top, and faces of nearly collinear corners, which was given up for that.
#[test]
fn turned_boxes_with_pockets_have_all_their_patches() {
    let grids = [
        ([0.0, 0.19, 0.44, 0.56, 0.77, 1.0], [0.0, 0.18, 0.4, 0.65, 0.81, 1.0]),
        ([0.0, 0.18, 0.4, 0.61, 0.8, 1.0], [0.0, 0.13, 0.33, 0.67, 0.81, 1.0]),
    ];
    for (x, y) in grids {
        let domain = single(turned(&pockets(&x, &y, 0.5)));
        let refiner = Refiner::new().flat_tolerance(FLAT);
        let refined = certified_within(&domain, &refiner, None, FLAT, "pockets");
        let stats = refined.stats;
        assert!(stats.patches > 20 && stats.patches_given_up == 0, "{stats:?}");
        assert_eq!(refined.outcome, RefineOutcome::Met, "{:?}", refined.excuses);
    }
}

/// The centres of triangles between the long edges of a low step lie outside the box of the
/// lattice: such a triangle was refused, and with it the tetrahedron that asked for it.
#[test]
fn triangles_with_centres_far_outside_are_split() {
    let x = [0.0, 0.07, 0.419, 0.665, 0.801, 1.0];
    let y = [0.0, 0.124, 0.34, 0.648, 0.908, 1.0];
    let refined = certified(&pockets(&x, &y, 0.03), &Refiner::new(), None, "low steps");
    assert_eq!(refined.outcome, RefineOutcome::Met);
}

/// A mesh with bounds on volumes takes many points on patches.
#[test]
fn points_on_patches_lie_on_their_polygons() {
    let refiner = Refiner::new().flat_tolerance(FLAT).max_volume(1e-3);
    for (noise, seed) in [(1e-8, 3), (1e-7, 4)] {
        let domain = prism(8, noise, seed);
        let refined = certified_within(&domain, &refiner, Some(1e-3), FLAT, "fine prism");
        assert_eq!(refined.outcome, RefineOutcome::Met);
        assert!(refined.stats.facet_points > 50, "{:?}", refined.stats);
    }
}

/// A sheet has the same cell on both sides: no patch; its neighbours have none, either.
#[test]
fn sheets_are_no_patches() {
    let mut domain = book(0);
    let corners = [[-0.5, -0.5, 0.0], [0.5, -0.5, 1e-8], [0.5, 0.5, 0.0], [-0.5, 0.5, 1e-8]];
    let first = domain.vertices.len() as u32;
    domain.vertices.truncate(8);
    let first = first.min(8);
    domain.vertices.extend(corners);
    for t in [[0, 1, 2], [0, 2, 3]] {
        domain.facets.push(Facet::polygon(&t.map(|k| first + k), 0));
    }
    let refiner = Refiner::new().flat_tolerance(FLAT);
    let refined = certified_within(&domain, &refiner, None, FLAT, "a sheet");
    assert_eq!((refined.stats.patches, refined.stats.flat_tolerance), (0, 0.0));
}

#[test]
fn tolerances_that_are_none_are_refused() {
    let ready = prism(6, 0.0, 1).prepare(&PrepareOptions::default()).expect("a sound domain");
    for tolerance in [-1e-9, f64::NAN, f64::INFINITY, 0.01] {
        let refiner = Refiner::new().flat_tolerance(tolerance);
        let error = refiner.refine(&ready.domain, &ready.lattice).expect_err("no tolerance");
        assert!(error.to_string().contains("flat-tolerance"), "{error}");
    }
}

/// The checker finds what is wrong with the tiles of a patch.
#[test]
fn wrong_tiles_of_a_patch_are_found() {
    let domain = prism(8, 1e-7, 1);
    let ready = domain.prepare(&PrepareOptions::default()).expect("a sound domain");
    let refined = Refiner::new()
        .flat_tolerance(FLAT)
        .max_volume(1e-3)
        .refine(&ready.domain, &ready.lattice)
        .expect("a mesh");
    let mesh = refined.inside();
    let judge = |tets: &[[u32; 4]], tolerance: f64| {
        let plc = ltbw_cli::plc_of(&ready.domain, tolerance);
        let view = Mesh::new(&mesh.points, tets);
        conforms(&view, &plc, None, &Limits::default(), &Options::default())
    };
    let found = judge(&mesh.tets, FLAT);
    assert!(found.passed() && found.patches >= 2, "{:?}", found.findings);
    // Exact facets have edges that the mesh does not have.
    assert!(!judge(&mesh.tets, 0.0).passed());
    // Every tetrahedron on the boundary is missed.
    let boundary: std::collections::BTreeSet<usize> =
        refined.boundary().iter().map(|face| face.tet).collect();
    for hole in boundary {
        let mut tets = mesh.tets.clone();
        tets.remove(hole);
        assert!(!judge(&tets, FLAT).passed(), "without tetrahedron {hole}");
    }
}

/// Points that are given are finer than the corners of facets, by which the checker finds patches.
#[test]
fn points_are_given_in_a_surface_with_patches() {
    let mut domain = flange(8, 30.0);
    let mut random = Random::new(3);
    domain.points = (0..300).map(|_| [0.0; 3].map(|_: f64| 1.2 * random.unit() - 0.4)).collect();
    let triangles = domain.facets.iter().map(|facet| facet.polygons[0].clone());
    let middles: Vec<[f64; 3]> = triangles
        .map(|t| {
            let at =
                |k: usize| t.iter().map(|&v| domain.vertices[v as usize][k]).sum::<f64>() / 3.0;
            [at(0), at(1), at(2)]
        })
        .collect();
    domain.points.extend(middles);
    let refiner = Refiner::new().flat_tolerance(FLAT);
    let refined = certified_within(&domain, &refiner, None, FLAT, "flange with points");
    assert!(matches!(refined.outcome, RefineOutcome::Met | RefineOutcome::Excused));
    let more = refined.mesh().num_vertices() - domain.vertices.len();
    assert!(more >= domain.facets.len(), "{more} vertices more");
}
