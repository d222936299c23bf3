//! Bytes to a small domain, checked and prepared: the body is
//! `ltbw_tests::fuzz::domains`, which `cargo test` runs over the corpus, too.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ltbw_tests::fuzz::domains::domains(bytes));
