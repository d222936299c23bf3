//! Bytes to points to a mesh, checked: the body is `ltbw_tests::fuzz::triangulate`, which
//! `cargo test` runs over the corpus, too.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ltbw_tests::fuzz::triangulate::triangulate(bytes));
