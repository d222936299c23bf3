//! Level *structure*: every tetrahedron names four different points that exist and are finite,
//! and no two used points lie at the same place. Duplicated tetrahedra are found while faces are
//! matched (`faces.rs`).
//!
//! Tetrahedra that fail are left out of the later levels. Cost: O(T + V log V).

use crate::defect::{Findings, Kind};
use crate::mesh::{Mesh, Options, Point};
use crate::perturb::order;
use crate::sweep::{Partial, pieces};
use rayon::prelude::*;

/// Tetrahedra are numbered below this, so that `4 * tet + face` leaves two reserved u32 values.
pub(crate) const MAX_TETS: usize = (1 << 30) - 1;

/// The mesh as the later levels see it.
pub(crate) struct Sound {
    /// Whether a tetrahedron names four different finite points.
    pub(crate) tet: Vec<bool>,
    /// Number of points named by sound tetrahedra.
    pub(crate) used: usize,
    /// Number of points that no sound tetrahedron names.
    pub(crate) unused: usize,
    /// Places of finite points at which no used point lies.
    pub(crate) left_out: usize,
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
    let finite = |p: &Point| p.iter().all(|c| c.is_finite());
    let checked = pieces(mesh.tets.len(), |range| {
        let mut part = Partial::new(options.max_defects);
        let sound: Vec<bool> = range
            .map(|t| {
                let tet = &mesh.tets[t];
                let findings = &mut part.findings;
                if tet.iter().any(|&v| v as usize >= points.len()) {
                    findings.add(Kind::IndexOutOfRange, &[t as u32], tet);
                    return false;
                }
                if (0..3).any(|i| tet[i + 1..].contains(&tet[i])) {
                    findings.add(Kind::RepeatedVertex, &[t as u32], tet);
                    return false;
                }
                tet.iter().all(|&v| finite(&points[v as usize]))
            })
            .collect();
        (sound, part)
    });
    let mut tet = Vec::with_capacity(mesh.tets.len());
    for (sound, part) in checked {
        tet.extend(sound);
        out.merge(part.findings);
    }
    let mut used = vec![false; points.len()];
    let mut named = vec![false; points.len()];
    for (vertices, &sound) in mesh.tets.iter().zip(&tet) {
        for &v in vertices {
            if let Some(n) = named.get_mut(v as usize) {
                *n = true;
                used[v as usize] |= sound;
            }
        }
    }
    for (v, p) in points.iter().enumerate() {
        if named[v] && !finite(p) {
            out.add(Kind::NotFinite, &[], &[v as u32]);
        }
    }
    let left_out = places(points, &used, options.all_points, out);
    let used = used.iter().filter(|&&u| u).count();
    Sound { tet, used, unused: points.len() - used, left_out }
}

/// Finds used points at equal places, and places that no used point has. Returns the number of
/// the latter. Points that are not finite have no place.
fn places(points: &[Point], used: &[bool], all_points: bool, out: &mut Findings) -> usize {
    let mut sorted: Vec<u32> = (0..points.len() as u32)
        .filter(|&v| points[v as usize].iter().all(|c| c.is_finite()))
        .collect();
    let at = |v: u32| &points[v as usize];
    sorted.par_sort_unstable_by(|&v, &w| order(at(v), at(w)).then(v.cmp(&w)));
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
