//! Replays the committed corpora of the fuzz targets: what the fuzzer once reached stays reached.

use std::fs;
use std::path::Path;

fn replay(target: &str, least: usize, run: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(target);
    let mut files: Vec<_> = fs::read_dir(&folder)
        .expect("the corpus is committed")
        .map(|entry| entry.expect("a folder can be read").path())
        .collect();
    files.sort();
    assert!(files.len() >= least, "the corpus holds {} files", files.len());
    for file in files {
        run(&fs::read(&file).expect("a corpus file can be read"));
    }
}

#[test]
fn the_corpus_of_triangulate_passes() {
    replay("triangulate", 5, ltbw_tests::fuzz::triangulate);
}

#[test]
fn the_corpus_of_formats_passes() {
    replay("formats", 25, ltbw_tests::formats::read_any);
}
