//! Meshes of point sets.

use crate::body::Body;
use crate::failure::Failure;
use crate::result::{Meshed, Outcome};
use crate::work::{Reins, in_pool};
use ltbw::domain::Thickness;
use ltbw::{Builder, Point, PointSet, RemoveError};

/// Points removed between two looks at whether the work is cancelled.
const CHECK_EVERY: usize = 1024;

/// The Delaunay mesh of points, by `threads` threads, at least one, without the vertices whose
/// numbers are in `without`. The others keep theirs.
///
/// # Errors
/// Points that are not finite or do not span space; numbers of none; work cancelled before there is
/// a mesh.
pub fn delaunay(
    points: Vec<Point>,
    without: &[u32],
    threads: u32,
    reins: &Reins,
) -> Result<Meshed, Failure> {
    if let Some(&vertex) = without.iter().find(|&&v| v as usize >= points.len()) {
        return Err(RemoveError::Unknown { vertex }.into());
    }
    in_pool(threads, || {
        let set = PointSet::new(points)?;
        let builder = Builder::new().threads(threads);
        let mut built = builder.observer(&reins.progress).cancel(&reins.cancel).build(&set)?;
        let mut outcome = match built.outcome {
            ltbw::Outcome::Complete => Outcome::Complete,
            ltbw::Outcome::Cancelled => Outcome::Cancelled,
            ltbw::Outcome::Budget | ltbw::Outcome::TooManyTets => Outcome::Budget,
        };
        for some in without.chunks(CHECK_EVERY) {
            if reins.cancel.is_cancelled() {
                outcome = Outcome::Cancelled;
            }
            if outcome != Outcome::Complete {
                break;
            }
            for &vertex in some {
                match built.mesh.remove(vertex) {
                    // Gone with another one at its place.
                    Ok(()) | Err(RemoveError::Unknown { .. }) => {}
                    Err(error) => return Err(error.into()),
                }
            }
        }
        let notes = Thickness::of_flat(set.points()).map(|flat| flat.to_string());
        let mut meshed = Meshed::new(Body::Points { mesh: Box::new(built.mesh), set }, outcome);
        meshed.notes.extend(notes);
        Ok(meshed)
    })
}
