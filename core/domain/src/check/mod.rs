//! The exact check of a domain before it is meshed.
//!
//! 1. Vertices: duplicates, unused ones. Facets by themselves: no area, crossing edges, corners
//!    out of the plane, hole points (`complex.rs`).
//! 2. Every two pieces that may meet (`parting.rs`, `large.rs`): do they touch otherwise than in
//!    what both name (`pairs.rs`, `contact.rs`)?
//! 3. If all that is sound, the surface divides space into cells, which are found exactly
//!    (`cells.rs`): gaps through which the outside leaks in, seeds in no cell, orientation,
//!    volumes. A part of the surface too small for any segment that is tried is a finding, too.
//!    What has nothing but exterior around it is told apart (`outer.rs`), gaps from ends of sheets
//!    (`ends.rs`), bodies in bodies from voids (`filling.rs`).
//! 4. Errors are summed up by what they mean for the bodies of the surface (`bodies.rs`).
//!
//! Every decision is made by exact predicates; floating point only chooses where to look, with
//! boxes that are exact. Cost: sorting and searching in n triangles, about n log n, as long as few
//! boxes overlap; seconds for a million triangles.

mod bodies;
mod cells;
mod complex;
pub(crate) mod contact;
mod ends;
mod exact;
mod filling;
mod large;
mod outer;
mod pairs;
mod parting;
mod rays;
mod seeds;
#[cfg(test)]
mod tests;

use crate::{DefectKind, Domain, DomainDefect, DomainError, Element, Lattice, Severity};
pub use bodies::{Trouble, TroubleKind};
pub(crate) use cells::Cells;
use complex::Complex;
pub(crate) use complex::same_place;
pub use exact::Volume;
use ltbw_exact::Point;
pub use outer::Exterior;
use rstar::RTree;
use std::collections::BTreeMap;

/// The options of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CheckOptions {
    /// The facets are an oriented surface: their orientation is checked, every open edge inside is
    /// a leak, and a body inside another is a void if it is turned the other way, a region if it is
    /// turned likewise. Otherwise holes are where the hole points are, and sheets may stand free
    /// inside.
    pub oriented: bool,
    /// A body inside another is a void however it is turned, and one in that void a body.
    pub nested_voids: bool,
    /// The most defects of each kind that are listed; all are counted.
    pub listed: usize,
}

impl Default for CheckOptions {
    fn default() -> Self {
        Self { oriented: false, nested_voids: false, listed: 1000 }
    }
}

/// A connected piece of space that the facets bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Its volume.
    pub volume: Volume,
    /// It is to be meshed.
    pub filled: bool,
    /// The holes whose points are in it.
    pub holes: Vec<u32>,
    /// The regions whose points are in it.
    pub regions: Vec<u32>,
}

/// The findings of the check.
#[derive(Debug, Clone, PartialEq)]
pub struct DomainReport {
    /// Defects, sorted by kind, at most [`CheckOptions::listed`] of each.
    pub defects: Vec<DomainDefect>,
    /// The number of defects of each kind, listed or not.
    pub counts: BTreeMap<DefectKind, u64>,
    /// The bounded cells; `None` if other defects leave it open what they are.
    pub cells: Option<Vec<Cell>>,
    /// A point inside each cell that is a void by orientation or nesting.
    pub voids: Vec<Point>,
    /// The facets that point inwards, of an oriented surface.
    pub inward: Vec<u32>,
    /// The items with nothing but exterior around them; none if defects leave that open.
    pub exterior: Exterior,
    /// The meaning of the errors for the surface, by kind.
    pub troubles: Vec<Trouble>,
    /// The number of bodies: sets of facets that edges connect. 0 if there are no errors.
    pub bodies: usize,
}

impl DomainReport {
    /// The gravest of the findings.
    #[must_use]
    pub fn severity(&self) -> Option<Severity> {
        self.counts.keys().map(|kind| kind.severity()).max()
    }

    /// Can the domain be meshed (after repair)?
    #[must_use]
    pub fn is_meshable(&self) -> bool {
        self.severity() != Some(Severity::Error)
    }

    /// Is there nothing wrong?
    #[must_use]
    pub fn passed(&self) -> bool {
        self.severity().is_none_or(|s| s == Severity::Info)
    }

    /// The number of defects of a kind.
    #[must_use]
    pub fn count(&self, kind: DefectKind) -> u64 {
        self.counts.get(&kind).copied().unwrap_or(0)
    }

    /// The volume of all filled cells, if they are known.
    #[must_use]
    pub fn volume(&self) -> Option<Volume> {
        let filled = self.cells.as_ref()?.iter().filter(|c| c.filled);
        Some(filled.fold(Volume::default(), |sum, cell| sum.plus(&cell.volume)))
    }
}

/// Defects on their way into a report.
struct Findings {
    defects: BTreeMap<DefectKind, Vec<DomainDefect>>,
    counts: BTreeMap<DefectKind, u64>,
    listed: usize,
    /// Errors, for the sum by bodies; at most [`COUNTED`] of them.
    errors: Vec<bodies::Counted>,
}

/// The most errors that are told apart by bodies.
const COUNTED: usize = 1 << 20;

impl Findings {
    fn add(&mut self, kind: DefectKind, elements: Vec<Element>, at: Vec<Point>) {
        *self.counts.entry(kind).or_default() += 1;
        if self.errors.len() < COUNTED {
            self.errors.extend(bodies::counted(kind, &elements));
        }
        let list = self.defects.entry(kind).or_default();
        if list.len() < self.listed {
            list.push(DomainDefect { kind, elements, at });
        }
    }

    fn has(&self, kinds: &[DefectKind]) -> bool {
        kinds.iter().any(|kind| self.counts.contains_key(kind))
    }
}

impl Domain {
    /// Checks the domain exactly.
    ///
    /// # Errors
    /// What makes it impossible to look at: see [`Domain::check_structure`] and [`Lattice::of`].
    pub fn check(&self, options: &CheckOptions) -> Result<DomainReport, DomainError> {
        self.check_with(options, &[])
    }

    /// [`Domain::check`] of a domain in which some facets, ascending, are inner ones: they are
    /// between two bodies, so that passing through one leads neither in nor out.
    pub(crate) fn check_with(
        &self,
        options: &CheckOptions,
        inner: &[u32],
    ) -> Result<DomainReport, DomainError> {
        self.check_structure()?;
        // Coordinates are in the range in which nothing overflows.
        Lattice::of(self)?;
        let (defects, counts, errors) = Default::default();
        let mut findings = Findings { defects, counts, listed: options.listed, errors };
        let complex = Complex::new(self, &mut findings);
        let pieces = complex.pieces();
        pairs::find(&complex, &pieces, &mut findings);
        let index = RTree::bulk_load(pieces);
        let unsound = [
            DefectKind::Degenerate,
            DefectKind::Overlap,
            DefectKind::Intersection,
            DefectKind::TJunction,
        ];
        let mut report = DomainReport {
            defects: Vec::new(),
            counts: BTreeMap::new(),
            cells: None,
            voids: Vec::new(),
            inward: Vec::new(),
            exterior: Exterior::default(),
            troubles: Vec::new(),
            bodies: 0,
        };
        if findings.has(&unsound) {
            cells::open_edges(&complex, &mut findings);
        } else if !complex.triangles.is_empty() {
            match Cells::new(&complex, &index, &mut findings) {
                Ok(cells) => {
                    let question = seeds::Question::new(self, &complex, &index, cells, inner);
                    question.assign(options, &mut findings, &mut report);
                }
                Err(triangle) => complex.unresolved(triangle, &mut findings),
            }
        }
        report.defects = findings.defects.into_values().flatten().collect();
        report.counts = findings.counts;
        (report.troubles, report.bodies) =
            bodies::troubles(self, &findings.errors, &report.defects);
        Ok(report)
    }
}
