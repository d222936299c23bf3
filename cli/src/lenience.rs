//! The excused tetrahedra that are let pass, if they are few.

use ltbw::refine::ExcusedShare;

/// Options of `mesh` that say when its result serves.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct Lenience {
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
    /// The share that may be excused: nothing where all is to be `strict`.
    pub(crate) fn share(&self, strict: bool) -> f64 {
        match strict {
            true => 0.0,
            false => self.excused_share.unwrap_or(ExcusedShare::USUAL),
        }
    }
}
