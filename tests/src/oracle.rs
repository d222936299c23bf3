//! Slow and obviously right: the predicates over GMP integers (`rug`), for any finite f64, and the
//! Delaunay triangulation of a few points by brute force.
//!
//! Nothing here shares code or formulas with the kernel: no differences are rounded, the in-sphere
//! test is a determinant by cofactors, the in-circle test is an in-sphere test through an apex over
//! the circle's plane. Cost: microseconds per predicate, O(n^5) for a triangulation.

// A feature of the crate below `rug` leaves out the tests of GMP itself, half of its build.
use gmp_mpfr_sys as _;
use ltbw::{Point, Sign};
use rug::Integer;
use std::array::from_fn;
use std::cmp::Ordering;

/// A point with integer coordinates.
pub type Exact = [Integer; 3];

/// Scales all `points` by one power of two to integers. Signs of homogeneous expressions stay.
///
/// # Panics
/// If a coordinate is not finite.
#[must_use]
pub fn scale(points: &[Point]) -> Vec<Exact> {
    let lowest = points.iter().flatten().filter(|&&c| c != 0.0).map(|&c| decode(c).1).min();
    let lowest = lowest.unwrap_or(0);
    let integer = |c: f64| {
        let (mantissa, exponent) = decode(c);
        if mantissa == 0 {
            return Integer::new();
        }
        Integer::from(mantissa) << u32::try_from(exponent - lowest).expect("lowest is a minimum")
    };
    points.iter().map(|p| p.map(integer)).collect()
}

/// `(m, e)` with `c = m * 2^e`.
fn decode(c: f64) -> (i64, i32) {
    assert!(c.is_finite(), "the oracle takes finite coordinates, not {c}");
    let bits = c.to_bits();
    let fraction = i64::try_from(bits & ((1 << 52) - 1)).expect("52 bits");
    let biased = i32::try_from(bits >> 52 & 0x7ff).expect("11 bits");
    let (mantissa, exponent) =
        if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
    (if c < 0.0 { -mantissa } else { mantissa }, exponent)
}

fn minus(p: &Exact, q: &Exact) -> Exact {
    from_fn(|i| Integer::from(&p[i] - &q[i]))
}

// Products are added in place: GMP then allocates once for each result, not for each product.
fn cross(u: &Exact, v: &Exact) -> Exact {
    from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let mut difference = Integer::from(&u[j] * &v[k]);
        difference -= &u[k] * &v[j];
        difference
    })
}

fn dot(u: &Exact, v: &Exact) -> Integer {
    let mut sum = Integer::from(&u[0] * &v[0]);
    sum += &u[1] * &v[1];
    sum += &u[2] * &v[2];
    sum
}

fn det(u: &Exact, v: &Exact, w: &Exact) -> Integer {
    dot(&cross(u, v), w)
}

fn sign(value: &Integer) -> Sign {
    match value.cmp0() {
        Ordering::Less => Sign::Negative,
        Ordering::Equal => Sign::Zero,
        Ordering::Greater => Sign::Positive,
    }
}

fn times(s: Sign, t: Sign) -> Sign {
    match s as i8 * t as i8 {
        0 => Sign::Zero,
        1 => Sign::Positive,
        _ => Sign::Negative,
    }
}

/// The predicates on integer points; see the functions of the same name on [`Point`]s.
pub mod exact {
    use super::{Exact, Integer, Ordering, Sign, cross, det, dot, from_fn, minus, sign, times};

    /// Sign of det(b - a, c - a, d - a).
    #[must_use]
    pub fn orient3d(a: &Exact, b: &Exact, c: &Exact, d: &Exact) -> Sign {
        sign(&det(&minus(b, a), &minus(c, a), &minus(d, a)))
    }

    /// Positive when `e` is inside the sphere of the positive tetrahedron `a, b, c, d`.
    #[must_use]
    pub fn insphere(a: &Exact, b: &Exact, c: &Exact, d: &Exact, e: &Exact) -> Sign {
        // The determinant of the rows (|p - e|^2, p - e), along its first column.
        let [a, b, c, d] = [a, b, c, d].map(|p| minus(p, e));
        let mut sum = dot(&a, &a) * det(&b, &c, &d);
        sum -= &dot(&b, &b) * &det(&a, &c, &d);
        sum += &dot(&c, &c) * &det(&a, &b, &d);
        sum -= &dot(&d, &d) * &det(&a, &b, &c);
        sign(&sum)
    }

    /// Turn of `a, b, c` in the first of the projections xy, yz, xz in which it is not zero.
    #[must_use]
    pub fn coplanar_orient(a: &Exact, b: &Exact, c: &Exact) -> Sign {
        let (u, v) = (minus(b, a), minus(c, a));
        let turn = |i: usize, j: usize| {
            sign(&(Integer::from(&u[i] * &v[j]) - Integer::from(&u[j] * &v[i])))
        };
        [turn(0, 1), turn(1, 2), turn(0, 2)]
            .into_iter()
            .find(|&s| s != Sign::Zero)
            .unwrap_or(Sign::Zero)
    }

    /// Positive when `d`, in the plane of the triangle `a, b, c`, is inside its circle.
    #[must_use]
    pub fn side_of_bounded_circle(a: &Exact, b: &Exact, c: &Exact, d: &Exact) -> Sign {
        // Any sphere through a, b, c cuts the plane in their circle; this one also goes through
        // a point above a, on the side that makes the tetrahedron positive.
        let normal = cross(&minus(b, a), &minus(c, a));
        let apex: Exact = from_fn(|i| Integer::from(&a[i] + &normal[i]));
        insphere(a, b, c, &apex, d)
    }

    /// `Less` if `a` is strictly nearer to `p` than `b` is.
    #[must_use]
    pub fn cmp_distance(p: &Exact, a: &Exact, b: &Exact) -> Ordering {
        let [a, b] = [a, b].map(|q| minus(q, p));
        dot(&a, &a).cmp(&dot(&b, &b))
    }

    /// In-sphere test with the symbolic perturbation: never zero for five distinct points with
    /// orient3d(p0..p3) > 0.
    #[must_use]
    pub fn side_of_sphere(cell: [&Exact; 4], p: &Exact) -> Sign {
        let [a, b, c, d] = cell;
        let side = insphere(a, b, c, d, p);
        if side != Sign::Zero {
            return side;
        }
        for q in descending(&cell, p) {
            if q == p {
                return Sign::Negative;
            }
            let [a, b, c, d] = cell.map(|r| if r == q { p } else { r });
            let turn = orient3d(a, b, c, d);
            if turn != Sign::Zero {
                return turn;
            }
        }
        Sign::Zero
    }

    /// In-circle test with the symbolic perturbation, for four distinct coplanar points of which
    /// the first three are not collinear.
    #[must_use]
    pub fn side_of_circle(triangle: [&Exact; 3], p: &Exact) -> Sign {
        let [a, b, c] = triangle;
        let side = side_of_bounded_circle(a, b, c, p);
        if side != Sign::Zero {
            return side;
        }
        let local = coplanar_orient(a, b, c);
        for q in descending(&triangle, p).into_iter().take(3) {
            if q == p {
                return Sign::Negative;
            }
            let [a, b, c] = triangle.map(|r| if r == q { p } else { r });
            let turn = coplanar_orient(a, b, c);
            if turn != Sign::Zero {
                return times(turn, local);
            }
        }
        times(local, Sign::Negative)
    }

    /// Is `p` in the perturbed sphere of the infinite tetrahedron over the hull facet `a, b, c`,
    /// which turns so that orient3d(a, b, c, q) > 0 for `q` beyond it?
    #[must_use]
    pub fn side_of_hull_facet(facet: [&Exact; 3], p: &Exact) -> Sign {
        let [a, b, c] = facet;
        match orient3d(a, b, c, p) {
            Sign::Zero => side_of_circle(facet, p),
            turn => turn,
        }
    }

    /// `cell` and `p` by (x, y, z), the largest first.
    fn descending<'a>(cell: &[&'a Exact], p: &'a Exact) -> Vec<&'a Exact> {
        let mut all: Vec<&Exact> = cell.iter().copied().chain([p]).collect();
        all.sort_by(|s, t| t.cmp(s));
        all
    }
}

/// A predicate of `N` points by exact integers: `with([a, b, c, d], |[a, b, c, d]| ..)`.
fn with<const N: usize, R>(points: [&Point; N], f: impl FnOnce([&Exact; N]) -> R) -> R {
    let scaled = scale(&points.map(|p| *p));
    f(from_fn(|i| &scaled[i]))
}

/// Sign of det(b - a, c - a, d - a).
#[must_use]
pub fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    with([a, b, c, d], |[a, b, c, d]| exact::orient3d(a, b, c, d))
}

/// Positive when `e` is inside the sphere of the positive tetrahedron `a, b, c, d`.
#[must_use]
pub fn insphere(a: &Point, b: &Point, c: &Point, d: &Point, e: &Point) -> Sign {
    with([a, b, c, d, e], |[a, b, c, d, e]| exact::insphere(a, b, c, d, e))
}

/// Turn of `a, b, c` in the first of the projections xy, yz, xz in which it is not zero.
#[must_use]
pub fn coplanar_orient(a: &Point, b: &Point, c: &Point) -> Sign {
    with([a, b, c], |[a, b, c]| exact::coplanar_orient(a, b, c))
}

/// Positive when `d`, in the plane of the triangle `a, b, c`, is inside its circle.
#[must_use]
pub fn side_of_bounded_circle(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    with([a, b, c, d], |[a, b, c, d]| exact::side_of_bounded_circle(a, b, c, d))
}

/// Perturbed in-sphere test; see [`exact::side_of_sphere`].
#[must_use]
pub fn side_of_sphere(cell: [&Point; 4], p: &Point) -> Sign {
    let [a, b, c, d] = cell;
    with([a, b, c, d, p], |[a, b, c, d, p]| exact::side_of_sphere([a, b, c, d], p))
}

/// Perturbed in-circle test; see [`exact::side_of_circle`].
#[must_use]
pub fn side_of_circle(triangle: [&Point; 3], p: &Point) -> Sign {
    let [a, b, c] = triangle;
    with([a, b, c, p], |[a, b, c, p]| exact::side_of_circle([a, b, c], p))
}

/// Perturbed test against a hull facet; see [`exact::side_of_hull_facet`].
#[must_use]
pub fn side_of_hull_facet(facet: [&Point; 3], p: &Point) -> Sign {
    let [a, b, c] = facet;
    with([a, b, c, p], |[a, b, c, p]| exact::side_of_hull_facet([a, b, c], p))
}

/// The Delaunay tetrahedra of a few points, by definition: all quadruples whose perturbed sphere
/// holds no other point. Ascending indices, sorted; duplicates stand for their smallest index.
#[must_use]
pub fn brute_force(points: &[Point]) -> Vec<[u32; 4]> {
    let scaled = scale(points);
    let first = |p: &Exact| scaled.iter().position(|q| q == p);
    let distinct: Vec<usize> =
        (0..scaled.len()).filter(|&i| first(&scaled[i]) == Some(i)).collect();
    let mut tets = Vec::new();
    for (ia, &a) in distinct.iter().enumerate() {
        for (ib, &b) in distinct.iter().enumerate().skip(ia + 1) {
            for (ic, &c) in distinct.iter().enumerate().skip(ib + 1) {
                for &d in &distinct[ic + 1..] {
                    let quad = [a, b, c, d];
                    if is_empty(&scaled, &distinct, quad) {
                        tets.push(quad.map(|i| u32::try_from(i).expect("a few points")));
                    }
                }
            }
        }
    }
    tets
}

fn is_empty(points: &[Exact], distinct: &[usize], quad: [usize; 4]) -> bool {
    let mut cell = quad.map(|i| &points[i]);
    match exact::orient3d(cell[0], cell[1], cell[2], cell[3]) {
        Sign::Zero => return false,
        Sign::Negative => cell.swap(0, 1),
        Sign::Positive => {}
    }
    distinct
        .iter()
        .filter(|i| !quad.contains(i))
        .all(|&i| exact::side_of_sphere(cell, &points[i]) == Sign::Negative)
}

#[cfg(test)]
mod tests {
    use super::{brute_force, insphere, orient3d, scale, side_of_bounded_circle};
    use ltbw::Sign;

    const O: [f64; 3] = [0.0, 0.0, 0.0];
    const X: [f64; 3] = [1.0, 0.0, 0.0];
    const Y: [f64; 3] = [0.0, 1.0, 0.0];
    const Z: [f64; 3] = [0.0, 0.0, 1.0];

    #[test]
    fn signs_follow_the_convention() {
        assert_eq!(orient3d(&O, &X, &Y, &Z), Sign::Positive);
        assert_eq!(insphere(&O, &X, &Y, &Z, &[0.5, 0.5, 0.5]), Sign::Positive);
        assert_eq!(insphere(&O, &X, &Y, &Z, &[1.0, 1.0, 1.0]), Sign::Zero);
        assert_eq!(insphere(&O, &X, &Y, &Z, &[1.0, 1.0, 1.5]), Sign::Negative);
        assert_eq!(side_of_bounded_circle(&O, &Y, &X, &[0.5, 0.5, 0.0]), Sign::Positive);
        assert_eq!(side_of_bounded_circle(&O, &Y, &X, &[1.0, 1.0, 0.0]), Sign::Zero);
        assert_eq!(side_of_bounded_circle(&O, &Y, &X, &[2.0, 1.0, 0.0]), Sign::Negative);
    }

    #[test]
    fn scaling_is_exact_over_the_whole_range_of_f64() {
        let tiny = f64::from_bits(1);
        let scaled = scale(&[[tiny, -0.0, f64::MAX]]);
        assert_eq!(scaled[0][0], 1);
        assert_eq!(scaled[0][1], 0);
        assert_eq!(scaled[0][2].significant_bits(), 1024 + 1074);
    }

    #[test]
    fn a_cube_is_cut_into_the_tetrahedra_of_one_perturbation() {
        let cube: Vec<_> =
            (0..8u32).map(|i| [4, 2, 1].map(|b| f64::from(u8::from(i & b != 0)))).collect();
        let tets = brute_force(&cube);
        assert!(tets.len() == 5 || tets.len() == 6, "{tets:?}");
        // Numbering does not matter: the reversed list gives the same set.
        let reversed: Vec<_> = cube.iter().rev().copied().collect();
        let mut back: Vec<_> = brute_force(&reversed)
            .into_iter()
            .map(|t| {
                let mut t = t.map(|v| 7 - v);
                t.sort_unstable();
                t
            })
            .collect();
        back.sort_unstable();
        assert_eq!(tets, back);
    }
}
