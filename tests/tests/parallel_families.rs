//! The families of the bars on threads: always the sequential kernel's mesh, to its hash.
//!
//! `cargo test` builds the moderate sets (some 20,000 points) once on each of some numbers of
//! threads; both full bars are
//! `LTBW_CASES=20 cargo test --release -p ltbw-tests --test workspace parallel_families:: --
//! --include-ignored --nocapture`: the moderate sets on 1 to 16 threads, 20 times, and the full
//! ones (a million points where the family says so) on 1, 2, 4 and 16 threads, 3 times.
//! `LTBW_FAMILIES=uniform,grid` asks for some families alone, so that a long run can be done in
//! pieces.

use ltbw::threads::Parallel;
use ltbw::{Builder, MeshHash, PointSet};
use ltbw_tests::cases;
use ltbw_tests::families::{Family, Size, all};

/// Builds `family` on `threads` threads.
fn on_threads(set: &PointSet, threads: u32) -> (MeshHash, u64, u64) {
    let run = Parallel::new(threads).build(set).expect("a mesh");
    let setbacks = run.workers.iter().map(|w| w.setbacks).sum();
    let messages = run.workers.iter().map(|w| w.messages).sum();
    (run.mesh.hash().expect("a hash"), setbacks, messages)
}

/// Every family on every number of threads, each time `repetitions` runs; returns their number.
fn all_equal(families: Vec<Family>, threads: &[u32], repetitions: u32) -> u64 {
    let (mut runs, mut all_messages) = (0, 0);
    let asked = std::env::var("LTBW_FAMILIES").ok();
    let is_asked = |name: &str| asked.as_ref().is_none_or(|all| all.split(',').any(|n| n == name));
    for Family { name, points } in families {
        if !is_asked(&name) {
            println!("{name}: not asked for");
            continue;
        }
        let set = PointSet::new(points).expect("finite points");
        let built = Builder::new().build(&set).expect("a mesh");
        let expected = built.mesh.hash().expect("a hash");
        drop(built);
        let (mut setbacks, mut messages) = (0, 0);
        for &threads in threads {
            for repetition in 0..repetitions {
                let (hash, back, sent) = on_threads(&set, threads);
                assert_eq!(hash, expected, "{name} on {threads} threads, run {repetition}");
                setbacks += back;
                messages += sent;
                runs += 1;
            }
        }
        println!("{name}: {} points, {setbacks} setbacks, {messages} messages", set.len());
        all_messages += messages;
    }
    assert!(all_messages > 0, "no worker ever spoke to another");
    runs
}

#[test]
fn moderate_families_on_threads_have_the_sequential_hash() {
    let repetitions = cases(1);
    let every: Vec<u32> = (1..=16).collect();
    let threads = if repetitions > 1 { &every[..] } else { &[1, 2, 3, 16] };
    let runs = all_equal(all(Size::Moderate), threads, repetitions);
    println!("{runs} runs, all with the sequential kernel's hash");
}

#[test]
#[ignore = "180 runs of up to a million points"]
fn full_families_on_threads_have_the_sequential_hash() {
    let runs = all_equal(all(Size::Full), &[1, 2, 4, 16], 3);
    println!("{runs} runs, all with the sequential kernel's hash");
}
