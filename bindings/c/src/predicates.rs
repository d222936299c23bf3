//! The exact predicates, for any finite coordinates.
//!
//! Points are three numbers each. The answers are 1, 0 and -1; `INT32_MIN` says that an argument is
//! NULL or not finite.

use crate::error::failed;
use crate::input::values;
use kernel::Point;
use kernel::predicates::{Sign, insphere, orient3d, perturb};
use ltbw_bindings::unpanicked;

/// The points at pointers, if all are there and finite.
///
/// # Safety
/// Each pointer is null or points to three numbers.
unsafe fn read<const N: usize>(pointers: [*const f64; N]) -> Option<[Point; N]> {
    let mut read = [[0.0; 3]; N];
    for (point, pointer) in read.iter_mut().zip(pointers) {
        // SAFETY: as the caller promises.
        let given = unsafe { values(pointer, 3, "point") };
        let given: Point = given.ok()?.try_into().ok()?;
        // Points of the kernel have no -0.
        *point = given.map(|c| c + 0.0);
        if given.iter().any(|c| !c.is_finite()) {
            return None;
        }
    }
    Some(read)
}

/// The answer of a predicate; a panic is no sign, and is told.
fn answer(sign: impl FnOnce() -> Option<Sign>) -> i32 {
    let asked = unpanicked(|| Ok(sign())).unwrap_or_else(|failure| {
        failed(&failure);
        None
    });
    asked.map_or(i32::MIN, |sign| sign as i32)
}

/// The orientation of a tetrahedron: positive if it is that of the origin and the three unit
/// vectors in their order.
///
/// # Safety
/// Each pointer is null or points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_orient3d(
    a: *const f64,
    b: *const f64,
    c: *const f64,
    d: *const f64,
) -> i32 {
    // SAFETY: as the caller promises.
    let read = unsafe { read([a, b, c, d]) };
    answer(|| read.map(|[a, b, c, d]| orient3d(&a, &b, &c, &d)))
}

/// Positive if e is inside the sphere through a, b, c, d, a tetrahedron of positive orientation.
///
/// # Safety
/// Each pointer is null or points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_insphere(
    a: *const f64,
    b: *const f64,
    c: *const f64,
    d: *const f64,
    e: *const f64,
) -> i32 {
    // SAFETY: as the caller promises.
    let read = unsafe { read([a, b, c, d, e]) };
    answer(|| read.map(|[a, b, c, d, e]| insphere(&a, &b, &c, &d, &e)))
}

/// Positive if e is inside the perturbed sphere: never 0 for five different points.
///
/// # Safety
/// Each pointer is null or points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_side_of_sphere(
    a: *const f64,
    b: *const f64,
    c: *const f64,
    d: *const f64,
    e: *const f64,
) -> i32 {
    // SAFETY: as the caller promises.
    let read = unsafe { read([a, b, c, d, e]) };
    answer(|| read.map(|[a, b, c, d, e]| perturb::side_of_sphere(&a, &b, &c, &d, &e)))
}

/// Positive if d is beyond the perturbed hull facet a, b, c.
///
/// # Safety
/// Each pointer is null or points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ltbw_side_of_hull_facet(
    a: *const f64,
    b: *const f64,
    c: *const f64,
    d: *const f64,
) -> i32 {
    // SAFETY: as the caller promises.
    let read = unsafe { read([a, b, c, d]) };
    answer(|| read.map(|[a, b, c, d]| perturb::side_of_hull_facet(&a, &b, &c, &d)))
}
