//! The work of the program: mesh, check, convert, generate, demo.

use crate::common::{Run, json, ltbw, names};
use serde_json::Value;
use std::path::Path;

/// The hash that a run printed to stdout.
fn hash(run: &Run) -> &str {
    let hash = run.stdout.trim_end().strip_prefix("ltbw.mesh/1 ").expect(&run.stdout);
    assert!(hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit()), "{hash}");
    hash
}

/// Two unit cubes on top of each other with duplicates, one of them a negative zero.
fn cubes(dir: &Path) {
    let mut text = String::new();
    for i in 0..12 {
        text += &format!("{} {} {}\n", i & 1, i >> 1 & 1, i >> 2);
    }
    text += "1 1 1\n-0 0 0\n";
    std::fs::write(dir.join("cubes.xyz"), text).unwrap();
}

#[test]
fn the_report_has_its_fields() {
    let dir = tempfile::tempdir().unwrap();
    cubes(dir.path());
    let args = ["delaunay", "cubes.xyz", "-o", "a.vtu", "--check", "full", "--threads", "2"];
    let run = ltbw(dir.path(), &[&args[..], &["--json", "-"]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report = json(&run.stdout);
    assert_eq!(report["schema"], "ltbw.report/1");
    assert_eq!(report["command"], "delaunay");
    assert_eq!(report["outcome"], "complete");
    assert_eq!(report["input"]["points"], 14);
    assert_eq!(report["input"]["distinct"], 12);
    assert_eq!(report["input"]["duplicates"], 2);
    assert_eq!(report["input"]["duplicate_of"], json("[[12, 7], [13, 0]]"));
    assert_eq!(report["mesh"]["vertices"], 12);
    assert_eq!(report["mesh"]["hull_faces"], 20);
    assert!(report["mesh"]["tets"].as_u64().unwrap() >= 10);
    assert_eq!(report["mesh"]["hash"].as_str().unwrap().len(), 64);
    for field in ["calls", "exact"] {
        assert!(report["predicates"]["orient3d"][field].is_u64(), "{field}");
    }
    for field in ["calls", "exact", "perturbed"] {
        assert!(report["predicates"]["insphere"][field].is_u64(), "{field}");
    }
    assert!(report["predicates"]["insphere"]["perturbed"].as_u64().unwrap() > 0);
    for field in ["read", "order", "insert", "refine", "check", "hash", "write", "total"] {
        assert!(report["seconds"][field].is_f64(), "{field}");
    }
    assert_eq!(report["threads"], 2);
    if cfg!(target_os = "linux") {
        assert!(report["peak_rss_bytes"].as_u64().unwrap() > 1 << 20);
    }
    assert_eq!(report["certificate"]["schema"], "ltbw.cert/1");
    assert_eq!(report["outputs"], json("[\"a.vtu\"]"));

    let run = ltbw(dir.path(), &["delaunay", "cubes.xyz", "--check", "off", "--json", "r.json"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let other = json(&std::fs::read_to_string(dir.path().join("r.json")).unwrap());
    assert_eq!(other["mesh"]["hash"], report["mesh"]["hash"]);
    assert_eq!(other["mesh"]["hash"], hash(&run));
    assert_eq!(other["certificate"], Value::Null);
}

#[test]
fn one_mesh_whatever_the_formats_and_threads() {
    let dir = tempfile::tempdir().unwrap();
    let made = ltbw(dir.path(), &["generate", "clusters", "3000", "--seed", "5", "-o", "p.npy"]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    let first = ltbw(
        dir.path(),
        &["delaunay", "p.npy", "-o", "m.vtu", "-o", "m.mesh", "-o", "m.ele", "--check", "full"],
    );
    assert_eq!(first.code, 0, "{}", first.stderr);
    for extension in ["xyz", "csv", "node"] {
        let name = format!("q.{extension}");
        assert_eq!(ltbw(dir.path(), &["convert", "p.npy", &name]).code, 0);
        let run = ltbw(dir.path(), &["delaunay", &name, "--threads", "1"]);
        assert_eq!(hash(&run), hash(&first), "{name}");
    }
    for threads in ["2", "5"] {
        let args =
            ["delaunay", "p.npy", "--threads", threads, "--check", "full", "--json", "t.json"];
        let run = ltbw(dir.path(), &args);
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert_eq!(hash(&run), hash(&first), "{threads} threads");
        let text = std::fs::read_to_string(dir.path().join("t.json")).unwrap();
        let report = json(&text);
        let workers = report["workers"].as_array().unwrap();
        assert_eq!(workers.len().to_string(), threads);
        assert!(workers.iter().any(|w| w["operations"].as_u64() > Some(0)), "{workers:?}");
    }
    assert_eq!(ltbw(dir.path(), &["convert", "m.vtu", "n.ele"]).code, 0);
    for name in ["m.vtu", "m.mesh", "m.ele", "m.node", "n.ele"] {
        let run = ltbw(dir.path(), &["check", name]);
        assert_eq!(run.code, 0, "{name}: {}", run.stderr);
        assert_eq!(hash(&run), hash(&first), "{name}");
    }
    let run = ltbw(dir.path(), &["convert", "m.mesh", "back.npy"]);
    assert!(run.stderr.contains("tetrahedra are not kept"), "{}", run.stderr);
    let bytes = |name: &str| std::fs::read(dir.path().join(name)).unwrap();
    assert_eq!(bytes("back.npy"), bytes("p.npy"));
}

#[test]
fn convert_writes_text_and_the_older_gmsh_version() {
    let dir = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| {
        let run = ltbw(dir.path(), args);
        assert_eq!(run.code, 0, "{}", run.stderr);
        run
    };
    run(&["generate", "sphere", "50", "-o", "p.ply"]);
    let made = run(&["delaunay", "p.ply", "-o", "m.msh"]);
    let first = hash(&made);
    let starts: [(&[&str], &[u8]); 4] = [
        (&["a.msh"], b"$MeshFormat\n4.1 1 8\n"),
        (&["b.msh", "--ascii"], b"$MeshFormat\n4.1 0 8\n"),
        (&["c.msh", "--msh2"], b"$MeshFormat\n2.2 1 8\n"),
        (&["d.msh", "--msh2", "--ascii"], b"$MeshFormat\n2.2 0 8\n"),
    ];
    for (args, start) in starts {
        run(&[&["convert", "m.msh"], args].concat());
        assert!(std::fs::read(dir.path().join(args[0])).unwrap().starts_with(start), "{args:?}");
        assert_eq!(hash(&run(&["check", args[0]])), first, "{args:?}");
    }
    run(&["convert", "p.ply", "q.ply", "--ascii"]);
    assert!(std::fs::read(dir.path().join("q.ply")).unwrap().is_ascii());
    assert_eq!(hash(&run(&["delaunay", "q.ply"])), first);
    std::fs::write(dir.path().join("s.off"), "OFF\n4 0 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n").unwrap();
    run(&["delaunay", "s.off"]);
    let refused = ltbw(dir.path(), &["convert", "p.ply", "t.stl"]);
    assert_eq!(refused.code, 2);
    assert!(refused.error().starts_with("t.stl: this format is only read"), "{}", refused.stderr);
}

#[test]
fn check_finds_what_is_wrong() {
    let dir = tempfile::tempdir().unwrap();
    // The far corner of the cube lies inside the sphere of the other four points.
    let node = "5 3\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n4 .4 .4 .4\n";
    std::fs::write(dir.path().join("a.node"), node).unwrap();
    std::fs::write(dir.path().join("a.ele"), "2 4\n0 0 1 2 3\n1 1 2 3 4\n").unwrap();
    let run = ltbw(dir.path(), &["check", "a.ele"]);
    assert_eq!(run.code, 0, "sound, though not Delaunay: {}", run.stderr);
    assert!(run.stderr.contains("shape     not Delaunay at 1 faces, convex"), "{}", run.stderr);
    let run = ltbw(dir.path(), &["check", "a.ele", "--delaunay", "--json", "-"]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.error().starts_with("a.ele: defects: "), "{}", run.stderr);
    let certificate = json(&run.stdout);
    assert_eq!(certificate["schema"], "ltbw.cert/1");
    assert_eq!(
        (&certificate["passed"], &certificate["judged_as"]),
        (&false.into(), &"elements".into())
    );
    assert!(!certificate["defects"].as_array().unwrap().is_empty());
    std::fs::write(dir.path().join("a.ele"), "1 4\n0 0 1 2 9\n").unwrap();
    let run = ltbw(dir.path(), &["check", "a.ele"]);
    assert_eq!(run.code, 1);
    assert_eq!(
        run.error(),
        "a.ele: line 2: tetrahedron 0 names point 9, but points are numbered 0 to 4"
    );
    let run = ltbw(dir.path(), &["check", "a.npy"]);
    assert_eq!(
        (run.code, run.error()),
        (3, "a.npy: this format holds points, but a mesh is wanted")
    );
}

#[test]
fn tags_survive_or_a_note_says_not() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("a.csv"), "x,y,z,tag\n0,0,0,5\n1,0,0,6\n0,1,0,7\n0,0,1,-8\n")
        .unwrap();
    let run = ltbw(dir.path(), &["delaunay", "a.csv", "-o", "a.mesh"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(ltbw(dir.path(), &["convert", "a.mesh", "b.csv"]).code, 0);
    let text = |name: &str| std::fs::read_to_string(dir.path().join(name)).unwrap();
    assert_eq!(text("b.csv"), text("a.csv"));
    let run = ltbw(dir.path(), &["convert", "a.csv", "c.xyz"]);
    assert!(run.stderr.contains("note: c.xyz: tags are not kept"), "{}", run.stderr);
}

#[test]
fn generate_is_the_same_everywhere() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(
        ltbw(dir.path(), &["generate", "uniform", "2", "--seed", "1", "-o", "a.xyz"]).code,
        0
    );
    assert_eq!(
        std::fs::read_to_string(dir.path().join("a.xyz")).unwrap(),
        "0.5665615751722809 0.7457817572627011 0.9710027535867962\n\
         0.4443592170557721 0.44426470082635805 0.762894391911761\n"
    );
}

#[test]
fn the_demo_meshes_the_model_problem_and_shows_it() {
    let dir = tempfile::tempdir().unwrap();
    let run = ltbw(dir.path(), &["demo"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    for word in ["tetrahedra", "no defect", "volume 47/48", "seconds", "browser", "ParaView"] {
        assert!(run.stderr.contains(word), "{word}: {}", run.stderr);
    }
    assert_eq!(names(dir.path()), ["demo.html", "demo.vtu"]);
    // The page needs nothing from outside; tests/page.rs looks at it in a browser.
    let page = std::fs::read_to_string(dir.path().join("demo.html")).unwrap();
    assert!(page.starts_with("<!doctype html>") && page.ends_with("</html>\n"));
    assert!(page.contains(hash(&run)) && page.contains("ltbw.report/1"));
    // The commands that it names work.
    let next: Vec<&str> =
        run.stderr.lines().filter_map(|line| line.strip_prefix("  ltbw ")).take(2).collect();
    assert!(next.len() == 2 && next[1].starts_with("check "), "{next:?}");
    for command in next {
        let args: Vec<&str> = command.split(' ').collect();
        let run = ltbw(dir.path(), &args);
        assert_eq!(run.code, 0, "{command}: {}", run.stderr);
    }
}

/// The share that workers have in a domain is told, and the same where the cuts between them move.
#[test]
fn the_share_of_workers_is_told() {
    let dir = tempfile::tempdir().unwrap();
    let made = ltbw(dir.path(), &["generate", "tee", "-o", "d.poly"]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    let mesh = ["mesh", "d.poly", "--max-volume", "1e-4", "--json", "r.json"];
    let alone = ltbw(dir.path(), &mesh);
    for (more, moves) in [(&[][..], false), (&["--redeal", "2"], true)] {
        let run = ltbw(dir.path(), &[&mesh[..], &["--workers", "2"], more].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert_eq!(hash(&run), hash(&alone));
        let report = json(&std::fs::read_to_string(dir.path().join("r.json")).unwrap());
        let of = |name: &str| report["share"][name].as_f64().unwrap();
        let (vertices, start) = (report["mesh"]["vertices"].as_f64().unwrap(), of("start"));
        assert!(start > 1000.0 && start < vertices, "{start} of {vertices}");
        assert!((0.9..=1.0).contains(&of("by_workers")), "{}", report["share"]);
        assert!((1.0..1.5).contains(&of("busiest")), "{}", report["share"]);
        assert!(run.stderr.contains("share     "), "{}", run.stderr);
        assert_eq!(report["redeals"].is_object(), moves, "{report}");
    }
    for wrong in [&["--redeal", "2"][..], &["--workers", "2", "--redeal", "0"]] {
        assert_eq!(ltbw(dir.path(), &[&mesh[..], wrong].concat()).code, 2, "{wrong:?}");
    }
    let wrong = ["--workers", "2", "--mode", "async", "--redeal", "needed"];
    assert_eq!(ltbw(dir.path(), &[&mesh[..], &wrong].concat()).code, 2);
}
