//! Removes points from a mesh and puts them back, and prints the nanoseconds that each takes:
//! `cargo run --release -p ltbw-core --example remove_speed -- uniform 1000000 3`.
use ltbw_core::{Builder, Inserted, Point, Vertex, order};
use ltbw_exact::PointSet;
use ltbw_generate::{PointKind, generate};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let kind: PointKind = args.next().unwrap_or_else(|| "uniform".into()).parse()?;
    let n: usize = args.next().map_or(Ok(1_000_000), |s| s.parse())?;
    let repeats: usize = args.next().map_or(Ok(1), |s| s.parse())?;
    let set = PointSet::new(generate(kind, n, 1))?;
    let mut mesh = Builder::new().build(&set)?.mesh;
    let before = mesh.hash()?;
    let mut all: Vec<(Vertex, Point)> = mesh.vertices().collect();
    all.sort_unstable_by_key(|v| v.0);
    // Every tenth, along the curve.
    let mut some: Vec<(Vertex, Point)> = all.into_iter().step_by(10).collect();
    let points: Vec<Point> = some.iter().map(|v| v.1).collect();
    some = order::hilbert(&points).into_iter().map(|i| some[i as usize]).collect();
    for _ in 0..repeats {
        let clock = Instant::now();
        for &(v, _) in &some {
            mesh.remove(v)?;
        }
        let removed = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        for (v, p) in &mut some {
            if let Inserted::Vertex(number) = mesh.insert(*p)? {
                *v = number;
            }
        }
        let inserted = clock.elapsed().as_secs_f64();
        let each = |seconds: f64| 1e9 * seconds / some.len() as f64;
        println!(
            "remove {:.0} ns, insert {:.0} ns, {:.2} times",
            each(removed),
            each(inserted),
            removed / inserted
        );
    }
    assert_eq!(mesh.hash()?, before, "the mesh is as before");
    Ok(())
}
