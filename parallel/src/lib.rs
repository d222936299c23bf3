//! `ltbw`: a parallel 3D Delaunay mesh generation kernel. Users add this crate alone.
//!
//! It re-exports [`ltbw_core`], the exact sequential kernel. The parallel kernel
//! (Latency-Tolerant Bowyer-Watson) is built on the same cavity code.
#![forbid(unsafe_code)]

pub use ltbw_core::*;
