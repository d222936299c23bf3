//! Bytes to a file of any format: the body is `ltbw_tests::fuzz::formats`, which `cargo test`
//! runs over the corpus, too.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ltbw_tests::fuzz::formats::formats(bytes));
