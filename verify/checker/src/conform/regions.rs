//! The numbers of regions, from the seeds of the domain.

use super::{ConformityDefect, Regions, Run};
use std::collections::HashMap;

impl Run<'_> {
    /// Tags are the numbers of regions: 1 around the first seed, the next one around the next seed
    /// that is elsewhere, and so on; around no seed they are higher. (What is between the sides of
    /// a patch has no seed of its own, and may belong to any region.)
    pub(super) fn numbers(&mut self, regions: Regions<'_>, tags: Option<&[i64]>) {
        let Regions { cells, seeds } = regions;
        let mut numbers: HashMap<u32, i64> = HashMap::new();
        for &cell in seeds.iter().flatten() {
            let next = numbers.len() as i64 + 1;
            numbers.entry(cell).or_insert(next);
        }
        let seeded = numbers.len() as i64;
        for (t, (cell, &tag)) in (0u32..).zip(cells.iter().zip(tags.unwrap_or_default())) {
            let is_right = match numbers.get(cell) {
                Some(&number) => tag == number,
                None => tag > seeded || self.out.patches > 0,
            };
            if !is_right {
                self.add(ConformityDefect::TagNotOfSeed, &[t]);
            }
        }
    }
}
