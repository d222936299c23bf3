//! Checkpoints of a refinement by processes: a file of the first one's, which holds the mesh and
//! the work left between two rounds. A job of any size goes on from it, and ends with the mesh that
//! the other one would have made.

use crate::binding::sha256;
use crate::console;
use crate::outcome::Failure;
use ltbw::io;
use serde::{Deserialize, Serialize};
use std::io::ErrorKind;
use std::path::PathBuf;

/// The checkpoints that a job is to write, and to go on from.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    /// The file. It is read if it is there.
    pub path: PathBuf,
    /// Rounds from one to the next.
    pub every: u64,
}

/// The job that a checkpoint is of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Job {
    /// The program.
    pub(super) build: String,
    /// The hash of its command line.
    pub(super) words: String,
    /// The hash of what it has read.
    pub(super) input: String,
}

/// The first line of the file.
#[derive(Serialize, Deserialize)]
struct Head {
    ltbw_checkpoint: u32,
    job: Job,
    rounds: u64,
    bytes: usize,
    sha256: String,
}

/// The version of this format.
const FORMAT: u32 = 1;

/// The reason for which nobody goes on from a file.
enum Unfit {
    Damaged(&'static str),
    Input,
    Other(&'static str),
}

impl Checkpoint {
    /// The state to go on from, if the file is there.
    pub(super) fn load(&self, job: &Job) -> Result<Option<Vec<u8>>, Failure> {
        let bytes = match std::fs::read(&self.path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(self.damaged(&error.to_string())),
        };
        match open(&bytes, job) {
            Ok((rounds, state)) => {
                let name = self.path.display();
                console::people(&format!("note: {name}: goes on after {rounds} rounds"));
                Ok(Some(state.to_vec()))
            }
            Err(Unfit::Damaged(why)) => Err(self.damaged(why)),
            Err(Unfit::Input) => {
                let why = "a checkpoint of another input".to_owned();
                Err(Failure::Report { path: self.path.clone(), why })
            }
            Err(Unfit::Other(what)) => {
                let name = self.path.display();
                Err(Failure::Usage(format!("{name}: a checkpoint of another {what}")))
            }
        }
    }

    fn damaged(&self, why: &str) -> Failure {
        Failure::Report { path: self.path.clone(), why: format!("no checkpoint: {why}") }
    }

    /// Writes a state aside, and gives it its name. The one before stays if that fails, and the job
    /// goes on.
    pub(super) fn keep(&self, job: &Job, rounds: u64, state: &[u8]) {
        if let Err(error) = io::write_bytes(&self.path, &sealed(job, rounds, state)) {
            console::aloud(&format!("note: no checkpoint after {rounds} rounds: {error}"));
        }
    }
}

/// A state with its head.
fn sealed(job: &Job, rounds: u64, state: &[u8]) -> Vec<u8> {
    let (job, sha256) = (job.clone(), sha256(state));
    let head = Head { ltbw_checkpoint: FORMAT, job, rounds, bytes: state.len(), sha256 };
    // A head has no maps, whose keys could be none of JSON's.
    let mut bytes = serde_json::to_vec(&head).unwrap_or_default();
    bytes.push(b'\n');
    bytes.extend_from_slice(state);
    bytes
}

/// The rounds before a state, and the state, if it is of this job and whole.
fn open<'b>(bytes: &'b [u8], job: &Job) -> Result<(u64, &'b [u8]), Unfit> {
    let end = bytes.iter().position(|&byte| byte == b'\n');
    let (head, state) = bytes.split_at(end.ok_or(Unfit::Damaged("it has no first line"))?);
    let state = &state[1..];
    let head: Head = serde_json::from_slice(head)
        .map_err(|_| Unfit::Damaged("its first line makes no sense"))?;
    match () {
        () if head.ltbw_checkpoint != FORMAT || head.job.build != job.build => {
            Err(Unfit::Other("build"))
        }
        () if head.job.words != job.words => Err(Unfit::Other("command line")),
        () if head.job.input != job.input => Err(Unfit::Input),
        () if head.bytes != state.len() => Err(Unfit::Damaged("its length is not what it says")),
        () if head.sha256 != sha256(state) => Err(Unfit::Damaged("its hash is not what it says")),
        () => Ok((head.rounds, state)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job() -> Job {
        let [build, words, input] = ["a", "b", "c"].map(str::to_owned);
        Job { build, words, input }
    }

    #[test]
    fn a_checkpoint_is_that_of_its_job_or_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let own = Checkpoint { path: folder.path().join("c"), every: 1 };
        assert_eq!(own.load(&job()).expect("none"), None);
        own.keep(&job(), 7, b"state\nof it");
        assert_eq!(own.load(&job()).expect("a state").as_deref(), Some(&b"state\nof it"[..]));
        let text = |job: &Job| own.load(job).expect_err("another").to_string();
        let other = || "other".to_owned();
        for (job, what, code) in [
            (Job { build: other(), ..job() }, "build", 2),
            (Job { words: other(), ..job() }, "command line", 2),
            (Job { input: other(), ..job() }, "input", 3),
        ] {
            assert!(text(&job).ends_with(&format!("a checkpoint of another {what}")), "{what}");
            assert_eq!(own.load(&job).expect_err("another").code(), code);
        }
        let whole = std::fs::read(&own.path).expect("bytes");
        let head = whole.iter().position(|&byte| byte == b'\n').expect("a line");
        // Whatever is cut off, and whatever changes in the state.
        for length in 0..whole.len() {
            std::fs::write(&own.path, &whole[..length]).expect("a file");
            assert_eq!(own.load(&job()).expect_err("cut").code(), 3, "{length}");
        }
        for place in head + 1..whole.len() {
            let mut bytes = whole.clone();
            bytes[place] ^= 1;
            std::fs::write(&own.path, bytes).expect("a file");
            assert!(text(&job()).ends_with("its hash is not what it says"), "{place}");
        }
    }

    #[test]
    fn a_checkpoint_that_cannot_be_written_leaves_the_one_before() {
        let folder = tempfile::tempdir().expect("a folder");
        let own = Checkpoint { path: folder.path().join("no/such"), every: 1 };
        own.keep(&job(), 7, b"state");
        assert_eq!(own.load(&job()).expect("none"), None);
    }
}
