//! `predicates/`: signs of determinants, and the perturbation.

use crate::{Case, File, write};
use ltbw::predicates::{cmp_xyz, insphere, orient3d, perturb, twin};
use ltbw::{Point, Sign};
use ltbw_tests::families::{Rng, two_to};
use ltbw_tests::five_points::{WIDE, WINDOW};
use ltbw_tests::{epsilon, oracle};
use serde_json::{Value, json};

/// Draws of each family.
const DRAWS: usize = 6;

/// The files of the folder.
#[must_use]
pub fn files() -> Vec<File> {
    let file = |name, tier, about, cases| File { folder: "predicates", name, tier, about, cases };
    vec![
        file("human", 1, "Signs that can be checked by hand.", human()),
        file("signs", 2, "orient3d and insphere on the families inside the window.", signs(false)),
        file("ties", 2, "side_of_sphere and side_of_hull_facet: ties by perturbation.", ties()),
        file("range", 3, "orient3d and insphere over the whole range of f64.", signs(true)),
    ]
}

/// A case of `op` on `points`, if its twins agree.
fn case(op: &str, name: &str, flags: &[&'static str], points: &[Point], signs: &[Sign]) -> Case {
    assert!(signs.windows(2).all(|s| s[0] == s[1]), "{op} {name}: {points:?} {signs:?}");
    Case {
        name: name.to_string(),
        flags: flags.to_vec(),
        ask: json!({"op": op, "points": write(points)}),
        expect: sign(signs[0]),
    }
}

/// A sign as JSON.
pub(super) fn sign(sign: Sign) -> Value {
    json!({"sign": sign as i8})
}

fn orient(name: &str, flags: &[&'static str], p: &[Point; 4]) -> Case {
    let [a, b, c, d] = p;
    let twins = [orient3d(a, b, c, d), twin::orient3d(a, b, c, d), oracle::orient3d(a, b, c, d)];
    case("orient3d", name, flags, p, &twins)
}

fn inside(name: &str, flags: &[&'static str], p: &[Point; 5]) -> Case {
    let [a, b, c, d, e] = p;
    let twins =
        [insphere(a, b, c, d, e), twin::insphere(a, b, c, d, e), oracle::insphere(a, b, c, d, e)];
    case("insphere", name, flags, p, &twins)
}

/// Perturbed side of small integer points: by the definition in ε, too.
fn side(name: &str, flags: &[&'static str], small: &[epsilon::Small; 5]) -> Case {
    let p = small.map(|q| q.map(|c| c as f64));
    let [a, b, c, d, e] = &p;
    assert_eq!(orient3d(a, b, c, d), Sign::Positive, "{name}");
    let twins = [
        perturb::side_of_sphere(a, b, c, d, e),
        oracle::side_of_sphere([a, b, c, d], e),
        epsilon::side_of_sphere(small),
    ];
    assert_ne!(twins[0], Sign::Zero);
    case("side_of_sphere", name, flags, &p, &twins)
}

fn beyond(name: &str, flags: &[&'static str], small: &[epsilon::Small; 4]) -> Case {
    let p = small.map(|q| q.map(|c| c as f64));
    let [a, b, c, d] = &p;
    let twins = [
        perturb::side_of_hull_facet(a, b, c, d),
        oracle::side_of_hull_facet([a, b, c], d),
        epsilon::side_of_hull_facet(small),
    ];
    assert_ne!(twins[0], Sign::Zero);
    case("side_of_hull_facet", name, flags, &p, &twins)
}

const O: Point = [0.0; 3];
const X: Point = [1.0, 0.0, 0.0];
const Y: Point = [0.0, 1.0, 0.0];
const Z: Point = [0.0, 0.0, 1.0];

fn human() -> Vec<Case> {
    let convention = &["sign-convention"];
    let m = -0.0;
    vec![
        orient("the unit tetrahedron is positive", convention, &[O, X, Y, Z]),
        orient("two corners exchanged", convention, &[X, O, Y, Z]),
        orient("four points of a plane", &["rounded"], &[O, X, Y, [1.0, 1.0, 0.0]]),
        orient("zeros of both signs", &["negative-zero"], &[[m; 3], X, [m, 1.0, m], Z]),
        inside("the centre is inside", convention, &[O, X, Y, Z, [0.5; 3]]),
        inside("a far point is outside", convention, &[O, X, Y, Z, [9.0; 3]]),
        inside("a negative tetrahedron turns the sign", convention, &[X, O, Y, Z, [0.5; 3]]),
        inside("the eighth corner of the cube: zero", &["rounded"], &[O, X, Y, Z, [1.0; 3]]),
        side(
            "the eighth corner, the largest point, is outside",
            &["tie", "tie-order"],
            &[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]],
        ),
        side(
            "the origin, the smallest point, is inside the corner tetrahedron opposite",
            &["tie", "tie-order"],
            &[[0, 1, 1], [1, 1, 1], [1, 0, 1], [1, 1, 0], [0, 0, 0]],
        ),
        beyond("beyond a hull facet", &["hull"], &[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 5]]),
        beyond("before it", &["hull"], &[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, -5]]),
        beyond(
            "in its plane, inside its circle",
            &["hull-plane"],
            &[[0, 0, 0], [4, 0, 0], [0, 4, 0], [3, 3, 0]],
        ),
        beyond(
            "in its plane, on its circle: a tie",
            &["hull-plane", "tie"],
            &[[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]],
        ),
    ]
}

fn signs(wide: bool) -> Vec<Case> {
    let (families, flag) = if wide { (WIDE, "range") } else { (WINDOW, "rounded") };
    let mut cases = Vec::new();
    for (number, (name, draw)) in (1..).zip(families) {
        let mut random = Rng::new(number);
        for _ in 0..DRAWS {
            let p = draw(&mut random);
            cases.push(orient(name, &[flag], &[p[0], p[1], p[2], p[3]]));
            cases.push(inside(name, &[flag], &p));
        }
    }
    cases
}

/// Five different cospherical points, a positive tetrahedron first; `None` if they are coplanar.
fn tie(mut five: [epsilon::Small; 5]) -> Option<[epsilon::Small; 5]> {
    let distinct = (0..5).all(|i| !five[..i].contains(&five[i]));
    match epsilon::orient3d(&[five[0], five[1], five[2], five[3]]) {
        _ if !distinct => None,
        Sign::Zero => None,
        Sign::Negative => {
            five.swap(0, 1);
            Some(five)
        }
        Sign::Positive => Some(five),
    }
}

/// Is the first coefficient of the perturbation zero: is `five[4]`, in the place of the largest
/// vertex, in one plane with the others?
fn needs_second(five: &[epsilon::Small; 5]) -> bool {
    let largest = (0..5).max_by_key(|&k| five[k]).unwrap_or(4);
    let mut four = [five[0], five[1], five[2], five[3]];
    if largest == 4 {
        return false;
    }
    four[largest] = five[4];
    epsilon::orient3d(&four) == Sign::Zero
}

fn ties() -> Vec<Case> {
    let sphere: Vec<epsilon::Small> =
        ltbw_tests::families::spheres(&[9]).iter().map(|p| p.map(|c| c as i64)).collect();
    let cube: Vec<epsilon::Small> = (0..8).map(|i| [i >> 2, i >> 1 & 1, i & 1]).collect();
    let mut random = Rng::new(7);
    let mut cases = Vec::new();
    for (name, points) in [("a cube's corners", &cube), ("integer points of a sphere", &sphere)] {
        let (mut first, mut second) = (0, 0);
        // Ends: random picks give both kinds many times; a bound all the same.
        for _ in 0..10_000 {
            let five = std::array::from_fn(|_| points[random.below(points.len() as u64) as usize]);
            let Some(five) = tie(five) else { continue };
            let late = needs_second(&five);
            let (count, flags): (_, &[_]) = if late {
                (&mut second, &["tie", "second-round"])
            } else {
                (&mut first, &["tie", "tie-order"])
            };
            if *count < 20 {
                *count += 1;
                cases.push(side(name, flags, &five));
            }
        }
        assert!(first == 20 && second == 20, "{name}: {first}, {second}");
    }
    let mut flat = 0;
    while flat < 24 {
        let four: [epsilon::Small; 4] =
            std::array::from_fn(|_| [random.below(4) as i64, random.below(4) as i64, 2]);
        let distinct = (0..4).all(|i| !four[..i].contains(&four[i]));
        if !distinct || epsilon::coplanar_orient([four[0], four[1], four[2]]) == Sign::Zero {
            continue;
        }
        flat += 1;
        cases.push(beyond("in the plane of a hull facet", &["hull-plane"], &four));
    }
    cases.extend(scaled_ties(&cube, &mut random));
    cases
}

/// The cube far from the origin and at other scales: ties stay ties.
fn scaled_ties(cube: &[epsilon::Small], random: &mut Rng) -> Vec<Case> {
    let mut cases = Vec::new();
    for e in [-140, -1, 30, 150] {
        for _ in 0..4 {
            let five = std::array::from_fn(|_| cube[random.below(8) as usize]);
            let Some(five) = tie(five) else { continue };
            let p = five.map(|q| q.map(|c| (c as f64 + 3.0) * two_to(e)));
            let [a, b, c, d, q] = &p;
            let twins = [
                perturb::side_of_sphere(a, b, c, d, q),
                oracle::side_of_sphere([a, b, c, d], q),
                epsilon::side_of_sphere(&five),
            ];
            cases.push(case("side_of_sphere", "a scaled cube", &["tie"], &p, &twins));
        }
    }
    cases
}

/// The order of two points as a sign.
pub(super) fn compare(name: &str, flags: &[&'static str], p: &[Point; 2]) -> Case {
    let fast = Sign::from_ordering(cmp_xyz(&p[0], &p[1]));
    let slow = Sign::from_ordering(oracle::scale(p)[0].cmp(&oracle::scale(p)[1]));
    case("compare_xyz", name, flags, p, &[fast, slow])
}
