//! Mesh a box with a hole in it and a material in one half: `cargo run --example domain`.

use ltbw::prelude::*;

/// The corners of a box, and its sides, whose corners count from `first` on.
fn box_of(low: Point, high: Point, first: u32) -> (Vec<Point>, Vec<Facet>) {
    let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] });
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let side = |s: [u32; 4]| Facet::polygon(&s.map(|v| v + first), 0);
    ((0..8).map(corner).collect(), sides.map(side).to_vec())
}

/// Meshes the domain.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (outer, inner) = (box_of([0.0; 3], [2.0, 1.0, 1.0], 0), box_of([0.25; 3], [0.75; 3], 8));
    let vertices = [outer.0, inner.0].concat();
    let facets = [outer.1, inner.1].concat();
    let domain = Domain { vertices, facets, holes: vec![[0.5; 3]], ..Domain::default() };
    let refined = Refiner::new().radius_edge(1.6).max_volume(0.005).mesh(&domain)?;
    let inside = refined.to_tet_mesh(false);
    println!("{:?}: {} tetrahedra", refined.outcome, inside.tets.len());
    println!("{} triangles on the boundary", refined.boundary(false).len());
    Ok(())
}
