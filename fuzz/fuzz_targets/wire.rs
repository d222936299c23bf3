//! Bytes to a letter between workers: the body is `ltbw_tests::fuzz::wire`, which `cargo test` runs
//! over the corpus, too.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ltbw_tests::fuzz::wire::wire(bytes));
