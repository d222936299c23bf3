//! Bytes to a mesh and a planted defect, which the checker must find: the body is
//! `ltbw_tests::fuzz::checker`, which `cargo test` runs over the corpus, too.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ltbw_tests::fuzz::checker::checker(bytes));
