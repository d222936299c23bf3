//! Exact geometric predicates: a proved filter first, exact arithmetic after it.
//!
//! Sign conventions (CGAL's and VTK's): `orient3d(a, b, c, d)` is the sign of
//! det(b-a, c-a, d-a), positive when `a, b, c` turn counterclockwise seen from `d`'s side
//! reversed, i.e. for the unit tetrahedron (0, x, y, z). `insphere(a, b, c, d, e)` is positive
//! when `e` lies inside the sphere through a positively oriented tetrahedron `a, b, c, d`.

/// Sign of an exactly evaluated expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(i8)]
pub enum Sign {
    /// Below zero.
    Negative = -1,
    /// Exactly zero.
    Zero = 0,
    /// Above zero.
    Positive = 1,
}
