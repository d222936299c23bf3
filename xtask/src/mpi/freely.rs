//! Jobs that refine without rounds: certified, with about as many tetrahedra as rounds have, and
//! told to be another mesh each time.

use super::faults::expect;
use super::{Bench, WATCHDOG, watched, words_of};
use std::fs;

/// A job without rounds.
struct Freely {
    kind: &'static str,
    volume: &'static str,
    /// The bound on dihedral angles, in degrees.
    degrees: &'static str,
    processes: u32,
    is_tcp: bool,
    /// The delay of mails, in microseconds.
    late: Option<&'static str>,
    /// Options beside these.
    more: &'static [&'static str],
}

const fn job(kind: &'static str, volume: &'static str, processes: u32) -> Freely {
    Freely { kind, volume, degrees: "0", processes, is_tcp: false, late: None, more: &[] }
}

const JOBS: [Freely; 4] = [
    job("cube-octahedron", "2e-5", 2),
    Freely { is_tcp: true, late: Some("300"), ..job("cube-octahedron", "2e-5", 4) },
    Freely { degrees: "8", late: Some("300"), ..job("cube-in-cube", "2e-5", 3) },
    Freely { more: &["--keep-exterior"], ..job("tee", "1e-4", 4) },
];

/// Runs them all; returns their number.
pub(super) fn run(bench: &Bench) -> Result<usize, String> {
    let report = |name: &str| {
        let text =
            fs::read_to_string(bench.folder.join(name)).map_err(|error| error.to_string())?;
        let tets = text.lines().find_map(|line| line.trim().strip_prefix("\"tets\": "));
        let tets = tets.and_then(|text| text.trim_end_matches(',').parse::<f64>().ok());
        Ok::<_, String>((tets.ok_or_else(|| format!("{name}: no tetrahedra"))?, text))
    };
    let mut runs = 0;
    for Freely { kind, volume, degrees, processes, is_tcp, late, more } in JOBS {
        if is_tcp && !bench.mpi.has_tcp() {
            continue;
        }
        let file = format!("{kind}.poly");
        let mesh = ["mesh", &file, "--max-volume", volume, "--min-dihedral", degrees];
        let mesh = words_of(&[&mesh[..], more].concat());
        let alone = bench.ltbw(&[&mesh[..], &words_of(&["--json", "alone.json"])].concat())?;
        expect(kind, &alone, 0, "")?;
        _ = fs::remove_file(bench.folder.join("freely.json"));
        let mut job = bench.job(processes, is_tcp);
        late.iter().for_each(|late| _ = job.env("LTBW_MPI_LATENCY_US", late));
        job.arg(&bench.ranked).args(&mesh).args(["--mode", "async", "-o", "freely.pvtu"]);
        let outcome = watched(job.args(["--json", "freely.json"]), WATCHDOG)?;
        let what = format!("{kind} without rounds on {processes}");
        expect(&what, &outcome, 0, "made without rounds")?;
        let ((expected, _), (tets, text)) = (report("alone.json")?, report("freely.json")?);
        let ratio = tets / expected;
        if (ratio - 1.0).abs() > 0.03 {
            return Err(format!("{what}: {ratio} times the tetrahedra of rounds"));
        }
        for word in ["\"reproducible\": false", "\"verdict\": \"passed\""] {
            if !text.contains(word) {
                return Err(format!("{what}: no {word} in the report"));
            }
        }
        runs += 1;
        let is_kept = text.contains("\"late\": null");
        println!(
            "{what}: {ratio:.3} times the tetrahedra, {}",
            match is_kept {
                true => "in parts",
                false => "put together",
            }
        );
    }
    Ok(runs)
}
