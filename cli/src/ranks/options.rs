//! The options of a process that is one of several: the first one alone checks and writes.

use crate::args::{Delaunay, Depth, MeshArgs};
use crate::outcome::Failure;
use crate::streams::is_stdin;
use crate::workers::Mode;
use std::path::Path;

/// Refuses options that a process that is one of several does not have.
fn refused(options: &[(&str, bool)], input: &Path) -> Result<(), Failure> {
    if is_stdin(input) {
        let text = "stdin: each process of a job reads the input, which has to be a file";
        return Err(Failure::Usage(text.to_owned()));
    }
    match options.iter().find(|(_, is_asked)| *is_asked) {
        Some((option, _)) => Err(Failure::Usage(format!("{option} is for threads of one process"))),
        None => Ok(()),
    }
}

impl Delaunay {
    /// For one of several processes: the first one alone checks and writes.
    pub(crate) fn for_ranks(&mut self, is_first: bool) -> Result<(), Failure> {
        let options = [
            ("--balance", self.balance),
            ("--tables", self.tables),
            ("--trace", self.trace.is_some()),
        ];
        refused(&options, &self.points)?;
        if !is_first {
            (self.json, self.page, self.check) = (None, None, Depth::Off);
            self.output.clear();
            self.streams.keep_input(&self.points);
        }
        Ok(())
    }
}

impl MeshArgs {
    /// For one of several processes: the first one alone checks and writes.
    pub(crate) fn for_ranks(&mut self, is_first: bool) -> Result<(), Failure> {
        let options = [
            ("--workers", self.workers.is_some()),
            ("--mode", self.mode != Mode::Rounds),
            ("--trace", self.trace.is_some()),
        ];
        refused(&options, &self.domain)?;
        if !is_first {
            (self.json, self.page, self.check) = (None, None, Depth::Off);
            (self.histogram, self.preparation.write_defects) = (None, None);
            self.output.clear();
            self.streams.keep_input(&self.domain);
        }
        Ok(())
    }
}
