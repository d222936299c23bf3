//! A domain as it is given, and the tolerance within which facets are taken for coplanar there.

use crate::prepare::LARGEST_TOLERANCE;
use crate::{Domain, PrepareOptions, Prepared};

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
/// the diagonal, or two steps of the largest coordinate where all numbers are single-precision;
/// `read` is the surface as its file has it, `ready` as it is to be meshed.
pub fn usual_tolerance(read: &Domain, ready: &Domain) -> f64 {
    let (read, _) = read.near();
    let own = read.diagonal() / f64::from(1u32 << 22);
    let numbers = || read.vertices.iter().flatten();
    let largest = numbers().fold(0.0, |most: f64, c| most.max(c.abs())) as f32;
    let is_single = numbers().all(|&c| f64::from(c as f32) == c) && largest < f32::MAX;
    let steps = 2.0 * (f64::from(largest.next_up()) - f64::from(largest));
    // Far from the origin single-precision steps are no small lengths.
    if is_single { own.max(steps) } else { own }.min(largest_tolerance(ready))
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
    }
}
