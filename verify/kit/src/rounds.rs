//! `rounds/`: the pure parts of refinement in rounds: keys, who is foremost, who is killed, and
//! the barriers with sums.

use crate::{Case, File, write};
use ltbw::Point;
use ltbw::protocol::{Correct, WorkerId};
use ltbw::refine::{BoundaryItem, Carrier, Corner, Keys, Rank, Ranked};
use ltbw::refining::{InnerCandidate, Step, Sums, Tree, is_quiet, unkilled};
use ltbw::topology::TetId;
use ltbw_tests::families::Rng;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// The files of the folder.
#[must_use]
pub fn files() -> Vec<File> {
    let file = |name, tier, about, cases| File { folder: "rounds", name, tier, about, cases };
    vec![
        file("human", 1, "Keys of edges, triangles and tetrahedra; small choices.", human()),
        file("choice", 2, "Who is foremost, and who is killed, among many.", choice()),
        file("barrier", 2, "Sums that go up a tree, in any order of events.", barrier()),
    ]
}

/// Points of small whole coordinates.
fn whole(random: &mut Rng, range: u64) -> Point {
    std::array::from_fn(|_| random.below(range) as f64 - (range / 2) as f64)
}

fn is_flat(p: &[Point; 4]) -> bool {
    let [a, b, c] = [0, 1, 2].map(|k| [0, 1, 2].map(|c| (p[k][c] - p[3][c]) as i128));
    let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
    a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1) == 0
}

/// Four corners that are not in one plane.
fn tetrahedron(random: &mut Rng, range: u64) -> [Point; 4] {
    loop {
        let corners: [Point; 4] = std::array::from_fn(|_| whole(random, range));
        if !is_flat(&corners) {
            return corners;
        }
    }
}

fn key_of(corners: &[Point]) -> u64 {
    let corner = |&point: &Point| Corner { point, carrier: Carrier::Free };
    match corners {
        &[a, b, c, d] => Rank::key_of_tet([a, b, c, d]),
        _ => {
            let corners: Vec<Corner> = corners.iter().map(corner).collect();
            BoundaryItem::new(&corners, 0).rank().key()
        }
    }
}

fn hexadecimal(key: u64) -> String {
    format!("{key:016x}")
}

/// The key of two, three or four corners. The twin: it is the same for all their orders, and its
/// leading bits are within rounding of the size by a formula of its own.
fn key(name: &str, corners: &[Point]) -> Case {
    let key = key_of(corners);
    let mut turned = corners.to_vec();
    for _ in 0..corners.len() {
        turned.rotate_left(1);
        assert_eq!(key_of(&turned), key, "{name}: turned");
    }
    turned.swap(0, 1);
    assert_eq!(key_of(&turned), key, "{name}: swapped");
    let size = f64::from_bits(key >> 48 << 48);
    let slow = slow_size(corners);
    assert!((0.93 * slow..=1.001 * slow).contains(&size), "{name}: {size} for {slow}");
    Case {
        name: name.to_string(),
        flags: vec!["key"],
        ask: json!({"op": "key", "points": write(corners)}),
        expect: json!({"key": hexadecimal(key)}),
    }
}

/// The squared length of an edge, or circumradius, by lengths of edges alone.
fn slow_size(p: &[Point]) -> f64 {
    let d = |i: usize, j: usize| -> f64 { (0..3).map(|k| (p[i][k] - p[j][k]).powi(2)).sum() };
    match p.len() {
        2 => d(0, 1),
        3 => {
            let (a, b, c) = (d(1, 2), d(0, 2), d(0, 1));
            let area16 = 2.0 * (a * b + b * c + c * a) - a * a - b * b - c * c;
            a * b * c / area16
        }
        _ => {
            // Crelle: 6 V R is the area of a triangle with the products of opposite edges.
            let [a, b, c] =
                [d(0, 1) * d(2, 3), d(0, 2) * d(1, 3), d(0, 3) * d(1, 2)].map(f64::sqrt);
            let s = (a + b + c) / 2.0;
            let area2 = s * (s - a) * (s - b) * (s - c);
            let [u, v, w] = [0, 1, 2].map(|k| [0, 1, 2].map(|x| p[k][x] - p[3][x]));
            let det = u[0] * (v[1] * w[2] - v[2] * w[1])
                + u[1] * (v[2] * w[0] - v[0] * w[2])
                + u[2] * (v[0] * w[1] - v[1] * w[0]);
            area2 / (det * det)
        }
    }
}

/// Tetrahedra by their corners, some of which are over their bounds, and their neighbours.
struct Around {
    corners: Vec<[Point; 4]>,
    over: Vec<bool>,
    neighbours: Vec<[u32; 4]>,
}

impl Ranked for Around {
    fn neighbours(&self, t: TetId) -> [TetId; 4] {
        self.neighbours[t.index()].map(TetId::new)
    }

    fn prefetch(&self, _: TetId) {}

    fn around(&self, way: TetId) -> Option<[TetId; 4]> {
        Some(self.neighbours(way))
    }

    fn is_first_by_place(&self, one: TetId, other: TetId) -> bool {
        let rank = |t: TetId| Rank::of_tet(self.corners[t.index()]);
        rank(one) < rank(other)
    }
}

/// The foremost of some tetrahedra. The twin looks for the largest key among all around each.
fn foremost(name: &str, flags: &[&'static str], around: &Around) -> Case {
    let all = TetId::below(around.corners.len() as u32);
    let (mut keys, mut found): (Keys, Vec<u32>) = Default::default();
    keys.grow(around.corners.len());
    for t in all.filter(|t| around.over[t.index()]) {
        keys.enter(t, Rank::key_of_tet(around.corners[t.index()]));
    }
    keys.sift(around, |t, _| found.push(t.number()));
    found.sort_unstable();
    let slow = |t: u32| {
        let key = |t: u32| (key_of(&around.corners[t as usize]), t);
        let beside = around.neighbours[t as usize];
        let beyond = beside.iter().flat_map(|&n| around.neighbours[n as usize]);
        let near: BTreeSet<u32> = beside.into_iter().chain(beyond).chain([t]).collect();
        let best = near.into_iter().filter(|&t| around.over[t as usize]).map(key).max();
        around.over[t as usize] && best == Some(key(t))
    };
    let count = around.corners.len() as u32;
    assert!((0..count).filter(|&t| slow(t)).eq(found.iter().copied()), "{name}");
    let corners: Vec<Value> = around.corners.iter().map(|own| write(own)).collect();
    Case {
        name: name.to_string(),
        flags: flags.to_vec(),
        ask: json!({
            "op": "foremost",
            "tets": corners,
            "over": around.over,
            "neighbours": around.neighbours,
        }),
        expect: json!({"foremost": found}),
    }
}

/// A candidate: its corners, its own slot, and the slots in conflict with its point.
type Candidate = ([Point; 4], u32, Vec<u32>);

/// The candidates that none before them kills. The twin compares all pairs.
fn kill(name: &str, flags: &[&'static str], candidates: &[Candidate]) -> Case {
    let given: Vec<InnerCandidate> = candidates
        .iter()
        .map(|(corners, own, cavity)| {
            let cavity = cavity.iter().copied().map(TetId::new).collect();
            InnerCandidate { rank: Rank::of_tet(*corners), own: TetId::new(*own), cavity }
        })
        .collect();
    let chosen = unkilled(&given);
    let slow = |k: usize| {
        let (corners, own, _) = &candidates[k];
        !candidates
            .iter()
            .any(|(other, _, cavity)| cavity.contains(own) && key_of(other) > key_of(corners))
    };
    assert!((0..candidates.len()).filter(|&k| slow(k)).eq(chosen.iter().copied()), "{name}");
    let asked: Vec<Value> = candidates
        .iter()
        .map(|(corners, own, cavity)| json!({"tet": write(corners), "own": own, "cavity": cavity}))
        .collect();
    Case {
        name: name.to_string(),
        flags: flags.to_vec(),
        ask: json!({"op": "kill", "candidates": asked}),
        expect: json!({"chosen": chosen}),
    }
}

/// The sums of a wave as the places of those sent and taken.
fn sums_of([sent, taken]: [i64; 2]) -> Sums {
    let mut sums = Sums::default();
    (sums[0], sums[1]) = (sent, taken);
    sums
}

/// A wave of `workers`, which speak in this order: what goes up at each word, and at the root the
/// sums of all. The twin adds up.
fn wave(name: &str, workers: u32, order: &[u32], own: impl Fn(u32) -> [i64; 2]) -> Case {
    let mut trees: Vec<Tree> =
        (0..workers).map(|me| Tree::new(WorkerId::new(me), workers)).collect();
    let mut steps: Vec<Value> = Vec::new();
    let mut done = None;
    for &me in order {
        let mut sent = Vec::new();
        let mut from = WorkerId::new(me);
        let mut step = trees[me as usize].put(sums_of(own(me)));
        while let Some(next) = step {
            step = match next {
                Step::Up(to, sums) => {
                    sent.push(json!({"from": from, "to": to, "sums": sums[..2]}));
                    let next = trees[to.index()].hear(sums);
                    from = to;
                    next
                }
                Step::Done(sums) => {
                    done = Some([sums[0], sums[1]]);
                    None
                }
            };
        }
        steps.push(json!(sent));
    }
    let sum = |k: usize| order.iter().map(|&me| own(me)[k]).sum::<i64>();
    assert_eq!(done, Some([sum(0), sum(1)]), "{name}");
    let words: Vec<Value> =
        order.iter().map(|&me| json!({"worker": me, "sums": own(me)})).collect();
    Case {
        name: name.to_string(),
        flags: vec!["tree"],
        ask: json!({"op": "wave", "workers": workers, "words": words}),
        expect: json!({"up": steps, "all": done}),
    }
}

/// Does a wave end the insertion of a round?
fn quiet(name: &str, before: Option<[i64; 2]>, sums: [i64; 2]) -> Case {
    let quiet = is_quiet::<Correct>(before.map(sums_of), &sums_of(sums));
    Case {
        name: name.to_string(),
        flags: vec!["second-wave"],
        ask: json!({"op": "quiet", "before": before, "sums": sums}),
        expect: json!({"quiet": quiet}),
    }
}

fn human() -> Vec<Case> {
    let (o, x, y, z) = ([0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]);
    let far = [0.0, 0.0, 400.0];
    let chain = |over: [bool; 3]| Around {
        corners: vec![[o, x, y, z], [o, x, y, far], [o, x, z, [9.0; 3]]],
        over: over.to_vec(),
        // 1 is beyond 2, as seen from 0.
        neighbours: vec![[2; 4], [2; 4], [0, 1, 0, 1]],
    };
    vec![
        key("an edge of length 4", &[o, x]),
        key("a right triangle", &[o, x, y]),
        key("the corner of a cube", &[o, x, y, z]),
        key("the same by another order", &[z, y, o, x]),
        key("a needle", &[o, x, y, far]),
        foremost("the largest comes first", &["foremost"], &chain([true; 3])),
        foremost(
            "one within its bounds counts for nothing",
            &["foremost"],
            &chain([true, false, true]),
        ),
        foremost("two faces away still counts", &["foremost-beyond"], &chain([true, true, false])),
        kill(
            "cavities that only meet",
            &["kill"],
            &[([o, x, y, far], 1, vec![1, 2, 3]), ([o, x, y, z], 4, vec![3, 4])],
        ),
        kill(
            "one whose tetrahedron another one has",
            &["kill"],
            &[([o, x, y, z], 2, vec![2, 3]), ([o, x, y, far], 1, vec![1, 2])],
        ),
        kill(
            "one that comes later kills nobody",
            &["kill"],
            &[([o, x, y, far], 1, vec![1, 2]), ([o, x, y, z], 2, vec![1, 2, 3])],
        ),
        kill(
            "one that is killed kills, too",
            &["kill-chain"],
            &[
                ([o, x, y, far], 1, vec![1, 2]),
                ([o, x, z, [9.0; 3]], 2, vec![2, 3]),
                ([o, x, y, z], 3, vec![3]),
            ],
        ),
        quiet("nothing sent, the first wave", None, [0, 0]),
        quiet("as many taken as sent, by chance", Some([3, 2]), [4, 4]),
        quiet("twice the same", Some([4, 4]), [4, 4]),
        quiet("twice the same, one under way", Some([4, 3]), [4, 3]),
    ]
}

/// Tetrahedra on a ring, each with neighbours on it.
fn ring(count: u32, share: u64, seed: u64) -> Around {
    let mut random = Rng::new(seed);
    let corners = (0..count).map(|_| tetrahedron(&mut random, 1 << 20)).collect();
    let over = (0..count).map(|_| random.below(4) < share).collect();
    let step = |t: u32, by: u32| (t + by) % count;
    let neighbours =
        (0..count).map(|t| [1, count - 1, 7, count - 7].map(|by| step(t, by))).collect();
    Around { corners, over, neighbours }
}

fn choice() -> Vec<Case> {
    let mut random = Rng::new(4);
    let mut cases: Vec<Case> = (0..8)
        .map(|k| {
            let corners = tetrahedron(&mut random, 1 << (4 + 5 * k));
            let count = [2, 3, 4][k % 3];
            key("whole coordinates", &corners[..count])
        })
        .collect();
    for (count, share, seed) in [(24, 4, 1), (40, 3, 2), (40, 1, 3)] {
        let flags = ["foremost", "foremost-beyond"];
        cases.push(foremost("a ring", &flags, &ring(count, share, seed)));
    }
    for (count, slots, most) in [(12, 40, 4), (30, 60, 9), (30, 400, 9)] {
        let candidates: Vec<Candidate> = (0..count)
            .map(|_| {
                let own = random.below(slots) as u32;
                let size = 1 + random.below(most);
                let mut cavity: BTreeSet<u32> =
                    (0..size).map(|_| random.below(slots) as u32).collect();
                cavity.insert(own);
                (tetrahedron(&mut random, 1 << 20), own, cavity.into_iter().collect())
            })
            .collect();
        cases.push(kill("random cavities", &["kill", "kill-chain"], &candidates));
    }
    cases
}

fn barrier() -> Vec<Case> {
    let mut random = Rng::new(8);
    let mut cases = Vec::new();
    for workers in [1, 2, 3, 17, 18, 40] {
        let ascending: Vec<u32> = (0..workers).collect();
        let descending: Vec<u32> = (0..workers).rev().collect();
        let mut mixed = ascending.clone();
        for k in (1..mixed.len()).rev() {
            mixed.swap(k, random.below(k as u64 + 1) as usize);
        }
        for order in [ascending, descending, mixed] {
            let name = format!("{workers} workers");
            cases.push(wave(&name, workers, &order, |me| {
                [i64::from(me) + 1, i64::from(me * me) - 3]
            }));
        }
    }
    cases
}
