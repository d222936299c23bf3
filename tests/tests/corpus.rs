//! Replays the committed corpus of the fuzz target: what the fuzzer once reached stays reached.

use std::fs;
use std::path::Path;

#[test]
fn the_corpus_of_triangulate_passes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus/triangulate");
    let mut files: Vec<_> = fs::read_dir(&folder)
        .expect("the corpus is committed")
        .map(|entry| entry.expect("a folder can be read").path())
        .collect();
    files.sort();
    assert!(files.len() >= 5, "the corpus holds {} files", files.len());
    for file in files {
        ltbw_tests::fuzz::triangulate(&fs::read(&file).expect("a corpus file can be read"));
    }
}
