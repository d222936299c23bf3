//! Time of the thread runtime against the sequential kernel, runs interleaved.
//!
//! `cargo run --release -p ltbw --example parallel_speed -- KIND N THREADS[,..] RUNS [WINDOW]`
//! prints one JSON line: medians of seconds, and ratios to the sequential kernel of the same run.
//! `-p` in front of KIND skips the sequential kernel: for profilers.

use ltbw::threads::{Parallel, Run};
use ltbw::{Builder, PointSet};
use ltbw_generate::{PointKind, generate};
use std::time::Instant;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn print(threads: u32, runs: &[(f64, Run)]) {
    let part = |f: fn(&Run) -> f64| median(runs.iter().map(|(_, run)| f(run)).collect());
    let Some((_, last)) = runs.last() else { return };
    let sum = |f: fn(&ltbw::threads::WorkerStats) -> u64| last.workers.iter().map(f).sum::<u64>();
    println!(
        "{{\"threads\":{threads},\"seconds\":{:.3},\"start\":{:.3},\"insert\":{:.3},\
         \"gather\":{:.3},\"local\":{},\"operations\":{},\"interface\":{},\"setbacks\":{},\
         \"messages\":{}}}",
        median(runs.iter().map(|(s, _)| *s).collect()),
        part(|run| run.start_seconds),
        part(|run| run.insert_seconds),
        part(|run| run.gather_seconds),
        sum(|w| w.local),
        sum(|w| w.operations),
        sum(|w| w.interface),
        sum(|w| w.setbacks),
        sum(|w| w.messages),
    );
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let alone = words.first().is_some_and(|word| word == "-p");
    if alone {
        words.remove(0);
    }
    let [kind, count, threads, runs, window @ ..] = words.as_slice() else {
        return Err("usage: parallel_speed [-p] KIND N THREADS[,THREADS...] RUNS [WINDOW]".into());
    };
    let window: Option<usize> = window.first().map(|word| word.parse()).transpose()?;
    let kind: PointKind = kind.parse()?;
    let set = PointSet::new(generate(kind, count.parse()?, 1))?;
    let threads: Vec<u32> = threads.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let runs: usize = runs.parse()?;
    let mut sequential = Vec::new();
    let mut parallel: Vec<Vec<(f64, Run)>> = threads.iter().map(|_| Vec::new()).collect();
    let mut ratios: Vec<Vec<f64>> = vec![Vec::new(); threads.len()];
    for _ in 0..runs {
        let mut base = f64::NAN;
        if !alone {
            let clock = Instant::now();
            let built = Builder::new().build(&set)?;
            base = clock.elapsed().as_secs_f64();
            drop(built);
            sequential.push(base);
        }
        for (k, &threads) in threads.iter().enumerate() {
            let clock = Instant::now();
            let parallel_run = Parallel::new(threads);
            let parallel_run = match window {
                Some(window) => parallel_run.window(window),
                None => parallel_run,
            };
            let mut run = parallel_run.build(&set)?;
            let seconds = clock.elapsed().as_secs_f64();
            ratios[k].push(base / seconds);
            // Only the figures are kept.
            run.mesh = Builder::new().build(&PointSet::new(generate(kind, 30, 1))?)?.mesh;
            parallel[k].push((seconds, run));
        }
    }
    if !alone {
        println!("{{\"sequential\":{:.3}}}", median(sequential));
    }
    for ((threads, runs), ratios) in threads.into_iter().zip(&parallel).zip(ratios) {
        print(threads, runs);
        if !alone {
            println!("{{\"threads\":{threads},\"speedup\":{:.3}}}", median(ratios));
        }
    }
    Ok(())
}
