//! Kernel vertices by public number: the way back from what callers know.

use crate::topology::{INFINITE, VertexId};

/// In place of a number where there is no vertex. No point has it.
pub(crate) const VACANT: u32 = u32::MAX;

/// A point at the place of a vertex. It is stored as the pair of both numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "(u32, u32)", into = "(u32, u32)"))]
pub struct Duplicate {
    /// Number of the point.
    pub number: u32,
    /// Number of the vertex at its place, which is smaller.
    pub kept: u32,
}

impl From<(u32, u32)> for Duplicate {
    fn from((number, kept): (u32, u32)) -> Self {
        Self { number, kept }
    }
}

impl From<Duplicate> for (u32, u32) {
    fn from(duplicate: Duplicate) -> Self {
        (duplicate.number, duplicate.kept)
    }
}

/// Kernel vertices by public number.
#[derive(Debug)]
pub(crate) enum Numbering {
    /// By index; [`INFINITE`] stands for none.
    Dense(Vec<VertexId>),
    /// By number, ascending: few numbers have a vertex, as after a build that was cut short.
    Sparse(Vec<(u32, VertexId)>),
}

impl Numbering {
    /// The numbering of kernel vertices with `numbers`, of which the first stands for the vertex at
    /// infinity, and of `duplicates`.
    pub(crate) fn new(numbers: &[u32], duplicates: &[Duplicate]) -> Self {
        let there = numbers.iter().skip(1).copied().filter(|&number| number != VACANT);
        let all = there.chain(duplicates.iter().map(|d| d.number));
        let count = all.max().map_or(0, |v| v as usize + 1);
        let used = numbers.len() + duplicates.len();
        if count > 4 * used + 1024 {
            Self::sparse(numbers, duplicates)
        } else {
            Self::dense(numbers, duplicates, count)
        }
    }

    /// `count` is above all numbers.
    fn dense(numbers: &[u32], duplicates: &[Duplicate], count: usize) -> Self {
        let mut kernel = vec![INFINITE; count];
        for (number, v) in vertices(numbers) {
            kernel[number as usize] = v;
        }
        for &Duplicate { number, kept } in duplicates {
            kernel[number as usize] = kernel[kept as usize];
        }
        Self::Dense(kernel)
    }

    fn sparse(numbers: &[u32], duplicates: &[Duplicate]) -> Self {
        let mut pairs: Vec<_> = vertices(numbers).collect();
        pairs.sort_unstable();
        let kept = Self::Sparse(pairs);
        let duplicates = duplicates.iter();
        let mut all: Vec<_> =
            duplicates.filter_map(|d| Some((d.number, kept.get(d.kept)?))).collect();
        if let Self::Sparse(pairs) = kept {
            all.extend(pairs);
        }
        all.sort_unstable();
        Self::Sparse(all)
    }

    pub(crate) fn get(&self, v: u32) -> Option<VertexId> {
        match self {
            Self::Dense(kernel) => kernel.get(v as usize).copied().filter(|&k| k != INFINITE),
            Self::Sparse(pairs) => {
                let at = pairs.binary_search_by_key(&v, |pair| pair.0).ok()?;
                pairs.get(at).map(|pair| pair.1).filter(|&k| k != INFINITE)
            }
        }
    }

    /// Notes a new kernel vertex whose number is the next one; false if it is another.
    pub(crate) fn note(&mut self, number: u32, v: VertexId) -> bool {
        match self {
            Self::Dense(kernel) if kernel.len() == number as usize => kernel.push(v),
            Self::Sparse(pairs) if pairs.last().is_none_or(|last| last.0 < number) => {
                pairs.push((number, v));
            }
            _ => return false,
        }
        true
    }

    /// Forgets the vertex of a number.
    pub(crate) fn forget(&mut self, number: u32) {
        let place = match self {
            Self::Dense(kernel) => kernel.get_mut(number as usize),
            Self::Sparse(pairs) => {
                let at = pairs.binary_search_by_key(&number, |pair| pair.0);
                at.ok().and_then(|at| pairs.get_mut(at)).map(|pair| &mut pair.1)
            }
        };
        if let Some(place) = place {
            *place = INFINITE;
        }
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        match self {
            Self::Dense(kernel) => kernel.capacity() * size_of::<VertexId>(),
            Self::Sparse(pairs) => pairs.capacity() * size_of::<(u32, VertexId)>(),
        }
    }
}

/// Kernel vertices with their numbers.
fn vertices(numbers: &[u32]) -> impl Iterator<Item = (u32, VertexId)> + '_ {
    let all = numbers.iter().copied().zip((0..).map(VertexId::new)).skip(1);
    all.filter(|&(number, _)| number != VACANT)
}
