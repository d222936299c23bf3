//! The expressions of the filters in exact arithmetic, by the textbook's formulas, and what their
//! bounds are made of.

use num_bigint::BigInt;
use num_traits::{One, Signed, Zero};

/// A point of integer coordinates.
pub(crate) type Place = [BigInt; 3];

fn minus(a: &Place, b: &Place) -> Place {
    std::array::from_fn(|k| &a[k] - &b[k])
}

fn dot(a: &Place, b: &Place) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &Place, b: &Place) -> Place {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        &a[i] * &b[j] - &a[j] * &b[i]
    })
}

fn squared(a: &Place) -> BigInt {
    dot(a, a)
}

/// Determinant by expansion along the first row.
fn determinant(rows: &[Vec<BigInt>]) -> BigInt {
    let Some((first, rest)) = rows.split_first() else {
        return BigInt::one();
    };
    let mut sum = BigInt::zero();
    for (column, factor) in first.iter().enumerate() {
        let minor: Vec<Vec<BigInt>> =
            rest.iter().map(|row| [&row[..column], &row[column + 1..]].concat()).collect();
        let term = factor * determinant(&minor);
        sum = if column % 2 == 0 { sum + term } else { sum - term };
    }
    sum
}

/// det(b - a, c - a, d - a).
pub(crate) fn orient3d(p: &[Place]) -> BigInt {
    dot(&minus(&p[1], &p[0]), &cross(&minus(&p[2], &p[0]), &minus(&p[3], &p[0])))
}

/// -det(1 x y z l) of the five points.
pub(crate) fn insphere(p: &[Place]) -> BigInt {
    let row = |p: &Place| [&[BigInt::one()], &p[..], &[squared(p)]].concat();
    -determinant(&p.iter().map(row).collect::<Vec<_>>())
}

/// det(1 x y) of three points, x and y being the axes of `plane`.
pub(crate) fn orient2d(p: &[Place], [i, j]: [usize; 2]) -> BigInt {
    let row = |p: &Place| vec![BigInt::one(), p[i].clone(), p[j].clone()];
    determinant(&p.iter().map(row).collect::<Vec<_>>())
}

/// det(x y l) of the differences to the last of four points.
pub(crate) fn incircle(p: &[Place], [i, j]: [usize; 2]) -> BigInt {
    let row = |q: &Place| {
        let q = minus(q, &p[3]);
        vec![q[i].clone(), q[j].clone(), squared(&q)]
    };
    determinant(&p[..3].iter().map(row).collect::<Vec<_>>())
}

/// Squared radius minus squared distance to the middle of a and b.
pub(crate) fn diametral(p: &[Place]) -> BigInt {
    let from_middle: Place = std::array::from_fn(|k| 2 * &p[2][k] - &p[0][k] - &p[1][k]);
    (squared(&minus(&p[0], &p[1])) - squared(&from_middle)) / 4
}

/// With the circumcentre a + o / (2 |n|²) of a, b, c: |n|² times squared radius minus squared
/// distance.
pub(crate) fn equatorial(p: &[Place]) -> BigInt {
    let [u, v, w] = [1, 2, 3].map(|k| minus(&p[k], &p[0]));
    let n = cross(&u, &v);
    let (first, second) = (cross(&n, &u), cross(&v, &n));
    let o: Place = std::array::from_fn(|k| squared(&v) * &first[k] + squared(&u) * &second[k]);
    dot(&o, &w) - squared(&n) * squared(&w)
}

/// unit² · 4 det² (R² - (ratio / unit)² l²) for the circumradius R and the shortest edge l.
pub(crate) fn radius_edge(p: &[Place], ratio: &BigInt, unit: u32) -> BigInt {
    let [u, v, w] = [1, 2, 3].map(|k| minus(&p[k], &p[0]));
    let (vw, wu, uv) = (cross(&v, &w), cross(&w, &u), cross(&u, &v));
    // 2 det times the vector to the centre.
    let n: Place =
        std::array::from_fn(|k| squared(&u) * &vw[k] + squared(&v) * &wu[k] + squared(&w) * &uv[k]);
    let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    let shortest = pairs.map(|(i, j)| squared(&minus(&p[i], &p[j]))).into_iter().min();
    let limit = 2 * ratio * dot(&u, &vw);
    squared(&n) * unit * unit - &limit * &limit * shortest.unwrap_or_default()
}

/// Six times the volume of the tetrahedron minus that of `limit`.
pub(crate) fn volume(p: &[Place], limit: &BigInt) -> BigInt {
    orient3d(p) - 6 * limit
}

/// unit · |p|² |q|² (cos²(angle) - cosine / unit) for the dihedral angle at the first two points, p
/// and q being the normals of its faces; without cross products, by Lagrange's identity.
pub(crate) fn below_dihedral(p: &[Place], cosine: &BigInt, unit: u32) -> BigInt {
    let [u, v, w] = [1, 2, 3].map(|k| minus(&p[k], &p[0]));
    let normals = |x: &Place, y: &Place| squared(&u) * dot(x, y) - dot(&u, x) * dot(&u, y);
    let product = normals(&v, &w);
    unit * &product * &product - cosine * normals(&v, &v) * normals(&w, &w)
}

/// The largest difference in each axis, of the points with these numbers.
pub(crate) fn extents(p: &[Place], pairs: &[(usize, usize)]) -> Place {
    std::array::from_fn(|k| {
        pairs.iter().map(|&(i, j)| (&p[i][k] - &p[j][k]).abs()).max().unwrap_or_default()
    })
}
