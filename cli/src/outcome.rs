//! Exit codes, and errors that print as one line.

use ltbw::domain::{PrepareError, SkinError};
use ltbw::io::IoError;
use ltbw::refine::{BackgroundError, RefineError};
use ltbw::{BuildError, PointError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The exit codes of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Exit {
    /// Done and checked; what is excused is little.
    Done = 0,
    /// `check` found a defect in the file that it was given; or a mesh was made, but more of it
    /// than may be is over a bound (the report says where and why).
    Defect = 1,
    /// The command line makes no sense.
    Usage = 2,
    /// The input was rejected.
    Input = 3,
    /// Cancelled, or the budget of points was used up; the mesh so far, if any, was written.
    Stopped = 4,
    /// The checker found a defect in our own output; nothing was written.
    OwnDefect = 5,
    /// An output could not be written; nothing is left under its name.
    Output = 6,
    /// The machine lacks memory or threads; nothing was written.
    Machine = 7,
}

/// Why a command failed. Prints as one line.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// The command line makes no sense.
    #[error("{0}")]
    Usage(String),
    /// An input file could not be read.
    #[error(transparent)]
    Read(IoError),
    /// The points are not a point set.
    #[error("{}: {error}", show(path))]
    Points {
        /// The input file.
        path: PathBuf,
        /// The reason.
        error: PointError,
    },
    /// The domain cannot be used.
    #[error("{}: {error}", show(path))]
    Domain {
        /// The input file.
        path: PathBuf,
        /// Why.
        error: PrepareError,
    },
    /// The mesh cannot be gone on with.
    #[error("{}: {error}{help}", show(path))]
    Mesh {
        /// The input file.
        path: PathBuf,
        /// Why.
        error: SkinError,
        /// The option that helps, in words, if one does.
        help: &'static str,
    },
    /// A report that certifies nothing.
    #[error("{}: {why}", show(path))]
    Report {
        /// The file.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// The domain has no mesh.
    #[error("{}: {error}", show(path))]
    Refine {
        /// The input file.
        path: PathBuf,
        /// Why.
        error: RefineError,
    },
    /// Edge lengths that cannot be used.
    #[error("{}: {error}", show(path))]
    Sizes {
        /// The file with the lengths.
        path: PathBuf,
        /// Why.
        error: BackgroundError,
    },
    /// The points have no mesh.
    #[error("{}: {error}", show(path))]
    Build {
        /// The input file.
        path: PathBuf,
        /// Why.
        error: BuildError,
    },
    /// Points that cannot be removed.
    #[error("{}: {why}", show(path))]
    Without {
        /// The file that names them.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// An output file could not be written.
    #[error(transparent)]
    Write(IoError),
    /// The machine lacks memory or threads.
    #[error("{0}")]
    Machine(String),
    /// Processes that mesh together have agreed to end, with this exit code.
    #[cfg(feature = "wire")]
    #[error("{why}")]
    Agreed {
        /// The code.
        code: u8,
        /// Why the first one of them refuses that does.
        why: String,
    },
    /// Something that must not happen.
    #[error("{0}")]
    Other(String),
}

impl Failure {
    /// The number of its exit code.
    pub(crate) fn code(&self) -> u8 {
        match self {
            #[cfg(feature = "wire")]
            Failure::Agreed { code, .. } => *code,
            other => other.exit() as u8,
        }
    }

    /// Is it the same whoever reads the input?
    #[cfg(feature = "wire")]
    pub(crate) fn is_about_input(&self) -> bool {
        matches!(self, Failure::Read(IoError::Parse { .. }) | Failure::Points { .. })
    }

    /// The exit code of this failure.
    fn exit(&self) -> Exit {
        match self {
            #[cfg(feature = "wire")]
            Failure::Agreed { .. } => Exit::Usage,
            Failure::Machine(_)
            | Failure::Build { error: BuildError::Memory(_), .. }
            | Failure::Refine { error: RefineError::Build(BuildError::Memory(_)), .. } => {
                Exit::Machine
            }
            Failure::Read(IoError::Read { source, .. })
            | Failure::Write(IoError::Write { source, .. })
                if source.kind() == ErrorKind::OutOfMemory =>
            {
                Exit::Machine
            }
            Failure::Write(IoError::Cancelled { .. }) => Exit::Stopped,
            Failure::Usage(_) => Exit::Usage,
            Failure::Write(
                IoError::UnknownFormat { .. }
                | IoError::WrongKind { .. }
                | IoError::ReadOnly { .. }
                | IoError::SeveralFiles { .. },
            ) => Exit::Usage,
            Failure::Write(_) | Failure::Other(_) => Exit::Output,
            Failure::Build { error: BuildError::Cancelled, .. }
            | Failure::Refine { error: RefineError::Cancelled, .. } => Exit::Stopped,
            Failure::Refine { error: RefineError::Bound { .. }, .. } => Exit::Usage,
            Failure::Domain {
                error:
                    PrepareError::Tolerance { .. }
                    | PrepareError::Simplify { .. }
                    | PrepareError::SimplifyPoints { .. },
                ..
            }
            | Failure::Mesh {
                error: SkinError::Boundary(PrepareError::Tolerance { .. }), ..
            } => Exit::Usage,
            Failure::Read(_)
            | Failure::Points { .. }
            | Failure::Domain { .. }
            | Failure::Mesh { .. }
            | Failure::Report { .. }
            | Failure::Refine { .. }
            | Failure::Sizes { .. }
            | Failure::Build { .. }
            | Failure::Without { .. } => Exit::Input,
        }
    }
}

/// Seconds for people: two digits after the point, four below a hundredth, `0` for none.
pub(crate) fn seconds(time: f64) -> String {
    match time {
        t if t >= 0.01 => format!("{t:.2}"),
        t if t > 0.0 => format!("{:.4}", t.max(0.0001)),
        _ => "0".to_owned(),
    }
}

/// A path as it can stand inside a one-line message.
pub(crate) fn show(path: &Path) -> String {
    path.to_string_lossy().chars().map(|c| if c.is_control() { '?' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::seconds;

    #[test]
    fn short_times_are_told_as_well_as_long_ones() {
        let times = [12.345, 0.01, 0.0042, 0.000_04, 0.0].map(seconds);
        assert_eq!(times, ["12.35", "0.01", "0.0042", "0.0001", "0"]);
    }
}
