//! `order/`: the order of points, the Hilbert curve, the rounds, and who owns a tetrahedron.

use crate::predicates::compare;
use crate::{Case, File, write};
use ltbw::Point;
use ltbw::mesh::Blocks;
use ltbw::order::{brio_hilbert, hilbert, round_of};
use ltbw::protocol::BlockId;
use ltbw_tests::families::{Rng, clusters, grid, two_to, uniform};
use serde_json::json;

/// The files of the folder.
#[must_use]
pub fn files() -> Vec<File> {
    let file = |name, tier, about, cases| File { folder: "order", name, tier, about, cases };
    vec![
        file("human", 1, "The eight octants, pairs of points, blocks of four vertices.", human()),
        file("curve", 2, "Hilbert order of point sets, and insertion rounds.", curve()),
    ]
}

/// The order of points along the curve. The twin: every order is a permutation, and each step of a
/// full grid is one to a face neighbour.
fn along(name: &str, flags: &[&'static str], points: &[Point], is_grid: bool) -> Case {
    let order = hilbert(points);
    let mut sorted = order.clone();
    sorted.sort_unstable();
    assert!(sorted.iter().copied().eq(0..points.len() as u32), "{name}: a permutation");
    if is_grid {
        let distance = |i: u32, j: u32| -> f64 {
            let [p, q] = [i, j].map(|i| points[i as usize]);
            (0..3).map(|k| (p[k] - q[k]).abs()).sum()
        };
        assert!(order.windows(2).all(|pair| distance(pair[0], pair[1]) == 1.0), "{name}");
    }
    Case {
        name: name.to_string(),
        flags: flags.to_vec(),
        ask: json!({"op": "hilbert", "points": write(points)}),
        expect: json!({"order": order}),
    }
}

fn round(index: u32, rounds: u32) -> Case {
    Case {
        name: format!("round of point {index} of {rounds} rounds"),
        flags: vec!["brio-hash"],
        ask: json!({"op": "round_of", "index": index, "rounds": rounds}),
        expect: json!({"round": round_of(index, rounds)}),
    }
}

/// Blocks of vertices 1 to `vertices` and of some tetrahedra; the twin counts votes.
fn owners(name: &str, vertices: u32, blocks: u32, tets: &[[u32; 4]]) -> Case {
    let map = Blocks::even(vertices, blocks);
    let slow = |tet: &[u32; 4]| {
        let votes = |b| tet.iter().filter(|&&v| v != 0 && map.vertices(b).contains(&v)).count();
        let most = |&b: &BlockId| (votes(b), std::cmp::Reverse(b));
        BlockId::below(blocks).max_by_key(most).unwrap_or_default()
    };
    let found: Vec<BlockId> = tets.iter().map(|&tet| map.of_tet(tet)).collect();
    assert!(tets.iter().map(slow).eq(found.iter().copied()), "{name}");
    Case {
        name: name.to_string(),
        flags: vec!["majority"],
        ask: json!({"op": "blocks", "vertices": vertices, "blocks": blocks, "tets": tets}),
        expect: json!({"blocks": found}),
    }
}

fn human() -> Vec<Case> {
    let pair = |name: &str, flag, p, q| compare(name, &[flag], &[p, q]);
    let m = -0.0;
    let mut cases = vec![
        pair("by x first", "tie-order", [0.0, 9.0, 9.0], [1.0, 0.0, 0.0]),
        pair("then by y", "tie-order", [1.0, 2.0, 0.0], [1.0, 1.0, 9.0]),
        pair("then by z", "tie-order", [1.0, 1.0, -2.0], [1.0, 1.0, -1.0]),
        pair("equal", "tie-order", [1.0; 3], [1.0; 3]),
        pair("zeros of both signs are equal", "negative-zero", [m, 0.0, m], [0.0, m, 0.0]),
        pair("a zero before the next coordinate", "negative-zero", [0.0, 1.0, 0.0], [m, 2.0, 0.0]),
        along("the eight corners of a cube", &["hilbert-curve"], &grid(2), true),
        along("corners in reverse order", &["hilbert-curve"], &reversed(grid(2)), true),
        along("equal points by index", &["hilbert-cell"], &[[1.0; 3]; 3], false),
    ];
    cases.push(owners(
        "majority, ties, ghosts",
        10,
        4,
        &[[1, 4, 5, 9], [9, 8, 1, 2], [9, 1, 4, 6], [9, 8, 1, 0], [3, 6, 8, 0]],
    ));
    cases
}

fn reversed(mut points: Vec<Point>) -> Vec<Point> {
    points.reverse();
    points
}

fn curve() -> Vec<Case> {
    let mut near = uniform(12, 5);
    near.iter_mut().for_each(|p| *p = p.map(|c| 1.0 + c * two_to(-40)));
    near.push([0.0; 3]);
    near.push([2.0; 3]);
    let flat: Vec<Point> = uniform(20, 6).into_iter().map(|[x, y, _]| [x, y, 3.0]).collect();
    let mut cases = vec![
        along("grid 4 x 4 x 4", &["hilbert-curve"], &grid(4), true),
        along("uniform", &["hilbert-curve", "hilbert-cell"], &uniform(60, 1), false),
        along("clusters", &["hilbert-cell", "hilbert-run"], &clusters(60, 2), false),
        along("many points in one cell", &["hilbert-run"], &near, false),
        along("a plane", &["hilbert-cell"], &flat, false),
        along(
            "subnormal",
            &["hilbert-cell", "range"],
            &ltbw_tests::families::subnormal_grid(3),
            false,
        ),
        along("the ends of f64", &["range"], &[[f64::MAX; 3], [-f64::MAX; 3], [0.0; 3]], false),
    ];
    cases.extend((0..24).map(|k| round(k, 3)));
    cases.extend([513, 70_000, 1 << 28, u32::MAX].map(|k| round(k, 15)));
    let points =
        uniform(600, 3).into_iter().map(|p| p.map(|c| (c * 256.0).floor())).collect::<Vec<_>>();
    cases.push(Case {
        name: "rounds and curve together: 600 points".to_string(),
        flags: vec!["brio-hash", "hilbert-curve"],
        ask: json!({"op": "brio_hilbert", "points": write(&points)}),
        expect: json!({"order": brio_hilbert(&points)}),
    });
    let mut random = Rng::new(9);
    for (vertices, blocks) in [(16, 4), (3, 8), (1000, 48)] {
        let tets: Vec<[u32; 4]> = (0..30)
            .map(|k| {
                let mut tet = std::array::from_fn(|_| 1 + random.below(vertices) as u32);
                tet[3] = if k % 3 == 0 { 0 } else { tet[3] };
                tet
            })
            .collect();
        cases.push(owners("random tetrahedra", vertices as u32, blocks, &tets));
    }
    cases
}
