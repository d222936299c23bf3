//! Bytes to a file of any format: the body is `ltbw_tests::formats::read_any`, which `cargo test`
//! runs over the corpus, too.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ltbw_tests::formats::read_any(bytes));
