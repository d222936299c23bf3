//! Refines a domain file and prints time, counts and outcome:
//! `refine_speed DOMAIN MAX_VOLUME [RADIUS_EDGE]`.

use ltbw_core::domain::{Domain, Facet};
use ltbw_core::refine::Refiner;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let domain = read(&args.next().unwrap())?;
    let mut refiner = Refiner::new();
    if let Some(a) = args.next() { let a: f64 = a.parse()?; if a > 0.0 { refiner = refiner.max_volume(a); } }
    if let Some(b) = args.next() { refiner = refiner.radius_edge(b.parse()?); }
    let clock = Instant::now();
    let snapped = domain.snap()?;
    println!("moved {} {:?}", snapped.moved, snapped.largest);
    let refined = refiner.refine(&snapped)?;
    println!("{:.3} s, {} tets, {} vertices, {:?}, {:?}", clock.elapsed().as_secs_f64(), refined.num_tets(), refined.mesh().num_vertices(), refined.outcome, refined.stats);
    println!("{:?}", refined.mesh().predicate_stats());
    println!("lost {} {:?} excuses {} {:?}", refined.lost.len(), refined.lost.first(), refined.excuses.len(), refined.excuses.first());
    Ok(())
}
fn read(f: &str) -> Result<Domain, Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(f)?;
    let mut lines = text.lines().map(|l| l.split('#').next().unwrap_or("").split_whitespace().map(|w| w.parse::<f64>().unwrap()).collect::<Vec<_>>()).filter(|l| !l.is_empty());
    let mut d = Domain::default();
    let n = lines.next().unwrap()[0] as usize;
    for _ in 0..n { let l = lines.next().unwrap(); d.vertices.push([l[1], l[2], l[3]]); }
    let h = lines.next().unwrap(); 
    for _ in 0..h[0] as usize {
        let l = lines.next().unwrap();
        let mut facet = Facet::default();
        for _ in 0..l[0] as usize { let p = lines.next().unwrap(); facet.polygons.push(p[1..=p[0] as usize].iter().map(|&x| x as u32).collect()); }
        for _ in 0..l.get(1).copied().unwrap_or(0.0) as usize { let p = lines.next().unwrap(); facet.holes.push([p[1], p[2], p[3]]); }
        d.facets.push(facet);
    }
    let h = lines.next().unwrap()[0] as usize;
    for _ in 0..h { let l = lines.next().unwrap(); d.holes.push([l[1], l[2], l[3]]); }
    Ok(d)
}
