//! Builds the mesh of generated points on one thread, checks it on one and on several, and prints
//! the times side by side, since a ratio of one run is worth more than two times of two runs:
//! `cargo run --release -p ltbw-cli --example check_speed -- uniform 1000000 2 5 unaided`
//! (kind, number of points, threads of the check, rounds; the last word is optional).
//!
//! *build* is ordering and insertion. *check* is `ltbw_verify::check` at full depth, all five
//! levels and the canonical hash, on a mesh in memory with its neighbours and its hull given;
//! *unaided* is the same check with nothing given but points and tetrahedra.

#[path = "../src/lists.rs"]
mod lists;

use lists::{Lists, lists};
use ltbw::{Builder, PointSet};
use ltbw_generate::{PointKind, generate};
use ltbw_verify as verify;
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let kind: PointKind = args.next().unwrap_or_else(|| "uniform".into()).parse()?;
    let count: usize = args.next().map_or(Ok(1_000_000), |s| s.parse())?;
    let threads: usize = args.next().map_or(Ok(2), |s| s.parse())?;
    let rounds: usize = args.next().map_or(Ok(3), |s| s.parse())?;
    let with_unaided = args.next().is_some_and(|word| word == "unaided");
    let set = PointSet::new(generate(kind, count, 1))?;
    let pool = |n: usize| rayon::ThreadPoolBuilder::new().num_threads(n).build();
    let (one, many) = (pool(1)?, pool(threads)?);
    for _ in 0..rounds {
        let clock = Instant::now();
        let mesh = one.install(|| Builder::new().build(&set))?.mesh;
        let build = clock.elapsed().as_secs_f64();

        let Lists { tets, neighbours } = lists(&mesh);
        let hull: Vec<[u32; 3]> = mesh.hull_facets().collect();
        drop(mesh);
        let bare = verify::Mesh::new(set.points(), &tets);
        let given = bare.with_neighbours(&neighbours).with_hull(&hull);
        let timed = |pool: &rayon::ThreadPool, mesh: &verify::Mesh| {
            let clock = Instant::now();
            let report = pool.install(|| verify::check(mesh, &verify::Options::default()));
            let seconds = clock.elapsed().as_secs_f64();
            if report.passed() { Ok(seconds) } else { Err("the check found a defect") }
        };
        let alone = timed(&one, &given)?;
        let check = timed(&many, &given)?;
        println!(
            "{} tets: build {build:.3} s, check on one thread {alone:.3} s ({:.2} of build), on \
             {threads} {check:.3} s ({:.2})",
            tets.len(),
            alone / build,
            check / build
        );
        if with_unaided {
            let unaided = timed(&many, &bare)?;
            println!("unaided, on {threads}: {unaided:.3} s ({:.2})", unaided / build);
        }
    }
    Ok(())
}
