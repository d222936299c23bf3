//! Brute-force canonical Delaunay meshes of a few integer points, from the definition: a
//! tetrahedron belongs to the mesh exactly if it is not flat and no other point lies inside its
//! perturbed sphere. Shares nothing with the checker: the perturbed determinant is expanded as a
//! polynomial in the perturbations, with 5 × 5 determinants of i128.

#![allow(clippy::unwrap_used, reason = "a failed step here is a failed test")]

pub(crate) mod domain;
pub(crate) mod team;

use ltbw_verify::{Kind, Report};

/// A mesh that a test owns.
#[derive(Debug, Clone)]
pub(crate) struct Owned {
    pub(crate) points: Vec<[f64; 3]>,
    pub(crate) tets: Vec<[u32; 4]>,
}

pub(crate) type IntPoint = [i64; 3];

/// The determinant of a square matrix, by expansion along the first row.
fn determinant(rows: &[Vec<i128>]) -> i128 {
    if rows.len() == 1 {
        return rows[0][0];
    }
    let minor = |skip: usize| -> Vec<Vec<i128>> {
        let keep = |r: &Vec<i128>| (0..r.len()).filter(|&k| k != skip).map(|k| r[k]).collect();
        rows[1..].iter().map(keep).collect()
    };
    (0..rows.len())
        .filter(|&k| rows[0][k] != 0)
        .map(|k| if k % 2 == 0 { 1 } else { -1 } * rows[0][k] * determinant(&minor(k)))
        .sum()
}

/// Six times the signed volume.
pub(crate) fn volume6(p: [IntPoint; 4]) -> i128 {
    let row = |q: IntPoint| (0..3).map(|k| i128::from(q[k] - p[0][k])).collect();
    determinant(&[row(p[1]), row(p[2]), row(p[3])])
}

/// The determinant of (x, y, z, lift, 1) over five points.
fn lifted(p: &[IntPoint; 5], lift: impl Fn(usize) -> i128) -> i128 {
    let row = |i: usize| {
        let [x, y, z] = p[i].map(i128::from);
        vec![x, y, z, lift(i), 1]
    };
    determinant(&(0..5).map(row).collect::<Vec<_>>())
}

/// Whether the fifth point is inside the sphere of the four others.
pub(crate) fn is_inside(p: &[IntPoint; 5]) -> bool {
    let square = |i: usize| p[i].iter().map(|&c| i128::from(c) * i128::from(c)).sum();
    -lifted(p, square).signum() * volume6([p[0], p[1], p[2], p[3]]).signum() > 0
}

/// Whether the fifth point is inside the perturbed sphere of the four others.
fn conflicts(p: &[IntPoint; 5]) -> bool {
    let square = |i: usize| p[i].iter().map(|&c| i128::from(c) * i128::from(c)).sum();
    let mut descending = [0, 1, 2, 3, 4];
    descending.sort_by_key(|&i| std::cmp::Reverse(p[i]));
    let mut sign = lifted(p, square).signum();
    for q in descending {
        if sign == 0 {
            sign = lifted(p, |i| i128::from(i == q)).signum();
        }
    }
    -sign * volume6([p[0], p[1], p[2], p[3]]).signum() > 0
}

/// The canonical Delaunay mesh of distinct points, positively oriented.
pub(crate) fn delaunay(points: &[IntPoint]) -> Owned {
    let n = points.len();
    let mut tets = Vec::new();
    for (a, b, c, d) in quadruples(n) {
        let p = [a, b, c, d].map(|i| points[i]);
        let volume = volume6(p);
        let empty = || {
            let others = (0..n).filter(|i| ![a, b, c, d].contains(i));
            others.into_iter().all(|e| !conflicts(&[p[0], p[1], p[2], p[3], points[e]]))
        };
        if volume != 0 && empty() {
            let [a, b, c, d] = [a, b, c, d].map(|i| i as u32);
            tets.push(if volume > 0 { [a, b, c, d] } else { [a, b, d, c] });
        }
    }
    Owned { points: points.iter().map(|p| p.map(|c| c as f64)).collect(), tets }
}

fn quadruples(n: usize) -> impl Iterator<Item = (usize, usize, usize, usize)> {
    (0..n).flat_map(move |a| {
        (a + 1..n)
            .flat_map(move |b| (b + 1..n).flat_map(move |c| (c + 1..n).map(move |d| (a, b, c, d))))
    })
}

/// Twelve points in general position around an inner one.
pub(crate) const GENERAL: [IntPoint; 12] = [
    [13, 7, 1],
    [92, 11, 9],
    [8, 97, 14],
    [5, 3, 88],
    [95, 90, 19],
    [89, 17, 93],
    [16, 84, 98],
    [99, 96, 85],
    [47, 52, 44],
    [31, 66, 58],
    [71, 38, 29],
    [55, 61, 79],
];

/// The corners of a cube.
pub(crate) fn cube() -> Vec<IntPoint> {
    (0..8).map(|i| [i >> 2 & 1, i >> 1 & 1, i & 1]).collect()
}

/// The adjacency of a mesh, by comparing all pairs of faces.
pub(crate) fn adjacency(tets: &[[u32; 4]]) -> Vec<[u32; 4]> {
    let face = |t: usize, i: usize| {
        let mut f: Vec<u32> = (0..4).filter(|&k| k != i).map(|k| tets[t][k]).collect();
        f.sort_unstable();
        f
    };
    let other = |t: usize, i: usize| {
        let shares = |&u: &usize| u != t && (0..4).any(|j| face(u, j) == face(t, i));
        (0..tets.len()).find(shares).map_or(u32::MAX, |u| u as u32)
    };
    (0..tets.len()).map(|t| [0, 1, 2, 3].map(|i| other(t, i))).collect()
}

/// The kinds of the defects found, each once.
pub(crate) fn kinds(report: &Report) -> Vec<Kind> {
    report.defect_counts.keys().copied().collect()
}

/// A mesh as the files in `testdata` hold it.
pub(crate) fn parse(text: &str) -> Owned {
    let mut words = text.split_whitespace();
    let mut mesh = Owned { points: Vec::new(), tets: Vec::new() };
    assert_eq!(words.next(), Some("points"));
    for _ in 0..words.next().unwrap().parse().unwrap() {
        mesh.points.push([0; 3].map(|_| words.next().unwrap().parse().unwrap()));
    }
    assert_eq!(words.next(), Some("tets"));
    for _ in 0..words.next().unwrap().parse().unwrap() {
        mesh.tets.push([0; 4].map(|_| words.next().unwrap().parse().unwrap()));
    }
    assert_eq!(words.next(), None);
    mesh
}
