//! One description of every predicate that has a filter, and what is generated from it:
//!
//! | module | writes | for |
//! |---|---|---|
//! | [`rust`] | `core/exact/src/predicates/filter/generated.rs` | the kernel |
//! | [`coq`] | `verify/proofs/Predicates.v` | the proofs |
//! | [`gappa`] | `verify/proofs/gappa/*.g` | a second opinion on the constants |
//! | [`spheres`] | `core/kernel/src/sphere/constants.rs`, `verify/proofs/Constants.v` | both |
//!
//! The files are checked in; `cargo xtask generate` writes them, a test compares them byte for
//! byte. So the source that is compiled is the term that is proved.

pub(crate) mod coq;
pub(crate) mod describe;
pub(crate) mod expression;
pub(crate) mod gappa;
pub(crate) mod model;
pub(crate) mod rust;
pub(crate) mod spheres;
