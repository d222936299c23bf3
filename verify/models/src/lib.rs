//! Model checks of ltbw's concurrent code, over the real code: `cargo xtask model-check`.
//!
//! Only with `--cfg loom` is there anything here. Today the sequential kernel shares one word
//! between threads, the flag of [`ltbw::CancelToken`]; the protocol's models join it when the
//! parallel kernel does. Every model asserts *witnesses* (outcomes that must have been reached)
//! and a least number of executions, and has a known-bad twin that must fail.
#![forbid(unsafe_code)]
