//! Domains of layers: stacks, honeycombs, and laminates with holes.
//!
//! Each is a plan of polygons that share sides, extruded from level to level. Two materials have
//! the facet between them in common, so these are no surfaces: their facets have two sides, and
//! edges have up to four of them. Thin layers are what circuit boards, soils and laminates are
//! made of. Coordinates are made with + − × ÷ √ only.

use super::surfaces::around;
use ltbw_domain::{Domain, Facet, Region};
use ltbw_exact::Point;
use std::collections::BTreeMap;
use std::ops::Range;

/// The marker of all walls; the floors of level k have the marker `WALL + 1 + k`.
const WALL: i32 = 1;

/// A polygon of a plan.
#[derive(Debug, Clone, Default)]
struct Cell {
    /// Its corners, counter-clockwise.
    corners: Vec<u32>,
    /// The cells that lie inside it, which are no part of it.
    plugs: Vec<usize>,
    /// A point inside it.
    middle: [f64; 2],
}

/// Polygons of the plane that share sides.
#[derive(Debug, Clone, Default)]
struct Plan {
    points: Vec<[f64; 2]>,
    cells: Vec<Cell>,
}

/// A plan between levels.
struct Extruded<'a> {
    plan: &'a Plan,
    /// The heights of the levels, one more than layers.
    levels: &'a [f64],
    /// Per cell and layer: what fills it, if anything does.
    materials: Vec<Vec<Option<u32>>>,
}

/// A hole through layers of a laminate.
#[derive(Debug, Clone, PartialEq)]
pub struct Drill {
    /// The middle of its polygon.
    pub centre: [f64; 2],
    /// The distance of the polygon's corners from there.
    pub radius: f64,
    /// The number of corners, at least 3; four of them make a square along the axes.
    pub corners: u32,
    /// The layers that it goes through, the lowest being 0.
    pub layers: Range<usize>,
}

/// Boxes of one base on top of each other, from z = 0 on; with `regions` each has a seed.
#[must_use]
pub fn stack(base: [f64; 2], thicknesses: &[f64], regions: bool) -> Domain {
    laminate(base, thicknesses, &[], regions)
}

/// The layers of a stack with holes, which must neither touch each other nor the base's border.
///
/// A hole that no layer closes is open to the outside, others are pits or voids.
#[must_use]
pub fn laminate([x, y]: [f64; 2], thicknesses: &[f64], drills: &[Drill], regions: bool) -> Domain {
    let points = vec![[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]];
    let reach = |drill: &Drill| drill.centre.map(|c| (c - drill.radius) / 2.0);
    // Half of what is left between the corner at 0 and the nearest hole.
    let least = |k: usize, side: f64| drills.iter().map(|d| reach(d)[k]).fold(side / 2.0, f64::min);
    let plate =
        Cell { corners: vec![0, 1, 2, 3], plugs: Vec::new(), middle: [least(0, x), least(1, y)] };
    let mut plan = Plan { points, cells: vec![plate] };
    for drill in drills {
        let (first, n) = (plan.points.len() as u32, drill.corners.max(3));
        let corner = |k: u32| {
            let turned = around(2 * k + 1, 2 * n);
            [0, 1].map(|i| drill.centre[i] + drill.radius * turned[i])
        };
        plan.points.extend((0..n).map(corner));
        let number = plan.cells.len();
        plan.cells[0].plugs.push(number);
        let corners = (first..first + n).collect();
        plan.cells.push(Cell { corners, middle: drill.centre, ..Cell::default() });
    }
    let material = |cell: usize, layer: usize| {
        let is_open = cell > 0 && drills[cell - 1].layers.contains(&layer);
        (!is_open).then_some(layer as u32)
    };
    plan.extruded(&levels(thicknesses), material).domain(regions)
}

/// Regular hexagons of side 1 in `columns` and `rows` (at least 1 each), walls between them, in
/// layers from z = 0 on; each cell of each layer is a material of its own, and with `regions` has a
/// seed. The cells numbered in `empty`, column by column, are left out.
#[must_use]
pub fn honeycomb(
    columns: u32,
    rows: u32,
    empty: &[usize],
    thicknesses: &[f64],
    regions: bool,
) -> Domain {
    let half = 3.0_f64.sqrt() / 2.0;
    let (mut plan, mut numbers) = (Plan::default(), BTreeMap::new());
    for column in 0..columns.max(1) {
        for row in 0..rows.max(1) {
            // In halves of a side along x, in halves of a cell's height along y.
            let [x, y] = [3 * i64::from(column), 2 * i64::from(row) + i64::from(column % 2)];
            let place = |[x, y]: [i64; 2]| [x as f64 / 2.0, y as f64 * half];
            let ring = [[2, 0], [1, 1], [-1, 1], [-2, 0], [-1, -1], [1, -1]];
            let corners = ring.map(|[u, v]| {
                *numbers.entry([x + u, y + v]).or_insert_with(|| {
                    plan.points.push(place([x + u, y + v]));
                    plan.points.len() as u32 - 1
                })
            });
            let (corners, middle) = (corners.to_vec(), place([x, y]));
            plan.cells.push(Cell { corners, middle, ..Cell::default() });
        }
    }
    let count = plan.cells.len();
    let material = |cell: usize, layer: usize| {
        (!empty.contains(&cell)).then_some((layer * count + cell) as u32)
    };
    plan.extruded(&levels(thicknesses), material).domain(regions)
}

/// The heights at which layers begin and end.
fn levels(thicknesses: &[f64]) -> Vec<f64> {
    let mut height = 0.0;
    let tops = thicknesses.iter().map(|thickness| {
        height += thickness;
        height
    });
    std::iter::once(0.0).chain(tops).collect()
}

/// A cell at a side.
#[derive(Clone, Copy)]
struct Owner {
    cell: usize,
    /// The side, in the direction in which the cell has it.
    side: [u32; 2],
}

impl Cell {
    /// The sides from corner to corner, counter-clockwise.
    fn sides(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).map(|(&a, &b)| [a, b])
    }
}

impl Plan {
    fn extruded<'a>(
        &'a self,
        levels: &'a [f64],
        material: impl Fn(usize, usize) -> Option<u32>,
    ) -> Extruded<'a> {
        let layers = levels.len().saturating_sub(1);
        let of = |cell: usize| (0..layers).map(|layer| material(cell, layer)).collect();
        Extruded { plan: self, levels, materials: (0..self.cells.len()).map(of).collect() }
    }

    /// Per side the one or two cells at it.
    fn owners(&self) -> BTreeMap<[u32; 2], Vec<Owner>> {
        let mut owners: BTreeMap<[u32; 2], Vec<Owner>> = BTreeMap::new();
        let mut add = |cell: usize, [a, b]: [u32; 2]| {
            owners.entry([a.min(b), a.max(b)]).or_default().push(Owner { cell, side: [a, b] });
        };
        for (number, cell) in self.cells.iter().enumerate() {
            cell.sides().for_each(|side| add(number, side));
            for plug in &cell.plugs {
                self.cells[*plug].sides().for_each(|[a, b]| add(number, [b, a]));
            }
        }
        owners
    }
}

impl Extruded<'_> {
    /// The materials below and above a level.
    fn beside(&self, cell: usize, level: usize) -> [Option<u32>; 2] {
        let of = &self.materials[cell];
        let below = level.checked_sub(1).and_then(|layer| of[layer]);
        [below, of.get(level).copied().flatten()]
    }

    /// The number of a point of the plan at a level.
    fn number(&self, point: u32, level: usize) -> u32 {
        level as u32 * self.plan.points.len() as u32 + point
    }

    /// A place in a layer, halfway up.
    fn place(&self, [x, y]: [f64; 2], layer: usize) -> Point {
        [x, y, (self.levels[layer] + self.levels[layer + 1]) / 2.0]
    }

    fn domain(&self, regions: bool) -> Domain {
        let mut domain = Domain::default();
        for z in self.levels {
            domain.vertices.extend(self.plan.points.iter().map(|&[x, y]| [x, y, *z]));
        }
        for level in 0..self.levels.len() {
            domain.facets.extend((0..self.plan.cells.len()).filter_map(|c| self.floor(c, level)));
        }
        let owners = self.plan.owners();
        for (layer, cells) in owners.values().flat_map(|cells| {
            (0..self.levels.len().saturating_sub(1)).map(move |layer| (layer, cells))
        }) {
            domain.facets.extend(self.wall(cells, layer));
        }
        domain.holes = self.voids(&owners);
        if regions {
            domain.regions = self.regions();
        }
        without_spare_vertices(domain)
    }

    /// The floor of a cell at a level, if the materials below and above differ.
    fn floor(&self, number: usize, level: usize) -> Option<Facet> {
        let cell = &self.plan.cells[number];
        let beside = self.beside(number, level);
        if beside[0] == beside[1] {
            return None;
        }
        let ring = |cell: &Cell| -> Vec<u32> {
            let corners = cell.corners.iter().map(|&p| self.number(p, level));
            // Away from what is below, or from what is above nothing.
            if beside[0].is_some() { corners.collect() } else { corners.rev().collect() }
        };
        let mut facet = Facet::polygon(&ring(cell), WALL + 1 + level as i32);
        // A plug of the plate's own materials needs no hole.
        for &plug in cell.plugs.iter().filter(|&&plug| self.beside(plug, level) != beside) {
            let [x, y] = self.plan.cells[plug].middle;
            facet.polygons.push(ring(&self.plan.cells[plug]));
            facet.holes.push([x, y, self.levels[level]]);
        }
        let is_plug = self.plan.cells.iter().position(|c| c.plugs.contains(&number));
        let is_covered = is_plug.is_some_and(|plate| self.beside(plate, level) == beside);
        (!is_covered).then_some(facet)
    }

    /// The wall between the cells at a side in a layer, if their materials differ.
    fn wall(&self, cells: &[Owner], layer: usize) -> Option<Facet> {
        let material = |k: usize| cells.get(k).and_then(|owner| self.materials[owner.cell][layer]);
        if material(0) == material(1) {
            return None;
        }
        // Away from the material of lower number, or from the only one.
        let from = match (material(0), material(1)) {
            (Some(a), Some(b)) => usize::from(b < a),
            (first, _) => usize::from(first.is_none()),
        };
        let [a, b] = cells[from].side;
        let corners = [(a, layer), (b, layer), (b, layer + 1), (a, layer + 1)];
        Some(Facet::polygon(&corners.map(|(p, level)| self.number(p, level)), WALL))
    }

    /// A point in every void that is closed all around.
    fn voids(&self, owners: &BTreeMap<[u32; 2], Vec<Owner>>) -> Vec<Point> {
        let layers = self.levels.len().saturating_sub(1);
        let mut seen: Vec<Vec<bool>> =
            self.materials.iter().map(|of| of.iter().map(Option::is_some).collect()).collect();
        let mut voids = Vec::new();
        for (cell, layer) in
            (0..self.plan.cells.len()).flat_map(|cell| (0..layers).map(move |layer| (cell, layer)))
        {
            // Every turn inside marks a cell of a layer.
            let (mut stack, mut is_open) = (vec![(cell, layer)], false);
            let mut found = false;
            while let Some((cell, layer)) = stack.pop() {
                if std::mem::replace(&mut seen[cell][layer], true) {
                    continue;
                }
                found = true;
                is_open |= layer == 0 || layer + 1 == layers;
                stack.extend(layer.checked_sub(1).map(|below| (cell, below)));
                stack.extend((layer + 1 < layers).then_some((cell, layer + 1)));
                for cells in
                    owners.values().filter(|all| all.iter().any(|owner| owner.cell == cell))
                {
                    is_open |= cells.len() == 1;
                    stack.extend(cells.iter().map(|other| (other.cell, layer)));
                }
            }
            if found && !is_open {
                voids.push(self.place(self.plan.cells[cell].middle, layer));
            }
        }
        voids
    }

    /// A seed in the first cell of each material.
    fn regions(&self) -> Vec<Region> {
        let mut seeds: BTreeMap<u32, Point> = BTreeMap::new();
        for (cell, of) in self.plan.cells.iter().zip(&self.materials) {
            for (layer, material) in of.iter().enumerate() {
                let Some(material) = material else { continue };
                seeds.entry(*material).or_insert_with(|| self.place(cell.middle, layer));
            }
        }
        let region = |(material, seed): (u32, Point)| Region {
            seed,
            attribute: f64::from(material + 1),
            max_volume: None,
        };
        seeds.into_iter().map(region).collect()
    }
}

/// The domain without vertices that no facet names.
fn without_spare_vertices(mut domain: Domain) -> Domain {
    let mut used = vec![false; domain.vertices.len()];
    let corners = domain.facets.iter().flat_map(|f| f.polygons.iter().flatten());
    corners.for_each(|&v| used[v as usize] = true);
    let mut next = 0;
    let numbers: Vec<u32> = used
        .iter()
        .map(|&is_used| {
            next += u32::from(is_used);
            // Of an unused one no facet asks.
            next.saturating_sub(1)
        })
        .collect();
    let corners = domain.facets.iter_mut().flat_map(|f| f.polygons.iter_mut().flatten());
    corners.for_each(|v| *v = numbers[*v as usize]);
    let mut used = used.into_iter();
    domain.vertices.retain(|_| used.next().unwrap_or(false));
    domain
}

#[cfg(test)]
mod tests {
    use super::{Drill, honeycomb, laminate, stack};
    use ltbw_domain::{CheckOptions, Domain};

    /// The domain is sound, with these cells and this volume, rounded.
    fn assert_sound(name: &str, domain: &Domain, cells: usize, volume: f64) {
        let report = domain.check(&CheckOptions::default()).expect("a domain");
        assert!(report.passed(), "{name}: {:?}", report.defects.first());
        let filled = report.cells.as_ref().expect("cells").iter().filter(|cell| cell.filled);
        assert_eq!(filled.count(), cells, "{name}");
        let own = report.volume().expect("a volume").to_f64();
        assert!((own - volume).abs() < 1e-9 * volume, "{name}: {own}");
    }

    #[test]
    fn stacks_are_boxes_with_floors_in_common() {
        for regions in [false, true] {
            let domain = stack([3.0, 2.0], &[0.0625, 0.5, 0.0625], regions);
            assert_eq!((domain.vertices.len(), domain.facets.len()), (16, 16));
            assert_eq!(domain.regions.len(), 3 * usize::from(regions));
            assert_sound("a stack", &domain, 3, 6.0 * 0.625);
        }
    }

    #[test]
    fn honeycombs_share_their_walls() {
        let hexagon = 1.5 * 3.0_f64.sqrt();
        let domain = honeycomb(3, 2, &[], &[0.25, 0.5], true);
        assert_eq!(domain.regions.len(), 12);
        // Below are the numbers of corners and of sides of six hexagons.
        let (corners, sides) = (22, 27);
        assert_eq!(domain.vertices.len(), 3 * corners);
        assert_eq!(domain.facets.len(), 3 * 6 + 2 * sides);
        let volume = domain.check(&CheckOptions::default()).expect("a domain").volume();
        let volume = volume.expect("a volume").to_f64();
        assert!((volume - 6.0 * 0.75 * hexagon).abs() < 1e-9, "{volume}");
    }

    #[test]
    fn an_empty_cell_inside_is_a_void() {
        // The fifth of nine has six others around it.
        let domain = honeycomb(3, 3, &[4], &[0.5], false);
        assert_eq!(domain.holes.len(), 0, "open above and below");
        let domain = laminate(
            [2.0, 1.0],
            &[0.25, 0.5, 0.25],
            &[Drill { centre: [0.5, 0.5], radius: 0.25, corners: 4, layers: 1..2 }],
            false,
        );
        assert_eq!(domain.holes, [[0.5, 0.5, 0.5]]);
        assert_sound("a void", &domain, 3, 2.0 - 0.5 * 0.125);
    }

    #[test]
    fn holes_of_laminates_go_through_their_layers() {
        let drill =
            |x: f64, corners, layers| Drill { centre: [x, 0.5], radius: 0.25, corners, layers };
        let thin = [0.25, 0.5, 0.25];
        for (layers, open) in [(0..3, 1.0), (0..1, 0.25), (1..3, 0.75), (1..2, 0.5), (2..2, 0.0)] {
            let all = [drill(0.5, 4, layers.clone()), drill(1.5, 4, 0..3)];
            let domain = laminate([2.0, 1.0], &thin, &all, true);
            assert_sound(&format!("{layers:?}"), &domain, 3, 2.0 - 0.125 * (1.0 + open));
        }
        let round = laminate([2.0, 1.0], &thin, &[drill(1.0, 7, 0..2)], false);
        assert!(round.check(&CheckOptions::default()).expect("a domain").is_meshable());
    }
}
