//! Figures that workers tell of their splits.

/// The figures of one worker's refinement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Splits {
    /// Points inserted on segments, on facets, and inside.
    pub inserted: [u64; 3],
    /// Points that gave way to a boundary item.
    pub deferred: u64,
    /// Points that did not do what they were made for.
    pub useless: u64,
    /// Boundary items, and tetrahedra, that were given up.
    pub refused: [u64; 2],
}

impl Splits {
    pub(in super::super) fn add(&mut self, other: &Self) {
        // They may have come from another process.
        let add = |sum: &mut u64, own: u64| *sum = sum.saturating_add(own);
        self.inserted.iter_mut().zip(other.inserted).for_each(|(sum, own)| add(sum, own));
        add(&mut self.deferred, other.deferred);
        add(&mut self.useless, other.useless);
        self.refused.iter_mut().zip(other.refused).for_each(|(sum, own)| add(sum, own));
    }
}
