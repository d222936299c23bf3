//! The bodies of the fuzz targets, here so that `cargo test` replays their corpora.
//!
//! Each takes raw bytes and panics when it has found something; that is what the fuzzer looks for.
//!
//! | target | what must hold |
//! |---|---|
//! | [`predicates`] | every predicate equals `rug` on five points of any finite coordinates |
//! | [`triangulate`] | one mesh for all orders, refusals and queries; equal to CGAL's; certified |
//! | [`formats`] | a reader reads or says why not, and what it read can be written and read back |
//! | [`checker`] | the checker passes a sound mesh and finds every planted defect |
//! | [`domains`] | the check of a domain ends in any order; what is prepared and meshed is judged |
//! | [`protocol`] | the parallel kernel ends at rest with the one mesh, in any order of events |
//! | [`wire`] | a letter is read or refused by name; what was read is written as it came |
//! | [`cli`] | the command line is understood, or refused in one line with exit code 2 |
//! | [`canary`] | **fails on purpose**: its predicate has a planted bug, which must be found |

pub mod canary;
pub mod checker;
pub mod cli;
pub mod domains;
pub mod formats;
pub mod predicates;
pub mod protocol;
pub mod triangulate;
pub mod wire;

use crate::cgal::{Cgal, Failure};
use std::sync::{Mutex, OnceLock};

/// The one CGAL server of this process; none where CGAL is missing.
fn reference() -> Option<&'static Mutex<Cgal>> {
    static SERVER: OnceLock<Option<Mutex<Cgal>>> = OnceLock::new();
    let start = || match Cgal::start() {
        Ok(cgal) => Some(Mutex::new(cgal)),
        Err(Failure::Missing(_)) => None,
        Err(failure) => panic!("{failure}"),
    };
    SERVER.get_or_init(start).as_ref()
}

/// A fuzz target by name.
pub type Target = fn(&[u8]);

/// Every target but the canary, which fails on purpose.
pub const TARGETS: [(&str, Target); 8] = [
    ("predicates", predicates::predicates),
    ("triangulate", triangulate::triangulate),
    ("formats", formats::formats),
    ("checker", checker::checker),
    ("cli", cli::cli),
    ("domains", domains::domains),
    ("protocol", protocol::protocol),
    ("wire", wire::wire),
];
