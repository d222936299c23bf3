//! A planted bug that must be found: fails on purpose: the body is
//! `ltbw_tests::fuzz::canary`, which `cargo test` runs over the corpus, too.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ltbw_tests::fuzz::canary::canary(bytes));
