//! The geometry of a patch: its polygons in the projection along an axis, each with its own plane.

use super::carrier::{Grid, Plane, UNIT, corner_point};
use crate::table::edge;
use ltbw_exact::Point;

/// A point of the projection, in fine steps.
pub(crate) type Flat = [i128; 2];

/// The labels on both sides of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sides {
    pub(crate) inner: u32,
    /// The exterior, or else the lower region: flat tetrahedra of the patch belong to it.
    pub(crate) outer: u32,
    /// Is the inner side in the direction of the axis?
    pub(crate) upwards: bool,
}

/// A polygon of a patch by its corners, with its own plane.
pub(crate) struct Piece {
    pub(crate) corners: Vec<u32>,
    pub(crate) plane: Plane,
}

/// Polygons that are coplanar within the tolerance.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    /// The facet of the domain that it grew from.
    pub(crate) first: u32,
    /// The axis along which it is projected.
    pub(crate) axis: usize,
    /// Known when the boundary is complete.
    pub(crate) sides: Option<Sides>,
    /// The polygons, counter-clockwise in the projection.
    pieces: Vec<(Vec<Flat>, Plane)>,
    /// The outline: sides that one polygon has.
    outline: Vec<[Flat; 2]>,
    /// The heights of their ends, along the axis.
    heights: Vec<[f64; 2]>,
    /// Cells of a grid over the projection with the polygons, and the sides of the outline, that
    /// may touch them.
    cells: Vec<Vec<u32>>,
    outline_cells: Vec<Vec<u32>>,
    low: Flat,
    /// The sides of a cell, and the number of cells in each direction.
    size: Flat,
    count: usize,
}

/// The most times that patches are looked for, each time without those that were not found.
pub(crate) const DISSOLVED: u32 = 8;

/// Why patches are not in the mesh.
pub(crate) struct Unfound {
    /// The number of all.
    pub(crate) patches: usize,
    /// The facets that those grew from without which the others may be found.
    pub(crate) dissolve: Vec<u32>,
}

/// Twice the signed area of a triangle; coordinates are at most 2^53.
pub(crate) fn turn(a: Flat, b: Flat, c: Flat) -> i128 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The projection of a point of whole coordinates along an axis.
pub(crate) fn flat(axis: usize, p: &Point) -> Flat {
    [p[(axis + 1) % 3] as i128, p[(axis + 2) % 3] as i128]
}

impl Patch {
    pub(crate) fn new(corners: &[Grid], first: u32, axis: usize, polygons: &[Piece]) -> Self {
        let project = |v: &u32| {
            let p = corners[*v as usize];
            [(axis + 1) % 3, (axis + 2) % 3].map(|k| i128::from(p[k]) * i128::from(UNIT))
        };
        let pieces: Vec<(Vec<Flat>, Plane)> = polygons
            .iter()
            .map(|own| (own.corners.iter().map(project).collect(), own.plane))
            .collect();
        let all = || pieces.iter().flat_map(|(ring, _)| ring);
        let low = [0, 1].map(|k| all().map(|p| p[k]).min().unwrap_or(0));
        let high = [0, 1].map(|k| all().map(|p| p[k]).max().unwrap_or(0));
        let sides = outline(polygons);
        let outline: Vec<[Flat; 2]> = sides.iter().map(|s| s.map(|v| project(&v))).collect();
        let height = |v: u32| corner_point(&corners[v as usize])[axis];
        let heights = sides.into_iter().map(|side| side.map(height)).collect();
        let count = ((pieces.len() as f64).sqrt() as usize).clamp(1, 1024);
        let size = [0, 1].map(|k| (high[k] - low[k]) / count as i128 + 1);
        let (sides, cells, outline_cells) = (None, Vec::new(), Vec::new());
        let mut patch = Self {
            first,
            axis,
            sides,
            pieces,
            outline,
            heights,
            cells,
            outline_cells,
            low,
            size,
            count,
        };
        patch.cells = patch.spread(patch.pieces.iter().map(|(ring, _)| &ring[..]));
        patch.outline_cells = patch.spread(patch.outline.iter().map(|side| &side[..]));
        patch
    }

    /// The cells with the numbers of what may touch them.
    fn spread<'p>(&self, all: impl Iterator<Item = &'p [Flat]>) -> Vec<Vec<u32>> {
        let mut cells = vec![Vec::new(); self.count * self.count];
        for (k, points) in (0..).zip(all) {
            self.cells_of(points).for_each(|cell| cells[cell].push(k));
        }
        cells
    }

    /// The cells that the box of some points touches.
    fn cells_of(&self, points: &[Flat]) -> impl Iterator<Item = usize> + use<> {
        let ends = |i: usize| {
            let low = points.iter().map(|p| p[i]).min().unwrap_or(0);
            let high = points.iter().map(|p| p[i]).max().unwrap_or(0);
            self.column(low, i)..=self.column(high, i)
        };
        let (columns, rows, count) = (ends(0), ends(1), self.count);
        columns.flat_map(move |column| rows.clone().map(move |row| column * count + row))
    }

    fn column(&self, c: i128, axis: usize) -> usize {
        ((c - self.low[axis]) / self.size[axis]).clamp(0, self.count as i128 - 1) as usize
    }

    /// The polygons near a point of the projection.
    fn near(&self, p: Flat) -> impl Iterator<Item = &(Vec<Flat>, Plane)> {
        let cell = self.column(p[0], 0) * self.count + self.column(p[1], 1);
        self.cells[cell].iter().map(|&k| &self.pieces[k as usize])
    }

    /// Is a triangle within the polygons, in the projection? So it is if its centroid is and no
    /// side of the outline goes through it. Of one that is nothing in the projection the middles
    /// of its sides decide.
    pub(crate) fn holds_triangle(&self, corners: [&Point; 3]) -> bool {
        let [a, b, c] = corners.map(|p| flat(self.axis, p));
        if !self.holds_mean([a, b, c], 3) {
            return false;
        }
        let zero = [0, 0];
        match turn(a, b, c) {
            0 => [[a, b, zero], [b, c, zero], [c, a, zero]].iter().all(|s| self.holds_mean(*s, 2)),
            1.. => !self.is_cut([a, b, c]),
            _ => !self.is_cut([a, c, b]),
        }
    }

    /// Does a side of the outline go through the inside of a triangle that is counter-clockwise?
    fn is_cut(&self, triangle: [Flat; 3]) -> bool {
        let meets = |&k: &u32| goes_through(self.outline[k as usize], triangle);
        self.cells_of(&triangle).any(|cell| self.outline_cells[cell].iter().any(meets))
    }

    /// The height of a triangle over a side of the outline that goes through it in the projection,
    /// rounded: the farthest of all.
    pub(crate) fn height_over_outline(&self, corners: [&Point; 3]) -> Option<f64> {
        let [a, b, c] = corners.map(|p| flat(self.axis, p));
        let mut points = [(a, corners[0]), (b, corners[1]), (c, corners[2])];
        if turn(a, b, c) < 0 {
            points.swap(1, 2);
        }
        let (triangle, tops) = (points.map(|p| p.0), points.map(|p| p.1[self.axis]));
        let over = |k: u32| {
            let side = self.outline[k as usize];
            let cuts = goes_through(side, triangle);
            cuts.then(|| height_over(side, self.heights[k as usize], triangle, tops))
        };
        let cells = self.cells_of(&triangle);
        let all = cells.flat_map(|cell| self.outline_cells[cell].iter().filter_map(|&k| over(k)));
        all.max_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// Is the sum of some points, divided by their number, in a polygon?
    fn holds_mean(&self, points: [Flat; 3], count: i128) -> bool {
        let sum = [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<i128>());
        let near = sum.map(|c| c.div_euclid(count));
        self.near(near).any(|(ring, _)| {
            let scaled: Vec<Flat> = ring.iter().map(|p| p.map(|c| count * c)).collect();
            holds(&scaled, sum)
        })
    }

    /// A point of few bits on one of the polygons, within about `tolerance` of where `target` is
    /// projected to; `None` if there is none.
    pub(crate) fn place(&self, target: &Point, tolerance: f64) -> Option<Point> {
        let rounded = target.map(f64::round);
        let at = flat(self.axis, &rounded);
        let above = self.near(at).filter(|(ring, _)| holds(ring, at));
        let mut points = above.filter_map(|(ring, plane)| {
            let p = plane.near_along(self.axis, target, tolerance)?;
            holds(ring, flat(self.axis, &p)).then_some(p)
        });
        points.next()
    }

    /// Is a point exactly on one of the polygons?
    pub(crate) fn holds(&self, p: &Point) -> bool {
        let at = flat(self.axis, p);
        self.near(at).any(|(ring, plane)| plane.holds(p) && holds(ring, at))
    }

    /// Twice the area of the polygons in the projection.
    pub(crate) fn area(&self) -> i128 {
        let area = |ring: &Vec<Flat>| -> i128 {
            (2..ring.len()).map(|k| turn(ring[0], ring[k - 1], ring[k])).sum()
        };
        self.pieces.iter().map(|(ring, _)| area(ring)).sum()
    }

    /// Twice the area of a triangle in the projection.
    pub(crate) fn area_of(&self, corners: [&Point; 3]) -> i128 {
        let [a, b, c] = corners.map(|p| flat(self.axis, p));
        turn(a, b, c).abs()
    }

    /// The sign of a triangle's area in the projection.
    pub(crate) fn turn(&self, corners: [&Point; 3]) -> i128 {
        let [a, b, c] = corners.map(|p| flat(self.axis, p));
        turn(a, b, c).signum()
    }
}

/// The sides that one polygon has.
fn outline(polygons: &[Piece]) -> Vec<[u32; 2]> {
    let sides = |ring: &Vec<u32>| {
        let ring = ring.clone();
        (0..ring.len()).map(move |k| edge(ring[k], ring[(k + 1) % ring.len()]))
    };
    let mut all: Vec<[u32; 2]> = polygons.iter().flat_map(|own| sides(&own.corners)).collect();
    all.sort_unstable();
    all.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]).collect()
}

/// Does a line from p to q go through the inside of a counter-clockwise triangle? If not, one of
/// the sides, or the line, has nothing of the other strictly on its inner side.
fn goes_through([p, q]: [Flat; 2], [a, b, c]: [Flat; 3]) -> bool {
    let beyond = |a: Flat, b: Flat| turn(a, b, p) <= 0 && turn(a, b, q) <= 0;
    let corners = [a, b, c].map(|v| turn(p, q, v));
    !(beyond(a, b)
        || beyond(b, c)
        || beyond(c, a)
        || corners.iter().all(|&t| t <= 0)
        || corners.iter().all(|&t| t >= 0))
}

/// The height of a counter-clockwise triangle over a line that goes through it in the projection,
/// in the middle of what they have in common.
fn height_over([p, q]: [Flat; 2], ends: [f64; 2], triangle: [Flat; 3], tops: [f64; 3]) -> f64 {
    let [a, b, c] = triangle;
    let (mut from, mut to) = (0.0, 1.0_f64);
    let mut weights = [[0.0; 2]; 3];
    for (k, (a, b)) in [(b, c), (c, a), (a, b)].into_iter().enumerate() {
        // The line is within this side where the turn, which is linear, is positive.
        let [s, t] = [turn(a, b, p) as f64, turn(a, b, q) as f64];
        weights[k] = [s, t];
        match (s < 0.0, t < 0.0) {
            (true, false) => from = f64::max(from, s / (s - t)),
            (false, true) => to = f64::min(to, s / (s - t)),
            _ => {}
        }
    }
    let middle = (from + to) / 2.0;
    let at = |[s, t]: [f64; 2]| s + middle * (t - s);
    let base = tops[0];
    let (mut sum, mut total) = (0.0, 0.0);
    for (weight, top) in weights.into_iter().map(at).zip(tops) {
        sum += weight * (top - base);
        total += weight;
    }
    sum / total - at(ends.map(|h| h - base))
}

/// Is a point in a closed polygon?
fn holds(ring: &[Flat], p: Flat) -> bool {
    let mut inside = false;
    for (k, &a) in ring.iter().enumerate() {
        let b = ring[(k + 1) % ring.len()];
        let side = turn(a, b, p);
        let between = (0..2).all(|i| a[i].min(b[i]) <= p[i] && p[i] <= a[i].max(b[i]));
        if side == 0 && between {
            return true;
        }
        if (a[1] > p[1]) != (b[1] > p[1]) {
            inside ^= if b[1] > a[1] { side > 0 } else { side < 0 };
        }
    }
    inside
}
