//! Small inputs at random: a family and a size, or a domain and a bound; a number of processes, a
//! network and a delay. All are drawn; each run has the hash of `ltbw`.

use super::draw::Draw;
use super::{Bench, DOMAINS, Input, Way, words_of};
use std::collections::BTreeMap;
use std::time::Instant;

/// Families of points with the most of each: of some the mesh grows with the square.
const FAMILIES: [(&str, u64); 13] = [
    ("uniform", 20_000),
    ("grid", 20_000),
    ("bcc", 20_000),
    ("sphere", 20_000),
    ("shell", 20_000),
    ("clusters", 20_000),
    ("lines", 300),
    ("moment", 300),
    ("planes", 20_000),
    ("cospherical", 5_000),
    ("cylinder", 5_000),
    ("ulps", 20_000),
    ("duplicates", 20_000),
];

/// Files that processes read in slices, and one that they do not.
const FORMATS: [&str; 5] = ["npy", "csv", "xyz", "node", "ply"];

/// The numbers of processes, if no others are asked for.
const RANKS: [u32; 8] = [1, 2, 3, 4, 5, 7, 8, 16];

/// Inputs of which one is a domain.
const DOMAINS_ONE_IN: u64 = 5;

/// The powers of two below which sizes are drawn.
const BITS: std::ops::Range<u64> = 4..15;

/// Runs that many inputs, and tells which.
pub(super) fn run(
    bench: &Bench,
    count: u64,
    asked: Option<&[u32]>,
    seed: u64,
) -> Result<(), String> {
    println!("{count} inputs at random: --seed {seed}");
    let clock = Instant::now();
    let mut draw = Draw(seed);
    let (mut kinds, mut sizes) = (BTreeMap::<String, u32>::new(), BTreeMap::<u32, u32>::new());
    let (mut by_tcp, mut are_late) = (0, 0);
    for number in 0..count {
        let input = drawn(bench, &mut draw)?;
        let way = Way {
            count: draw.one(asked.unwrap_or(&RANKS)),
            is_tcp: draw.below(2) == 1 && bench.mpi.has_tcp(),
            late: draw.one(&[None, Some("300")]),
            ..Way::default()
        };
        let alone = bench.alone(&input, &[])?;
        bench.compare(&input, &alone, way).map_err(|why| format!("input {number}: {why}"))?;
        let kind = input.name.split(' ').next().unwrap_or_default();
        *kinds.entry(kind.to_owned()).or_default() += 1;
        *sizes.entry(way.count).or_default() += 1;
        by_tcp += u32::from(way.is_tcp);
        are_late += u32::from(way.late.is_some());
    }
    let list = |all: Vec<String>| all.join(", ");
    println!("kinds: {}", list(kinds.iter().map(|(kind, own)| format!("{kind} {own}")).collect()));
    let on = |(size, own): (&u32, &u32)| format!("{own} on {size}");
    println!("processes: {}", list(sizes.iter().map(on).collect()));
    println!(
        "by TCP {by_tcp}, with mails 300 us late {are_late}; {:.0} s",
        clock.elapsed().as_secs_f64()
    );
    println!("{count} inputs at random: one hash each");
    Ok(())
}

/// An input that is drawn.
fn drawn(bench: &Bench, draw: &mut Draw) -> Result<Input, String> {
    if draw.below(DOMAINS_ONE_IN) == 0 {
        let (kind, shape, [option, bound]) = draw.one(&DOMAINS[..DOMAINS.len() - 1]) else {
            return Err("a domain has another bound than one of its volumes".to_owned());
        };
        let bound = bound.parse::<f64>().map_err(|error| format!("{bound}: {error}"))?;
        let bound = format!("{:e}", bound * (1 + draw.below(8)) as f64);
        let made = [&[kind][..], shape, &["-o", "seed.poly"]].concat();
        bench.generate(&made)?;
        let arguments = words_of(&["mesh", "seed.poly", option, &bound]);
        return Ok(Input { name: format!("{kind} {option} {bound}"), arguments });
    }
    let (kind, most) = draw.one(&FAMILIES);
    let bits = BITS.start + draw.below(BITS.end - BITS.start);
    let size = (8 + draw.below(1 << bits)).min(most).to_string();
    let (seed, format) = (draw.below(1 << 32).to_string(), draw.one(&FORMATS));
    let file = format!("seed.{format}");
    bench.generate(&[kind, &size, "--seed", &seed, "-o", &file])?;
    let arguments = words_of(&["delaunay", &file]);
    Ok(Input { name: format!("{kind} {size} {format} (--seed {seed})"), arguments })
}
