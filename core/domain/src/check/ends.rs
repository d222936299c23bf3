//! Open edges in the exterior: a gap through which the outside leaks in, or the end of a sheet?
//!
//! Nothing but the place of the edges can tell. Those of one sheet are taken together where they
//! meet in a vertex. A set whose facets lie in one plane is the rim of a flat sheet. Otherwise it
//! is a gap if it has no end, so that it runs around something; or if one more facet would close
//! it: its vertices lie in one plane, and an edge joins its two ends. The rest are ends of bent
//! sheets.

use super::cells::{Sets, edges};
use super::complex::Complex;
use super::contact::sides_of;
use crate::triangulate::sorted;
use ltbw_exact::predicates::{collinear, orient3d};
use std::collections::{BTreeMap, HashMap, HashSet};

/// An edge of one triangle only, with that triangle.
type Open = ([u32; 2], u32);

/// For each open edge whether it is one of a gap.
pub(super) fn gaps(complex: &Complex<'_>, open: &[Open]) -> Vec<bool> {
    if open.is_empty() {
        return Vec::new();
    }
    let mut sets: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    let sheets = sheets(complex);
    for (i, set) in connected(open, &sheets).into_iter().enumerate() {
        sets.entry(set).or_default().push(i);
    }
    let all: HashSet<[u32; 2]> =
        complex.triangles.iter().flat_map(|&t| sides_of(t)).map(sorted).collect();
    let mut found = vec![false; open.len()];
    for set in sets.into_values() {
        let edges: Vec<Open> = set.iter().map(|&i| open[i]).collect();
        let is_gap = is_gap(complex, &edges, &|edge| all.contains(&sorted(edge)));
        set.iter().for_each(|&i| found[i] = is_gap);
    }
    found
}

/// For each triangle the sheet that it is of: triangles that edges of two of them connect.
fn sheets(complex: &Complex<'_>) -> Vec<u32> {
    let mut sets = Sets::new(complex.triangles.len());
    for group in edges(complex).chunk_by(|a, b| a.0 == b.0) {
        if let [one, other] = group {
            sets.unite(one.1, other.1);
        }
    }
    (0..complex.triangles.len() as u32).map(|t| sets.find(t)).collect()
}

/// For each edge the number of its set: edges of one sheet that meet in vertices.
fn connected(open: &[Open], sheets: &[u32]) -> Vec<u32> {
    let key = |v: u32, t: u32| (v, sheets[t as usize]);
    let mut at: HashMap<(u32, u32), Vec<u32>> = HashMap::new();
    for (i, &(edge, t)) in (0..).zip(open) {
        edge.iter().for_each(|&v| at.entry(key(v, t)).or_default().push(i));
    }
    let mut set = vec![u32::MAX; open.len()];
    for first in 0..open.len() as u32 {
        let mut stack = vec![first];
        // Every edge is numbered once.
        while let Some(i) = stack.pop() {
            if set[i as usize] == u32::MAX {
                set[i as usize] = first;
                let (edge, t) = open[i as usize];
                stack.extend(edge.iter().flat_map(|&v| &at[&key(v, t)]));
            }
        }
    }
    set
}

fn is_gap(complex: &Complex<'_>, edges: &[Open], has_edge: &dyn Fn([u32; 2]) -> bool) -> bool {
    let mut sheet: Vec<u32> =
        edges.iter().flat_map(|&(_, t)| complex.triangles[t as usize]).collect();
    if is_flat(complex, &mut sheet) {
        return false;
    }
    let mut degree: BTreeMap<u32, u32> = BTreeMap::new();
    edges.iter().flat_map(|(edge, _)| edge).for_each(|&v| *degree.entry(v).or_default() += 1);
    let ends: Vec<u32> = degree.iter().filter(|(_, n)| **n == 1).map(|(&v, _)| v).collect();
    let mut rim: Vec<u32> = degree.into_keys().collect();
    match ends[..] {
        [] => true,
        [a, b] => has_edge([a, b]) && rim.len() > 2 && is_flat(complex, &mut rim),
        _ => false,
    }
}

/// Do these vertices lie in one plane?
fn is_flat(complex: &Complex<'_>, vertices: &mut Vec<u32>) -> bool {
    vertices.sort_unstable();
    vertices.dedup();
    let at = |v: u32| &complex.points[v as usize];
    let [a, b, ref rest @ ..] = vertices[..] else { return true };
    let Some(&c) = rest.iter().find(|&&c| !collinear(at(a), at(b), at(c))) else { return true };
    rest.iter().all(|&d| orient3d(at(a), at(b), at(c), at(d)).is_zero())
}
