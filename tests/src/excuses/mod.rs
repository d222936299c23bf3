//! The counter of excuses: may a mesh of this domain leave anything over a bound?
//!
//! Refinement excuses what it leaves over a bound, and gives reasons. Whoever believes the reasons
//! sees no mesh as a failure. So the counter computes by itself, from the domain, at which angles
//! its features meet, and from the mesh, with the checker's exact tests, how much of the volume is
//! over a bound. Where no angle is below [`SMALL`], at most [`ALLOWED`] of the volume may be.

mod complex;
mod features;
#[cfg(test)]
mod tests;

pub use features::{Features, NEEDLE};

use crate::domains::plc_of;
use ltbw::domain::vector::{cross, dot, minus};
use ltbw::domain::{Domain, Prepared};
use ltbw::refine::Refined;
use ltbw::{Point, TetMesh};
use ltbw_verify::{Conformity, ConformityDefect, Limits, Mesh, Options, Plc, conforms};
use std::collections::BTreeSet;

/// The angle, in degrees, below which features excuse what is over a bound near them.
pub const SMALL: f64 = 20.0;
/// The part of the volume that may be over a bound where no features meet at a smaller angle: the
/// rounding of points to the lattice is an excuse, too.
pub const ALLOWED: f64 = 1e-3;

/// A vector of length 1.
fn unit(p: &Point) -> Point {
    let length = dot(p, p).sqrt();
    p.map(|c| c / length)
}

/// The way in which the features of a domain meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Meeting {
    /// At no small angle: nothing is excused.
    Wide,
    /// At none but the tips of facets that are needles, which are counted apart.
    Needles,
    /// At some small angle.
    Sharp,
}

impl Meeting {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Meeting::Wide => "wide",
            Meeting::Needles => "needles",
            Meeting::Sharp => "sharp",
        }
    }
}

impl Features {
    /// The way in which they meet.
    #[must_use]
    pub fn meeting(&self) -> Meeting {
        let others = self.segments.min(self.segment_facet).min(self.facets);
        match (others < SMALL || (NEEDLE..SMALL).contains(&self.plane), self.needles) {
            (true, _) => Meeting::Sharp,
            (false, 0) => Meeting::Wide,
            (false, _) => Meeting::Needles,
        }
    }
}

/// The features of a domain, and how much of its mesh is over a bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Count {
    /// The features.
    pub features: Features,
    /// Tetrahedra of the mesh.
    pub tets: usize,
    /// Tetrahedra that are over a bound.
    pub over: usize,
    /// The part of the volume that these fill; 1 of a mesh without tetrahedra.
    pub share: f64,
}

impl Count {
    /// Counts in a mesh without its exterior what the checker, asked for all it finds, found over
    /// a bound.
    ///
    /// # Errors
    /// The first defect of a mesh whose bounds were not tested because of it.
    pub fn of(features: Features, mesh: &TetMesh, found: &Conformity) -> Result<Self, String> {
        if let Some(defect) = found.mesh_defects.first() {
            return Err(defect.to_string());
        }
        if found.count(ConformityDefect::TooFine) > 0 {
            return Err(ConformityDefect::TooFine.text().to_owned());
        }
        let volume = |tet: &[u32; 4]| {
            let [a, b, c, d] = tet.map(|v| &mesh.points[v as usize]);
            dot(&minus(a, d), &cross(&minus(b, d), &minus(c, d))).abs() / 6.0
        };
        let is_bound = |breach| {
            matches!(
                breach,
                ConformityDefect::RatioExceeded
                    | ConformityDefect::VolumeExceeded
                    | ConformityDefect::EdgeExceeded
            )
        };
        let breaches = found.findings.iter().filter(|finding| is_bound(finding.breach));
        // One may be over two bounds.
        let over: BTreeSet<u32> =
            breaches.flat_map(|finding| finding.ids.iter().copied()).collect();
        let all: f64 = mesh.tets.iter().map(volume).sum();
        let share: f64 = over.iter().map(|&t| volume(&mesh.tets[t as usize])).sum();
        let share = if all > 0.0 { share / all } else { 1.0 };
        Ok(Self { features, tets: mesh.tets.len(), over: over.len(), share })
    }

    /// Is more over a bound than the angles of the domain excuse?
    #[must_use]
    pub fn is_broken(&self) -> bool {
        self.features.meeting() == Meeting::Wide && self.share > ALLOWED
    }
}

impl std::fmt::Display for Count {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} of {} tetrahedra, {:.3} % of the volume, are over a bound; features are {}: {:.2} \
             degrees at least, {} needles",
            self.over,
            self.tets,
            100.0 * self.share,
            self.features.meeting().name(),
            self.features.least(),
            self.features.needles
        )
    }
}

/// The bounds of a domain, those of its regions included.
#[must_use]
pub fn limits(domain: &Domain, radius_edge: Option<f64>, max_volume: Option<f64>) -> Limits {
    let region_volumes = domain.regions.iter().map(|region| region.max_volume).collect();
    Limits { radius_edge, max_volume, region_volumes, ..Limits::default() }
}

/// Has the checker judge a mesh without its exterior, and counts what is over a bound; `tolerance`
/// is the one that patches are flat within.
///
/// # Errors
/// Those of [`Count::of`].
pub fn judge(
    domain: &Domain,
    tolerance: f64,
    mesh: &TetMesh,
    limits: &Limits,
) -> Result<(Conformity, Count), String> {
    let plc = Plc { flat_tolerance: tolerance, ..plc_of(domain) };
    let options = Options { max_defects: usize::MAX, numbered_regions: true, ..Options::default() };
    let view = Mesh::new(&mesh.points, &mesh.tets);
    let found = match mesh.tets.is_empty() {
        // There is nothing to test.
        true => Conformity::default(),
        false => conforms(&view, &plc, mesh.tet_tags.as_deref(), limits, &options),
    };
    let count = Count::of(Features::of(domain, tolerance), mesh, &found)?;
    Ok((found, count))
}

/// Judges a refined domain: [`judge`], with the tolerance that its patches have.
///
/// # Errors
/// Those of [`Count::of`].
pub fn judge_refined(
    ready: &Prepared,
    refined: &Refined,
    limits: &Limits,
) -> Result<(Conformity, Count), String> {
    judge(&ready.domain, refined.stats.flat_tolerance, &refined.inside(), limits)
}
