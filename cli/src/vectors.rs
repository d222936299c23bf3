//! `vectors run`: asks a foreign program the questions of the conformance kit. `vectors unpack`:
//! writes the kit.
//!
//! One JSON object a line in, one a line out. What a wrong answer tells is in the case's flags;
//! what the program cannot do it says (`{"unsupported": true}`). A folder's *level* is the highest
//! tier up to which every case was answered, and rightly.

use crate::args::VectorsRun;
use crate::console;
use crate::kit;
use crate::outcome::{Exit, Failure, show};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

/// The folders, in the order in which a port fills them (`docs/porting.md`).
const FOLDERS: [&str; 8] =
    ["predicates", "order", "cavity", "insert", "delaunay", "protocol", "interleavings", "rounds"];
/// Wrong answers told of, for each folder.
const TOLD: usize = 3;

/// A file of the kit.
#[derive(Debug, Deserialize)]
struct File {
    kit: String,
    tier: u32,
    flags: BTreeMap<String, String>,
    cases: Vec<Case>,
}

#[derive(Debug, Deserialize)]
struct Case {
    id: String,
    name: String,
    flags: Vec<String>,
    ask: Value,
    expect: Value,
}

/// The result of one folder.
#[derive(Debug, Default)]
struct Tally {
    right: usize,
    unsupported: usize,
    /// Cases, wrong answers and why.
    wrong: Vec<String>,
    /// By tier: is every case answered rightly?
    tiers: BTreeMap<u32, bool>,
    /// By flag: how many failed, of how many, and what that tells.
    flags: BTreeMap<String, (usize, usize, String)>,
}

impl Tally {
    /// The highest tier up to which all is right, and the highest there is.
    fn level(&self) -> (u32, u32) {
        let reached = self.tiers.iter().take_while(|(_, right)| **right).last();
        let most = self.tiers.keys().next_back();
        (reached.map_or(0, |(tier, _)| *tier), most.copied().unwrap_or(0))
    }

    fn add(
        &mut self,
        tier: u32,
        case: &Case,
        meanings: &BTreeMap<String, String>,
        verdict: Verdict,
    ) {
        let right = matches!(verdict, Verdict::Right);
        *self.tiers.entry(tier).or_insert(true) &= right;
        let failed = matches!(verdict, Verdict::Wrong(_));
        for flag in &case.flags {
            let meaning = || meanings.get(flag).cloned().unwrap_or_default();
            let entry = self.flags.entry(flag.clone()).or_insert_with(|| (0, 0, meaning()));
            entry.0 += usize::from(failed);
            entry.1 += 1;
        }
        match verdict {
            Verdict::Right => self.right += 1,
            Verdict::Unsupported => self.unsupported += 1,
            Verdict::Wrong(why) => self.wrong.push(format!("{} ({}): {why}", case.id, case.name)),
        }
    }
}

/// The value of an answer.
#[derive(Debug)]
enum Verdict {
    Right,
    Unsupported,
    Wrong(String),
}

/// The foreign program. Its answers are read by a thread, so that one that hangs is noticed.
struct Executor {
    child: Child,
    to: Option<ChildStdin>,
    from: Receiver<String>,
    patience: Duration,
}

impl Executor {
    /// Starts it as asked, with `RUST_BACKTRACE` as the user has it.
    fn start(asked: &VectorsRun, backtraces: Option<&OsStr>) -> Result<Self, Failure> {
        let program = &asked.executor;
        let mut command = Command::new(program);
        command.args(&asked.arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
        command.envs(backtraces.map(|asked| ("RUST_BACKTRACE", asked)));
        let failed = |error: &dyn std::fmt::Display| {
            Failure::Usage(format!("executor {}: {error}", show(program)))
        };
        let mut child = command.spawn().map_err(|error| failed(&error))?;
        let to = child.stdin.take();
        let Some(out) = child.stdout.take() else { return Err(failed(&"no stdout")) };
        let (sender, from) = channel();
        let listener = std::thread::Builder::new().spawn(move || {
            // Ends with the program's output, or when nobody listens any more.
            for line in BufReader::new(out).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        listener.map_err(|e| Failure::Machine(format!("cannot start a thread: {e}")))?;
        Ok(Self { child, to, from, patience: Duration::from_secs(asked.timeout) })
    }

    /// One question; an error if the program is gone or says nothing in time.
    fn ask(&mut self, question: &Value) -> Result<String, String> {
        let to = self.to.as_mut().ok_or("it takes no questions")?;
        writeln!(to, "{question}")
            .and_then(|()| to.flush())
            .map_err(|e| format!("it is gone: {e}"))?;
        self.from.recv_timeout(self.patience).map_err(|error| match error {
            RecvTimeoutError::Timeout => format!("no answer in {} s", self.patience.as_secs()),
            RecvTimeoutError::Disconnected => "it ended without an answer".to_string(),
        })
    }
}

impl Drop for Executor {
    fn drop(&mut self) {
        self.to = None;
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Compares an answer with the expected one: every expected field, and no mind of others.
fn judge(expect: &Value, line: &str) -> Verdict {
    let reply: Value = match serde_json::from_str(line) {
        Ok(reply) => reply,
        Err(error) => return Verdict::Wrong(format!("not JSON: {error}")),
    };
    if reply.get("unsupported") == Some(&Value::Bool(true)) {
        return Verdict::Unsupported;
    }
    let fields = expect.as_object().into_iter().flatten();
    let absent = Value::Null;
    for (field, wanted) in fields {
        let found = reply.get(field).unwrap_or(&absent);
        if found != wanted {
            return Verdict::Wrong(format!("{field} is {}, not {}", short(found), short(wanted)));
        }
    }
    Verdict::Right
}

/// A value in a line of moderate length.
fn short(value: &Value) -> String {
    let text = value.to_string();
    let cut: String = text.chars().take(80).map(|c| if c.is_control() { '?' } else { c }).collect();
    if cut.len() < text.len() { format!("{cut}...") } else { cut }
}

/// The texts of a kit, by path: of a folder, or of the kit inside the program.
fn kit(folder: Option<&Path>) -> Result<BTreeMap<String, String>, Failure> {
    let Some(root) = folder else { return kit::files() };
    let mut texts = BTreeMap::new();
    for name in FOLDERS {
        let folder = root.join(name);
        let entries = std::fs::read_dir(&folder).map_err(|error| bad(&folder, &error))?;
        for path in entries.filter_map(|entry| entry.ok().map(|entry| entry.path())) {
            let Some(file) = path.file_name().filter(|_| is_json(&path)) else { continue };
            let text = std::fs::read_to_string(&path).map_err(|error| bad(&path, &error))?;
            texts.insert(format!("{name}/{}", file.to_string_lossy()), text);
        }
    }
    Ok(texts)
}

fn is_json(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "json")
}

fn bad(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::Usage(format!("{}: {error}", show(path)))
}

/// The files of a folder of the kit, by name.
fn files(kit: &BTreeMap<String, String>, folder: &str) -> Result<Vec<File>, Failure> {
    let of_folder = |path: &&String| path.split('/').next() == Some(folder);
    let paths: Vec<&String> =
        kit.keys().filter(of_folder).filter(|p| p.ends_with(".json")).collect();
    if paths.is_empty() {
        return Err(bad(Path::new(folder), &"no vectors"));
    }
    let parse = |path: &&String| {
        serde_json::from_str(&kit[*path]).map_err(|error| bad(Path::new(path), &error))
    };
    paths.iter().map(parse).collect()
}

/// `ltbw vectors unpack`.
pub(crate) fn unpack(folder: &Path) -> Result<Exit, Failure> {
    let written = kit::unpack(folder)?;
    let count = written.len();
    console::people(&format!("wrote     {count} files of the kit into {}", show(folder)));
    Ok(Exit::Done)
}

/// `ltbw vectors run`.
pub(crate) fn run(args: &VectorsRun, backtraces: Option<&OsStr>) -> Result<Exit, Failure> {
    let kit = kit(args.kit.as_deref())?;
    let mut executor = Executor::start(args, backtraces)?;
    let (mut wrong, mut version) = (0, String::new());
    let chosen = |folder: &str| args.folder.is_empty() || args.folder.iter().any(|f| f == folder);
    for folder in FOLDERS.into_iter().filter(|folder| chosen(folder)) {
        let mut tally = Tally::default();
        for file in files(&kit, folder)? {
            version.clone_from(&file.kit);
            for case in &file.cases {
                let verdict = match executor.ask(&case.ask) {
                    Ok(line) => judge(&case.expect, &line),
                    Err(why) => {
                        console::people(&format!("{}: {why}; it is started again", case.id));
                        executor = Executor::start(args, backtraces)?;
                        Verdict::Wrong(why)
                    }
                };
                tally.add(file.tier, case, &file.flags, verdict);
            }
        }
        wrong += tally.wrong.len();
        console::data(&told(folder, &tally))?;
    }
    console::data(&format!("kit {version}: {wrong} wrong answers\n"))?;
    Ok(if wrong == 0 { Exit::Done } else { Exit::Defect })
}

/// The lines to print of a folder.
fn told(folder: &str, tally: &Tally) -> String {
    let (reached, most) = tally.level();
    let Tally { right, unsupported, wrong, .. } = tally;
    let all = right + unsupported + wrong.len();
    let mut text = format!("{folder:<14} level {reached} of {most}: {right} of {all} right");
    if *unsupported > 0 {
        text += &format!(", {unsupported} not supported");
    }
    text += "\n";
    for (flag, (failed, of, meaning)) in tally.flags.iter().filter(|(_, (failed, ..))| *failed > 0)
    {
        text += &format!("  {flag}: {failed} of {of} wrong: {meaning}\n");
    }
    for line in wrong.iter().take(TOLD) {
        text += &format!("  e.g. {line}\n");
    }
    text
}
