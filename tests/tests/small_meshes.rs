//! Meshes, exhaustively: every subset of a few points, in several orders of insertion, has exactly
//! the tetrahedra and hull facets of the definition (`ltbw_tests::small_world`): those without a
//! point in their perturbed sphere.
//!
//! Covered: all subsets of up to 6 points of {0, 1, 2}³ (up to `LTBW_SMALL_WORLD` of them: 7 adds
//! 888,030 sets, 27 is the power set), the power sets of the grids 2×2×3, 2×2×4 and 3×3×2, of a
//! plane grid between two apexes and of twelve points of a sphere around its centre. Not reduced
//! by the symmetry of the grids: the perturbation orders points by (x, y, z) and knows no symmetry
//! but translation and scaling.

use ltbw::build::Builder;
use ltbw::invariants::check_all;
use ltbw::{BuildError, Order, Point, PointSet};
use ltbw_tests::epsilon::Small;
use ltbw_tests::families::Rng;
use ltbw_tests::small_world::{Expected, World, subsets};

/// Meshes built and sets looked at, for the report.
#[derive(Default)]
struct Count {
    sets: u64,
    meshes: u64,
    degenerate: u64,
}

/// The facet with its smallest vertex first.
fn turned([a, b, c]: [u32; 3]) -> [u32; 3] {
    match a.min(b).min(c) {
        least if least == a => [a, b, c],
        least if least == b => [b, c, a],
        _ => [c, a, b],
    }
}

/// Builds the points of the world in the order `numbers` and compares.
fn check(world: &World, numbers: &[u32], order: Order, expected: &Expected, deep: bool) -> bool {
    let floats = |&i: &u32| -> Point { world.points()[i as usize].map(|c| c as f64) };
    let set = PointSet::new(numbers.iter().map(floats).collect()).expect("finite points");
    let place = || format!("{:?} inserted by {order:?}", set.points());
    let mesh = match Builder::new().order(order).build(&set) {
        Ok(built) => built.mesh,
        Err(error) => {
            let right = match error {
                BuildError::TooFewPoints { distinct } => distinct == numbers.len() && distinct < 4,
                BuildError::Collinear { .. } => numbers.len() > 3 && expected.dimension == 1,
                BuildError::Coplanar { .. } => numbers.len() > 3 && expected.dimension == 2,
                _ => false,
            };
            assert!(right, "{error}, but the dimension is {}: {}", expected.dimension, place());
            return false;
        }
    };
    let world_number = |v: u32| numbers[v as usize];
    let mut tets: Vec<[u32; 4]> = mesh.tets().map(|t| t.map(world_number)).collect();
    tets.iter_mut().for_each(|t| t.sort_unstable());
    tets.sort_unstable();
    let mut hull: Vec<[u32; 3]> = mesh.hull_facets().map(|f| turned(f.map(world_number))).collect();
    hull.sort_unstable();
    assert_eq!((&tets, &hull), (&expected.tets, &expected.hull), "{}", place());
    if deep {
        check_all(&mesh).unwrap_or_else(|broken| panic!("{broken}: {}", place()));
    }
    true
}

/// One set in four orders: ascending by (x, y, z), descending, shuffled, and as a build has it.
fn check_set(world: &World, set: u32, count: &mut Count) {
    let expected = world.mesh(set);
    let mut numbers: Vec<u32> = (0..32).filter(|i| set >> i & 1 == 1).collect();
    count.sets += 1;
    let built = check(world, &numbers, Order::Input, &expected, true);
    if !built {
        count.degenerate += 1;
        return;
    }
    count.meshes += 4;
    check(world, &numbers, Order::Brio, &expected, false);
    numbers.reverse();
    check(world, &numbers, Order::Input, &expected, false);
    Rng::new(u64::from(set)).shuffle(&mut numbers);
    check(world, &numbers, Order::Input, &expected, false);
}

fn report(name: &str, count: &Count) {
    let Count { sets, meshes, degenerate } = count;
    println!("{name}: {sets} sets, {meshes} meshes, {degenerate} sets without volume");
    assert!(*meshes > *sets, "most sets have a mesh");
}

fn power_set(name: &str, world: &World) {
    let mut count = Count::default();
    for size in 1..=world.points().len() {
        for set in subsets(world.points().len(), size) {
            check_set(world, set, &mut count);
        }
    }
    report(name, &count);
}

/// Largest size of the subsets of {0, 1, 2}³: `LTBW_SMALL_WORLD`, or 6.
fn largest() -> usize {
    let given = std::env::var("LTBW_SMALL_WORLD");
    given.map_or(6, |text| text.parse().expect("LTBW_SMALL_WORLD is a number of points")).min(27)
}

#[test]
fn all_small_subsets_of_the_cubic_grid() {
    let world = World::grid([3, 3, 3]);
    for size in 1..=largest() {
        let mut count = Count::default();
        subsets(27, size).for_each(|set| check_set(&world, set, &mut count));
        let Count { sets, meshes, degenerate } = count;
        println!("size {size}: {sets} sets, {meshes} meshes, {degenerate} sets without volume");
        assert!(size < 5 || meshes > sets);
    }
}

#[test]
fn all_subsets_of_a_layered_grid() {
    power_set("3x3x2", &World::grid([3, 3, 2]));
}

#[test]
fn all_subsets_of_a_column_grid() {
    power_set("2x2x4", &World::grid([2, 2, 4]));
}

#[test]
fn all_subsets_of_a_plane_grid_between_two_apexes() {
    let plane = (0..9).map(|i| [i / 3, i % 3, 1]);
    let world: Vec<Small> = plane.chain([[1, 1, 0], [1, 1, 2]]).collect();
    power_set("3x3 and two apexes", &World::new(world));
}

#[test]
fn all_subsets_of_points_of_a_sphere_and_its_centre() {
    let grid = (0..27).map(|i: i64| [i / 9, i / 3 % 3, i % 3]);
    let distance = |p: &Small| p.iter().map(|c| (c - 1) * (c - 1)).sum::<i64>();
    let world: Vec<Small> = grid.filter(|p| [0, 2].contains(&distance(p))).collect();
    assert_eq!(world.len(), 13);
    power_set("sphere of 12 and centre", &World::new(world));
}

/// All orders of insertion of all sets of up to five points of a 2×2×3 grid.
#[test]
fn all_orders_of_all_sets_of_five() {
    fn every_order(numbers: &mut [u32], from: usize, check: &mut impl FnMut(&[u32])) {
        if from == numbers.len() {
            check(numbers);
        }
        for i in from..numbers.len() {
            numbers.swap(from, i);
            every_order(numbers, from + 1, check);
            numbers.swap(from, i);
        }
    }
    let world = World::grid([2, 2, 3]);
    let mut orders = 0;
    for size in 4..=5 {
        for set in subsets(12, size) {
            let expected = world.mesh(set);
            let mut numbers: Vec<u32> = (0..12).filter(|i| set >> i & 1 == 1).collect();
            every_order(&mut numbers, 0, &mut |numbers| {
                orders += u32::from(check(&world, numbers, Order::Input, &expected, false));
            });
        }
    }
    assert!(orders > 80_000, "{orders}");
}
