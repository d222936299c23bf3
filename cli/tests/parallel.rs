//! The parallel kernel on the command line: threads, meshes in parts, the simulator.

use crate::common::{ltbw, names, read_json as json};
use ltbw::io::read_mesh;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The fields that a report's figures must have.
const FIGURES: [&str; 8] = [
    "lt",
    "lt_strict",
    "setbacks",
    "operations",
    "worst_setbacks",
    "makespan",
    "messages",
    "polls",
];

fn points(dir: &Path, count: &str) {
    let run = ltbw(dir, &["generate", "uniform", count, "-o", "p.npy"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
}

/// The tetrahedra of a mesh, by the bits of their corners.
fn tets(path: &Path) -> Vec<[[u64; 3]; 4]> {
    let mesh = read_mesh(path).unwrap();
    let corner = |v: u32| mesh.points[v as usize].map(f64::to_bits);
    mesh.tets.iter().map(|tet| tet.map(corner)).collect()
}

#[test]
fn a_mesh_in_parts_is_the_mesh() {
    let dir = tempfile::tempdir().unwrap();
    points(dir.path(), "3000");
    for threads in ["1", "3"] {
        let args = ["delaunay", "p.npy", "--threads", threads, "-o", "whole.vtu", "-o", "m.pvtu"];
        let run = ltbw(dir.path(), &args);
        assert_eq!(run.code, 0, "{}", run.stderr);
        let list = std::fs::read_to_string(dir.path().join("m.pvtu")).unwrap();
        let parts: usize = threads.parse().unwrap();
        assert_eq!(list.matches("<Piece ").count(), parts, "{list}");
        let sorted = |mut tet: [[u64; 3]; 4]| {
            tet.sort_unstable();
            tet
        };
        let whole: BTreeSet<_> =
            tets(&dir.path().join("whole.vtu")).into_iter().map(sorted).collect();
        let mut owners = BTreeMap::new();
        for k in 0..parts {
            let path = dir.path().join(format!("m_{k}.vtu"));
            let part = tets(&path);
            assert!(!part.is_empty(), "part {k} of {threads}");
            for tet in part {
                assert_eq!(owners.insert(sorted(tet), k), None, "a tetrahedron in two parts");
            }
            // A part is a mesh by itself, and its tetrahedra are Delaunay's: not convex as a rule.
            let corners: BTreeSet<_> = tets(&path).into_iter().flatten().collect();
            assert_eq!(read_mesh(&path).unwrap().points.len(), corners.len(), "unused points");
        }
        assert!(owners.keys().eq(whole.iter()), "the parts are not the mesh");
    }
}

#[test]
fn parts_are_refused_where_they_cannot_be() {
    let dir = tempfile::tempdir().unwrap();
    points(dir.path(), "100");
    let run = ltbw(dir.path(), &["delaunay", "p.npy", "-o", "nowhere/m.pvtu"]);
    assert_eq!(run.code, 6, "{}", run.stderr);
    for option in ["--balance", "--tables", "--trace=t.json"] {
        let run = ltbw(dir.path(), &["delaunay", "p.npy", "--threads", "1", option]);
        assert_eq!(run.code, 2, "{}", run.stderr);
        assert!(run.error().contains("--threads 2"), "{}", run.stderr);
    }
    assert_eq!(names(dir.path()), ["p.npy"]);
}

#[test]
fn threads_tell_what_they_did() {
    let dir = tempfile::tempdir().unwrap();
    points(dir.path(), "6000");
    let alone = ltbw(dir.path(), &["delaunay", "p.npy"]);
    let args = ["delaunay", "p.npy", "--threads", "3", "--balance", "--tables"];
    let run = ltbw(dir.path(), &[&args[..], &["--json", "r.json", "--trace", "t.json"]].concat());
    assert_eq!((run.code, &run.stdout), (0, &alone.stdout), "{}", run.stderr);
    assert!(
        run.stderr.contains("Table V: time of the workers of lowest and highest LT"),
        "{}",
        run.stderr
    );
    let report = json(dir.path().join("r.json"));
    let parallel = &report["parallel"];
    for field in FIGURES {
        assert!(!parallel[field].is_null(), "{field}");
    }
    let workers = parallel["workers"].as_array().unwrap();
    assert_eq!(workers.len(), 3);
    let makespan = parallel["makespan"].as_u64().unwrap();
    let (mut inserted, mut known) = (0, 0);
    for worker in workers {
        let times = &worker["times"];
        let of = |name: &str| times[name].as_u64().unwrap();
        let all = ["meshing", "communication", "polling", "balancing", "idle"].map(of);
        assert_eq!(all.iter().sum::<u64>(), makespan, "all time is accounted for: {times}");
        known += worker["known"].as_u64().unwrap();
        let cavities = worker["cavities"].as_object().unwrap();
        inserted += cavities.values().map(|n| n.as_u64().unwrap()).sum::<u64>();
    }
    assert_eq!(parallel["operations"], inserted);
    // The others are in the coarse mesh.
    assert!(inserted + known <= 6000 && inserted > 3000, "{inserted} inserted");
    let counted: u64 = report["workers"]
        .as_array()
        .unwrap()
        .iter()
        .map(|w| w["local"].as_u64().unwrap() + w["operations"].as_u64().unwrap())
        .sum();
    assert_eq!(counted, inserted, "two counts of one thing");
    let trace = json(dir.path().join("t.json"));
    let events = trace["traceEvents"].as_array().unwrap();
    let tracks: BTreeSet<u64> = events.iter().filter_map(|e| e["tid"].as_u64()).collect();
    assert_eq!(tracks.len(), 3, "a track for each worker");
    let kinds: BTreeSet<&str> = events.iter().filter_map(|e| e["name"].as_str()).collect();
    assert!(kinds.contains("fill") && kinds.contains("poll"), "{kinds:?}");
    arrows_have_both_ends(&trace, 3);
}

/// Every message that was sent is taken once, not before, and both in a stretch of its worker's
/// time; workers and program have names.
fn arrows_have_both_ends(trace: &Value, workers: usize) {
    let events = trace["traceEvents"].as_array().unwrap();
    let of = |ph: &'static str| events.iter().filter(move |event| event["ph"] == ph);
    let thousandths = |event: &Value, field: &str| {
        let time = event[field].as_f64().unwrap();
        assert!(time >= 0.0, "{event}");
        (time * 1e3).round() as u64
    };
    let mut stretches = vec![BTreeMap::new(); workers];
    for span in of("X") {
        let (begin, length) = (thousandths(span, "ts"), thousandths(span, "dur"));
        assert!(length > 0, "{span}");
        stretches[span["tid"].as_u64().unwrap() as usize].insert(begin, begin + length);
    }
    let holds = |event: &Value| {
        let (worker, time) = (event["tid"].as_u64().unwrap() as usize, thousandths(event, "ts"));
        let stretch = stretches[worker].range(..=time).next_back();
        assert!(stretch.is_some_and(|(_, &end)| time < end), "no stretch around {event}");
        time
    };
    let mut ends = BTreeMap::new();
    for end in of("f") {
        assert_eq!(end["bp"], "e");
        assert!(ends.insert(end["id"].as_u64().unwrap(), end).is_none(), "two ends: {end}");
    }
    let mut kinds = BTreeSet::new();
    for start in of("s") {
        let end = ends.remove(&start["id"].as_u64().unwrap()).unwrap();
        assert!(holds(start) <= holds(end), "{start} {end}");
        assert!(start["tid"] != end["tid"] && start["name"] == end["name"], "{start} {end}");
        kinds.insert(start["name"].as_str().unwrap());
    }
    assert!(ends.is_empty(), "an end without a start");
    assert!(kinds.contains("expand") && kinds.contains("grant"), "requests, answers: {kinds:?}");
    let names: Vec<&str> = of("M").map(|event| event["args"]["name"].as_str().unwrap()).collect();
    assert_eq!(names[..2], ["ltbw", "worker 0"]);
    assert_eq!(names.len(), workers + 1);
}

#[test]
fn the_simulator_prints_its_tables() {
    let dir = tempfile::tempdir().unwrap();
    let args = ["simulate", "--processors", "4", "--points", "2000", "--latency", "100us"];
    let args = [&args[..], &["--seed", "3", "--trace", "t.json", "--json"]].concat();
    let run = ltbw(dir.path(), &[&args[..], &["a.json"]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    for table in ["Table III", "Table IV", "Table V", "Table VI", "Figures 5 and 7", "Cost model"] {
        assert!(run.stdout.contains(table), "{table}: {}", run.stdout);
    }
    let report = json(dir.path().join("a.json"));
    assert_eq!(
        (&report["schema"], &report["command"]),
        (&"ltbw.simulation/1".into(), &"simulate".into())
    );
    let simulation = &report["simulation"];
    for field in FIGURES.into_iter().chain(["efficiency", "workers", "cost_model"]) {
        assert!(!simulation[field].is_null(), "{field}");
    }
    assert_eq!(simulation["workers"].as_array().unwrap().len(), 4);
    assert!((0.0..=1.0).contains(&simulation["lt"].as_f64().unwrap()));
    assert_eq!(simulation["settings"]["latency"], 100_000);
    arrows_have_both_ends(&json(dir.path().join("t.json")), 4);
    // The mesh is that of the points, and one seed is one run.
    let generated = ["generate", "uniform", "2000", "--seed", "3", "-o", "p.npy"];
    assert_eq!(ltbw(dir.path(), &generated).code, 0);
    let mesh = ltbw(dir.path(), &["delaunay", "p.npy"]);
    let hash = report["mesh"]["hash"].as_str().unwrap();
    assert!(mesh.stdout.contains(hash), "{} {hash}", mesh.stdout);
    ltbw(dir.path(), &[&args[..], &["b.json"]].concat());
    assert_eq!(json(dir.path().join("b.json")), report);
}

#[test]
fn the_simulator_inserts_the_rounds_of_a_domain() {
    let dir = tempfile::tempdir().unwrap();
    let made = ltbw(dir.path(), &["generate", "cube-octahedron", "-o", "d.poly"]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    let base = ["simulate", "--domain", "d.poly", "--max-volume", "5e-4", "--json", "a.json"];
    let mut hashes = Vec::new();
    for more in [
        &["--start", "100", "--processors", "4"][..],
        &["--start", "100", "--processors", "7", "--ownership", "newest", "--latency", "100us"],
        &["--start", "100", "--processors", "3", "--latency", "1ms"],
    ] {
        let run = ltbw(dir.path(), &[&base[..], more].concat());
        // The program compares the mesh with the engine's.
        assert_eq!(run.code, 0, "{more:?}: {}", run.stderr);
        assert!(run.stdout.contains(" rounds ("), "{}", run.stdout);
        let report = json(dir.path().join("a.json"));
        let points = report["input"]["points"].as_u64().unwrap();
        let inserted = report["simulation"]["operations"].as_u64().unwrap();
        assert!(inserted > 300 && inserted < points, "{inserted} of {points}");
        assert!(report["simulation"]["rounds"].as_u64().unwrap() > 5, "{report}");
        assert!(report["simulation"]["cavities"]["interface"].as_u64().unwrap() > 0, "{report}");
        assert_eq!(report["input"]["kind"], "domain");
        hashes.push(report["mesh"]["hash"].clone());
    }
    // A kind by its name, which is the same domain.
    let kind =
        ["simulate", "--domain", "cube-octahedron", "--max-volume", "5e-4", "--start", "100"];
    let run = ltbw(dir.path(), &kind);
    assert_eq!(run.code, 0, "{}", run.stderr);
    hashes.push(run.stdout.lines().last().unwrap().trim_start_matches("ltbw.mesh/1 ").into());
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:?}");
    // The hash is the one that `mesh` prints.
    let mesh = ltbw(dir.path(), &["mesh", "d.poly", "--max-volume", "4e-5"]);
    let last = |out: &str| out.lines().last().unwrap_or_default().to_owned();
    let run = ltbw(dir.path(), &["simulate", "--domain", "d.poly", "--max-volume", "4e-5"]);
    assert_eq!(last(&run.stdout), last(&mesh.stdout), "{}", run.stderr);
    assert!(last(&run.stdout).starts_with("ltbw.mesh/1 "), "{}", run.stdout);
    // Another bound is another mesh.
    let run = ltbw(dir.path(), &[&kind[..], &["--radius-edge", "1.1"]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(!run.stdout.contains(hashes[0].as_str().unwrap()), "{}", run.stdout);
    for (wrong, code) in [
        (&["--domain", "d.poly", "--points", "50"][..], 2),
        (&["--max-volume", "1e-3"], 2),
        (&["--domain", "cube-octahedron", "--radius-edge", "0.5"], 2),
        // Nothing is left for rounds.
        (&["--domain", "d.poly", "--max-volume", "0.1"], 2),
        // Rounds move no blocks.
        (&["--domain", "d.poly", "--max-volume", "5e-4", "--storm", "1ms"], 2),
        (&["--domain", "none.poly"], 3),
    ] {
        let run = ltbw(dir.path(), &[&["simulate"], wrong].concat());
        assert_eq!(run.code, code, "{wrong:?}: {}", run.stderr);
    }
}

#[test]
fn the_simulator_refines_a_domain_without_rounds() {
    let dir = tempfile::tempdir().unwrap();
    let base = ["simulate", "--domain", "cube-in-cube", "--max-volume", "1e-3", "--start", "50"];
    let mut hashes = Vec::new();
    for more in [
        &["--processors", "4", "--json", "a.json"][..],
        &["--processors", "9", "--latency", "100us", "--ownership", "newest", "--json", "a.json"],
        &["--processors", "1", "--json", "a.json"],
        &["--processors", "4", "--blocks", "6", "--storm", "50us", "--json", "a.json"],
    ] {
        let run = ltbw(dir.path(), &[&base[..], &["--mode", "async"], more].concat());
        // The program checks the mesh against the domain.
        assert_eq!(run.code, 0, "{more:?}: {}", run.stderr);
        let all = "Left to one processor: 0 tetrahedra, 0 boundary items, and the last slivers: ";
        assert!(run.stdout.contains(all), "{}", run.stdout);
        let report = json(dir.path().join("a.json"));
        assert!(report["simulation"]["operations"].as_u64().unwrap() > 300, "{report}");
        hashes.push(report["mesh"]["hash"].clone());
    }
    assert!(hashes[0] != hashes[1] && hashes[1] != hashes[2], "{hashes:?}");
    let report = json(dir.path().join("a.json"));
    let moves = report["simulation"]["workers"].as_array().unwrap().iter();
    let moves: u64 = moves.map(|own| own["migrations"].as_u64().unwrap()).sum();
    assert!(moves > 3, "{moves} blocks have moved in the storm");
    for (wrong, code) in [
        (&["--mode", "async"][..], 2),
        (
            &[
                "--domain",
                "cube-in-cube",
                "--mode",
                "async",
                "--storm",
                "1ms",
                "--ownership",
                "newest",
            ],
            2,
        ),
        (&["--domain", "cube-in-cube", "--mode", "never"], 2),
        // Nothing is left to split.
        (&["--domain", "cube-in-cube", "--mode", "async", "--start", "4096"], 2),
        (&["--domain", "none.poly", "--mode", "async"], 3),
    ] {
        let run = ltbw(dir.path(), &[&["simulate"], wrong].concat());
        assert_eq!(run.code, code, "{wrong:?}: {}", run.stderr);
    }
}

#[test]
fn every_option_of_the_simulator_is_obeyed() {
    let dir = tempfile::tempdir().unwrap();
    let base = ["simulate", "--points", "600", "--processors", "3", "--json", "a.json"];
    let options: [(&[&str], &str, Value); 22] = [
        (&["--rule", "paper"], "rule", "paper".into()),
        (&["--distribution", "exponential"], "distribution", "exponential".into()),
        (&["--closure", "vertex"], "closure", "vertex".into()),
        (&["--ownership", "creator"], "ownership", "creator".into()),
        (&["--ownership", "newest"], "balance", false.into()),
        (&["--balance"], "balance", true.into()),
        (&["--machine", "cow"], "latency", 100_000.into()),
        (&["--machine", "cow", "--latency", "3us"], "latency", 3000.into()),
        (&["--machine", "cow"], "byte", 80.0.into()),
        (&["--poll-every", "8"], "poll_every", 8.into()),
        (&["--letters"], "letters", true.into()),
        (&["--as-processes"], "letters", true.into()),
        (&["--as-processes"], "poll_every", 8.into()),
        (&["--as-processes"], "ownership", "newest".into()),
        (&["--as-processes"], "window", 64.into()),
        (&["--as-processes"], "abreast", 0.into()),
        (&["--as-processes"], "own_curves", true.into()),
        (&["--own-curves"], "own_curves", true.into()),
        (&["--abreast", "7"], "abreast", 7.into()),
        (&["--window", "5"], "window", 5.into()),
        (&["--slow", "20"], "slow", 20.0.into()),
        (&["--storm", "300us"], "storm", 300_000.into()),
    ];
    for (option, name, value) in options {
        let run = ltbw(dir.path(), &[&base[..], option].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert_eq!(json(dir.path().join("a.json"))["simulation"]["settings"][name], value);
    }
    let run = ltbw(dir.path(), &[&base[..], &["--message", "3us"]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let costs = &json(dir.path().join("a.json"))["simulation"]["cost_model"];
    assert_eq!([&costs["send"], &costs["receive"]], [3000.0, 3000.0]);
    for wrong in [
        &["--latency", "5"][..],
        &["--ownership", "creator", "--storm", "1ms"],
        &["--ownership", "creator", "--balance"],
        &["--poll-every", "0"],
        &["--as-processes", "--letters"],
        &["--as-processes", "--own-curves"],
        &["--domain", "tee", "--own-curves"],
        &["--domain", "tee", "--order", "newest"],
        &["--domain", "tee", "--mode", "async", "--towards", "0.3"],
        &["--order", "newest"],
        &["--as-processes", "--balance"],
    ] {
        let run = ltbw(dir.path(), &[&["simulate"], wrong].concat());
        assert_eq!(run.code, 2, "{}", run.stderr);
    }
}

/// Without rounds a mesh depends on the timing, which is said; it is checked as all meshes are, and
/// its certificate tells the mode.
#[test]
fn workers_refine_a_domain_without_rounds() {
    let dir = tempfile::tempdir().unwrap();
    let run = ltbw(dir.path(), &["generate", "gear", "-o", "d.poly"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let mesh = ["mesh", "d.poly", "--max-volume", "1e-3", "--workers", "3", "--json", "r.json"];
    let outputs = ["-o", "m.vtu", "-o", "m.pvtu"];
    let run = ltbw(dir.path(), &[&mesh[..], &["--mode", "async"], &outputs].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("checked   ") && run.stderr.contains("workers   3, "));
    let note = "note: made without rounds: another run makes another mesh";
    assert!(run.stderr.contains(note), "{}", run.stderr);
    let report = json(dir.path().join("r.json"));
    assert_eq!(
        (&report["outcome"], &report["certificate"]["verdict"]),
        (&"met".into(), &"passed".into())
    );
    assert_eq!(
        report["certificate"]["binding"]["options"]["mode"], "async",
        "{}",
        report["certificate"]
    );
    assert_eq!(report["refinement"]["reproducible"], false);
    let whole = read_mesh(dir.path().join("m.vtu")).unwrap();
    let parts = (0..3).map(|k| read_mesh(dir.path().join(format!("m_{k}.vtu"))).unwrap());
    let sizes: Vec<usize> = parts.map(|part| part.tets.len()).collect();
    assert!(sizes.iter().sum::<usize>() == whole.tets.len() && !sizes.contains(&0), "{sizes:?}");
    let limits = ["--plc", "d.poly", "--max-volume", "1e-3", "--radius-edge", "2"];
    let run = ltbw(dir.path(), &[&["check", "m.vtu"][..], &limits].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let run = ltbw(dir.path(), &["check", "m.vtu", "--certificate", "r.json", "--input", "d.poly"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    // In rounds nothing is said of that, and the certificate has no mode.
    let run = ltbw(dir.path(), &mesh);
    assert!(run.code == 0 && !run.stderr.contains(note), "{}", run.stderr);
    let report = json(dir.path().join("r.json"));
    assert!(report["certificate"]["binding"]["options"].get("mode").is_none());
    assert_eq!(report["refinement"]["reproducible"], true);
    let run = ltbw(dir.path(), &["mesh", "d.poly", "--mode", "async"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    // Points at small angles are left to one processor, and that is told.
    let run = ltbw(dir.path(), &["generate", "wedge", "--angle", "5", "-o", "w.poly"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let mesh = ["mesh", "w.poly", "--max-volume", "1e-5"];
    let code = ltbw(dir.path(), &mesh).code;
    for workers in ["2", "5"] {
        let more = ["--mode", "async", "--workers", workers];
        let run = ltbw(dir.path(), &[&mesh[..], &more].concat());
        assert_eq!(run.code, code, "{}", run.stderr);
        assert!(run.stderr.contains(" left to one processor"), "{}", run.stderr);
        assert!(run.stderr.contains(note), "{}", run.stderr);
    }
}

/// A domain refined by workers that share no mesh: one hash, one set of whole files, and parts
/// that are the mesh, regions and boundary triangles included.
#[test]
fn workers_refine_a_domain_to_one_mesh() {
    let dir = tempfile::tempdir().unwrap();
    let run = ltbw(dir.path(), &["generate", "cube-in-cube", "-o", "d.poly"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let mesh = ["mesh", "d.poly", "--max-volume", "2e-4"];
    let run = ltbw(dir.path(), &[&mesh[..], &["-o", "whole.vtu"]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let (hash, whole) = (run.stdout, read_mesh(dir.path().join("whole.vtu")).unwrap());
    let bytes = std::fs::read(dir.path().join("whole.vtu")).unwrap();
    let place = |points: &[[f64; 3]], v: u32| points[v as usize].map(f64::to_bits);
    for workers in ["1", "2", "5"] {
        let more = ["--workers", workers, "-o", "again.vtu", "-o", "m.pvtu", "--json", "r.json"];
        let run = ltbw(dir.path(), &[&mesh[..], &more].concat());
        assert_eq!((run.code, &run.stdout), (0, &hash), "{}", run.stderr);
        assert!(run.stderr.contains(&format!("workers   {workers}, ")), "{}", run.stderr);
        assert!(std::fs::read(dir.path().join("again.vtu")).unwrap() == bytes, "other bytes");
        let (mut tets, mut faces) = (BTreeMap::new(), BTreeMap::new());
        let count: usize = workers.parse().unwrap();
        for k in 0..count {
            let part = read_mesh(dir.path().join(format!("m_{k}.vtu"))).unwrap();
            let regions = part.tet_tags.as_ref().unwrap();
            for (tet, region) in part.tets.iter().zip(regions) {
                let corners: BTreeSet<_> = tet.iter().map(|&v| place(&part.points, v)).collect();
                assert_eq!(tets.insert(corners, *region), None, "a tetrahedron in two parts");
            }
            for face in &part.faces {
                let corners: BTreeSet<_> =
                    face.corners.iter().map(|&v| place(&part.points, v)).collect();
                assert_eq!(faces.insert(corners, face.marker), None, "a triangle in two parts");
            }
        }
        let set =
            |v: &[u32]| -> BTreeSet<_> { v.iter().map(|&v| place(&whole.points, v)).collect() };
        let regions = whole.tet_tags.as_ref().unwrap();
        let all: BTreeMap<_, _> =
            whole.tets.iter().map(|tet| set(tet)).zip(regions.iter().copied()).collect();
        assert!(tets == all, "the parts are not the mesh");
        let all: BTreeMap<_, _> =
            whole.faces.iter().map(|face| (set(&face.corners), face.marker)).collect();
        assert!(faces == all, "the parts have other boundary triangles");
        let report = json(dir.path().join("r.json"));
        assert_eq!(report["workers"].as_array().unwrap().len(), count);
    }
    // Of a domain that has nothing but small angles one thread makes all points, and that is said;
    // the tetrahedra are the workers' all the same.
    let run = ltbw(dir.path(), &["generate", "wedge", "--angle", "5", "-o", "w.poly"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let args = ["mesh", "w.poly", "--max-volume", "1e-2", "--workers", "2", "-o", "w.pvtu"];
    let run = ltbw(dir.path(), &[&args[..], &["--mode", "async"]].concat());
    assert!(run.stderr.contains("note: one thread has refined it: "), "{}", run.stderr);
    let parts = ["w_0.vtu", "w_1.vtu"].map(|part| read_mesh(dir.path().join(part)).unwrap());
    assert!(parts.iter().all(|part| !part.tets.is_empty()));
    let args = ["mesh", "d.poly", "--max-volume", "2e-5", "--max-points", "9", "--workers", "2"];
    let run = ltbw(dir.path(), &args);
    assert!(run.code == 4 && !run.stderr.contains("one thread"), "{}", run.stderr);
    let run = ltbw(dir.path(), &["mesh", "d.poly", "--write-unrecovered", "-o", "m.pvtu"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    // The tetrahedra of the page have the colours of their workers, whatever else is written.
    assert_eq!(ltbw(dir.path(), &["generate", "gear", "-o", "g.poly"]).code, 0);
    let page = |more: &[&str]| {
        let mesh = ["mesh", "g.poly", "--max-volume", "2e-3", "--workers", "3", "--page", "p.html"];
        assert_eq!(ltbw(dir.path(), &[&mesh[..], more].concat()).code, 0);
        let text = std::fs::read_to_string(dir.path().join("p.html")).unwrap();
        let data = text.split("id=\"mesh-data\">").nth(1).unwrap();
        data.split("</script>").next().unwrap().to_owned()
    };
    assert!(page(&[]) == page(&["--keep-exterior", "-o", "e.pvtu"]), "other colours");
    let run = ltbw(dir.path(), &["mesh", "w.poly", "--workers", "2", "--trace", "t.json"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
}
