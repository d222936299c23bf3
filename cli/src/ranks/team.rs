//! A process as one of a team: how it begins, agrees with the others, and ends.

use super::checkpoint::{Checkpoint, Job};
use crate::args::{Args, Command, Refine};
use crate::binding::sha256;
use crate::others::{Apart, Ranks, Work, of_rank};
use crate::outcome::{Exit, Failure};
use crate::workers::{Made, Mode};
use crate::{console, dispatch, machine, refusal};
use clap::Parser;
use ltbw::distributed::{self, Gathered, Hashed, Joined, Part, Points, Slice, SliceError};
use ltbw::domain::{Prepared, Thickness};
use ltbw::io::{Border, Piece};
use ltbw::protocol::WorkerId;
use ltbw::refine::{Refined, Refiner};
use ltbw::refining::{
    Checkpoints, Pieces, RefineError, TeamEnd, Wishes, domain_on_team, rounds_on_team,
};
use ltbw::team::{LetterFigures, Team, TeamError};
use ltbw::threads::{BuiltPart, RunError};
use ltbw::wire::{VERSION, WireError};
use ltbw::{Builder, Point};
use ltbw_verify as verify;
use serde::{Deserialize, Serialize};
use std::cell::{Cell, RefCell};
use std::ffi::OsString;

/// The end of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// As all others, with this exit code.
    Together(u8),
    /// With this exit code while others may wait for it: the job has to end.
    Alone(u8),
}

/// The word of a process before the work.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Word {
    /// It has read an input with this fingerprint.
    Ready(String),
    /// It refuses, with this exit code and for this reason.
    Refuses { code: u8, why: String },
}

/// A process as it introduces itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Hello {
    /// The version of the letters and of the program, and the hash of its file.
    build: String,
    words: Vec<String>,
}

/// The team, and how far it has come.
struct Member<'t> {
    team: RefCell<&'t mut Team>,
    /// All have agreed to begin, or not to.
    has_agreed: Cell<bool>,
    /// The team is not one any more.
    is_broken: Cell<bool>,
    kept: Option<Kept>,
}

/// The checkpoints of a job, at the first process.
struct Kept {
    file: Checkpoint,
    /// The job. What it has read is known when all have agreed.
    job: RefCell<Job>,
    /// The state to go on from, in pieces.
    from: RefCell<Option<Vec<Vec<u8>>>>,
}

impl Kept {
    fn of(file: Checkpoint, words: &[OsString]) -> Self {
        let Hello { build, words } = hello(words);
        let (words, input) = (sha256(words.join("\0").as_bytes()), String::new());
        let job = RefCell::new(Job { build, words, input });
        Self { file, job, from: RefCell::default() }
    }
}

impl Member<'_> {
    /// Tells this process's word, and hears all: each finds the same, the first refusal if there
    /// is one.
    fn speak(&self, own: &Word) -> Result<(), Failure> {
        self.has_agreed.set(true);
        let all = self.team.borrow_mut().gather_all(own).map_err(|error| self.lost(&error))?;
        let refusal = (0..).zip(&all).find_map(|(rank, word): (u32, _)| match word {
            Word::Ready(_) => None,
            Word::Refuses { code, why } => {
                Some(Failure::Agreed { code: *code, why: of_rank(rank, why) })
            }
        });
        let other = all.iter().position(|word| *word != all[0]);
        match (refusal, other) {
            (Some(refusal), _) => Err(refusal),
            (None, Some(rank)) => {
                let why = format!("rank {rank} has read another input than rank 0");
                Err(Failure::Agreed { code: Exit::Input as u8, why })
            }
            (None, None) => Ok(()),
        }
    }

    /// The team has failed.
    fn lost(&self, error: &TeamError) -> Failure {
        self.is_broken.set(true);
        Failure::Other(error.to_string())
    }
}

impl Ranks for Member<'_> {
    fn size(&self) -> u32 {
        self.team.borrow().size()
    }

    fn agree(&self, fingerprint: String) -> Result<(), Failure> {
        if let Some(Kept { file, job, from }) = &self.kept {
            job.borrow_mut().input.clone_from(&fingerprint);
            *from.borrow_mut() = file.load(&job.borrow())?;
        }
        self.speak(&Word::Ready(fingerprint))
    }

    fn apart(&self) -> &dyn Apart {
        self
    }
}

impl Apart for Member<'_> {
    fn size(&self) -> u32 {
        self.team.borrow().size()
    }

    fn me(&self) -> u32 {
        self.team.borrow().me().number()
    }

    fn tell_all(&self, own: Vec<u8>) -> Result<Vec<Vec<u8>>, Failure> {
        self.team.borrow_mut().gather_all(&own).map_err(|error| self.lost(&error))
    }

    fn deal(&self, whole: Option<Points>) -> Result<Points, Failure> {
        let own = distributed::deal(*self.team.borrow_mut(), whole);
        own.map_err(|error| self.lost(&error))
    }

    fn slice(&self, points: Vec<Point>) -> Result<Result<Slice, SliceError>, Failure> {
        match Slice::new(*self.team.borrow_mut(), points) {
            Err(SliceError::Team(error)) => Err(self.lost(&error)),
            other => Ok(other),
        }
    }

    fn thickness(&self, slice: &Slice) -> Result<Option<Thickness>, Failure> {
        let found = distributed::thickness(*self.team.borrow_mut(), slice);
        found.map_err(|error| self.lost(&error))
    }

    fn build(&self, builder: &Builder<'_>, slice: &Slice) -> Result<BuiltPart, RunError> {
        let built = builder.build_on(*self.team.borrow_mut(), slice);
        // The points are the same everywhere.
        let is_lost = |error: &RunError| !matches!(error, RunError::Build(_));
        self.is_broken.set(built.as_ref().is_err_and(is_lost));
        built
    }

    fn refine(
        &self,
        refiner: &Refiner<'_>,
        ready: &Prepared,
        Work { parallel, token, mode }: Work<'_>,
        wishes: Wishes<'_>,
    ) -> Result<TeamEnd<(Refined, Made)>, RefineError> {
        let from = self.kept.as_ref().and_then(|own| own.from.take());
        let keep = |rounds: u64, pieces: &mut Pieces<'_>| {
            if let Some(Kept { file, job, .. }) = &self.kept {
                file.keep(&job.borrow(), rounds, pieces);
            }
        };
        let checkpoints = Checkpoints {
            every: self.kept.as_ref().map_or(0, |own| own.file.every),
            from: from.as_deref(),
            keep: Some(&keep),
        };
        let (whole, threads) = ((&ready.domain, &ready.lattice), (parallel, token));
        let mut team = self.team.borrow_mut();
        let refined = match mode {
            Mode::Rounds => {
                let wishes = Wishes { checkpoints, ..wishes };
                let end = rounds_on_team(refiner, whole, threads, *team, wishes);
                end.map(|end| end.map(Made::by_rounds))
            }
            Mode::Async => {
                let end = domain_on_team(refiner, whole, threads, *team, wishes);
                end.map(|end| end.map(Made::freely))
            }
        };
        let is_lost = |error: &RefineError| {
            !matches!(error, RefineError::Build(_) | RefineError::Domain(_) | RefineError::Range)
        };
        self.is_broken.set(refined.as_ref().is_err_and(is_lost));
        refined
    }

    fn hash(&self, part: &Part) -> Result<Hashed, Failure> {
        let hashed = distributed::hash(*self.team.borrow_mut(), part);
        hashed.map_err(|error| self.lost(&error))
    }

    fn check(
        &self,
        part: &verify::Part<'_>,
        options: &verify::Options,
    ) -> Result<verify::Report, Failure> {
        let report = verify::check_parted(&mut Judge(*self.team.borrow_mut()), part, options);
        report.map_err(|error| self.lost(&error))
    }

    fn conforms(
        &self,
        part: &verify::DomainPart<'_>,
        plc: &verify::Plc,
        limits: &verify::Limits,
        options: &verify::Options,
    ) -> Result<verify::Conformity, Failure> {
        let mut team = self.team.borrow_mut();
        let found = verify::conforms_parted(&mut Judge(*team), part, plc, limits, options);
        found.map_err(|error| self.lost(&error))
    }

    fn border(&self, piece: &Piece) -> Result<Border, Failure> {
        let border = distributed::border(*self.team.borrow_mut(), piece);
        border.map_err(|error| self.lost(&error))
    }

    fn gather(&self, part: &Part, points: usize) -> Result<Option<Gathered>, Failure> {
        let gathered = distributed::gather(*self.team.borrow_mut(), part, points);
        gathered.map_err(|error| self.lost(&error))
    }

    fn join(&self, piece: Piece, beside: Part, vertices: u64) -> Result<Option<Joined>, Failure> {
        let joined = distributed::join(*self.team.borrow_mut(), piece, beside, vertices);
        joined.map_err(|error| self.lost(&error))
    }

    fn tags(
        &self,
        slice: &Slice,
        own: Option<&[i64]>,
        numbers: &[u32],
    ) -> Result<Option<Vec<i64>>, Failure> {
        let tags = distributed::tags(*self.team.borrow_mut(), slice, own, numbers);
        tags.map_err(|error| self.lost(&error))
    }

    fn gather_points(
        &self,
        slice: &Slice,
        tags: Option<&[i64]>,
    ) -> Result<Option<Points>, Failure> {
        let points = distributed::gather_points(*self.team.borrow_mut(), slice, tags);
        points.map_err(|error| self.lost(&error))
    }
}

/// The way of the checker, which knows nothing of teams.
#[derive(Debug)]
pub struct Judge<'t>(pub &'t mut Team);

impl verify::Exchange for Judge<'_> {
    type Error = TeamError;

    fn me(&self) -> usize {
        self.0.me().index()
    }

    fn members(&self) -> usize {
        self.0.size() as usize
    }

    fn exchange(&mut self, parts: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>, TeamError> {
        self.0.exchange(parts)
    }

    fn in_turn(
        &mut self,
        first: Vec<u8>,
        own: &mut dyn FnMut(Vec<u8>) -> Vec<u8>,
    ) -> Result<Vec<u8>, TeamError> {
        self.0.in_turn(first, |before| Ok(own(before)))
    }

    fn nonsense(&self, from: usize, what: &'static str) -> TeamError {
        let (from, reason) = (WorkerId::new(from as u32), what.to_owned());
        WireError { from, at: 0, length: 0, reason }.into()
    }
}

/// This process as it introduces itself.
fn hello(words: &[OsString]) -> Hello {
    let program = std::env::current_exe().and_then(std::fs::read);
    let program = program.map_or_else(|error| error.to_string(), |bytes| sha256(&bytes));
    let build = format!("{VERSION} {} {program}", env!("CARGO_PKG_VERSION"));
    let words = words.iter().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    Hello { build, words }
}

/// Finds out whether all processes are of one build, and have one command line.
fn introduce(team: &mut Team, words: &[OsString]) -> Result<(), Failure> {
    let other = |rank: usize, what: &str| Failure::Agreed {
        code: Exit::Usage as u8,
        why: format!("rank {rank} has another {what} than rank 0"),
    };
    let all = match team.gather_all(&hello(words)) {
        Ok(all) => all,
        // Another build may introduce itself in another way.
        Err(TeamError::Wire(error)) => return Err(other(error.from.index(), "build")),
        Err(error) => return Err(Failure::Other(error.to_string())),
    };
    let find = |differs: fn(&Hello, &Hello) -> bool| all.iter().position(|h| differs(h, &all[0]));
    if let Some(rank) = find(|a, b| a.build != b.build) {
        return Err(other(rank, "build"));
    }
    match find(|a, b| a.words != b.words) {
        Some(rank) => Err(other(rank, "command line")),
        None => Ok(()),
    }
}

/// Runs the program on the command line of this process, as one of a team. The checkpoints of the
/// first one count.
pub fn run(team: &mut Team, checkpoint: Option<Checkpoint>) -> Ended {
    let words: Vec<OsString> = std::env::args_os().collect();
    let is_first = team.is_first();
    if let Err(failure) = machine::watch().and_then(|()| introduce(team, &words)) {
        return match &failure {
            Failure::Agreed { code, .. } => {
                tell(is_first, &failure);
                Ended::Together(*code)
            }
            _ => alone(team, &failure),
        };
    }
    let (has_agreed, is_broken) = Default::default();
    let kept = checkpoint.filter(|_| is_first).map(|file| Kept::of(file, &words));
    let member = Member { team: RefCell::new(team), has_agreed, is_broken, kept };
    let result = match Args::try_parse_from(&words) {
        Ok(args) => begin(args, &member, is_first),
        // All have the same words.
        Err(error) => {
            let code = if is_first { refusal::explain(&error, &words) } else { Ok(Exit::Usage) };
            member.has_agreed.set(true);
            code
        }
    };
    let result = match result {
        Err(failure) if !member.has_agreed.get() => {
            let (code, why) = (failure.code(), failure.to_string());
            member.speak(&Word::Refuses { code, why }).map(|()| Exit::Done)
        }
        other => other,
    };
    let (is_broken, team) = (member.is_broken.get(), member.team.into_inner());
    let code = match &result {
        Ok(exit) => *exit as u8,
        Err(failure) if is_broken => return alone(team, failure),
        Err(failure) => {
            tell(is_first, failure);
            failure.code()
        }
    };
    if let Err(error) = print_letters(team) {
        return alone(team, &Failure::Other(error.to_string()));
    }
    // The first one's counts: the others end when it has.
    match team.tell_value(is_first.then_some(code)) {
        Ok(code) => Ended::Together(code),
        Err(error) => alone(team, &Failure::Other(error.to_string())),
    }
}

/// Says for people what processes have sent each other.
fn print_letters(team: &mut Team) -> Result<(), TeamError> {
    let mut sum = LetterFigures::default();
    let own = team.figures();
    team.gather_values(&own)?.into_iter().flatten().for_each(|own| sum.add(&own));
    let LetterFigures { messages, letters, bytes } = sum;
    if letters > 0 && team.is_first() {
        let size = team.size();
        console::people(&format!(
            "letters   {letters} of {size} processes, with {messages} messages in {bytes} bytes"
        ));
    }
    Ok(())
}

/// Understands the command, and runs it.
fn begin(mut args: Args, member: &Member<'_>, is_first: bool) -> Result<Exit, Failure> {
    match &mut args.command {
        Command::Delaunay(_) if member.kept.is_some() => {
            let text =
                "LTBW_MPI_CHECKPOINT is for domains: the mesh of points is that of its input";
            return Err(Failure::Usage(text.to_owned()));
        }
        Command::Delaunay(own) => own.for_ranks(is_first)?,
        Command::Mesh(own) | Command::Refine(Refine { mesh: own, .. }) => {
            if own.mode == Mode::Async && member.kept.is_some() {
                let text = "LTBW_MPI_CHECKPOINT is for rounds: --mode async has none";
                return Err(Failure::Usage(text.to_owned()));
            }
            own.for_ranks(is_first)?;
        }
        _ => {
            let text = "the processes of a job have two commands, delaunay and mesh";
            return Err(Failure::Usage(text.to_owned()));
        }
    }
    if !is_first {
        args.quiet = true;
        console::be_silent();
    }
    dispatch(args, None, Some(member))
}

/// Says why it ends: once, since all end for this reason.
fn tell(is_first: bool, failure: &Failure) {
    if is_first {
        console::people(&format!("ltbw: {failure}"));
    }
}

/// Says why this process ends, while others may wait for it.
fn alone(team: &Team, failure: &Failure) -> Ended {
    console::aloud(&format!("ltbw: rank {}: {failure}", team.me().number()));
    Ended::Alone(failure.code())
}
