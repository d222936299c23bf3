//! The checker's own adjacency, from the list of tetrahedra alone.
//!
//! Faces are put into one bucket per smallest vertex (a counting sort), then matched inside each
//! bucket by their two other vertices; buckets in parallel. In a usual mesh a bucket holds some
//! 27 faces, so this costs a fraction of sorting all faces. Memory: 8 words of 4 bytes per
//! tetrahedron. Threads share the result ([`Numbers`]): each entry is written at most once and read
//! after the sweep.

use crate::chunks::{Partial, Table, pieces_of};
use crate::defect::{Findings, Kind};
use crate::mesh::{Mesh, Side, split};
use crate::sync::Numbers;

/// No tetrahedron on the other side.
pub(crate) const HULL: u32 = u32::MAX;
/// The face belongs to an unsound tetrahedron or to three or more: no statement about it.
pub(crate) const NONE: u32 = u32::MAX - 1;

/// The adjacency: entry `4 t + i` is the code `4 u + j` of the other side of the face of `t`
/// opposite its vertex `i`, or [`HULL`] or [`NONE`].
pub(crate) struct Faces {
    pub(crate) across: Vec<u32>,
    /// Codes of the hull facets, ascending.
    pub(crate) hull: Vec<u32>,
    /// Number of different faces.
    pub(crate) count: u64,
}

impl Faces {
    /// The other side of face `i` of tetrahedron `t`, if there is one.
    pub(crate) fn other(&self, t: usize, i: usize) -> Option<Side> {
        let code = self.across[4 * t + i];
        (code < NONE).then(|| split(code))
    }
}

/// Matches the faces of the sound tetrahedra. Removes all but the first of duplicated tetrahedra
/// from `sound` and reports them, and faces of three or more.
pub(crate) fn matched(mesh: &Mesh, sound: &mut [bool], limit: usize, out: &mut Findings) -> Faces {
    let tets = mesh.tets;
    let table = Table::new(mesh.points.len(), |emit| {
        for (t, tet) in tets.iter().enumerate().filter(|&(t, _)| sound[t]) {
            for i in 0..4 {
                let smallest = (0..4).filter(|&k| k != i).map(|k| tet[k]).min();
                emit(smallest.unwrap_or(0), (4 * t + i) as u32);
            }
        }
    });
    let across = Numbers::new(4 * tets.len(), NONE);
    let parts = pieces_of(1 << 12, mesh.points.len(), |range| {
        let mut part = Partial::new(limit);
        let mut duplicates = Vec::new();
        let mut faces = 0u64;
        let mut bucket: Vec<Coded> = Vec::new();
        for v in range {
            bucket.clear();
            bucket.extend(
                table.row(v).iter().map(|&code| Coded { two: other_two(tets, code), code }),
            );
            bucket.sort_unstable();
            for group in bucket.chunk_by_mut(|a, b| a.two == b.two) {
                faces += 1;
                match group {
                    [face] => across.set(face.code, HULL),
                    [a, b] if apex(tets, a.code) != apex(tets, b.code) => {
                        across.set(a.code, b.code);
                        across.set(b.code, a.code);
                    }
                    _ => face_of_many(tets, group, &across, &mut duplicates, &mut part.findings),
                }
            }
        }
        (part, duplicates, faces)
    });
    let mut count = 0;
    for (part, duplicates, faces) in parts {
        out.merge(part.findings);
        duplicates.iter().for_each(|&t: &u32| sound[t as usize] = false);
        count += faces;
    }
    let across = across.into_plain();
    let hull = (0u32..).zip(&across).filter(|&(_, &c)| c == HULL).map(|(i, _)| i).collect();
    Faces { across, hull, count }
}

/// A face of a tetrahedron, in the bucket of its smallest vertex.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Coded {
    /// Its other two vertices, as [`other_two`] has them.
    two: u64,
    code: u32,
}

/// The vertex of the tetrahedron opposite the face.
fn apex(tets: &[[u32; 4]], code: u32) -> u32 {
    let Side { t, i } = split(code);
    tets[t][i]
}

/// The two larger vertices of a face, packed so that equal faces of a bucket are equal numbers.
fn other_two(tets: &[[u32; 4]], code: u32) -> u64 {
    let Side { t, i } = split(code);
    let [a, b, c] = crate::mesh::face(&tets[t], i);
    let (low, high) = (a.min(b), a.max(b));
    let (middle, high) = (c.min(high).max(low), c.max(high));
    u64::from(middle) << 32 | u64::from(high)
}

/// A face with duplicated tetrahedra, or with three or more. Of tetrahedra with the same apex the
/// first counts; each duplicate is reported once, at the face opposite its largest vertex.
fn face_of_many(
    tets: &[[u32; 4]],
    group: &mut [Coded],
    across: &Numbers,
    duplicates: &mut Vec<u32>,
    out: &mut Findings,
) {
    group.sort_unstable_by_key(|face| (apex(tets, face.code), face.code));
    let mut distinct = Vec::new();
    for same in group.chunk_by(|a, b| apex(tets, a.code) == apex(tets, b.code)) {
        let first = same[0].code;
        distinct.push(first);
        let Side { t, i } = split(first);
        if tets[t].iter().all(|&v| v <= tets[t][i]) {
            for &Coded { code, .. } in &same[1..] {
                out.add(Kind::DuplicateTet, &[t as u32, code >> 2], &tets[t]);
                duplicates.push(code >> 2);
            }
        }
    }
    match distinct[..] {
        [a] => across.set(a, HULL),
        [a, b] => {
            across.set(a, b);
            across.set(b, a);
        }
        _ => {
            distinct.sort_unstable();
            let owners: Vec<u32> = distinct.iter().map(|c| c >> 2).collect();
            let Side { t, i } = split(distinct[0]);
            out.add(Kind::FaceOverused, &owners, &crate::mesh::face(&tets[t], i));
        }
    }
}
