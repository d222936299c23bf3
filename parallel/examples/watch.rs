//! A wanted edge length at each place, progress, and cancelling: `cargo run --example watch`.

use ltbw::prelude::*;

/// Meshes a box with a hole, fine at one corner.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let hole = Domain { holes: vec![[0.5; 3]], ..Domain::cuboid([0.25; 3], [0.75; 3]) };
    let domain = Domain::cuboid([0.0; 3], [2.0, 1.0, 1.0]).join(hole);
    let size = |p: Point| 0.05 + 0.2 * p.iter().sum::<f64>();
    let enough = CancelToken::new();
    let watch = |p: Progress| {
        println!("{:?}: {} points", p.phase, p.done);
        if p.done > 100_000 {
            enough.cancel();
        }
    };
    let refined = Refiner::new().sizing(&size).observer(&watch).cancel(&enough).mesh(&domain)?;
    println!("{:?}: {} tetrahedra", refined.outcome, refined.num_tets());
    Ok(())
}
