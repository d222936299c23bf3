//! From what a file says to what refinement takes.
//!
//! Snap to the lattice, merge equal vertices, drop facets that say nothing (`repair.rs`), cut
//! facets that are not planar into triangles, check exactly, leave out what has nothing but
//! exterior around it (`exterior.rs`), and put a hole point into every void of an oriented surface.
//! What the check of the snapped domain refuses is checked once more as it was, to tell whether the
//! domain itself is wrong or has features below the lattice.

mod error;

pub use error::PrepareError;

use crate::check::same_place;
use crate::exterior::{LEFT_OUT, Settled};
use crate::points::Placed;
use crate::renumber::{in_numbers_of_input, others};
use crate::repair::{Repairs, Surface, weld};
use crate::simplify::{self, Simplified};
use crate::{CheckOptions, Domain, DomainError, DomainReport, Lattice, Move, Snapped};
use crate::{DefectKind, TroubleKind};
use ltbw_exact::Point;

/// The coordinates in which a domain is meshed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Frame {
    /// The file's own, unless the distance from the origin takes two bits of them or more: then
    /// those from the middle of the domain.
    #[default]
    Auto,
    /// The file's own.
    Own,
    /// Coordinates from the middle of the domain: see [`Lattice::local`].
    Local,
}

/// Lost bits from which on the frame is local.
const LOST_BITS: u32 = 2;

/// The largest tolerance, as a part of the diagonal of the domain's box.
pub const LARGEST_TOLERANCE: f64 = 1.0 / 1024.0;

/// Options of the preparation of a domain.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PrepareOptions {
    /// Refuse a domain that is not on its lattice. Vertices at different places stay different.
    pub exact_input: bool,
    /// Where coordinates are measured from.
    pub frame: Frame,
    /// The distance within which vertices are welded and seams are closed, at most
    /// [`LARGEST_TOLERANCE`] of the diagonal. 0: nothing but what a step of the lattice welds.
    pub repair: f64,
    /// The facets are an oriented surface: see [`CheckOptions::oriented`].
    pub oriented: bool,
    /// A body inside another is a void: see [`CheckOptions::nested_voids`].
    pub nested_voids: bool,
    /// Refuse a domain of which something would be repaired, left out or guessed.
    pub strict: bool,
    /// The distance within which the surface is simplified, at most 5 % of the diagonal; 0: it is
    /// left as it is. See [`crate::simplify`].
    pub simplify: f64,
    /// The most edges of a hole that is closed by triangles, at most [`crate::LONGEST_LOOP`];
    /// below 3: none is.
    pub fill: u32,
}

/// A domain whose equal vertices were merged.
#[derive(Debug, Clone, PartialEq)]
pub struct Welded {
    /// The domain.
    pub domain: Domain,
    /// For each vertex of the one before its new number.
    pub numbers: Vec<u32>,
}

/// A domain that can be meshed.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// The domain: vertices distinct and on the lattice, facets planar, a hole point in each void.
    pub domain: Domain,
    /// The lattice.
    pub lattice: Lattice,
    /// The number of vertices that moved.
    pub moved: usize,
    /// The farthest move, if any vertex moved, with the number of the vertex in the input.
    pub largest: Option<Move>,
    /// For each vertex of the input its number in the domain; [`LEFT_OUT`] if it is no part of it.
    /// One at the boundary that nothing names is one of [`Domain::points`]: see [`Placed::map`].
    pub vertex_map: Vec<u32>,
    /// The points that are to be vertices, and where they are.
    pub placed: Placed,
    /// For each facet of the domain the facet of the input that it is part of.
    pub facet_map: Vec<u32>,
    /// The findings of the check: nothing graver than warnings. Elements are those of the domain.
    pub report: DomainReport,
    /// The welded, dropped and closed items.
    pub repairs: Repairs,
    /// The domain with what has nothing but exterior around it, for a judge who finds that out by
    /// himself; `None` if there is no such thing.
    pub whole: Option<Domain>,
    /// The simplification of the surface, if there was one.
    pub simplified: Option<Simplified>,
}

impl Prepared {
    /// The domain that a judge of the mesh is to be given: [`Prepared::whole`], or the domain.
    #[must_use]
    pub fn judged(&self) -> &Domain {
        self.whole.as_ref().unwrap_or(&self.domain)
    }

    /// A line for each kind of what was repaired, left out or guessed.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let mut notes = self.repairs.notes();
        notes.extend(nested(&self.report));
        notes
    }

    /// The points that are vertices, too, in a line; none if none were given.
    #[must_use]
    pub fn given(&self) -> Option<String> {
        let (placed, count) = (&self.placed, self.domain.points.len());
        if count + placed.doubled == 0 {
            return None;
        }
        let inside = count - placed.on_edges - placed.on_facets;
        let mut line = format!(
            "{count} points: {inside} inside, {} on facets, {} on edges",
            placed.on_facets, placed.on_edges
        );
        if placed.doubled > 0 {
            line += &format!("; {} are at a vertex, or given twice", placed.doubled);
        }
        if placed.farthest > 0.0 {
            line += &format!("; the farthest was moved by {:.3e}", placed.farthest);
        }
        Some(line)
    }
}

impl Prepared {
    /// This domain with its surface simplified, and checked once more.
    fn simplify(mut self, options: &PrepareOptions) -> Result<Self, PrepareError> {
        let (value, limit) = (options.simplify, simplify::largest_simplification(&self.domain));
        if !(value >= 0.0 && value <= limit) {
            return Err(PrepareError::Simplify { value, limit });
        }
        let simpler = simplify::simplify(&self.domain, value, options.oriented);
        // Holes have their points by now.
        let mut report = simpler.domain.check(&CheckOptions::default())?;
        if !report.is_meshable() {
            return Err(PrepareError::Defects(Box::new(report)));
        }
        report.counts.extend(self.report.counts.remove_entry(&DefectKind::Nested));
        let renumber = |v: &mut u32| {
            *v = simpler.vertices.get(*v as usize).copied().flatten().unwrap_or(LEFT_OUT);
        };
        self.vertex_map.iter_mut().for_each(renumber);
        let facets = simpler.facets.iter().map(|&f| self.facet_map[f as usize]).collect();
        let simplified = Some(simpler.told);
        Ok(Self {
            domain: simpler.domain,
            facet_map: facets,
            report,
            whole: None,
            simplified,
            ..self
        })
    }

    /// Gives vertices, in a domain that is a part of the input, their numbers in the input, which
    /// has `count` of them.
    fn renumbered(&mut self, numbers: &[u32], count: usize) {
        let mut map = vec![LEFT_OUT; count];
        for (&number, &own) in numbers.iter().zip(&self.vertex_map) {
            map[number as usize] = own;
        }
        self.vertex_map = map;
        self.repairs.exterior_vertices += count - numbers.len();
        if let Some(largest) = &mut self.largest {
            largest.vertex = numbers[largest.vertex as usize];
        }
    }

    /// Gives vertices their numbers in the input, which has `count` of them: those at the boundary
    /// that nothing names, `spare`, are the first points here.
    fn with_spare(&mut self, spare: &[u32], count: usize) {
        let left_out = self.repairs.exterior_vertices;
        if self.simplified.is_some() {
            self.placed.map.resize(spare.len(), LEFT_OUT);
        }
        self.renumbered(&others(spare, count), count);
        self.repairs.exterior_vertices = left_out;
        for (&v, number) in spare.iter().zip(self.placed.map.drain(..spare.len())) {
            self.vertex_map[v as usize] = number;
        }
    }
}

/// The note on bodies inside others that are taken for regions.
fn nested(report: &DomainReport) -> Option<String> {
    let (bodies, them) = match report.count(DefectKind::Nested) {
        0 => return None,
        1 => {
            ("1 body lies inside another and is turned likewise: a region".to_owned(), "it a void")
        }
        n => {
            (format!("{n} bodies lie inside others and are turned likewise: regions"), "them voids")
        }
    };
    Some(format!("{bodies} of their own (holes `auto` makes {them})").replacen(
        "a region of their own",
        "a region of its own",
        1,
    ))
}

fn distance(p: &Point, q: &Point) -> f64 {
    (0..3).map(|k| (p[k] - q[k]) * (p[k] - q[k])).sum::<f64>().sqrt()
}

/// A report of what is left, in which a surface that is open because its facets were there from
/// either side is called doubled, as the report of the input does.
fn with_doubled(mut left: DomainReport, before: &DomainReport, repairs: &Repairs) -> DomainReport {
    let is_open = left.troubles.iter().any(|t| t.kind == TroubleKind::Open);
    let doubled = before.troubles.iter().find(|t| t.kind == TroubleKind::Doubled);
    if let Some(doubled) = doubled.filter(|_| is_open && !repairs.inner.is_empty()) {
        left.troubles.push(doubled.clone());
        left.troubles.sort_by_key(|t| t.kind);
        left.bodies = left.bodies.max(before.bodies);
    }
    left
}

impl Domain {
    /// Makes the domain ready to be meshed.
    ///
    /// # Errors
    /// Why it cannot be meshed.
    pub fn prepare(&self, options: &PrepareOptions) -> Result<Prepared, PrepareError> {
        self.check_structure()?;
        let (mut own, spare) = self.part_spare();
        if options.simplify != 0.0 {
            if !self.points.is_empty() {
                return Err(PrepareError::SimplifyPoints { count: self.points.len() });
            }
            // Vertices at the boundary that nothing names would not be on the simpler one.
            if !own.points.is_empty() {
                own.to_mut().points.clear();
            }
        }
        let (near, numbers) = own.near();
        let mut prepared = near.prepare_near(options);
        if options.simplify != 0.0
            && let Ok(sound) = prepared
        {
            prepared = sound.simplify(options);
        }
        if let Some(numbers) = numbers {
            prepared = prepared.map_err(|error| error.renumbered(&numbers));
            if let Ok(prepared) = &mut prepared {
                prepared.renumbered(&numbers, own.vertices.len());
            }
        }
        if !spare.is_empty() {
            let numbers = others(&spare, self.vertices.len());
            prepared = prepared.map_err(|error| error.renumbered(&numbers));
            if let Ok(prepared) = &mut prepared {
                prepared.with_spare(&spare, self.vertices.len());
            }
        }
        let prepared = prepared?;
        let notes = if options.strict { prepared.notes() } else { Vec::new() };
        if notes.is_empty() { Ok(prepared) } else { Err(PrepareError::Strict { notes }) }
    }

    /// [`Domain::prepare`] but for what the lattice must not reach out for, and for strictness.
    fn prepare_near(&self, options: &PrepareOptions) -> Result<Prepared, PrepareError> {
        let Snapped { domain, lattice, moved, largest, .. } = self.snap_near(options)?;
        let mut repairs = Repairs::default();
        let (domain, mut vertex_map) = self.weld_snapped(domain, &lattice, options, &mut repairs);
        let mut surface = Surface::new(domain);
        surface.clean(&mut repairs);
        if options.repair > 0.0 {
            surface.close_seams(options.repair, &mut repairs);
        }
        if options.fill > 0 {
            surface.fill(options.fill, &mut repairs);
        }
        surface.flatten();
        let PrepareOptions { oriented, nested_voids, .. } = *options;
        let checks = CheckOptions { oriented, nested_voids, ..CheckOptions::default() };
        if surface.domain.facets.is_empty() {
            return Err(self.nothing_left(options, &checks)?);
        }
        let mut placed = Placed::default();
        let Settled { mut report, whole, left } = surface.settle(&checks, &mut repairs)?;
        if let Some(left) = left {
            vertex_map.iter_mut().for_each(|number| *number = left[*number as usize]);
        }
        if report.is_meshable() {
            placed = surface.place_points(&lattice, &checks, &mut repairs)?;
        }
        let Surface { mut domain, origin: facet_map, .. } = surface;
        let whole = whole.map(|whole| Self { points: domain.points.clone(), ..whole });
        if !report.is_meshable() {
            in_numbers_of_input(&mut report, &vertex_map, &facet_map);
            return Err(self.refusal(report, moved, &lattice, &repairs, &checks)?);
        }
        let cells = report.cells.as_ref().ok_or(PrepareError::Undecided)?;
        if !cells.iter().any(|cell| cell.filled) {
            return Err(PrepareError::NothingInside);
        }
        let empty = cells.iter().filter(|cell| !cell.filled && cell.holes.is_empty());
        if empty.count() != report.voids.len() {
            return Err(PrepareError::Undecided);
        }
        domain.holes.append(&mut report.voids);
        Ok(Prepared {
            domain,
            lattice,
            moved,
            largest,
            vertex_map,
            placed,
            facet_map,
            report,
            repairs,
            whole,
            simplified: None,
        })
    }

    /// Why no facet is left: they have no area, as they are or on the lattice.
    fn nothing_left(
        &self,
        options: &PrepareOptions,
        checks: &CheckOptions,
    ) -> Result<PrepareError, PrepareError> {
        let Snapped { domain, lattice, moved, .. } = self.snap_near(options)?;
        let mut none = Repairs::default();
        let (domain, vertex_map) = self.weld_snapped(domain, &lattice, options, &mut none);
        let mut report = domain.check(checks)?;
        in_numbers_of_input(&mut report, &vertex_map, &[]);
        Ok(self.refusal(report, moved, &lattice, &Repairs::default(), checks)?)
    }

    /// The domain on its lattice, in the frame that is asked for, without vertices that nothing
    /// names beyond all that is named.
    ///
    /// # Errors
    /// Those of [`Domain::snap`] and [`Lattice::local`]; [`PrepareError::Tolerance`]; a vertex off
    /// the lattice, if that is refused.
    pub fn snap_by(&self, options: &PrepareOptions) -> Result<Snapped, PrepareError> {
        self.check_structure()?;
        let (own, spare) = self.part_spare();
        let (near, numbers) = own.near();
        let mut snapped = near.snap_near(options);
        let spare = (!spare.is_empty()).then(|| others(&spare, self.vertices.len()));
        for numbers in numbers.into_iter().chain(spare) {
            snapped = snapped.map_err(|error| error.renumbered(&numbers));
            if let Ok(Snapped { largest: Some(largest), .. }) = &mut snapped {
                largest.vertex = numbers[largest.vertex as usize];
            }
        }
        snapped
    }

    fn snap_near(&self, options: &PrepareOptions) -> Result<Snapped, PrepareError> {
        let own = self.snap()?;
        let (low, high) = self.bounds().unwrap_or_default();
        let side = |k: usize| high[k] - low[k];
        let diagonal = (0..3).map(|k| side(k) * side(k)).sum::<f64>().sqrt();
        let limit = LARGEST_TOLERANCE * diagonal;
        if !(options.repair >= 0.0 && options.repair <= limit) {
            return Err(PrepareError::Tolerance { value: options.repair, limit });
        }
        let is_local = match options.frame {
            Frame::Auto => own.lattice.lost_bits() >= LOST_BITS,
            Frame::Own => false,
            Frame::Local => true,
        };
        let snapped = if is_local { self.snap_local()? } else { own };
        Ok(if options.exact_input { snapped.exact()? } else { snapped })
    }

    /// The snapped domain with vertices merged, and for each vertex its new number.
    fn weld_snapped(
        &self,
        mut snapped: Domain,
        lattice: &Lattice,
        options: &PrepareOptions,
        repairs: &mut Repairs,
    ) -> (Domain, Vec<u32>) {
        let step = if options.exact_input { 0.0 } else { lattice.step() };
        let kept = weld(self, step, options.repair);
        let places = snapped.vertices.clone();
        for (place, &kept) in snapped.vertices.iter_mut().zip(&kept) {
            *place = places[kept as usize];
        }
        let Welded { domain, numbers: map } = snapped.welded();
        // For each vertex of the domain the first one of the input.
        let mut first = vec![u32::MAX; domain.vertices.len()];
        for (v, &number) in (0..).zip(&map) {
            let first = &mut first[number as usize];
            *first = (*first).min(v);
            let (own, other) = (&self.vertices[v as usize], &self.vertices[*first as usize]);
            let by_lattice = places[v as usize] == places[*first as usize];
            repairs.count_weld(distance(own, other), if by_lattice { f64::INFINITY } else { step });
        }
        (domain, map)
    }

    /// Why a domain with these defects on the lattice is refused.
    fn refusal(
        &self,
        report: DomainReport,
        moved: usize,
        lattice: &Lattice,
        repairs: &Repairs,
        checks: &CheckOptions,
    ) -> Result<PrepareError, DomainError> {
        let before = self.check(checks)?;
        let step = lattice.step();
        Ok(if moved > 0 && before.is_meshable() {
            PrepareError::BelowLattice { report: Box::new(report), step }
        } else if repairs.is_empty() && !before.is_meshable() {
            PrepareError::Defects(Box::new(before))
        } else {
            // Repaired items are no reason any more.
            PrepareError::Defects(Box::new(with_doubled(report, &before, repairs)))
        })
    }

    /// The domain with equal vertices merged.
    #[must_use]
    pub fn welded(mut self) -> Welded {
        let Some(same) = same_place(&self.vertices) else {
            let numbers = (0..self.vertices.len() as u32).collect();
            return Welded { domain: self, numbers };
        };
        let mut map = Vec::with_capacity(same.len());
        let mut kept = 0;
        for (v, &first) in (0..).zip(&same) {
            // The first of equal ones has its number already.
            let number = if first == v { kept } else { map[first as usize] };
            kept += u32::from(first == v);
            map.push(number);
        }
        let mut number = 0..;
        self.vertices.retain(|_| number.next().is_some_and(|v: u32| same[v as usize] == v));
        let corners = self.facets.iter_mut().flat_map(|f| f.polygons.iter_mut().flatten());
        let ends = self.segments.iter_mut().flat_map(|(ends, _)| ends);
        corners.chain(ends).for_each(|v| *v = map[*v as usize]);
        Welded { domain: self, numbers: map }
    }
}
