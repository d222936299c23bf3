//! Golden hashes `ltbw.mesh/1` of the small sets of every family and of some larger ones. They
//! came from CGAL and are checked against it where it is there; a mesh that hashes differently on
//! any machine, or after any change, is a breaking change.

use ltbw::{Builder, Order, Point, PointSet};
use ltbw_tests::cgal::Cgal;
use ltbw_tests::families::{Size, all, grid, uniform};

/// Name, and hash of the mesh.
const GOLDEN: &[(&str, &str)] = &[
    ("uniform", "324fcfded2e4596ed88cc8a341123577cdc840f30252ab769623e439343be379"),
    ("grid", "0d09e6492e01754ac260c1dc2b66104b7b32d9b9e2bfe7755a8a34083c456ed0"),
    ("grid+-ulps", "446ddf6dec21b2cbc482895723ad9c164f527b5c116ab30e3c6631ce9d9aa381"),
    ("body-centred", "e7239b55d2c8fc844ce90383dc4bc5f122d3d1351404a995322652b5c8cfa254"),
    ("spheres", "4d40024c51b76683f412f983f764f0462b7850bcbe3f68b13f2fa4ade8e066fb"),
    ("cylinder", "fe7c13586236245ea3648b1b6987e31947ecd5291a220c2b1969fc00d1ffe6d7"),
    ("clusters", "b1ab330a1d8e3d3db609f27642cfa62db3d1ef910af9386dabe9f07be426d9f3"),
    ("planes", "f18639394f9c0af93b449e371b6919a9e8ceae449d0f4cc11804f6e009199fae"),
    ("triplicated", "7129911779b53e71a50f5eafc32e1fa785385f68fb0c5080a878f8b4d1fa1cba"),
    ("grid*2^-120", "229978d01340fcf194cc953c3b316ac29680409a8c0eb05e1a013c6a1c287be5"),
    ("grid*2^190", "f8ba0d70052954dad9bf8f7f3407e5118eb00a1ab92cae61b684e729f37f6e70"),
    ("grid*2^-700", "6da72ac895df94c40219b373b8dc7bb43359fa294ab2625606840ddb6e992e6f"),
    ("moment-curve", "b810e74fb985457524f6f618565544f58f07e87e336d01733f10147b0c59bc2d"),
    ("skew-lines", "fc6be7028ac5134043e796675ec8f25d4ba9615b81d3a631e29b4bf1ee613cda"),
    ("signed-zeros", "e7696d2a2295c932ff5fc9eb0cd42a6be98b0bafad678c0fd75c9e5a2facb018"),
    ("uniform 20000", "63fad91834d34a2a647932695fcf073a16ea1273a456014db423e983e30d48c8"),
    ("grid 20^3", "747620b006cced80226501e5a8906b2b34a9236769a031defea37ee3a1563503"),
];

/// The golden sets by name.
fn sets() -> Vec<(String, Vec<Point>)> {
    let small = all(Size::Small).into_iter().map(|family| (family.name, family.points));
    let larger =
        [("uniform 20000".to_string(), uniform(20_000, 1)), ("grid 20^3".to_string(), grid(20))];
    small.chain(larger).collect()
}

#[test]
fn our_meshes_have_the_golden_hashes() {
    for ((name, points), &(expected_name, expected)) in sets().into_iter().zip(GOLDEN) {
        assert_eq!(name, expected_name);
        let set = PointSet::new(points).expect("finite points");
        for order in [Order::Brio, Order::Input] {
            let built = Builder::new().order(order).build(&set).expect("dimension 3");
            let hash = built.mesh.hash().expect("a mesh of distinct points");
            assert_eq!(hash.to_string(), expected, "{name}, {order:?}");
        }
    }
}

#[test]
fn the_golden_hashes_are_those_of_cgal_and_of_all_sets() {
    assert_eq!(sets().len(), GOLDEN.len());
    let Some(mut cgal) = Cgal::for_test("the_golden_hashes_are_those_of_cgal") else { return };
    for ((name, points), &(_, expected)) in sets().iter().zip(GOLDEN) {
        let hash = cgal.hash(points).expect("CGAL answers").expect("dimension 3");
        assert_eq!(hash.to_string(), expected, "{name}");
    }
}
