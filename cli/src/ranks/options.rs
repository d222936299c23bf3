//! The options of a process that is one of several.

use crate::args::{Delaunay, MeshArgs};
use crate::outcome::Failure;
use crate::streams::is_stdin;
use std::path::Path;

/// An option, and whether it was given.
struct Asked {
    option: &'static str,
    is_given: bool,
}

impl Asked {
    fn new(option: &'static str, is_given: bool) -> Self {
        Self { option, is_given }
    }
}

/// Refuses options that a process that is one of several does not have.
fn refused(options: &[Asked], input: &Path) -> Result<(), Failure> {
    if is_stdin(input) {
        let text = "stdin: each process of a job reads the input, which has to be a file";
        return Err(Failure::Usage(text.to_owned()));
    }
    match options.iter().find(|asked| asked.is_given) {
        Some(Asked { option, .. }) => {
            Err(Failure::Usage(format!("{option} is for threads of one process")))
        }
        None => Ok(()),
    }
}

impl Delaunay {
    /// For one of several processes: all check and write their parts, the first one alone reports.
    pub(crate) fn for_ranks(&mut self, is_first: bool) -> Result<(), Failure> {
        let options = [
            Asked::new("--balance", self.balance),
            Asked::new("--tables", self.tables),
            Asked::new("--without", self.without.is_some()),
            Asked::new("--trace", self.trace.is_some()),
        ];
        refused(&options, &self.points)?;
        if !is_first {
            self.json = None;
        }
        Ok(())
    }
}

impl MeshArgs {
    /// For one of several processes: all check and write their parts, the first one alone reports.
    pub(crate) fn for_ranks(&mut self, is_first: bool) -> Result<(), Failure> {
        let options = [
            Asked::new("--workers", self.workers.is_some()),
            Asked::new("--trace", self.trace.is_some()),
        ];
        refused(&options, &self.domain)?;
        if !is_first {
            (self.json, self.preparation.write_defects) = (None, None);
        }
        Ok(())
    }
}
