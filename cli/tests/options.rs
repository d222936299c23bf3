//! Options do what they say: parts, pairs of files, holes, orientation; and help names them.

use crate::common::{Run, json, names, read_json, run};
use std::path::Path;

/// The hash that a run printed to stdout.
fn hash(run: &Run) -> String {
    run.stdout.trim_end().strip_prefix("ltbw.mesh/1 ").unwrap().to_owned()
}

#[test]
fn a_mesh_in_parts_is_checked_and_converted_as_the_whole() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    run(dir, &["generate", "cube-in-cube", "-o", "d.poly"], 0);
    let mesh = ["mesh", "d.poly", "--max-volume", "1e-2", "--workers", "3"];
    let outputs = ["-o", "m.pvtu", "-o", "m_%.msh", "-o", "m.mfem", "-o", "m.vtkhdf"];
    let made = run(dir, &[&mesh[..], &outputs, &["--json", "r.json"]].concat(), 0);
    for file in ["m_3.msh", "m.000002", "m.vtkhdf"] {
        assert!(made.stderr.contains(&format!("wrote     {file}")), "{}", made.stderr);
    }
    let told = read_json(dir.join("r.json"))["mesh"]["hash"].as_str().unwrap().to_owned();
    assert_eq!(hash(&made), told);
    assert_eq!(hash(&run(dir, &["check", "m.pvtu"], 0)), told);
    for file in ["m.pvtu", "m_%.msh"] {
        run(dir, &["convert", file, "w.vtu"], 0);
        assert_eq!(hash(&run(dir, &["check", "w.vtu"], 0)), told);
        run(dir, &["check", file, "--plc", "d.poly"], 0);
        run(dir, &["check", file, "--certificate", "r.json", "--input", "d.poly"], 0);
    }
    // Without a part there is no mesh.
    std::fs::remove_file(dir.join("m_2.msh")).unwrap();
    assert!(run(dir, &["check", "m_%.msh"], 3).error().contains("m_2.msh"));
    std::fs::remove_file(dir.join("m_1.vtu")).unwrap();
    let refused = run(dir, &["check", "m.pvtu"], 3);
    assert!(refused.error().contains("m_1.vtu"), "{}", refused.stderr);
}

/// `-o m.ele -o m.node` is one mesh in two files, in whatever order.
#[test]
fn a_pair_of_files_is_one_output() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    run(dir, &["generate", "cube-in-cube", "-o", "d.poly"], 0);
    run(dir, &["generate", "uniform", "50", "-o", "p.csv"], 0);
    for command in [&["mesh", "d.poly"][..], &["delaunay", "p.csv"]] {
        let written = |outputs: &[&str]| {
            let args = [command, outputs, &["--json", "-"]].concat();
            let outputs = json(&run(dir, &args, 0).stdout)["outputs"].clone();
            let files: Vec<(String, Vec<u8>)> = names(dir)
                .into_iter()
                .filter(|name| name.starts_with("m."))
                .map(|name| (name.clone(), std::fs::read(dir.join(name)).unwrap()))
                .collect();
            files.iter().for_each(|(name, _)| std::fs::remove_file(dir.join(name)).unwrap());
            (outputs, files)
        };
        let alone = written(&["-o", "m.ele"]);
        assert!(alone.1.iter().any(|(name, _)| name == "m.node"), "{command:?}");
        assert_eq!(written(&["-o", "m.ele", "-o", "m.node"]), alone);
        assert_eq!(written(&["-o", "m.node", "-o", "m.ele"]), alone);
        for other in [["-o", "m.ele"], ["--json", "m.node"]] {
            let twice = [command, &["-o", "m.ele"], &other].concat();
            assert!(run(dir, &twice, 2).error().contains("two outputs"), "{twice:?}");
        }
    }
}

/// A cube in a cube, which is turned inward or not.
fn nested(dir: &Path, inward: bool) {
    let mut text = "OFF\n16 12 0\n".to_owned();
    for half in [4, 1] {
        let side = |v: u32, bit: u32| if v >> bit & 1 == 0 { -half } else { half };
        let corner = |v: u32| format!("{} {} {}\n", side(v, 0), side(v, 1), side(v, 2));
        text.extend((0..8).map(corner));
    }
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for first in [0, 8] {
        for mut side in sides {
            if first > 0 && inward {
                side.reverse();
            }
            let [a, b, c, d] = side.map(|v| v + first);
            text += &format!("4 {a} {b} {c} {d}\n");
        }
    }
    std::fs::write(dir.join("n.off"), text).unwrap();
}

#[test]
fn holes_are_what_is_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let volume = |args: &[&str]| {
        let told = run(dir, &[&["mesh", "n.off", "--json", "-"], args].concat(), 0);
        let report = json(&told.stdout);
        let regions = report["refinement"]["regions"].as_array().unwrap().len();
        let volume = report["certificate"]["volume"].as_str().unwrap().to_owned();
        (volume, regions, told.stderr.contains("of its own (holes `auto`"))
    };
    let (filled, empty) = (|noted| ("512".to_owned(), 2, noted), ("504".to_owned(), 1, false));
    for inward in [false, true] {
        nested(dir, inward);
        assert_eq!(volume(&[]), if inward { empty.clone() } else { filled(true) });
        assert_eq!(volume(&["--holes", "none"]), filled(false));
        assert_eq!(volume(&["--holes", "auto"]), empty);
        for points in ["0,0,0", "0.5, -0.5, 0.25;", "0,0,0;0.5,0.5,0.5"] {
            assert_eq!(volume(&["--holes", points]), empty, "{points}");
        }
    }
    // A point outside of all, and none left to mesh.
    run(dir, &["mesh", "n.off", "--holes", "9,9,9"], 3);
    run(dir, &["mesh", "n.off", "--holes", "0,0,0;2,2,2"], 3);
    for wrong in ["", "all", "1,2", "1,2,3,4", "0,0,x", "0,0,inf"] {
        let refused = run(dir, &["mesh", "n.off", "--holes", wrong], 2);
        assert!(refused.error().contains("--holes"), "{wrong}: {}", refused.stderr);
    }
}

#[test]
fn negative_tetrahedra_are_turned_where_that_is_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let points = "5 3 0 0\n0 0 0 0\n1 4 0 0\n2 0 4 0\n3 1 1 1\n4 1 1 -1\n";
    std::fs::write(dir.join("m.node"), points).unwrap();
    std::fs::write(dir.join("m.ele"), "2 4 0\n0 0 1 2 3\n1 0 1 2 4\n").unwrap();
    let wrong = run(dir, &["check", "m.ele"], 1);
    assert!(wrong.stderr.contains("--orient"), "{}", wrong.stderr);
    run(dir, &["convert", "m.ele", "same.vtu"], 0);
    run(dir, &["check", "same.vtu"], 1);
    let turned = run(dir, &["convert", "m.ele", "turned.vtu", "--orient"], 0);
    let note = "1 of 2 tetrahedra are turned to positive orientation";
    assert!(turned.stderr.contains(note), "{}", turned.stderr);
    let found = hash(&run(dir, &["check", "turned.vtu"], 0));
    assert_eq!(hash(&run(dir, &["check", "m.ele", "--any-order"], 0)), found);
    let refused = run(dir, &["convert", "m.node", "p.csv", "--orient"], 2);
    assert!(refused.error().starts_with("--orient"), "{}", refused.stderr);
}

#[test]
fn help_names_meshes_in_parts() {
    let dir = tempfile::tempdir().unwrap();
    for command in ["check", "convert", "mesh", "delaunay"] {
        let help = run(dir.path(), &["help", command], 0).stdout;
        assert!(help.contains(".pvtu"), "{command}: {help}");
    }
}

/// Two formats of meshes in parts have no number for the exterior: that is said before the work.
#[test]
fn the_exterior_is_written_in_parts_where_it_has_a_number() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    run(dir, &["generate", "tee", "-o", "t.poly"], 0);
    let mesh = ["mesh", "t.poly", "--max-volume", "0.01", "--workers", "2", "--keep-exterior"];
    for name in ["t_%.msh", "t.mfem"] {
        let refused = run(dir, &[&mesh[..], &["-o", name]].concat(), 2);
        assert!(refused.stderr.contains("--keep-exterior"), "{name}: {}", refused.stderr);
        assert!(refused.stderr.contains(name), "{name}: {}", refused.stderr);
    }
    assert_eq!(names(dir), ["t.poly"]);
    for name in ["t.pvtu", "t.vtkhdf"] {
        run(dir, &[&mesh[..], &["-o", name]].concat(), 0);
    }
    let regions = ltbw::io::read_mesh(dir.join("t.pvtu")).unwrap().tet_tags.unwrap();
    assert!(regions.contains(&0) && regions.contains(&1));
}
