//! Bytes to five points, all predicates compared with GMP: the body is
//! `ltbw_tests::fuzz::predicates`, which `cargo test` runs over the corpus, too.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ltbw_tests::fuzz::predicates::predicates(bytes));
