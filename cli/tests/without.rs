//! `delaunay --without`: the mesh of what is left, in numbers without gaps.

use crate::common::{json, names, run};
use std::fs::{read, write};
use std::path::Path;

/// Writes points of a lattice, and every third of them; and the others.
fn files(dir: &Path) {
    let all: Vec<String> =
        (0..343).map(|i| format!("{} {} {}", i % 7, i / 7 % 7, i / 49)).collect();
    let some = |is: fn(usize) -> bool| {
        let lines = all.iter().enumerate().filter(|&(k, _)| is(k)).map(|(_, line)| line.clone());
        lines.collect::<Vec<String>>().join("\n") + "\n"
    };
    write(dir.join("all.xyz"), some(|_| true)).unwrap();
    write(dir.join("gone.xyz"), some(|k| k % 3 == 0)).unwrap();
    write(dir.join("left.xyz"), some(|k| k % 3 != 0)).unwrap();
}

#[test]
fn what_is_left_is_meshed_as_if_it_were_all() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    files(dir);
    let without = ["delaunay", "all.xyz", "--without", "gone.xyz", "--check", "full"];
    let one = run(dir, &[&without[..], &["-o", "m.vtu", "--json", "r.json"]].concat(), 0);
    let other = run(dir, &["delaunay", "left.xyz", "-o", "l.node"], 0);
    assert_eq!(one.stdout, other.stdout);
    assert!(one.stderr.contains("without   115 of 343 points, by gone.xyz"), "{}", one.stderr);
    // All that is in the file is in the mesh.
    assert_eq!(run(dir, &["check", "m.vtu", "--delaunay"], 0).stdout, one.stdout);
    let check = ["check", "m.vtu", "--certificate", "r.json"];
    run(dir, &[&check[..], &["--input", "all.xyz", "--input", "gone.xyz"]].concat(), 0);
    run(dir, &[&without[..], &["-o", "n.node"]].concat(), 0);
    assert_eq!(read(dir.join("n.node")).unwrap(), read(dir.join("l.node")).unwrap());
    // By several workers, and from a stream.
    let parallel = [&without[..], &["--threads", "2", "--json", "-"]].concat();
    let report = json(&run(dir, &parallel, 0).stdout);
    assert_eq!(
        (&report["input"]["points"], &report["mesh"]["vertices"]),
        (&228.into(), &228.into())
    );
    // A place twice is a place; so is a point that was there twice.
    let twice =
        |name: &str| [read(dir.join(name)).unwrap(), read(dir.join(name)).unwrap()].concat();
    write(dir.join("gone.xyz"), twice("gone.xyz")).unwrap();
    write(dir.join("all.xyz"), twice("all.xyz")).unwrap();
    assert_eq!(run(dir, &without, 0).stdout, other.stdout);
}

#[test]
fn a_point_that_is_no_vertex_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    files(dir);
    let before = names(dir);
    write(dir.join("gone.xyz"), "1 2 3\n-0.0 6 6\n1 2 3.5\n").unwrap();
    let without = ["delaunay", "all.xyz", "--without", "gone.xyz", "-o", "m.vtu"];
    let refused = run(dir, &without, 3);
    let text = "gone.xyz: point 2, [1.0, 2.0, 3.5], is no vertex of the mesh";
    assert!(refused.error().contains(text), "{}", refused.stderr);
    // Nothing is left but a plane.
    write(dir.join("all.xyz"), "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n").unwrap();
    write(dir.join("gone.xyz"), "0 0 1\n").unwrap();
    let refused = run(dir, &without, 3);
    assert!(refused.error().contains("gone.xyz: without vertex 4"), "{}", refused.stderr);
    let parts = ["delaunay", "all.xyz", "--threads", "2", "--without", "gone.xyz", "-o", "m.pvtu"];
    assert!(run(dir, &parts, 2).error().contains("--without"));
    assert_eq!(names(dir), before, "nothing was written");
}
