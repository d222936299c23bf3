//! A domain as it is given, and the tolerance within which facets are taken for coplanar there.

use crate::prepare::LARGEST_TOLERANCE;
use crate::{Domain, FEATURE_ANGLE, Parts, PrepareOptions, Prepared};
use ltbw_exact::Point;
use std::fmt::Write;

/// A domain as it is given: a [`Domain`], or the file that it was read from.
pub trait Given {
    /// The domain itself.
    fn domain(&self) -> &Domain;

    /// Are its facets an oriented surface, which says itself what is inside? So they are in formats
    /// without hole points.
    fn is_surface(&self) -> bool;

    /// The distance within which neighbouring facets are taken for coplanar where nobody asks for
    /// one, in the library as in the program and the bindings: [`usual_tolerance`] of a surface, 0
    /// of another domain, and of exact input.
    fn flat_tolerance(&self, ready: &Prepared, options: &PrepareOptions) -> f64 {
        match self.is_surface() && !options.exact_input {
            true => usual_tolerance(self.domain(), &ready.domain),
            false => 0.0,
        }
    }

    /// The smooth parts of a domain whose facets have no markers, for a feature angle in degrees:
    /// `None` for what is usual, [`FEATURE_ANGLE`] of a surface, and 0, which parts nothing, of
    /// another domain.
    fn smooth_parts(
        &self,
        ready: &Prepared,
        degrees: Option<f64>,
        flat_tolerance: f64,
    ) -> Option<Parts> {
        let usual = if self.is_surface() { FEATURE_ANGLE } else { 0.0 };
        let degrees = degrees.unwrap_or(usual);
        let is_plain = ready.domain.facets.iter().all(|facet| facet.marker == 0);
        (degrees > 0.0 && is_plain).then(|| Parts::smooth(ready, degrees, flat_tolerance))
    }
}

/// A domain that is no file: its facets need not be oriented.
impl Given for Domain {
    fn domain(&self) -> &Domain {
        self
    }

    fn is_surface(&self) -> bool {
        false
    }
}

/// The largest tolerance within which facets of a domain may be taken for coplanar: 2^-10 of the
/// diagonal.
pub fn largest_tolerance(domain: &Domain) -> f64 {
    LARGEST_TOLERANCE * domain.diagonal()
}

/// The tolerance within which the triangles of a surface are usually taken for coplanar: 2^-22 of
/// the diagonal, or what its numbers can tell, if that is more: two steps of the largest coordinate
/// where all are single-precision numbers, two units of the last decimal where they are text.
/// `read` is the surface as its file has it, `ready` as it is to be meshed.
pub fn usual_tolerance(read: &Domain, ready: &Domain) -> f64 {
    let (read, _) = read.near();
    let own = rounding_of(&read);
    let digits = Digits::of(&read.vertices);
    let told = if is_single(&read.vertices, digits.most) {
        let numbers = read.vertices.iter().flatten();
        let largest = numbers.fold(0.0, |most: f64, c| most.max(c.abs())) as f32;
        f64::from(largest.next_up()) - f64::from(largest)
    } else {
        digits.unit().unwrap_or(0.0)
    };
    // Far from the origin single-precision steps are no small lengths, and so are decimals of
    // numbers with few digits.
    own.max(2.0 * told).min(largest_tolerance(ready))
}

/// The distance within which facets of a surface are coplanar, whatever its numbers tell: 2^-22 of
/// the diagonal.
pub(crate) fn rounding_of(domain: &Domain) -> f64 {
    domain.diagonal() / f64::from(1u32 << 22)
}

/// Digits of a number below which it is one that somebody chose, not one that was rounded.
const CHOSEN: usize = 5;

/// Digits that tell a double from others: there is no decimal at which it was rounded.
const DOUBLE: usize = 16;

/// Digits that tell a single-precision number from others.
const SINGLE: usize = 9;

/// The digits of the numbers of a text.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Digits {
    /// The most significant digits that a coordinate has.
    most: usize,
    /// The largest power of ten that is the last decimal of a coordinate with that number.
    last: i32,
}

impl Digits {
    fn of(points: &[Point]) -> Self {
        let mut all = Self::default();
        let mut text = String::new();
        for c in points.iter().flatten() {
            // The shortest text of a number of at most 15 digits is the one that it was read from,
            // without zeros at its end.
            text.clear();
            if write!(text, "{:e}", c.abs()).is_err() {
                continue;
            }
            let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
            let most = digits.len() - usize::from(digits.contains('.'));
            let last = exponent.parse::<i32>().unwrap_or(0) + 1 - most as i32;
            if most > all.most || (most == all.most && last > all.last) {
                all = Self { most, last };
            }
            if all.most >= DOUBLE {
                break;
            }
        }
        all
    }

    /// The last decimal, if it tells at what the numbers were rounded.
    fn unit(self) -> Option<f64> {
        let told = (CHOSEN..DOUBLE).contains(&self.most);
        told.then(|| format!("1e{}", self.last).parse().ok()).flatten()
    }
}

/// Are all coordinates single-precision numbers, or the texts of such with nine digits?
fn is_single(points: &[Point], digits: usize) -> bool {
    let is_near = |c: f64| {
        let text = || format!("{:.*e}", SINGLE - 1, f64::from(c as f32));
        digits == SINGLE && text().parse() == Ok(c)
    };
    let single =
        |c: &f64| (c.abs() as f32) < f32::MAX && (f64::from(*c as f32) == *c || is_near(*c));
    points.iter().flatten().all(single)
}

#[cfg(test)]
mod tests {
    use super::{largest_tolerance, usual_tolerance};
    use crate::Domain;

    #[test]
    fn single_precision_numbers_have_steps() {
        let surface = |far: f64, x: f64| Domain {
            vertices: vec![[far, 0.0, 0.0], [far + x, 0.0, 0.0]],
            ..Domain::default()
        };
        let usual = |domain: &Domain| usual_tolerance(domain, domain);
        let (single, double) = (surface(4.0, 1.0), surface(4.0, 1.1));
        assert_eq!(usual(&single), 2.0 / f64::from(1 << 21), "two steps of 5");
        assert!((usual(&double) - 1.1 / f64::from(1 << 22)).abs() < 1e-12);
        let far = surface(f64::from(1 << 20), 1.0);
        assert_eq!(usual(&far), largest_tolerance(&far), "steps of 2^-3 are no small lengths");
        // Its text with nine digits is no single-precision number any more.
        let text = 0.300_000_19;
        assert_ne!(f64::from((4.0 + text) as f32), 4.0 + text);
        assert_eq!(usual(&surface(4.0, text)), usual(&single), "two steps");
    }

    #[test]
    fn numbers_of_text_have_a_last_decimal() {
        let usual = |c: [f64; 3]| {
            let domain = Domain { vertices: vec![[0.0; 3], c], ..Domain::default() };
            usual_tolerance(&domain, &domain)
        };
        assert_eq!(usual([0.123_456, 0.012_345_6, 0.9]), 2e-6, "six digits, the larger number");
        assert_eq!(usual([20.0, 0.1234, -12.3456]), 2e-4, "four decimals");
        assert_eq!(usual([-1.2345e-7, 1e-6, 0.0]), 2e-11);
        // A part of the diagonal is more than a unit of the tenth digit; 17 digits tell nothing.
        let own = |x: f64| x / f64::from(1u32 << 22);
        assert_eq!(usual([0.123_456_789_1, 0.0, 0.0]), own(0.123_456_789_1));
        assert_eq!(usual([1.0 / 3.0, 0.0, 0.0]), own(1.0 / 3.0));
        // Numbers of four digits were drawn.
        assert_eq!(usual([0.0, 0.0, 12.34]), own(12.34));
        let far = Domain { vertices: vec![[1234.1; 3], [1234.0; 3]], ..Domain::default() };
        assert_eq!(usual_tolerance(&far, &far), largest_tolerance(&far), "0.2 is no small length");
    }
}
