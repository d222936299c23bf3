//! Mesh points, look at the tetrahedra, write a file: `cargo run --example points`.

use ltbw::prelude::*;

/// Meshes points on a twisted grid.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let place = |i: u32| [i % 10, i / 10 % 10, i / 100].map(f64::from);
    let points: Vec<Point> = (0..1000).map(place).map(|[x, y, z]| [x + 0.1 * z, y, z]).collect();
    let mesh = Builder::new().build(&PointSet::new(points)?)?.mesh;
    println!("{} tetrahedra, hash {}", mesh.num_tets(), mesh.hash()?);
    let file = std::env::temp_dir().join("ltbw-points.vtu");
    io::write_mesh(&file, &mesh.to_tet_mesh())?;
    Ok(std::fs::remove_file(file)?)
}
