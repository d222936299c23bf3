//! The handle of a mesh, with the arrays that were asked for.

use kernel::Point;
use ltbw_bindings::Meshed;
use std::ffi::CString;
use std::sync::{Mutex, OnceLock};

/// A mesh. From its making to `ltbw_mesh_free` many threads may ask it at once.
pub struct Mesh {
    pub(crate) meshed: Meshed,
    pub(crate) arrays: Arrays,
    /// Keeps two first calls from making the same array twice.
    pub(crate) making: Mutex<()>,
}

/// The arrays that were asked for.
#[derive(Default)]
pub(crate) struct Arrays {
    pub(crate) points: OnceLock<Vec<Point>>,
    pub(crate) tets: OnceLock<Vec<[u32; 4]>>,
    pub(crate) neighbours: OnceLock<Vec<[u32; 4]>>,
    pub(crate) hull: OnceLock<Vec<[u32; 3]>>,
    pub(crate) boundary: OnceLock<(Vec<[u32; 3]>, Vec<i64>)>,
    pub(crate) regions: OnceLock<Vec<u32>>,
    pub(crate) excuses: OnceLock<(Vec<u32>, Vec<CString>)>,
    pub(crate) certificate: OnceLock<Option<CString>>,
    pub(crate) notes: OnceLock<Vec<CString>>,
}
