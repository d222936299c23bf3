//! The CGAL reference as a server process: compiled once per source, started, asked over a pipe.
//!
//! The program is `tests/cgal/server.cpp` (its head describes the pipe). It is compiled when a test
//! first needs it, into the cargo target folder, under a name that is a hash of source, compiler
//! and flags; concurrent test processes wait for one another on a lock file.
//! CGAL is never linked to any of our crates: it is another program.

use ltbw::{MeshHash, Point};
use std::fmt;
use std::fs::{self, File};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

const SOURCE: &str = include_str!("../cgal/server.cpp");

/// `-frounding-math`: CGAL's interval filters are wrong without it. No `-march`: our own code is
/// compiled for the baseline processor, too.
const FLAGS: &[&str] = &["-std=c++17", "-O3", "-DNDEBUG", "-frounding-math", "-x", "c++", "-"];

/// Headers that must be there for the server, and for its variant on several threads.
const PROBE: &str = "#include <CGAL/version.h>\n#include <gmp.h>\n#include <mpfr.h>\n";
const PROBE_TBB: &str = "#include <tbb/global_control.h>\n";

/// The longest time that a reply may take before the server counts as hung. The largest sets of the
/// bars take CGAL about ten seconds; a debug machine under load gets a wide margin.
const PATIENCE: Duration = Duration::from_secs(600);

/// Why there is no CGAL to compare with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Missing {
    /// No C++ compiler was found (`$CXX`, `c++`, `g++`, `clang++`).
    Compiler,
    /// The headers of CGAL, GMP or MPFR (or of TBB, for the parallel variant) were not found.
    Headers(&'static str),
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Compiler => write!(f, "no C++ compiler was found"),
            Self::Headers(which) => write!(f, "the headers of {which} were not found"),
        }
    }
}

/// A failure of a server that should work. A test fails on these, it does not skip.
#[derive(Debug)]
pub enum Failure {
    /// CGAL is missing: the only reason to skip.
    Missing(Missing),
    /// The program did not compile or could not be started; the text says why.
    Build(String),
    /// The server died, or its reply was cut short.
    Pipe(io::Error),
    /// No reply in time; the server was killed.
    Timeout(Duration),
    /// The server refused the request (a coordinate that is not finite).
    Refused,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(missing) => missing.fmt(f),
            Self::Build(text) => write!(f, "the CGAL server does not build: {text}"),
            Self::Pipe(error) => write!(f, "the CGAL server is gone: {error}"),
            Self::Timeout(limit) => write!(f, "the CGAL server hung for {limit:?}"),
            Self::Refused => write!(f, "the CGAL server refused the points"),
        }
    }
}

impl std::error::Error for Failure {}

/// The parts of an answer that are asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Ask {
    /// Send the finite tetrahedra.
    pub tets: bool,
    /// Send the hull facets.
    pub hull: bool,
    /// Compute the canonical hash.
    pub hash: bool,
    /// Insert in input order instead of CGAL's spatial sort.
    pub input_order: bool,
    /// Remove the later half of the points again: the answer is of the others.
    pub remove: bool,
    /// Threads, for a server started with [`Cgal::start_tbb`]; else ignored.
    pub threads: u16,
}

impl Ask {
    fn flags(self) -> u32 {
        u32::from(self.tets)
            | u32::from(self.hull) << 1
            | u32::from(self.hash) << 2
            | u32::from(self.input_order) << 3
            | u32::from(self.remove) << 4
            | u32::from(self.threads) << 16
    }
}

/// CGAL's answer. Indices are the input's; duplicates appear as their smallest index.
#[derive(Debug, Clone)]
pub struct Reply {
    /// Affine dimension of the points: -1 for none, 3 for a mesh.
    pub dimension: i32,
    /// Number of distinct points.
    pub distinct: u64,
    /// Finite tetrahedra, positively oriented.
    pub tets: Vec<[u32; 4]>,
    /// Hull facets, oriented outwards.
    pub hull: Vec<[u32; 3]>,
    /// The canonical hash `ltbw.mesh/1`, if asked for and the dimension is 3.
    pub hash: Option<MeshHash>,
    /// Seconds for order and insertion; or for removing what was to be removed.
    pub seconds: f64,
    /// Peak resident set of the server so far, in bytes.
    pub peak_rss: u64,
}

struct Request {
    points: Vec<Point>,
    ask: Ask,
}

/// A running server. One request at a time; dropping it ends the process.
#[derive(Debug)]
pub struct Cgal {
    child: Child,
    requests: Option<Sender<Request>>,
    replies: Receiver<Result<Reply, Failure>>,
    patience: Duration,
}

impl Cgal {
    /// Compiles the server if need be and starts it.
    pub fn start() -> Result<Self, Failure> {
        Self::spawn(&executable(false)?, PATIENCE)
    }

    /// As [`Cgal::start`], with CGAL's parallel triangulation over TBB.
    pub fn start_tbb() -> Result<Self, Failure> {
        Self::spawn(&executable(true)?, PATIENCE)
    }

    /// A server for the test `test`; `None`, said aloud, where CGAL is missing and not required.
    ///
    /// # Panics
    /// If the server should work and does not, or if it is missing and `LTBW_REQUIRE` demands it.
    #[must_use]
    pub fn for_test(test: &str) -> Option<Self> {
        match Self::start() {
            Ok(cgal) => Some(cgal),
            Err(Failure::Missing(missing)) => {
                let skipped = crate::require::skip(test, "cgal", &missing.to_string());
                skipped.unwrap_or_else(|demanded| panic!("{demanded}"));
                None
            }
            Err(failure) => panic!("{test}: {failure}"),
        }
    }

    /// Starts the program at `path`; a reply that takes longer than `patience` is a failure.
    pub fn spawn(path: &Path, patience: Duration) -> Result<Self, Failure> {
        let mut child = Command::new(path)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| Failure::Build(format!("{}: {error}", path.display())))?;
        let stdin = child.stdin.take().expect("stdin was asked to be a pipe");
        let stdout = child.stdout.take().expect("stdout was asked to be a pipe");
        let (requests, inbox) = channel();
        let (outbox, replies) = channel();
        // The thread ends when the request side is dropped or the pipe breaks.
        thread::spawn(move || converse(stdin, stdout, &inbox, &outbox));
        Ok(Self { child, requests: Some(requests), replies, patience })
    }

    /// Tetrahedra, hull facets and hash of `points`.
    pub fn triangulate(&mut self, points: &[Point]) -> Result<Reply, Failure> {
        self.ask(points, Ask { tets: true, hull: true, hash: true, ..Ask::default() })
    }

    /// The hash alone (`None` below dimension 3).
    pub fn hash(&mut self, points: &[Point]) -> Result<Option<MeshHash>, Failure> {
        Ok(self.ask(points, Ask { hash: true, ..Ask::default() })?.hash)
    }

    /// Sends one request and waits for its reply.
    pub fn ask(&mut self, points: &[Point], ask: Ask) -> Result<Reply, Failure> {
        let gone = || Failure::Pipe(io::ErrorKind::BrokenPipe.into());
        let request = Request { points: points.to_vec(), ask };
        let requests = self.requests.as_ref().ok_or_else(gone)?;
        requests.send(request).map_err(|_| gone())?;
        match self.replies.recv_timeout(self.patience) {
            Ok(reply) => reply,
            Err(RecvTimeoutError::Timeout) => {
                self.requests = None;
                let _ = self.child.kill();
                Err(Failure::Timeout(self.patience))
            }
            Err(RecvTimeoutError::Disconnected) => Err(gone()),
        }
    }
}

impl Drop for Cgal {
    fn drop(&mut self) {
        // The server is at rest between requests, so killing it loses nothing.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Serves one request after the other until either side is gone.
fn converse(
    mut stdin: ChildStdin,
    mut stdout: ChildStdout,
    inbox: &Receiver<Request>,
    outbox: &Sender<Result<Reply, Failure>>,
) {
    for request in inbox {
        let result = send(&mut stdin, &request).map_err(Failure::Pipe).and_then(|()| {
            let mut stdout = io::BufReader::with_capacity(1 << 16, &mut stdout);
            receive(&mut stdout, request.ask)
        });
        let failed = result.is_err();
        if outbox.send(result).is_err() || failed {
            return;
        }
    }
}

fn send(stdin: &mut ChildStdin, request: &Request) -> io::Result<()> {
    let mut bytes = Vec::with_capacity(20 + 24 * request.points.len());
    bytes.extend(1u64.to_le_bytes());
    bytes.extend(request.ask.flags().to_le_bytes());
    bytes.extend((request.points.len() as u64).to_le_bytes());
    bytes.extend(request.points.iter().flatten().flat_map(|c| c.to_le_bytes()));
    stdin.write_all(&bytes)?;
    stdin.flush()
}

/// Reads one reply. A `BufReader` per reply loses nothing: the server sends nothing unasked.
fn receive(stdout: &mut impl Read, ask: Ask) -> Result<Reply, Failure> {
    let mut head = [0u8; 80];
    stdout.read_exact(&mut head).map_err(Failure::Pipe)?;
    let word = |at: usize| -> [u8; 4] { head[at..at + 4].try_into().expect("4 of 80 bytes") };
    let long = |at: usize| -> [u8; 8] { head[at..at + 8].try_into().expect("8 of 80 bytes") };
    let status = u32::from_le_bytes(word(0));
    if status > 1 {
        return Err(Failure::Refused);
    }
    let hash: [u8; 32] = head[48..80].try_into().expect("32 of 80 bytes");
    Ok(Reply {
        dimension: i32::from_le_bytes(word(4)),
        distinct: u64::from_le_bytes(long(8)),
        seconds: f64::from_le_bytes(long(32)),
        peak_rss: u64::from_le_bytes(long(40)),
        hash: (ask.hash && status == 0).then_some(MeshHash(hash)),
        tets: simplices(stdout, u64::from_le_bytes(long(16))).map_err(Failure::Pipe)?,
        hull: simplices(stdout, u64::from_le_bytes(long(24))).map_err(Failure::Pipe)?,
    })
}

fn simplices<const N: usize>(from: &mut impl Read, count: u64) -> io::Result<Vec<[u32; N]>> {
    let mut bytes = Vec::new();
    let len = count * 4 * N as u64;
    if from.take(len).read_to_end(&mut bytes)? as u64 != len {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    let numbers = |row: &[u8]| {
        std::array::from_fn(|i| {
            u32::from_le_bytes(row[4 * i..4 * i + 4].try_into().expect("4 bytes"))
        })
    };
    Ok(bytes.chunks_exact(4 * N).map(numbers).collect())
}

/// Path of the compiled server; compiles it if this source was never compiled here.
fn executable(tbb: bool) -> Result<PathBuf, Failure> {
    let compiler = compiler()?;
    let mut key = DefaultHasher::new();
    (SOURCE, FLAGS, &compiler, tbb).hash(&mut key);
    let folder = folder();
    let path = folder.join(format!("server-{:016x}", key.finish()));
    if path.exists() {
        return Ok(path);
    }
    for (probe, wanted, name) in [(PROBE, true, "CGAL, GMP and MPFR"), (PROBE_TBB, tbb, "TBB")] {
        if wanted && pipe(Command::new(&compiler).args(["-x", "c++", "-E", "-"]), probe).is_err() {
            return Err(Failure::Missing(Missing::Headers(name)));
        }
    }
    let build = |error: io::Error| Failure::Build(format!("{}: {error}", path.display()));
    fs::create_dir_all(&folder).map_err(build)?;
    let lock = File::create(folder.join("lock")).map_err(build)?;
    lock.lock().map_err(build)?;
    if path.exists() {
        return Ok(path); // another process compiled it while this one waited
    }
    let aside = path.with_extension("new");
    let mut command = Command::new(&compiler);
    command.args(FLAGS).arg("-o").arg(&aside);
    if tbb {
        command.args(["-DLTBW_TBB", "-DCGAL_LINKED_WITH_TBB", "-ltbb", "-ltbbmalloc", "-pthread"]);
    }
    pipe(command.args(["-lgmp", "-lmpfr"]), SOURCE).map_err(Failure::Build)?;
    fs::rename(&aside, &path).map_err(build)?;
    Ok(path)
}

/// Runs `command` with `input` on its standard input; its messages are the error.
fn pipe(command: &mut Command, input: &str) -> Result<(), String> {
    let text = |error: io::Error| error.to_string();
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(text)?;
    let mut stdin = child.stdin.take().expect("stdin was asked to be a pipe");
    stdin.write_all(input.as_bytes()).map_err(text)?;
    drop(stdin);
    let output = child.wait_with_output().map_err(text)?;
    if output.status.success() {
        Ok(())
    } else {
        Err(format!("{command:?}: {}", String::from_utf8_lossy(&output.stderr)))
    }
}

fn compiler() -> Result<String, Failure> {
    let works = |name: &String| {
        Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success())
    };
    let named = std::env::var("CXX").ok();
    named
        .into_iter()
        .chain(["c++", "g++", "clang++"].map(String::from))
        .find(works)
        .ok_or(Failure::Missing(Missing::Compiler))
}

/// The folder of compiled servers: `LTBW_CGAL_FOLDER`, else `cgal` in the cargo target folder.
fn folder() -> PathBuf {
    std::env::var_os("LTBW_CGAL_FOLDER").map_or_else(|| target_folder().join("cgal"), PathBuf::from)
}

/// The cargo target folder: the running program lies in `<target>/<profile>[/deps]`.
fn target_folder() -> PathBuf {
    let program = std::env::current_exe().unwrap_or_default();
    let mut folder = program.parent().unwrap_or(Path::new("."));
    if folder.ends_with("deps") {
        folder = folder.parent().unwrap_or(folder);
    }
    folder.parent().unwrap_or(folder).to_path_buf()
}

#[cfg(test)]
mod tests {
    use super::{Cgal, Failure};
    use std::path::Path;
    use std::time::Duration;

    #[test]
    fn a_server_that_hangs_is_a_failure_and_not_a_hang() {
        // `cat` echoes the 44 bytes of the request, which is less than a reply's head.
        let cat = Cgal::spawn(Path::new("cat"), Duration::from_millis(20));
        let mut cat = cat.expect("cat is a program");
        let reply = cat.triangulate(&[[0.0; 3]]);
        assert!(matches!(reply, Err(Failure::Timeout(_))), "{reply:?}");
        let reply = cat.triangulate(&[[0.0; 3]]);
        assert!(matches!(reply, Err(Failure::Pipe(_))), "{reply:?}");
    }

    #[test]
    fn what_cannot_be_started_is_a_build_failure() {
        let none = Cgal::spawn(Path::new("no-such-program"), Duration::from_secs(1));
        assert!(matches!(none, Err(Failure::Build(_))), "{none:?}");
    }
}
