//! Checkpoints of a refinement by processes: a file that the first one writes, in which all have
//! their parts of the mesh and of the work left between two rounds. A job of any size goes on from
//! it, and ends with the mesh that the other one would have made.
//!
//! A first line says whose it is; then come pieces, each after its length in eight bytes, and the
//! hash of all that.

use crate::binding::{digits, sha256};
use crate::console;
use crate::outcome::Failure;
use ltbw::io;
use ltbw::refining::Pieces;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io::{Error, ErrorKind, Write};
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
}

/// The version of this format.
const FORMAT: u32 = 2;

/// The digits of a hash.
const DIGITS: usize = 64;

/// The reason for which nobody goes on from a file.
enum Unfit {
    Damaged(&'static str),
    Input,
    Other(&'static str),
}

impl Checkpoint {
    /// The pieces of the state to go on from, if the file is there.
    pub(super) fn load(&self, job: &Job) -> Result<Option<Vec<Vec<u8>>>, Failure> {
        let bytes = match std::fs::read(&self.path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(self.damaged(&error.to_string())),
        };
        match open(&bytes, job) {
            Ok((rounds, pieces)) => {
                let name = self.path.display();
                console::people(&format!("note: {name}: goes on after {rounds} rounds"));
                Ok(Some(pieces))
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
    pub(super) fn keep(&self, job: &Job, rounds: u64, pieces: &mut Pieces<'_>) {
        let write = |out: &mut dyn Write| seal(out, job, rounds, pieces);
        if let Err(error) = io::write_with(&self.path, write) {
            console::aloud(&format!("note: no checkpoint after {rounds} rounds: {error}"));
        }
    }
}

/// Bytes on their way to a file, and the hash of them all.
struct Hashed<'o> {
    out: &'o mut dyn Write,
    hash: Sha256,
}

impl Hashed<'_> {
    fn put(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.hash.update(bytes);
        self.out.write_all(bytes)
    }
}

/// Writes a checkpoint.
fn seal(out: &mut dyn Write, job: &Job, rounds: u64, pieces: &mut Pieces<'_>) -> Result<(), Error> {
    let mut out = Hashed { out, hash: Sha256::new() };
    let mut head = serde_json::to_vec(&Head { ltbw_checkpoint: FORMAT, job: job.clone(), rounds })?;
    head.push(b'\n');
    out.put(&head)?;
    for piece in pieces {
        let piece = piece.map_err(Error::other)?;
        out.put(&(piece.len() as u64).to_le_bytes())?;
        out.put(&piece)?;
    }
    let hash = digits(&out.hash.finalize());
    out.out.write_all(hash.as_bytes())
}

/// The rounds before a state, and its pieces, if it is of this job and whole.
fn open(bytes: &[u8], job: &Job) -> Result<(u64, Vec<Vec<u8>>), Unfit> {
    let end = bytes.iter().position(|&byte| byte == b'\n');
    let end = end.ok_or(Unfit::Damaged("it has no first line"))?;
    let head: Head = serde_json::from_slice(&bytes[..end])
        .map_err(|_| Unfit::Damaged("its first line makes no sense"))?;
    match () {
        () if head.ltbw_checkpoint != FORMAT || head.job.build != job.build => {
            return Err(Unfit::Other("build"));
        }
        () if head.job.words != job.words => return Err(Unfit::Other("command line")),
        () if head.job.input != job.input => return Err(Unfit::Input),
        () => {}
    }
    let hashed = bytes.len().checked_sub(DIGITS).filter(|hashed| *hashed > end);
    let (all, hash) = bytes.split_at(hashed.ok_or(Unfit::Damaged("it has no hash"))?);
    if sha256(all).as_bytes() != hash {
        return Err(Unfit::Damaged("its hash is not what it says"));
    }
    let (mut pieces, mut rest) = (Vec::new(), &all[end + 1..]);
    while !rest.is_empty() {
        let piece = rest.split_first_chunk().and_then(|(length, after)| {
            after.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)
        });
        let (piece, after) = piece.ok_or(Unfit::Damaged("it ends within a piece"))?;
        pieces.push(piece.to_vec());
        rest = after;
    }
    Ok((head.rounds, pieces))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltbw::protocol::WorkerId;
    use ltbw::team::TeamError;

    fn job() -> Job {
        let [build, words, input] = ["a", "b", "c"].map(str::to_owned);
        Job { build, words, input }
    }

    #[test]
    fn a_checkpoint_is_that_of_its_job_or_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let own = Checkpoint { path: folder.path().join("c"), every: 1 };
        assert_eq!(own.load(&job()).expect("none"), None);
        let all = vec![b"state\n".to_vec(), Vec::new(), b"of it".to_vec()];
        own.keep(&job(), 7, &mut all.clone().into_iter().map(Ok));
        assert_eq!(own.load(&job()).expect("a state"), Some(all.clone()));
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
        own.keep(&job(), 7, &mut [Ok(vec![1])].into_iter());
        assert_eq!(own.load(&job()).expect("none"), None);
        let own = Checkpoint { path: folder.path().join("c"), every: 1 };
        own.keep(&job(), 7, &mut [Ok(vec![1])].into_iter());
        // Another process is lost as its piece is to arrive.
        let lost = Err(TeamError::Failed(WorkerId::new(1)));
        own.keep(&job(), 9, &mut [Ok(vec![2]), lost].into_iter());
        assert_eq!(own.load(&job()).expect("the one before"), Some(vec![vec![1]]));
    }
}
