//! Meshes of point sets.

use crate::body::Body;
use crate::failure::Failure;
use crate::result::{Meshed, Outcome};
use crate::work::{Reins, in_pool};
use ltbw::domain::Thickness;
use ltbw::{Builder, Point, PointSet};

/// The Delaunay mesh of points, by `threads` threads, at least one.
///
/// # Errors
/// Points that are not finite or do not span space; work cancelled before there is a mesh.
pub fn delaunay(points: Vec<Point>, threads: u32, reins: &Reins) -> Result<Meshed, Failure> {
    in_pool(threads, || {
        let set = PointSet::new(points)?;
        let builder = Builder::new().threads(threads);
        let built = builder.observer(&reins.progress).cancel(&reins.cancel).build(&set)?;
        let outcome = match built.outcome {
            ltbw::Outcome::Complete => Outcome::Complete,
            ltbw::Outcome::Cancelled => Outcome::Cancelled,
            ltbw::Outcome::Budget | ltbw::Outcome::TooManyTets => Outcome::Budget,
        };
        let notes = Thickness::of_flat(set.points()).map(|flat| flat.to_string());
        let mut meshed = Meshed::new(Body::Points { mesh: Box::new(built.mesh), set }, outcome);
        meshed.notes.extend(notes);
        Ok(meshed)
    })
}
