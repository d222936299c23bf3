//! Letters between workers: the first byte says of which kind, the others are the letter.
//!
//! A letter that can be read can be written, and read again, as it was; another one is refused by
//! the name of its sender. Neither takes more memory than a few times the letter's, as a nested or
//! an announced length would.

use ltbw::mesh::LocalMesh;
use ltbw::protocol::WorkerId;
use ltbw::refining::DomainMesh;
use ltbw::transport::Mail;
use ltbw::wire::{Wire, open};

/// The first byte of a letter about points, and of one about a domain.
pub const POINTS: u8 = 0;
/// See [`POINTS`].
pub const DOMAIN: u8 = 1;

/// The fuzz target.
pub fn wire(bytes: &[u8]) {
    let Some((kind, letter)) = bytes.split_first() else { return };
    match kind % 2 {
        POINTS => read::<Mail<LocalMesh>>(letter),
        _ => read::<Mail<DomainMesh<'static>>>(letter),
    }
}

fn read<M: Wire>(letter: &[u8]) {
    let from = WorkerId::new(7);
    let mut once = Vec::new();
    let put =
        |mail: &M, to: &mut Vec<u8>| mail.put(from, to).expect("what was read can be written");
    if let Err(error) = open(from, letter, |mail| put(&mail, &mut once)) {
        assert_eq!(error.from, from);
        assert!(error.at <= letter.len() && error.length == letter.len(), "{error}");
        assert!(!error.to_string().is_empty());
    }
    let mut twice = Vec::new();
    open(from, &once, |mail| put(&mail, &mut twice)).expect("what was written can be read");
    assert!(once == twice, "{once:?} is not {twice:?}");
}
