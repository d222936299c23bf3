//! Certificates are bound to the mesh, to the input and to the options, and `check --certificate`
//! finds what is another.

use crate::common::{program, read_json, run};
use ltbw::io::{Format, carried_hash};
use serde_json::{Value, json};
use std::io::Write;
use std::path::Path;
use std::process::Stdio;

fn read(dir: &Path, name: &str) -> Value {
    read_json(dir.join(name))
}

/// SHA-256 as another program has it.
fn sha256(dir: &Path, name: &str) -> String {
    let found = std::process::Command::new("sha256sum").arg(name).current_dir(dir).output();
    String::from_utf8(found.unwrap().stdout).unwrap()[..64].to_owned()
}

/// Domain, its points in a file of their own, edge lengths, and a mesh of it with its report.
fn made(dir: &Path) -> Value {
    run(dir, &["generate", "cube-in-cube", "-o", "w.poly"], 0);
    let whole = std::fs::read_to_string(dir.join("w.poly")).unwrap();
    let mut lines = whole.lines().skip_while(|line| line.starts_with('#'));
    let count: usize = lines.next().unwrap().split(' ').next().unwrap().parse().unwrap();
    let points: Vec<&str> = lines.by_ref().take(count).collect();
    let facets: Vec<&str> = lines.collect();
    let node = format!("{count} 3 0 0\n{}\n", points.join("\n"));
    std::fs::write(dir.join("d.node"), node).unwrap();
    std::fs::write(dir.join("d.poly"), format!("0 3 0 0\n{}\n", facets.join("\n"))).unwrap();
    std::fs::write(dir.join("s.mtr"), format!("{count} 1\n{}", "0.3\n".repeat(count))).unwrap();
    let args = ["mesh", "d.poly", "--sizes", "s.mtr", "--max-volume", "1e-2", "--json", "r.json"];
    run(dir, &[&args[..], &["-o", "m.vtu", "-o", "m.msh", "-o", "m.mesh"]].concat(), 0);
    read(dir, "r.json")
}

#[test]
fn a_report_binds_its_certificate() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let report = made(dir);
    let binding = &report["certificate"]["binding"];
    assert_eq!(binding["mesh"], report["mesh"]["hash"]);
    let inputs = binding["inputs"].as_array().unwrap();
    let names = [("input", "d.poly"), ("companion", "d.node"), ("sizes", "s.mtr")];
    assert_eq!(inputs.len(), names.len(), "{binding}");
    for (input, (role, name)) in inputs.iter().zip(names) {
        assert_eq!((&input["role"], &input["name"]), (&json!(role), &json!(name)));
    }
    for (input, (_, name)) in inputs.iter().zip(names) {
        assert_eq!(input["sha256"], sha256(dir, name), "{name}");
        assert_eq!(input["bytes"], std::fs::metadata(dir.join(name)).unwrap().len());
    }
    let options = &binding["options"];
    assert_eq!((&options["max_volume"], &options["radius_edge"]), (&json!("0.01"), &json!("2.0")));
    // Two formats carry the hash, and others read them as before.
    for (name, format) in [("m.vtu", Format::Vtu), ("m.msh", Format::Msh)] {
        let bytes = std::fs::read(dir.join(name)).unwrap();
        assert_eq!(carried_hash(format, &bytes).as_deref(), report["mesh"]["hash"].as_str());
        let again = ltbw::io::read_mesh_file(dir.join(name)).unwrap();
        assert!(again.notes.iter().all(|note| !note.contains("Comments")), "{:?}", again.notes);
    }
    // Threads and outputs are no options of the mesh; a bound is one.
    let other = |more: &[&str]| {
        let base = ["mesh", "d.poly", "--sizes", "s.mtr", "--json", "o.json"];
        run(dir, &[&base[..], more].concat(), 0);
        read(dir, "o.json")["certificate"]["binding"].clone()
    };
    assert_eq!(&other(&["--max-volume", "1e-2", "--threads", "1", "--workers", "2"]), binding);
    let tighter = other(&["--max-volume", "9e-3"]);
    assert_ne!(tighter["options_sha256"], binding["options_sha256"]);
}

#[test]
fn a_mesh_is_compared_with_what_is_certified() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let report = made(dir);
    let check = |mesh: &str, more: &[&str], code: i32| {
        run(dir, &[&["check", mesh, "--certificate", "r.json"], more].concat(), code)
    };
    for mesh in ["m.vtu", "m.msh", "m.mesh"] {
        let told = check(mesh, &["--input", "d.poly", "--input", "s.mtr"], 0);
        assert!(told.stderr.contains("3 of 3 inputs"), "{}", told.stderr);
        check(mesh, &[], 0);
    }
    run(dir, &["mesh", "d.poly", "--max-volume", "1e-2", "--keep-exterior", "-o", "e.vtu"], 0);
    run(dir, &["mesh", "d.poly", "--max-volume", "5e-3", "-o", "o.vtu", "-o", "o.mesh"], 0);
    let told = check("o.mesh", &[], 1);
    assert!(told.stderr.contains("differs   mesh: its hash is "), "{}", told.stderr);
    assert!(told.error().ends_with("from r.json"), "{}", told.stderr);
    // A hash that is carried on, but is another mesh's.
    let text = std::fs::read(dir.join("m.vtu")).unwrap();
    let hash = report["mesh"]["hash"].as_str().unwrap();
    let place = text.windows(64).position(|part| part == hash.as_bytes()).unwrap();
    let mut other = text.clone();
    other[place] = if other[place] == b'0' { b'1' } else { b'0' };
    std::fs::write(dir.join("x.vtu"), other).unwrap();
    let told = check("x.vtu", &[], 1);
    assert!(told.stderr.contains("the one that the file carries"), "{}", told.stderr);
    // Each file of the input, a byte more.
    for (name, given) in [("d.poly", "d.poly"), ("d.node", "d.poly"), ("s.mtr", "d.poly")] {
        let before = std::fs::read(dir.join(name)).unwrap();
        std::fs::write(dir.join(name), [&before[..], b"\n"].concat()).unwrap();
        let told = check("m.vtu", &["--input", given, "--input", "s.mtr"], 1);
        let word = format!("differs   input: {name}: its SHA-256 is ");
        assert!(told.stderr.contains(&word), "{}", told.stderr);
        std::fs::write(dir.join(name), before).unwrap();
    }
    let told = check("m.vtu", &["--input", "d.poly", "--input", "w.poly"], 1);
    assert!(told.stderr.contains("w.poly: the certificate has no such file"), "{}", told.stderr);
}

#[test]
fn a_report_that_was_changed_is_found() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let report = made(dir);
    let changes: [(&str, Value, &str); 5] = [
        ("/certificate/binding/mesh", json!("0".repeat(64)), "that of the certificate"),
        ("/mesh/hash", json!("0".repeat(64)), "that of the report"),
        ("/certificate/binding/options/max_volume", json!("1.0"), "options: their hash"),
        ("/certificate/verdict", json!("failed"), "its verdict is failed"),
        ("/certificate/binding/inputs/0/sha256", json!("0".repeat(64)), "input: d.poly"),
    ];
    for (place, value, word) in changes {
        let mut other = report.clone();
        *other.pointer_mut(place).unwrap() = value;
        if place == "/certificate/verdict" {
            other["certificate"]["passed"] = false.into();
        }
        std::fs::write(dir.join("x.json"), other.to_string()).unwrap();
        let args = ["check", "m.vtu", "--certificate", "x.json", "--input", "d.poly"];
        let told = run(dir, &args, 1);
        assert!(told.stderr.contains(word), "{place}: {}", told.stderr);
    }
    // A report that certifies nothing is no input for it.
    run(dir, &["mesh", "d.poly", "--check", "off", "--json", "u.json"], 0);
    run(dir, &["check", "m.vtu", "--plc", "d.poly", "--json", "c.json"], 0);
    std::fs::write(dir.join("n.json"), "{}").unwrap();
    for (name, why) in [
        ("u.json", "without a certificate"),
        ("c.json", "not bound to a mesh"),
        ("n.json", "neither a report nor a certificate"),
        ("m.vtu", "no JSON"),
        ("none.json", "cannot read"),
    ] {
        let told = run(dir, &["check", "m.vtu", "--certificate", name], 3);
        assert!(told.error().starts_with(name) && told.error().contains(why), "{}", told.stderr);
    }
    run(dir, &["check", "m.vtu", "--input", "d.poly"], 2);
    run(dir, &["check", "d.poly", "--certificate", "u.json"], 2);
}

#[test]
fn points_and_stdin_are_bound_too() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    run(dir, &["generate", "uniform", "300", "-o", "p.csv"], 0);
    let args = ["delaunay", "-", "--format", "csv", "--json", "r.json", "-o", "m.msh"];
    let mut child = program(dir, &args)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let bytes = std::fs::read(dir.join("p.csv")).unwrap();
    child.stdin.take().unwrap().write_all(&bytes).unwrap();
    assert!(child.wait().unwrap().success());
    let binding = &read(dir, "r.json")["certificate"]["binding"];
    let input = json!([{
        "role": "input", "name": "stdin", "bytes": bytes.len(), "sha256": sha256(dir, "p.csv"),
    }]);
    assert_eq!(binding["inputs"], input);
    let args = ["check", "m.msh", "--certificate", "r.json", "--input", "p.csv"];
    run(dir, &args, 0);
    // The certificate alone is enough.
    let certificate = read(dir, "r.json")["certificate"].to_string();
    std::fs::write(dir.join("r.json"), certificate).unwrap();
    run(dir, &args, 0);
    run(dir, &["generate", "uniform", "300", "--seed", "2", "-o", "p.csv"], 0);
    run(dir, &args, 1);
}
