//! Bytes to a command line, understood or refused: the body is
//! `ltbw_tests::fuzz::cli`, which `cargo test` runs over the corpus, too.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ltbw_tests::fuzz::cli::cli(bytes));
