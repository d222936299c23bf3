//! `checker`: bytes to a mesh and a planted defect, which the checker must find.
//!
//! The bytes: 4 of style, 2 plants with 4 bytes of choice each, then 4 for each of at most 24
//! points ([`snap`]).

use crate::families::snap;
use crate::plant::{PLANTS, Subject, try_plant};
use arbitrary::Unstructured;
use ltbw::{Builder, PointSet};

/// Plants the defects of `bytes` into the mesh of its points.
///
/// # Panics
/// If the checker overlooks one, calls it by a wrong name, or does not pass the sound mesh.
pub fn checker(bytes: &[u8]) {
    let mut u = Unstructured::new(bytes);
    // Zeros follow the last byte.
    let style: u32 = u.arbitrary().unwrap_or_default();
    let plants: [(u8, u32); 2] = u.arbitrary().unwrap_or_default();
    let (cells, _) = u.take_rest().as_chunks::<4>();
    let points = snap(style, &cells[..cells.len().min(24)]);
    let set = PointSet::new(points).expect("snapped points are finite");
    let Ok(built) = Builder::new().build(&set) else { return };
    let mesh = Subject::of(&built.mesh);
    mesh.passes().unwrap_or_else(|why| panic!("sound, but {why}: {:?}", set.points()));
    for (plant, choice) in plants {
        let plant = PLANTS[usize::from(plant) % PLANTS.len()];
        if let Err(why) = try_plant(&mesh, plant, choice as usize) {
            panic!("{why}: {:?}", set.points());
        }
    }
}
