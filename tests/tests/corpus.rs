//! Replays the committed corpora of the fuzz targets: what the fuzzer once reached stays reached.

use ltbw_tests::corpora;
use ltbw_tests::fuzz::{TARGETS, canary};
use std::fs;
use std::path::{Path, PathBuf};

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz").join(name)
}

#[test]
fn the_corpora_pass() {
    for (name, run) in TARGETS {
        let files = corpora::read(&corpora::archive(name)).expect("the corpus is committed");
        assert!(files.len() >= 11, "the corpus of {name} holds {} files", files.len());
        for (file, bytes) in files {
            let passed = std::panic::catch_unwind(|| run(&bytes));
            assert!(passed.is_ok(), "{name}/{file} fails (see above)");
        }
    }
}

/// The targets here are those that the fuzzer runs.
#[test]
fn every_fuzz_target_is_replayed() {
    let sources = fs::read_dir(folder("fuzz_targets")).expect("the targets are committed");
    let mut found: Vec<String> = sources
        .map(|entry| entry.expect("a folder can be read").path())
        .map(|path| path.file_stem().expect("a file has a name").to_string_lossy().into_owned())
        .collect();
    let mut known: Vec<String> = TARGETS.iter().map(|(name, _)| (*name).to_string()).collect();
    known.push("canary".to_string());
    found.sort();
    known.sort();
    assert_eq!(found, known);
}

/// An input that the fuzzer found: the canary fails on it as `cargo xtask fuzz` expects. It is not
/// in the canary's corpus, which is empty: the fuzzer has to find it anew.
#[test]
fn the_canary_fails_on_a_known_input() {
    let known = folder("canary-finding");
    let bytes = fs::read(&known).expect("the finding is committed");
    let caught = std::panic::catch_unwind(|| canary::canary(&bytes)).expect_err("a planted bug");
    let said = caught.downcast_ref::<String>().map(String::as_str);
    let said = said.or_else(|| caught.downcast_ref::<&str>().copied());
    assert_eq!(said, Some(canary::FOUND));
    canary::canary(&[]);
}
