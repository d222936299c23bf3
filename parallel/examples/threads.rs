//! Mesh points on several threads and print their figures: `cargo run --example threads`.

use ltbw::prelude::*;

/// Meshes with two workers.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let place = |i: u32| [i * 37 % 1009, i * 53 % 1013, i * 71 % 1019].map(f64::from);
    let set = PointSet::new((0..20_000).map(place).collect())?;
    let built = Builder::new().threads(2).measure(0).build(&set)?;
    println!("{} tetrahedra, {:?}", built.mesh.num_tets(), built.outcome);
    built.summary.iter().for_each(|summary| println!("{summary}"));
    Ok(())
}
