//! A little that is excused is let pass, with a warning; with `--strict` nothing is.

use crate::common::{Run, json, ltbw, run};
use ltbw::io;
use ltbw_bindings::{Class, Reins, Source, Wishes};
use ltbw_generate::surfaces::{globe, prism, single};
use serde_json::Value;
use std::path::Path;

fn report(run: &Run) -> Value {
    json(&run.stdout)
}

/// A sphere by latitude and longitude: around its poles angles are too small for the bound.
fn sphere(dir: &Path) {
    io::write_domain(dir.join("s.stl"), &single(globe(30, 30, 0.0, 1))).unwrap();
}

/// The mesh of it: fine enough that this is a little.
const MESH: [&str; 4] = ["mesh", "s.stl", "--max-volume", "5e-5"];

/// The shares that a report has, of tetrahedra and of volume.
fn shares(report: &Value) -> [f64; 2] {
    let at = &report["refinement"]["excused_at"];
    [&at["share_of_tets"], &at["share"]].map(|share| share.as_f64().unwrap())
}

#[test]
fn a_little_that_is_excused_is_a_warning() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    sphere(dir);
    let made = run(dir, &[&MESH[..], &["-o", "s.vtu", "--json", "-"]].concat(), 0);
    let told = report(&made);
    assert_eq!(
        (&told["outcome"], &told["certificate"]["verdict"]),
        (&"excused".into(), &"excused".into())
    );
    assert_eq!(told["certificate"]["passed"], false);
    let [tets, volume] = shares(&told);
    assert!(0.0 < volume && volume < tets && tets < 0.01, "{tets} {volume}");
    let counted = told["refinement"]["excused"].as_f64().unwrap();
    assert!((tets - counted / told["certificate"]["tets"].as_f64().unwrap()).abs() < 1e-12);
    // The last line names places: the poles.
    let line = made.error();
    assert!(line.starts_with("excused, and little enough: "), "{line}");
    assert!(line.contains(" at (0, 0, 0.5)") || line.contains(" at (0, 0, -0.5)"), "{line}");
    assert!(!line.contains("--excused-share"), "{line}");
    // Quiet or not, it is told.
    assert_eq!(run(dir, &[&["-q"], &MESH[..]].concat(), 0).stderr.lines().count(), 1);
    let strict = run(dir, &[&MESH[..], &["--strict", "--json", "-"]].concat(), 1);
    assert_eq!(report(&strict)["certificate"]["verdict"], "failed");
    assert!(strict.error().starts_with("excused: "), "{}", strict.stderr);
    // The larger of both shares decides, and is what would help.
    let less = format!("{}", 0.99 * tets);
    let stopped = run(dir, &[&MESH[..], &["--excused-share", &less]].concat(), 1);
    let (_, help) = stopped.error().split_once("--excused-share ").unwrap();
    let share = help.split(' ').next().unwrap();
    assert!((1.0..1.1).contains(&(share.parse::<f64>().unwrap() / tets)), "{share}");
    let passed = run(dir, &[&MESH[..], &["--excused-share", share, "--json", "-"]].concat(), 0);
    assert_eq!(report(&passed)["certificate"]["verdict"], "excused");
    run(dir, &[&MESH[..], &["--excused-share", "0"]].concat(), 1);
    // The bindings give the same words.
    for (limit, word) in [(None, "excused"), (Some(0.99 * tets), "failed"), (Some(0.0), "failed")] {
        assert_eq!(verdict(&dir.join("s.stl"), limit), word);
    }
}

/// The verdict of the bindings on their mesh of a file.
fn verdict(path: &Path, excused_share: Option<f64>) -> String {
    let bounds = Wishes { radius_edge: Some(2.0), max_volume: Some(5e-5), ..Wishes::default() };
    let wishes = Wishes { excused_share, ..bounds };
    let source = Source::File(path.to_owned());
    let (ready, reins) = (ltbw_bindings::Ready::new(source, &wishes).unwrap(), Reins::default());
    let refined = ready.refine(&wishes, None, false, &reins.progress, &reins.cancel).unwrap();
    let text = ready.finish(&wishes, refined).unwrap().certificate.unwrap();
    let certificate = json(&text);
    assert_eq!(certificate["passed"], false);
    certificate["verdict"].as_str().unwrap().to_owned()
}

#[test]
fn shares_that_are_none_are_usage_errors() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    run(dir, &["generate", "tee", "-o", "t.stl"], 0);
    for share in ["0.051", "-0.001", "NaN", "1", "inf", "x"] {
        let refused = run(dir, &["mesh", "t.stl", "--excused-share", share], 2);
        assert!(refused.error().contains("--excused-share"), "{}", refused.stderr);
        let Ok(share) = share.parse() else { continue };
        let wishes = Wishes { excused_share: Some(share), ..Wishes::default() };
        let source = Source::File(dir.join("t.stl"));
        let failure = ltbw_bindings::Ready::new(source, &wishes).unwrap_err();
        assert_eq!((failure.class, failure.code), (Class::Input, "refine.bound"));
    }
    let met = run(dir, &["mesh", "t.stl", "--excused-share", "0.05", "--strict", "--json", "-"], 0);
    assert_eq!(report(&met)["certificate"]["verdict"], "passed");
    assert_eq!(met.stderr.lines().filter(|line| line.starts_with("ltbw: ")).count(), 0);
}

/// A prism whose caps are flat up to a noise: within that as a tolerance nothing is excused there.
#[test]
fn the_tolerance_that_helps_is_named_and_helps() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    io::write_domain(dir.join("p.stl"), &single(prism(24, 1e-5, 1))).unwrap();
    let told = ltbw(dir, &["mesh", "p.stl", "--min-dihedral", "0", "--json", "-"]);
    let [before, _] = shares(&report(&told));
    assert!(before > 0.0, "{}", told.stderr);
    let (_, help) = told.error().split_once("--flat-tolerance ").unwrap();
    let tolerance = help.split(' ').next().unwrap();
    assert!((1e-7..1e-3).contains(&tolerance.parse::<f64>().unwrap()), "{tolerance}");
    let helped = ["mesh", "p.stl", "--flat-tolerance", tolerance, "--json", "-"];
    let helped = ltbw(dir, &helped);
    let [after, _] = shares(&report(&helped));
    assert!(after < before, "{after} {before}: {}{}", told.stderr, helped.stderr);
}

#[test]
fn a_strict_run_takes_the_input_as_it_is_or_not_at_all() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let cube = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n";
    let sides = "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";
    let off = |vertices: &str, facets: &str| {
        let counts = [cube, vertices, sides, facets].map(|lines| lines.lines().count());
        let [vertex_count, facet_count] = [counts[0] + counts[1], counts[2] + counts[3]];
        format!("OFF\n{vertex_count} {facet_count} 0\n{cube}{vertices}{sides}{facets}")
    };
    let corner = |scale: f64, v: u32| [v, v >> 1, v >> 2].map(|bit| scale * f64::from(bit & 1));
    let inner: String = (0..8)
        .map(|v| corner(0.5, v).map(|c| c + 0.25))
        .map(|[x, y, z]| format!("{x} {y} {z}\n"))
        .collect();
    let moved = |line: &str| {
        let corners = line.split(' ').skip(1).map(|v| 8 + v.parse::<u32>().unwrap());
        format!("4 {}\n", corners.map(|v| v.to_string()).collect::<Vec<_>>().join(" "))
    };
    let nested: String = sides.lines().map(moved).collect();
    let away = "2 2 2\n3 2 2\n2 3 2\n";
    let welded = off("1e-12 0 0\n", "").replacen("4 0", "4 8", 1);
    let cases = [
        ("a facet given twice", off("", "4 0 2 3 1\n"), "given before"),
        ("a facet without area", off("", "3 0 1 0\n"), "without area"),
        ("a corner twice, less than a step apart", welded, "welded to others"),
        ("a vertex of nothing", off("2 2 2\n", ""), "1 vertex left out"),
        ("a facet away from the body", off(away, "3 8 9 10\n"), "1 facet left out"),
        ("a facet that ends outside", off("0.5 -1 0\n", "3 0 1 8\n"), "ends in the exterior"),
        ("a flap", off("2 0 0.5\n", "3 1 5 8\n3 5 1 8\n"), "given from either side"),
        ("a body in a body, turned likewise", off(&inner, &nested), "1 body lies inside another"),
    ];
    let strict_or_not = |name: &str, what: &str, word: &str| {
        let lenient = run(dir, &["mesh", name], 0);
        assert!(lenient.stderr.contains(word), "{what}: {}", lenient.stderr);
        for args in [&["mesh", name, "-o", "c.vtu"][..], &["check", name, "--json", "c.json"]] {
            let strict = run(dir, &[args, &["--strict"]].concat(), 3);
            let refused = strict.error().strip_prefix(&format!("{name}: not repaired"));
            assert!(refused.unwrap().contains(word), "{what}: {}", strict.stderr);
            assert!(!dir.join("c.vtu").exists(), "{what}");
        }
    };
    for (what, text, word) in cases {
        std::fs::write(dir.join("c.off"), text).unwrap();
        strict_or_not("c.off", what, word);
    }
    std::fs::write(dir.join("c.off"), off("", "")).unwrap();
    run(dir, &["mesh", "c.off", "--strict"], 0);
}

#[test]
fn a_move_to_the_lattice_is_told_as_a_part_of_the_diagonal() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    sphere(dir);
    let made = run(dir, &[&MESH[..], &["--json", "-"]].concat(), 0);
    let note = made.stderr.lines().find(|line| line.contains("moved to the lattice")).unwrap();
    let part: f64 =
        note.strip_suffix(" of the diagonal").unwrap().rsplit(' ').next().unwrap().parse().unwrap();
    let lattice = &report(&made)["refinement"]["lattice"];
    let (own, largest) = (&lattice["largest_move_of_diagonal"], &lattice["largest_move"]);
    let diagonal = largest.as_f64().unwrap() / own.as_f64().unwrap();
    assert!((1.5..1.8).contains(&diagonal), "{diagonal}");
    assert!((part / own.as_f64().unwrap() - 1.0).abs() < 0.06, "{note}");
    let checked = run(dir, &["check", "s.stl"], 0);
    assert!(checked.stderr.contains(" of the diagonal"), "{}", checked.stderr);
}
