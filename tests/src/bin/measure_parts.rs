//! `measure_parts`: the program `ltbw mesh` on surfaces of the real kind, beside TetGen, as a
//! table. `cargo xtask parts` builds the program with the release profile and runs this.
//!
//! Every run is a process of its own with a limit of [`LIMIT`] of the clock on the wall. Seconds
//! are those of the processor: of the whole program on one thread (reading, refining, hashing,
//! checking) and of TetGen's call alone. The bars that no run may break ([`broken`]) decide the
//! exit code.

use ltbw::domain::{CheckOptions, Domain};
use ltbw::io;
use ltbw_tests::excuses::{Count, Meeting};
use ltbw_tests::median;
use ltbw_tests::parts::{
    Expected, count, expected, files, generated, twin_file, twins, write_triangles,
};
use ltbw_tests::require::skip;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

/// The longest time of a run.
const LIMIT: Duration = Duration::from_secs(60);
/// The most processor time: for each tetrahedron, and in addition for the whole run.
const SECONDS_EACH: f64 = 30e-6;
const SECONDS_MORE: f64 = 0.1;
/// The most tetrahedra: for each facet of the input, and in addition for the whole mesh.
const TETS_EACH: usize = 128;
const TETS_MORE: usize = 1000;
/// The bound that is asked for: circumradius to shortest edge.
const RATIO: f64 = 2.0;

type Failure = Box<dyn std::error::Error>;

const USAGE: &str = "\
usage: measure_parts PROGRAM WORK [DIR | --generated] [--twins] [--only TEXT]

PROGRAM is ltbw, WORK a folder for files that are made. Without a folder DIR the set by formula is
measured. --only keeps the parts with TEXT in their names.";

/// The programs and parts to measure.
struct Plan {
    program: PathBuf,
    work: PathBuf,
    folder: Option<PathBuf>,
    twins: bool,
    only: String,
    /// A Python that has TetGen.
    python: Option<String>,
}

/// The result of a program for a part.
#[derive(Debug, Clone, Default)]
struct Ran {
    /// None if it ran into the limit or was killed.
    code: Option<i32>,
    outcome: String,
    tets: Option<usize>,
    seconds: f64,
    certified: bool,
    /// Its own message, in one line.
    message: String,
    /// The angles of the domain, and what is left over the bound; or why that is not known.
    count: Option<Result<Count, String>>,
}

/// A line of the table.
struct Row {
    name: String,
    facets: usize,
    ours: Ran,
    theirs: Option<Ran>,
    broken: Vec<&'static str>,
}

fn main() -> ExitCode {
    match plan().and_then(|plan| measure(&plan)) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(failure) => {
            eprintln!("measure_parts: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn plan() -> Result<Plan, Failure> {
    let mut args = std::env::args().skip(1);
    let (Some(program), Some(work)) = (args.next(), args.next()) else {
        return Err(USAGE.into());
    };
    let mut plan = Plan {
        program: program.into(),
        work: work.into(),
        folder: None,
        twins: false,
        only: String::new(),
        python: python(),
    };
    while let Some(word) = args.next() {
        match word.as_str() {
            "--generated" => plan.folder = None,
            "--twins" => plan.twins = true,
            "--only" => plan.only = args.next().ok_or(USAGE)?,
            other if !other.starts_with('-') && plan.folder.is_none() => {
                plan.folder = Some(other.into());
            }
            _ => return Err(USAGE.into()),
        }
    }
    std::fs::create_dir_all(&plan.work)?;
    plan.work = plan.work.canonicalize()?;
    Ok(plan)
}

/// A Python that has TetGen, if there is one.
fn python() -> Option<String> {
    let python = std::env::var("LTBW_TETGEN_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let mut probe = Command::new(&python);
    probe.args(["-c", "import tetgen"]).stdout(Stdio::null()).stderr(Stdio::null());
    probe.status().is_ok_and(|status| status.success()).then_some(python)
}

/// TetGen's run of a part, as far as it is told.
fn theirs(known: &Expected) -> Ran {
    let tets = known.tets.parse().ok();
    let outcome = if tets.is_none() { known.tets.clone() } else { String::new() };
    let seconds = known.seconds.parse().unwrap_or_default();
    Ran { tets, outcome, seconds, ..Ran::default() }
}

/// The parts: names and files.
fn parts(plan: &Plan) -> Result<Vec<(String, PathBuf)>, Failure> {
    let mut all = Vec::new();
    if let Some(folder) = &plan.folder {
        all = files(folder)?;
    } else {
        for (name, domain) in generated()?.iter().filter(|(name, _)| name.contains(&plan.only)) {
            let path = plan.work.join(name);
            io::write_domain(&path, domain)?;
            all.push(path);
        }
    }
    let mut parts = Vec::new();
    for path in all {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if !name.contains(&plan.only) {
            continue;
        }
        parts.push((name, path.clone()));
        let file = if plan.twins { io::read_domain(&path).ok() } else { None };
        let Some(file) = file else { continue };
        for (twin, domain) in twins(&file.domain) {
            let name = twin_file(&path, twin, &domain, file.oriented);
            let path = plan.work.join(&name);
            io::write_domain(&path, &domain)?;
            parts.push((name, path));
        }
    }
    Ok(parts)
}

/// Measures all parts; true if no bar is broken.
fn measure(plan: &Plan) -> Result<bool, Failure> {
    if plan.python.is_none() {
        skip("parts beside TetGen", "tetgen", "Python has no package `tetgen`")?;
    }
    let expected = expected(plan.folder.as_deref());
    println!(
        "| part | exit | outcome | tets | TetGen, tets | ratio | s | TetGen, s | us/tet | \
         certified | angles | % over |\n\
         |---|--:|---|--:|--:|--:|--:|--:|--:|---|---|--:|"
    );
    let mut rows = Vec::new();
    for (name, path) in parts(plan)? {
        let row = part(plan, &name, &path, &expected)?;
        println!("{}", line(&row));
        rows.push(row);
    }
    medians(&rows);
    unexpected(&rows, &expected);
    let broken: Vec<&Row> = rows.iter().filter(|row| !row.broken.is_empty()).collect();
    for row in &broken {
        println!("broken: {}: {}: {}", row.name, row.broken.join(", "), row.ours.message);
    }
    println!(
        "{} parts, {} of them break a bar; processor time of one thread: ours of the whole \
         program, TetGen's of its call",
        rows.len(),
        broken.len()
    );
    Ok(broken.is_empty() && !rows.is_empty())
}

fn part(
    plan: &Plan,
    name: &str,
    path: &Path,
    expected: &BTreeMap<String, Expected>,
) -> Result<Row, Failure> {
    let ours = ours(plan, path)?;
    let file = io::read_domain(path).ok();
    let known = expected.get(name).map(theirs);
    let theirs = match (&plan.python, &file) {
        // Parts that TetGen does not mesh, or crashes on, need not be waited for.
        (_, _) if known.as_ref().is_some_and(|known| known.tets.is_none()) => known,
        (Some(python), Some(file)) => {
            let ran = tetgen(plan, python, &file.domain)?;
            // From a file of its own it reads some surfaces that it refuses as triangles.
            if ran.tets.is_none() && known.is_some() { known } else { Some(ran) }
        }
        _ => known,
    };
    let facets = file.as_ref().map_or(0, |f| f.domain.facets.len());
    let bounded = file.is_some_and(|file| {
        let options = CheckOptions { oriented: file.oriented, ..CheckOptions::default() };
        let report = file.domain.check(&options);
        report.is_ok_and(|report| report.cells.is_some_and(|cells| !cells.is_empty()))
    });
    let broken = broken(&ours, facets, bounded);
    Ok(Row { name: name.to_owned(), facets, ours, theirs, broken })
}

/// The bars that no run may break and this one does. `bounded`: the check of the domain finds a
/// bounded cell.
fn broken(ran: &Ran, facets: usize, bounded: bool) -> Vec<&'static str> {
    let tets = ran.tets.unwrap_or(0);
    let each = SECONDS_EACH * tets as f64 + SECONDS_MORE;
    [
        (ran.code == Some(5), "a defect in our own output"),
        (ran.message.contains("no region") && bounded, "no region where there is a bounded cell"),
        (ran.code.is_none(), "no end within 60 s, or killed"),
        (ran.tets.is_some() && ran.seconds > each, "more than 30 us per tetrahedron + 0.1 s"),
        (tets > TETS_EACH * facets + TETS_MORE, "more than 128 x the facets + 1000 tetrahedra"),
        (counted(ran, Count::is_broken), "more over the bound than angles excuse"),
        (matches!(ran.count, Some(Err(_))), "a mesh that is not judged"),
    ]
    .into_iter()
    .filter_map(|(is_broken, text)| is_broken.then_some(text))
    .collect()
}

/// Is it so of what was counted?
fn counted(ran: &Ran, is_so: impl Fn(&Count) -> bool) -> bool {
    matches!(&ran.count, Some(Ok(count)) if is_so(count))
}

/// Runs a command within the limit: its exit code, processor seconds, and what it wrote to stderr.
fn run(plan: &Plan, command: &mut Command) -> Result<(Option<i32>, f64, String), Failure> {
    let log = plan.work.join("stderr.txt");
    command.stderr(std::fs::File::create(&log)?).stdin(Stdio::null());
    let before = children_seconds();
    let start = Instant::now();
    let mut child = command.spawn()?;
    // Ends at the limit.
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break Some(status);
        }
        if start.elapsed() > LIMIT {
            child.kill()?;
            child.wait()?;
            break None;
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let wall = start.elapsed().as_secs_f64();
    let seconds = before.and_then(|b| Some(children_seconds()? - b)).unwrap_or(wall);
    let text = std::fs::read(&log).map(|bytes| String::from_utf8_lossy(&bytes).into_owned())?;
    Ok((status.and_then(|s| s.code()), seconds, text))
}

/// Processor seconds of all children that ended, where the system tells.
fn children_seconds() -> Option<f64> {
    /// Linux counts in hundredths of a second here, whatever its clock.
    const TICKS: f64 = 100.0;
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The second field is a name in parentheses, which may have blanks in it.
    let (_, rest) = stat.rsplit_once(')')?;
    let words: Vec<&str> = rest.split_whitespace().collect();
    let ticks = |i: usize| words.get(i)?.parse::<f64>().ok();
    Some((ticks(13)? + ticks(14)?) / TICKS)
}

/// Our program on a part.
fn ours(plan: &Plan, path: &Path) -> Result<Ran, Failure> {
    let [json, mesh] = ["report.json", "mesh.vtu"].map(|name| plan.work.join(name));
    // The output of an earlier run would be taken for this one's.
    for file in [&json, &mesh].into_iter().filter(|file| file.exists()) {
        std::fs::remove_file(file)?;
    }
    let mut command = Command::new(&plan.program);
    command.arg("mesh").arg(path).args(["--radius-edge", &RATIO.to_string(), "--threads", "1"]);
    command.arg("-o").arg(&mesh).arg("--json").arg(&json);
    let (code, seconds, text) = run(plan, command.stdout(Stdio::null()))?;
    let message = text.lines().rev().find_map(|line| line.strip_prefix("ltbw: "));
    let message = message.unwrap_or_default().to_owned();
    let report: Option<Value> =
        std::fs::read(&json).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    let mut ran = Ran { code, seconds, message, ..Ran::default() };
    let report = report.filter(|r| r["outcome"].is_string());
    ran.outcome = match (&report, code) {
        (Some(report), _) => told(report),
        (None, None) => "no end".to_owned(),
        (None, _) => refusal(&ran.message),
    };
    if let Some(report) = report.filter(|r| r["refinement"].is_object()) {
        ran.tets = report["mesh"]["tets"].as_u64().map(|n| n as usize);
        // A mesh is certified if nothing is wrong with it but for tetrahedra that are excused.
        let complete = ["met", "excused"].iter().any(|o| report["outcome"] == *o);
        ran.certified = complete && report["certificate"].is_object() && code != Some(5);
        let tolerance = report["refinement"]["flat_tolerance"].as_f64().unwrap_or(0.0);
        let written = Some(&*mesh).filter(|mesh| mesh.exists());
        if code != Some(5) {
            ran.count = Some(count(path, written, tolerance, RATIO));
        }
    }
    Ok(ran)
}

/// The outcome that a report tells.
fn told(report: &Value) -> String {
    let outcome = report["outcome"].as_str().unwrap_or_default();
    let refinement = &report["refinement"];
    let count = |name: &str| refinement[name].as_u64().filter(|&n| n > 0);
    let mut text = outcome.to_owned();
    if let Some(n) = count("excused") {
        text += &format!(" {n}");
    }
    if let Some(n) = count("boundary_lost") {
        text += &format!(", {n} missing");
    }
    text
}

/// A refusal in a few words: without the file's name and coordinates.
fn refusal(message: &str) -> String {
    // The meaning of the defects stands at the end: `; of 3 bodies: open: 4 places in 1 body;
    // doubled ...`.
    if let Some((_, kinds)) = message.split_once(" bodies: ") {
        let kinds = kinds.split("; ").filter_map(|kind| kind.split_once(": "));
        let kinds: Vec<&str> = kinds.map(|(name, _)| name).collect();
        return format!("refused: {}", kinds.join(", "));
    }
    let (_, reason) = message.split_once(": ").unwrap_or(("", message));
    let reason = reason.split("; the first").next().unwrap_or_default();
    let short: String = reason.chars().take(70).collect();
    format!("refused: {}", short.replace('|', "/"))
}

/// TetGen on the triangles of a domain.
fn tetgen(plan: &Plan, python: &str, domain: &Domain) -> Result<Ran, Failure> {
    let input = plan.work.join("tetgen.poly");
    let output = plan.work.join("tetgen.txt");
    write_triangles(&input, domain)?;
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tetgen/parts.py");
    let mut command = Command::new(python);
    // Of a surface that crosses itself TetGen leaves files where it runs.
    command.current_dir(&plan.work);
    command.arg(script).arg(&input).stdout(std::fs::File::create(&output)?);
    let (code, _, text) = run(plan, &mut command)?;
    let told = std::fs::read_to_string(&output)?;
    let numbers = told.lines().rev().find_map(|line| line.strip_prefix("result "));
    let numbers: Option<(usize, f64)> = numbers.and_then(|line| {
        let (tets, seconds) = line.split_once(' ')?;
        Some((tets.parse().ok()?, seconds.parse().ok()?))
    });
    let outcome = match (code, numbers) {
        (Some(0), Some(_)) => String::new(),
        (Some(_), _) => "refused".to_owned(),
        (None, _) => "crash or no end".to_owned(),
    };
    let message = text.lines().last().unwrap_or_default().to_owned();
    let (tets, seconds) = numbers.map_or((None, 0.0), |(t, s)| (Some(t), s));
    Ok(Ran { code, outcome, tets, seconds, message, ..Ran::default() })
}

fn ratio(row: &Row) -> Option<f64> {
    let theirs = row.theirs.as_ref()?.tets.filter(|&tets| tets > 0)?;
    Some(row.ours.tets? as f64 / theirs as f64)
}

fn each(row: &Row) -> Option<f64> {
    let tets = row.ours.tets.filter(|&tets| tets > 0)?;
    Some(row.ours.seconds * 1e6 / tets as f64)
}

/// A row of the table.
fn line(row: &Row) -> String {
    let dash = || "-".to_owned();
    let number = |n: Option<f64>, digits: usize| n.map_or_else(dash, |n| format!("{n:.digits$}"));
    let tets = |ran: &Ran| ran.tets.map_or_else(|| ran.outcome.clone(), |n| n.to_string());
    let theirs = row.theirs.as_ref();
    let count = row.ours.count.as_ref().and_then(|count| count.as_ref().ok());
    format!(
        "| {} | {} | {} | {} | {} | {} | {:.2} | {} | {} | {} | {} | {} |{}",
        row.name,
        row.ours.code.map_or_else(dash, |code| code.to_string()),
        row.ours.outcome,
        row.ours.tets.map_or_else(dash, |n| n.to_string()),
        theirs.map_or_else(dash, tets),
        number(ratio(row), 2),
        row.ours.seconds,
        number(theirs.filter(|t| t.tets.is_some()).map(|t| t.seconds), 2),
        number(each(row), 1),
        if row.ours.certified { "yes" } else { "no" },
        count.map_or_else(dash, |count| count.features.meeting().name().to_owned()),
        number(count.map(|count| 100.0 * count.share), 3),
        if row.broken.is_empty() { "" } else { " BROKEN" },
    )
}

fn medians(rows: &[Row]) {
    let show = |name: &str, value: &dyn Fn(&Row) -> Option<f64>| {
        let mut values: Vec<f64> = rows.iter().filter_map(value).collect();
        if values.is_empty() {
            return;
        }
        let middle = median(&mut values);
        let most = values.last().copied().unwrap_or_default();
        println!("{name}: median {middle:.2}, largest {most:.2}, of {}", values.len());
    };
    println!();
    show("tetrahedra, ratio to TetGen's", &ratio);
    show("seconds, ratio to TetGen's", &|row| {
        let theirs = row.theirs.as_ref()?;
        // Below the resolution of the clock a quotient means nothing.
        (row.ours.tets.is_some() && theirs.seconds >= 0.05)
            .then(|| row.ours.seconds / theirs.seconds)
    });
    show("microseconds for a tetrahedron", &each);
    show("tetrahedra for a facet", &|row| Some(row.ours.tets? as f64 / row.facets.max(1) as f64));
    let with = |exit: i32| rows.iter().filter(|row| row.ours.code == Some(exit)).count();
    println!("exit codes: 0: {}, 1: {}, 3: {}, 5: {}", with(0), with(1), with(3), with(5));
    let certified = rows.iter().filter(|row| row.ours.certified).count();
    println!("certified: {certified} of {}", rows.len());
    for meeting in [Meeting::Wide, Meeting::Needles, Meeting::Sharp] {
        let counts = rows.iter().filter_map(|row| row.ours.count.as_ref()?.as_ref().ok());
        let own = counts.filter(|count| count.features.meeting() == meeting);
        let shares: Vec<f64> = own.map(|count| 100.0 * count.share).collect();
        let most = shares.iter().copied().fold(0.0, f64::max);
        println!("{} angles: {} parts, at most {most:.3} % over", meeting.name(), shares.len());
    }
}

/// Tells where a part is not what `expected.tsv` says.
fn unexpected(rows: &[Row], expected: &BTreeMap<String, Expected>) {
    for row in rows {
        let Some(wanted) = expected.get(&row.name) else { continue };
        let meshed = matches!(row.ours.code, Some(0 | 1)) && row.ours.certified;
        let refused = row.ours.code == Some(3);
        let good = if wanted.ours.starts_with("mesh") { meshed } else { refused };
        if !good {
            println!("unexpected: {}: `{}` wanted: {}", row.name, wanted.ours, row.ours.message);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Count, Ran, broken, refusal};
    use ltbw_tests::excuses::Features;

    fn ran(code: Option<i32>, tets: usize, seconds: f64, message: &str) -> Ran {
        let (message, tets) = (message.to_owned(), Some(tets));
        Ran { code, tets, seconds, message, ..Ran::default() }
    }

    #[test]
    fn each_bar_breaks_alone() {
        assert_eq!(broken(&ran(Some(0), 2000, 0.159, ""), 8, true), Vec::<&str>::new());
        assert_eq!(broken(&ran(Some(5), 2000, 0.1, ""), 8, true).len(), 1);
        assert_eq!(broken(&ran(None, 2000, 0.1, ""), 8, true).len(), 1);
        assert_eq!(broken(&ran(Some(0), 2000, 0.17, ""), 8, true).len(), 1);
        assert_eq!(broken(&ran(Some(0), 2025, 0.1, ""), 8, true).len(), 1);
        let text = "a.stl: the facets enclose no region: all is hole";
        assert_eq!(broken(&ran(Some(3), 0, 0.0, text), 8, true).len(), 1);
        assert_eq!(broken(&ran(Some(3), 0, 0.0, text), 8, false), Vec::<&str>::new());
        let count = |facets: f64, share: f64| {
            let right =
                Features { segments: 90.0, segment_facet: 90.0, facets, plane: 90.0, needles: 0 };
            let count = Count { features: right, tets: 2000, over: 9, share };
            let ran = Ran { count: Some(Ok(count)), ..ran(Some(1), 2000, 0.1, "") };
            broken(&ran, 8, true).len()
        };
        assert_eq!([count(90.0, 1e-3), count(90.0, 2e-3), count(19.0, 2e-3)], [0, 1, 0]);
        let none = Ran { count: Some(Err("a defect".to_owned())), ..ran(Some(1), 2000, 0.1, "") };
        assert_eq!(broken(&none, 8, true), ["a mesh that is not judged"]);
    }

    #[test]
    fn a_refusal_is_short() {
        let text = "a|b.stl: defects: 3 domain.leak; the first: domain.leak: at (1 2 3)";
        assert_eq!(refusal(text), "refused: defects: 3 domain.leak");
        let kinds = "; of 3 bodies: open: 4 places in 1 body, the first at (1 2 3); \
                     bodies that touch: 1 place in 2 bodies";
        assert_eq!(refusal(&format!("{text}{kinds}")), "refused: open, bodies that touch");
    }
}
