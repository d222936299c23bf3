//! Level *structure*: every tetrahedron names four different points that exist and are finite,
//! and no two used points lie at the same place. Duplicated tetrahedra are found while faces are
//! matched (`faces.rs`).
//!
//! Tetrahedra that fail are left out of the later levels. Cost: O(T + V log V).

use crate::chunks::pieces;
use crate::defect::{Findings, Kind};
use crate::mesh::{Mesh, Options, Point};
use crate::perturb::order;
use crate::places;
use crate::sync::Marks;
use rayon::prelude::*;

/// Tetrahedra are numbered below this, so that `4 * tet + face` leaves two reserved u32 values.
pub(crate) const MAX_TETS: usize = (1 << 30) - 1;

/// The mesh as the later levels see it.
pub(crate) struct Sound {
    /// Whether a tetrahedron names four different finite points.
    pub(crate) tet: Vec<bool>,
    /// Number of points that no sound tetrahedron names.
    pub(crate) unused: usize,
    /// Places of finite points at which no used point lies.
    pub(crate) left_out: usize,
    /// The points named by sound tetrahedra, in the order by (x, y, z).
    pub(crate) vertices: Vec<u32>,
}

/// Whether the lists are small enough to be numbered.
pub(crate) fn fits(mesh: &Mesh) -> bool {
    mesh.tets.len() <= MAX_TETS && mesh.points.len() < u32::MAX as usize
}

/// Runs the level. The mesh must fit (see [`fits`]).
pub(crate) fn check(mesh: &Mesh, options: &Options, out: &mut Findings) -> Sound {
    if mesh.tets.is_empty() {
        out.add(Kind::Empty, &[], &[]);
    }
    let points = mesh.points;
    let (checked, order) =
        rayon::join(|| tets(mesh, options.max_defects), || places::sorted(points));
    let Checked { tet, used, named, findings } = checked;
    out.merge(findings);
    // The order has the finite points; only if some are missing is it worth a look which.
    if order.len() < points.len() {
        for (v, p) in (0u32..).zip(points) {
            if (named[v as usize] || used[v as usize]) && !is_finite(p) {
                out.add(Kind::NotFinite, &[], &[v]);
            }
        }
    }
    let left_out = occupied(points, &order, &used, options.all_points, out);
    let mut vertices = order;
    vertices.retain(|&v| used[v as usize]);
    Sound { tet, unused: points.len() - vertices.len(), left_out, vertices }
}

fn is_finite(p: &Point) -> bool {
    p.iter().all(|c| c.is_finite())
}

/// The findings of [`tets`].
struct Checked {
    tet: Vec<bool>,
    /// Whether a sound tetrahedron names the point.
    used: Vec<bool>,
    /// Whether an unsound one does.
    named: Vec<bool>,
    findings: Findings,
}

/// Checks every tetrahedron by itself.
///
/// The marks of points are shared by threads: they are only ever set, and read after the sweep.
fn tets(mesh: &Mesh, limit: usize) -> Checked {
    let points = mesh.points;
    let (used, named) = (Marks::new(points.len()), Marks::new(points.len()));
    let all_finite = points.par_iter().all(is_finite);
    let checked = pieces(mesh.tets.len(), |range| {
        let mut findings = Findings::new(limit);
        let sound: Vec<bool> = range
            .map(|t| {
                let tet = &mesh.tets[t];
                let [a, b, c, d] = *tet;
                let sound = if a.max(b).max(c.max(d)) as usize >= points.len() {
                    findings.add(Kind::IndexOutOfRange, &[t as u32], tet);
                    false
                } else if a == b || a == c || a == d || b == c || b == d || c == d {
                    findings.add(Kind::RepeatedVertex, &[t as u32], tet);
                    false
                } else {
                    all_finite || tet.iter().all(|&v| is_finite(&points[v as usize]))
                };
                let marks = if sound { &used } else { &named };
                tet.iter().for_each(|&v| marks.set(v as usize));
                sound
            })
            .collect();
        (sound, findings)
    });
    let mut tet = Vec::with_capacity(mesh.tets.len());
    let mut findings = Findings::new(limit);
    for (sound, found) in checked {
        tet.extend(sound);
        findings.merge(found);
    }
    Checked { tet, used: used.into_plain(), named: named.into_plain(), findings }
}

/// Finds used points at equal places, and places that no used point has, among the finite points
/// in their `order`. Returns the number of the latter.
fn occupied(
    points: &[Point],
    sorted: &[u32],
    used: &[bool],
    all_points: bool,
    out: &mut Findings,
) -> usize {
    let at = |v: u32| &points[v as usize];
    let mut left_out = Vec::new();
    for group in sorted.chunk_by(|&v, &w| order(at(v), at(w)).is_eq()) {
        let mut users = group.iter().filter(|&&v| used[v as usize]);
        match users.next() {
            None => left_out.push(group[0]),
            Some(&first) => users.for_each(|&v| out.add(Kind::EqualVertices, &[], &[first, v])),
        }
    }
    if all_points {
        left_out.sort_unstable();
        left_out.iter().for_each(|&v| out.add(Kind::PointLeftOut, &[], &[v]));
    }
    left_out.len()
}
