//! Times queries against building: points of a kind, as many random points asked in Hilbert order.
//! `cargo run --release -p ltbw-core --example query_speed -- uniform 1000000 3`.
use ltbw_core::Builder;
use ltbw_core::order::hilbert;
use ltbw_core::query::{Conflicts, Location};
use ltbw_exact::{Point, PointSet};
use ltbw_generate::{PointKind, generate};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let kind: PointKind = args.next().unwrap_or_else(|| "uniform".into()).parse()?;
    let n: usize = args.next().map_or(Ok(1_000_000), |s| s.parse())?;
    let repeats: usize = args.next().map_or(Ok(1), |s| s.parse())?;
    let set = PointSet::new(generate(kind, n, 1))?;
    let asked = generate(PointKind::Uniform, n, 2);
    for _ in 0..repeats {
        let clock = Instant::now();
        let mesh = Builder::new().build(&set)?.mesh;
        println!("build        {:.3} s, {} bytes", lap(&clock), mesh.memory_bytes());
        let clock = Instant::now();
        let queries = mesh.queries();
        println!("queries()    {:.3} s, {} bytes", lap(&clock), queries.memory_bytes());
        let mut cursor = queries.cursor();

        let clock = Instant::now();
        let sorted: Vec<Point> = hilbert(&asked).into_iter().map(|i| asked[i as usize]).collect();
        println!("order        {:.3} s", lap(&clock));
        let clock = Instant::now();
        let mut inside = 0;
        for &p in &sorted {
            inside += usize::from(!matches!(cursor.locate(p)?, Location::OutsideHull { .. }));
        }
        println!("locate       {:.3} s, {inside} inside", lap(&clock));
        let clock = Instant::now();
        let mut sum = 0;
        for &p in &sorted {
            sum += u64::from(cursor.nearest(p)?);
        }
        println!("nearest      {:.3} s, sum {sum}", lap(&clock));
        let clock = Instant::now();
        let mut tets = 0;
        for &p in &sorted {
            if let Conflicts::Region(region) = cursor.conflicts(p)? {
                tets += region.tets.len();
            }
        }
        println!("conflicts    {:.3} s, {tets} tetrahedra", lap(&clock));
        let clock = Instant::now();
        let edges = cursor.edges().count();
        println!("edges        {:.3} s, {edges}", lap(&clock));
        let clock = Instant::now();
        let (mut corners, mut bounded) = (0, 0);
        for (v, _) in mesh.vertices() {
            if let Some(cell) = cursor.cell(v) {
                bounded += usize::from(cell.is_bounded());
                corners += cell.faces().map(|face| face.corners.len()).sum::<usize>();
            }
        }
        println!("cells        {:.3} s, {bounded} bounded, {corners} corners", lap(&clock));
        let clock = Instant::now();
        let centres = mesh.tet_ids().filter_map(|t| queries.circumcentre(t));
        let worst = centres.map(|c| c.error).fold(0.0, f64::max);
        println!("circumcentre {:.3} s, errors at most {worst:.1e}", lap(&clock));
        println!("cursor       {} bytes", cursor.memory_bytes());
    }
    Ok(())
}

fn lap(clock: &Instant) -> f64 {
    clock.elapsed().as_secs_f64()
}
