//! `mpi`: the program of `parallel/mpi`: its tests, and its runs by each MPI that is here, beside
//! `ltbw`, each under a watchdog: one hash on any number of processes, over shared memory and over
//! TCP, in time and late; what it refuses; what comes of processes that panic, are killed or are
//! stopped; jobs that go on from the checkpoint of one that has lost a process.

mod asked;
mod beside;
mod draw;
mod faults;
mod freely;
pub(crate) mod library;
mod memory;
mod readers;
mod resumed;
mod seeds;
mod storm;
mod torus;
mod validate;

use crate::require;
use crate::shell::{self, target};
use asked::Asked;
use library::{Found, LIBRARIES};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The longest time of a run.
const WATCHDOG: Duration = Duration::from_secs(120);

/// The numbers of processes, if no others are asked for.
const RANKS: [u32; 4] = [1, 2, 3, 4];

/// A number of processes far above that of cores, and the inputs that are run on these, too.
const MANY: u32 = 16;
const ON_MANY: [&str; 4] = ["uniform 20000", "duplicates 8000", "cube-octahedron", "tee"];

/// The delay of late mails, in microseconds.
const LATE: &str = "300";

/// Families of points: kind, number, and format: one that is not cut among them.
const POINTS: [(&str, &str, &str); 7] = [
    ("uniform", "20000", "npy"),
    ("clusters", "20000", "csv"),
    ("grid", "8000", "xyz"),
    ("sphere", "5000", "npy"),
    ("duplicates", "8000", "node"),
    ("clusters", "3000", "ply"),
    ("uniform", "40", "npy"),
];

/// A domain: kind, what else makes it, bounds.
type Kind = (&'static str, &'static [&'static str], &'static [&'static str]);

/// A domain of two regions, for readers.
const REGIONS: Kind = ("two-material", &[], &["--max-volume", "5e-5"]);

const DOMAINS: [Kind; 5] = [
    ("cube-octahedron", &[], &["--max-volume", "5e-5"]),
    ("tee", &[], &["--max-volume", "1.5e-4"]),
    ("gear", &[], &["--max-volume", "4e-5", "--keep-exterior"]),
    ("cube-in-cube", &[], &["--max-volume", "5e-5"]),
    (ALONE, &["--angle", "5"], &[]),
];

/// A domain that one process refines alone.
const ALONE: &str = "wedge";

/// A surface with patches, which takes as many vertices as rounds begin with there: it is run on
/// the most processes alone, and stays in parts.
const PATCHED: &str = "torus";
const PATCHED_BOUNDS: [&str; 4] = ["--max-volume", "2.5e-6", "--flat-tolerance", "1e-6"];

/// The files of a mesh in parts.
const IN_PARTS: [&str; 4] = ["parts.pvtu", "parts_%.msh", "parts.mfem", "parts.vtkhdf"];

/// Files of a mesh in parts that have a number for the exterior.
const WITH_EXTERIOR: [&str; 2] = ["parts.pvtu", "parts.vtkhdf"];

/// Files of a mesh in parts that `ltbw` reads.
const READ: [&str; 2] = ["parts.pvtu", "parts_%.msh"];

/// The files that `ltbw` writes of a whole domain, and processes that keep their parts.
const WHOLE: [[&str; 2]; 3] =
    [["alone.vtu", "whole.vtu"], ["alone.msh", "whole.msh"], ["alone.svg", "whole.svg"]];

/// The options for the files of a domain that are made of the whole mesh.
fn whole_of(input: &Input, way: usize) -> Vec<String> {
    match input.is_domain() {
        true => {
            let [vtu, msh, svg] = WHOLE.map(|names| names[way]);
            words_of(&["-o", vtu, "-o", msh, "--histogram", svg])
        }
        false => Vec::new(),
    }
}

/// The outcome of a run.
pub(crate) struct Outcome {
    /// The exit code; none if a signal or the watchdog has ended it.
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
    pub(crate) seconds: f64,
}

/// The programs, and a folder for what they read and write.
pub(crate) struct Bench {
    pub(crate) ranked: PathBuf,
    alone: PathBuf,
    pub(crate) folder: PathBuf,
    mpi: Found,
}

/// An input with the arguments that mesh it.
pub(crate) struct Input {
    name: String,
    arguments: Vec<String>,
}

impl Input {
    fn is_domain(&self) -> bool {
        self.arguments.first().is_some_and(|command| command == "mesh")
    }

    fn has_exterior(&self) -> bool {
        self.arguments.iter().any(|word| word == "--keep-exterior")
    }
}

/// Jobs with faults beside the others.
const FEW_FAULTS: u64 = 12;

/// Builds and runs, for each MPI.
pub(crate) fn run(rest: &[String]) -> Result<(), String> {
    let asked = Asked::of(rest)?;
    let mut runs_all = true;
    for library in LIBRARIES.iter().filter(|own| asked.libraries.contains(&own.name)) {
        let mpi = match library.find() {
            Ok(mpi) => mpi,
            Err(why) => {
                let what = format!("the program of parallel/mpi by {}", library.name);
                require::skip(&what, "mpi", &why)?;
                continue;
            }
        };
        println!("== {}", library.name);
        run_by(mpi, &asked, runs_all)?;
        runs_all = false;
    }
    Ok(())
}

/// Builds and runs, for one MPI; the first one runs all, others the fewest and the most processes.
fn run_by(mpi: Found, asked: &Asked, runs_all: bool) -> Result<(), String> {
    let bench = Bench::build(mpi, runs_all)?;
    if asked.validates {
        return validate::run(&bench);
    }
    if asked.has_speed {
        return beside::run(&bench);
    }
    if let Some(count) = asked.seeds {
        return seeds::run(&bench, count, asked.ranks.as_deref(), asked.seed);
    }
    let mut inputs = bench.inputs()?;
    if asked.has_readers {
        inputs.push(bench.domain(REGIONS)?);
    }
    if let Some(count) = asked.faults {
        return storm::run(&bench, count, asked.seed);
    }
    let mut ranks = asked.ranks.clone().unwrap_or_else(|| RANKS.to_vec());
    let most = ranks.iter().copied().max().unwrap_or(2);
    ranks.retain(|&count| runs_all || count == 2 || count == most);
    let mut runs = 0;
    for input in &inputs {
        let alone = bench.alone(input, &whole_of(input, 0))?;
        let mut ways: Vec<Way> =
            ranks.iter().map(|&count| Way { count, ..Way::default() }).collect();
        let mut late =
            |count, is_tcp| ways.push(Way { count, is_tcp, late: Some(LATE), ..Way::default() });
        late(2, false);
        late(most, true);
        ways.push(Way { count: most, is_tcp: true, ..Way::default() });
        if input.is_domain() {
            ways.push(Way { count: most, has_moves: true, ..Way::default() });
        }
        if most < MANY && ON_MANY.contains(&&*input.name) {
            ways.push(Way { count: MANY, ..Way::default() });
            ways.push(Way { count: MANY, is_tcp: true, late: Some(LATE), ..Way::default() });
        }
        let is_large = input.name == PATCHED;
        ways.retain(|way| !is_large || way.count == most && !(way.is_tcp && way.late.is_none()));
        ways.retain(|way| !way.is_tcp || bench.mpi.has_tcp());
        for way in &ways {
            bench.compare(input, &alone, *way)?;
        }
        bench.in_parts(input, &alone, most)?;
        runs += ways.len() + 1;
        let is_sound = input.is_domain() && alone.code == Some(0) && !input.has_exterior();
        if !asked.has_readers {
            continue;
        }
        if is_sound && bench.mpi.library.name == "Open MPI" {
            readers::by_dolfinx(&bench, &input.name)?;
        }
        if is_sound || !input.is_domain() {
            readers::run(&bench, &input.name, &input.arguments, most)?;
        }
    }
    println!("{} inputs, {runs} runs: one hash each", inputs.len());
    println!("{} jobs without rounds", freely::run(&bench)?);
    let count = faults::run(&bench)? + resumed::run(&bench)?;
    println!("{count} refusals and faults: each with its word and its code");
    if runs_all && bench.mpi.library.name == "Open MPI" {
        memory::run(&bench)?;
    }
    storm::run(&bench, FEW_FAULTS, asked.seed)
}

/// The way in which an input is run on processes.
#[derive(Clone, Copy, Debug, Default)]
struct Way {
    count: u32,
    /// Mail goes over TCP, not through shared memory.
    is_tcp: bool,
    /// The delay of mails, in microseconds.
    late: Option<&'static str>,
    /// Cuts between parts move every other round.
    has_moves: bool,
}

impl std::fmt::Display for Way {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { count, is_tcp, late, has_moves } = self;
        let tcp = if *is_tcp { " by TCP" } else { "" };
        let late = late.map(|late| format!(", {late} us late")).unwrap_or_default();
        let moves = if *has_moves { ", cuts move" } else { "" };
        write!(f, "on {count}{tcp}{late}{moves}")
    }
}

impl Bench {
    /// The programs for an MPI.
    fn build(mpi: Found, runs_tests: bool) -> Result<Self, String> {
        let folder = target().join("mpi");
        fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        Ok(Self { ranked: mpi.build(runs_tests)?, alone: shell::program()?, folder, mpi })
    }

    /// A command of `ltbw`.
    pub(crate) fn ltbw(&self, arguments: &[String]) -> Result<Outcome, String> {
        let mut command = Command::new(&self.alone);
        watched(command.current_dir(&self.folder).arg("--quiet").args(arguments), WATCHDOG)
    }

    /// Makes the file of an input.
    fn generate(&self, arguments: &[&str]) -> Result<(), String> {
        let made = self.ltbw(&words_of(&[&["generate"], arguments].concat()))?;
        match made.code {
            Some(0) => Ok(()),
            _ => Err(format!("generate {arguments:?}: {}", made.stderr)),
        }
    }

    /// Makes all inputs.
    fn inputs(&self) -> Result<Vec<Input>, String> {
        let mut inputs = Vec::new();
        for (kind, count, format) in POINTS {
            let file = format!("{kind}-{count}.{format}");
            self.generate(&[kind, count, "-o", &file])?;
            let arguments = words_of(&["delaunay", &file]);
            inputs.push(Input { name: format!("{kind} {count}"), arguments });
        }
        for kind in DOMAINS {
            inputs.push(self.domain(kind)?);
        }
        let file = format!("{PATCHED}.obj");
        let written = fs::write(self.folder.join(&file), torus::torus(10));
        written.map_err(|error| format!("{file}: {error}"))?;
        let arguments = words_of(&[&["mesh", &file], &PATCHED_BOUNDS[..]].concat());
        inputs.push(Input { name: PATCHED.to_owned(), arguments });
        Ok(inputs)
    }

    /// Makes the file of a domain.
    fn domain(&self, kind: Kind) -> Result<Input, String> {
        let (kind, shape, bounds) = kind;
        let file = format!("{kind}.poly");
        self.generate(&[&[kind], shape, &["-o", &file]].concat())?;
        let arguments = words_of(&[&["mesh", &file], bounds].concat());
        Ok(Input { name: kind.to_owned(), arguments })
    }

    /// The outcome of `ltbw` with an input, and more arguments.
    fn alone(&self, input: &Input, more: &[String]) -> Result<Outcome, String> {
        let report = words_of(&["--json", "alone.json"]);
        _ = fs::remove_file(self.folder.join("alone.json"));
        self.ltbw(&[&input.arguments[..], &report, more].concat())
    }

    /// Runs an input on processes, and compares code, hash and excuses.
    fn compare(&self, input: &Input, alone: &Outcome, way: Way) -> Result<(), String> {
        let report = words_of(&["--json", "ranks.json"]);
        let arguments = [input.arguments.clone(), report].concat();
        let mut job = self.job(way.count, way.is_tcp);
        job.arg(&self.ranked).arg("--quiet").args(&arguments);
        if way.has_moves {
            job.args(["--redeal", "2"]);
        }
        way.late.iter().for_each(|late| _ = job.env("LTBW_MPI_LATENCY_US", late));
        _ = fs::remove_file(self.folder.join("ranks.json"));
        let outcome = watched(&mut job, WATCHDOG)?;
        let what = format!("{} {way}", input.name);
        let excuses = |file: &str| excused(&self.folder.join(file));
        let same = outcome.code == alone.code && outcome.stdout == alone.stdout;
        let (own, expected) = (excuses("ranks.json"), excuses("alone.json"));
        // Where a hash is printed there is a report.
        let is_told = alone.stdout.is_empty() || !expected.is_empty();
        if !same || own != expected || !is_told {
            return Err(format!(
                "{what}: code {:?}, {:?}, not {:?}, {:?}\n{}",
                outcome.code, outcome.stdout, alone.code, alone.stdout, outcome.stderr
            ));
        }
        let told = fs::read_to_string(self.folder.join("ranks.json")).unwrap_or_default();
        let is_alone = way.count == 1 || input.name == ALONE;
        if way.has_moves && !is_alone && !told.contains("\"redeals\": {") {
            return Err(format!("{what}: no cut has moved"));
        }
        println!("{what}: {:.2} s", outcome.seconds);
        Ok(())
    }

    /// Lets each process write its part: together they are the mesh that `ltbw` has certified.
    /// Files of a whole domain are those of `ltbw`.
    fn in_parts(&self, input: &Input, alone: &Outcome, count: u32) -> Result<(), String> {
        let mut job = self.job(count, false);
        job.arg(&self.ranked).arg("--quiet").args(&input.arguments);
        job.args(["--json", "parts.json"]);
        let in_parts: &[&str] = if input.has_exterior() { &WITH_EXTERIOR } else { &IN_PARTS };
        in_parts.iter().for_each(|name| _ = job.args(["-o", name]));
        job.args(whole_of(input, 1));
        if input.is_domain() {
            job.args(["--page", "whole.html"]);
        }
        let outcome = watched(&mut job, WATCHDOG)?;
        let what = format!("{} in {count} parts", input.name);
        if outcome.code != alone.code {
            return Err(format!("{what}: code {:?}\n{}", outcome.code, outcome.stderr));
        }
        let report = fs::read_to_string(self.folder.join("parts.json")).unwrap_or_default();
        if input.name == PATCHED && !report.contains("\"late\": null") {
            return Err(format!("{what}: one process has the whole"));
        }
        let is_put_together = report.contains("\"gathered\":");
        let told = report.split_once("\"ranks\":").map_or("", |(_, told)| told);
        if !is_put_together && !told.contains(&format!("\"count\": {count},")) {
            return Err(format!("{what}: the report does not tell of {count} processes"));
        }
        // The others are not read by `ltbw`; what is not as asked for has no certificate.
        let is_read = |name: &&&str| alone.code == Some(0) && READ.contains(name);
        for name in in_parts.iter().filter(is_read) {
            let check = words_of(&["check", name, "--certificate", "alone.json"]);
            let checked = self.ltbw(&check)?;
            if checked.code != Some(0) {
                return Err(format!("{what}: {name}: {:?}\n{}", checked.code, checked.stderr));
            }
        }
        if input.is_domain() {
            for names in WHOLE {
                let read = |name: &str| {
                    fs::read(self.folder.join(name)).map_err(|error| format!("{name}: {error}"))
                };
                let [alone, whole] = names;
                if read(alone)? != read(whole)? {
                    return Err(format!("{what}: {whole} is another file than {alone}"));
                }
            }
        }
        println!("{what}: read back");
        Ok(())
    }

    /// A job of this many processes, whose program is still to be named.
    pub(crate) fn job(&self, count: u32, is_tcp: bool) -> Command {
        let mut job = self.mpi.job(count, is_tcp);
        job.current_dir(&self.folder);
        job
    }
}

/// Words.
pub(crate) fn words_of(all: &[&str]) -> Vec<String> {
    all.iter().map(|word| (*word).to_owned()).collect()
}

/// Fields of a report that do not depend on who has made the mesh.
const TOLD: [&str; 12] = [
    "excused",
    "reason",
    "tets",
    "outcome",
    "boundary_lost",
    "vertices",
    "hull_faces",
    "segment_points",
    "facet_points",
    "free_points",
    "value",
    "tet",
];

/// The lines of a report that tell of the mesh, of its quality, and of what is excused; none if an
/// input was refused.
fn excused(report: &Path) -> Vec<String> {
    let text = fs::read_to_string(report).unwrap_or_default();
    let is_wanted = |line: &&str| {
        let name = line.trim_start().strip_prefix('"').and_then(|line| line.split('"').next());
        name.is_some_and(|name| TOLD.contains(&name))
    };
    // A certificate has numbers of its own for tetrahedra in parts.
    let before = text.split("\"certificate\"").next().unwrap_or_default();
    before.lines().filter(is_wanted).map(|line| line.trim().to_owned()).collect()
}

/// Runs a command to its end, or to that of the watchdog's patience, which is an error.
pub(crate) fn watched(command: &mut Command, patience: Duration) -> Result<Outcome, String> {
    let child = begin(command)?;
    end(child, patience).map_err(|error| format!("{command:?}: {error}"))
}

/// Begins a command whose output is kept.
pub(crate) fn begin(command: &mut Command) -> Result<Child, String> {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().map_err(|error| format!("{command:?}: {error}"))
}

/// Waits for the end of a command.
pub(crate) fn end(child: Child, patience: Duration) -> Result<Outcome, String> {
    let clock = Instant::now();
    let is_late = || (clock.elapsed() >= patience).then(|| format!("{} s", patience.as_secs()));
    end_unless(child, is_late)
}

/// As [`end`]; `is_late` looks on, and says of a command that has to be ended why.
pub(crate) fn end_unless(
    mut child: Child,
    mut is_late: impl FnMut() -> Option<String>,
) -> Result<Outcome, String> {
    let clock = Instant::now();
    let (out, err) = (reader(child.stdout.take()), reader(child.stderr.take()));
    let status = loop {
        if let Some(status) = child.try_wait().map_err(|error| error.to_string())? {
            break status;
        }
        if let Some(why) = is_late() {
            let ended = child.kill().and_then(|()| child.wait());
            return Err(format!("no end after {why} ({ended:?})"));
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let text = |reader: std::thread::JoinHandle<String>| reader.join().unwrap_or_default();
    let seconds = clock.elapsed().as_secs_f64();
    Ok(Outcome { code: status.code(), stdout: text(out), stderr: text(err), seconds })
}

/// Reads an output as it comes: a pipe that is full would stop its writer.
fn reader(pipe: Option<impl std::io::Read + Send + 'static>) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            // The bytes that are there when it ends are told.
            let _ = pipe.read_to_end(&mut bytes);
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}
