//! Every planted defect is found by the checker, at the right level and under the right name, on
//! meshes of every kind: each plant at many places of each mesh, with and without claimed
//! neighbours, at both depths.

use ltbw::{Builder, Point, PointSet};
use ltbw_tests::families::{Rng, Size, all, grid, scaled, snapped, spheres, uniform, wide};
use ltbw_tests::plant::{
    Among, Deal, PLANTS, Subject, try_plant, try_plant_elements, try_plant_in_parts,
};
use ltbw_verify::Depth;

/// Places tried for each plant on each mesh, until it has grown at [`ENOUGH`] places.
const TRIES: usize = 60;
const ENOUGH: u32 = 4;

/// Meshes of ordinary, degenerate and wide points, with their names.
fn subjects() -> Vec<(String, Subject)> {
    let apexes: Vec<Point> =
        vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [1.0, 1.0, 3.0], [1.0, 1.0, -3.0]];
    let mut sets = vec![
        ("one tetrahedron".to_string(), apexes[..4].to_vec()),
        ("five points".to_string(), apexes),
        ("cube".to_string(), grid(2)),
        ("grid".to_string(), grid(4)),
        ("subnormal cube".to_string(), grid(2).iter().map(|p| p.map(|c| c * 5e-324)).collect()),
        ("huge grid".to_string(), scaled(&grid(3), 1000)),
        ("sphere".to_string(), spheres(&[41])),
        ("uniform".to_string(), uniform(200, 5)),
    ];
    sets.extend(all(Size::Small).into_iter().map(|family| (family.name, family.points)));
    // A few points are enough where every test of the checker needs big integers.
    sets.extend(wide(Size::Small).into_iter().map(|f| (f.name, f.points[..16].to_vec())));
    sets.extend((0..30).map(|seed| (format!("snapped {seed}"), snapped(seed))));
    let subject = |(name, points): (String, Vec<Point>)| {
        let built = Builder::new().build(&PointSet::new(points).ok()?).ok()?;
        Some((name, Subject::of(&built.mesh)))
    };
    sets.into_iter().filter_map(subject).collect()
}

#[test]
fn every_planted_defect_is_found_and_named() {
    let subjects = subjects();
    assert!(subjects.len() > 50, "{}", subjects.len());
    let mut rng = Rng::new(4);
    let mut planted = [0u32; PLANTS.len()];
    for (name, mesh) in &subjects {
        mesh.passes().unwrap_or_else(|why| panic!("{name}: sound, but {why}"));
        for (plant, count) in PLANTS.into_iter().zip(&mut planted) {
            let mut grown = 0;
            for _ in 0..TRIES {
                match try_plant(mesh, plant, rng.below(1 << 32) as usize) {
                    Ok(grows) => grown += u32::from(grows),
                    Err(why) => panic!("{name}: {why}"),
                }
                if grown == ENOUGH {
                    break;
                }
            }
            *count += grown;
        }
    }
    for (plant, count) in PLANTS.iter().zip(planted) {
        println!("{}: {count} planted, all found", plant.name);
        assert!(count > 40, "{} grew only {count} times", plant.name);
    }
}

/// At every place of a small mesh, not only at some.
#[test]
fn every_place_of_a_small_mesh() {
    for points in [grid(2), spheres(&[2]), uniform(10, 3)] {
        let set = PointSet::new(points).expect("finite points");
        let built = Builder::new().build(&set).expect("a set of dimension 3");
        let mesh = Subject::of(&built.mesh);
        for plant in PLANTS {
            // A choice names a tetrahedron and one of its vertices or its six edges.
            for choice in 0..mesh.tets.len() * 6 {
                if let Err(why) = try_plant(&mesh, plant, choice) {
                    panic!("{why}: {:?}", set.points());
                }
            }
        }
    }
}

/// The judge of finite element meshes finds them, too, but for flips, which leave a sound mesh.
#[test]
fn the_judge_of_elements_finds_what_is_wrong_in_any_body() {
    let mut rng = Rng::new(8);
    let mut planted = [0u32; PLANTS.len()];
    for (name, mesh) in &subjects() {
        for (plant, count) in PLANTS.into_iter().zip(&mut planted) {
            for _ in 0..4 {
                match try_plant_elements(mesh, plant, rng.below(1 << 32) as usize) {
                    Ok(found) => *count += u32::from(found),
                    Err(why) => panic!("{name}: {why}"),
                }
            }
        }
    }
    for (plant, count) in PLANTS.iter().zip(planted) {
        println!("{}: {count} planted, all found", plant.name);
        let is_sound = plant.name.starts_with("flip ") || plant.name == "missing tetrahedron";
        assert_eq!(count < 40, is_sound, "{} grew {count} times", plant.name);
    }
}

/// In parts, every defect is found wherever it lies, inside a part and between parts, and no sound
/// mesh is accused. Its name may be another one: a part does not ask who else has its faces.
#[test]
fn every_planted_defect_is_found_in_parts() {
    let subjects = subjects();
    let mut rng = Rng::new(12);
    let mut planted = [[0_u32; 2]; PLANTS.len()];
    for (k, (name, mesh)) in subjects.iter().enumerate() {
        for members in [1, 2, 3, 5] {
            let deal = [Deal::Stretches, Deal::Random(k as u64)][(k + members as usize) % 2];
            let report = mesh.report_in_parts(Depth::Full, members, deal);
            assert!(report.passed(), "{name}, {members} {deal:?}: {:?}", report.defects);
        }
        for (plant, count) in PLANTS.into_iter().zip(&mut planted) {
            // A team for each place: one place of a large mesh, some of the others.
            for _ in 0..if mesh.tets.len() < 100 { 4 } else { 1 } {
                let members = [1, 2, 3, 5][rng.below(4) as usize];
                let deal = match rng.below(3) {
                    0 => Deal::Stretches,
                    seed => Deal::Random(seed),
                };
                let choice = rng.below(1 << 32) as usize;
                match try_plant_in_parts(mesh, plant, choice, Among { members, deal }) {
                    Ok(found) => {
                        count[0] += u32::from(found.is_some());
                        count[1] += u32::from(found == Some(true));
                    }
                    Err(why) => panic!("{name}: {why}"),
                }
            }
        }
    }
    for (plant, [found, named]) in PLANTS.iter().zip(planted) {
        println!("{}: {found} planted in parts, all found, {named} by name", plant.name);
        // Parts claim no neighbours and no hull.
        let in_claims = plant.name.ends_with("neighbour")
            || plant.name.ends_with("neighbours")
            || plant.name.ends_with("hull facet");
        assert!(if in_claims { found == 0 } else { found > 5 }, "{} grew {found}", plant.name);
        // No member follows faces through the mesh: another test finds what is not connected.
        let has_name = plant.name != "second body";
        let is_named = 10 * named >= 9 * found;
        assert_eq!(is_named, has_name || found == 0, "{}: {named} of {found}", plant.name);
    }
}
