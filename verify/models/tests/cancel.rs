//! The cancel token: a cancellation is seen by every clone, once seen it stays, and it is seen at
//! the latest after the cancelling thread was joined. Bounds: one canceller, one worker with two
//! looks; exhaustive.
#![cfg(loom)]

use ltbw::CancelToken;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

/// Runs the model with tokens made by `share` for the second thread; returns the pairs of looks
/// that the worker took, and the number of executions.
fn outcomes(share: fn(&CancelToken) -> CancelToken) -> (BTreeSet<(bool, bool)>, u32) {
    let seen = Arc::new(Mutex::new((BTreeSet::new(), 0)));
    let record = seen.clone();
    loom::model(move || {
        let token = CancelToken::new();
        let theirs = share(&token);
        let canceller = loom::thread::spawn(move || theirs.cancel());
        let looks = (token.is_cancelled(), token.is_cancelled());
        canceller.join().expect("the canceller does not panic");
        assert!(token.is_cancelled(), "a joined cancellation was not seen");
        let mut record = record.lock().expect("no panic while locked");
        record.0.insert(looks);
        record.1 += 1;
    });
    let seen = seen.lock().expect("no panic while locked");
    (seen.0.clone(), seen.1)
}

#[test]
fn a_cancellation_is_seen_and_stays_seen() {
    let (looks, executions) = outcomes(CancelToken::clone);
    println!("cancel token: {executions} executions, looks {looks:?}");
    // All three witnesses, and not (true, false): a flag that is taken back.
    assert_eq!(looks, BTreeSet::from([(false, false), (false, true), (true, true)]));
    assert!(executions >= 3, "{executions}");
}

/// Known bad: a clone with a flag of its own.
#[test]
#[should_panic(expected = "a joined cancellation was not seen")]
fn a_token_that_is_not_shared_is_caught() {
    outcomes(|_| CancelToken::new());
}
