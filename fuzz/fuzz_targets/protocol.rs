//! Bytes to points, workers and an order of events on the real protocol: the body is
//! `ltbw_tests::fuzz::protocol`, which `cargo test` runs over the corpus, too.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ltbw_tests::fuzz::protocol::protocol(bytes));
