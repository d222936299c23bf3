//! Figures of simulated processors claim no more than was done: nothing about nothing, the whole
//! beside the kernel, and the paper's figures as the paper has them.

use crate::common::{Run, ltbw, read_json, run};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

fn simulation(dir: &Path, args: &[&str]) -> (Value, Run) {
    let run = run(dir, &[&["simulate", "--json", "a.json"], args].concat(), 0);
    (read_json(dir.join("a.json"))["simulation"].clone(), run)
}

/// The figures in a row of a table.
fn row<'a>(text: &'a str, name: &str) -> Vec<&'a str> {
    let line = text.lines().find_map(|line| line.trim_start().strip_prefix(name));
    line.unwrap_or_else(|| panic!("{name}: {text}"))
        .split("  ")
        .map(str::trim)
        .filter(|w| !w.is_empty())
        .collect()
}

#[test]
fn no_latency_is_tolerated_where_there_was_none() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let (figures, run) = simulation(dir, &["--points", "600", "--processors", "1"]);
    assert!(figures["lt"].is_null() && figures["lt_strict"].is_null(), "{figures}");
    assert!(figures["worst"]["lt"].is_null() && figures["workers"][0]["lt"].is_null());
    assert!(figures["operations"].as_u64() > Some(0));
    assert_eq!(row(&run.stdout, "LT, all workers"), ["-", "-", "-"]);
    assert_eq!(row(&run.stdout, "latency tolerance LT, worst worker (-)"), ["-", "0.96", "0.94"]);
    let (figures, _) = simulation(dir, &["--points", "3000", "--processors", "4"]);
    assert!(figures["lt"].is_f64() && figures["cavities"]["interface"].as_u64() > Some(0));
}

#[test]
fn a_run_that_does_nothing_is_refused_with_what_to_change() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let large = ["--domain", "cube-in-cube", "--max-volume", "1e-3", "--start", "100000"];
    for (args, word) in [
        (&["--points", "8", "--processors", "2", "--sample", "8"][..], "more --points"),
        (&[&large[..], &["--mode", "async"]].concat(), "a smaller --max-volume or --start"),
        (&["--domain", "cube-in-cube", "--max-volume", "0.1"], "a smaller --max-volume or --start"),
    ] {
        let refused = run(dir, &[&["simulate"], args].concat(), 2);
        assert!(refused.error().contains(word), "{args:?}: {}", refused.stderr);
        assert_eq!(refused.stdout, "", "{args:?}");
    }
    // By default the mesh at the start is a part of that at the end.
    for mode in ["rounds", "async"] {
        let args = ["--domain", "cube-in-cube", "--max-volume", "2e-4", "--mode", mode];
        let (figures, _) = simulation(dir, &[&args[..], &["--processors", "8"]].concat());
        let start = figures["start"].as_u64().unwrap();
        let operations = figures["operations"].as_u64().unwrap();
        assert!(operations > start && start > 50, "{mode}: {start} {operations}");
    }
}

#[test]
fn the_whole_is_told_beside_the_kernel() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let domain = ["--domain", "cube-octahedron", "--max-volume", "5e-4", "--start", "100"];
    let runs: [(&[&str], &str); 3] = [
        (&["--points", "3000"], "Insertion of points"),
        (&domain, "Refinement in rounds"),
        (&[&domain[..], &["--mode", "async"]].concat(), "Refinement without rounds"),
    ];
    for (args, doing) in runs {
        let (figures, run) = simulation(dir, &[args, &["--processors", "4"]].concat());
        assert!(run.stdout.contains(doing), "{args:?}: {}", run.stdout);
        assert_eq!(run.stdout.contains("Insertion of points"), doing == "Insertion of points");
        let whole = &figures["whole"];
        let part = |name: &str| whole[name].as_u64().unwrap();
        let parts = ["start", "distribution", "kernel"].map(part);
        assert!(parts.iter().all(|&time| time > 0), "{whole}");
        // Processors keep their parts, but for what takes the whole mesh.
        let ends = ["gathering", "numbering"].map(part);
        let is_gathered = doing == "Refinement without rounds";
        assert_eq!(ends.map(|time| time > 0), [is_gathered, !is_gathered], "{whole}");
        assert_eq!(parts.iter().chain(&ends).sum::<u64>(), part("makespan"), "{whole}");
        assert_eq!(part("kernel"), figures["makespan"]);
        let efficiency = whole["efficiency"].as_f64().unwrap();
        let alone = part("one_processor") as f64 / (4.0 * part("makespan") as f64);
        assert!((alone - efficiency).abs() < 1e-9, "{whole}");
        assert!(part("one_processor") > figures["one_processor"].as_u64().unwrap(), "{whole}");
        let told = row(&run.stdout, "makespan, whole");
        assert_eq!(told[0], format!("{:.6} s", part("makespan") as f64 * 1e-9));
        assert_eq!(told[1..], ["201 s", "388 s"]);
        assert_eq!(row(&run.stdout, "makespan, kernel")[1..], ["-", "-"]);
    }
}

/// The latency tolerance of the paper follows from its own rows.
#[test]
fn the_papers_tables_are_the_papers() {
    let dir = tempfile::tempdir().unwrap();
    let (_, run) = simulation(dir.path(), &["--points", "3000", "--processors", "4"]);
    let (_, table) = run.stdout.split_once("Table V:").unwrap();
    let paper = |name: &str| {
        let figures = row(table, name);
        [3, 4].map(|k| figures[k].trim_end_matches(" s").parse::<f64>().unwrap())
    };
    let [a, i, both, s, lt] = ["A, ", "I, ", "A + I ", "S, ", "LT = "].map(|start| {
        let line = table.lines().find(|line| line.trim_start().starts_with(start)).unwrap();
        let name: String = line.trim_start().chars().take(34).collect();
        paper(name.trim_end())
    });
    for k in 0..2 {
        assert!((a[k] + i[k] - both[k]).abs() < 0.011, "{a:?} {i:?} {both:?}");
        let follows = both[k] / (both[k] + s[k]);
        assert!((follows - lt[k]).abs() < 0.005, "{follows} {lt:?}");
    }
    let (_, table) = run.stdout.split_once("Table VI:").unwrap();
    for (name, figures) in [
        ("run time, kernel", ["201.30 s", "201.30 s", "388.26 s", "388.35 s"]),
        ("in vain, of the run's time", ["14.2 %", "1.9 %", "10.8 %", "2.1 %"]),
        ("polls   ", ["861388", "157744", "1330290", "289530"]),
    ] {
        assert_eq!(row(table, name)[3..], figures, "{name}");
    }
}

/// Under the paper's rule operations have no age; what none of them gets done, the engine does.
#[test]
fn the_papers_rule_refines_domains() {
    let dir = tempfile::tempdir().unwrap();
    let args = ["simulate", "--domain", "cube-in-cube", "--max-volume", "1e-3", "--mode", "async"];
    let more = ["--rule", "paper", "--processors", "4", "--start", "50"];
    let run = run(dir.path(), &[&args[..], &more].concat(), 0);
    assert!(run.stdout.contains(", rule paper, "), "{}", run.stdout);
}

/// The order of bad tetrahedra and the place of their points make other meshes, without rounds.
#[test]
fn orders_and_places_are_obeyed() {
    let dir = tempfile::tempdir().unwrap();
    let tee = ["simulate", "--domain", "tee", "--max-volume", "2e-3", "--start", "200"];
    let tee = [&tee[..], &["--mode", "async", "--processors", "3", "--json", "a.json"]].concat();
    let mut hashes = BTreeSet::new();
    for (option, name, value) in [
        (&[][..], "order", Value::from("largest")),
        (&["--order", "smallest"], "order", "smallest".into()),
        (&["--order", "oldest"], "order", "oldest".into()),
        (&["--order", "newest"], "order", "newest".into()),
        (&["--towards", "0.25"], "towards", 0.25.into()),
    ] {
        let run = ltbw(dir.path(), &[&tee[..], option].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        let report = read_json(dir.path().join("a.json"));
        assert_eq!(report["simulation"]["settings"][name], value);
        hashes.insert(report["mesh"]["hash"].to_string());
    }
    assert_eq!(hashes.len(), 5, "{hashes:?}");
}
