//! Which cells of an oriented surface, or of bodies in bodies, are inside.

use super::cells::{OUTSIDE, Sets, edges};
use super::seeds::Question;
use super::{Cell, CheckOptions, Findings};
use crate::{DefectKind, Element};
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// The count of a step over facets between two cells, from the first to the second.
type Steps = BTreeMap<[u32; 2], i64>;

/// A step over facets between two cells.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Step {
    cells: [u32; 2],
    /// The count from the first to the second.
    count: i64,
}

/// A cell that a step has reached.
struct Reached {
    cell: u32,
    from: u32,
    /// The count of the step.
    step: i64,
}

impl Question<'_> {
    /// Decides which cells are filled. All of them are, unless the surface is oriented or bodies in
    /// bodies are voids.
    pub(super) fn fill(&self, options: &CheckOptions, found: &mut [Cell], findings: &mut Findings) {
        let filled = match (options.oriented, options.nested_voids) {
            (true, true) => self.depth().or_else(|| Some(self.nesting())),
            (false, true) => Some(self.nesting()),
            (true, false) => self.by_orientation(findings).or_else(|| self.depth()),
            (false, false) => None,
        };
        for (cell, filled) in found.iter_mut().zip(filled.iter().flat_map(|f| &f[1..])) {
            cell.filled = *filled;
        }
    }

    /// Pairs of different cells that facets part, the smaller first, by triangles: whether the
    /// facet is an inner one, and whether the triangle's front is in the second.
    fn steps(&self) -> impl Iterator<Item = ([u32; 2], bool, bool)> + '_ {
        (0..self.complex.triangles.len()).filter_map(|t| {
            let [front, back] = self.cells.beside(t);
            let inner = self.is_inner(t);
            (front != back).then(|| ([front.min(back), front.max(back)], inner, front > back))
        })
    }

    /// For each cell whether it is inside by the orientation of facets: what a shell in the
    /// exterior bounds is, and what one inside bounds unless it is turned the other way than that
    /// around it. Between two cells the most of the triangles say how they are turned. `None` if
    /// what winds around a cell depends on the way to it. Reports each body inside another.
    fn by_orientation(&self, findings: &mut Findings) -> Option<Vec<bool>> {
        let (mut plain, mut inner) = (Steps::new(), Steps::new());
        for (pair, is_inner, front_is_second) in self.steps() {
            // From the front to the back it is one more.
            let step = match (is_inner, front_is_second) {
                (true, _) => 0,
                (false, true) => -1,
                (false, false) => 1,
            };
            *if is_inner { &mut inner } else { &mut plain }.entry(pair).or_default() += step;
        }
        // As many triangles either way tell nothing.
        if plain.iter().any(|(pair, sum)| *sum == 0 || inner.contains_key(pair)) {
            return None;
        }
        let steps = plain.into_iter().chain(inner);
        let steps = steps.map(|(cells, sum)| Step { cells, count: sum.signum() });
        let (_, reached) = self.spread(steps, |own, step| own + step)?;
        // The way that what is inside is turned, and 0 for the exterior.
        let mut turned = vec![0; self.cells.count as usize];
        let mut nested = HashSet::new();
        for Reached { cell, from, step } in reached {
            let around = turned[from as usize];
            turned[cell as usize] = match step {
                0 => around,
                step if around == -step => 0,
                step => step,
            };
            if step != 0 && around == step {
                nested.insert([cell, from]);
            }
        }
        self.tell_nested(nested, findings);
        Some(turned.into_iter().map(|turn| turn != 0).collect())
    }

    /// Reports bodies inside others, each by the first triangle between its cell and that around.
    fn tell_nested(&self, mut nested: HashSet<[u32; 2]>, findings: &mut Findings) {
        for t in 0..self.complex.triangles.len() {
            let [a, b] = self.cells.beside(t);
            if nested.is_empty() {
                return;
            }
            if nested.remove(&[a, b]) || nested.remove(&[b, a]) {
                let at = self.complex.triangles[t].map(|v| self.at(v)).to_vec();
                let facet = Element::Facet(self.complex.facet_of[t]);
                findings.add(DefectKind::Nested, vec![facet], at);
            }
        }
    }

    /// For each cell whether the number of facets between it and the outside is odd, inner facets
    /// not counted; `None` if that depends on the way.
    fn depth(&self) -> Option<Vec<bool>> {
        let step =
            |(cells, inner, _): ([u32; 2], bool, bool)| Step { cells, count: i64::from(!inner) };
        let steps: BTreeSet<Step> = self.steps().map(step).collect();
        let (odd, _) = self.spread(steps.into_iter(), |own, step| (own + step).rem_euclid(2))?;
        Some(odd.into_iter().map(|odd| odd == 1).collect())
    }

    /// Spreads a number from the outside, where it is 0, over pairs of cells; `None` if it depends
    /// on the way, or does not reach all. With the cells in the order in which they are reached.
    fn spread(
        &self,
        steps: impl Iterator<Item = Step>,
        next: impl Fn(i64, i64) -> i64,
    ) -> Option<(Vec<i64>, Vec<Reached>)> {
        let count = self.cells.count as usize;
        let mut neighbours: Vec<Vec<(u32, i64)>> = vec![Vec::new(); count];
        for Step { cells: [a, b], count } in steps {
            neighbours[a as usize].push((b, count));
            neighbours[b as usize].push((a, -count));
        }
        let mut numbers: Vec<Option<i64>> = vec![None; count];
        numbers[OUTSIDE as usize] = Some(0);
        let (mut stack, mut reached) = (vec![OUTSIDE], Vec::new());
        // Every cell is pushed once.
        while let Some(cell) = stack.pop() {
            let own = numbers[cell as usize]?;
            for &(other, step) in &neighbours[cell as usize] {
                let number = next(own, step);
                match numbers[other as usize] {
                    Some(known) if known == number => {}
                    Some(_) => return None,
                    None => {
                        numbers[other as usize] = Some(number);
                        stack.push(other);
                        reached.push(Reached { cell: other, from: cell, step });
                    }
                }
            }
        }
        let numbers: Option<Vec<i64>> = numbers.into_iter().collect();
        Some((numbers?, reached))
    }

    /// For each cell whether it is inside, if shells (triangles that edges connect) in what is
    /// inside bound voids, and those in voids bodies.
    fn nesting(&self) -> Vec<bool> {
        let mut sets = Sets::new(self.complex.triangles.len());
        for group in edges(self.complex).chunk_by(|a, b| a.0 == b.0) {
            group[1..].iter().for_each(|side| sets.unite(group[0].1, side.1));
        }
        let count = self.cells.count as usize;
        let mut shells_at: Vec<Vec<u32>> = vec![Vec::new(); count];
        let mut cells_at: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for t in 0..self.complex.triangles.len() as u32 {
            let shell = sets.find(t);
            for cell in self.cells.beside(t as usize) {
                shells_at[cell as usize].push(shell);
                cells_at.entry(shell).or_default().push(cell);
            }
        }
        let mut filled: Vec<Option<bool>> = vec![None; count];
        filled[OUTSIDE as usize] = Some(false);
        let mut stack = vec![OUTSIDE];
        // Every shell is taken once, and every cell pushed once.
        while let Some(cell) = stack.pop() {
            let beyond = !filled[cell as usize].unwrap_or_default();
            for shell in std::mem::take(&mut shells_at[cell as usize]) {
                for other in cells_at.remove(&shell).unwrap_or_default() {
                    if filled[other as usize].is_none() {
                        filled[other as usize] = Some(beyond);
                        stack.push(other);
                    }
                }
            }
        }
        filled.into_iter().map(Option::unwrap_or_default).collect()
    }
}
