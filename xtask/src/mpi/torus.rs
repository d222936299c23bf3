//! A surface with patches: what `ltbw generate` makes has none.

use std::f64::consts::TAU;
use std::fmt::Write;

/// The text of an `.obj` file with a torus of radii 0.5 and 0.2, its corners rounded to 32 bits:
/// `parts` around the axis and as many around the tube, two triangles each, nearly in one plane.
pub(super) fn torus(parts: u32) -> String {
    let around = |k: u32| (TAU * f64::from(k) / f64::from(parts)).sin_cos();
    let mut text = String::new();
    for (i, j) in (0..parts * parts).map(|k| (k / parts, k % parts)) {
        let ((y, x), (up, out)) = (around(i), around(j));
        let radius = 0.5 + 0.2 * out;
        let [x, y, z] = [radius * x, radius * y, 0.2 * up].map(|c| c as f32);
        _ = writeln!(text, "v {x} {y} {z}");
    }
    let at = |i: u32, j: u32| i % parts * parts + j % parts + 1;
    for (i, j) in (0..parts * parts).map(|k| (k / parts, k % parts)) {
        let [a, b] = [at(i, j), at(i + 1, j)];
        let [c, d] = [at(i + 1, j + 1), at(i, j + 1)];
        _ = write!(text, "f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    text
}
