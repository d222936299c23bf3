//! Mesh a box with a hole in it, and write its boundary too: `cargo run --example domain`.

use ltbw::prelude::*;

/// Meshes the domain.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let hole = Domain { holes: vec![[0.5; 3]], ..Domain::cuboid([0.25; 3], [0.75; 3]) };
    let domain = Domain::cuboid([0.0; 3], [2.0, 1.0, 1.0]).join(hole);
    let refined = Refiner::new().radius_edge(1.6).max_volume(0.005).mesh(&domain)?;
    let inside = refined.inside();
    println!("{:?}: {} tetrahedra", refined.outcome, inside.tets.len());
    let file = std::env::temp_dir().join("ltbw-domain.msh");
    io::write_mesh(&file, &inside)?;
    println!("{}, with {} boundary triangles", file.display(), inside.faces.len());
    Ok(())
}
