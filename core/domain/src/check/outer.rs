//! The items with nothing but exterior around them.

use super::cells::{self, OUTSIDE, Sets};
use super::contact::sides_of;
use super::seeds::Question;
use super::{Cell, Findings};
use crate::triangulate::sorted;
use crate::{DefectKind, Element};
use ltbw_exact::Point;
use rayon::prelude::*;
use std::collections::HashMap;

/// Items with nothing but exterior around them: the outside, and voids. Numbers are those of the
/// domain, ascending.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Exterior {
    /// Facets. Also those that were given from either side, with nothing between.
    pub facets: Vec<u32>,
    /// The facets of these that have an edge of one facet only: they end in the exterior.
    pub ends: Vec<u32>,
    /// Facets of which a part is such.
    pub partly: Vec<u32>,
    /// Free-standing segments.
    pub segments: Vec<u32>,
    /// Vertices that nothing else names.
    pub vertices: Vec<u32>,
    /// Points of holes that lie outside once the facets are left out.
    pub holes: Vec<u32>,
}

impl Exterior {
    /// Is all a part of the domain?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl Question<'_> {
    /// Has a triangle nothing but exterior on both sides? An inner facet, given from either side,
    /// also counts if both sides are one cell: there is nothing between its two.
    fn is_idle(&self, found: &[Cell], t: usize) -> bool {
        let [front, back] = self.cells.beside(t);
        let is_exterior = !self.is_filled(found, front) && !self.is_filled(found, back);
        is_exterior || (front == back && self.is_inner(t))
    }

    /// Is a triangle one of an inner facet?
    pub(super) fn is_inner(&self, t: usize) -> bool {
        self.inner.binary_search(&self.complex.facet_of[t]).is_ok()
    }

    /// The items with nothing but exterior around them.
    pub(super) fn exterior(&self, found: &[Cell]) -> Exterior {
        let (domain, complex) = (self.domain, self.complex);
        let idle: Vec<bool> =
            (0..complex.triangles.len()).map(|t| self.is_idle(found, t)).collect();
        let is_whole = !idle.contains(&true);
        if is_whole && complex.unused.is_empty() && complex.loose.is_empty() {
            return Exterior::default();
        }
        // Of each facet: is some of it idle, and is some of it not?
        let mut parts = vec![[false; 2]; domain.facets.len()];
        for (&f, &idle) in complex.facet_of.iter().zip(&idle) {
            parts[f as usize][usize::from(!idle)] = true;
        }
        let mut segments = vec![false; domain.segments.len()];
        for (element, is_out) in self.loose(found, &idle) {
            match element {
                Element::Segment(s) => segments[s as usize] = is_out,
                Element::Facet(f) => parts[f as usize][usize::from(!is_out)] = true,
                _ => {}
            }
        }
        let mut ends: Vec<u32> = self
            .cells
            .open
            .iter()
            .filter(|(_, t)| idle[*t as usize])
            .map(|&(_, t)| complex.facet_of[t as usize])
            .collect();
        ends.sort_unstable();
        ends.dedup();
        ends.retain(|&f| parts[f as usize] == [true, false]);
        let of = |part: [bool; 2]| {
            (0..).zip(&parts).filter(|&(_, p)| *p == part).map(|(f, _)| f).collect()
        };
        let out = |list: &[bool]| (0..).zip(list).filter(|&(_, &o)| o).map(|(n, _)| n).collect();
        Exterior {
            vertices: self.outer_vertices(found, &parts, &segments),
            facets: of([true, false]),
            partly: of([true, true]),
            ends,
            segments: out(&segments),
            holes: self.outer_holes(found, &idle),
        }
    }

    /// The loose edges, and whether each is in the exterior. One that no triangle has lies in one
    /// cell, which its middle tells; on the lattice that is exact.
    fn loose(&self, found: &[Cell], idle: &[bool]) -> Vec<(Element, bool)> {
        let complex = self.complex;
        if complex.loose.is_empty() {
            return Vec::new();
        }
        let mut is_out: HashMap<[u32; 2], bool> = HashMap::new();
        for (&t, &idle) in complex.triangles.iter().zip(idle) {
            for side in sides_of(t) {
                *is_out.entry(sorted(side)).or_insert(true) &= idle;
            }
        }
        let middle = |[a, b]: [u32; 2]| {
            let (p, q) = (self.at(a), self.at(b));
            [0, 1, 2].map(|k| p[k] / 2.0 + q[k] / 2.0)
        };
        let of = |&(edge, element): &([u32; 2], Element)| {
            let known = is_out.get(&sorted(edge)).copied();
            (element, known.unwrap_or_else(|| self.is_outer(found, &middle(edge))))
        };
        complex.loose.par_iter().map(of).collect()
    }

    /// Is a point, which is on no facet, in the exterior?
    fn is_outer(&self, found: &[Cell], p: &Point) -> bool {
        let cell = cells::locate(self.complex, self.index, &self.cells, p);
        cell.is_some_and(|cell| !self.is_filled(found, cell))
    }

    /// The vertices in the exterior that nothing names which is kept.
    fn outer_vertices(&self, found: &[Cell], parts: &[[bool; 2]], segments: &[bool]) -> Vec<u32> {
        // Named by nothing, by what is left out, by what is kept.
        let mut named = vec![0_u8; self.domain.vertices.len()];
        for (facet, part) in self.domain.facets.iter().zip(parts) {
            let by = if *part == [true, false] { 1 } else { 2 };
            let corners = facet.polygons.iter().flatten();
            corners.for_each(|&v| named[v as usize] = named[v as usize].max(by));
        }
        for ((ends, _), is_out) in self.domain.segments.iter().zip(segments) {
            let by = if *is_out { 1 } else { 2 };
            ends.iter().for_each(|&v| named[v as usize] = named[v as usize].max(by));
        }
        let unused = self.complex.unused.par_iter().copied();
        let mut outer: Vec<u32> = unused.filter(|&v| self.is_outer(found, &self.at(v))).collect();
        outer.extend((0..).zip(named).filter(|&(_, by)| by == 1).map(|(v, _)| v));
        outer.sort_unstable();
        outer
    }

    /// The holes in cells that are outside once idle facets are left out.
    fn outer_holes(&self, found: &[Cell], idle: &[bool]) -> Vec<u32> {
        let mut sets = Sets::new(self.cells.count as usize);
        for t in (0..idle.len()).filter(|&t| idle[t]) {
            let [front, back] = self.cells.beside(t);
            sets.unite(front, back);
        }
        let outside = sets.find(OUTSIDE);
        let mut holes: Vec<u32> = (1..)
            .zip(found)
            .filter(|&(cell, _)| sets.find(cell) == outside)
            .flat_map(|(_, cell)| cell.holes.iter().copied())
            .collect();
        holes.sort_unstable();
        holes
    }

    /// Reports facets that have nothing but exterior around them.
    pub(super) fn tell_exterior(&self, exterior: &Exterior, findings: &mut Findings) {
        let mut corners: HashMap<u32, [u32; 3]> = HashMap::new();
        for (&f, &t) in self.complex.facet_of.iter().zip(&self.complex.triangles) {
            corners.entry(f).or_insert(t);
        }
        for &f in &exterior.facets {
            let ends = exterior.ends.binary_search(&f).is_ok();
            let kind = if ends { DefectKind::EndsOutside } else { DefectKind::Exterior };
            let at = corners.get(&f).map(|t| t.map(|v| self.at(v)).to_vec());
            findings.add(kind, vec![Element::Facet(f)], at.unwrap_or_default());
        }
    }
}
