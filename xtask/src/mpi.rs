//! `mpi`: the program of `parallel/mpi`: its tests, and its runs by `mpirun` beside `ltbw`, each
//! under a watchdog: one hash on any number of processes, over shared memory and over TCP, in time
//! and late; what it refuses; what comes of processes that panic, are killed or are stopped; jobs
//! that go on from the checkpoint of one that has lost a process.

mod faults;
mod readers;
mod resumed;
mod storm;
mod validate;

use crate::require;
use crate::shell::{self, cargo, command, root, target};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The longest time of a run.
const WATCHDOG: Duration = Duration::from_secs(120);

/// Mail goes over TCP.
const TCP: [&str; 6] = ["--mca", "btl", "self,tcp", "--mca", "btl_tcp_if_include", "lo"];

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

/// Domains: kind, what else makes it, bounds.
const DOMAINS: [(&str, &[&str], &[&str]); 5] = [
    ("cube-octahedron", &[], &["--max-volume", "5e-5"]),
    ("tee", &[], &["--max-volume", "1.5e-4"]),
    ("gear", &[], &["--max-volume", "4e-5"]),
    ("cube-in-cube", &[], &["--max-volume", "5e-5"]),
    // One process refines it alone.
    ("wedge", &["--angle", "5"], &[]),
];

/// The files of a mesh in parts.
const IN_PARTS: [&str; 4] = ["parts.pvtu", "parts_%.msh", "parts.mfem", "parts.vtkhdf"];

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
}

/// An input with the arguments that mesh it.
pub(crate) struct Input {
    name: String,
    arguments: Vec<String>,
}

/// The demands of a command line.
struct Asked {
    ranks: Vec<u32>,
    has_readers: bool,
    validates: bool,
    /// Jobs with faults, and no other ones.
    faults: Option<u64>,
    seed: u64,
}

/// Jobs with faults beside the others.
const FEW_FAULTS: u64 = 12;

/// Builds and runs.
pub(crate) fn run(rest: &[String]) -> Result<(), String> {
    let Asked { ranks, has_readers, validates, faults, seed } = Asked::of(rest)?;
    let tools: [(&str, &[&str]); 2] = [("mpirun", &["--version"]), ("mpicc", &["--version"])];
    for (tool, arguments) in tools {
        if !shell::works(command(tool).args(arguments)) {
            let install = "apt-get install openmpi-bin libopenmpi-dev libclang-dev clang";
            let reason = format!("{tool} does not start: {install}");
            return require::skip("the program of parallel/mpi", "mpi", &reason);
        }
    }
    let bench = Bench::build()?;
    if validates {
        return validate::run(&bench);
    }
    let inputs = bench.inputs()?;
    if let Some(count) = faults {
        return storm::run(&bench, count, seed);
    }
    let mut runs = 0;
    for input in &inputs {
        let alone = bench.alone(input)?;
        for &count in &ranks {
            bench.compare(input, &alone, Way { count, ..Way::default() })?;
            runs += 1;
        }
        let most = ranks.iter().copied().max().unwrap_or(2);
        bench.compare(input, &alone, Way { count: most, network: &TCP, late: None })?;
        bench.compare(input, &alone, Way { count: 2, network: &[], late: Some("300") })?;
        runs += 2;
        bench.in_parts(input, &alone, most)?;
        runs += 1;
        let has_points = input.arguments.first().is_some_and(|command| command == "delaunay");
        if has_points && has_readers {
            readers::run(&bench, &input.name, &input.arguments, most)?;
        }
    }
    println!("{} inputs, {runs} runs: one hash each", inputs.len());
    let count = faults::run(&bench)? + resumed::run(&bench)?;
    println!("{count} refusals and faults: each with its word and its code");
    storm::run(&bench, FEW_FAULTS, seed)
}

impl Asked {
    fn of(rest: &[String]) -> Result<Self, String> {
        let usage = "cargo xtask mpi [--ranks 1,2,3,4] [--readers] [--validate] \
                     [--faults N] [--seed N]";
        let (has_readers, validates, faults) = (false, false, None);
        let seed = std::time::UNIX_EPOCH.elapsed().map_or(1, |since| since.as_secs());
        let mut own = Self { ranks: vec![1, 2, 3, 4], has_readers, validates, faults, seed };
        let mut words = rest.iter().map(String::as_str);
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or_else(|| usage.to_owned());
            let number = |text: &str| {
                text.parse::<u64>().map_err(|_| format!("{word} {text}: no number; {usage}"))
            };
            match word {
                "--readers" => own.has_readers = true,
                "--validate" => own.validates = true,
                "--faults" => own.faults = Some(number(value()?)?),
                "--seed" => own.seed = number(value()?)?,
                "--ranks" => {
                    let list = value()?.split(',').map(number).collect::<Result<Vec<u64>, _>>()?;
                    let count = |count: u64| u32::try_from(count).ok().filter(|&own| own > 0);
                    let ranks: Option<Vec<u32>> = list.into_iter().map(count).collect();
                    own.ranks = ranks.ok_or_else(|| usage.to_owned())?;
                }
                _ => return Err(usage.to_owned()),
            }
        }
        Ok(own)
    }
}

/// The way in which an input is run on processes.
#[derive(Clone, Copy, Default)]
struct Way<'a> {
    count: u32,
    /// Options of `mpirun`.
    network: &'a [&'a str],
    /// The delay of mails, in microseconds.
    late: Option<&'a str>,
}

impl Bench {
    /// The programs: those that `LTBW_MPI_PROGRAM` and `LTBW_PROGRAM` name, or that are built here.
    fn build() -> Result<Self, String> {
        let folder = target().join("mpi");
        fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        if let Some(ranked) = std::env::var_os("LTBW_MPI_PROGRAM") {
            return Ok(Self { ranked: ranked.into(), alone: shell::program()?, folder });
        }
        let manifest = root().join("parallel/mpi/Cargo.toml");
        let in_package = |arguments: &[&str], more: &[&str]| {
            let mut cargo = cargo();
            cargo.args(arguments).arg("--manifest-path").arg(&manifest).args(more);
            // The crates below are those of the workspace, which are built once.
            shell::run(cargo.env("CARGO_TARGET_DIR", target()))
        };
        in_package(&["fmt"], &["--check"])?;
        in_package(&["test", "--quiet", "--release", "--locked"], &[])?;
        in_package(&["build", "--quiet", "--release", "--locked"], &[])?;
        let ranked = target().join("release/ltbw-mpi");
        Ok(Self { ranked, alone: shell::program()?, folder })
    }

    /// A command of `ltbw`.
    pub(crate) fn ltbw(&self, arguments: &[String]) -> Result<Outcome, String> {
        let mut command = Command::new(&self.alone);
        watched(command.current_dir(&self.folder).arg("--quiet").args(arguments), WATCHDOG)
    }

    /// Makes all inputs.
    fn inputs(&self) -> Result<Vec<Input>, String> {
        let mut inputs = Vec::new();
        let words = |all: &[&str]| all.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let mut make = |arguments: Vec<String>, name: String, command: Vec<String>| {
            let made = self.ltbw(&[words(&["generate"]), arguments].concat())?;
            if made.code != Some(0) {
                return Err(format!("{name}: {}", made.stderr));
            }
            inputs.push(Input { name, arguments: command });
            Ok(())
        };
        for (kind, count, format) in POINTS {
            let file = format!("{kind}-{count}.{format}");
            make(
                words(&[kind, count, "-o", &file]),
                format!("{kind} {count}"),
                words(&["delaunay", &file]),
            )?;
        }
        for (kind, shape, bounds) in DOMAINS {
            let file = format!("{kind}.poly");
            make(
                [words(&[kind]), words(shape), words(&["-o", &file])].concat(),
                kind.to_owned(),
                [words(&["mesh", &file]), words(bounds)].concat(),
            )?;
        }
        Ok(inputs)
    }

    /// The outcome of `ltbw` with an input.
    fn alone(&self, input: &Input) -> Result<Outcome, String> {
        let report = words_of(&["--json", "alone.json"]);
        self.ltbw(&[input.arguments.clone(), report].concat())
    }

    /// Runs an input on processes, and compares code, hash and excuses.
    fn compare(&self, input: &Input, alone: &Outcome, way: Way<'_>) -> Result<(), String> {
        let Way { count, network, late: latency } = way;
        let report = words_of(&["--json", "ranks.json"]);
        let arguments = [input.arguments.clone(), report].concat();
        let mut job = self.job(count, network);
        job.arg(&self.ranked).arg("--quiet").args(&arguments);
        latency.iter().for_each(|late| _ = job.env("LTBW_MPI_LATENCY_US", late));
        let outcome = watched(&mut job, WATCHDOG)?;
        let what = format!("{} on {count} {network:?} {latency:?}", input.name);
        let excuses = |file: &str| excused(&self.folder.join(file));
        let same = outcome.code == alone.code && outcome.stdout == alone.stdout;
        if !same || excuses("ranks.json")? != excuses("alone.json")? {
            return Err(format!(
                "{what}: code {:?}, {:?}, not {:?}, {:?}\n{}",
                outcome.code, outcome.stdout, alone.code, alone.stdout, outcome.stderr
            ));
        }
        println!("{what}: {:.2} s", outcome.seconds);
        Ok(())
    }

    /// Lets each process write its part: together they are the mesh that `ltbw` has certified.
    fn in_parts(&self, input: &Input, alone: &Outcome, count: u32) -> Result<(), String> {
        let mut job = self.job(count, &[]);
        job.arg(&self.ranked).arg("--quiet").args(&input.arguments);
        IN_PARTS.iter().for_each(|name| _ = job.args(["-o", name]));
        let outcome = watched(&mut job, WATCHDOG)?;
        let what = format!("{} in {count} parts", input.name);
        if outcome.code != alone.code {
            return Err(format!("{what}: code {:?}\n{}", outcome.code, outcome.stderr));
        }
        // The others are not read by `ltbw`; what is not as asked for has no certificate.
        let read = if alone.code == Some(0) { &IN_PARTS[..2] } else { &[] };
        for name in read {
            let check = words_of(&["check", name, "--certificate", "alone.json"]);
            let checked = self.ltbw(&check)?;
            if checked.code != Some(0) {
                return Err(format!("{what}: {name}: {:?}\n{}", checked.code, checked.stderr));
            }
        }
        println!("{what}: read back");
        Ok(())
    }

    /// A job of this many processes, whose program is still to be named.
    pub(crate) fn job(&self, count: u32, network: &[&str]) -> Command {
        let mut job = Command::new("mpirun");
        job.current_dir(&self.folder).env("OMPI_ALLOW_RUN_AS_ROOT", "1");
        job.env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1").args(["--oversubscribe"]).args(network);
        job.args(["-n", &count.to_string()]);
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

/// The lines of a report that tell of the mesh, of its quality, and of what is excused.
fn excused(report: &Path) -> Result<Vec<String>, String> {
    let text = fs::read_to_string(report).map_err(|e| format!("{}: {e}", report.display()))?;
    let is_wanted = |line: &&str| {
        let name = line.trim_start().strip_prefix('"').and_then(|line| line.split('"').next());
        name.is_some_and(|name| TOLD.contains(&name))
    };
    // A certificate has numbers of its own for tetrahedra in parts.
    let before = text.split("\"certificate\"").next().unwrap_or_default();
    Ok(before.lines().filter(is_wanted).map(|line| line.trim().to_owned()).collect())
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
    end_or(child, patience, || ())
}

/// As [`end`]; `last` looks at a command that is out of time before it is ended.
pub(crate) fn end_or(
    mut child: Child,
    patience: Duration,
    last: impl FnOnce(),
) -> Result<Outcome, String> {
    let clock = Instant::now();
    let (out, err) = (reader(child.stdout.take()), reader(child.stderr.take()));
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if clock.elapsed() < patience => std::thread::sleep(Duration::from_millis(5)),
            Ok(None) => {
                last();
                let ended = child.kill().and_then(|()| child.wait());
                return Err(format!("no end after {} s ({ended:?})", patience.as_secs()));
            }
            Err(error) => return Err(error.to_string()),
        }
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
