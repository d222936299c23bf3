//! Conversions from and to other libraries' points: `nalgebra`'s, and arrays of `ndarray`, each
//! under the feature of its name.

#[cfg(feature = "nalgebra")]
mod algebra;
#[cfg(feature = "ndarray")]
mod arrays;

#[cfg(feature = "nalgebra")]
pub use algebra::{from_nalgebra, to_nalgebra};
#[cfg(feature = "ndarray")]
pub use arrays::{from_ndarray, to_ndarray};
