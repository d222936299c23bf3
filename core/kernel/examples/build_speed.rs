//! Builds the mesh of generated points and prints times and counters:
//! `cargo run --release -p ltbw-core --example build_speed -- uniform 1000000 3`.
use ltbw_core::Builder;
use ltbw_exact::PointSet;
use ltbw_generate::{PointKind, generate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let kind: PointKind = args.next().unwrap_or_else(|| "uniform".into()).parse()?;
    let n: usize = args.next().map_or(Ok(1_000_000), |s| s.parse())?;
    let repeats: usize = args.next().map_or(Ok(1), |s| s.parse())?;
    let set = PointSet::new(generate(kind, n, 1))?;
    for _ in 0..repeats {
        let built = Builder::new().build(&set)?;
        println!(
            "order {:.3} s, insert {:.3} s, {} tets, {} hull facets, {:?}",
            built.stats.order_seconds,
            built.stats.insert_seconds,
            built.mesh.num_tets(),
            built.mesh.num_hull_faces(),
            built.stats.predicates
        );
    }
    Ok(())
}
