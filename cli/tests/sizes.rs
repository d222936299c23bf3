//! Edge lengths near places and at parts, the longest edge, and one mesh of them for all.

use crate::common::ltbw;
use ltbw::TetMesh;
use std::path::Path;

const CUBE: &str = "8 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 1 1 0\n4 0 0 1\n\
                    5 1 0 1\n6 0 1 1\n7 1 1 1\n6 1\n\
                    1 0 1\n4 0 2 3 1\n1 0 2\n4 4 5 7 6\n1 0 3\n4 0 1 5 4\n\
                    1 0 4\n4 2 6 7 3\n1 0 5\n4 0 4 6 2\n1 0 6\n4 1 3 7 5\n0\n0\n";

fn meshed(dir: &Path, options: &[&str]) -> (TetMesh, String) {
    let run = ltbw(dir, &[&["mesh", "c.poly", "-o", "c.vtu"], options].concat());
    assert_eq!(run.code, 0, "{options:?}: {}", run.stderr);
    (ltbw::io::read_mesh(dir.join("c.vtu")).unwrap(), run.stdout)
}

/// The mean of the edges whose ends `are_meant`.
fn mean(mesh: &TetMesh, are_meant: impl Fn(&[f64; 3]) -> bool) -> f64 {
    let at = |v: u32| &mesh.points[v as usize];
    let (mut sum, mut count) = (0.0, 0.0);
    for tet in &mesh.tets {
        for (k, &v) in tet.iter().enumerate() {
            for &w in &tet[..k] {
                if are_meant(at(v)) && are_meant(at(w)) {
                    sum += (0..3).map(|k| (at(v)[k] - at(w)[k]).powi(2)).sum::<f64>().sqrt();
                    count += 1.0;
                }
            }
        }
    }
    assert!(count > 50.0);
    sum / count
}

#[test]
fn edges_are_short_near_places_and_at_parts_and_grow_from_there() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    std::fs::write(dir.join("c.poly"), CUBE).unwrap();
    let place = ["--near", "1,1,1:0.04:0.2", "--size", "0.2"];
    let (near, hash) = meshed(dir, &place);
    let is_near = |p: &[f64; 3]| p.iter().map(|c| (c - 1.0).powi(2)).sum::<f64>() < 0.04;
    let is_far = |p: &[f64; 3]| p.iter().all(|c| *c < 0.55);
    let [short, long] = [mean(&near, is_near), mean(&near, is_far)];
    assert!((0.034..0.046).contains(&short), "{short}");
    assert!((0.15..0.25).contains(&long), "{long}");
    let slow = [&place[..], &["--growth", "1.1"]].concat();
    assert!(meshed(dir, &slow).0.tets.len() > 2 * near.tets.len());
    for how in [&["--threads", "1"][..], &["--threads", "3"], &["--workers", "3"]] {
        assert_eq!(meshed(dir, &[&place[..], how].concat()).1, hash, "{how:?}");
    }
    // Facet 2 is z = 1.
    let (top, _) = meshed(dir, &["--size-at", "2:0.05", "--size", "0.3"]);
    let short = mean(&top, |p| p[2] == 1.0);
    assert!((0.04..0.06).contains(&short), "{short}");
    assert!(mean(&top, |p| p[2] < 0.5) > 0.1);
    for (wrong, code) in [
        (["--size-at", "9:0.1"], 2),
        (["--size-at", "top"], 2),
        (["--near", "1,1:0.1"], 2),
        (["--near", "1,1,1:-0.1"], 2),
        (["--growth", "0.5"], 2),
        (["--max-edge", "0"], 2),
        (["--max-edge", "1e-30"], 2),
    ] {
        let run = ltbw(dir, &[&["mesh", "c.poly"][..], &wrong].concat());
        assert_eq!(run.code, code, "{wrong:?}: {}", run.stderr);
        assert!(run.stderr.contains(&wrong[0][2..]), "{}", run.stderr);
    }
}

#[test]
fn no_edge_is_longer_than_the_longest_and_the_checker_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    std::fs::write(dir.join("c.poly"), CUBE).unwrap();
    let (mesh, hash) = meshed(dir, &["--max-edge", "0.2"]);
    let (parted, other) = meshed(dir, &["--max-edge", "0.2", "--workers", "2"]);
    assert_eq!((mesh.tets.len(), hash), (parted.tets.len(), other));
    let longest = |mesh: &TetMesh| {
        let square = |v: u32, w: u32| {
            let [p, q] = [v, w].map(|v| mesh.points[v as usize]);
            (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>()
        };
        let all = mesh.tets.iter().flat_map(|&[a, b, c, d]| {
            [square(a, b), square(a, c), square(a, d), square(b, c), square(b, d), square(c, d)]
        });
        all.fold(0.0, f64::max).sqrt()
    };
    let most = longest(&mesh);
    assert!(most <= 0.2 && most > 0.18, "{most}");
    let check = |bound: f64| {
        let bound = format!("{bound:?}");
        let args = ["check", "c.vtu", "--plc", "c.poly", "--max-edge", &bound, "--json", "-"];
        ltbw(dir, &args)
    };
    assert_eq!([check(most.next_up()).code, check(most * 0.999).code], [0, 1]);
    let report: serde_json::Value = serde_json::from_str(&check(most * 0.9).stdout).unwrap();
    assert_eq!(report["breach_counts"][0]["breach"], "edge_exceeded");
}
