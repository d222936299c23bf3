//! Refines a domain file and prints times, counts and the outcome:
//! `refine_speed DOMAIN [VOLUME|0 [RATIO [REPEATS [queues|rounds [ORDER [START [flat]]]]]]]`;
//! with `queues` all is the start, before the first round;
//! ORDER is `hilbert`, `forwards`, `backwards` or a seed; with `flat`, the facets of surfaces are
//! flat within the usual tolerance; the environment's MIN_DIHEDRAL is in degrees.

use ltbw_domain::PrepareOptions;
use ltbw_formats::read_domain;
use ltbw_refine::{InsertOrder, Refiner, usual_tolerance};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let path = args.next().ok_or("which domain?")?;
    let volume: f64 = args.next().map_or(Ok(0.0), |s| s.parse())?;
    let ratio: f64 = args.next().map_or(Ok(2.0), |s| s.parse())?;
    let repeats: usize = args.next().map_or(Ok(1), |s| s.parse())?;
    let queues = args.next().is_some_and(|word| word == "queues");
    let order = match args.next().as_deref() {
        None | Some("hilbert") => InsertOrder::Hilbert,
        Some("forwards") => InsertOrder::Forwards,
        Some("backwards") => InsertOrder::Backwards,
        Some(seed) => InsertOrder::Random(seed.parse()?),
    };
    let start: usize = args.next().map_or(Ok(4096), |s| s.parse())?;
    let flat = args.next().is_some_and(|word| word == "flat");
    let file = read_domain(Path::new(&path))?;
    let options = PrepareOptions { oriented: file.oriented, ..PrepareOptions::default() };
    let ready = file.domain.prepare(&options)?;
    let mut refiner = Refiner::new().radius_edge(ratio);
    if let Ok(degrees) = std::env::var("MIN_DIHEDRAL") {
        refiner = refiner.min_dihedral(degrees.parse()?);
    }
    if volume > 0.0 {
        refiner = refiner.max_volume(volume);
    }
    if flat {
        refiner = refiner.flat_tolerance(usual_tolerance(&file.domain, &ready.domain));
    }
    refiner = refiner.insert_order(order).start(if queues { usize::MAX } else { start });
    for repeat in 1..=repeats {
        let refined = refiner.refine(&ready.domain, &ready.lattice)?;
        let stats = refined.stats;
        println!(
            "recover {:.3} s, refine {:.3} s, {} tets, {} vertices, {:?}, {} excuses, {} lost",
            stats.recover_seconds,
            stats.refine_seconds,
            refined.num_tets(),
            refined.mesh().num_vertices(),
            refined.outcome,
            refined.excuses.len(),
            refined.lost.len()
        );
        println!("{stats:?}\n{:?}", refined.mesh().predicate_stats());
        if repeat == repeats {
            println!("{}", refined.mesh().hash()?);
            let angles = |d: f64| refined.slivers.iter().filter(|own| own.angle < d).count();
            let below = [0.1, 1.0, 5.0].map(angles);
            println!("{} slivers, below 0.1, 1, 5 degrees: {below:?}", refined.slivers.len());
        }
    }
    Ok(())
}
