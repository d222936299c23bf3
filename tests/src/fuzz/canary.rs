//! `canary`: a fuzz target that must fail. If `cargo xtask fuzz` does not find the bug planted
//! here within a minute, the fuzzing itself is broken: the build, the coverage, the generator or
//! the oracle.

use super::predicates::points;
use crate::oracle;
use ltbw::{Point, Sign};

/// The message of the panic, for which `cargo xtask fuzz` looks.
pub const FOUND: &str = "the canary's planted bug was found";

/// Compares a wrong `orient3d` with `rug`.
///
/// # Panics
/// If they differ: on purpose.
pub fn canary(bytes: &[u8]) {
    let Some([a, b, c, d, _]) = points(bytes) else { return };
    let right = oracle::orient3d(&a, &b, &c, &d);
    assert!(planted(&a, &b, &c, &d) == right, "{FOUND}");
}

/// The planted bug: a filter with an error bound of 2 ulps instead of the proved one. Right on
/// random points, on exactly coplanar ones and on small integers.
fn planted(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    let [u, v, w] = [b, c, d].map(|p| -> Point { std::array::from_fn(|k| p[k] - a[k]) });
    let det = u[0] * (v[1] * w[2] - v[2] * w[1])
        + u[1] * (v[2] * w[0] - v[0] * w[2])
        + u[2] * (v[0] * w[1] - v[1] * w[0]);
    let extent = |k: usize| u[k].abs().max(v[k].abs()).max(w[k].abs());
    let bound = 2.0 * f64::EPSILON * extent(0) * extent(1) * extent(2);
    if det.is_finite() && bound > f64::MIN_POSITIVE && det.abs() > bound {
        Sign::from_f64(det)
    } else {
        oracle::orient3d(a, b, c, d)
    }
}

#[cfg(test)]
mod tests {
    use super::planted;
    use crate::families::Rng;
    use crate::five_points::WINDOW;
    use crate::oracle;

    /// A bug that random points find would say nothing about the fuzzer.
    #[test]
    fn uniform_points_do_not_find_it() {
        let (_, uniform) = WINDOW[0];
        let mut rng = Rng::new(1);
        for _ in 0..20_000 {
            let [a, b, c, d, _] = uniform(&mut rng);
            assert_eq!(planted(&a, &b, &c, &d), oracle::orient3d(&a, &b, &c, &d));
        }
    }
}
