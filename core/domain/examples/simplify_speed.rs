//! The time of simplifying a surface, and the figures of the result.
//!
//! `cargo run --release -p ltbw-domain --example simplify_speed -- part.stl 0.01 out.off`

use ltbw_domain::PrepareOptions;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().collect();
    let [_, path, tolerance, more @ ..] = args.as_slice() else {
        return Err("a file, a tolerance".into());
    };
    let file = ltbw_formats::read_domain(path)?;
    let options = PrepareOptions { oriented: file.oriented, ..PrepareOptions::default() };
    let clock = Instant::now();
    file.domain.prepare(&options)?;
    let before = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    let ready = file.domain.prepare(&PrepareOptions { simplify: tolerance.parse()?, ..options })?;
    println!("prepared in {before:.2} s, simplified in {:.2} s", clock.elapsed().as_secs_f64());
    println!("{}", ready.simplified.unwrap_or_default().note());
    if let [out] = more {
        ltbw_formats::write_domain(out, &ready.domain)?;
    }
    Ok(())
}
