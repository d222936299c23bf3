//! A domain that is to be meshed, with what is asked for.

use crate::bounds::Asked;
use crate::parts::Boundary;
use crate::progress::Progress;
use crate::sizes::Field;
use crate::task::Task;
use crate::workers::Crew;
use ltbw::refine::Refiner;
use std::path::Path;

/// The task with a domain.
pub(crate) struct Job<'a> {
    pub(crate) task: Task<'a>,
    /// Bounds.
    pub(crate) asked: Asked,
    /// Wanted edge lengths.
    pub(crate) field: Option<Field>,
    /// The workers that refine it without a common mesh.
    pub(crate) crew: Option<Crew>,
    /// The most points to insert.
    pub(crate) max_points: Option<u64>,
    /// The distance within which facets are taken for coplanar.
    pub(crate) flat_tolerance: f64,
    /// The parts of the boundary.
    pub(crate) boundary: Boundary,
    /// With the exterior.
    pub(crate) keep_exterior: bool,
    /// Write the Delaunay mesh, exterior included, even if the boundary is not in it.
    pub(crate) write_unrecovered: bool,
    /// The files of the histograms and of the rounds' timeline.
    pub(crate) histogram: Option<&'a Path>,
    pub(crate) trace: Option<&'a Path>,
    /// The share of tetrahedra, and of volume, that may be excused.
    pub(crate) excused_share: f64,
}

impl Job<'_> {
    /// The number of parts that the mesh has.
    pub(crate) fn parts(&self) -> usize {
        parts_by(self.crew)
    }

    /// The refiner that is asked for.
    pub(crate) fn refiner<'a>(&'a self, progress: &'a Progress) -> Refiner<'a> {
        let mut refiner = self.asked.refiner().observer(progress).cancel(self.task.stop.token());
        refiner = refiner.flat_tolerance(self.flat_tolerance);
        if self.task.json.or(self.task.page).or(self.histogram).is_some() {
            refiner = refiner.count_angles();
        }
        if let Some(field) = &self.field {
            refiner = refiner.sizing(field);
        }
        self.max_points.map_or(refiner, |count| refiner.max_points(count))
    }
}

/// The number of parts that a mesh of a crew has.
pub(crate) fn parts_by(crew: Option<Crew>) -> usize {
    crew.map_or(1, |crew| crew.workers as usize)
}
