//! The share of a mesh that is excused, and whether that is little enough to go on.

use crate::outcome::Sliver;
use crate::{RefineError, Refined};

/// The part of the inside that is over a bound, and excused for it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExcusedShare {
    /// Of its tetrahedra.
    pub tets: f64,
    /// Of its volume, rounded.
    pub volume: f64,
    /// Tetrahedra with a dihedral angle below [`ExcusedShare::FLAT`] among the slivers.
    pub flat: usize,
}

impl ExcusedShare {
    /// The share up to which a mesh serves, where nobody says another.
    pub const USUAL: f64 = 0.01;
    /// [`Sliver::FLAT`].
    pub const FLAT: f64 = Sliver::FLAT;
    /// The largest that may be asked for.
    pub const LARGEST: f64 = 0.05;

    /// A share that may be asked for.
    ///
    /// # Errors
    /// [`RefineError::Bound`]: a number that is none, below 0, or above [`Self::LARGEST`].
    pub fn limit(value: f64) -> Result<f64, RefineError> {
        if (0.0..=Self::LARGEST).contains(&value) {
            return Ok(value);
        }
        let limit = format!("it has to be between 0 and {}", Self::LARGEST);
        Err(RefineError::Bound { name: "excused-share", value, limit })
    }

    /// The larger of the two.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.tets.max(self.volume)
    }

    /// Are both at most `limit`, and is no tetrahedron flat?
    #[must_use]
    pub fn is_within(&self, limit: f64) -> bool {
        self.flat == 0 && self.largest() <= limit
    }
}

/// The judgement of a mesh of a domain, in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing is wrong.
    Passed,
    /// It is over its bounds only where that is excused, and there is little of it.
    Excused,
    /// Something is wrong, or too much is excused, or a tetrahedron is flat.
    Failed,
}

impl Verdict {
    /// The verdict on a mesh of which the checker found all (`passed`) or all but excused bounds
    /// (`explained`) as it has to be.
    #[must_use]
    pub fn of(passed: bool, explained: bool, share: &ExcusedShare, limit: f64) -> Self {
        match (passed, explained) {
            (true, _) if share.flat == 0 => Self::Passed,
            (_, true) if share.is_within(limit) => Self::Excused,
            _ => Self::Failed,
        }
    }

    /// Its word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Excused => "excused",
            Self::Failed => "failed",
        }
    }
}

impl Refined {
    /// The share of tetrahedra over a bound in the inside; 0 of none.
    #[must_use]
    pub fn excused_share(&self) -> ExcusedShare {
        let flat = self.slivers.iter().filter(|own| own.angle < ExcusedShare::FLAT).count();
        if self.excuses.is_empty() {
            return ExcusedShare { flat, ..ExcusedShare::default() };
        }
        let volume: f64 = self.excused().iter().map(|excused| excused.volume).sum();
        ExcusedShare {
            tets: self.excuses.len() as f64 / self.num_tets().max(1) as f64,
            volume: volume / self.volume(),
            flat,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_that_may_be_asked_for_is_small() {
        for share in [0.0, ExcusedShare::USUAL, 0.05] {
            assert_eq!(ExcusedShare::limit(share), Ok(share));
        }
        for share in [-0.01, 0.050_001, 1.0, f64::NAN, f64::INFINITY] {
            let error = ExcusedShare::limit(share).expect_err("no share");
            assert!(error.to_string().contains("between 0 and 0.05"), "{error}");
        }
    }

    #[test]
    fn both_shares_have_to_be_small() {
        let share = |tets, volume, flat| ExcusedShare { tets, volume, flat };
        let word = |tets, volume| Verdict::of(false, true, &share(tets, volume, 0), 0.01).name();
        assert_eq!(word(0.01, 0.01), "excused");
        assert_eq!(word(0.011, 0.0), "failed");
        assert_eq!(word(0.0, 0.011), "failed");
        let none = ExcusedShare::default();
        assert_eq!(Verdict::of(true, true, &none, 0.0), Verdict::Passed);
        assert_eq!(Verdict::of(true, true, &share(0.0, 0.0, 1), 0.05), Verdict::Failed);
        assert_eq!(Verdict::of(false, false, &none, 0.05), Verdict::Failed);
    }
}
