//! From what a file says to what refinement takes.
//!
//! Snap to the lattice, merge equal vertices, cut facets that are not planar into triangles, check
//! exactly, and put a hole point into every void of an oriented surface. What the check of the
//! snapped domain refuses is checked once more as it was, to tell whether the domain itself is
//! wrong or has features below the lattice.

use crate::check::same_place;
use crate::{CheckOptions, Domain, DomainError, DomainReport, Facet, Lattice, Move, Snapped};
use crate::{DefectKind, triangulate};

/// How to prepare a domain.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PrepareOptions {
    /// Refuse a domain that is not on its lattice.
    pub exact_input: bool,
    /// Measure from the middle of the domain: see [`Lattice::local`].
    pub local_frame: bool,
    /// The facets are an oriented surface: see [`CheckOptions::oriented`].
    pub oriented: bool,
}

/// A domain that can be meshed.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// The domain: vertices distinct and on the lattice, facets planar, a hole point in each void.
    pub domain: Domain,
    /// The lattice.
    pub lattice: Lattice,
    /// How many vertices moved.
    pub moved: usize,
    /// The farthest move, if any vertex moved, with the number of the vertex in the input.
    pub largest: Option<Move>,
    /// For each vertex of the input its number in the domain.
    pub vertex_map: Vec<u32>,
    /// For each facet of the domain the facet of the input that it is part of.
    pub facet_map: Vec<u32>,
    /// What the check found: nothing graver than warnings. Elements are those of the domain.
    pub report: DomainReport,
}

/// Why a domain cannot be meshed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// It cannot be looked at.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// It has defects.
    #[error("{}", summary(.0))]
    Defects(Box<DomainReport>),
    /// It has defects once its vertices are on the lattice: features below the lattice.
    #[error("on the lattice of step {step:e}: {}", summary(.report))]
    BelowLattice {
        /// The defects.
        report: Box<DomainReport>,
        /// The step of the lattice.
        step: f64,
    },
    /// It bounds nothing that is not a hole.
    #[error("there is nothing to mesh: all that the facets bound are holes")]
    NothingInside,
    /// The inside was not found, or a void has no point that is a double.
    #[error("the facets are too thin to tell the inside from the outside")]
    Undecided,
}

impl PrepareError {
    /// A short code that stays the same between versions, for programs to match on.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            PrepareError::Domain(error) => error.code(),
            PrepareError::Defects(_) => "domain.defects",
            PrepareError::BelowLattice { .. } => "domain.below-lattice",
            PrepareError::NothingInside => "domain.nothing-inside",
            PrepareError::Undecided => "domain.undecided",
        }
    }
}

/// The gravest defects in a line: how many of each kind, and the first one.
fn summary(report: &DomainReport) -> String {
    let gravest = report.severity();
    let grave = |kind: &DefectKind| Some(kind.severity()) == gravest;
    let counts: Vec<String> = report
        .counts
        .iter()
        .filter(|(kind, _)| grave(kind))
        .map(|(kind, count)| format!("{count} {}", kind.code()))
        .collect();
    let first = report.defects.iter().find(|d| grave(&d.kind));
    let first = first.map(|d| format!("; the first: {d}")).unwrap_or_default();
    format!("defects: {}{first}", counts.join(", "))
}

impl Domain {
    /// Makes the domain ready to be meshed.
    ///
    /// # Errors
    /// Why it cannot be meshed.
    pub fn prepare(&self, options: &PrepareOptions) -> Result<Prepared, PrepareError> {
        let snapped = if options.local_frame { self.snap_local()? } else { self.snap()? };
        let snapped = if options.exact_input { snapped.exact()? } else { snapped };
        let Snapped { domain, lattice, moved, largest } = snapped;
        let (mut domain, vertex_map) = domain.welded();
        let facet_map = domain.flatten();
        let checks = CheckOptions { oriented: options.oriented, ..CheckOptions::default() };
        let mut report = domain.check(&checks)?;
        if !report.is_meshable() {
            let before = if moved == 0 { None } else { Some(self.check(&checks)?) };
            let step = lattice.step();
            return Err(match before {
                Some(before) if before.is_meshable() => {
                    PrepareError::BelowLattice { report: Box::new(report), step }
                }
                // Elements are those of the input.
                Some(before) => PrepareError::Defects(Box::new(before)),
                None => PrepareError::Defects(Box::new(self.check(&checks)?)),
            });
        }
        let cells = report.cells.as_ref().ok_or(PrepareError::Undecided)?;
        if !cells.iter().any(|cell| cell.filled) {
            return Err(PrepareError::NothingInside);
        }
        let empty = cells.iter().filter(|cell| !cell.filled && cell.holes.is_empty());
        if options.oriented && empty.count() != report.voids.len() {
            return Err(PrepareError::Undecided);
        }
        domain.holes.append(&mut report.voids);
        Ok(Prepared { domain, lattice, moved, largest, vertex_map, facet_map, report })
    }

    /// The domain with equal vertices merged, and for each vertex its new number.
    #[must_use]
    pub fn welded(mut self) -> (Self, Vec<u32>) {
        let Some(same) = same_place(&self.vertices) else {
            let identity = (0..self.vertices.len() as u32).collect();
            return (self, identity);
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
        (self, map)
    }

    /// Cuts facets that are not planar into triangles, each a facet of the same marker; returns for
    /// each facet the one that it was part of. Facets that are wrong by themselves stay.
    pub fn flatten(&mut self) -> Vec<u32> {
        let mut origin = Vec::with_capacity(self.facets.len());
        let mut flat = Vec::with_capacity(self.facets.len());
        for (number, facet) in (0..).zip(std::mem::take(&mut self.facets)) {
            let simple = facet.polygons.iter().map(Vec::len).sum::<usize>() <= 3;
            let cut = if simple { None } else { Some(triangulate::facet(&self.vertices, &facet)) };
            match cut {
                Some(cut) if !cut.planar && cut.is_sound() => {
                    origin.extend(cut.triangles.iter().map(|_| number));
                    flat.extend(cut.triangles.iter().map(|t| Facet::polygon(t, facet.marker)));
                    let loose = cut.loose.iter().map(|&edge| (edge, facet.marker));
                    self.segments.extend(loose);
                }
                _ => {
                    origin.push(number);
                    flat.push(facet);
                }
            }
        }
        self.facets = flat;
        origin
    }

    /// Turns the facets of these numbers round, for example [`DomainReport::inward`].
    pub fn turn_round(&mut self, facets: &[u32]) {
        for &f in facets {
            if let Some(facet) = self.facets.get_mut(f as usize) {
                facet.polygons.iter_mut().for_each(|polygon| polygon.reverse());
            }
        }
    }
}
