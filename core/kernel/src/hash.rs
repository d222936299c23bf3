//! The canonical mesh hash `ltbw.mesh/1`: a function of the mesh alone, not of numbering,
//! thread count or machine.
//!
//! Vertices used by at least one tetrahedron, `-0.0` as `0.0`, sorted by (x, y, z) and renumbered
//! from 0; each tetrahedron as its four new numbers ascending; tetrahedra sorted
//! lexicographically. SHA-256 over the ASCII bytes `ltbw.mesh/1\n`, the u64 vertex count, the
//! coordinates as f64, the u64 tetrahedron count, the numbers as u32; all little-endian.

use ltbw_exact::Point;
use rayon::prelude::*;
use sha2::{Digest, Sha256};

/// A canonical mesh hash; prints as 64 lower-case hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct MeshHash(pub [u8; 32]);

impl std::fmt::Display for MeshHash {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|b| write!(f, "{b:02x}"))
    }
}

impl std::fmt::Debug for MeshHash {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "MeshHash({self})")
    }
}

/// Why a mesh has no canonical hash.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HashError {
    /// A tetrahedron names a vertex that does not exist.
    #[error("tetrahedron {tet} names vertex {vertex}, but there are {vertices} vertices")]
    Index {
        /// The tetrahedron.
        tet: usize,
        /// The index it names.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// Two used vertices lie at the same place, so the order of vertices is not defined.
    #[error("vertices {first} and {second} are both used and both lie at {at:?}")]
    EqualVertices {
        /// The smaller index.
        first: u32,
        /// The larger index.
        second: u32,
        /// Their common coordinates.
        at: Point,
    },
    /// A used vertex has a coordinate that is not a number.
    #[error("vertex {vertex} has the coordinates {at:?}, which are not all finite")]
    NotFinite {
        /// The vertex.
        vertex: u32,
        /// Its coordinates.
        at: Point,
    },
}

/// Computes `ltbw.mesh/1` of the tetrahedra `tets` over `points`. Unused points do not matter.
///
/// Cost: O((V + T) log (V + T)) time, sorting in parallel on the current rayon pool;
/// O(V + T) memory.
pub fn canonical_hash(points: &[Point], tets: &[[u32; 4]]) -> Result<MeshHash, HashError> {
    const UNUSED: u32 = u32::MAX;
    let mut rank = vec![UNUSED; points.len()];
    for (i, tet) in tets.iter().enumerate() {
        for &v in tet {
            match rank.get_mut(v as usize) {
                Some(r) => *r = 0,
                None => {
                    return Err(HashError::Index { tet: i, vertex: v, vertices: points.len() });
                }
            }
        }
    }
    let clean = |v: u32| points[v as usize].map(|c| c + 0.0); // -0.0 + 0.0 is 0.0
    let mut used: Vec<(Point, u32)> =
        (0u32..).zip(&rank).filter(|&(_, &r)| r != UNUSED).map(|(v, _)| (clean(v), v)).collect();
    if let Some(&(at, vertex)) = used.iter().find(|(p, _)| p.iter().any(|c| !c.is_finite())) {
        return Err(HashError::NotFinite { vertex, at });
    }
    used.par_sort_unstable_by(|(p, i), (q, j)| {
        p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(p[2].total_cmp(&q[2])).then(i.cmp(j))
    });
    if let Some(w) = used.windows(2).find(|w| w[0].0 == w[1].0) {
        return Err(HashError::EqualVertices { first: w[0].1, second: w[1].1, at: w[0].0 });
    }
    for (k, &(_, v)) in (0u32..).zip(&used) {
        rank[v as usize] = k;
    }
    // As one number each, which are compared faster than lists.
    let row = |t: &[u32; 4]| {
        let mut row = t.map(|v| rank[v as usize]);
        row.sort_unstable();
        row.iter().fold(0, |all: u128, &v| all << 32 | u128::from(v))
    };
    let mut rows: Vec<u128> = tets.par_iter().map(row).collect();
    rows.par_sort_unstable();

    let mut sha = Sha256::new_with_prefix(b"ltbw.mesh/1\n");
    let mut block = Vec::with_capacity(1 << 16);
    sha.update((used.len() as u64).to_le_bytes());
    for chunk in used.chunks(2048) {
        block.clear();
        block.extend(chunk.iter().flat_map(|(p, _)| *p).flat_map(f64::to_le_bytes));
        sha.update(&block);
    }
    sha.update((rows.len() as u64).to_le_bytes());
    for chunk in rows.chunks(4096) {
        block.clear();
        let numbers = chunk.iter().flat_map(|row| [96, 64, 32, 0].map(|low| (row >> low) as u32));
        block.extend(numbers.flat_map(u32::to_le_bytes));
        sha.update(&block);
    }
    Ok(MeshHash(sha.finalize().into()))
}
