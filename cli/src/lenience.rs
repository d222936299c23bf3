//! The things that are let pass: excused tetrahedra, if they are few, and repairs of the input.

use crate::outcome::Failure;
use ltbw::domain::Prepared;
use ltbw::refine::ExcusedShare;
use std::path::Path;

/// Options of `mesh` that say when its result serves.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct Lenience {
    /// Exit code 3 for a repair of the input, 1 for anything excused
    #[arg(long)]
    #[arg(hide_short_help = true)]
    pub(crate) strict: bool,
    /// Largest share that may be excused, up to 0.05 [default: 0.01]
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    pub(crate) excused_share: Option<f64>,
}

/// A share that may be asked for.
fn share(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    ExcusedShare::limit(value).map_err(|e| e.to_string())
}

impl Lenience {
    /// The share that may be excused.
    pub(crate) fn share(&self) -> f64 {
        match self.strict {
            true => 0.0,
            false => self.excused_share.unwrap_or(ExcusedShare::USUAL),
        }
    }

    /// Refuses a domain that is not meshed as it was given, if that is asked for. To move vertices
    /// to the lattice is no repair: `--exact-input` refuses that.
    pub(crate) fn admit(&self, name: &Path, ready: &Prepared) -> Result<(), Failure> {
        if !self.strict || ready.repairs.is_empty() {
            return Ok(());
        }
        let notes = ready.repairs.notes().join("; ");
        Err(Failure::Repaired { path: name.to_owned(), notes })
    }
}
