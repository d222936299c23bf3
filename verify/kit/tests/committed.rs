//! The committed files of the kit are the generated ones.

use ltbw_kit::{FLAGS, Generated, files, kit};
use std::collections::BTreeSet;
use std::path::Path;

/// The kit's files are those that the generator writes, to the byte: the real code gives the
/// answers that are committed, and the twins agree (the generator asserts it).
#[test]
fn committed_vectors_are_the_generated_ones() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vectors");
    let mut size = 0;
    for Generated { path, text } in files() {
        let found = std::fs::read_to_string(root.join(&path)).unwrap_or_default();
        assert!(found == text, "{path}: run `cargo xtask vectors`");
        size += text.len();
    }
    assert!(size < 1_000_000, "the kit has {size} bytes");
}

#[test]
fn every_flag_is_used_and_every_case_has_one() {
    let kit = kit();
    let cases = || kit.iter().flat_map(|file| &file.cases);
    assert!(cases().all(|case| !case.flags.is_empty()));
    let used: BTreeSet<&str> = cases().flat_map(|case| case.flags.clone()).collect();
    let known: BTreeSet<&str> = FLAGS.iter().map(|(name, _)| *name).collect();
    assert_eq!(used, known);
}
