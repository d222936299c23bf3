//! Limits of the edges that splitting an item may make near small angles.

/// The shortest edges that splitting an item may make near small angles.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Limit {
    /// The shortest edge: no point that makes none shorter is refused.
    pub least: f64,
    /// Where a tetrahedron is too large, the shortest edge of another kind of point: one whose
    /// edges across a small angle are as short as the angle makes them, and all others longer.
    pub along: Option<f64>,
}

impl Limit {
    /// One limit for all edges.
    #[cfg(test)]
    pub(crate) fn all(least: f64) -> Self {
        Self { least, along: None }
    }

    /// Some part of it.
    pub(crate) fn times(self, part: f64) -> Self {
        Self { least: part * self.least, along: self.along.map(|along| part * along) }
    }

    /// The limit that allows what either of two does.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        let along = [self.along, other.along].into_iter().flatten().reduce(f64::min);
        Self { least: self.least.min(other.least), along }
    }

    /// Does it allow edges that `other`, times a part, does not?
    pub(crate) fn is_below(self, part: f64, other: Self) -> bool {
        let is_below = |along: f64| other.along.is_none_or(|other| along < part * other);
        self.least < part * other.least || self.along.is_some_and(is_below)
    }
}

#[cfg(test)]
mod tests {
    use super::Limit;

    #[test]
    fn limits_are_joined_and_compared_in_both_parts() {
        let (all, sized) = (Limit::all(2.0), Limit { least: 3.0, along: Some(4.0) });
        assert_eq!(all.or(sized), Limit { least: 2.0, along: Some(4.0) });
        assert_eq!(sized.or(all), all.or(sized));
        assert_eq!(sized.times(0.5), Limit { least: 1.5, along: Some(2.0) });
        assert!(sized.is_below(1.0, all), "it allows points of another kind");
        assert!(all.is_below(1.0, sized) && !all.is_below(0.5, sized));
        assert!(!sized.is_below(1.0, sized) && sized.times(0.98).is_below(0.99, sized));
        assert!(!all.or(sized).is_below(1.0, all.or(sized)));
    }
}
