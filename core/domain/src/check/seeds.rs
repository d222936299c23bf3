//! The meaning of the cells: which are to be meshed, which are voids, where the outside leaks in.

use super::cells::{self, Cells, OUTSIDE};
use super::complex::{Complex, Piece, Shape};
use super::contact::Contacts;
use super::exact::{Turned, Volume};
use super::rays::cast;
use super::{Cell, CheckOptions, DomainReport, Findings, bodies, ends};
use crate::{DefectKind, Domain, Element};
use ltbw_core::Random;
use ltbw_exact::Point;
use rstar::{AABB, RTree};
use std::collections::HashSet;

/// Everything that is asked.
pub(super) struct Question<'a> {
    pub(super) domain: &'a Domain,
    pub(super) complex: &'a Complex<'a>,
    pub(super) index: &'a RTree<Piece>,
    pub(super) cells: Cells,
    /// Facets between two bodies, ascending.
    pub(super) inner: &'a [u32],
}

impl<'a> Question<'a> {
    pub(super) fn new(
        domain: &'a Domain,
        complex: &'a Complex<'a>,
        index: &'a RTree<Piece>,
        cells: Cells,
        inner: &'a [u32],
    ) -> Self {
        Self { domain, complex, index, cells, inner }
    }
}

impl Question<'_> {
    /// Assigns seeds and meanings to the cells, and reports what is wrong with them.
    pub(super) fn assign(
        self,
        options: &CheckOptions,
        findings: &mut Findings,
        report: &mut DomainReport,
    ) {
        let mut found = self.volumes();
        self.fill(options, &mut found, findings);
        self.seeds(&mut found, findings);
        let closed = self.open_edges(options, &found, findings);
        if closed && options.oriented {
            report.inward = self.inward(&found, findings);
        }
        if closed && (options.oriented || options.nested_voids) {
            report.voids = self.voids(&found);
        }
        if closed && found.iter().any(|cell| cell.filled) {
            report.exterior = self.exterior(&found);
            self.tell_exterior(&report.exterior, findings);
        }
        report.cells = Some(found);
    }

    pub(super) fn at(&self, v: u32) -> Point {
        self.complex.points[v as usize]
    }

    /// Reports edges of one facet only; is there none of them that keeps the domain from being
    /// meshed? Those where a facet ends in the exterior do not.
    fn open_edges(&self, options: &CheckOptions, found: &[Cell], findings: &mut Findings) -> bool {
        let (mut closed, mut outer) = (true, Vec::new());
        for &(edge, t) in &self.cells.open {
            // Both sides of this triangle are in one cell.
            let cell = self.cells.beside(t as usize)[0];
            let inside = self.is_filled(found, cell);
            if inside && self.is_inner(t as usize) {
                // There is nothing between the two facets that were here.
                continue;
            }
            if inside && options.oriented {
                closed = false;
                cells::leak(self.complex, edge, t, DefectKind::Leak, findings);
            } else if cell != OUTSIDE && !options.oriented {
                cells::leak(self.complex, edge, t, DefectKind::Dangling, findings);
            } else {
                outer.push((edge, t));
            }
        }
        let is_body = found.iter().any(|cell| cell.filled);
        let gaps = if is_body { ends::gaps(self.complex, &outer) } else { vec![true; outer.len()] };
        for ((edge, t), _) in outer.into_iter().zip(gaps).filter(|(_, gap)| *gap) {
            closed = false;
            cells::leak(self.complex, edge, t, DefectKind::Leak, findings);
        }
        closed
    }

    /// The bounded cells with their volumes, all of them filled.
    fn volumes(&self) -> Vec<Cell> {
        let mut borders: Vec<Vec<Turned>> = vec![Vec::new(); self.cells.count as usize];
        for (t, &corners) in self.complex.triangles.iter().enumerate() {
            let [front, back] = self.cells.beside(t);
            if front != back {
                // Seen from the cell behind it, a triangle points outwards.
                borders[front as usize].push(Turned { corners, factor: -1 });
                borders[back as usize].push(Turned { corners, factor: 1 });
            }
        }
        borders[1..]
            .iter()
            .map(|border| Cell {
                volume: Volume::of_cone(self.complex.points, border),
                filled: true,
                holes: Vec::new(),
                regions: Vec::new(),
            })
            .collect()
    }

    /// Finds the cells of the hole points, and then of the region points.
    fn seeds(&self, found: &mut [Cell], findings: &mut Findings) {
        for (h, p) in (0..).zip(&self.domain.holes) {
            if let Some(cell) = self.cell_of(p, Element::Hole(h), found, findings) {
                cell.holes.push(h);
                cell.filled = false;
            }
        }
        for (r, region) in (0..).zip(&self.domain.regions) {
            let element = Element::Region(r);
            match self.cell_of(&region.seed, element, found, findings) {
                Some(cell) if cell.filled => cell.regions.push(r),
                Some(_) => {
                    findings.add(DefectKind::SeedOutside, vec![element], vec![region.seed]);
                }
                None => {}
            }
        }
    }

    /// The bounded cell in which a seed lies; if there is none, that is reported.
    fn cell_of<'c>(
        &self,
        p: &Point,
        element: Element,
        found: &'c mut [Cell],
        findings: &mut Findings,
    ) -> Option<&'c mut Cell> {
        let contacts = Contacts { points: self.complex.points };
        let here = self.index.locate_in_envelope_intersecting(AABB::from_point(*p));
        for piece in here {
            let Shape::Triangle(t) = self.complex.shape(piece.number) else { continue };
            if contacts.point_on_triangle(p, t) {
                let elements = vec![element, self.complex.element(piece.number)];
                findings.add(DefectKind::SeedOnFacet, elements, vec![*p]);
                return None;
            }
        }
        match cells::locate(self.complex, self.index, &self.cells, p) {
            Some(cell) if cell != OUTSIDE => found.get_mut(cell as usize - 1),
            _ => {
                findings.add(DefectKind::SeedOutside, vec![element], vec![*p]);
                None
            }
        }
    }

    pub(super) fn is_filled(&self, found: &[Cell], cell: u32) -> bool {
        cell != OUTSIDE && found[cell as usize - 1].filled
    }

    /// The facets that point into what is filled. Each body that has such is reported once.
    fn inward(&self, found: &[Cell], findings: &mut Findings) -> Vec<u32> {
        // A facet, and a triangle of it.
        let mut inward: Vec<(u32, usize)> = Vec::new();
        for t in 0..self.complex.triangles.len() {
            let [front, back] = self.cells.beside(t).map(|cell| self.is_filled(found, cell));
            let facet = self.complex.facet_of[t];
            // Between two filled cells both orientations are right. The triangles of a facet
            // follow each other.
            if front && !back && inward.last().is_none_or(|&(last, _)| last != facet) {
                inward.push((facet, t));
            }
        }
        if inward.is_empty() {
            return Vec::new();
        }
        let bodies = bodies::bodies_of(self.domain);
        let mut told = HashSet::new();
        for &(facet, t) in &inward {
            if told.insert(bodies[facet as usize]) {
                let corners = self.complex.triangles[t].map(|v| self.at(v)).to_vec();
                findings.add(DefectKind::Orientation, vec![Element::Facet(facet)], corners);
            }
        }
        inward.into_iter().map(|(facet, _)| facet).collect()
    }

    /// A point inside each bounded cell that is not filled and has no hole point.
    fn voids(&self, found: &[Cell]) -> Vec<Point> {
        let mut wanted: Vec<Vec<u32>> = vec![Vec::new(); self.cells.count as usize];
        for t in 0..self.complex.triangles.len() {
            for cell in self.cells.beside(t) {
                if cell != OUTSIDE {
                    let cell_found = &found[cell as usize - 1];
                    if !cell_found.filled && cell_found.holes.is_empty() {
                        wanted[cell as usize].push(t as u32);
                    }
                }
            }
        }
        (0..).zip(wanted).filter_map(|(cell, border)| self.point_in(cell, border)).collect()
    }

    /// A point in a cell with this border: half-way from one of its larger triangles to what lies
    /// across; proved to be in the cell by locating it.
    fn point_in(&self, cell: u32, mut border: Vec<u32>) -> Option<Point> {
        const TRIES: usize = 64;
        let area = |t: &u32| cells::area(self.complex, *t);
        border.sort_by(|t, u| area(u).total_cmp(&area(t)));
        let (low, high) = self.domain.bounds()?;
        let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        let mut random = Random::new(3);
        for (_, &t) in (0..TRIES).zip(border.iter().cycle()) {
            let middle = cells::middle(self.complex, t, &mut random);
            let normal = cells::normal(self.complex, t);
            let length = cells::area(self.complex, t).sqrt();
            let shift = |s: f64| [0, 1, 2].map(|k| middle[k] + s * size * (normal[k] / length));
            let (from, to) = (shift(-2.0), shift(2.0));
            let Ok(hits) = cast(self.complex, self.index, &from, &to) else { continue };
            let in_cell = |side: u32| self.cells.of_side[side as usize] == cell;
            for pair in hits.windows(2) {
                let own = pair[0].triangle == t || pair[1].triangle == t;
                if !own || !in_cell(pair[0].far()) {
                    continue;
                }
                let s = (pair[0].along.to_f64() + pair[1].along.to_f64()) / 2.0;
                let p = [0, 1, 2].map(|k| from[k] + s * (to[k] - from[k]));
                if cells::locate(self.complex, self.index, &self.cells, &p) == Some(cell) {
                    return Some(p);
                }
            }
        }
        None
    }
}
