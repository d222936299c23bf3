//! A wanted edge length at each place, progress, and cancelling: `cargo run --example watch`.

use ltbw::prelude::*;

/// Meshes a cube that is fine at one corner.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let vertices = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    let facets = sides.iter().map(|s| Facet::polygon(s, 0)).collect();
    let cube = Domain { vertices, facets, ..Domain::default() };
    let size = |p: Point| 0.05 + 0.2 * p.iter().sum::<f64>();
    let enough = CancelToken::new();
    let watch = |p: Progress| {
        println!("{:?}: {} points", p.phase, p.done);
        if p.done > 100_000 {
            enough.cancel();
        }
    };
    let refined = Refiner::new().sizing(&size).observer(&watch).cancel(&enough).mesh(&cube)?;
    println!("{:?}: {} tetrahedra", refined.outcome, refined.num_tets());
    Ok(())
}
