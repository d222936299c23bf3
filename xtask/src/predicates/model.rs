//! The parts of a description ([`super::describe`] holds the descriptions themselves).

use super::expression::Expression;

/// A predicate with a floating-point filter: a value, computed from coordinate differences in one
/// order of evaluation, and a bound of its error.
#[derive(Clone, Debug)]
pub(crate) struct Predicate<'a> {
    /// Its name in Rust and Coq.
    pub(crate) name: &'static str,
    /// Documentation of the filters: what a positive sign says.
    pub(crate) about: &'static str,
    /// The points, in the order of the arguments.
    pub(crate) points: &'static [&'static str],
    /// Parameters after the points: exact non-negative numbers.
    pub(crate) parameters: &'static [&'static str],
    /// Differences of points, each named by minuend and subtrahend: `ad` is a - d.
    pub(crate) vectors: &'static [&'static str],
    /// The way in which the sizes of the differences are measured.
    pub(crate) extents: Extents,
    /// Named intermediate values in the order of evaluation; the last one is the value.
    pub(crate) steps: &'static [Step],
    /// Is the sign of the predicate the opposite of the value's?
    pub(crate) negate: bool,
    /// The factors of the error bound: name and value.
    pub(crate) constants: &'a [(&'static str, Constant)],
    /// The error bound, from extents, parameters and constants, in steps like the value's.
    pub(crate) bound: &'static [(&'static str, &'static str)],
    /// The guard of the filter for any coordinates.
    pub(crate) guard: Guard,
    /// A filter without guard for the exactness window as well?
    pub(crate) window: bool,
    /// The number of steps of a lattice up to which differences are decided without error, as an
    /// exponent of two, if there is such a filter.
    pub(crate) lattice_bits: Option<u32>,
    /// Is the value also computed in integers of fixed width, by the exact stages?
    pub(crate) integers: bool,
}

/// A named intermediate value.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub(crate) name: &'static str,
    pub(crate) text: &'static str,
    /// Which extent bounds the differences in it?
    pub(crate) measure: Measure,
}

/// Which extent bounds a difference?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Measure {
    /// The extent of its own axis.
    Axis,
    /// The largest one.
    Largest,
}

/// A way in which the sizes of the differences are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extents {
    /// mx, my, mz for the three axes; m is the largest of them.
    Space,
    /// mi, mj for the two axes of a projection, differences along these alone.
    Plane,
    /// mi, mj for the two axes of a projection, and m, the largest over all three axes.
    PlaneInSpace,
    /// m alone, the largest over all axes.
    One,
}

/// A constant of a bound: this many sixteenths of the unit roundoff u.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Constant(pub(crate) u64);

/// The extents that a filter takes lie in (2^low, 2^high), its parameters likewise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Guard {
    pub(crate) low: i32,
    pub(crate) high: i32,
    pub(crate) parameter_low: i32,
    pub(crate) parameter_high: i32,
}

impl Constant {
    /// In units of u, as Rust writes an `f64`.
    pub(crate) fn in_roundoffs(self) -> String {
        format!("{:?}", self.0 as f64 / 16.0)
    }
}

impl Step {
    pub(crate) fn expression(&self) -> Result<Expression, String> {
        Expression::parse(self.text)
    }
}

/// The axes that a name may end in.
const AXES: &[u8] = b"xyzij";

impl Predicate<'_> {
    /// The vector and the axis of the difference `name`, `adx`; `None` if it is no difference.
    pub(crate) fn difference<'a>(&self, name: &'a str) -> Option<(&'a str, char)> {
        let axis = *name.as_bytes().last()?;
        let vector = &name[..name.len() - 1];
        (AXES.contains(&axis) && self.vectors.contains(&vector)).then_some((vector, axis as char))
    }

    /// The axes that occur in the steps, in the order of [`AXES`].
    pub(crate) fn axes(&self) -> Result<Vec<char>, String> {
        let mut seen = Vec::new();
        for step in self.steps {
            let expression = step.expression()?;
            let axes = expression.names();
            seen.extend(axes.iter().filter_map(|name| self.difference(name)).map(|(_, axis)| axis));
        }
        Ok(AXES.iter().map(|&axis| axis as char).filter(|axis| seen.contains(axis)).collect())
    }

    /// The name of the value: the last step.
    pub(crate) fn value(&self) -> &'static str {
        self.steps.last().map_or("", |step| step.name)
    }

    /// The names of the extents that a filter computes.
    pub(crate) fn extent_names(&self) -> &'static [&'static str] {
        match self.extents {
            Extents::Space => &["mx", "my", "mz"],
            Extents::Plane => &["mi", "mj"],
            Extents::PlaneInSpace => &["mi", "mj", "m"],
            Extents::One => &["m"],
        }
    }

    /// Does the bound use the largest extent of [`Extents::Space`]?
    pub(crate) fn bound_uses_largest(&self) -> Result<bool, String> {
        let mut uses = false;
        for (_, text) in self.bound {
            uses |= Expression::parse(text)?.names().contains(&"m");
        }
        Ok(uses && self.extents == Extents::Space)
    }
}
