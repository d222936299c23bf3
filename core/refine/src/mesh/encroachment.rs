//! The encroachment index: pending boundary items and their closed balls.
//!
//! A present item that no vertex encroaches is guarded by the tetrahedra around it: a new point in
//! its ball takes one of them into its cavity. An item whose repair waits has no such guard, and a
//! missing one is in no tetrahedron at all. The index finds them by place: a hash grid with one
//! level per power of two of the radius, cells at least two radii wide, so that a ball lies in at
//! most eight cells and a query looks at one cell of each level in use.

use super::item::Item;
use crate::table::Map;
use ltbw_exact::Point;

/// Cells of this level and above are one cell: larger than any box of fine steps.
const TOP: i32 = 57;

/// Level and place of a cell.
type Cell = [i64; 4];

/// Pending segments and subfaces by place.
#[derive(Debug)]
pub(crate) struct EncroachmentIndex {
    cells: Map<Cell, Vec<Item>>,
    /// Per item: the ball under which it was entered.
    balls: Map<Item, (Point, f64)>,
    /// Items per level.
    levels: [u32; TOP as usize + 1],
}

impl Default for EncroachmentIndex {
    fn default() -> Self {
        let levels = [0; TOP as usize + 1];
        Self { cells: Map::default(), balls: Map::default(), levels }
    }
}

/// The level for a ball: cells of 2^level fine steps, at least two radii.
fn level(radius: f64) -> i32 {
    let size = 2.0 * radius.max(1.0);
    let exponent = (size.to_bits() >> 52) as i32 - 1023 + 1;
    exponent.min(TOP)
}

fn place(c: f64, level: i32) -> i64 {
    if level == TOP { 0 } else { (c / (1i64 << level) as f64).floor() as i64 }
}

/// The cells that a ball touches.
fn cells(centre: &Point, radius: f64) -> (i32, [[i64; 2]; 3]) {
    let level = level(radius);
    (level, centre.map(|c| [place(c - radius, level), place(c + radius, level)]))
}

impl EncroachmentIndex {
    /// Enters an item with a ball that contains its own (the rounding of centre and radius is
    /// covered here). `false` if it is there already.
    pub(crate) fn enter(&mut self, item: Item, centre: Point, radius: f64) -> bool {
        if self.balls.contains_key(&item) {
            return false;
        }
        let radius = radius * (1.0 + 1e-6) + 2.0;
        self.balls.insert(item, (centre, radius));
        let (level, range) = cells(&centre, radius);
        self.levels[level as usize] += 1;
        for_each_cell(level, range, |cell| self.cells.entry(cell).or_default().push(item));
        true
    }

    /// Removes an item, if it is there.
    pub(crate) fn remove(&mut self, item: Item) {
        let Some((centre, radius)) = self.balls.remove(&item) else { return };
        let (level, range) = cells(&centre, radius);
        self.levels[level as usize] -= 1;
        for_each_cell(level, range, |cell| {
            if let Some(items) = self.cells.get_mut(&cell) {
                items.retain(|i| *i != item);
                if items.is_empty() {
                    self.cells.remove(&cell);
                }
            }
        });
    }

    /// All items whose ball may contain `p`: a superset, in no particular order.
    pub(crate) fn near(&self, p: &Point) -> impl Iterator<Item = Item> + '_ {
        let p = *p;
        let top = if self.balls.is_empty() { -1 } else { TOP };
        let used = (0..=top).filter(|&l| self.levels[l as usize] > 0);
        used.flat_map(move |level| {
            let cell = [level.into(), place(p[0], level), place(p[1], level), place(p[2], level)];
            self.cells.get(&cell).into_iter().flatten().copied()
        })
    }
}

/// Calls `act` for every cell of a range.
fn for_each_cell(level: i32, [x, y, z]: [[i64; 2]; 3], mut act: impl FnMut(Cell)) {
    for i in x[0]..=x[1] {
        for j in y[0]..=y[1] {
            (z[0]..=z[1]).for_each(|k| act([level.into(), i, j, k]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltbw_core::topology::VertexId;
    use ltbw_domain::vector::distance2;

    #[test]
    fn every_ball_around_a_point_is_found() {
        let mut s = 7u64;
        let mut next = move || {
            s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (s >> 33) as f64 / f64::from(1u32 << 31)
        };
        let mut index = EncroachmentIndex::default();
        let mut balls = Vec::new();
        for k in 0..600u32 {
            let centre = [0; 3].map(|_| (next() - 0.5) * 1e15);
            let radius = 10f64.powf(next() * 20.0);
            let item = Item::Segment([k, k + 1].map(VertexId::new));
            assert!(index.enter(item, centre, radius));
            balls.push((item, centre, radius));
        }
        let mut hits = 0;
        for round in 0..3 {
            for _ in 0..500 {
                let p = [0; 3].map(|_| (next() - 0.5) * 1e15);
                let found: Vec<Item> = index.near(&p).collect();
                for (item, centre, radius) in &balls {
                    if distance2(centre, &p) <= radius * radius {
                        hits += 1;
                        assert!(found.contains(item), "round {round}");
                    }
                }
                assert!(found.iter().all(|i| balls.iter().any(|b| b.0 == *i)));
            }
            for (item, ..) in balls.drain(..200) {
                index.remove(item);
            }
        }
        assert!(hits > 1000, "{hits}");
        assert!(index.cells.is_empty() && index.levels == [0; TOP as usize + 1]);
    }
}
