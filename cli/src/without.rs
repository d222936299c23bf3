//! `delaunay --without`: vertices at the points of a file are removed from the mesh.

use crate::console;
use crate::outcome::{Failure, show};
use crate::progress::Stage;
use ltbw::{Built, Point, PointSet, RemoveError, Vertex};
use std::collections::HashMap;
use std::path::PathBuf;

/// The points to be removed.
pub(crate) struct Without {
    /// The name of their file.
    pub(crate) name: PathBuf,
    pub(crate) points: Vec<Point>,
}

/// The points of a mesh, with their tags.
pub(crate) struct Given {
    pub(crate) set: PointSet,
    pub(crate) tags: Option<Vec<i64>>,
}

/// The bits that equal points share.
fn key(p: Point) -> [u64; 3] {
    p.map(|c| (c + 0.0).to_bits())
}

impl Without {
    /// Removes the points from a mesh that has all that were given; what is left is numbered from
    /// 0 on in its order.
    pub(crate) fn remove(&self, built: &mut Built, given: Given) -> Result<Given, Failure> {
        let _stage = Stage::begin("remove");
        let refuse = |why: String| Failure::Without { path: self.name.clone(), why };
        let mut at: HashMap<[u64; 3], Option<Vertex>> =
            self.points.iter().map(|&p| (key(p), None)).collect();
        for (v, p) in built.mesh.vertices() {
            if let Some(found) = at.get_mut(&key(p)) {
                *found = Some(v);
            }
        }
        for (index, &p) in self.points.iter().enumerate() {
            let Some(v) = at.get(&key(p)).copied().flatten() else {
                return Err(refuse(format!("point {index}, {p:?}, is no vertex of the mesh")));
            };
            match built.mesh.remove(v) {
                // The same place once more.
                Ok(()) | Err(RemoveError::Unknown { .. }) => {}
                Err(error) => return Err(refuse(error.to_string())),
            }
        }
        let all = given.set.len();
        let left = built.mesh.renumber();
        built.duplicates = built.mesh.duplicates().to_vec();
        // They are of the mesh before.
        built.parts.clear();
        let (from, gone) = (given.set.points(), all - left.len());
        let points: Vec<Point> = left.iter().map(|&v| from[v as usize]).collect();
        let tags = given.tags.map(|tags| left.iter().map(|&v| tags[v as usize]).collect());
        console::people(&format!("without   {gone} of {all} points, by {}", show(&self.name)));
        let set = PointSet::new(points)
            .map_err(|error| Failure::Points { path: self.name.clone(), error })?;
        Ok(Given { set, tags })
    }
}
