//! Parallel sweeps whose result does not depend on the number of threads: the pieces are merged
//! in order.

use crate::defect::Findings;
use crate::predicates::Tally;
use rayon::prelude::*;
use std::ops::Range;

/// The result of a sweep over a part of the mesh.
#[derive(Debug, Clone)]
pub(crate) struct Partial {
    pub(crate) findings: Findings,
    /// Tests of the level's predicate, by what decided them.
    pub(crate) tally: Tally,
    /// Tests that could not be posed, because a defect below leaves their question without sense.
    pub(crate) untested: u64,
}

impl Partial {
    pub(crate) fn new(limit: usize) -> Self {
        Self { findings: Findings::new(limit), tally: Tally::default(), untested: 0 }
    }

    pub(crate) fn merge(&mut self, later: Self) {
        self.findings.merge(later.findings);
        self.tally.merge(later.tally);
        self.untested += later.untested;
    }

    /// The results of the parts of two levels that are tested together.
    pub(crate) fn both(parts: Vec<Levels>, limit: usize) -> Levels {
        parts.into_iter().fold(Levels::new(limit), |mut all, part| {
            all.delaunay.merge(part.delaunay);
            all.canonical.merge(part.canonical);
            all
        })
    }
}

/// The results of two levels that are tested together.
#[derive(Debug, Clone)]
pub(crate) struct Levels {
    pub(crate) delaunay: Partial,
    /// Of ties: what the perturbation decides.
    pub(crate) canonical: Partial,
}

impl Levels {
    pub(crate) fn new(limit: usize) -> Self {
        Self { delaunay: Partial::new(limit), canonical: Partial::new(limit) }
    }
}

/// Number of elements in a piece: small enough to balance, large enough to cost nothing.
const PIECE: usize = 1 << 14;

/// Runs `part` over the pieces of `0..count` on the current rayon pool; results in order.
pub(crate) fn pieces<T: Send>(count: usize, part: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    pieces_of(PIECE, count, part)
}

/// [`pieces`] with a chosen piece length, at least 1.
pub(crate) fn pieces_of<T: Send>(
    length: usize,
    count: usize,
    part: impl Fn(Range<usize>) -> T + Sync,
) -> Vec<T> {
    let length = length.max(1);
    (0..count.div_ceil(length))
        .into_par_iter()
        .map(|i| part(i * length..count.min((i + 1) * length)))
        .collect()
}

/// A compressed table: for each of `count` keys, the values given with it, in the order given.
pub(crate) struct Table {
    starts: Vec<u32>,
    values: Vec<u32>,
}

impl Table {
    /// Groups the `(key, value)` pairs that `pairs` emits (twice the same ones, fewer than 2^32,
    /// keys below `count`): a counting sort.
    pub(crate) fn new(count: usize, pairs: impl Fn(&mut dyn FnMut(u32, u32))) -> Self {
        let mut starts = vec![0u32; count + 2];
        pairs(&mut |key, _| starts[key as usize + 2] += 1);
        for k in 2..starts.len() {
            starts[k] += starts[k - 1];
        }
        let mut values = vec![0u32; starts.last().map_or(0, |&n| n as usize)];
        pairs(&mut |key, value| {
            let slot = &mut starts[key as usize + 1];
            values[*slot as usize] = value;
            *slot += 1;
        });
        Self { starts, values }
    }

    /// The values of `key`.
    pub(crate) fn row(&self, key: usize) -> &[u32] {
        &self.values[self.starts[key] as usize..self.starts[key + 1] as usize]
    }
}
