//! Find the tetrahedron that holds a place, and its neighbours: `cargo run --example walk`.

use ltbw::prelude::*;

/// Meshes a grid and asks where a place is.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let place = |i: u32| [i % 10, i / 10 % 10, i / 100].map(f64::from);
    let mesh = Builder::new().build(&PointSet::new((0..1000).map(place).collect())?)?.mesh;
    let found = mesh.queries().cursor().locate([4.2, 4.3, 4.4])?;
    let Location::Tet(tet) = found else { return Err(format!("{found:?}").into()) };
    let beside: Vec<_> = (0..4).filter_map(|slot| mesh.neighbour(tet, slot)).collect();
    println!("in tetrahedron {tet}: {:?}, beside {beside:?}", mesh.tet(tet));
    Ok(())
}
