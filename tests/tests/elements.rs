//! The checker as a judge of finite element meshes: sound meshes of bodies of every shape pass, and
//! planted overlaps, hanging vertices and crossing edges are found, with no one accused in vain.

use ltbw::Point;
use ltbw_tests::families::Rng;
use ltbw_tests::overlap::overlap;
use ltbw_tests::overlaps::{OVERLAPS, is_overlapping};
use ltbw_tests::solids::{Solid, solids};
use ltbw_verify::{Kind, Level, Mesh, Options, Outcome, Report, check_elements};

fn judged(solid: &Solid) -> Report {
    check_elements(&Mesh::new(&solid.points, &solid.tets), &Options::default(), false)
}

#[test]
fn sound_meshes_pass() {
    let all = solids();
    assert!(all.len() > 100, "{}", all.len());
    let mut concave = 0;
    for (name, solid) in &all {
        let report = judged(solid);
        assert!(report.passed(), "{name}: {report}");
        assert_eq!(report.mirrored, name.ends_with("mirrored"), "{name}");
        let told = report.information.expect("always told");
        concave += usize::from(told.count(Kind::ConcaveHull) > 0);
        // Which of these are told is known by the name.
        let has = |kind: Kind| told.count(kind) > 0;
        // Voxels, and parts taken at random, may touch in an edge or not.
        if !name.starts_with("voxels") && !name.contains("at random") {
            let pinched = ["pinched edge", "all pinched"].iter().any(|word| name.starts_with(word));
            assert_eq!(has(Kind::HullEdge), pinched, "{name}");
        }
        let doubled = ["apart", "crack", "one cell", "materials", "parts", "touch"];
        let is_doubled = doubled.iter().any(|word| name.contains(word));
        assert_eq!(has(Kind::EqualVertices), is_doubled, "{name}");
        let spare = u64::from(name.starts_with("a point that nothing uses"));
        assert_eq!(report.counts.unused_points, spare, "{name}");
    }
    assert!(concave > 50, "{concave}");
}

/// 1,000 overlaps at least, of every kind; and what was planted and overlaps nothing is no overlap.
#[test]
fn planted_overlaps_are_found_and_no_others() {
    let all = solids();
    let mut rng = Rng::new(9);
    let (mut found, mut none) = ([0u32; OVERLAPS.len()], 0u32);
    for round in 0..100 {
        for (k, (plant, spoil)) in OVERLAPS.into_iter().enumerate() {
            let (name, solid) = &all[rng.below(all.len() as u64) as usize];
            let mut spoilt = solid.clone();
            let Some(changed) = spoil(&mut spoilt, &mut rng) else { continue };
            if !spoilt.points.iter().flatten().all(|c| c.is_finite()) {
                continue;
            }
            let report = judged(&spoilt);
            let told = report.count(Kind::Overlap);
            let why = || format!("{plant} in {name}, {round}: {report}");
            if report.count(Kind::DuplicateTet) > 0 {
                continue;
            }
            match is_overlapping(&spoilt, &changed) {
                true => {
                    assert!(told > 0 && !report.passed(), "overlooked: {}", why());
                    assert_eq!(report.level(Level::Overlap).outcome, Outcome::Failed);
                    found[k] += 1;
                }
                false => {
                    assert_eq!(told, 0, "accused in vain: {}", why());
                    none += 1;
                }
            }
            // Pairs that are told do overlap.
            for defect in report.defects.iter().filter(|d| d.kind == Kind::Overlap).take(3) {
                let [t, u] = [0, 1].map(|k| spoilt.corners(defect.tets[k] as usize));
                assert!(overlap(t, u), "{}", why());
            }
        }
    }
    for ((plant, _), count) in OVERLAPS.iter().zip(found) {
        println!("{plant}: {count} planted, all found");
        assert!(count >= 5, "{plant} grew only {count} times");
    }
    let sum: u32 = found.iter().sum();
    println!("{sum} overlaps, {none} that overlap nothing");
    assert!(sum >= 1000 && none > 20, "{sum} {none}");
}

/// Heaps of tetrahedra on few integer points: whatever meets there meets in every degenerate way.
#[test]
fn heaps_of_cells_are_judged_as_pair_by_pair() {
    let mut rng = Rng::new(3);
    let (mut overlapping, mut apart) = (0, 0);
    for round in 0..4000u64 {
        let (side, count) = (2 + round % 4, 2 + round / 4 % 7);
        let mut solid = Solid::default();
        for _ in 0..count {
            let corners = [0; 4].map(|_| [0; 3].map(|_| rng.below(side) as f64));
            let shared = round % 3 == 0;
            let vertex = |solid: &mut Solid, p: Point| {
                let known = solid.points.iter().position(|q| shared && *q == p);
                known.unwrap_or_else(|| {
                    solid.points.push(p);
                    solid.points.len() - 1
                }) as u32
            };
            let [a, b, c, d] = corners.map(|p| vertex(&mut solid, p));
            solid.tets.push([a, b, c, d]);
        }
        let options = Options { vertex_order: ltbw_verify::VertexOrder::Any, ..Options::default() };
        let report = check_elements(&Mesh::new(&solid.points, &solid.tets), &options, false);
        if report.count(Kind::DuplicateTet) > 0 {
            continue;
        }
        let all = solid.tets.len();
        let expected = (0..all).any(|t| is_overlapping(&solid, &[t]));
        assert_eq!(report.count(Kind::Overlap) > 0, expected, "{solid:?}: {report}");
        overlapping += u32::from(expected);
        apart += u32::from(!expected);
    }
    println!("{overlapping} heaps overlap, {apart} do not");
    assert!(overlapping > 500 && apart > 200);
}

/// Two boxes with one corner in common each, meshed on their own.
fn boxes(low: [f64; 3], mesh: impl Fn(Point) -> Point) -> Solid {
    let (name, block) = &solids()[0];
    assert!(name.starts_with("block"));
    let mut both = block.clone();
    let first = both.points.len() as u32;
    both.points.extend(block.points.iter().map(|&p| {
        let p = mesh(p);
        [0, 1, 2].map(|k| p[k] + low[k])
    }));
    both.tets.extend(block.tets.iter().map(|tet| tet.map(|v| v + first)));
    both
}

#[test]
fn vertices_that_hang_and_edges_that_cross_are_found() {
    let kinds = |solid: &Solid| {
        let report = judged(solid);
        [Kind::Overlap, Kind::HangingVertex, Kind::CrossingEdges].map(|kind| report.count(kind))
    };
    // On top of each other: in line, shifted by half a cube, twice as fine, mirrored.
    assert_eq!(kinds(&boxes([0.0, 0.0, 2.0], |p| p)), [0; 3]);
    let [overlaps, hanging, _] = kinds(&boxes([0.5, 0.0, 2.0], |p| p));
    assert!(overlaps == 0 && hanging > 0);
    let [overlaps, hanging, _] = kinds(&boxes([0.0, 0.0, 2.0], |p| p.map(|c| c / 2.0)));
    assert!(overlaps == 0 && hanging > 0);
    // The diagonals of the other box run the other way: no vertex hangs.
    let turned = |[x, y, z]: Point| [2.0 - y, x, z];
    assert_eq!(kinds(&boxes([0.0, 0.0, 2.0], turned)), [0, 0, 4]);
    // A corner inside a face, and edges that cross in one point.
    assert_eq!(kinds(&boxes([0.25, 0.5, 2.0], |[x, y, z]| [x + z, y - z / 2.0, z]))[0], 0);
    // A vertex of an edge that all its tetrahedra but one are cut at.
    let mut cut = solids()[0].1.clone();
    let [a, b, c, d] = cut.tets[0];
    let middle = [0, 1, 2].map(|k| {
        let [p, q] = [a, b].map(|v| cut.points[v as usize][k]);
        (p + q) / 2.0
    });
    cut.points.push(middle);
    let m = cut.points.len() as u32 - 1;
    cut.tets[0] = [a, m, c, d];
    cut.tets.push([m, b, c, d]);
    let report = judged(&cut);
    assert_eq!((report.count(Kind::HangingVertex), report.count(Kind::Overlap)), (1, 0));
    let hanging = report.defects.iter().find(|defect| defect.kind == Kind::HangingVertex);
    assert_eq!(hanging.expect("listed").vertices[0], m);
}
